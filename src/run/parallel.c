/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Threads that take items of work from a common counter, until all are done: parallel_do(). The
 * calling thread only waits and shows progress. */
#include <hooke/base/cancel.h>
#include <hooke/run/parallel.h>

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>
#include <unistd.h>

/* Stack [byte] of each thread: eight times the largest frame, that of a long formula. The default
 * would depend on the system. */
#define THREAD_STACK ((size_t)1 << 20)

/* State that all threads of one parallel_do() share. */
struct parallel_share {
    const struct parallel *parallel;
    int64_t count;      /* number of items */
    atomic_llong next;  /* next item that no thread has taken */
    atomic_int working; /* threads that have not ended */
};

/* Argument of one thread. */
struct parallel_thread {
    struct parallel_share *share;
    pthread_t id;
    int number; /* 0, 1, …: which of the caller's workspaces it uses */
};

/* Main function of a thread: works on items until none is left or the user cancels. */
static void *take_items(void *context)
{
    const struct parallel_thread *thread = context;
    struct parallel_share *share = thread->share;
    const struct parallel *parallel = share->parallel;
    for (int64_t index; (index = atomic_fetch_add(&share->next, 1)) < share->count &&
                        !cancelled(parallel->cancel);)
        parallel->work(parallel->context, thread->number, index);
    atomic_fetch_sub(&share->working, 1);
    return NULL;
}

/* Waits for the threads to end and reports progress ten times a second from the calling thread, so
 * that callbacks need not be safe in threads. */
static void watch_threads(struct parallel_share *share)
{
    static const int64_t look_ns = 100000000;
    const struct parallel *parallel = share->parallel;
    int64_t shown = clock_ns();
    while (atomic_load(&share->working) > 0) {
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        if (!parallel->progress || clock_ns() - shown < look_ns || cancelled(parallel->cancel))
            continue;
        shown = clock_ns();
        const double taken = (double)atomic_load(&share->next) / (double)share->count;
        parallel->progress(parallel->progress_context, taken < 1 ? taken : 1);
    }
}

/* Returns the number of threads for `count` items: as requested, or one for each processor. */
int parallel_threads(const struct parallel *parallel, int64_t count)
{
    int64_t threads = parallel->threads;
    if (threads <= 0)
        threads = sysconf(_SC_NPROCESSORS_ONLN);
    threads = threads > PARALLEL_THREADS_MAX ? PARALLEL_THREADS_MAX : threads;
    threads = threads > count ? count : threads;
    return threads < 1 ? 1 : (int)threads;
}

/* Starts the threads, waits for them, and returns how many there were; works alone if none
 * starts. */
int parallel_do(const struct parallel *parallel, int64_t count)
{
    struct parallel_share share = {.parallel = parallel, .count = count};
    struct parallel_thread thread[PARALLEL_THREADS_MAX];
    const int wanted = parallel_threads(parallel, count);
    pthread_attr_t stack;
    int made = 0;
    pthread_attr_init(&stack);
    pthread_attr_setstacksize(&stack, THREAD_STACK);
    for (; made < wanted; made++) {
        thread[made] = (struct parallel_thread){.share = &share, .number = made};
        atomic_fetch_add(&share.working, 1);
        if (pthread_create(&thread[made].id, &stack, take_items, &thread[made]) != 0)
            break;
    }
    pthread_attr_destroy(&stack);
    if (made < wanted)
        atomic_fetch_sub(&share.working, 1);
    if (made == 0)
        take_items(&thread[0]);
    watch_threads(&share);
    for (int i = 0; i < made; i++)
        pthread_join(thread[i].id, NULL);
    return made > 0 ? made : 1;
}
