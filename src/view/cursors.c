/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The two cursors: lines on the time plots, and the table of what they measure in place of the log. */
#include "internal.h"

#include <stdio.h>

#define TABLE_ROWS 6

/* A piece of the frame without writing, where a letter can stand. */
static bool is_bare_frame(const struct screen *screen, const struct canvas *canvas, int x, int y)
{
    return canvas->cell[(size_t)y * (size_t)canvas->width + (size_t)x].codepoint == (screen->charset == CHARSET_ASCII ? '-' : 0x2500);
}

void cursors_draw(const struct screen *screen, const struct figure_layout *layout, struct canvas *canvas, struct rectangle at, bool letters)
{
    const struct cursors *cursors = &screen->session->view.cursors;
    uint32_t line = screen->charset == CHARSET_ASCII ? ':' : 0x250A;
    int column, row;

    for (int i = 0; i < 2 && cursors->shown; i++) {
        if (!cursors->at[i].set || !figure_cell(layout, cursors->at[i].t, layout->y.from, &column, &row))
            continue;
        int x = at.x + layout->left + column, y = at.y + layout->top;
        for (row = 0; row < layout->rows; row++) { /* the curve stays in front */
            const struct cell *cell = &canvas->cell[(size_t)(y + row) * (size_t)canvas->width + (size_t)x];
            if (cell->codepoint == ' ' || cell->style == STYLE_DIM)
                canvas_put(canvas, x, y + row, line, i == cursors->active ? STYLE_BOLD : STYLE_DIM);
        }
        if (letters)
            canvas_put(canvas, x, is_bare_frame(screen, canvas, x, at.y) ? at.y : y, (uint32_t)"AB"[i], STYLE_BOLD);
    }
}

/* "1.4530(4)": the uncertainty in units of the last digit. */
static void put_parenthesis(struct buffer *out, double value, double uncertainty)
{
    if (!(uncertainty > 0) || !isfinite(uncertainty)) {
        buffer_format(out, "%.6g", value);
        return;
    }
    int decimals = larger(-(int)floor(log10(uncertainty * 1.0526)), 0); /* 9.5 rounds to 10 */
    double unit = pow(10, -decimals);
    if (decimals > 15 || uncertainty >= 9.5)
        buffer_format(out, "%.10g", value);
    else
        buffer_format(out, "%.*f(%.0f)", decimals, value, uncertainty / unit);
}

static double derived(const struct scene *scene, const char *name)
{
    const struct row *row = catalog_find(&derived_catalog, text_of(name));
    return row ? ((const struct derived_row *)(const void *)row)->value(scene).value : (double)NAN;
}

static const struct scene *scene_of(const struct session *session)
{
    const struct run *run = session_run(session);
    return run ? &run->scene : &session->setup.scene;
}

static void put_cursor(struct buffer *out, const struct session *session, int i)
{
    const struct cursors *cursors = &session->view.cursors;
    const char *letter = i ? "B" : "A";
    buffer_format(out, "%s%s  ", i == cursors->active ? ">" : " ", letter);
    if (!cursors->at[i].set) {
        buffer_put(out, TEXT("not set"));
        return;
    }
    const struct unit *unit = unit_display(QUANTITY_LENGTH, fmax(fabs(cursors->at[0].y), fabs(cursors->at[1].y)));
    buffer_put(out, TEXT("t = "));
    put_parenthesis(out, cursors->at[i].t, cursors->at[i].t_uncertainty);
    buffer_format(out, " s   y = %.2f %s", cursors->at[i].y / (unit ? unit->factor : 1) + 0.0, unit ? unit->row.name : "m");
    if (cursors->at[i].crossing > 0)
        buffer_format(out, "  up-crossing #%d", cursors->at[i].crossing);
}

struct interval {
    double length, uncertainty; /* [s] */
    double period, period_uncertainty; /* [s] NAN: not known */
};

static struct interval interval_of(const struct cursors *cursors)
{
    struct interval interval = {NAN, NAN, NAN, NAN};
    if (!cursors->at[0].set || !cursors->at[1].set)
        return interval;
    interval.length = cursors->at[1].t - cursors->at[0].t;
    interval.uncertainty = hypot(cursors->at[0].t_uncertainty, cursors->at[1].t_uncertainty);
    if (cursors->periods > 0 && interval.length != 0) {
        interval.period = fabs(interval.length) / cursors->periods;
        interval.period_uncertainty = interval.uncertainty / cursors->periods;
    }
    return interval;
}

static void put_interval(struct buffer *out, const struct session *session)
{
    const struct cursors *cursors = &session->view.cursors;
    struct interval interval = interval_of(cursors);
    buffer_put(out, TEXT(" B-A"));
    if (isnan(interval.length))
        return;
    buffer_format(out, " = %.*f s", 4, interval.length);
    if (isnan(interval.period))
        return;
    buffer_format(out, " / %.6g period%s   T = ", cursors->periods, cursors->periods == 1 ? "" : "s");
    put_parenthesis(out, interval.period, interval.period_uncertainty);
    buffer_put(out, TEXT(" s   f = "));
    put_parenthesis(out, 1 / interval.period, interval.period_uncertainty / interval.period / interval.period);
    buffer_put(out, TEXT(" Hz"));
}

static void put_theory(struct buffer *out, const struct session *session)
{
    const struct scene *scene = scene_of(session);
    double damped = derived(scene, "T_d"), period = isfinite(damped) ? damped : derived(scene, "T0");
    double gamma = scene->value[param_index("gamma")], omega0 = derived(scene, "omega0");
    double measured = interval_of(&session->view.cursors).period;
    if (!isfinite(period))
        return;
    buffer_format(out, " theory T0 = %.4f s", period);
    if (isfinite(measured))
        buffer_format(out, "  (T-T0)/T0 = %+.2f %%", (measured / period - 1) * 100);
    if (gamma > 0)
        buffer_format(out, "    log decrement %.3g  Q = %.3g", gamma * period / 2, omega0 / gamma);
}

static const char *snap_name(const struct cursors *cursors)
{
    return catalog_row(&snap_catalog, (size_t)cursors->snap)->name;
}

void cursors_table(const struct screen *screen, struct rectangle at)
{
    const struct session *session = screen->session;
    const struct cursors *cursors = &session->view.cursors;
    struct buffer line[TABLE_ROWS] = {{0}};
    /* Which rows stay when there is no room for all: the most important first. */
    static const int order[TABLE_ROWS] = {2, 0, 1, 3, 4, 5};
    bool shown[TABLE_ROWS] = {false};

    put_cursor(&line[0], session, 0);
    put_cursor(&line[1], session, 1);
    put_interval(&line[2], session);
    put_theory(&line[3], session);
    buffer_put(&line[4], TEXT(" </> move  n/N next/prev crossing  +/- periods  Tab A<->B  s snap  l lock"));
    buffer_put(&line[5], TEXT(" Enter keep as measurement  z zoom  e export  q leave  ? help"));
    for (int i = 0; i < smaller(at.height, TABLE_ROWS); i++)
        shown[order[i]] = true;
    for (int i = 0, y = at.y; i < TABLE_ROWS; i++) {
        if (shown[i])
            line_draw(screen, at.x, y++, at.width, buffer_text(&line[i]), i == cursors->active ? STYLE_BOLD : i < 4 ? STYLE_PLAIN : STYLE_DIM);
        buffer_free(&line[i]);
    }
    char side[2][48];
    snprintf(side[0], sizeof side[0], "snap: %s%s", snap_name(cursors), cursors->locked ? ", locked" : "");
    snprintf(side[1], sizeof side[1], "on: %s", cursors->on_data ? "y, data" : "y, run");
    for (int i = 0; i < 2 && at.height > 2 && at.width >= 76; i++)
        canvas_text(screen->canvas, at.x + 54, at.y + i, text_of(side[i]), STYLE_PLAIN);
}
