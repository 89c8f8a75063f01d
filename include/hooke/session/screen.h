/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Content of the screen: changed by commands only, drawn by the view layer. */
#pragma once

#include <hooke/base/catalog.h>
#include <hooke/base/limit.h>
#include <hooke/base/quantity.h>

enum layout {
    LAYOUT_TRIO,
    LAYOUT_DUO,
    LAYOUT_SINGLE,
    LAYOUT_STACK,
    LAYOUT_QUAD,
    LAYOUT_PLOT,
    LAYOUT_LOG
};

extern const struct catalog layout_catalog; /* struct layout_row at the enum's place */

struct layout_row {
    struct row row;
    int width, height;   /* [cell] of a screen that has room for it */
    enum layout smaller; /* drawn on another one */
};

static inline const struct layout_row *layout_row(enum layout layout)
{
    return (const struct layout_row *)(const void *)catalog_row(&layout_catalog, (size_t)layout);
}

/* Returns the layout that a screen of that size can show. */
enum layout layout_drawn(enum layout layout, int width, int height);

enum snap { SNAP_CROSSING, SNAP_PEAK, SNAP_SAMPLE, SNAP_NONE };

extern const struct catalog snap_catalog; /* struct row at the enum's place */

struct cursors {
    bool shown;      /* the two cursors stand on the plot */
    bool plane;      /* instead of them a point stands on the portrait: */
    double point[2]; /* SI, of the variables across and up */
    bool on_data;    /* they stand on the recording, else on the current run */
    int active;      /* 0: A, 1: B */
    bool locked;     /* both move together */
    struct {
        bool set;
        double t, t_uncertainty, y; /* [s] [s] SI */
        int crossing;               /* number of the up-crossing; 0 if it is not at one */
        double amplitude;           /* amplitude of the motion there; NAN if not known */
    } cursor[2];
    enum snap snap;
    double periods; /* number of periods between A and B; NAN if not known */
    /* name of what the cursors stand on, such as "run 2" or "data swing3" */
    char subject[LIMIT_NAME + 16];
    size_t samples;         /* it had then */
    enum quantity quantity; /* quantity of y */
};

#define LIMIT_STARTS 16
#define STARTS_VARIABLES 7 /* Largest number of variables of a scene that has a portrait. */

struct view {
    enum layout layout;
    /* Pane of plot_catalog that commands and zooming act on; NULL for the position. */
    const struct row *focus;
    bool full;         /* the focused pane alone */
    double x[2], y[2]; /* fixed ranges of the focused pane (time [s], SI); NAN for automatic */
    double window;     /* [s] of time shown; 0 for automatic */
    double trail;      /* periods of the phase trail; HUGE_VAL for all */
    int scroll;        /* rows the log is scrolled up */
    bool reading;      /* the log has the whole screen */
    int found;         /* line that was found last, from the newest */
    char wanted[LIMIT_NAME + 1]; /* text that was searched for */
    /* topic of help that was shown by the last line; NULL if there is none */
    const char *recipe;
    bool paging; /* the live view sweeps, then pages; otherwise it scrolls by whole cells */
    /* numbers of the runs drawn besides the present one; those that are gone are passed over */
    int overlay[LIMIT_OVERLAY];
    int overlays;
    struct cursors cursors;
    /* [starts] where trajectories of the portrait begin, of scenes with start_n variables, SI */
    double start[LIMIT_STARTS][STARTS_VARIABLES];
    int starts, start_n;
};

/* The last lines that commands said, for the log pane. A ring: line `first` is the oldest. */
struct log {
    /* [LIMIT_LOG], allocated when the first line comes; each made safe, without newline */
    char **line;
    int first, count;
    uint64_t said; /* lines, also those that are gone */
};

/* one or more lines; without memory they are dropped */
void log_add(struct log *log, struct text text);
const char *log_line(const struct log *log, int i); /* i = 0: the newest */
/*
 * The row of a line that begins at byte *offset, as it stands in a pane of that width [cell]: whole
 * words, unless one is longer than a row. *indent [cell] goes before it; 0 in the first row.
 * *offset is then where the next row begins: line.len after the last.
 */
struct text log_row(struct text line, size_t *offset, int width, int *indent);
int log_rows(struct text line, int width); /* number of rows that the line takes, at least 1 */
/* Returns the number of rows of the newest `lines` lines. */
int log_rows_newest(const struct log *log, int lines, int width);
void log_clear(struct log *log);
