/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Items of work shared by threads, whose results are kept by item and not by thread. */
#pragma once

#include <hooke/base/text.h>

struct cancel;

enum { PARALLEL_THREADS_MAX = 256 };

struct parallel {
    int threads; /* 0 means as many as there are processors */
    const struct cancel *cancel;
    /* Is called by the calling thread ten times a second; may be NULL. */
    void (*progress)(void *context, double fraction);
    void *progress_context;
    /* Does item `index` in a thread, numbered from 0. It looks at `cancel` itself where it takes
     * long. */
    void (*work)(void *context, int thread, int64_t index);
    void *context;
};

/* Returns how many threads there will be at most for so many items, at least 1. */
int parallel_threads(const struct parallel *parallel, int64_t count);

/* Does all items from 0 to count - 1, with fewer threads where no more can be made, in the calling
 * thread if there are none. Returns how many threads there were. If it is cancelled some items are
 * not done. */
int parallel_do(const struct parallel *parallel, int64_t count);
