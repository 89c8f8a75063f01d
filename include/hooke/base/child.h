/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * base: work that runs in a process of its own, a copy of this one: what a foreign library crashes,
 * exhausts or never ends there is that copy, and nothing of it stays in this process.
 */
#pragma once

#include <hooke/base/error.h>

struct child {
    /* Appends to `output`, or fails with an error. What else it changes is lost. */
    bool (*work)(const void *context, struct buffer *output, struct error *error);
    /* Returns true if the work is to be stopped. Called all the time, in both processes. NULL means
     * that it is never stopped. */
    bool (*stopped)(const void *context);
    const void *context;
    const char *what; /* is not done if the process fails: "the picture could not be drawn" */
    double patience;  /* [s] that the work may take */
};

/*
 * Appends to `output` what the work appended there. False, `output` as it was: the work failed (its
 * own error), was stopped (ERROR_CANCELLED), or its process could not be started, crashed, was
 * killed or took too long (ERROR_IO, "<what>: <why>").
 *
 * The child has neither the terminal nor standard input and output, flushes no stream, calls no
 * atexit function, leaves no core, takes no signal of this process's terminal or handlers, and dies
 * with this process. For the caller's signals: all are blocked while the process is copied.
 */
bool child_run(const struct child *child, struct buffer *output, struct error *error);
