/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Signal handlers, which only set flags and wake the loops through a pipe; the loops look at the
 * flags. */
#define _GNU_SOURCE /* pipe2 */
#include "terminal/terminal.h"
#include <hooke/base/cancel.h>

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

/* [s] time after SIGHUP or SIGTERM by which everything should be saved */
#define OVERDUE_SECONDS 10

struct cancel interrupt;
/* signal that ends the program, or 0 */
static volatile sig_atomic_t ending;
/* events that nobody has looked at yet */
static volatile sig_atomic_t happened[HAPPENED_COUNT];
/* a command is being executed: nobody looks at Ctrl-Z */
static volatile sig_atomic_t busy;
/* pipe that wakes the loops */
static int ends[2] = {-1, -1};

/* Signal of each event. */
static const int number_of[HAPPENED_COUNT] = {[HAPPENED_RESIZE] = SIGWINCH,
                                              [HAPPENED_SUSPEND] = SIGTSTP,
                                              [HAPPENED_CONTINUE] = SIGCONT,
                                              [HAPPENED_ALARM] = SIGALRM};

/* Wakes the loop that waits at the pipe; safe in a signal handler. */
static void signals_wake(void)
{
    int saved_errno = errno;
    if (ends[1] >= 0) {
        ssize_t ignored = write(ends[1], "", 1); /* if the pipe is full the reader wakes anyway */
        (void)ignored;
    }
    errno = saved_errno;
}

/* Handles Ctrl-C: asks every computation to stop. */
static void on_interrupt(int number)
{
    (void)number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
    signals_wake();
}

static void install_handler(int number, void (*handler)(int));

/* Ends the program if saving takes too long, perhaps in a write to a terminal that takes nothing.
 */
static void on_overdue(int number)
{
    (void)number;
    crash_end();
    _exit(128 + ending);
}

/* Handles SIGHUP and SIGTERM: asks computations and loops to end, and sets an alarm in case they do
 * not. */
static void on_ending(int number)
{
    if (!ending) {
        install_handler(SIGALRM, on_overdue);
        alarm(OVERDUE_SECONDS);
    }
    ending = number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
    signals_wake();
}

/* Notes an event for the loops. While a command is busy Ctrl-Z stops the program here, with the
 * terminal restored. */
static void on_event(int number)
{
    if (number == SIGTSTP && busy) {
        const int saved_errno = errno;
        crash_restore();
        signals_stop();
        errno = saved_errno;
        /* the loop must take the terminal back, even if the system did not stop us */
        number = SIGCONT;
    }
    for (int i = 0; i < HAPPENED_COUNT; i++) {
        if (number_of[i] == number) {
            happened[i] = 1;
        }
    }
    signals_wake();
}

/* Installs a handler without SA_RESTART, so that a blocking read returns. */
static void install_handler(int number, void (*handler)(int))
{
    struct sigaction action = {0};
    sigemptyset(&action.sa_mask);
    action.sa_handler = handler;
    sigaction(number, &action, NULL);
}

/* Installs the handlers of all front ends. */
void signals_install(void)
{
    install_handler(SIGINT, on_interrupt);
    install_handler(SIGHUP, on_ending);
    install_handler(SIGTERM, on_ending);
    install_handler(SIGPIPE,
                    SIG_IGN); /* closed output and file size limits are reported by write() */
    install_handler(SIGXFSZ, SIG_IGN);
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

/* Installs the handlers of the events in `set` and gives the others back to the system; the alarm
 * goes to crash_signal(). */
void signals_watch(unsigned set)
{
    for (int i = 0; i < HAPPENED_COUNT; i++) {
        if (number_of[i] == SIGALRM && ending) {
            continue; /* this alarm limits the time for saving */
        }
        if (number_of[i] == SIGALRM && !(set & 1u << i)) {
            crash_signal(SIGALRM);
        } else {
            install_handler(number_of[i], set & 1u << i ? on_event : SIG_DFL);
        }
    }
}

/* Sets the alarm, 0 stops it. Has no effect once the program is ending, which has an alarm of its
 * own. */
void signals_alarm(int64_t ns)
{
    const struct itimerval timer = {.it_value = {.tv_sec = (time_t)(ns / 1000000000),
                                                 .tv_usec = (suseconds_t)(ns % 1000000000 / 1000)}};
    sigset_t ends_it, saved_mask;
    sigemptyset(&ends_it);
    sigaddset(&ends_it, SIGHUP);
    sigaddset(&ends_it, SIGTERM);
    /* the alarm of on_ending() must not be replaced */
    sigprocmask(SIG_BLOCK, &ends_it, &saved_mask);
    if (!ending)
        setitimer(ITIMER_REAL, &timer, NULL);
    sigprocmask(SIG_SETMASK, &saved_mask, NULL);
}

/* Tells whether a command is being executed; returns the previous value. A Ctrl-Z that was not
 * handled yet stops the program. */
bool signals_busy(bool now)
{
    const bool was_busy = busy;
    busy = now;
    if (now && signals_happened(HAPPENED_SUSPEND)) { /* nobody will look at it for long */
        raise(SIGTSTP);
    }
    return was_busy;
}

/* Returns true if the event has happened since the last call. */
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

/* Stops the program as Ctrl-Z would, with the default action; returns when it is continued. */
void signals_stop(void)
{
    sigset_t stop, saved_mask;
    sigemptyset(&stop);
    sigaddset(&stop, SIGTSTP);
    install_handler(SIGTSTP, SIG_DFL);
    sigprocmask(SIG_UNBLOCK, &stop, &saved_mask);
    raise(SIGTSTP);
    sigprocmask(SIG_SETMASK, &saved_mask, NULL);
    install_handler(SIGTSTP, on_event);
}
