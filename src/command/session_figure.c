/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Plots of a session as figures: which curves, over which time, in which units. */
#include "figure_curves.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PERIOD_COLUMNS_ASCII 8 /* least columns a period that can still be followed */
#define PERIOD_COLUMNS_DOTS 5
#define TRAIL_PERIODS 2 /* of the phase plot */
#define UNBOUNDED 3     /* times the median of the other curves' maxima */
#define FRAME 10        /* [cell] of the width that labels and frame take */
#define HARMONICS 6     /* shown of a spectrum */

struct plot_row {
    struct row row;
    const char *observable, *label; /* of the vertical axis */
    bool periods;                   /* each period has to be seen: the window is limited to what the width can show */
};

static const struct plot_row plots[] = {
    [PLOT_POSITION] = {{"position", "", "y against t", "", NULL}, "y", "y", true},
    [PLOT_VELOCITY] = {{"velocity", "", "v against t", "", NULL}, "v", "v", true},
    [PLOT_PHASE] = {{"phase", "", "v against y, the last two periods unless a window is given", "", NULL},
                    "v",
                    "v",
                    false},
    [PLOT_ENERGY] = {{"energy", "", "energy against t", "", NULL}, "energy", "E", false},
    [PLOT_ERROR] = {{"error", "", "distance from the exact solution against t", "", NULL}, "error", "error", false},
    [PLOT_RESIDUAL] = {{"residual", "", "the recording minus its fit, or minus the run, against t", "", NULL},
                       "y",
                       "residual",
                       false},
    [PLOT_SPECTRUM] = {{"spectrum", "", "amplitude spectrum of y", "", NULL}, "y", "amplitude", false},
};
const struct catalog plot_catalog = CATALOG("plot", plots);

/* What is built up. */
struct drawing {
    const struct session *session;
    const struct figure_request *request;
    struct arena *arena;
    struct error *error;
    struct curve *curve;
    int curves;
    double omega0;       /* [rad/s] that v is divided by; 1: not */
    double period;       /* [s] of the first run, NAN: none */
    double window[2];    /* [s] */
    double shown, total; /* [s] */
};

static const struct observable *observable(const char *name)
{
    return (const struct observable *)(const void *)catalog_find(&observable_catalog, text_of(name));
}

static const struct recording *recording_of(const struct drawing *d)
{
    return d->request->recording >= 0 ? d->session->recording[d->request->recording]->recording : NULL;
}

/* Whether the fit of the session is one of this recording. */
static bool has_fit_of(const struct session *session, const struct recording *recording)
{
    char name[sizeof session->fit_of];
    snprintf(name, sizeof name, "data %s", recording->name);
    return session->has_fit && strcmp(name, session->fit_of) == 0;
}

int figure_recording(const struct session *session, enum plot_kind kind)
{
    const struct run *run = session_run(session);
    const struct recording *recording = session_recording(session);
    if (!recording || (kind != PLOT_POSITION && kind != PLOT_RESIDUAL && (kind != PLOT_SPECTRUM || run)) ||
        (kind == PLOT_RESIDUAL && !run && !has_fit_of(session, recording)))
        return -1;
    if (!run)
        return session->current_recording;
    if (recording->column[recording->value].quantity != QUANTITY_LENGTH)
        return -1;
    const double a = trace_time(run->trace, 0), b = trace_time(run->trace, trace_count(run->trace) - 1);
    return fmin(a, b) < recording->window[1] && fmax(a, b) > recording->window[0] ? session->current_recording : -1;
}

/* ---- which part of the time ---- */

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
    /* What follows a run shows the part of the recording that lies beside it. */
    const struct recording *recording = recording_of(d);
    if (recording && !(d->request->follow && d->request->runs)) {
        *from = fmin(*from, recording->window[0]);
        *to = fmax(*to, recording->window[1]);
    }
}

/* Down to a length whose quarters are short numbers too: a window that lasts has labels that look the same on each
 * page. */
static double short_number(double length)
{
    static const double digits[] = {8, 6, 4, 3.2, 2.4, 2, 1.6, 1.2, 1};
    const double unit = pow(10, floor(log10(length)));
    for (size_t i = 0; i < COUNT_OF(digits); i++)
        if (digits[i] * unit <= length)
            return digits[i] * unit;
    return length;
}

/* [s] the longest window in which every period can be seen at this width; NAN: any. */
static double longest_window(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    const int each = request->charset == CHARSET_ASCII ? PERIOD_COLUMNS_ASCII : PERIOD_COLUMNS_DOTS;
    const int columns = request->width > 2 * FRAME ? request->width - FRAME : FRAME;
    const double most =
        plots[request->kind].periods || (request->follow && !request->alone) ? d->period * columns / each : NAN;
    return request->follow && d->total > most && isnormal(most) ? short_number(most) : most;
}

static double trail(const struct drawing *d)
{
    return d->request->trail > 0 ? d->request->trail : TRAIL_PERIODS;
}

static void choose_window(struct drawing *d)
{
    const struct figure_request *request = d->request;
    double from, to;
    span_of(d, &from, &to);
    const double now = to;
    const bool asked = !isnan(request->window[0]) || !isnan(request->window[1]), phase = request->kind == PLOT_PHASE;
    if (request->follow && !phase && request->until > to)
        to = request->until;
    d->total = to - from;
    d->window[0] = isnan(request->window[0]) ? from : request->window[0];
    d->window[1] = isnan(request->window[1]) ? to : request->window[1];
    const double most = request->span > 0 ? request->span : longest_window(d);
    if (asked || request->kind == PLOT_SPECTRUM) {
    } else if (phase) {
        d->window[0] = fmax(from, to - trail(d) * d->period);
    } else if (request->follow && (request->span > 0 || d->total > most)) {
        /* A moving window starts a whole number of pages, or of columns, after the start: while the curve grows nothing
         * else moves. */
        const double turn = most / (request->pages > 0 ? request->pages : 1);
        const double start = from + turn * fmax(0, ceil((now - from - most) / turn - 1e-6));
        d->window[0] = start;
        d->window[1] = start + most;
    } else if (d->total > most) {
        d->window[1] = from + most;
    }
    d->shown = d->window[1] - d->window[0];
}

/* ---- curves ---- */

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
    const bool phase = d->request->kind == PLOT_PHASE;
    struct curve *curve = &d->curve[d->curves];
    *curve = (struct curve){.label = run_label(d, run)};
    if (!curve->label)
        return error_memory(d->error);
    if (d->request->kind == PLOT_SPECTRUM) {
        d->curves++;
        return run_spectrum(run, d->window[0], d->window[1], d->period, d->arena, curve, d->error);
    }
    /* Of a run that ended earlier the phase plot shows its own last periods. */
    const double end = trace_time(run->trace, trace_count(run->trace) - 1);
    const double late = phase && isnan(d->request->window[0]) && end < d->window[1] ? d->window[1] - end : 0;
    struct chosen_rows rows;
    const struct row_request part = {d->window[0] - late, d->window[1], d->request->width, d->period,
                                     d->request->follow};
    if (!choose_rows(run, &part, d->arena, &rows, d->error))
        return false;
    double *x = arena_array(d->arena, rows.n + 1, sizeof *x), *y = arena_array(d->arena, rows.n + 1, sizeof *y);
    if (!x || !y)
        return error_memory(d->error);
    if (!values_at_rows(run, observable(phase ? "y" : "t"), &rows, d->arena, x, d->error) ||
        !values_at_rows(run, observable(plots[d->request->kind].observable), &rows, d->arena, y, d->error))
        return false;
    for (size_t i = 0; i < rows.n && d->omega0 != 1; i++)
        y[i] /= d->omega0;
    curve->x = x;
    curve->y = y;
    curve->n = rows.n;
    d->curves++;
    return true;
}

static bool add_recording(struct drawing *d, const struct recording *recording)
{
    struct series series;
    struct curve *curve = &d->curve[d->curves];
    if (!recording_series(recording, d->arena, 1, &series, d->error))
        return false;
    series = series_window(series, d->window[0], d->window[1]);
    *curve = (struct curve){.label = d->request->runs ? "data" : recording->name,
                            .x = series.t,
                            .y = series.y,
                            .n = series.n,
                            .points = true};
    d->curves++;
    if (d->request->kind != PLOT_SPECTRUM)
        return true;
    curve->points = false;
    return data_spectrum(&series, d->arena, curve, d->error);
}

static bool add_residual(struct drawing *d, const struct recording *recording)
{
    const bool fitted = has_fit_of(d->session, recording);
    const struct run *run = d->request->runs ? d->session->run[d->request->run[0]]->run : NULL;
    if (!fitted && !run)
        return error_set(d->error, ERROR_COMMAND, "a residual needs a fit of this recording, or a run beside it");
    if (!add_recording(d, recording))
        return false;
    struct curve *curve = &d->curve[d->curves - 1];
    double *left = arena_array(d->arena, curve->n + 1, sizeof *left);
    if (!left)
        return error_memory(d->error);
    const double shift = recording->zero - d->session->fit_zero; /* since the fit */
    for (size_t i = 0; i < curve->n; i++)
        left[i] =
            curve->y[i] - (fitted ? fit_value(&d->session->fit, curve->x[i]) - shift : run_position(run, curve->x[i]));
    curve->y = left;
    curve->label = fitted ? "data - fit" : "data - run";
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

/* A run whose method, not its scene, makes it grow. */
static bool grows(const struct run *run)
{
    const struct oscillator *o = &run->system.oscillator;
    const double doubling = log(2);
    return run->stop == STOP_DIVERGED || (o->damping >= 0 && o->stiffness > 0 && run->system.autonomous &&
                                          (double)run->steps * log(run->plan.growth) > doubling);
}

/* A growing run that dwarfs the others does not set the range; a single curve always does. */
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
        const bool growing = i < d->request->runs && grows(d->session->run[d->request->run[i]]->run);
        d->curve[i].unbounded = n > 0 && growing && other[(n - 1) / 2] > 0 && most[i] > UNBOUNDED * other[(n - 1) / 2];
        bounded += !d->curve[i].unbounded;
    }
    for (int i = 0; i < d->curves && bounded == 0; i++)
        d->curve[i].unbounded = false;
    return true;
}

/* ---- axes ---- */

static struct axis make_axis(const char *label, enum quantity quantity, double size)
{
    const struct unit *unit = unit_display(quantity, quantity == QUANTITY_TIME ? fmax(size, 1) : size);
    return (struct axis){
        .label = label, .unit = unit ? unit->row.name : quantity_unit(quantity), .factor = unit ? unit->factor : 1};
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
    const bool asked = !isnan(request->window[0]) || !isnan(request->window[1]),
               part = !asked && d->shown < d->total * (1 - 1e-9);
    struct buffer text = {0};
    if (request->kind == PLOT_PHASE && part)
        buffer_format(&text, "last %.4g T", trail(d));
    else if (request->follow && part && !request->running)
        buffer_format(&text, "last %.4g of %.4g s", d->shown, d->total);
    else if (part)
        buffer_format(&text, request->follow ? "last %.4g s" : "first %.4g of %.4g s", d->shown, d->total);
    else if (isfinite(d->period) && plots[request->kind].periods &&
             d->shown * PERIOD_COLUMNS_DOTS > d->period * (request->width - FRAME))
        buffer_format(&text, "%.0f periods: envelope", d->shown / d->period);
    const char *note = text.len ? arena_text(d->arena, buffer_text(&text)) : NULL;
    buffer_free(&text);
    return note;
}

static enum quantity y_quantity(const struct drawing *d)
{
    const struct recording *recording = recording_of(d);
    if (recording && d->request->runs == 0)
        return recording->column[recording->value].quantity;
    if (d->request->kind == PLOT_PHASE && d->omega0 != 1)
        return QUANTITY_LENGTH;
    return observable(plots[d->request->kind].observable)->quantity;
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

bool session_figure(const struct session *session, const struct figure_request *request, struct arena *arena,
                    struct figure *figure, struct error *error)
{
    struct drawing d = {
        .session = session, .request = request, .arena = arena, .error = error, .omega0 = 1, .period = NAN};
    d.curve = arena_array(arena, (size_t)request->runs + 1, sizeof *d.curve);
    if (!d.curve)
        return error_memory(error);
    const bool phase = request->kind == PLOT_PHASE;
    if (request->runs > 0) {
        const struct run *run = session->run[request->run[0]]->run;
        const double stiffness = run->system.oscillator.stiffness; /* now in force */
        d.period = scene_period(&run->scene);
        if (phase && session->setup.settings.phase_axes == PHASE_SCALED && stiffness > 0)
            d.omega0 = sqrt(stiffness);
    }
    choose_window(&d);
    const struct recording *recording = recording_of(&d);
    const bool residual = request->kind == PLOT_RESIDUAL, spectrum = request->kind == PLOT_SPECTRUM;
    if (residual && !recording)
        return error_set(error, ERROR_COMMAND, "a residual needs a recording");
    for (int i = 0; i < request->runs && !residual; i++)
        if (!add_run(&d, session->run[request->run[i]]->run))
            return false;
    if (recording && !(residual ? add_residual : add_recording)(&d, recording))
        return false;
    size_t points = 0;
    for (int i = 0; i < d.curves; i++)
        points += d.curve[i].n;
    if (points == 0 && !request->follow)
        return error_set(error, ERROR_COMMAND, "nothing was recorded in this window of time");
    if (!mark_unbounded(&d))
        return false;

    *figure = (struct figure){.title = plots[request->kind].row.name,
                              .curve = d.curve,
                              .curves = d.curves,
                              .zero_line = request->kind != PLOT_ENERGY && !spectrum,
                              .equal = phase && d.omega0 != 1,
                              .note = make_note(&d)};
    figure->x = phase      ? make_axis("y", QUANTITY_LENGTH, size_of(&d, true))
                : spectrum ? (struct axis){.label = "f", .unit = "Hz"}
                           : make_axis("t", QUANTITY_TIME, d.window[1]);
    figure->y =
        make_axis(phase && d.omega0 != 1 ? "v/omega0" : plots[request->kind].label, y_quantity(&d), size_of(&d, false));
    figure->y.log = request->log;
    if (figure->equal) {
        figure->y.factor = figure->x.factor;
        figure->y.unit = figure->x.unit;
    }
    if (request->follow && !phase && !spectrum) {
        figure->x.fixed = true;
        figure->x.from = d.window[0];
        figure->x.to = d.window[1];
    } else if (spectrum && d.curve[0].n > 0) {
        const double nyquist = d.curve[0].x[d.curve[0].n - 1];
        figure->x.fixed = true;
        figure->x.to = isfinite(d.period) ? fmin(nyquist, HARMONICS / d.period) : nyquist;
    }
    if (!residual && !spectrum)
        mark_present(&d, figure);
    return true;
}
