/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which rows of a run are recorded. */
#ifndef HOOKE_RUN_RECORD_H
#define HOOKE_RUN_RECORD_H

#include <stdint.h>

enum record_rule { RECORD_AUTO, RECORD_ALL, RECORD_EVERY, RECORD_TIMES };

struct recording_rule {
    enum record_rule rule;
    int64_t every; /* RECORD_EVERY: each so many steps */
    /* [s] > 0, RECORD_TIMES: rows at t0 + k interval, inside of steps too, and the present state */
    double interval;
};

#endif
