/* SPDX-License-Identifier: GPL-3.0-or-later */
/* record: the rule by which a run chooses the states that it records as rows. */
#pragma once

#include <stdint.h>

/* RECORD_AUTO records all steps, but drops every second row if there are too many; RECORD_ALL all
 * steps; RECORD_EVERY each `every`-th step; RECORD_TIMES times at equal distances. */
enum record_rule { RECORD_AUTO, RECORD_ALL, RECORD_EVERY, RECORD_TIMES };

/* A rule with its parameter. */
struct recording_rule {
    enum record_rule rule;
    int64_t every; /* Number of steps between two rows (RECORD_EVERY). */
    /* Distance [s] of the rows of RECORD_TIMES, > 0: rows are at t0 + k interval, also inside
     * steps, and at the current state. */
    double interval;
};
