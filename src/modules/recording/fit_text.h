/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Replies about fits of all kinds: a command fills a struct fit_summary, adds warnings, and calls
 * reply_fit(). Also the functions behind the kinds of `fit`, and `adopt`. */
#pragma once

#include "modules/recording/fits.h"
#include "modules/recording/known/known.h"

#include <hooke/command/handler.h>

/* Largest number of warnings of a fit. */
#define FIT_WARNINGS 8

/* A fit as it is reported. */
struct fit_summary {
    const struct subject *subject;
    const char *model; /* damped, scene, or the formula */
    /* One of these: a result of a row of fit_catalog, or of a curve with named parameters (of the
     * scene, of a formula). */
    const struct fit *motion;
    const struct curve_fit *curve;
    /* Several modes, of which `motion` is then the summary, else NULL. */
    const struct modes_fit *modes;
    const char *const *name; /* [curve->parameters] names */
    /* [curve->parameters] quantities; QUANTITY_OTHER if the formula determines the unit. */
    const enum quantity *quantity;
    const char *fixed;    /* values that were not fitted, as "m = 0.2 kg, k = 15 N/m", or NULL */
    struct measured k;    /* NAN if unknown */
    bool spring;          /* k would be known if the mass were */
    struct inputs inputs; /* values that entered besides the recording */
    char warning[FIT_WARNINGS][200];
    int warnings;
};

/* Sets *mass to the mass on the spring. Returns false unless the user has set it. */
bool known_mass(const struct scene *scene, struct measured *mass);
/* Appends "name = value". If `measured` is true, an uncertainty is shown however small it is. */
void put_value(struct buffer *text, const char *name, struct measured value, enum quantity quantity,
               bool measured);
/* Appends "name = 40.0 +- 0.5 s" for top/rate, "name > 80 s" if the rate may be 0, and nothing if
 * the rate is clearly negative. */
void put_reciprocal(struct buffer *text, const char *name, double top, struct measured rate,
                    enum quantity quantity, bool measured);
/* Appends the uncertainty of the sampling rate if the recording got its times from one. */
void put_pace(const struct series *series, struct buffer *text);
/* Adds a warning, formatted as by printf(); ignored if there is no space left. */
void fit_add_warning(struct fit_summary *summary, const char *format, ...) PRINTF_LIKE(2, 3);
/* Adds the advice for the window, if there is one, as a warning. */
void fit_add_window(struct fit_summary *summary, enum window_law law, struct arena *arena);
/* Adds warnings about correlated residuals and parameters, and about bounds. */
void fit_add_residuals(struct fit_summary *summary);
/* Adds the fit to the reply as text, record and warnings. */
void reply_fit(const struct fit_summary *summary, struct arena *arena, struct reply *reply);

/* Returns the unit of rate k of a law of drag, which depends on the fitted quantity. */
const char *fit_rate_unit(const struct fit_summary *summary, int k);
/* Returns true if parameters i and j are determined and strongly correlated. */
bool fit_correlated(const struct curve_fit *curve, int i, int j);
/* Adds the record of the fit to the reply (fitted.c). */
void reply_fit_record(const struct fit_summary *summary, struct reply *reply);

/* ---- fit_modes.c ---- */

/* Appends the modes as text. */
void put_modes(const struct fit_summary *summary, struct buffer *text);
/* Adds the modes to the open record. */
void reply_modes(const struct fit_summary *summary, struct reply *reply);

/* ---- fits of the scene and of formulas (fit_curve.c) ----
 *
 * These functions report the requested fit and keep the result in the session if it converged.
 * They return false with the error otherwise.
 */

/* A call of the command `fit`. */
struct fit_request {
    struct session *session;
    const struct arguments *args;
    const struct subject *subject;
    struct reply *reply;
};

bool fit_the_scene(const struct fit_request *call, struct error *error);
bool fit_a_formula(const struct fit_request *call, struct text formula, struct error *error);
/* mass is that of one oscillator, or NULL if unknown. */
bool fit_the_modes(const struct fit_request *call, const struct measured *mass,
                   struct error *error);
/* Keeps y - residual at the samples as the curve of the last fit, with the summary values in `fit`.
 * Returns false with the error if out of memory. */
bool session_add_curve(const struct fit_request *call, const double *residual,
                       const struct fit *fit, struct error *error);

/* ---- adopt.c ---- */

/* Handles `adopt`: takes the values of the last fit into the scene. Returns false with the
 * error. */
bool adopt_fit(struct session *session, const struct arguments *args, struct reply *reply,
               struct error *error);
