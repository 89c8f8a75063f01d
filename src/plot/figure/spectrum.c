/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Spectra in figures: how far the axis goes, and the names of their lines. */
#include <hooke/plot/drawing.h>

#include <hooke/plot.h>

#include <math.h>

/* the axis goes to so many times the main line: beyond it there is little to see */
#define TIMES 10

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

struct axis spectrum_axis(const struct drawing *d)
{
    const struct curve *first = &d->curve[0];
    const double nyquist = first->n > 0 ? first->x[first->n - 1] : 0;
    /* While a run goes on its law says it best: the axis stands still. */
    const bool law = d->request->follow && isfinite(d->period);
    const double line = law ? 1 / d->period : d->line.frequency.value;
    return (struct axis){.label = "f",
                         .unit = "Hz",
                         .fixed = nyquist > 0,
                         .to = line > 0 ? fmin(nyquist, TIMES * line) : nyquist};
}

void spectrum_note(const struct drawing *d, struct buffer *text)
{
    if (!(d->line.frequency.value > 0) || d->request->running)
        return;
    buffer_put(text, TEXT("line at "));
    buffer_measured(text, d->line.frequency, QUANTITY_FREQUENCY, 5);
}
