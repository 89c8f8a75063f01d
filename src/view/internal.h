/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations that the files of src/view share. screen.c divides the screen and calls one draw
 * function for each part; layouts.c places the panes, panes.c makes their figures, ranges.c
 * steadies their axes. */
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

/* Position and size on the screen [cell]. */
struct rectangle {
    int x, y, width, height;
};

/* ---- positions of the panes on the screen (layouts.c) ---- */

/* most panes on a screen */
#define PLACED_MAX 8

/* One pane on the screen. Panes that share a time axis are placed one above the other in one frame;
 * only the lowest has labels. */
struct placed_pane {
    enum plot_kind pane;
    struct rectangle area;
    bool open;   /* another pane continues the frame below: no time labels, no lower frame */
    bool joined; /* continues the frame of the pane above: its upper frame is a divider */
    int number;  /* written in the frame, or 0 for none */
};

/* Heights [cell] of the parts of the screen; 0 for a part that is not shown. The prompt is the last
 * row. */
struct division {
    int state, plots, log, numbers; /* [cell] */
};

/* Divides the height of the screen among its parts. */
struct division screen_division(const struct session *session, int height);
/* Places the panes of the session's layout in the area, which is as wide as the screen; height is
 * that of the screen. Returns their number. */
int screen_panes(const struct session *session, struct rectangle area, int height,
                 struct placed_pane placed[PLACED_MAX]);

/* ---- ranges.c ---- */

/* Returns true while a live run is running or paused. */
bool run_in_progress(const struct session *session);
/* Returns true if the user has set a range on a focused time plot; it holds for all panes, so that
 * they stay aligned. */
bool view_has_time_range(const struct view *view);
/* Returns true if the range was set, false if it is automatic (empty). */
bool is_range(const double range[2]);
/* Extends a time axis of `columns` cells to the next label if that is near. */
void ranges_reach_label(struct axis *axis, int columns);
/* Chooses ranges of a figure's axes that stay the same while a curve grows. Returns false if out of
 * memory. */
bool ranges_settle(struct screen *screen, const struct placed_pane *placed, struct figure *figure);

/* ---- panes.c ---- */

/* Makes the figure of each pane as it will be drawn; time plots share their time axis and the width
 * of their labels. Returns false if out of memory. */
bool panes_figures(struct screen *screen, const struct placed_pane *placed, int placed_count,
                   struct figure *figure);
/* Returns the height of the pane's figure, whose lowest rows may lie under the pane below. */
int pane_drawn_height(const struct placed_pane *placed);
/* Makes and draws all panes. Returns false if out of memory. */
bool panes_draw(struct screen *screen, const struct placed_pane *placed, int placed_count);
/* Computes the width and height of one cell in units of a pane's axes. Returns false if the pane is
 * not on the screen. */
bool panes_plane_cell(struct screen *screen, const struct placed_pane *placed, int placed_count,
                      enum plot_kind pane, double cell[2]);
/* Sets the first and the last time [s] of the focused time plot, or of the first one if none has
 * the focus. Returns its number of columns, or 0 if there is no time plot. */
int panes_time_axis(struct screen *screen, const struct placed_pane *placed, int placed_count,
                    double span[2]);

/* ---- cursors.c ---- */

/* Draws the cursors on a time plot of the given layout and area, with their letters if wanted. */
void cursors_draw(const struct screen *screen, const struct figure_layout *layout,
                  struct canvas *canvas, struct rectangle area, bool letters);
/* Draws the table of the cursors into the area of the log. */
void cursors_table(const struct screen *screen, struct rectangle area);

/* ---- one file each ---- */

/* Replaces a figure's only curve, if it is drawn as points of which two or more fall on each of the
 * `columns` of the plot, by a line with a gap wherever nothing was recorded. Leaves other figures
 * unchanged. Memory is the arena's. Returns false if out of memory. */
bool curves_join_dense(struct arena *arena, int columns, struct figure *figure);

/* Replaces names of runs in the legend by their numbers if the names do not fit into a frame of
 * width x height [cell]. */
void labels_shorten(struct screen *screen, int width, int height,
                    const struct figure_request *request, struct figure *figure);
/* Draws the line of the scene, the method and the state of the run into row y. */
void state_line_draw(const struct screen *screen, int y);
/* Draws the line of energy, its error and keys, or `hint` instead, into row y. */
void numbers_draw(const struct screen *screen, struct text hint, int y);
/* Draws the newest lines of the log, or those scrolled to, into the area. */
void log_draw(const struct screen *screen, struct rectangle area);
/* Draws the line being edited into row y and sets *cursor_x to the column of its cursor. */
void prompt_draw(const struct screen *screen, const struct prompt_line *prompt, int y,
                 int *cursor_x);

/* Draws one line of text, cut with a mark if it is wider than `width`. */
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
