/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Envelopes in figures: amplitudes read window by window. */
#include "modules/recording/known/known.h"
#include "modules/recording/plots.h"

#include <math.h>

/* Largest and smallest number of windows, and samples below which nothing is drawn. */
#define ENVELOPE_MAX 120
#define ENVELOPE_MIN 3
#define ENVELOPE_SAMPLES 8

/* Makes a curve of amplitudes, with error bars, read in windows of two periods, or more if there
 * are many. If a gap leaves one empty, fewer and longer windows are tried. Returns false with the
 * error. */
bool drawing_data_envelope(struct drawing *d, const struct series *series, struct curve *curve)
{
    struct overview overview;
    struct reading reading[ENVELOPE_MAX];
    double times[ENVELOPE_MAX];
    curve->n = 0;
    if (series->n < ENVELOPE_SAMPLES) /* a window of time in which there is next to nothing */
        return true;
    series_overview(series, d->arena, &overview);
    int count =
        overview.oscillates ? (int)fmin(fmax(overview.periods / 2, ENVELOPE_MIN), ENVELOPE_MAX) : 1;
    const double t_begin = series->t[0], span = series->t[series->n - 1] - t_begin;
    for (;; count /= 2) {
        for (int i = 0; i < count; i++)
            times[i] = t_begin + (i + 0.5) / count * span;
        if (series_amplitudes(series, d->arena, times, count, span / count, reading, d->error))
            break;
        if (count < 2 * ENVELOPE_MIN)
            return false;
    }
    double *x = arena_array(d->arena, (size_t)count, sizeof *x),
           *y = arena_array(d->arena, (size_t)count, sizeof *y),
           *bar = arena_array(d->arena, (size_t)count, sizeof *bar);
    if (!x || !y || !bar)
        return error_memory(d->error);
    for (int i = 0; i < count; i++) {
        x[i] = reading[i].t;
        y[i] = reading[i].amplitude.value;
        bar[i] = reading[i].amplitude.uncertainty;
    }
    curve->bar = bar;
    curve->x = x;
    curve->y = y;
    curve->n = (size_t)count;
    return true;
}

/* Takes the envelope of the samples of the run in the window. */
bool drawing_run_envelope(struct drawing *d, const struct run *run, struct curve *curve)
{
    struct series series;
    if (!run_series(run, false, d->arena, &series, d->error))
        return false;
    series = series_window(series, d->window[0], d->window[1]);
    return drawing_data_envelope(d, &series, curve);
}
