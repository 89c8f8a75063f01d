/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables made from a session; all memory from the arena. */
#ifndef HOOKE_COMMAND_EXPORT_H
#define HOOKE_COMMAND_EXPORT_H

#include "internal.h"

struct export
{
    struct arena *arena;
    struct table table;
};

/* runs: none means the current one; column: none means t, y, v, energy; every: a count of rows, or a time. */
bool export_runs(const struct session *session, const struct given *runs, const struct given *column,
                 const struct given *every, struct export *export, struct error *error);
/* Adds NAME_low and NAME_high to the table of one run: the band of the adopted fit about each
 * variable of the state in it. where: the option as typed. */
bool export_band(const struct session *session, const struct given *runs, struct text where,
                 struct export *export, struct error *error);
bool export_recording(const struct session *session, struct export *export, struct error *error);
/* column: t, y, v, energy; none means t and y. */
bool export_recorded(const struct session *session, const struct given *column, const struct given *every,
                     struct export *export, struct error *error);
bool export_measurements(const struct session *session, struct export *export, struct error *error);
bool export_sweep(const struct session *session, struct export *export, struct error *error);
bool export_precision(const struct session *session, struct export *export, struct error *error);
/* Fills the keys of the table: what made this run. */
bool export_run_keys(const struct session *session, int place, struct export *export, struct error *error);
/* A row for each run. */
bool export_run_table(const struct session *session, struct export *export, struct error *error);

/* Which rows of many are written, by `every`: a count of rows, or a time [s]. */
struct thinning {
    double step;
    bool by_time;
    int64_t next;
};

bool thinning_begin(struct thinning *thinning, const struct given *every, struct error *error);
/* Row i, `elapsed` after the first; to be asked of one after another. */
bool thinning_keeps(struct thinning *thinning, size_t i, double elapsed);

#endif
