/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The two cursors: lines on the time plots, and the table of what they measure in place of the log.
 */
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <hooke/plot.h>
#include "view/internal.h"

#include <stdio.h>

#define TABLE_ROWS 6
/* Width [cell] from which the pane also names the curve that the cursors snap to. */
#define CURSOR_DETAILS_WIDTH 54

/* A piece of the frame without writing, where a letter can stand. */
static bool is_bare_frame(const struct screen *screen, const struct canvas *canvas, int x, int y)
{
    return canvas->cell[(size_t)y * (size_t)canvas->width + (size_t)x].codepoint ==
           (screen->charset->plain ? '-' : 0x2500);
}

void cursors_draw(const struct screen *screen, const struct figure_layout *layout,
                  struct canvas *canvas, struct rectangle at, bool letters)
{
    const struct cursors *cursors = &screen->session->view.cursors;
    uint32_t line = screen->charset->plain ? ':' : 0x250A;
    int column, row;

    for (int i = 0; i < 2 && cursors->shown && !cursors->plane; i++) {
        if (!cursors->at[i].set ||
            !figure_cell(layout, cursors->at[i].t, layout->y.from, &column, &row))
            continue;
        int x = at.x + layout->left + column, y = at.y + layout->top;
        for (row = 0; row < layout->rows; row++) { /* the curve stays in front */
            const struct cell *cell =
                &canvas->cell[(size_t)(y + row) * (size_t)canvas->width + (size_t)x];
            if (cell->codepoint == ' ' || cell->style == STYLE_DIM)
                canvas_put(canvas, x, y + row, line, i == cursors->active ? STYLE_BOLD : STYLE_DIM);
        }
        if (letters)
            canvas_put(canvas, x, is_bare_frame(screen, canvas, x, at.y) ? at.y : y,
                       (uint32_t) "AB"[i], STYLE_BOLD);
    }
}

static void put_cursor(struct buffer *out, const struct cursors *cursors, int i)
{
    buffer_format(out, "%s%c  ", i == cursors->active ? ">" : " ", "AB"[i]);
    if (!cursors->at[i].set) {
        buffer_put(out, TEXT("not set"));
        return;
    }
    const struct unit *unit =
        unit_display(cursors->quantity, fmax(cursors->at[i].amplitude, fabs(cursors->at[i].y)));
    buffer_put(out, TEXT("t = "));
    buffer_parenthesis(out, cursors->at[i].t, cursors->at[i].t_uncertainty);
    /* never -0.00 */
    double y = floor(cursors->at[i].y / (unit ? unit->factor : 1) * 100 + 0.5) / 100 + 0.0;
    buffer_format(out, " s   y = %.2f %s", y,
                  unit ? unit->row.name : quantity_unit(cursors->quantity));
    if (cursors->at[i].crossing > 0)
        buffer_format(out, "  up-crossing #%d", cursors->at[i].crossing);
    /* the portrait sheet shows the amplitude here */
    else if (isfinite(cursors->at[i].amplitude))
        buffer_format(out, "  amplitude %.2f %s",
                      cursors->at[i].amplitude / (unit ? unit->factor : 1),
                      unit ? unit->row.name : quantity_unit(cursors->quantity));
}

static void put_interval(struct buffer *out, const struct cursor_reading *reading)
{
    buffer_format(out, " B-A = %.4f s", reading->dt);
    if (!isfinite(reading->period.value))
        return;
    buffer_format(out, " / %.6g period%s   T = ", reading->periods,
                  reading->periods == 1 ? "" : "s");
    buffer_parenthesis(out, reading->period.value, reading->period.uncertainty);
    buffer_put(out, TEXT(" s   f = "));
    buffer_parenthesis(out, reading->frequency.value, reading->frequency.uncertainty);
    buffer_put(out, TEXT(" Hz"));
}

static void put_theory(struct buffer *out, const struct cursor_reading *reading)
{
    const char *name = reading->theory_name;
    if (isfinite(reading->theory))
        buffer_format(out, " theory %s = %.4f s", name, reading->theory);
    if (isfinite(reading->deviation))
        buffer_format(out, "  (T-%s)/%s = %+.2g %%", name, name, reading->deviation * 100);
    if (isfinite(reading->quality))
        buffer_format(out, "   log decrement %.3g  Q = %.3g", reading->decrement, reading->quality);
}

/* Draws the table of the point on a portrait. */
static void plane_table(const struct screen *screen, struct rectangle at)
{
    struct buffer said = {0};
    cursor_plane_lines(screen->session, &said);
    const struct text lines[] = {
        TEXT(" arrows move   n/N next/previous equilibrium   Enter a trajectory from here"),
        TEXT(" x start clear   : a command   q leave   ? help   PgUp log")};
    struct text rest = buffer_text(&said), line;
    int y = 0;
    for (; y < at.height && text_split(&rest, '\n', &line); y++)
        line_draw(screen, at.x + 1, at.y + y, at.width - 1, line, y ? STYLE_PLAIN : STYLE_BOLD);
    for (size_t i = 0; i < COUNT_OF(lines) && y < at.height; i++)
        line_draw(screen, at.x, at.y + y++, at.width, lines[i], STYLE_DIM);
    buffer_free(&said);
}

void cursors_table(const struct screen *screen, struct rectangle at)
{
    const struct session *session = screen->session;
    const struct cursors *cursors = &session->view.cursors;
    struct buffer line[TABLE_ROWS] = {{0}};
    if (cursors->plane) {
        plane_table(screen, at);
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
    for (int i = 0; i < smaller(at.height, TABLE_ROWS); i++)
        shown[order[i]] = true;
    int side_x =
        larger(CURSOR_DETAILS_WIDTH,
               larger(text_width(buffer_text(&line[0])), text_width(buffer_text(&line[1]))) + 2);
    for (int i = 0, y = at.y; i < TABLE_ROWS; i++) {
        if (shown[i])
            line_draw(screen, at.x, y++, at.width, buffer_text(&line[i]),
                      i == cursors->active ? STYLE_BOLD
                      : i < 4              ? STYLE_PLAIN
                                           : STYLE_DIM);
        buffer_free(&line[i]);
    }
    char side[2][LIMIT_NAME + 32];
    snprintf(side[0], sizeof side[0], "snap: %s%s",
             catalog_row(&snap_catalog, (size_t)cursors->snap)->name,
             cursors->locked ? ", locked" : "");
    snprintf(side[1], sizeof side[1], "on: %s", cursors->of);
    for (int i = 0; i < 2 && at.height > 2 && at.width >= side_x + 10; i++)
        line_draw(screen, at.x + side_x, at.y + i, at.width - side_x, text_of(side[i]),
                  STYLE_PLAIN);
}
