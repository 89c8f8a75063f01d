/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of `collect` share. */
#pragma once

#include "modules/collect/lines.h"
#include "modules/collect/collecting.h"
#include <hooke/command/handler.h>

#include <sys/types.h>

struct unit;

/* Something to wait for: the value passes a level. */
struct trigger {
    bool wanted;
    int direction;           /* 1 rising, -1 falling */
    struct text said;        /* all of it, as it was typed */
    struct text name;        /* of the column; "y": the value */
    double level;            /* SI, or as the column has it */
    const struct unit *unit; /* NULL: none, the level is as the column has its numbers */
    uint32_t after_line;     /* line of the file: not before */
    double t;                /* [s] of the recording, where it came; NAN: not yet */
    uint32_t line;           /* of the file, where it came */
    double arrival;          /* [s] of that line, by the clock of the arrivals */
};

/* "y rising 22 cm" */
bool trigger_read(struct parser *parser, struct trigger *trigger, struct error *error);
/* Whether it is in what there is by now; the error says why it never can be (code 0: it can). */
bool trigger_look(struct trigger *trigger, const struct recording *recording, struct error *error);
/* What was waited for in vain: between which numbers the column was. */
void trigger_missed(const struct trigger *trigger, const struct recording *recording,
                    struct buffer *output);

/* What has come, for the panes and the trigger: each look reads on in the file. */
struct collect_view {
    const char *path;
    const struct load_options *options;
    int fd;                /* of the file; -1: not yet opened */
    struct buffer head;    /* of the file, before its first sample; empty: not yet known */
    uint32_t head_lines;   /* in it, without remarks */
    off_t offset;          /* the line at which the next look begins … */
    uint32_t lines_before; /* … and lines in the file before it, without remarks */
    uint64_t lines;        /* in the file when it was last read */
    int64_t due;           /* [clock_ns] not before */
    uint32_t newest;       /* line of the newest row … */
    double t;              /* [s] … and its time, by the clock of the first look */
    struct error problem;
};

/* The new rows and some before them. NULL: nothing new, not yet, or nothing can be made of it:
 * problem.text. */
struct recording *collect_view_read(struct collect_view *view, uint64_t lines);
void collect_view_restart(struct collect_view *view); /* from the beginning of the file */
void collect_view_free(struct collect_view *view);

/* What is found of the lines while they come, each now and then. */
struct collect_live {
    struct lengthening growth;
    int64_t period_due, fit_due; /* [clock_ns] */
    struct scene laid;           /* that the model is of */
    const struct method *method;
};

enum collect_end { END_BY_FEED, END_STOPPED, END_IN_TIME };

/* One that is under way. */
struct collection {
    struct session *session;
    struct reply *reply;
    const char *source, *path;         /* path: of its file */
    const char *from_shown, *to_shown; /* both, safe to show */
    struct load_options options;
    struct calibration calibration; /* in force */
    struct text put_options;        /* as they stand behind load */
    struct trigger trigger;
    double length, pretrigger; /* [s] HUGE_VAL: no end */
    bool again;                /* goes on with a file there is … */
    uint32_t after_line;       /* … behind that line */
    double t_begin;            /* [s] its time goes on from there */
    long baud;
    uint64_t max, there; /* lines; that were there before */
    struct collecting state;
    struct collect_view view;
    struct collect_live live;
    struct feed_look look;
    double idle, looked; /* [s] paused by now; of the last look */
    enum collect_end how;
    bool said_silent, said_none;
    struct error never; /* why the trigger cannot come; code 0: it can */
};

/* Its place among the recordings while it grows; -1 if it is not shown. */
int collect_own_place(const struct session *session);
/* Of what is shown by now: period, fit, the scene laid over it. */
void collect_find(struct collection *c, struct recording *recording);
/* Of all that came. */
void collect_fit_last(struct collection *c);
/* What the last fit was. */
void collect_say_fit(const struct collection *c);
void collect_live_free(struct collection *c);
/* Into the file, where it counts from its beginning. */
bool collect_put_calibration(const struct collection *c, struct error *error);
/* Until it ends; true: by a Ctrl-C. */
bool collect_follow(struct collection *c);
/* What was collected becomes a recording as any other, which `load` gives again. */
bool collect_finish(struct collection *c, const struct arguments *args, struct error *error);
