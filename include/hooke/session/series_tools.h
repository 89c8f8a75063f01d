/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Functions of the module that measures series and reads recordings. A build has one such module or
 * none; recordings exist only in a build with it.
 */
#pragma once

#include <hooke/session/subject.h>

struct argument_value;
struct data_distance;
struct drawing;
struct export;
struct measured;
struct unit;

struct series_tools {
    /* ---- of any series ---- */

    void (*overview)(const struct series *series, struct arena *arena, struct overview *overview);
    /* Finds the crossings of `level`. Returns their number, which may be larger than `capacity`. */
    size_t (*crossings)(const struct series *series, const struct overview *overview, double level,
                        struct crossing *crossings, size_t capacity);
    /* Returns the amplitude about a time, or NAN if it is not known. */
    double (*amplitude)(const struct series *series, double t, struct arena *arena);
    /* Returns false with a reason in `error` where the series does not oscillate. */
    bool (*period)(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error);
    /* Finds the period of a run's position over all recorded rows in the cheapest way that is sound
     * for it. Returns false if it has none. */
    bool (*run_period)(const struct run *run, struct arena *arena, struct measured *period);

    /* ---- of recordings ---- */

    void (*describe)(const struct recording *recording, struct buffer *text);
    /* Finds the file's own uncertainties of these samples; *half is NULL if it has none. The array
     * is the arena's. Returns false if out of memory. */
    bool (*errors)(const struct recording *recording, const struct series *series,
                   struct arena *arena, const double **half);
    /* Finds velocities, and energies if they are asked for, from positions. `series` is a part of
     * the recording; NULL stands for its window. */
    bool (*motion)(const struct session *session, const struct recording *recording,
                   const struct series *series, bool energy, struct arena *arena,
                   struct data_motion *motion, struct error *error);
    /* Returns the angular frequency [rad/s] of the oscillation, or NAN if it has none. */
    double (*frequency)(const struct session *session, const struct recording *recording,
                        const struct series *series, struct arena *arena);
    void (*distance)(const struct run *run, struct recording *recording,
                     struct data_distance *distance);
    bool (*is_fitted)(const struct session *session, const struct recording *recording);
    /* Makes the table of `export FILE data`: COLUMN and every= as they were given. */
    bool (*table)(const struct session *session, const struct argument_value *column,
                  const struct argument_value *every, struct export *export, struct error *error);

    /* ---- of the fit that was adopted ---- */

    /* Adds its band to the curves of the run: found now, or the one that panes keep. Returns false
     * with `error` filled. */
    bool (*draw_band)(struct drawing *drawing);
    bool (*draw_stored_band)(struct drawing *drawing);
    /* Adds NAME_low and NAME_high to the table of one run; where: the option as typed. */
    bool (*export_band)(const struct session *session, const struct argument_value *runs,
                        struct text where, struct export *export, struct error *error);

    /* ---- of arguments ---- */

    /* Reads a unit in any spelling that headers of files have; *unit is the arena's, or NULL if it
     * is none. Returns false if out of memory. */
    bool (*unit)(struct text text, struct arena *arena, const struct unit **unit);
    /* Reads a formula that can be fitted at the beginning of a text; *used: its length. */
    bool (*formula)(struct text text, struct arena *arena, size_t *used, struct error *error);
};

/* Returns those of this build, or NULL if it has none. */
const struct series_tools *series_tools(void);
/* The same; without them `error` says which module `what`, "--band" or "data", belongs to. */
const struct series_tools *series_tools_for(const char *what, struct text word,
                                            struct error *error);
