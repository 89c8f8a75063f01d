/* SPDX-License-Identifier: GPL-3.0-or-later */
/* series_tools: functions of the module `recording`, which reads recordings and measures series,
 * for use in the core. Get them by series_tools(); a build without the module has none, and no
 * recordings. */
#pragma once

#include <hooke/session/subject.h>

struct argument_value;
struct data_distance;
struct drawing;
struct export;
struct measured;
struct unit;

/* The functions. Those that return bool and have a parameter `error` set it when they return false.
 * Memory of results is that of `arena`. */
struct series_tools {
    /* ---- any series ---- */

    /* Fills *overview with what the series shows before any fit (struct overview). */
    void (*overview)(const struct series *series, struct arena *arena, struct overview *overview);
    /* Finds the times at which the series crosses `level` [SI], and stores the first `capacity` of
     * them. Returns their number, which may be larger. `overview` is that of the series. */
    size_t (*crossings)(const struct series *series, const struct overview *overview, double level,
                        struct crossing *crossings, size_t capacity);
    /* Returns the amplitude around a time t [s], or NAN if it is unknown. */
    double (*amplitude)(const struct series *series, double t, struct arena *arena);
    /* Measures the period. Returns false, with the reason in `error`, if the series does not
     * oscillate. */
    bool (*period)(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error);
    /* Measures the period [s] of the first variable of a run over all rows, by the fastest
     * procedure that is valid for the run. Returns false if it has no period. */
    bool (*run_period)(const struct run *run, struct arena *arena, struct measured *period);

    /* ---- recordings ---- */

    /* Appends a description of the recording for the user. */
    void (*describe)(const struct recording *recording, struct buffer *text);
    /* Sets *half to the uncertainties [series->n] that the file gives for these samples, or to NULL
     * if it gives none. Returns false if out of memory. */
    bool (*errors)(const struct recording *recording, const struct series *series,
                   struct arena *arena, const double **half);
    /* Computes velocities, and with `energy` energies, from positions; `series` is a part of the
     * recording, or NULL for the window that the user has chosen. */
    bool (*motion)(const struct session *session, const struct recording *recording,
                   const struct series *series, bool energy, struct arena *arena,
                   struct data_motion *motion, struct error *error);
    /* Returns the angular frequency [rad/s] at which a recording oscillates, or NAN if it does not:
     * that of its fit, else the one measured while the recording grows, else the highest peak in
     * the spectrum of `series`, its series or a part of it. */
    double (*frequency)(const struct session *session, const struct recording *recording,
                        const struct series *series, struct arena *arena);
    /* Fills *distance with the root mean square distance of a recording from a run (struct
     * data_distance of <hooke/plot.h>). */
    void (*distance)(const struct run *run, struct recording *recording,
                     struct data_distance *distance);
    /* Returns true if the fit that the user has adopted into the scene is a fit of this recording.
     */
    bool (*is_fitted)(const struct session *session, const struct recording *recording);
    /* Makes the table of the command `export FILE data`; `column` and `every` are the values of its
     * arguments COLUMN and every=. */
    bool (*table)(const struct session *session, const struct argument_value *column,
                  const struct argument_value *every, struct export *export, struct error *error);

    /* ---- the adopted fit ---- */

    /* Add the confidence band of the adopted fit to the curves of the run: draw_band() computes it,
     * draw_stored_band() uses the band that panes have stored. */
    bool (*draw_band)(struct drawing *drawing);
    bool (*draw_stored_band)(struct drawing *drawing);
    /* Adds the columns NAME_low and NAME_high of the confidence band to the table of the run that
     * `runs`, an argument of the command, chooses; it must be a single run. `where` is the option
     * as typed, for errors. */
    bool (*export_band)(const struct session *session, const struct argument_value *runs,
                        struct text where, struct export *export, struct error *error);

    /* ---- arguments ---- */

    /* Finds the unit that `text` spells, in any spelling that headers of data files use; *unit is
     * NULL if it is no unit. Returns false if out of memory. */
    bool (*unit)(struct text text, struct arena *arena, const struct unit **unit);
    /* Checks that `text` begins with a formula that can be fitted, and sets *used to the length
     * [byte] of the formula. */
    bool (*formula)(struct text text, struct arena *arena, size_t *used, struct error *error);
};

/* Returns the functions of this build, or NULL if it has none. */
const struct series_tools *series_tools(void);
/* Returns the functions of this build. If it has none, returns NULL and sets an error at `word`
 * that names the module which provides `what` ("--band", "data"). */
const struct series_tools *series_tools_for(const char *what, struct text word,
                                            struct error *error);
