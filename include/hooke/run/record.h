/* SPDX-License-Identifier: GPL-3.0-or-later */
/* record: the rule by which a run chooses the states that it records as rows. */
#pragma once

#include <stdint.h>

/* All steps, decimated if there are too many; all steps; every n-th step; even times. */
enum record_rule { RECORD_AUTO, RECORD_ALL, RECORD_EVERY, RECORD_TIMES };

/* A rule with its parameter. */
struct recording_rule {
    enum record_rule rule;
    int64_t every; /* Number of steps between two rows (RECORD_EVERY). */
    /* [s] > 0. With RECORD_TIMES rows are at t0 + k interval, also inside steps, and at the current
     * state. */
    double interval;
};
