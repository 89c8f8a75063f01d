/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A precision study for the eye: the log-log figure. */
#include <hooke/plot/drawing.h>
#include "modules/comparison/comparison.h"
#include "modules/comparison/plots.h"

#include <math.h>
#include <string.h>

#define MIN_ERROR 1.1102230246251565e-16 /* where an error of 0 is drawn: half an ulp of 1 */

char precision_letter(int curve)
{
    return (char)(curve < 26 ? 'a' + curve : curve < 52 ? 'A' + curve - 26 : '?');
}

/* Where failed runs stand: above everything else. */
static double top_of(const struct precision *precision)
{
    double top = 0;
    for (int i = 0; i < precision->points; i++)
        if (precision_meaningful(&precision->point[i]))
            top = fmax(top, precision->point[i].errors.max);
    return top > 0 ? pow(10, ceil(log10(top)) + (top > 0.1 ? 1 : 0)) : 1;
}

bool precision_figure(const struct precision *precision, struct arena *arena, struct figure *figure,
                      struct error *error)
{
    const size_t n = (size_t)precision->points, curves = (size_t)precision->curves + 1;
    struct curve *curve = arena_array(arena, curves, sizeof *curve);
    double *x = arena_array(arena, 2 * n + 1, sizeof *x),
           *y = arena_array(arena, 2 * n + 1, sizeof *y);
    if (!curve || !x || !y)
        return error_memory(error);
    const double top = top_of(precision);
    bool timed = false;
    for (size_t i = 0; i < n; i++)
        timed |= isfinite(precision->point[i].time.minimum);
    struct curve *failed = &curve[0];
    *failed =
        (struct curve){.x = x + n, .y = y + n, .points = true, .mark = 'X', .label = "failed"};
    for (int c = 0; c < precision->curves; c++) {
        const struct precision_curve *from = &precision->curve[c];
        struct curve *to = &curve[c + 1];
        *to = (struct curve){.x = x + from->first,
                             .y = y + from->first,
                             .n = (size_t)from->count,
                             .points = true,
                             .mark = precision_letter(c)};
        for (int i = from->first; i < from->first + from->count; i++) {
            const struct precision_point *point = &precision->point[i];
            const bool good = precision_meaningful(point);
            const double cost =
                timed ? good ? point->time.minimum : point->seconds : (double)point->cost.evals;
            x[i] = good && cost > 0 ? cost : NAN;
            y[i] = fmax(point->errors.max, MIN_ERROR);
            if (!good && cost > 0) {
                x[n + failed->n] = cost;
                y[n + failed->n++] = top;
            }
        }
    }
    if (failed->n == 0)
        failed->label = NULL;
    *figure = (struct figure){.title = "precision",
                              .curve = curve,
                              .curves = (int)curves,
                              .x = {.label = timed ? "time of a solve" : "evaluations",
                                    .unit = timed ? "s" : "",
                                    .log = true},
                              .y = {.label = "error", .log = true},
                              .note = precision->reference.exact ? "against the closed form"
                                                                 : "against two methods"};
    return true;
}

bool precision_known(const struct session *session)
{
    return session_precision(session);
}

bool precision_plot(struct drawing *d, struct figure *figure)
{
    const struct precision *precision = session_precision(d->session);
    if (!precision) {
        error_set(d->error, ERROR_COMMAND, "there is no precision study to plot");
        return error_hint(d->error, "type: precision");
    }
    return precision_figure(precision, d->arena, figure, d->error);
}

void precision_plot_legend(const struct session *session, int width, struct buffer *text)
{
    precision_legend(session_precision(session), width, text);
}

bool precision_name_curves(const struct session *session, struct arena *arena,
                           struct figure *figure, struct error *error)
{
    const struct precision *precision = session_precision(session);
    struct curve *curve = arena_array(arena, (size_t)figure->curves, sizeof *curve);
    if (!curve)
        return error_memory(error);
    memcpy(curve, figure->curve, (size_t)figure->curves * sizeof *curve);
    for (int i = 0; i < precision->curves; i++)
        for (int c = 0; c < figure->curves; c++)
            if (curve[c].points && curve[c].mark == precision_letter(i))
                curve[c].label = precision->curve[i].by.method->row.name;
    figure->curve = curve;
    return true;
}
