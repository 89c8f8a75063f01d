/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module's knowledge about runs and recordings of a session: periods, velocities and energies,
 * comparisons, exports, inputs of derived numbers, faults. */
#pragma once

#include "modules/recording/series/analysis.h"
#include "modules/recording/table/load.h"
#include <hooke/plot.h>
#include <hooke/report.h>
#include <hooke/session/series_tools.h>

/* Does the same as series_period() for the first variable of a run over some of its rows. If that
 * finds no period, an uncertain one, or few waves, the period comes from returns of the whole state
 * (closed_period.c). run is NULL if the series shows something else. */
bool run_series_period(const struct run *run, const struct series *series, struct arena *arena,
                       struct period *period, struct error *error);
/* Measures the period of a run; it is the member run_period of series_tools. Returns false if there
 * is none. */
bool find_run_period(const struct run *run, struct arena *arena, struct measured *period);

/* ---- velocity and energy of a recording of positions (data_motion.c) ---- */

/* Computes velocities and, if `energy`, energies of a recording of positions, with memory of the
 * arena; series is its series, or NULL for its window. This function, motion_frequency() and
 * recording_is_fitted() are members of series_tools. Returns false with the error. */
bool data_motion(const struct session *session, const struct recording *recording,
                 const struct series *series, bool energy, struct arena *arena,
                 struct data_motion *motion, struct error *error);
/* Returns the angular frequency [rad/s] of the oscillation: that of the fit, else of the period
 * measured while the recording grows, else of the highest peak of the spectrum, or NAN if it has
 * none. */
double motion_frequency(const struct session *session, const struct recording *recording,
                        const struct series *series, struct arena *arena);
/* Returns true if the latest fit of the session is one of this recording. */
bool recording_is_fitted(const struct session *session, const struct recording *recording);

/* ---- a recording beside a run (distance.c), as tables (export_recording.c) ---- */

/* Compares a recording with a run: sets scale, offset and rms in *distance, which stays unchanged
 * if they cannot be compared. */
void find_distance(const struct run *run, struct recording *recording,
                   struct data_distance *distance);
/* Writes a recording as a table with these columns and rows. Returns false with the error. */
bool export_recorded(const struct session *session, const struct argument_value *column,
                     const struct argument_value *every, struct export *export,
                     struct error *error);
/* Writes t and y of every sample for a hand-in, and a column used (0, 1) if some are outside of the
 * window or masked. */
bool export_recording(const struct session *session, struct export *export, struct error *error);
/* Adds the band of the adopted fit to the table of its run. Returns false with the error. */
bool export_band(const struct session *session, const struct argument_value *runs,
                 struct text where, struct export *export, struct error *error);

/* ---- what a derived number was computed with (inputs.c) ----
 *
A derived number depends on given values. Those without a stated uncertainty count as exact and
 * are listed; the others widen its uncertainty. To use them, begin with a zeroed struct inputs,
call the
 * inputs_use functions, then inputs_widen() and inputs_put(). */

/* Largest number of listed names. */
#define INPUTS_MAX 16

/* Values that entered a derived number. */
struct inputs {
    const char *exact[INPUTS_MAX]; /* names of exact values, each once */
    int exacts;
    double relative; /* relative uncertainty of the product or quotient of all others (GUM 5.1.6) */
};

/* Adds a value. The name must live as long as the inputs. A value of 0 is ignored. */
void inputs_use(struct inputs *inputs, const char *name, struct measured value);
/* Adds the named parameters ("m rho area") that the scene has. */
void inputs_use_params(struct inputs *inputs, const struct scene *scene, const char *names);
/* Adds every parameter on which the motion depends, except those that are free. */
void inputs_use_motion(struct inputs *inputs, const struct scene *scene, const bool *is_free);
/* Returns the value with the inputs' relative uncertainty added to its own. */
struct measured inputs_widen(const struct inputs *inputs, struct measured value);

/* Appends a line that lists the exact values, beginning with a newline; nothing if there are
 * none. */
void inputs_put(const struct inputs *inputs, struct buffer *text);
/* Adds the array `exact` to the open record. */
void inputs_reply(const struct inputs *inputs, struct reply *reply);
/* Copies the names for a later report. */
void inputs_keep(const struct inputs *inputs, struct exact_names *names);
/* Adds names that inputs_keep() copied; they must outlive `inputs`. */
void inputs_recall(struct inputs *inputs, const struct exact_names *names);

/* ---- what is wrong with a recording (findings.c) ---- */

/* Examines the recording, unless that was done. period [s] is that of the whole recording, or NAN
 * if it is to be measured. Returns false with the error if cancelled or out of memory. */
bool find_faults(struct recording *recording, double period, struct arena *arena,
                 struct error *error);
/* Law for which advice is given; with WINDOW_LAW_STICKS it also describes the rest at the end. */
enum window_law { WINDOW_LAW_SINE, WINDOW_LAW_STICKS };

/* Advice which part of a subject is the free oscillation, as 'data clean' judges it. */
struct window_advice {
    char text[200]; /* "" if there is none */
};

/* Sets *advice for a subject. If period [s] is known (not NAN) and the ends of the subject fit to
 * what lies next to them, nothing is judged and the text is empty. */
void advise_window(const struct subject *subject, enum window_law law, double period,
                   struct arena *arena, struct window_advice *advice);
/* Adds the advice to the reply as a warning. */
void reply_advice(const struct subject *subject, double period, struct arena *arena,
                  struct reply *reply);

/* Returns true if a sine of the period [s], fitted to stretches at the ends of a series, has the
 * amplitude there that it has next to them, and normal residuals: no hand, release or rest is
 * included. If it returns false, nothing is known (ends.c). */
bool series_ends_as_inside(const struct series *series, double period);

/* Adds the table of findings to the reply, and what was done or would be done. */
void reply_findings(const struct recording *recording, struct arena *arena, struct reply *reply);
