/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Signals only set flags and wake the loop through a pipe; the loops look at them. */
#define _GNU_SOURCE /* pipe2 */
#include "terminal/terminal.h"
#include <hooke/base/cancel.h>

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

/* time after SIGHUP or SIGTERM by which everything should be saved */
#define OVERDUE_SECONDS 10

struct cancel interrupt;
static volatile sig_atomic_t ending;
static volatile sig_atomic_t happened[HAPPENED_COUNT];
static volatile sig_atomic_t busy;
static int ends[2] = {-1, -1};

static const int number_of[HAPPENED_COUNT] = {[HAPPENED_RESIZE] = SIGWINCH,
                                              [HAPPENED_SUSPEND] = SIGTSTP,
                                              [HAPPENED_CONTINUE] = SIGCONT,
                                              [HAPPENED_ALARM] = SIGALRM};

static void signals_wake(void)
{
    int saved_errno = errno;
    if (ends[1] >= 0) {
        ssize_t ignored = write(ends[1], "", 1); /* a full pipe wakes as well */
        (void)ignored;
    }
    errno = saved_errno;
}

static void on_interrupt(int number)
{
    (void)number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
    signals_wake();
}

static void handle(int number, void (*handler)(int));

/* The program hangs, perhaps in a write to a terminal that takes nothing. */
static void on_overdue(int number)
{
    (void)number;
    crash_end();
    _exit(128 + ending);
}

static void on_ending(int number)
{
    if (!ending) {
        handle(SIGALRM, on_overdue);
        alarm(OVERDUE_SECONDS);
    }
    ending = number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
    signals_wake();
}

static void on_event(int number)
{
    if (number == SIGTSTP && busy) {
        const int saved_errno = errno;
        crash_restore();
        signals_stop();
        errno = saved_errno;
        /* the terminal is to be taken back, also where the system would not stop us */
        number = SIGCONT;
    }
    for (int i = 0; i < HAPPENED_COUNT; i++) {
        if (number_of[i] == number) {
            happened[i] = 1;
        }
    }
    signals_wake();
}

static void handle(int number, void (*handler)(int))
{
    struct sigaction action = {0};
    sigemptyset(&action.sa_mask);
    action.sa_handler = handler; /* no SA_RESTART: a blocking read returns */
    sigaction(number, &action, NULL);
}

void signals_install(void)
{
    handle(SIGINT, on_interrupt);
    handle(SIGHUP, on_ending);
    handle(SIGTERM, on_ending);
    handle(SIGPIPE, SIG_IGN); /* closed output and file size limits are reported by write() */
    handle(SIGXFSZ, SIG_IGN);
}

void signals_hang_up(void)
{
    if (!ending) {
        on_ending(SIGHUP);
    }
}

int signals_ending(void)
{
    return ending;
}

void signals_watch(unsigned set)
{
    for (int i = 0; i < HAPPENED_COUNT; i++) {
        if (number_of[i] == SIGALRM && ending) {
            continue; /* it says that saving takes too long */
        }
        if (number_of[i] == SIGALRM && !(set & 1u << i)) {
            crash_signal(SIGALRM);
        } else {
            handle(number_of[i], set & 1u << i ? on_event : SIG_DFL);
        }
    }
}

void signals_alarm(int64_t ns)
{
    const struct itimerval timer = {.it_value = {.tv_sec = (time_t)(ns / 1000000000),
                                                 .tv_usec = (suseconds_t)(ns % 1000000000 / 1000)}};
    sigset_t ends_it, saved_mask;
    sigemptyset(&ends_it);
    sigaddset(&ends_it, SIGHUP);
    sigaddset(&ends_it, SIGTERM);
    sigprocmask(SIG_BLOCK, &ends_it, &saved_mask); /* or its own alarm would be set anew */
    if (!ending)
        setitimer(ITIMER_REAL, &timer, NULL);
    sigprocmask(SIG_SETMASK, &saved_mask, NULL);
}

bool signals_busy(bool now)
{
    const bool was_busy = busy;
    busy = now;
    if (now &&
        signals_happened(
            HAPPENED_SUSPEND)) { /* it came after the last look: nobody would see it for long */
        raise(SIGTSTP);
    }
    return was_busy;
}

bool signals_happened(enum signalled what)
{
    if (!happened[what]) {
        return false; /* clearing it here could lose one that comes just now */
    }
    happened[what] = 0;
    return true;
}

int signals_pipe(void)
{
    if (ends[0] < 0 && pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) {
        ends[0] = ends[1] = -1;
    }
    return ends[0];
}

void signals_drain(void)
{
    char bytes[64];
    while (read(ends[0], bytes, sizeof bytes) > 0) {
    }
}

void signals_stop(void)
{
    sigset_t stop, saved_mask;
    sigemptyset(&stop);
    sigaddset(&stop, SIGTSTP);
    handle(SIGTSTP, SIG_DFL);
    sigprocmask(SIG_UNBLOCK, &stop, &saved_mask);
    raise(SIGTSTP);
    sigprocmask(SIG_SETMASK, &saved_mask, NULL);
    handle(SIGTSTP, on_event);
}
