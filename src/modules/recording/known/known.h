/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Knowledge of the module about runs and recordings of a session. */
#pragma once

#include "modules/recording/series/analysis.h"
#include "modules/recording/table/load.h"
#include <hooke/plot.h>
#include <hooke/report.h>
#include <hooke/session/series_tools.h>

/* As series_period(), of the first variable of a run over some of its rows; where that finds no
 * period, an uncertain one or few waves, from returns of the whole state (closed_period.c). The run
 * is NULL where the series is of something else. */
bool run_series_period(const struct run *run, const struct series *series, struct arena *arena,
                       struct period *period, struct error *error);
/* series_tools.run_period */
bool find_run_period(const struct run *run, struct arena *arena, struct measured *period);

/* ---- velocity and energy of a recording of positions (data_motion.c) ---- */

/* series_tools.motion, frequency and is_fitted */
/* `series` is that of the recording, or NULL for its window. */
bool data_motion(const struct session *session, const struct recording *recording,
                 const struct series *series, bool energy, struct arena *arena,
                 struct data_motion *motion, struct error *error);
/* Returns the angular frequency of the oscillation [rad/s]: that of the fit, else of the period
 * read while the recording grows, else of the largest peak of the spectrum, or NAN if it has none.
 */
double motion_frequency(const struct session *session, const struct recording *recording,
                        const struct series *series, struct arena *arena);
bool recording_is_fitted(const struct session *session, const struct recording *recording);

/* ---- a recording beside a run (distance.c), as tables (export_recording.c) ---- */

void find_distance(const struct run *run, struct recording *recording,
                   struct data_distance *distance);
bool export_recorded(const struct session *session, const struct argument_value *column,
                     const struct argument_value *every, struct export *export,
                     struct error *error);
/* Writes, for a hand-in, t and y of every sample, and used (0, 1) if some are outside the window or
 * masked. */
bool export_recording(const struct session *session, struct export *export, struct error *error);
bool export_band(const struct session *session, const struct argument_value *runs,
                 struct text where, struct export *export, struct error *error);

/* ---- what a derived number was computed with (inputs.c) ----
 *
 * What a derived number was computed with: which of these values were stated without an
 * uncertainty and count as exact, and how uncertain the others make it. */

#define INPUTS_MAX 16

struct inputs {
    const char *exact[INPUTS_MAX]; /* names, each once */
    int exacts;
    double relative; /* uncertainty of a product or quotient of all of them (GUM 5.1.6) */
};

/* The name has to last as long as the inputs. Zero enters nothing. */
void inputs_use(struct inputs *inputs, const char *name, struct measured value);
/* Uses those of the named parameters ("m rho area") that the scene has. */
void inputs_use_params(struct inputs *inputs, const struct scene *scene, const char *names);
/* Every parameter but those that are free that the motion depends on. */
void inputs_use_motion(struct inputs *inputs, const struct scene *scene, const bool *is_free);
/* The value, more uncertain by all of the inputs. */
struct measured inputs_widen(const struct inputs *inputs, struct measured value);

/* A line that begins with a newline and says which are exact; nothing where none is. */
void inputs_put(const struct inputs *inputs, struct buffer *text);
/* Adds the array `exact` to the open record. */
void inputs_reply(const struct inputs *inputs, struct reply *reply);
/* Copies the names for the report, and reads them back; the names must outlive `inputs`. */
void inputs_keep(const struct inputs *inputs, struct exact_names *names);
void inputs_recall(struct inputs *inputs, const struct exact_names *names);

/* ---- what is wrong with a recording (findings.c) ---- */

/* Examines the recording unless that was done. `period` is that of all of it [s], or NAN to find
 * it. */
bool find_faults(struct recording *recording, double period, struct arena *arena,
                 struct error *error);
/*
 * Advice on which part of a subject is the free oscillation, as 'data clean' judges it, in words
 * for every command that works on a window. The text is empty where the whole of it is.
 */
enum window_law { WINDOW_LAW_SINE, WINDOW_LAW_STICKS /* the law describes the rest, too */ };

struct window_advice {
    char text[200]; /* "" if there is none */
};

/* period [s]: where it is known (not NAN) and the ends of the subject are as what lies next to
 * them, nothing is judged. */
void advise_window(const struct subject *subject, enum window_law law, double period,
                   struct arena *arena, struct window_advice *advice);
/* as a warning */
void reply_advice(const struct subject *subject, double period, struct arena *arena,
                  struct reply *reply);

/*
 * Returns true if a sine of the period [s], fitted to stretches at the ends of a series, has the
 * amplitude there that it has next to them, and leaves as much as anywhere: no hand, release or
 * rest is in it. False says nothing. (ends.c)
 */
bool series_ends_as_inside(const struct series *series, double period);

/* The table, then what was done or would be done. */
void reply_findings(const struct recording *recording, struct arena *arena, struct reply *reply);
