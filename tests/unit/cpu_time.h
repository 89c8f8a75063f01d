/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds on work are bounds on processor time: on a busy machine the clock on the wall says nothing
 * of the program. */
#pragma once

#include <stdint.h>
#include <time.h>

/* Processor time of this process so far [ns]. May be called by a signal handler. */
static inline int64_t cpu_ns(void)
{
    struct timespec now = {0, 0};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}
