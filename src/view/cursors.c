/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the two cursors: as lines on the time plots, and as the table of what they measure, which
 * replaces the log while they are shown. */
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <hooke/plot.h>
#include "view/internal.h"

#include <stdio.h>

/* lines of the table */
#define TABLE_ROWS 6
/* Width [cell] from which the pane also names the curve that the cursors snap to. */
#define CURSOR_DETAILS_WIDTH 54

/* Returns true if a cell of the frame has no text, so that a letter can be written there. */
static bool is_bare_frame(const struct screen *screen, const struct canvas *canvas, int x, int y)
{
    return canvas->cell[(size_t)y * (size_t)canvas->width + (size_t)x].codepoint ==
           (screen->charset->plain ? '-' : 0x2500);
}

/* Draws the cursors of the session on a time plot: dotted lines behind the curve and, if wanted,
 * their letters on the upper frame. */
void cursors_draw(const struct screen *screen, const struct figure_layout *layout,
                  struct canvas *canvas, struct rectangle area, bool letters)
{
    const struct cursors *cursors = &screen->session->view.cursors;
    uint32_t line = screen->charset->plain ? ':' : 0x250A;
    int column, row;

    for (int i = 0; i < 2 && cursors->shown && !cursors->plane; i++) {
        if (!cursors->cursor[i].set ||
            !figure_cell(layout, cursors->cursor[i].t, layout->y.first_value, &column, &row))
            continue;
        int x = area.x + layout->left + column, y = area.y + layout->top;
        for (row = 0; row < layout->rows; row++) { /* cells of a curve are not overwritten */
            const struct cell *cell =
                &canvas->cell[(size_t)(y + row) * (size_t)canvas->width + (size_t)x];
            if (cell->codepoint == ' ' || cell->style == STYLE_DIM)
                canvas_put(canvas, x, y + row, line, i == cursors->active ? STYLE_BOLD : STYLE_DIM);
        }
        if (letters)
            canvas_put(canvas, x, is_bare_frame(screen, canvas, x, area.y) ? area.y : y,
                       (uint32_t) "AB"[i], STYLE_BOLD);
    }
}

/* Appends the line of cursor i (0 is A, 1 is B): its time, the value there and, if it is at one,
 * the number of the crossing, else the amplitude beside it. */
static void put_cursor(struct buffer *output, const struct cursors *cursors, int i)
{
    buffer_format(output, "%s%c  ", i == cursors->active ? ">" : " ", "AB"[i]);
    if (!cursors->cursor[i].set) {
        buffer_put(output, TEXT("not set"));
        return;
    }
    const struct unit *unit = unit_display(
        cursors->quantity, fmax(cursors->cursor[i].amplitude, fabs(cursors->cursor[i].y)));
    buffer_put(output, TEXT("t = "));
    buffer_parenthesis(output, cursors->cursor[i].t, cursors->cursor[i].t_uncertainty);
    /* never -0.00 */
    double y = floor(cursors->cursor[i].y / (unit ? unit->factor : 1) * 100 + 0.5) / 100 + 0.0;
    buffer_format(output, " s   y = %.2f %s", y,
                  unit ? unit->row.name : quantity_unit(cursors->quantity));
    if (cursors->cursor[i].crossing > 0)
        buffer_format(output, "  up-crossing #%d", cursors->cursor[i].crossing);
    /* A cursor beside a crossing shows the amplitude there. */
    else if (isfinite(cursors->cursor[i].amplitude)) {
        const double factor = unit ? unit->factor : 1;
        buffer_format(output, "  amplitude %.2f %s", cursors->cursor[i].amplitude / factor,
                      unit ? unit->row.name : quantity_unit(cursors->quantity));
    }
}

/* Appends the time between the cursors and, if periods lie between them, period and frequency. */
static void put_interval(struct buffer *output, const struct cursor_reading *reading)
{
    buffer_format(output, " B-A = %.4f s", reading->dt);
    if (!isfinite(reading->period.value))
        return;
    buffer_format(output, " / %.6g period%s   T = ", reading->periods,
                  reading->periods == 1 ? "" : "s");
    buffer_parenthesis(output, reading->period.value, reading->period.uncertainty);
    buffer_put(output, TEXT(" s   f = "));
    buffer_parenthesis(output, reading->frequency.value, reading->frequency.uncertainty);
    buffer_put(output, TEXT(" Hz"));
}

/* Appends the period that the scene predicts, the deviation from it, decrement and Q, as far as
 * they are known. */
static void put_theory(struct buffer *output, const struct cursor_reading *reading)
{
    const char *name = reading->theory_name;
    if (isfinite(reading->theory))
        buffer_format(output, " theory %s = %.4f s", name, reading->theory);
    if (isfinite(reading->deviation))
        buffer_format(output, "  (T-%s)/%s = %+.2g %%", name, name, reading->deviation * 100);
    if (isfinite(reading->quality))
        buffer_format(output, "   log decrement %.3g  Q = %.3g", reading->decrement,
                      reading->quality);
}

/* Draws the table below a portrait for the point that the user moves on it: its state and the keys
 * that move it. */
static void plane_table(const struct screen *screen, struct rectangle area)
{
    struct buffer said = {0};
    cursor_plane_lines(screen->session, &said);
    const struct text lines[] = {
        TEXT(" arrows move   n/N next/previous equilibrium   Enter a trajectory from here"),
        TEXT(" x start clear   : a command   q leave   ? help   PgUp log")};
    struct text rest = buffer_text(&said), line;
    int y = 0;
    for (; y < area.height && text_split(&rest, '\n', &line); y++)
        line_draw(screen, area.x + 1, area.y + y, area.width - 1, line,
                  y ? STYLE_PLAIN : STYLE_BOLD);
    for (size_t i = 0; i < COUNT_OF(lines) && y < area.height; i++)
        line_draw(screen, area.x, area.y + y++, area.width, lines[i], STYLE_DIM);
    buffer_free(&said);
}

/* Draws the table of the two cursors, or of the point on a portrait, into the area of the log. */
void cursors_table(const struct screen *screen, struct rectangle area)
{
    const struct session *session = screen->session;
    const struct cursors *cursors = &session->view.cursors;
    struct buffer line[TABLE_ROWS] = {{0}};
    if (cursors->plane) {
        plane_table(screen, area);
        return;
    }
    /* The most important rows come first; the last ones are left out if there is no room. */
    static const int order[TABLE_ROWS] = {2, 0, 1, 3, 4, 5};
    bool shown[TABLE_ROWS] = {false};

    struct cursor_reading reading;
    put_cursor(&line[0], cursors, 0);
    put_cursor(&line[1], cursors, 1);
    if (session_cursor_reading(session, &reading)) {
        put_interval(&line[2], &reading);
        put_theory(&line[3], &reading);
    }
    buffer_put(&line[4],
               TEXT(" </> move  n/N next/prev crossing  +/- periods  Tab A<->B  s snap  l lock"));
    buffer_put(&line[5],
               TEXT(" Enter keep as measurement  z zoom  e export  q leave  ? help  PgUp log"));
    for (int i = 0; i < smaller(area.height, TABLE_ROWS); i++)
        shown[order[i]] = true;
    int side_x =
        larger(CURSOR_DETAILS_WIDTH,
               larger(text_width(buffer_text(&line[0])), text_width(buffer_text(&line[1]))) + 2);
    for (int i = 0, y = area.y; i < TABLE_ROWS; i++) {
        if (shown[i]) {
            enum style style;
            if (i == cursors->active)
                style = STYLE_BOLD;
            else
                style = i < 4 ? STYLE_PLAIN : STYLE_DIM;
            line_draw(screen, area.x, y++, area.width, buffer_text(&line[i]), style);
        }
        buffer_free(&line[i]);
    }
    char side[2][LIMIT_NAME + 32];
    snprintf(side[0], sizeof side[0], "snap: %s%s",
             catalog_row(&snap_catalog, (size_t)cursors->snap)->name,
             cursors->locked ? ", locked" : "");
    snprintf(side[1], sizeof side[1], "on: %s", cursors->subject);
    for (int i = 0; i < 2 && area.height > 2 && area.width >= side_x + 10; i++)
        line_draw(screen, area.x + side_x, area.y + i, area.width - side_x, text_of(side[i]),
                  STYLE_PLAIN);
}
