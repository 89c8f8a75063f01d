/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * cancel: Ctrl-C, and the clock.
 *
 * Set from a signal handler or another thread; long work asks between slices of at most 50 ms:
 * make CONFIG=watch builds a program that ends where it does not.
 */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct cancel {
    atomic_int requested;
};

#ifdef HOOKE_WATCH
void watch_look(void);
#else
#define watch_look() ((void)0)
#endif

#define LOOK_EACH_ROWS 16384 /* rows between two looks, for loops that take at most 1 us a row */

static inline bool cancelled(const struct cancel *cancel)
{
    if (cancel)
        watch_look();
    return cancel && atomic_load_explicit(&((struct cancel *)(uintptr_t)cancel)->requested,
                                          memory_order_relaxed) != 0;
}

/* Returns the same for row i of a loop that looks at every LOOK_EACH_ROWS-th row only. */
static inline bool cancelled_at(const struct cancel *cancel, size_t i)
{
    return i % LOOK_EACH_ROWS == 0 && cancelled(cancel);
}

/* ---- the clock ---- */

/* Returns a clock [ns] that only goes forward. */
int64_t clock_ns(void);
double clock_seconds(int64_t begin); /* returns the time [s] since `begin` [ns] */
int64_t clock_cpu_ns(void);          /* returns the processor time of this thread */
