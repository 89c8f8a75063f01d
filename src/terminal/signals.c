/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Signals only set flags; the loops look at them. */
#include "terminal.h"

#include <signal.h>

struct cancel interrupt;
static volatile sig_atomic_t ending;

static void on_interrupt(int number)
{
    (void)number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
}

static void on_ending(int number)
{
    ending = number;
    atomic_store_explicit(&interrupt.requested, 1, memory_order_relaxed);
}

void signals_install(void)
{
    struct sigaction action = {0};
    sigemptyset(&action.sa_mask);
    action.sa_handler = on_interrupt; /* no SA_RESTART: a blocking read returns */
    sigaction(SIGINT, &action, NULL);
    action.sa_handler = on_ending;
    sigaction(SIGHUP, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    action.sa_handler = SIG_IGN; /* closed output and file size limits are reported by write() */
    sigaction(SIGPIPE, &action, NULL);
    sigaction(SIGXFSZ, &action, NULL);
}

int signals_ending(void)
{
    return ending;
}
