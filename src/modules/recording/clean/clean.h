/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of cleaning share: local fits (fit.c), flat tops (clipped.c), sentinels
 * (sentinel.c). */
#pragma once

#include "modules/recording/table/load.h"

struct cancel;

/* Terms of a local fit: offset, line, cos, sin, and cos and sin with a linearly changing
 * amplitude. */
enum { LOCAL_TERMS = 6 };

/* The motion in one period of an oscillation of known period, by a local fit. */
struct local {
    double t;                      /* [s] middle of the period that is judged */
    size_t begin, end;             /* rows begin to end - 1, which are judged */
    double amplitude;              /* local amplitude at t */
    double scale;                  /* robust standard deviation of the residuals */
    bool fitted;                   /* false if there are too few good samples */
    double parameter[LOCAL_TERMS]; /* parameters of the fit, with times from t in periods */
};

/* State of the search for faults in a recording. */
struct cleaning {
    struct recording *recording;
    struct findings *findings;
    struct arena *scratch;
    /* Number of rows, their times [s] and values. */
    size_t n;
    const double *t, *y;
    double period;
    const struct cancel *cancel;
    double step;                   /* [s] median time step */
    double quantum;                /* SI; values are multiples of it; 0 if no such step is seen */
    double swing;                  /* range of all but the extreme values */
    double typical;                /* median of the local scales */
    unsigned char *excluded;       /* [n] rows left out of local fits: clipped, stuck, missing */
    unsigned char *fitted_without; /* [n] `excluded` of the latest fits; NULL before the first */
    double *residual;              /* [n] y minus local fit; 0 without a fit */
    double *model;                 /* [n] local fit; NAN without one */
    double *sorted;                /* [sorted_count] existing values, ascending */
    size_t sorted_count;
    double (*turn)[2];   /* [n] cosine and sine of the phase, set by the first fit */
    struct local *local; /* [locals] one for each whole period */
    double *per_local;   /* [locals] work space */
    size_t locals;
};

/* Fits each whole period robustly with the local terms, over two periods around it; fills local,
 * residual, model and typical. Returns false if out of memory or cancelled. */
bool clean_fit(struct cleaning *cleaning);

/* Removes values that a sensor sends when it sees nothing, and warns. Returns false if out of
 * memory. */
bool recording_leave_out_sentinels(struct recording *recording);

/* Counts a stretch of samples that begins at t [s] in a finding. */
static inline void clean_note(struct finding *finding, double t, size_t samples)
{
    if (finding->stretches < FINDING_STRETCHES)
        finding->first[finding->stretches] = t;
    finding->stretches++;
    finding->count += samples;
}

/* Finds flat tops on one side: at least three samples in each of at least three cycles, none of
 * which has half of them (that would be a rest). They are noted, and excluded from the local
 * fits. */
void clean_clipped(struct cleaning *cleaning, bool upper);
