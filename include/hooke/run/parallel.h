/* SPDX-License-Identifier: GPL-3.0-or-later */
/* parallel: distributes independent items of work over threads. Results belong to the item, so that
 * they do not depend on the number of threads. Fill a struct parallel and call parallel_do(). */
#pragma once

#include <hooke/base/text.h>

struct cancel;

enum { PARALLEL_THREADS_MAX = 256 };

/* The work, owned by the caller. */
struct parallel {
    int threads; /* Number of threads; 0 stands for the number of processors. */
    /* Stops the work between items; may be NULL. */
    const struct cancel *cancel;
    /* Called by the calling thread ten times a second with the fraction of items begun; may be
     * NULL. */
    void (*progress)(void *context, double fraction);
    void *progress_context;
    /* Does item `index` in thread number `thread`, from 0. Several threads call it at once. If an
     * item takes more than 50 ms it must call cancelled() itself. */
    void (*work)(void *context, int thread, int64_t index);
    void *context;
};

/* Returns the number of threads, at least 1, that parallel_do() uses at most for `count` items. */
int parallel_threads(const struct parallel *parallel, int64_t count);

/* Does the items 0 to count - 1, in the calling thread if no thread can be created, and returns
 * when all threads have ended. Returns the number of threads that it used. If parallel->cancel
 * stops the work, some items are not done. */
int parallel_do(const struct parallel *parallel, int64_t count);
