/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Time: processor time of this thread and monotonic time [ns]. */
#include <hooke/base/cancel.h>

#include <time.h>

/* Returns the processor time [ns] of this thread. */
int64_t clock_cpu_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* Returns monotonic time [ns]. */
int64_t clock_ns(void)
{
    struct timespec now;
    /* cannot fail: the clock exists and the address is good */
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

double clock_seconds(int64_t begin)
{
    return (double)(clock_ns() - begin) * 1e-9;
}
