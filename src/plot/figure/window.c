/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses the window of time that a plot shows: all, the part asked for, the last periods, or in a
 * live view a window that moves on in pages. */
#include <hooke/run.h>
#include <hooke/data.h>
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>

#include <hooke/base/numeric.h>
#include <hooke/plot.h>
#include <hooke/session/log.h>
#include <hooke/session/series_tools.h>

#include <math.h>

/* A phase curve is a spiral if its width changes by more than this fraction from the first turn to
 * the last. */
#define SPIRAL_CHANGE_MIN 0.05
#define TURN_TOLERANCE 0.01  /* relative error of a width that was found at the recorded rows */
#define SPIRAL_TURNS_MAX 100 /* More turns run together. */
#define GROWING_LEAST 2.0    /* [s] shortest window of a recording that is being collected */

/* Returns the number of coordinates (or values, for first order) that have the quantity of the
 * first and share its plot. */
int plot_coordinates(const struct model *model)
{
    const int all = model->order == 2 ? model->n / 2 : model->n;
    int n = 1;
    while (n < all && n <= LIMIT_OVERLAY &&
           model->variable[n].quantity == model->variable[0].quantity)
        n++;
    return n;
}

/* Returns the period [s] of a run by its scene, or an estimate from the scales of its state; NAN if
 * unknown. */
double run_rhythm(const struct run *run)
{
    const struct system *system = &run->system;
    const double period = scene_period(&run->scene);
    if (isfinite(period) || system->model == &oscillator_model || system->order != 2)
        return period;
    return TWO_PI * system->scale[0] / system->scale[system->n / 2];
}

/* Sets *t_begin and *t_end to the first and last time [s] of the runs of the figure and of the
 * window of its recording. If there are none, *t_begin is HUGE_VAL and *t_end is -HUGE_VAL. */
static void find_time_span(const struct drawing *d, double *t_begin, double *t_end)
{
    *t_begin = HUGE_VAL;
    *t_end = -HUGE_VAL;
    for (int i = 0; i < d->request->runs; i++) {
        const struct run *run = d->session->runs.slot[d->request->run[i]]->run;
        const double a = trace_time(run->trace, 0),
                     b = trace_time(run->trace, trace_count(run->trace) - 1);
        *t_begin = fmin(*t_begin, fmin(a, b));
        *t_end = fmax(*t_end, fmax(a, b));
    }
    /* A live plot of a run shows only the part of the recording beside it. */
    const struct recording *recording = recording_of(d);
    if (recording && !(d->request->follow && d->request->runs)) {
        *t_begin = fmin(*t_begin, recording->window[0]);
        *t_end = fmax(*t_end, recording->window[1]);
    }
}

/* Shortens a length to one whose quarters are short numbers, too, so that the labels of a window
 * look the same on each of its pages. */
static double short_length_below(double length)
{
    static const double digits[] = {8, 6, 4, 3.2, 2.4, 2, 1.6, 1.2, 1};
    const double unit = pow(10, floor(log10(length)));
    for (size_t i = 0; i < COUNT_OF(digits); i++)
        if (digits[i] * unit <= length)
            return digits[i] * unit;
    return length;
}

/* Returns the longest window [s] of a view in which every period can be seen at this width, or NAN
 * if any can be. */
static double longest_window(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    const int each =
        !request->charset || request->charset->plain ? PERIOD_COLUMNS_ASCII : PERIOD_COLUMNS_DOTS;
    const int columns =
        request->width > 2 * FRAME_COLUMNS ? request->width - FRAME_COLUMNS : FRAME_COLUMNS;
    const double max = kind_of(d)->periods || !request->alone ? d->period * columns / each : NAN;
    return d->total > max && isnormal(max) ? short_length_below(max) : max;
}

double drawing_trail(const struct drawing *d)
{
    return d->request->trail > 0 ? d->request->trail : VIEW_TRAIL_PERIODS;
}

/* Gives an axis the unit in which numbers of this size are short; times are in s or longer units.
 */
void axis_suit(struct axis *axis, enum quantity quantity, double size)
{
    const struct unit *unit =
        unit_display(quantity, quantity == QUANTITY_TIME ? fmax(size, 1) : size);
    if (!unit)
        return;
    axis->unit = unit->row.name;
    axis->factor = unit->factor;
}

struct axis quantity_axis(const char *label, enum quantity quantity, double size)
{
    struct axis axis = {.label = label, .unit = quantity_unit(quantity), .factor = 1};
    axis_suit(&axis, quantity, size);
    return axis;
}

/* Returns the fixed time axis of a window [s]. */
struct axis time_axis(const double window[2])
{
    struct axis axis = quantity_axis("t", QUANTITY_TIME, window[1]);
    axis.fixed = true;
    axis.first_value = window[0];
    axis.last_value = window[1];
    return axis;
}

bool run_goes_back(const struct run *run)
{
    return trace_time(run->trace, trace_count(run->trace) - 1) < trace_time(run->trace, 0);
}

/* Returns true if the first run, whose newest part a view shows, goes backwards in time. */
static bool first_run_goes_back(const struct drawing *d)
{
    return d->request->runs > 0 && run_goes_back(d->session->runs.slot[d->request->run[0]]->run);
}

/* Sets the window to the newest part of t_begin..t_end [s], `max` long. It moves by whole pages
 * from the start, so that only the curve changes between two moves. */
static void follow_window(struct drawing *d, double t_begin, double t_end, double now, double max)
{
    const double turn = max / (d->request->pages > 0 ? d->request->pages : 1);
    const double passed = first_run_goes_back(d) ? t_end - now : now - t_begin;
    const double moved = turn * fmax(0, ceil((passed - max) / turn - 1e-6));
    d->window[0] = first_run_goes_back(d) ? t_end - moved - max : t_begin + moved;
    d->window[1] = d->window[0] + max;
}

/* Returns the smallest length [s] with short quarters that is at least `length`, or half as long
 * again at most. */
static double short_length_above(double length)
{
    double longer = length;
    for (int i = 0; i < 4 && short_length_below(longer) < length; i++)
        longer *= 1.25;
    return short_length_below(longer);
}

/* Chooses the window of a recording that is being collected. If the longest useful window or the
 * end is known it fills from the left and then moves in pages; else it is lengthened from time to
 * time. */
static void growing_window(struct drawing *d, double t_begin, double t_end, double max)
{
    const double t_final = d->session->growing->t_end,
                 whole = t_final > t_begin ? t_final - t_begin : NAN;
    const double length = d->request->span > 0 ? max : fmin(fmin(whole, max), HUGE_VAL);
    follow_window(d, t_begin, t_end, t_end,
                  isfinite(length) ? length
                                   : short_length_above(fmax(t_end - t_begin, GROWING_LEAST)));
}

/* Chooses the window of the drawing: that of the other plots, that of the request, the trail of a
 * plane, or the newest part in a live view. */
/* Returns the difference between the largest and the least value of the run's first coordinate in
 * the recorded rows from t_begin to t_end, or -infinity if there is none. */
static double coordinate_range(const struct run *run, double t_begin, double t_end)
{
    const struct trace *trace = run->trace;
    double min = HUGE_VAL, max = -HUGE_VAL;
    for (size_t i = trace_row_at(trace, t_begin);
         i < trace_count(trace) && trace_time(trace, i) <= t_end; i++) {
        min = fmin(min, trace_state(trace, i)[0]);
        max = fmax(max, trace_state(trace, i)[0]);
    }
    return max - min;
}

/* Returns true if the turns of a run grow or shrink from each to the next, and by enough. */
static bool run_spirals(const struct run *run, double period)
{
    const double t_begin = trace_time(run->trace, 0),
                 t_end = trace_time(run->trace, trace_count(run->trace) - 1);
    const int turns = (int)((t_end - t_begin) / period);
    double first = NAN, width = NAN;
    bool grows = true, shrinks = true;
    for (int i = 0; i < turns && (grows || shrinks); i++) {
        const double begin = t_begin + i * period, previous = width;
        width = coordinate_range(run, begin, begin + period);
        if (i == 0)
            first = width;
        grows &= !(width < previous * (1 - TURN_TOLERANCE));
        shrinks &= !(width > previous * (1 + TURN_TOLERANCE));
    }
    return (grows || shrinks) && fabs(width - first) > SPIRAL_CHANGE_MIN * fmax(first, width);
}

/* Returns true if the turns of a run that is drawn grow or shrink and are few enough to be seen. */
static bool is_spiral(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    bool spirals = false;
    for (int i = 0; i < request->runs && !spirals && d->total <= SPIRAL_TURNS_MAX * d->period;
         i++) {
        const struct run *run = d->session->runs.slot[request->run[i]]->run;
        spirals = trace_count(run->trace) > 1 && !run_goes_back(run) && run_spirals(run, d->period);
    }
    return spirals;
}

void drawing_window(struct drawing *d)
{
    const struct figure_request *request = d->request;
    double t_begin, t_end;
    if (request->shared && plot_is_timed(request->kind)) {
        d->window[0] = request->shared->axis.first_value;
        d->window[1] = request->shared->axis.last_value;
        d->shown = request->shared->shown;
        d->total = request->shared->total;
        return;
    }
    find_time_span(d, &t_begin, &t_end);
    const bool wanted = !isnan(request->window[0]) || !isnan(request->window[1]),
               plane = plot_is_plane(request->kind);
    const double now = first_run_goes_back(d) ? t_begin : t_end;
    const bool grows = request->runs == 0 && session_grows(d->session, recording_of(d));
    if (request->follow && !plane) {
        t_begin = fmin(t_begin, request->t_end);
        t_end = fmax(t_end, request->t_end);
    }
    d->total = t_end - t_begin;
    d->window[0] = isnan(request->window[0]) ? t_begin : request->window[0];
    d->window[1] = isnan(request->window[1]) ? t_end : request->window[1];
    const double trail = drawing_trail(d) * d->period,
                 max = request->span > 0 ? request->span : longest_window(d);
    const bool whole =
        request->full || (request->whole_spiral && kind_of(d)->scaled && is_spiral(d));
    if (plane && !wanted && !whole && trail < d->total) {
        d->window[0] = first_run_goes_back(d) ? t_begin : t_end - trail;
        if (grows) /* moves only after a whole trail, so that the curve stays meanwhile */
            d->window[0] = t_begin + floor((d->window[0] - t_begin) / trail) * trail;
        d->window[1] = grows ? t_end : d->window[0] + trail;
    } else if (request->follow && plot_is_timed(request->kind) && !kind_of(d)->run_curve &&
               !wanted && grows) {
        growing_window(d, t_begin, t_end, max);
    } else if (request->follow && plot_is_timed(request->kind) && !kind_of(d)->run_curve &&
               !wanted &&
               (request->span > 0 ||
                /* a complete recording without a run is shown as a whole */
                (request->runs > 0 && d->total > max))) {
        follow_window(d, t_begin, t_end, now, max);
    }
    d->shown = d->window[1] - d->window[0];
}

/* Returns the period [s] of the first run or, without a run, of the recording; NAN if unknown. */
static double drawing_period(const struct drawing *d)
{
    const struct recording *recording = recording_of(d);
    struct series series;
    struct error ignored;
    if (d->request->runs > 0)
        return run_rhythm(d->session->runs.slot[d->request->run[0]]->run);
    if (!recording || !recording_series(recording, d->arena, 2, &series, &ignored))
        return NAN;
    return TWO_PI / series_tools()->frequency(d->session, recording, &series, d->arena);
}

/* Chooses the window that the time plots of a screen share. Returns false if there is nothing to
 * show. */
bool session_window(const struct session *session, const struct figure_request *request,
                    struct arena *arena, struct figure_window *window)
{
    struct drawing d = {.session = session, .request = request, .arena = arena};
    if (request->runs == 0 && request->recording < 0)
        return false;
    d.period = drawing_period(&d);
    drawing_window(&d);
    *window = (struct figure_window){time_axis(d.window), d.shown, d.total};
    return d.window[0] < d.window[1];
}

/* Returns the request for the rows of a run in a window. For plots of variables over time it names
 * the variables, so that choose_rows() may keep only the rows of their extremes. */
struct row_request drawing_rows(const struct drawing *d, const double window[2])
{
    const struct figure_request *request = d->request;
    struct row_request rows = {.t_begin = window[0],
                               .t_end = window[1],
                               .columns = request->width,
                               .period = d->period,
                               .screen = request->follow};
    if (plot_is_timed(request->kind) && !request->columns && !kind_of(d)->observable &&
        !request->log && !request->x && !request->y) {
        rows.first = (int)(vertical_variable(d->model, request->kind) - d->model->variable);
        rows.count = d->coordinates;
    }
    return rows;
}

bool drawing_shows_spiral(const struct drawing *d)
{
    const struct figure_request *request = d->request;
    return request->whole_spiral && kind_of(d)->scaled && !request->columns &&
           isnan(request->window[0]) && isnan(request->window[1]) &&
           d->total > drawing_trail(d) * d->period && is_spiral(d);
}

bool drawing_label_turns(const struct drawing *d, struct figure *figure)
{
    const struct curve *curve = &d->curve[0];
    if (!drawing_shows_spiral(d) || d->curves != 1 || curve->n < 2)
        return true;
    struct figure_label *label = arena_array(d->arena, 2, sizeof *label);
    struct buffer last = {0};
    buffer_format(&last, "turn %.0f", ceil(d->total / d->period));
    const char *last_text = arena_text(d->arena, buffer_text(&last));
    buffer_free(&last);
    if (!label || !last_text)
        return error_memory(d->error);
    label[0] = (struct figure_label){curve->x[0], curve->y[0], "turn 1"};
    label[1] = (struct figure_label){curve->x[curve->n - 1], curve->y[curve->n - 1], last_text};
    figure->label = label;
    figure->labels = 2;
    return true;
}
