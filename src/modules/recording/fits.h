/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module's part of a session: the last fit, fits for the report, the adopted scene, and its
 * band. */
#pragma once

#include "modules/recording/fit/fit.h"
#include <hooke/module.h>
#include "modules/recording/scene/scene_fit.h"

/* A fit that converged, kept for the report. */
struct stored_fit {
    struct fit fit;
    enum quantity quantity;   /* quantity that was fitted */
    struct measured k;        /* NAN if the mass was not set */
    struct exact_names exact; /* inputs that counted as exact */
    /* Number in the log, from 1, of the statement that made it; set by session_store_fit(). */
    size_t statement;
    char subject[LIMIT_NAME + 16]; /* series that was fitted */
};

/* The scene that `adopt` made last, and covariances of its uncertain parameters. */
struct adopted_fit {
    struct scene scene;            /* its model is NULL if nothing was adopted */
    struct scene_covariance known; /* covariances of the adopted values */
    struct exact_names exact;      /* inputs that counted as exact */
    char subject[LIMIT_NAME + 16]; /* series that was fitted, such as "data swing3" */
    size_t statement;              /* number in the log of the statement that adopted it, from 1 */
};

/* The band of an adopted fit around a run, as panes draw it. */
struct fit_band {
    int run; /* number of the run, or 0 if no band was computed */
    /* Rows and end [s] of the run, and the adopted fit, for which the band was computed. */
    size_t rows;
    double end;
    struct adopted_fit adopted;
    size_t n; /* number of times; 0 if the run has no band */
    int variables;
    double t_begin, step; /* [s] first time and distance of the times */
    double *half;         /* [variables][n] half the width; owned */
};

/* The module's part of a session. */
struct fits {
    bool has_fit;
    struct fit fit;               /* the last fit */
    char fit_of[LIMIT_NAME + 16]; /* "data swing3", "run 2" */
    double fit_zero; /* zero of the recording at the time of the fit, to which its offset refers */
    /* The next six members belong to a fit of the scene or of a formula. */
    double *fit_curve[2]; /* [fit_samples] times and values, or NULL to use fit_values() */
    size_t fit_samples;
    /* Checksum under which the session's file has the curve, or 0. */
    uint64_t fit_curve_sum;
    struct scene fit_scene;   /* the fitted scene; its model is NULL for other fits */
    bool fit_free[PARAM_MAX]; /* true for parameters that were free in it */
    struct adopted_fit adopted;
    struct fit_band band;
    int fit_modes;                 /* number of damped sines, or 0 if it was not a fit of modes */
    struct stored_fit *stored_fit; /* [stored_fits] owned */
    int stored_fits;
    bool live; /* the growing recording, or the next one, is fitted every second */
};

extern const struct module recording_module;

/* Returns the session's fits, or a constant without any fit. */
const struct fits *fits_of(const struct session *session);
/* Returns the session's fits if something was fitted, else NULL. */
struct fits *fits_made(const struct session *session);
/* Returns the session's fits, creating them if needed, or NULL with the error if out of memory. */
struct fits *fits_make(const struct session *session, struct error *error);

/* Frees what the fits point to, but not the structure. */
void fits_free(void *fits);
/* Returns true if a fit refers to this model. */
bool fits_use(const void *fits, const struct model *model);
/* Frees the band. */
void fits_drop_band(struct fits *fits);
/* Frees the curve and forgets the scene or modes of the last fit, which a new fit replaces. */
void fits_drop_curve(struct fits *fits);
/* Computes the values of the last fit at n ascending times [s]; a curve of samples is NAN outside
 * of them. */
void session_fit_values(const struct session *session, const double *t, size_t n, double *value);
/* Stores a fit for the report, replacing an earlier one of the same model, subject and window. If
 * out of memory, the fit is only missing in the report. */
void session_store_fit(struct session *session, const struct stored_fit *fit);

/* ---- in the session's file (fits_store.c) ---- */

/* Appends the fits to the state of the session's file. */
void fits_put(const void *fits, struct buffer *output);
/* Sets piece to the times and values of the curve, and *sum to its checksum. Returns false without
 * a curve. */
bool fits_content(void *fits, struct text piece[2], uint64_t **sum);
/* Reads the fits from a session's file; damaged parts are left out with a note. */
void fits_read(struct reader *reader);
