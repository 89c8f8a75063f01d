/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * front: callbacks that a front end (batch, prompt, panes, another program) offers to a session,
 * and the lines that it reads from sensors.
 */
#pragma once

#include <hooke/base/error.h>

struct cancel;
struct figure;
struct run;
struct session;
struct table;

/* ---- lines as they come, for `collect` ---- */

enum feed_end {
    FEED_GOES_ON,
    FEED_ENDED,     /* the writer has closed the source */
    FEED_UNPLUGGED, /* the device is gone */
    FEED_IN_TIME,   /* the time is over for which lines were wanted */
    FEED_FULL,      /* the number of lines was reached that is wanted, or that a file may have */
    FEED_FAILED     /* the file cannot be written; the lines in it are complete */
};

struct feed_request {
    const char *source; /* a device, a pipe, a file that grows, STANDARD_INPUT */
    int file;           /* descriptor that each complete line is appended to; the feed closes it */
    long baud;          /* baud rate of a serial line */
    double t_begin;     /* [s] time at which it begins */
    uint64_t max;       /* lines */
    bool safe;          /* devices are refused */
};

struct feed_look {
    enum feed_end end;
    uint64_t lines, bytes; /* lines in the file, bytes that came */
    double now;            /* [s] */
    double first, last;    /* [s] arrival of the first and the last line; NAN before any came */
    uint64_t unwritten;    /* lines that came but could not be written to the file */
    char failure[80];      /* reason for FEED_FAILED or FEED_UNPLUGGED; empty if it hung up */
};

struct feed; /* private to the front end, which reads in a thread of its own */

struct feed_access {
    struct feed *(*open)(const struct feed_request *request, struct error *error);
    void (*look)(struct feed *feed, struct feed_look *look);
    void (*pause)(struct feed *feed, bool pause); /* drops the lines that come during a pause */
    /* Ends the feed at the first line that comes after `end` [s], or never if that is HUGE_VAL. */
    void (*limit)(struct feed *feed, double end);
    /* Restores the device's settings and fills *look with all that came. */
    void (*close)(struct feed *feed, struct feed_look *look);
    /* Clears a Ctrl-C that has ended the collecting, so that it ends nothing else. */
    void (*heeded)(void);
};

enum front_change { FRONT_PANES, FRONT_PLAIN, FRONT_REDRAW };

/* The front end as the session sees it. Every callback may be NULL. */
struct front {
    /* true if a person types: prefixes of names are accepted, and long runs are asked about instead
     * of refused */
    bool interactive;
    bool utf8, color;  /* true if the output can show them */
    int width, height; /* [cell] size of the output; 0 means 80x24 */
    bool input;        /* true if standard input is free for data: no commands come from there */
    const struct feed_access *feed; /* NULL if the front end reads no sensors */
    const struct cancel *cancel;
    void *context;
    bool (*confirm)(void *context, const char *question);
    /* Shows progress between slices. fraction: < 0 if it is unknown, > 1 to erase what was shown;
     * run: NULL in a study. */
    void (*progress)(void *context, const struct run *run, double fraction);
    void (*clear)(void *context);
    /* Is called after each line, also of a file, when the session can be saved. */
    void (*executed)(void *context);
    /*
     * Live runs. `watched` is true if a person watches a screen of panes. Then run and continue
     * advance in slices of at most 10 ms and call `slice` between them: it polls the terminal,
     * executes typed lines (command_exec() may be called again from inside; commands that would
     * disturb the run are refused) and draws. It returns at `deadline` [clock_ns] or earlier; false
     * means pause.
     */
    bool watched;
    bool (*slice)(void *context, struct session *session, int64_t deadline);
    /* Draws the screen into a file, as ncurses would show it (in batch with width x height). */
    bool (*screenshot)(void *context, const struct session *session, const char *path,
                       struct write_policy policy, struct error *error);
    /* Appends the screen as lines of text, for `screenshot` without a file. */
    bool (*screen)(void *context, const struct session *session, struct buffer *text,
                   struct error *error);
    /* Takes the table of `export -`, which is written to the output if this is NULL. Returns false
     * if out of memory. */
    bool (*table)(void *context, const struct table *table);
    /* Sets the ends [s] of the time axis on the screen. Returns false if it has none. */
    bool (*time_shown)(void *context, const struct session *session, double span[2]);
    /* Shows a figure of width x height cells as pixels; if it is NULL, only checks that this is
     * possible. Returns false with the reason in `error`. */
    bool (*pixels)(const struct front *front, const struct figure *figure, int width, int height,
                   struct error *error);
    /* Changes the front end itself. Returns false with the reason if this is not possible. */
    bool (*change)(void *context, enum front_change change, struct error *error);
};
