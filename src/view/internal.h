/* SPDX-License-Identifier: GPL-3.0-or-later */
/* view: what its files share. */
#pragma once

#include <hooke/view.h>
#include <hooke/plot.h>

/* One screen being drawn. */
struct screen {
    const struct session *session;
    struct canvas *canvas;
    const struct charset *charset;
    struct arena arena; /* memory of this frame */
};

struct rectangle {
    int x, y, width, height;
};

/* ---- positions of the panes on the screen (layouts.c) ---- */

#define PLACED_MAX 8

/* One pane on the screen. Panes that share a time axis stand over each other in one frame; only the
 * last of them has labels below. */
struct placed_pane {
    enum plot_kind pane;
    struct rectangle area;
    bool open;   /* continues in the place below: no time labels, no lower frame */
    bool joined; /* continues the place above: its upper frame is a divider */
    int number;  /* written in the frame; 0 if there is none */
};

/* Heights [cell] of the parts of the screen; 0 for a part that is not shown. The prompt is the last
 * row. */
struct division {
    int state, plots, log, numbers; /* [cell] */
};

struct division screen_division(const struct session *session, int height);
/* The area is as wide as the screen, which has `height` rows. */
int screen_panes(const struct session *session, struct rectangle area, int height,
                 struct placed_pane placed[PLACED_MAX]);

/* ---- ranges.c ---- */

bool run_in_progress(const struct session *session);
/* The horizontal range of a focused time plot holds for all panes, so that they stay aligned. */
bool view_has_time_range(const struct view *view);
/* Moves the end of a time axis of so many cells to the next label where that is near. */
bool is_range(const double range[2]); /* not automatic */
void ranges_reach_label(struct axis *axis, int columns);
/* Returns false if out of memory */
bool ranges_settle(struct screen *screen, const struct placed_pane *placed, struct figure *figure);

/* ---- panes.c ---- */

/* One figure for each place, all time plots with the same time axis, as they will be drawn; returns
 * false if out of memory. */
bool panes_figures(struct screen *screen, const struct placed_pane *placed, int placed_count,
                   struct figure *figure);
/* Returns the height of the pane's figure, whose lowest rows may lie under the pane below. */
int pane_drawn_height(const struct placed_pane *placed);
/* Returns false if out of memory */
bool panes_draw(struct screen *screen, const struct placed_pane *placed, int placed_count);
/* Finds the coordinates of a cell on the axes of the pane, across and up; returns false if it is
 * not on the screen. */
bool panes_plane_cell(struct screen *screen, const struct placed_pane *placed, int placed_count,
                      enum plot_kind pane, double cell[2]);
/* [s] from, to of the time axis of the focused time plot, else of the first. Returns its columns, 0
 * if there is none. */
int panes_time_axis(struct screen *screen, const struct placed_pane *placed, int placed_count,
                    double span[2]);

/* ---- cursors.c ---- */

void cursors_draw(const struct screen *screen, const struct figure_layout *layout,
                  struct canvas *canvas, struct rectangle area, bool letters);
void cursors_table(const struct screen *screen, struct rectangle area);

/* ---- one file each ---- */

/* A curve of marks alone, too many for so many columns, becomes a line with gaps; returns false if
 * out of memory. */
bool curves_join_dense(struct arena *arena, int columns, struct figure *figure);

/* Run numbers instead of names where those do not fit into the frame of width x height [cell]. */
void labels_shorten(struct screen *screen, int width, int height,
                    const struct figure_request *request, struct figure *figure);
void state_line_draw(const struct screen *screen, int y);
void numbers_draw(const struct screen *screen, struct text hint, int y);
void log_draw(const struct screen *screen, struct rectangle area);
void prompt_draw(const struct screen *screen, const struct prompt_line *prompt, int y,
                 int *cursor_x);

/* One line of text, cut with a mark where it is longer than the width. */
void line_draw(const struct screen *screen, int x, int y, int width, struct text text,
               enum style style);

static inline int larger(int a, int b)
{
    return a > b ? a : b;
}

static inline int smaller(int a, int b)
{
    return a < b ? a : b;
}
