/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * cancel: a flag by which Ctrl-C, or another thread, asks long computations to stop; and clocks.
 *
 * A signal handler or another thread sets struct cancel.requested to a value other than 0. A long
 * computation is given a pointer to the struct and calls cancelled() at least every 50 ms; when
 * that returns true, the computation returns its failure value. A build with `make CONFIG=watch`
 * aborts if 50 ms pass between two calls.
 */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Flag that requests a stop. The owner is whoever creates the session or the thread;
 * zero-initialise it. */
struct cancel {
    /* 0 to continue, any other value to stop; may be written in a signal handler. */
    atomic_int requested;
};

#ifdef HOOKE_WATCH
/* Tells the watchdog of a CONFIG=watch build that cancelled() has been called; a no-op otherwise.
 */
void watch_look(void);
#else
#define watch_look() ((void)0)
#endif

/* Number of rows that a loop processes between two calls of cancelled(): at 1 us per row or less,
 * 16 ms. */
#define LOOK_EACH_ROWS 16384

/* Returns true if a stop has been requested. `cancel` may be NULL, for a computation that nothing
 * can stop: then the result is false. May be called from any thread. */
static inline bool cancelled(const struct cancel *cancel)
{
    if (cancel)
        watch_look();
    return cancel && atomic_load_explicit(&((struct cancel *)(uintptr_t)cancel)->requested,
                                          memory_order_relaxed) != 0;
}

/* Returns cancelled() if i is a multiple of LOOK_EACH_ROWS, else false: the condition of loops over
 * rows i = 0, 1, …. */
static inline bool cancelled_at(const struct cancel *cancel, size_t i)
{
    return i % LOOK_EACH_ROWS == 0 && cancelled(cancel);
}

/* ---- the clock ---- */

/* Returns the time [ns] of a monotonic clock whose zero is arbitrary. */
int64_t clock_ns(void);
/* Returns the time [s] that has passed since `begin`, a value of clock_ns(). */
double clock_seconds(int64_t begin);
int64_t clock_cpu_ns(void); /* Returns the processor time [ns] that the calling thread has used. */
