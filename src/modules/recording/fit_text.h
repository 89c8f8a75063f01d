/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Texts about fits of all kinds. */
#pragma once

#include "modules/recording/fits.h"
#include "modules/recording/known/known.h"

#include <hooke/command/handler.h>

#define FIT_WARNINGS 8

struct fit_summary {
    const struct subject *subject;
    const char *model; /* damped, scene, the formula */
    /* One of these: a row of fit_catalog, or a curve with named parameters (of the scene, of a
     * formula). */
    const struct fit *motion;
    const struct curve_fit *curve;
    const struct modes_fit
        *modes; /* several modes, of which `motion` is then the summary, else NULL */
    const char *const *name;
    const enum quantity
        *quantity;     /* [curve->parameters] QUANTITY_OTHER: the unit follows from the formula */
    const char *fixed; /* parameters that were not fitted, as "m = 0.2 kg, k = 15 N/m", or NULL */
    struct measured k; /* NAN if unknown */
    bool spring;       /* k could be known */
    struct inputs inputs; /* inputs besides the recording */
    char warning[FIT_WARNINGS][200];
    int warnings;
};

/* The mass on the spring, if somebody has said what it is. */
bool known_mass(const struct scene *scene, struct measured *mass);
/* Writes "name = value". If `measured` is true, an uncertainty is shown however small it is. */
void put_value(struct buffer *text, const char *name, struct measured value, enum quantity quantity,
               bool measured);
/* "name = 40.0 +- 0.5 s" for top/rate, "name > 80 s" where the rate may be 0; nothing where it is
 * negative beyond doubt. */
void put_reciprocal(struct buffer *text, const char *name, double top, struct measured rate,
                    enum quantity quantity, bool measured);
/* Writes how well the rate is known by which a recording without a clock got its times. */
void put_pace(const struct series *series, struct buffer *text);
void fit_add_warning(struct fit_summary *summary, const char *format, ...) PRINTF_LIKE(2, 3);
void fit_add_window(struct fit_summary *summary, enum window_law law, struct arena *arena);
/* Adds what the residuals of a curve say against it. */
void fit_add_residuals(struct fit_summary *summary);
/* Lines, record and warnings. */
void reply_fit(const struct fit_summary *summary, struct arena *arena, struct reply *reply);

/* Unit of the k-th rate of a law of drag, which follows from that of what was fitted. */
const char *fit_rate_unit(const struct fit_summary *summary, int k);
/* Two parameters of which one follows nearly from the other. */
bool fit_correlated(const struct curve_fit *curve, int i, int j);
void reply_fit_record(const struct fit_summary *summary, struct reply *reply); /* fitted.c */

/* ---- fit_modes.c ---- */

void put_modes(const struct fit_summary *summary, struct buffer *text);
/* Adds the modes to the open record. */
void reply_modes(const struct fit_summary *summary, struct reply *reply);

/* ---- fits of the scene and of formulas (fit_curve.c) ----
 *
 * These report the fit that `call` asks for, keep the result in the session if it converged, and
 * set the error otherwise.
 */
struct fit_request {
    struct session *session;
    const struct arguments *args;
    const struct subject *subject;
    struct reply *reply;
};

bool fit_the_scene(const struct fit_request *call, struct error *error);
bool fit_a_formula(const struct fit_request *call, struct text formula, struct error *error);
/* `mass` is that of one oscillator, or NULL if unknown. */
bool fit_the_modes(const struct fit_request *call, const struct measured *mass,
                   struct error *error);
/* Keeps y - residual at the samples as the curve of the last fit, with what `fit` says of it. */
bool session_add_curve(const struct fit_request *call, const double *residual,
                       const struct fit *fit, struct error *error);

/* ---- adopt.c ---- */

bool adopt_fit(struct session *session, const struct arguments *args, struct reply *reply,
               struct error *error);
