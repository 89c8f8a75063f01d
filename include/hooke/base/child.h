/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * child: runs a function in a forked copy of this process and returns the bytes that it produced.
 *
 * Used for calls of foreign libraries: a crash, a memory leak or an endless loop of the library
 * ends the copy and leaves this process unchanged. Describe the work in a struct child, then call
 * child_run(), which blocks until the work has ended.
 */
#pragma once

#include <hooke/base/error.h>

/* Description of the work; owned by the caller and not changed. */
struct child {
    /* Does the work in the copy: appends its result to `output` and returns true, or returns false
     * with `error` set. Other changes of memory are lost. */
    bool (*work)(const void *context, struct buffer *output, struct error *error);
    /* Returns true if the work must stop; child_run() calls it every 20 ms, and the work itself may
     * call it. NULL means never. */
    bool (*stopped)(const void *context);
    /* Argument of work() and stopped(). */
    const void *context;
    /* Beginning of the messages of failures, such as "the picture could not be drawn". */
    const char *what;
    /* Time [s] that child_run() waits for output, summed over all its waits; then the copy is
     * killed. */
    double patience;
};

/*
 * Runs child->work() in a copy of this process and appends its output to `output`. Returns false,
 * with `output` unchanged and `error` set, in these cases: the work failed (its own error);
 * stopped() returned true (ERROR_CANCELLED); the process could not be started, crashed, was killed
 * or took too long (ERROR_IO, "<what>: <reason>"); or memory ran out.
 *
 * The copy has no terminal and no standard streams, flushes no stream, calls no atexit function,
 * writes no core file, has default signal handlers and dies with this process. All signals are
 * blocked in the calling thread while the process is forked.
 */
bool child_run(const struct child *child, struct buffer *output, struct error *error);
