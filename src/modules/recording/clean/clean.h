/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of cleaning share. */
#pragma once

#include "modules/recording/table/load.h"

struct cancel;

/* Offset, line, cos, sin, and both with an amplitude that changes linearly. */
enum { LOCAL_TERMS = 6 };

/* The motion about one moment, where an oscillation of known period goes on. */
struct local {
    double t;                      /* [s] middle of what it judges: a period */
    size_t begin, end;             /* rows it judges */
    double amplitude;              /* local amplitude at t */
    double scale;                  /* robust standard deviation of the residuals */
    bool fitted;                   /* false if there are too few good samples */
    double parameter[LOCAL_TERMS]; /* parameters of the local fit about t, with times in periods */
};

struct cleaning {
    struct recording *recording;
    struct findings *findings;
    struct arena *scratch;
    size_t n;
    const double *t, *y;
    double period;
    const struct cancel *cancel;
    double step;             /* [s] median */
    double quantum;          /* SI; values are multiples of it, or 0 if no step is seen */
    double swing;            /* range of all but the extreme values */
    double typical;          /* median of the local scales */
    unsigned char *excluded; /* [n] takes no part in the local fits: clipped, stuck, missing */
    unsigned char *fitted_without; /* [n] `excluded` of the latest fits; NULL before the first */
    double *residual;              /* [n] y - local fit; 0 where there is none */
    double *model;                 /* [n] local fit, NAN where there is none */
    double *sorted;                /* [sorted_count] values that are present, ascending */
    size_t sorted_count;
    double (*turn)[2]; /* [n] cosine and sine of the oscillation's phase, from the first fit on */
    struct local *local;
    double *per_local; /* [locals] work */
    size_t locals;
};

/*
 * Fits offset, line, cos, sin and both with an amplitude that changes linearly, over two periods
 * about each whole period, robustly; fills local, residual, model and typical. Returns false if out
 * of memory or if cancelled.
 */
bool clean_fit(struct cleaning *cleaning);

/* Takes values that a sensor sends when it sees nothing for missing, and warns. Returns false if
 * out of memory. */
bool recording_leave_out_sentinels(struct recording *recording);

/* Notes a stretch of samples that begins at t. */
static inline void clean_note(struct finding *finding, double t, size_t samples)
{
    if (finding->stretches < FINDING_STRETCHES)
        finding->first[finding->stretches] = t;
    finding->stretches++;
    finding->count += samples;
}

/* Flat tops on one side, three samples at least in each of at least three cycles, none of which
 * holds half of them (that were a rest): noted, and excluded from the local fits. */
void clean_clipped(struct cleaning *cleaning, bool upper);
