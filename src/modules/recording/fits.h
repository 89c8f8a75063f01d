/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module's part of a session: the last fit, what was adopted, and its band. */
#pragma once

#include "modules/recording/fit/fit.h"
#include <hooke/module.h>
#include "modules/recording/scene/scene_fit.h"

/* A fit that converged, for the report. */
struct stored_fit {
    struct fit fit;
    enum quantity quantity; /* quantity that was fitted */
    struct measured k;      /* NAN if the mass was not set */
    struct exact_names exact;
    /* number in the log of the statement that made it, from 1, set by session_store_fit() */
    size_t statement;
    char subject[LIMIT_NAME + 16];
};

/* The scene that `adopt` made last, and covariances of what is uncertain in it. */
struct adopted_fit {
    struct scene scene; /* model NULL: nothing was adopted */
    struct scene_covariance known;
    struct exact_names exact;
    char subject[LIMIT_NAME + 16]; /* series that was fitted, such as "data swing3" */
    size_t statement;              /* number in the log of the statement that adopted it, from 1 */
};

/* The band of an adopted fit about a run, for the panes. */
struct fit_band {
    int run; /* number of the run, or 0 if no band was computed */
    size_t rows;
    double end; /* [s] rows and end of the run when it was */
    struct adopted_fit adopted;
    size_t n; /* 0 if it has none */
    int variables;
    double t_begin, step; /* [s] */
    double *half;         /* [variables][n] half the width */
};

struct fits {
    bool has_fit;
    struct fit fit;
    char fit_of[LIMIT_NAME + 16]; /* "data swing3", "run 2" */
    double fit_zero; /* zero of the recording at that time, from which its offset counts */
    /* The next six members belong to a fit of the scene or of a formula. */
    double *fit_curve[2]; /* [fit_samples] times and values, or NULL to use fit_values() */
    size_t fit_samples;
    /* checksum under which the session's file has the curve, or 0 if it has not */
    uint64_t fit_curve_sum;
    struct scene fit_scene; /* scene as fitted; model is NULL unless the fit was one of the scene */
    bool fit_free[PARAM_MAX]; /* parameters that were fitted there */
    struct adopted_fit adopted;
    struct fit_band band;
    int fit_modes; /* number of damped sines, or 0 if it was no fit of modes */
    struct stored_fit *stored_fit;
    int stored_fits;
    bool live; /* true to fit the recording that is growing, or the next, every second */
};

extern const struct module recording_module;

/* Returns the fits of a session; none where nothing was fitted. */
const struct fits *fits_of(const struct session *session);
/* Returns them where something was fitted, else NULL. */
struct fits *fits_made(const struct session *session);
/* Returns them, made where there are none. Returns NULL with `error` filled if out of memory. */
struct fits *fits_make(const struct session *session, struct error *error);

/* Frees what they point to. */
void fits_free(void *fits);
bool fits_use(const void *fits, const struct model *model);
void fits_drop_band(struct fits *fits);
/* A fit of something else replaces its curve. */
void fits_drop_curve(struct fits *fits);
/* Values of the last fit at n ascending times [s]; NAN outside of what it was fitted to. */
void session_fit_values(const struct session *session, const double *t, size_t n, double *value);
/* Keeps the latest fit of each model, recording or run, and window. Without memory it is only not
 * in the report. */
void session_store_fit(struct session *session, const struct stored_fit *fit);

/* ---- in the session's file (fits_store.c) ---- */

void fits_put(const void *fits, struct buffer *output);
bool fits_content(void *fits, struct text piece[2], uint64_t **sum);
void fits_read(struct reader *reader);
