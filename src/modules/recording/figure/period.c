/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The figure of the period against the amplitude: windows of runs and recordings as points, a
 * pendulum's closed form as a line. */
#include "modules/recording/known/known.h"
#include <hooke/figure/layout.h>
#include "modules/recording/plots.h"

#include <math.h>

/* Number of windows; periods of a window; smallest number of samples; points of the line. */
enum { WINDOWS_MAX = 24, WINDOWS_MIN = 3, PERIODS = 8, SAMPLES_MIN = 16, THEORY_POINTS = 100 };

/* Reads period against amplitude in windows of some periods each into a curve of points with error
 * bars; fewer windows if one cannot be read. Returns false with the error. */
static bool read_windows(struct drawing *d, const struct series *series, struct curve *curve)
{
    struct period_reading reading[WINDOWS_MAX];
    struct period p;
    if (!series_period(series, d->arena, &p, d->error))
        return false;
    int count = (int)fmin(fmax(p.periods / PERIODS, WINDOWS_MIN), WINDOWS_MAX);
    while (!series_period_readings(series, count, d->arena, reading, d->error)) {
        if (count <= WINDOWS_MIN)
            return false;
        count = count / 2 > WINDOWS_MIN ? count / 2 : WINDOWS_MIN;
    }
    double *x = arena_array(d->arena, (size_t)count, sizeof *x),
           *y = arena_array(d->arena, (size_t)count, sizeof *y),
           *bar = arena_array(d->arena, (size_t)count, sizeof *bar);
    if (!x || !y || !bar)
        return error_memory(d->error);
    for (int i = 0; i < count; i++) {
        x[i] = reading[i].amplitude.value;
        y[i] = reading[i].period.value;
        bar[i] = reading[i].period.uncertainty;
    }
    curve->bar = bar;
    curve->x = x;
    curve->y = y;
    curve->n = (size_t)count;
    curve->points = true;
    return true;
}

/* Adds the points of a series to the figure; label NULL means out of memory. Returns false with the
 * error. */
static bool add_series(struct drawing *d, struct series series, const char *label)
{
    const double *window = d->request->window;
    struct curve *curve = &d->curve[d->curves];
    if (series.n < SAMPLES_MIN)
        return error_set(d->error, ERROR_COMMAND, "fewer than %d samples", SAMPLES_MIN);
    const double t_begin = isnan(window[0]) ? series.t[0] : window[0];
    const double t_end = isnan(window[1]) ? series.t[series.n - 1] : window[1];
    series = series_window(series, t_begin, t_end);
    *curve = (struct curve){.label = label};
    if (!label)
        return error_memory(d->error);
    if (!read_windows(d, &series, curve))
        return false;
    d->curves++;
    return true;
}

/* Adds the scene's period against amplitude in closed form, if it has one, over the range of the
 * amplitudes. Returns false with the error if out of memory. */
static bool add_theory(struct drawing *d, const struct scene *scene)
{
    double min = HUGE_VAL, max = 0;
    for (int c = 0; c < d->curves; c++)
        for (size_t i = 0; curve_goes_on(&d->curve[c], i); i++) {
            min = fmin(min, d->curve[c].x[i]);
            max = fmax(max, d->curve[c].x[i]);
        }
    if (!isfinite(scene_period_at(scene, max)))
        return true;
    double *x = arena_array(d->arena, THEORY_POINTS, sizeof *x),
           *y = arena_array(d->arena, THEORY_POINTS, sizeof *y);
    if (!x || !y)
        return error_memory(d->error);
    for (int i = 0; i < THEORY_POINTS; i++) {
        x[i] = min + (max - min) * i / (THEORY_POINTS - 1);
        y[i] = scene_period_at(scene, x[i]);
    }
    d->curve[d->curves++] = (struct curve){.label = "theory", .x = x, .y = y, .n = THEORY_POINTS};
    return true;
}

/* Makes the figure of period against amplitude: windows of each run and of the recording, and the
 * theory of the first run. Returns false with the error. */
bool period_figure(struct drawing *d, struct figure *figure)
{
    const struct figure_request *request = d->request;
    const struct recording *recording = recording_of(d);
    const struct run *first =
        request->runs > 0 ? d->session->runs.slot[request->run[0]]->run : NULL;
    enum quantity quantity = QUANTITY_OTHER;
    struct series series;
    for (int i = 0; i < request->runs; i++) {
        const struct run *run = d->session->runs.slot[request->run[i]]->run;
        if (!run_series(run, false, d->arena, &series, d->error) ||
            !add_series(d, series, drawing_run_label(d, run)))
            return false;
        quantity = series.quantity;
    }
    if (recording) {
        if (!recording_series(recording, d->arena, SAMPLES_MIN, &series, d->error) ||
            !add_series(d, series, first ? "data" : recording->name))
            return false;
        quantity = first ? quantity : series.quantity;
    }
    if (first && !add_theory(d, &first->scene))
        return false;
    const struct curve *curve = &d->curve[0];
    *figure = (struct figure){.title = "period",
                              .curve = d->curve,
                              .curves = d->curves,
                              .plane = true,
                              .x = quantity_axis("A", quantity, curve->x[0]),
                              .y = quantity_axis("T", QUANTITY_TIME, curve->y[0])};
    return true;
}
