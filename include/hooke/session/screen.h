/* SPDX-License-Identifier: GPL-3.0-or-later */
/* screen: what the screen of a session shows: layout, ranges, cursors, the lines of the log.
 * Changed by commands only, and drawn by the view layer. */
#pragma once

#include <hooke/base/catalog.h>
#include <hooke/base/limit.h>
#include <hooke/base/quantity.h>

/* Arrangement of the panes; the rows of layout_catalog describe them. */
enum layout {
    LAYOUT_TRIO,
    LAYOUT_DUO,
    LAYOUT_SINGLE,
    LAYOUT_STACK,
    LAYOUT_QUAD,
    LAYOUT_PLOT,
    LAYOUT_LOG
};

/* Layouts, struct layout_row at the index of the enum. */
extern const struct catalog layout_catalog;

/* A layout. */
struct layout_row {
    struct row row;
    int width, height;   /* [cell] smallest screen with room for it */
    enum layout smaller; /* Layout that is drawn instead on a screen that is smaller than this. */
};

/* Returns the row of a layout. */
static inline const struct layout_row *layout_row(enum layout layout)
{
    return (const struct layout_row *)(const void *)catalog_row(&layout_catalog, (size_t)layout);
}

/* Returns the layout that is drawn on a screen of this size [cell]. */
enum layout layout_drawn(enum layout layout, int width, int height);

/* Points to which cursors snap: zero crossings, peaks, samples, or none. */
enum snap { SNAP_CROSSING, SNAP_PEAK, SNAP_SAMPLE, SNAP_NONE };

/* Names of the points, struct row at the index of the enum. */
extern const struct catalog snap_catalog;

/* The two cursors A and B on the time plot, or a point on the portrait. */
struct cursors {
    bool shown;      /* The two cursors are on the plot. */
    bool plane;      /* A point is on the portrait instead. */
    double point[2]; /* Values [SI] of the horizontal and vertical variable at that point. */
    bool on_data;    /* The cursors are on the current recording; otherwise on the current run. */
    int active;      /* Cursor that keys move, 0 for A, 1 for B. */
    bool locked;     /* Both cursors move together. */
    struct {
        bool set;                   /* The user has placed the cursor. */
        double t, t_uncertainty, y; /* Time [s], its uncertainty [s], and value [SI]. */
        /* Number of the upward zero crossing at which the cursor is, 0 if it is at none. */
        int crossing;
        double amplitude; /* Amplitude of the motion at the cursor, NAN if unknown. */
    } cursor[2];
    enum snap snap;
    double periods; /* Number of periods between A and B, NAN if unknown. */
    /* Name of the run or recording on which the cursors are: "run 2", "data swing3". */
    char subject[LIMIT_NAME + 16];
    size_t samples;         /* Number of samples of the subject when the cursors were placed. */
    enum quantity quantity; /* Quantity of y. */
};

/* Largest number of trajectories that a portrait shows. */
#define LIMIT_STARTS 16
/* Largest number of variables of a scene that has a portrait. */
#define STARTS_VARIABLES 7

/* Content of the panes. */
struct view {
    enum layout layout;
    /* Pane (row of plot_catalog) on which commands and zooming act; NULL for the position. */
    const struct row *focus;
    bool full; /* The focused pane fills the screen. */
    /* Fixed ranges of the focused pane (time [s], values [SI]); NAN for automatic. */
    double x[2], y[2];
    double window; /* [s] span of the time axis; 0 for automatic */
    double trail;  /* Number of periods of the phase plot; HUGE_VAL for all. */
    int scroll;    /* Number of rows by which the log is scrolled back from its end. */
    bool reading;  /* The log fills the screen. */
    /* Index of the log line at which the last search stopped; 0 is the newest line. */
    int found;
    char wanted[LIMIT_NAME + 1]; /* Text of the last search in the log. */
    /* Recipe that the last command has shown, which the key ! executes; NULL if there is none. */
    const char *recipe;
    /* The plot of a live run fills, then begins with an empty page; otherwise it scrolls by whole
     * cells. */
    bool paging;
    /* [overlays] numbers of the runs drawn beside the current one; those that do not exist are
     * ignored. */
    int overlay[LIMIT_OVERLAY];
    int overlays;
    struct cursors cursors;
    /* [starts] states [SI] at which trajectories of the portrait begin, for scenes with start_n
     * variables. */
    double start[LIMIT_STARTS][STARTS_VARIABLES];
    int starts, start_n;
};

/* The last lines of output, for the log pane: a ring whose oldest line is `first`. */
struct log {
    /* [LIMIT_LOG] lines without newline and control characters, owned; allocated with the first
     * line. */
    char **line;
    int first, count; /* Index of the oldest line, and number of lines. */
    uint64_t said;    /* Number of lines added so far, including those that were dropped. */
};

/* Adds one or more lines; they are dropped if out of memory. */
void log_add(struct log *log, struct text text);
/* Returns line i, counted from the newest (i = 0), or NULL if there is none. */
const char *log_line(const struct log *log, int i);
/* Returns the row of a line that begins at byte *offset, as a pane of `width` cells shows it: whole
 * words, unless a word is longer than a row. Sets *indent to the number of blanks shown before it,
 * 0 in the first row, and moves *offset to the beginning of the next row, or to line.len after the
 * last one. */
struct text log_row(struct text line, size_t *offset, int width, int *indent);
/* Returns the number of rows, at least 1, that a line needs in a pane of `width` cells. */
int log_rows(struct text line, int width);
/* Returns the number of rows that the newest `lines` lines need in a pane of `width` cells. */
int log_rows_newest(const struct log *log, int lines, int width);
/* Frees all lines. */
void log_clear(struct log *log);
