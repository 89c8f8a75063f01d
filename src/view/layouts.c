/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Layouts of the screen: how the height is divided among its parts, and which panes are placed
 * where. A layout is a row of a table. */
#include <hooke/plot.h>
#include "view/internal.h"

/* frame, axis with labels, and four rows of curve; the log is reduced to one row before plots
 * become lower */
#define PLOT_ROWS 8
#define SHARED_ROWS 3  /* axis, labels and lower frame of panes that share them */
#define CURVE_ROWS 3   /* smallest number of rows of curve in each of these panes */
#define PHASE_MIN 24   /* [cell] */
#define PHASE_LABELS 7 /* [cell] frame and labels of the phase plot beside its square */

/*
 * Divides the height. If it shrinks, the parts give way in this order (INTERFACE.md, section 6):
 * the numbers line, the rows of the log but one, then the plots lose labels and frame by
 * themselves; at last only the prompt is left.
 */
struct division screen_division(const struct session *session, int height)
{
    enum layout layout = session->view.layout;
    struct division d = {.state = height >= 3, .numbers = height >= PLOT_ROWS + 4};
    int rest = larger(height - 1 - d.state - d.numbers, 0);

    if (session->view.reading)
        return (struct division){.log = larger(height - 1, 0)};
    if (layout == LAYOUT_LOG || height < 4)
        d.log = rest;
    else if (layout != LAYOUT_PLOT || session->view.cursors.shown)
        d.log = larger(smaller(height / 4, rest - PLOT_ROWS), 1);
    d.plots = layout == LAYOUT_LOG || height < 4 ? 0 : rest - d.log;
    return d;
}

/* Panes of a layout, in a left and a right column. */
struct arrangement {
    bool shared; /* panes of the left column share one time axis */
    /* panes have a number in their frame */
    bool numbered;
    /* height of the left column's first pane, in units of the height of each other pane */
    int first;
    int lefts, rights;
    enum plot_kind left[3], right[2];
};

static const struct arrangement arrangements[] = {
    [LAYOUT_SINGLE] = {.first = 1, .lefts = 1, .left = {PLOT_POSITION}},
    [LAYOUT_DUO] =
        {.first = 1, .lefts = 1, .left = {PLOT_POSITION}, .rights = 1, .right = {PLOT_PHASE}},
    [LAYOUT_TRIO] = {.shared = true,
                     .first = 2,
                     .lefts = 2,
                     .left = {PLOT_POSITION, PLOT_ENERGY},
                     .rights = 1,
                     .right = {PLOT_PHASE}},
    [LAYOUT_STACK] = {.shared = true,
                      .first = 1,
                      .lefts = 3,
                      .left = {PLOT_POSITION, PLOT_VELOCITY, PLOT_ENERGY}},
    [LAYOUT_QUAD] = {.numbered = true,
                     .first = 1,
                     .lefts = 2,
                     .left = {PLOT_POSITION, PLOT_VELOCITY},
                     .rights = 2,
                     .right = {PLOT_PHASE, PLOT_ENERGY}},
    [LAYOUT_PLOT] = {.first = 1, .lefts = 1, .left = {PLOT_POSITION}},
    [LAYOUT_LOG] = {.first = 1},
};

/* Chooses those of the wanted panes for which the session has something to show. A phase plot
 * becomes an orbit if there is one, unless the phase plot has the focus. Returns their number. */
static int choose_panes(const struct session *session, const enum plot_kind *wanted, int count,
                        enum plot_kind *chosen)
{
    const bool orbit =
        plot_offered(session, PLOT_ORBIT) && view_focus(&session->view) != PLOT_PHASE;
    int n = 0;
    for (int i = 0; i < count; i++)
        if (plot_offered(session, wanted[i]))
            chosen[n++] = wanted[i] == PLOT_PHASE && orbit ? PLOT_ORBIT : wanted[i];
    return n;
}

/* Returns true if a plot is among the panes. */
static bool panes_include(const enum plot_kind *pane, int count, enum plot_kind wanted)
{
    for (int i = 0; i < count; i++)
        if (pane[i] == wanted)
            return true;
    return false;
}

/* Stacks panes in one column from top to bottom; those for which there is no height are left out.
 * Returns the number placed. */
static int stack_column(struct rectangle area, const struct arrangement *a,
                        const enum plot_kind *pane, int count, struct placed_pane *placed)
{
    bool shared = a->shared;
    for (int i = 0; i < count; i++)
        shared &= plot_is_timed(pane[i]);
    int each = shared ? CURVE_ROWS + 1 : PLOT_ROWS;
    int common = shared ? SHARED_ROWS : 0;
    while (count > 1 && area.height < count * each + common)
        count--;
    int fractions = a->first + count - 1, frames = shared ? count : 0,
        rows = area.height - common - frames, y = area.y;
    for (int i = 0; i < count; i++) {
        bool last = i == count - 1;
        /* rows that remain if each pane below gets its minimum */
        int max = rows - (y - area.y - (shared ? i : 0)) - CURVE_ROWS * (count - 1 - i);
        int fraction = smaller((rows * (i ? 1 : a->first) + fractions / 2) / fractions, max);
        /* The upper one of two panes without a shared axis is a little higher: 15 and 12 of 27
         * rows. */
        int height = shared ? fraction + 1 : (area.height * 5 + 4) / 9;
        if (last)
            height = area.y + area.height - y;
        placed[i] = (struct placed_pane){.pane = pane[i],
                                         .area = {area.x, y, area.width, height},
                                         .open = shared && !last,
                                         .joined = shared && i > 0};
        y += height;
    }
    return count;
}

/* Returns the width of the right column: a phase plot alone in it is about square, with twice as
 * many columns as rows. */
static int right_width(const struct arrangement *a, const enum plot_kind *right, int rights,
                       struct rectangle area)
{
    int max = area.width * 2 / 5, square = 2 * (area.height - SHARED_ROWS - 1) + PHASE_LABELS;
    if (a->numbered || !plot_is_plane(right[0]) || rights > 1)
        return max;
    return larger(smaller(square, max), PHASE_MIN);
}

/* Places the panes of the layout. Plots that the session cannot show are left out; the focused plot
 * replaces the first one if the layout does not contain it. */
int screen_panes(const struct session *session, struct rectangle area, int height,
                 struct placed_pane placed[PLACED_MAX])
{
    const struct view *view = &session->view;
    const enum layout layout =
        layout_drawn(view->full ? LAYOUT_SINGLE : view->layout, area.width, height);
    const struct arrangement *a = &arrangements[layout];

    enum plot_kind left[3], right[2];
    int lefts = choose_panes(session, a->left, a->lefts, left),
        rights = choose_panes(session, a->right, a->rights, right);
    if (!lefts && !rights)
        left[lefts++] = PLOT_POSITION;
    enum plot_kind *const main_column = lefts ? left : right;
    if (session_charset(session)->words) { /* screen readers read line by line */
        if (plot_offered(session, view_focus(view)))
            *main_column = view_focus(view);
        placed[0] = (struct placed_pane){.pane = *main_column, .area = area};
        return 1;
    }
    /* The focused plot is always shown. */
    if (plot_offered(session, view_focus(view)) && !panes_include(left, lefts, view_focus(view)) &&
        !panes_include(right, rights, view_focus(view)))
        *main_column = view_focus(view);
    if (!lefts || !rights) {
        int n = stack_column(area, a, main_column, lefts + rights, placed);
        for (int i = 0; i < n && a->numbered; i++)
            placed[i].number = i + 1;
        return n;
    }
    int width = right_width(a, right, rights, area);
    struct rectangle sides[2] = {{area.x, area.y, area.width - width, area.height},
                                 {area.x + area.width - width, area.y, width, area.height}};
    int n = stack_column(sides[0], a, left, lefts, placed),
        all = n + stack_column(sides[1], a, right, rights, placed + n);
    for (int i = 0; i < all && a->numbered; i++) /* numbers go row by row */
        placed[i].number = i < n ? 2 * i + 1 : 2 * (i - n) + 2;
    return all;
}
