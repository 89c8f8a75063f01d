/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rules that select the rows of a run to be recorded. */
#pragma once

#include <stdint.h>

enum record_rule { RECORD_AUTO, RECORD_ALL, RECORD_EVERY, RECORD_TIMES };

struct recording_rule {
    enum record_rule rule;
    int64_t every; /* number of steps between two rows (RECORD_EVERY) */
    /* [s], positive. With RECORD_TIMES rows are recorded at t0 + k interval, inside of steps too,
     * and at the present state. */
    double interval;
};
