/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Part of the program in CONFIG=watch only: ends it, and says where it was, when a thread has used
 * 50 ms of its processor time without a look at the flag that Ctrl-C sets. HOOKE_WATCH=say: says
 * so and goes on.
 */
#define _GNU_SOURCE /* gettid, SIGEV_THREAD_ID */
#include <hooke/base.h>

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

static _Thread_local volatile unsigned looks, seen, ticks;
static _Thread_local bool watched;

static void on_tick(int number)
{
    (void)number;
    void *at[48];
    if (looks != seen) {
        seen = looks;
        ticks = 0;
        return;
    }
    if (++ticks != TICKS)
        return;
    static const char said[] = "watch: 50 ms without a look at the flag of Ctrl-C, in\n";
    ssize_t ignored = write(STDERR_FILENO, said, sizeof said - 1);
    (void)ignored;
    backtrace_symbols_fd(at, backtrace(at, (int)COUNT_OF(at)), STDERR_FILENO);
    const char *how = getenv("HOOKE_WATCH");
    if (!how || strcmp(how, "say") != 0)
        abort();
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
