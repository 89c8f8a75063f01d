/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Spectra in figures: the length of the axis, and the list of lines. */
#include "modules/recording/known/known.h"
#include <hooke/base/cancel.h>
#include "modules/recording/measuring.h"
#include "modules/recording/plots.h"

#include <math.h>

/* The axis ends at this multiple of the main line; little is visible beyond it. */
#define SPECTRUM_AXIS_TIMES 10
/* Samples of a run's spectrum, and samples a period, as the axis extends to ten times the line. */
#define SPECTRUM_SAMPLES 4096
#define SAMPLES_A_PERIOD 24

/* Fills the curve with the amplitude spectrum of a series. Returns false with the error. */
static bool data_spectrum(const struct series *series, struct arena *arena, struct curve *curve,
                          struct error *error)
{
    if (!series_spectrum(series, arena, &curve->x, &curve->y, &curve->n))
        return error_set(error, ERROR_COMMAND, "a spectrum needs at least 8 samples");
    return true;
}

/* Samples a run's position evenly between two times [s], no finer than a spectrum of some harmonics
 * of `period` (NAN if unknown) needs; a long run is represented by its newest part. Returns false
 * with the error. */
static bool run_even_series(const struct run *run, double t_begin, double t_end, double period,
                            struct arena *arena, struct series *series, struct error *error)
{
    const double step =
        isfinite(period) ? fmax(run->settings.dt, period / SAMPLES_A_PERIOD) : run->settings.dt;
    const double max = floor((t_end - t_begin) / step);
    const size_t n = max > SPECTRUM_SAMPLES ? SPECTRUM_SAMPLES : (size_t)fmax(max, 0);
    double *t = arena_array(arena, n + 1, sizeof *t), *y = arena_array(arena, n + 1, sizeof *y);
    if (!t || !y)
        return error_memory(error);
    *series = (struct series){t, y, 0, system_variable(&run->system, 0).quantity, run->cancel, 0};
    for (size_t i = 0; i < n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(run->cancel))
            return error_set(error, ERROR_CANCELLED, "stopped");
        t[series->n] = t_end - (double)(n - i) * step;
        y[series->n] = run_position(run, t[series->n]);
        series->n += isfinite(y[series->n]) ? 1 : 0;
    }
    return true;
}

/* Makes the curve of a series' spectrum. Appends its strongest lines to the peaks of the request,
 * at most PEAKS_EACH. Sets d->line, for the axis, to the series' strongest line if its frequency is
 * higher than that of d->line: of the strongest lines of all series, the one with the highest
 * frequency. Returns false with the error in d->error. */
bool drawing_data_spectrum(struct drawing *d, const struct series *series, struct curve *curve)
{
    curve->points = false;
    struct figure_peaks ignored = {0}, *peaks = d->request->peaks ? d->request->peaks : &ignored;
    struct spectrum_peak found[PEAKS_EACH];
    const int max = d->request->peaks ? PEAKS_EACH : 1,
              count = series_peaks(series, d->arena, found, max);
    for (int i = 0; i < count && peaks->count < PEAKS_MAX; i++)
        peaks->peak[peaks->count++] =
            (struct figure_peak){curve->label, found[i], series->quantity};
    if (count > 0 && !(d->line.frequency.value >= found[0].frequency.value))
        d->line = found[0];
    return data_spectrum(series, d->arena, curve, d->error);
}

bool drawing_run_spectrum(struct drawing *d, const struct run *run, struct curve *curve)
{
    struct series series;
    return run_even_series(run, d->window[0], d->window[1], d->period, d->arena, &series,
                           d->error) &&
           drawing_data_spectrum(d, &series, curve);
}

/* Returns the frequency axis, which ends at SPECTRUM_AXIS_TIMES the frequency of the line, at most
 * at half the sampling rate. */
struct axis spectrum_axis(const struct drawing *d)
{
    const struct curve *first = &d->curve[0];
    const double nyquist = first->n > 0 ? first->x[first->n - 1] : 0;
    /* If a run is followed, the axis comes from its known period, so that it does not move. */
    const bool law = d->request->follow && isfinite(d->period);
    const double line = law ? 1 / d->period : d->line.frequency.value;
    return (struct axis){.label = "f",
                         .unit = "Hz",
                         .fixed = nyquist > 0,
                         .last_value =
                             line > 0 ? fmin(nyquist, SPECTRUM_AXIS_TIMES * line) : nyquist};
}

/* States the frequency of the line, unless a run is still going on. */
void spectrum_note(const struct drawing *d, struct buffer *text)
{
    if (!(d->line.frequency.value > 0) || d->request->running)
        return;
    buffer_format(text, "line at %s", SHOWN_MEASURED(d->line.frequency, QUANTITY_FREQUENCY, 5));
}

/* Adds the lines of spectra to the reply, in words and as records; with labels if there are several
 * curves. */
void spectrum_report(const struct figure_peaks *peaks, int curves, struct reply *reply)
{
    for (int i = 0; i < peaks->count; i++) {
        const struct figure_peak *peak = &peaks->peak[i];
        struct buffer *text = reply_buffer(reply);
        if (curves > 1 && peak->label)
            buffer_format(text, "%s: ", peak->label);
        put_measured(text, "line at f", peak->line.frequency, QUANTITY_FREQUENCY);
        put_measured(text, "   A", peak->line.amplitude, peak->quantity);
        reply_begin(reply, "peak");
        reply_string(reply, "of", peak->label);
        reply_measured(reply, "frequency", peak->line.frequency, QUANTITY_FREQUENCY);
        reply_measured(reply, "amplitude", peak->line.amplitude, peak->quantity);
        reply_end(reply);
    }
}

void reply_spectrum(const struct session *session, const struct figure_request *request,
                    struct reply *reply)
{
    UNUSED(session);
    spectrum_report(request->peaks, request->runs + (request->recording >= 0), reply);
}
