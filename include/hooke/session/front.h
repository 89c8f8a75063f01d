/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * front: the callbacks that a front end (batch, prompt, panes, another program) provides to a
 * session, and the lines that it reads from sensors for the command `collect`.
 *
 * A front end fills a struct front and passes it to session_create(); NULL callbacks are never
 * called.
 */
#pragma once

#include <hooke/base/error.h>

struct cancel;
struct figure;
struct run;
struct session;
struct table;

/* ---- feed: lines of a sensor, read in a thread of the front end ---- */

/* State of a feed: FEED_GOES_ON while it is read, else the reason why it has ended. */
enum feed_end {
    FEED_GOES_ON,
    FEED_ENDED,     /* The writer has closed the source. */
    FEED_UNPLUGGED, /* The device is gone. */
    FEED_IN_TIME,   /* The requested time is over. */
    FEED_FULL,  /* The requested number of lines, or the largest number in a file, was reached. */
    FEED_FAILED /* The file cannot be written; the lines in it are complete. */
};

/* The source that a feed reads, and the file that it writes. */
struct feed_request {
    const char *source; /* Path of a device, a pipe or a growing file, or STANDARD_INPUT. */
    int file;           /* Descriptor to which complete lines are appended; the feed closes it. */
    long baud;          /* Baud rate of a serial line. */
    /* Time [s] since the beginning of the recording at which the feed begins: 0, or more if it
     * continues a recording. */
    double t_begin;
    uint64_t max; /* Number of lines after which the feed ends. */
    bool safe;    /* If true, devices are refused (option --safe). */
};

/* The progress of a feed. The zero of all times is the beginning of the recording. */
struct feed_look {
    enum feed_end end;
    uint64_t lines, bytes; /* Number of lines in the file, and of bytes received. */
    double now;            /* Current time [s], whether or not lines arrive. */
    double first, last;    /* Arrival times [s] of the first and the last line; NAN before any. */
    uint64_t unwritten;    /* Number of lines received that could not be written to the file. */
    char failure[80];      /* Reason of FEED_FAILED or FEED_UNPLUGGED; "" if the device hung up. */
};

struct feed; /* private to the front end, which reads it in a thread */

/* Functions of the front end that read feeds; called by the thread of the session. */
struct feed_access {
    /* Opens a source and begins to read. Returns NULL with `error` set. */
    struct feed *(*open)(const struct feed_request *request, struct error *error);
    /* Fills *look with the current progress. */
    void (*look)(struct feed *feed, struct feed_look *look);
    /* Begins or ends a pause, during which lines are dropped. */
    void (*pause)(struct feed *feed, bool pause);
    /* Ends the feed at the first line that arrives after `end` [s], or never if that is HUGE_VAL.
     */
    void (*limit)(struct feed *feed, double end);
    /* Ends and frees the feed, restores the device's settings and fills *look with the final
     * progress. */
    void (*close)(struct feed *feed, struct feed_look *look);
    /* Clears the flag of a Ctrl-C by which the user has ended the feed, so that the same Ctrl-C
     * does not stop the commands that follow. */
    void (*heeded)(void);
};

/* Changes of the front end by the user: open panes, close them, or redraw the screen. */
enum front_change { FRONT_PANES, FRONT_PLAIN, FRONT_REDRAW };

/* A front end as the session sees it, copied by session_create(). Every callback may be NULL;
 * unless stated otherwise its first argument is `context`. */
struct front {
    /* A person types the commands: then beginnings of names are accepted as names, and the user is
     * asked about long runs, which are otherwise refused. */
    bool interactive;
    bool utf8;         /* The output can show UTF-8. */
    int colors;        /* Number of colours that the output can show: 0, 8 or 256. */
    bool is_terminal;  /* The output is a terminal, on which long answers scroll away. */
    int width, height; /* [cell] size of the output; 0 stands for 80x24 */
    bool input;        /* Standard input is free for data: no commands come from there. */
    const struct feed_access *feed; /* NULL if the front end reads no sensors. */
    /* Flag that Ctrl-C sets; may be NULL. */
    const struct cancel *cancel;
    void *context;
    /* Asks the user a question. Returns true for yes. */
    bool (*confirm)(void *context, const char *question);
    /* Shows the progress of a computation: a fraction from 0 to 1, < 0 if it is unknown, or > 1 to
     * erase what was shown. `run` is the run that advances, or NULL for other computations. */
    void (*progress)(void *context, const struct run *run, double fraction);
    /* Clears the screen. */
    void (*clear)(void *context);
    /* Called after each command line, also of a file, at a point where the session can be saved. */
    void (*executed)(void *context);
    /* A person watches panes. Then the commands run and continue make live runs, which advance in
     * slices of at most 10 ms and call slice() between them. */
    bool watched;
    /* Polls the terminal, executes lines that were typed during the run (by command_exec(), called
     * recursively; commands that would disturb the run are refused) and draws. Returns at
     * `deadline` [clock_ns] or earlier. Returns false if the run has to pause. */
    bool (*slice)(void *context, struct session *session, int64_t deadline);
    /* Writes the screen, as ncurses would show it, to a file (in batch with width x height).
     * Returns false with `error` set. */
    bool (*screenshot)(void *context, const struct session *session, const char *path,
                       struct write_policy policy, struct error *error);
    /* Appends the screen as lines of text, for `screenshot` without a file. Returns false with
     * `error` set. */
    bool (*screen)(void *context, const struct session *session, struct buffer *text,
                   struct error *error);
    /* Receives the table of `export -`. If this callback is NULL, the table is written to the
     * output. Returns false if out of memory. */
    bool (*table)(void *context, const struct table *table);
    /* Sets span[0] and span[1] to the times [s] at both ends of the time axis on the screen.
     * Returns false if the screen shows none. */
    bool (*time_shown)(void *context, const struct session *session, double span[2]);
    /* Shows a figure of width x height cells as pixels; if `figure` is NULL, only checks that this
     * is possible. Returns false with the reason in `error`. */
    bool (*pixels)(const struct front *front, const struct figure *figure, int width, int height,
                   struct error *error);
    /* Makes a change of the front end. Returns false with the reason in `error`. */
    bool (*change)(void *context, enum front_change change, struct error *error);
};
