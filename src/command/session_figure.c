/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Plots of a session as figures: which curves, over which time, in which units. */
#include "internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PERIOD_COLUMNS_ASCII 8   /* least columns a period that can still be followed */
#define PERIOD_COLUMNS_DOTS 5
#define TRAIL_PERIODS 2          /* of the phase plot */
#define UNBOUNDED 20             /* times the median of the other curves' maxima */
#define FRAME 10                 /* [cell] of the width that labels and frame take */

static const struct row plots[] = {
    [PLOT_POSITION] = {"position", "", "y against t", "", NULL},
    [PLOT_VELOCITY] = {"velocity", "", "v against t", "", NULL},
    [PLOT_PHASE] = {"phase", "", "v against y, the last two periods unless a window is given", "", NULL},
    [PLOT_ENERGY] = {"energy", "", "energy against t", "", NULL},
    [PLOT_ERROR] = {"error", "", "distance from the exact solution against t", "", NULL},
};
const struct catalog plot_catalog = CATALOG("plot", plots);

static const char *const observable_of[] = {[PLOT_POSITION] = "y", [PLOT_VELOCITY] = "v", [PLOT_PHASE] = "v", [PLOT_ENERGY] = "energy",
                                            [PLOT_ERROR] = "error"};
static const char *const label_of[] = {[PLOT_POSITION] = "y", [PLOT_VELOCITY] = "v", [PLOT_PHASE] = "v", [PLOT_ENERGY] = "E",
                                       [PLOT_ERROR] = "error"};

/* What is built up. */
struct drawing {
    const struct session *session;
    const struct figure_request *request;
    struct arena *arena;
    struct error *error;
    struct curve *curve;
    int curves;
    double omega0;    /* [rad/s] that v is divided by; 1: not */
    double period;    /* [s] of the first run, NAN: none */
    double window[2]; /* [s] */
    double shown, total; /* [s] */
};

static const struct observable *observable(const char *name)
{
    return (const struct observable *)(const void *)catalog_find(&observable_catalog, text_of(name));
}

static double derived_value(const struct scene *scene, const char *name)
{
    const struct row *row = catalog_find(&derived_catalog, text_of(name));
    return row ? ((const struct derived_row *)(const void *)row)->value(scene).value : (double)NAN;
}

static double scene_period(const struct scene *scene)
{
    const double damped = derived_value(scene, "T_d");
    return isfinite(damped) ? damped : derived_value(scene, "T0");
}

/* ---- which part of the time ------------------------------------------------------------------------------------------------ */

static void span_of(const struct drawing *d, double *from, double *to)
{
    *from = HUGE_VAL;
    *to = -HUGE_VAL;
    for (int i = 0; i < d->request->runs; i++) {
        const struct run *run = d->session->run[d->request->run[i]]->run;
        const double a = trace_time(run->trace, 0), b = trace_time(run->trace, trace_count(run->trace) - 1);
        *from = fmin(*from, fmin(a, b));
        *to = fmax(*to, fmax(a, b));
    }
    if (d->request->recording >= 0) {
        const struct recording *recording = d->session->recording[d->request->recording]->recording;
        *from = fmin(*from, recording->window[0]);
        *to = fmax(*to, recording->window[1]);
    }
}

static void choose_window(struct drawing *d)
{
    const struct figure_request *request = d->request;
    double from, to;
    span_of(d, &from, &to);
    const bool asked = !isnan(request->window[0]) || !isnan(request->window[1]);
    d->total = to - from;
    d->window[0] = isnan(request->window[0]) ? from : request->window[0];
    d->window[1] = isnan(request->window[1]) ? to : request->window[1];
    const int each = request->charset == CHARSET_ASCII ? PERIOD_COLUMNS_ASCII : PERIOD_COLUMNS_DOTS;
    const int columns = request->width > 2 * FRAME ? request->width - FRAME : FRAME;
    const double most = d->period * columns / each;
    if (!asked && (request->kind == PLOT_POSITION || request->kind == PLOT_VELOCITY) && to - from > most)
        d->window[1] = from + most;
    if (!asked && request->kind == PLOT_PHASE && to - from > TRAIL_PERIODS * d->period)
        d->window[0] = to - TRAIL_PERIODS * d->period;
    d->shown = d->window[1] - d->window[0];
}

/* ---- curves ------------------------------------------------------------------------------------------------------------------ */

static const char *run_label(const struct drawing *d, const struct run *run)
{
    const char *name = run->name[0] ? run->name : run->method->row.name;
    bool alone = true;
    for (int i = 0; i < d->request->runs; i++) {
        const struct run *other = d->session->run[d->request->run[i]]->run;
        const char *its = other->name[0] ? other->name : other->method->row.name;
        alone &= other == run || strcmp(its, name) != 0;
    }
    struct buffer text = {0};
    buffer_put(&text, text_of(name));
    if (!alone)
        buffer_format(&text, " (%d)", run->number);
    const char *label = arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return label;
}

static bool add_run(struct drawing *d, const struct run *run)
{
    const size_t n = trace_count(run->trace);
    const bool phase = d->request->kind == PLOT_PHASE;
    double *x = arena_array(d->arena, n, sizeof *x), *y = arena_array(d->arena, n, sizeof *y);
    const char *label = run_label(d, run);
    if (!x || !y || !label)
        return error_memory(d->error);
    if (!run_column(run, observable(observable_of[d->request->kind]), y, d->error) ||
        (phase && !run_column(run, observable("y"), x, d->error)))
        return false;
    /* Of a run that ended earlier the phase plot shows its own last periods. */
    const double end = trace_time(run->trace, n - 1);
    const double late = phase && isnan(d->request->window[0]) && end < d->window[1] ? d->window[1] - end : 0;
    size_t kept = 0;
    for (size_t i = 0; i < n; i++) {
        const double t = trace_time(run->trace, i);
        if (t < d->window[0] - late || t > d->window[1])
            continue;
        x[kept] = phase ? x[i] : t;
        y[kept] = phase ? y[i] / d->omega0 : y[i];
        kept++;
    }
    d->curve[d->curves++] = (struct curve){.label = label, .x = x, .y = y, .n = kept};
    return true;
}

static bool add_recording(struct drawing *d, struct recording *recording)
{
    struct series series;
    if (!recording_series(recording, d->arena, 1, &series, d->error))
        return false;
    series = series_window(series, d->window[0], d->window[1]);
    d->curve[d->curves++] = (struct curve){.label = d->request->runs ? "data" : recording->name, .x = series.t, .y = series.y, .n = series.n,
                                           .points = true};
    return true;
}

static double largest(const double *x, size_t n)
{
    double most = 0;
    for (size_t i = 0; i < n; i++)
        if (isfinite(x[i]))
            most = fmax(most, fabs(x[i]));
    return most;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A curve that dwarfs the others does not set the range; a single curve always does. */
static bool mark_unbounded(struct drawing *d)
{
    double *most = arena_array(d->arena, (size_t)d->curves + 1, sizeof *most);
    double *other = arena_array(d->arena, (size_t)d->curves + 1, sizeof *other);
    if (!most || !other)
        return error_memory(d->error);
    for (int i = 0; i < d->curves; i++)
        most[i] = largest(d->curve[i].y, d->curve[i].n);
    int bounded = 0;
    for (int i = 0; i < d->curves; i++) {
        int n = 0;
        for (int j = 0; j < d->curves; j++)
            if (j != i)
                other[n++] = most[j];
        qsort(other, (size_t)n, sizeof *other, ascending);
        const bool diverged = i < d->request->runs && d->session->run[d->request->run[i]]->run->stop == STOP_DIVERGED;
        d->curve[i].unbounded = n > 0 && (diverged || most[i] > UNBOUNDED * other[(n - 1) / 2]) && other[(n - 1) / 2] > 0;
        bounded += !d->curve[i].unbounded;
    }
    for (int i = 0; i < d->curves && bounded == 0; i++)
        d->curve[i].unbounded = false;
    return true;
}

/* ---- axes ---------------------------------------------------------------------------------------------------------------------- */

static struct axis make_axis(const char *label, enum quantity quantity, double size)
{
    const struct unit *unit = unit_display(quantity, quantity == QUANTITY_TIME ? fmax(size, 1) : size);
    return (struct axis){.label = label, .unit = unit ? unit->row.name : quantity_unit(quantity), .factor = unit ? unit->factor : 1};
}

static double size_of(const struct drawing *d, bool x)
{
    double size = 0;
    for (int i = 0; i < d->curves; i++)
        if (!d->curve[i].unbounded)
            size = fmax(size, largest(x ? d->curve[i].x : d->curve[i].y, d->curve[i].n));
    return size;
}

static const char *make_note(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    const bool asked = !isnan(request->window[0]) || !isnan(request->window[1]);
    struct buffer text = {0};
    if (request->kind == PLOT_PHASE && !asked && d->shown < d->total)
        buffer_format(&text, "last %d T", TRAIL_PERIODS);
    else if (!asked && d->shown < d->total)
        buffer_format(&text, "first %.4g of %.4g s", d->shown, d->total);
    else if (isfinite(d->period) && request->kind <= PLOT_VELOCITY && d->shown * PERIOD_COLUMNS_DOTS > d->period * (request->width - FRAME))
        buffer_format(&text, "%.0f periods: envelope", d->shown / d->period);
    const char *note = text.len ? arena_text(d->arena, buffer_text(&text)) : NULL;
    buffer_free(&text);
    return note;
}

static enum quantity y_quantity(const struct drawing *d)
{
    if (d->request->kind == PLOT_POSITION && d->request->runs == 0) {
        const struct recording *recording = d->session->recording[d->request->recording]->recording;
        return recording->column[recording->value].quantity;
    }
    if (d->request->kind == PLOT_PHASE && d->omega0 != 1)
        return QUANTITY_LENGTH;
    return observable(observable_of[d->request->kind])->quantity;
}

static void mark_present(const struct drawing *d, struct figure *figure)
{
    if (d->request->runs == 0 || d->curve[0].n == 0 || d->curve[0].unbounded)
        return;
    const struct curve *curve = &d->curve[0];
    figure->has_point = true;
    figure->point[0] = curve->x[curve->n - 1];
    figure->point[1] = curve->y[curve->n - 1];
}

bool session_figure(const struct session *session, const struct figure_request *request, struct arena *arena, struct figure *figure,
                    struct error *error)
{
    struct drawing d = {.session = session, .request = request, .arena = arena, .error = error, .omega0 = 1, .period = (double)NAN};
    d.curve = arena_array(arena, (size_t)request->runs + 1, sizeof *d.curve);
    if (!d.curve)
        return error_memory(error);
    const bool phase = request->kind == PLOT_PHASE;
    if (request->runs > 0) {
        const struct scene *scene = &session->run[request->run[0]]->run->scene;
        d.period = scene_period(scene);
        const double omega0 = derived_value(scene, "omega0");
        if (phase && session->setup.settings.phase_axes == PHASE_SCALED && isfinite(omega0))
            d.omega0 = omega0;
    }
    choose_window(&d);
    for (int i = 0; i < request->runs; i++)
        if (!add_run(&d, session->run[request->run[i]]->run))
            return false;
    if (request->recording >= 0 && !add_recording(&d, session->recording[request->recording]->recording))
        return false;
    if (!mark_unbounded(&d))
        return false;

    *figure = (struct figure){.title = plots[request->kind].name, .curve = d.curve, .curves = d.curves, .zero_line = request->kind != PLOT_ENERGY,
                              .equal = phase && d.omega0 != 1, .note = make_note(&d)};
    figure->x = phase ? make_axis("y", QUANTITY_LENGTH, size_of(&d, true)) : make_axis("t", QUANTITY_TIME, d.window[1]);
    figure->y = make_axis(phase && d.omega0 != 1 ? "v/omega0" : label_of[request->kind], y_quantity(&d), size_of(&d, false));
    figure->y.log = request->log;
    if (figure->equal) {
        figure->y.factor = figure->x.factor;
        figure->y.unit = figure->x.unit;
    }
    mark_present(&d, figure);
    return true;
}
