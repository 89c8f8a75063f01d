/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of `collect` share. */
#ifndef HOOKE_COMMAND_DATA_COLLECT_H
#define HOOKE_COMMAND_DATA_COLLECT_H

#include "command/internal.h"

/* Something to wait for: the value passes a level. */
struct trigger {
    bool wanted;
    int direction;    /* 1 rising, -1 falling */
    struct text name; /* of the column; "y": the value */
    double level;     /* SI, or as the column has it */
    bool has_unit;
    double after; /* [s] not before */
    double t;     /* [s] where it came; NAN: not yet */
};

/* "y rising 22 cm" */
bool trigger_read(struct parser *parser, struct trigger *trigger, struct error *error);
/* Whether it is in what there is by now. */
bool trigger_look(struct trigger *trigger, const struct recording *recording);

/* What has come, for the panes and the trigger: the last lines of the file, read anew. */
struct collect_view {
    const char *path;
    const struct load_options *options;
    int fd;             /* of the file; -1: not yet opened */
    struct buffer head; /* of the file, before its first sample; empty: not yet known */
    uint64_t lines;     /* in the file when it was last read */
    int64_t due;        /* [clock_ns] not before */
    struct error problem;
};

/* NULL: nothing new, not yet, or nothing can be made of it: problem.text. */
struct recording *collect_view_read(struct collect_view *view, uint64_t lines);
void collect_view_free(struct collect_view *view);

#endif
