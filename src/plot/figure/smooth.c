/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws adaptive runs as smooth curves: interpolates between their rows, which may be far apart, by
 * Hermite polynomials. */
#include <hooke/method.h>
#include <hooke/run.h>
#include <hooke/plot/drawing.h>

#include <hooke/base/numeric.h>
#include <hooke/plot.h>
#include <hooke/session/subject.h>

#define SMOOTH_MAX 32 /* largest number of points for each row */

/* Interpolated states. n is 0 if the rows are close enough or nothing is known between them. */
struct smooth {
    double *t, *y; /* t [n] in s, y [n][variables] */
    size_t n;
};

/* Returns true if rows should be interpolated: an adaptive run with fewer rows than points.
 * Implicit methods are left out, because slopes at their states, a rounding off the slow motion,
 * mean nothing. */
static bool is_smooth(const struct run *run, const struct chosen_rows *rows, int points)
{
    return run->plan.adaptive && !(run->method->flags & METHOD_IMPLICIT) && rows->n > 1 &&
           rows->n < (size_t)points;
}

/* Interpolates between the rows so that there are about `points` states. Returns false if out of
 * memory; smooth->n is 0 if no interpolation is needed. */
static bool smooth_rows(const struct run *run, const struct chosen_rows *rows, int points,
                        struct arena *arena, struct smooth *smooth, struct error *error)
{
    const int n = run->system.n;
    size_t each = (size_t)points / (rows->n ? rows->n : 1);
    *smooth = (struct smooth){.n = 0};
    if (!is_smooth(run, rows, points))
        return true;
    if (each < 2)
        each = 2;
    else
        each = each > SMOOTH_MAX ? SMOOTH_MAX : each;
    smooth->t = arena_array(arena, rows->n * each, sizeof *smooth->t);
    smooth->y = arena_array(arena, rows->n * each * (size_t)n, sizeof *smooth->y);
    if (!smooth->t || !smooth->y)
        return error_memory(error);
    double slope[2][LIMIT_VARIABLES];
    for (size_t row = 0; row < rows->n; row++) {
        const double a = trace_time(run->trace, rows->row[row]),
                     *left = trace_state(run->trace, rows->row[row]);
        const bool last = row + 1 == rows->n;
        const size_t next = rows->row[last ? row : row + 1];
        const double h = trace_time(run->trace, next) - a, *right = trace_state(run->trace, next);
        /* The system in force on the way to the next row; a change of parameters falls on a row. */
        const struct system *system = run_system_to(run, next);
        system_derivative(system, a, left, slope[0]);
        system_derivative(system, a + h, right, slope[1]);
        for (size_t k = 0; k < (last ? 1 : each); k++) {
            const double x = (double)k / (double)each;
            double *y = smooth->y + smooth->n * (size_t)n;
            for (int i = 0; i < n; i++)
                y[i] = hermite(x, h, left[i], slope[0][i], right[i], slope[1][i]);
            smooth->t[smooth->n++] = a + x * h;
        }
    }
    return true;
}

/* Returns the index of the state variable on the horizontal axis (coordinate -1) or that of a
 * coordinate, or -1 if the axis shows something else. */
static int state_on_axis(const struct drawing *d, int coordinate)
{
    const enum plot_kind kind = d->request->kind;
    const struct chosen_column *column;
    if (!d->request->columns)
        column = NULL;
    else
        column = coordinate < 0 ? &d->horizontal_column : &d->column[coordinate];
    if (column)
        return !column->observable && column->variable < d->model->n ? column->variable : -1;
    if (coordinate < 0)
        return 0;
    return plot_row(kind)->observable
               ? -1
               : (int)(vertical_variable(d->model, kind) - d->model->variable) + coordinate;
}

/* interpolated points for each column of cells */
#define POINTS_A_COLUMN 4

/* Adds interpolated curves of a run, and sets *drawn, if the plot shows state variables and rows
 * are far apart. Returns false if out of memory. */
bool drawing_smooth(struct drawing *d, const struct run *run, const struct chosen_rows *rows,
                    const char *label, bool *drawn)
{
    const bool plane = plot_is_plane(d->request->kind);
    const int x_state = plane ? state_on_axis(d, -1) : 0;
    struct smooth smooth;
    *drawn = x_state >= 0;
    for (int i = 0; i < d->coordinates; i++)
        *drawn = *drawn && state_on_axis(d, i) >= 0;
    if (!*drawn)
        return true;
    if (!smooth_rows(run, rows, POINTS_A_COLUMN * d->request->width, d->arena, &smooth, d->error))
        return false;
    *drawn = smooth.n > 0;
    const double *t = smooth.t;
    for (int c = plane ? -1 : 0; c < d->coordinates && *drawn; c++) {
        const int state = state_on_axis(d, c);
        double *value = arena_array(d->arena, smooth.n, sizeof *value);
        const char *name = c >= 0 && d->coordinates > 1 ? drawing_label(d, c) : label;
        if (!value || !name)
            return error_memory(d->error);
        for (size_t i = 0; i < smooth.n; i++)
            value[i] =
                smooth.y[i * (size_t)run->system.n + (size_t)state] / (c < 0 ? 1 : d->omega0);
        if (c < 0)
            smooth.t = value;
        else
            d->curve[d->curves++] = (struct curve){.label = name,
                                                   .x = smooth.t,
                                                   .y = value,
                                                   .n = smooth.n,
                                                   .t = plane ? t : NULL,
                                                   .thinned = true};
    }
    return true;
}
