/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations that the files of `collect` share: the trigger, the view of the file
 * (collect_view.c), results while it runs (collect_live.c), and the collection itself. */
#pragma once

#include "modules/collect/lines.h"
#include "modules/collect/collecting.h"
#include <hooke/command/handler.h>

#include <sys/types.h>

struct unit;

/* Trigger of a recording: the value passes a level in one direction. */
struct trigger {
    bool wanted;
    int direction;    /* 1 rising, -1 falling */
    struct text said; /* the trigger as it was typed */
    struct text name; /* name of the column; "y" is the value */
    double level;     /* level in SI units, or in the numbers of the column if `unit` is NULL */
    /* unit of the level, or NULL if the level is in the numbers of the column */
    const struct unit *unit;
    uint32_t after_line; /* line of the file behind which it is looked for */
    double t;            /* [s] time of the recording at which it came, or NAN before that */
    uint32_t line;       /* line of the file in which it came */
    double arrival;      /* [s] arrival of that line */
};

/* Reads a trigger such as "y rising 22 cm". Returns false with an error if it is malformed. */
bool trigger_read(struct parser *parser, struct trigger *trigger, struct error *error);
/* Searches the recording for the trigger and returns true if it has come. Sets error if it can
 * never come; otherwise the error's code is 0. */
bool trigger_look(struct trigger *trigger, const struct recording *recording, struct error *error);
/* Writes the range of the column if the trigger never came. */
void trigger_missed(const struct trigger *trigger, const struct recording *recording,
                    struct buffer *output);

/* View of the lines collected so far, for the panes and the trigger. Each look continues in the
 * file. */
struct collect_view {
    const char *path;
    const struct load_options *options;
    int fd;                /* descriptor of the file, or -1 before it is opened */
    struct buffer head;    /* part of the file before its first sample; empty until that is known */
    uint32_t head_lines;   /* number of lines in the head, without remarks */
    off_t offset;          /* [byte] position of the line at which the next reading begins */
    uint32_t lines_before; /* number of lines in the file before it, without remarks */
    uint64_t lines;        /* number of lines in the file when it was last read */
    int64_t due;           /* [clock_ns] earliest time of the next reading */
    uint32_t newest;       /* line of the newest row */
    double t;              /* [s] time of the newest row, by the clock of the first reading */
    /* reason why the lines cannot be read */
    struct error problem;
};

/* Returns the new rows and some before them. Returns NULL if nothing is new, if it is too early,
 * or if the lines cannot be read, with the reason in problem.text. */
struct recording *collect_view_read(struct collect_view *view, uint64_t lines);
/* Begins again at the start of the file. */
void collect_view_restart(struct collect_view *view);
/* Closes the file and frees the head. */
void collect_view_free(struct collect_view *view);

/* Results computed from time to time while lines arrive. */
struct collect_live {
    /* growth of the recording that is shown */
    struct lengthening growth;
    int64_t period_due, fit_due; /* [clock_ns] */
    struct scene laid;           /* scene of the run beside the data */
    const struct method *method;
};

/* Reason for the end: the source ended, the user stopped it, or the time limit. */
enum collect_end { END_BY_FEED, END_STOPPED, END_IN_TIME };

/* A collection in progress. */
struct collection {
    struct session *session;
    struct reply *reply;
    const char *source, *path;         /* path is that of the collected file */
    const char *from_shown, *to_shown; /* both, safe to show */
    struct load_options options;
    struct calibration calibration; /* calibration in force */
    struct text put_options;        /* options as `load` takes them */
    struct trigger trigger;
    double length, pretrigger; /* [s] length is HUGE_VAL if unlimited */
    bool again;                /* continues an existing file */
    uint32_t after_line;       /* last line of the file that is continued */
    double t_begin;            /* [s] time at which it begins */
    long baud;
    uint64_t max, there; /* limit of the number of lines, and lines of the file that is continued */
    struct collecting state;
    struct collect_view view;
    struct collect_live live;
    struct feed_look look;
    double idle, looked; /* [s] total time paused, and time of the last look */
    enum collect_end how;
    /* the user was told that nothing comes, or that nothing can be read */
    bool said_silent, said_none;
    struct error never; /* reason why the trigger cannot come; code 0 if it still can */
};

/* Returns the index of the growing recording in the session, or -1 if it is not shown. */
int collect_own_place(const struct session *session);
/* Computes the period, the fit and the overlaid scene for the data shown so far. */
void collect_find(struct collection *c, struct recording *recording);
/* Fits all collected data. */
void collect_fit_last(struct collection *c);
/* Reports the last fit. */
void collect_say_fit(const struct collection *c);
/* Frees the run beside the data and ends live fits. */
void collect_live_free(struct collection *c);
/* Appends the calibration to the file, for all of its lines. Returns false with an error if that
 * fails. */
bool collect_put_calibration(const struct collection *c, struct error *error);
/* Follows the lines until the collection ends. Returns true if Ctrl-C ended it. */
bool collect_follow(struct collection *c);
/* Turns the collected file into an ordinary recording, as `load` would read it. */
bool collect_finish(struct collection *c, const struct arguments *args, struct error *error);
