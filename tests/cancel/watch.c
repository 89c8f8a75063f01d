/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Part of the program in CONFIG=watch only: ends it, and says where it was, when a thread has used
 * 50 ms of its processor time without a look at the flag that Ctrl-C sets, or 50 ms while the flag
 * stood. HOOKE_WATCH=say: says so and goes on.
 */
#undef _GNU_SOURCE
#define _GNU_SOURCE /* gettid, SIGEV_THREAD_ID */
#include "terminal/terminal.h"
#include <hooke/base/cancel.h>

#include <execinfo.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

#define TICK_NS 10000000 /* of the thread's processor time */
#define TICKS 5

static _Thread_local volatile unsigned looks, seen, ticks, late;
static _Thread_local bool watched;

static void tell(struct text what)
{
    void *at[48];
    ssize_t ignored = write(STDERR_FILENO, what.data, what.len);
    (void)ignored;
    backtrace_symbols_fd(at, backtrace(at, (int)COUNT_OF(at)), STDERR_FILENO);
    const char *how = getenv("HOOKE_WATCH");
    if (!how || strcmp(how, "say") != 0)
        abort();
}

static void on_tick(int number)
{
    (void)number;
    late = atomic_load_explicit(&interrupt.requested, memory_order_relaxed) ? late + 1 : 0;
    ticks = looks == seen ? ticks + 1 : 0;
    seen = looks;
    if (late == TICKS)
        tell(TEXT("watch: at work 50 ms after Ctrl-C, in\n"));
    else if (ticks == TICKS)
        tell(TEXT("watch: 50 ms without a look at the flag of Ctrl-C, in\n"));
}

static void begin(void)
{
    void *at[2];
    backtrace(at, 2); /* loads what it needs before a handler does */
    struct sigaction action = {.sa_handler = on_tick, .sa_flags = SA_RESTART};
    sigaction(SIGRTMIN + 3, &action, NULL);
    struct sigevent event = {.sigev_notify = SIGEV_THREAD_ID, .sigev_signo = SIGRTMIN + 3};
    event.sigev_notify_thread_id = gettid();
    timer_t timer;
    const struct itimerspec each = {{0, TICK_NS}, {0, TICK_NS}};
    if (timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer) != 0 ||
        timer_settime(timer, 0, &each, NULL) != 0) {
        perror("watch");
        abort();
    }
}

void watch_look(void)
{
    if (!watched) {
        watched = true;
        begin();
    }
    looks++;
}
