/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings in figures: which one a plot shows, and its curve, with velocities or energies
 * computed from its positions where the plot needs them. */
#include <hooke/run.h>
#include <hooke/base/cancel.h>
#include <hooke/data.h>
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>

#include <hooke/plot.h>
#include <hooke/session/series_tools.h>

#include <math.h>

/* number of points per column drawn of velocities and energies during collection */
#define GROWING_POINTS 2
/* [cell] width from which a pane has room for other notes beside the delay of velocities */
#define DELAY_COLUMNS 60

bool recording_shows(const struct recording *recording, const struct run *run, enum plot_kind kind)
{
    const enum plot_recorded shown = plot_row(kind)->recorded;
    return shown && recorded_derivative(recording, run) == (int)shown - (int)RECORDED_POSITION;
}

/* Returns the index of the recording that a plot shows when the user names none, or -1: the current
 * one, if the plot can show its quantity and its window overlaps the run. */
int figure_recording(const struct session *session, enum plot_kind kind)
{
    const struct recording *recording = session_recording(session);
    const struct run *run = session_grows(session, recording) ? NULL : session_run(session);
    const struct plot_row *row = plot_row(kind);
    if (!recording || (row->residual && !run && !series_tools()->is_fitted(session, recording)))
        return -1;
    const bool own = recording_shows(recording, run, kind);
    const bool derived =
        row->of_motion && recording->column[recording->value].quantity == QUANTITY_LENGTH;
    if (!run)
        return own || row->any_recording || derived ? session->current_recording : -1;
    if (!own && !(row->residual && recorded_derivative(recording, run) >= 0))
        return -1;
    const double a = trace_time(run->trace, 0),
                 b = trace_time(run->trace, trace_count(run->trace) - 1);
    return fmin(a, b) < recording->window[1] && fmax(a, b) > recording->window[0]
               ? session->current_recording
               : -1;
}

/* Thins the velocities or energies of a recording that is being collected to GROWING_POINTS per
 * column, always at the same times, because their scatter would flicker. Overwrites the arrays of
 * the series. */
static void thin_derivatives(const struct drawing *d, struct series *series)
{
    const bool plane = plot_is_plane(d->request->kind);
    const double span = plane ? drawing_trail(d) * d->period : d->shown,
                 step = exp2(ceil(log2(span / (GROWING_POINTS * d->request->width))));
    double *t = (double *)(uintptr_t)series->t, *y = (double *)(uintptr_t)series->y;
    double previous = NAN;
    size_t n = 0;
    for (size_t i = 0; i < series->n && isfinite(step); i++) {
        const double place = floor(t[i] / step);
        if (place != previous) {
            t[n] = t[i];
            y[n++] = y[i];
        }
        previous = place;
    }
    series->n = isfinite(step) ? n : series->n;
}

/* Computes what the plot shows of a recording in its window: the recorded values, or velocities or
 * energies. Returns false with an error. */
static bool recorded_values(struct drawing *d, const struct recording *recording,
                            struct series *series)
{
    const struct data_motion *motion = &d->motion;
    if (!drawing_needs_motion(d, recording)) {
        if (!recording_series(recording, d->arena, 1, series, d->error))
            return false;
        *series = series_window(*series, d->window[0], d->window[1]);
        return true;
    }
    if (!motion_series(motion, kind_of(d)->energy, d->window[0], d->window[1], d->arena, series,
                       d->error))
        return false;
    if (d->request->follow && session_grows(d->session, recording))
        thin_derivatives(d, series);
    return true;
}

/* Fills the curve of a recording in the phase plot: its positions from their mean against its
 * velocities over omega0. Returns false if out of memory or cancelled. */
bool drawing_phase_data(struct drawing *d, const struct series *series, struct curve *curve)
{
    const struct data_motion *motion = &d->motion;
    double *x = arena_array(d->arena, series->n, sizeof *x),
           *y = arena_array(d->arena, series->n, sizeof *y);
    if (!x || !y)
        return error_memory(d->error);
    for (size_t i = 0, row = 0; i < series->n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(series->cancel))
            return error_set(d->error, ERROR_CANCELLED, "stopped");
        while (motion->t[row] < series->t[i])
            row++;
        x[i] = motion->y[row] - motion->middle;
        y[i] = series->y[i] / d->omega0;
    }
    curve->t = series->t;
    curve->x = x;
    curve->y = y;
    return true;
}

/* Scales a voltage or a force to the position of the run that it is compared with; the series
 * becomes empty if it does not follow the run. Returns false if out of memory. */
static bool scale_values(const struct drawing *d, struct series *series)
{
    const struct session *session = d->session;
    const struct data_distance data =
        run_data_distance(session->runs.slot[d->request->run[0]]->run,
                          session->recording[d->request->recording]->recording);
    double *y = arena_array(d->arena, series->n, sizeof *y);
    if (!y)
        return error_memory(d->error);
    for (size_t i = 0; i < series->n; i++)
        y[i] = data.at_zero + data.gain * series->y[i];
    series->y = y;
    if (!isfinite(data.gain))
        series->n = 0;
    return true;
}

/* Adds the curve of a recording to the figure, with error bars where they are known. Voltages and
 * forces that are drawn with runs are scaled to positions, without bars; no curve is added if they
 * do not follow the run. A kind of plot with its own curves of data (data_curve) fills the curve.
 * Returns false with an error. */
bool drawing_recording(struct drawing *d, const struct recording *recording)
{
    struct series series;
    struct curve *curve = &d->curve[d->curves];
    const double *bar = NULL;
    if (!recorded_values(d, recording, &series))
        return false;
    if ((kind_of(d)->recorded || kind_of(d)->residual) && !kind_of(d)->data_curve &&
        !drawing_needs_motion(d, recording) &&
        !series_tools()->errors(recording, &series, d->arena, &bar))
        return error_memory(d->error);
    if (d->request->runs > 0 && kind_of(d)->recorded == RECORDED_POSITION &&
        quantity_is_scaled(recording->column[recording->value].quantity)) {
        if (!scale_values(d, &series))
            return false;
        if (series.n == 0)
            return true;
        bar = NULL; /* the bars are those of another quantity */
    }
    *curve = (struct curve){.label = d->request->runs ? "data" : recording->name,
                            .x = series.t,
                            .y = series.y,
                            .n = series.n,
                            .points = true,
                            .bar = bar};
    d->curves++;
    return !kind_of(d)->data_curve || kind_of(d)->data_curve(d, &series, curve);
}

/* Appends "v 0.2 s late": how far velocities lag behind the samples during collection. */
void drawing_put_delay(const struct drawing *d, struct buffer *text)
{
    const struct recording *recording = recording_of(d);
    if (!kind_of(d)->of_motion || !recording || !session_grows(d->session, recording) ||
        !(d->session->growing->late > 0))
        return;
    if (d->request->width < DELAY_COLUMNS)
        buffer_clear(text);
    buffer_put(text, text->len > 0 ? TEXT(", v ") : TEXT("v "));
    buffer_quantity(text, d->session->growing->late, QUANTITY_TIME, 2);
    buffer_put(text, TEXT(" late"));
}

/* Fills a series with the newest part of a recording that is being collected, twice as long as what
 * is drawn. Returns false with an error. */
static bool read_recent_rows(struct drawing *d, const struct recording *recording,
                             struct series *series)
{
    struct recording part = *recording; /* its arrays are shared */
    const double trail = 2 * drawing_trail(d) * d->session->growing->steady,
                 shown = d->request->shared ? d->request->shared->shown : HUGE_VAL,
                 t_begin = part.window[1] - 2 * fmax(shown, trail);
    part.window[0] = isfinite(trail) ? fmax(part.window[0], t_begin) : part.window[0];
    return recording_series(&part, d->arena, 2, series, d->error);
}

/* Computes the velocities of a recording for this plot. Without a run its frequency scales the
 * phase plot. Returns false with an error if they cannot be found or do not belong to the run's
 * scene. */
bool drawing_find_motion(struct drawing *d, const struct recording *recording)
{
    const bool grows = d->request->follow && session_grows(d->session, recording);
    struct series recent;
    if (grows && !read_recent_rows(d, recording, &recent))
        return false;
    if (!series_tools()->motion(d->session, recording, grows ? &recent : NULL, kind_of(d)->energy,
                                d->arena, &d->motion, d->error))
        return false;
    if (d->request->runs > 0)
        return d->model == &oscillator_model ||
               error_set(d->error, ERROR_COMMAND,
                         "velocities of %s are those of a spring, so no plot shows both",
                         recording->name);
    const double omega = d->motion.omega;
    d->model = &oscillator_model;
    d->period = 6.283185307179586 / omega;
    if (kind_of(d)->scaled && d->session->setup.settings.phase_axes == PHASE_SCALED && omega > 0)
        d->omega0 = omega;
    return true;
}
