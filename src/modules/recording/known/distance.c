/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A recording compared with a run: which observable of the run it shows, on which scale, and the
 * rms difference. */
#include "modules/recording/known/known.h"

#include <hooke/base/cancel.h>
#include <hooke/plot/curves.h>

#include <math.h>

/* Smallest share of its variance that a scaled recording must have in common with the run. */
#define FOLLOWED_VARIANCE_MIN 0.01

/* Sets span to the earlier and the later end [s] of a run. */
static void run_span(const struct run *run, double span[2])
{
    const double first = trace_time(run->trace, 0),
                 last = trace_time(run->trace, trace_count(run->trace) - 1);
    span[0] = fmin(first, last);
    span[1] = fmax(first, last);
}

/* Returns the number of samples of a series, which has no gaps, within the span of a run. */
static size_t samples_spanned(const struct run *run, const struct series *data)
{
    double span[2];
    size_t count = 0;
    run_span(run, span);
    for (size_t i = 0; i < data->n && (i % LOOK_EACH_ROWS || !cancelled(data->cancel)); i++)
        count += data->t[i] >= span[0] && data->t[i] <= span[1];
    return count;
}

/* Sums over the samples within the span of a run: x is the value of the run there, y the recorded
 * one. */
struct overlap_sums {
    double n, x, y, xx, xy, yy; /* number, means, squares and product about the means */
    double apart;               /* sum of (x - y)^2 */
};

/* Computes in *s means, products and squared distance of the data and of the run's derivative of
 * that order, over the times that both have, in one pass (Welford 1962); n is 0 if cancelled. */
static void overlap_sum(const struct run *run, const struct series *data, int derivative,
                        struct overlap_sums *s)
{
    double span[2];
    run_span(run, span);
    *s = (struct overlap_sums){.n = 0};
    for (size_t i = 0; i < data->n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(data->cancel)) {
            *s = (struct overlap_sums){.n = 0};
            return;
        }
        if (!(data->t[i] >= span[0] && data->t[i] <= span[1]))
            continue;
        const double x = run_motion(run, data->t[i], derivative), y = data->y[i];
        if (!isfinite(x - y))
            continue;
        const double dx = x - s->x, dy = y - s->y;
        s->n++;
        s->x += dx / s->n;
        s->y += dy / s->n;
        s->xx += dx * (x - s->x);
        s->xy += dx * (y - s->y);
        s->yy += dy * (y - s->y);
        s->apart += (x - y) * (x - y);
    }
}

/* Returns true if the run is one oscillator that moves forward in time and shows the recorded
 * quantity. */
static bool can_compare(const struct run *run, const struct recording *recording)
{
    const size_t rows = trace_count(run->trace);
    return run->system.n == 2 && run->system.order == 2 && rows > 1 &&
           recorded_derivative(recording, run) >= 0 &&
           trace_time(run->trace, rows - 1) > trace_time(run->trace, 0);
}

/* Fits y = a + b x by least squares, with the noise in the recorded values y, and stores the
 * inverse, which converts the recording to the run's scale. */
static void fit_scale(const struct overlap_sums *s, struct data_distance *d)
{
    const double slope = s->xy / s->xx, left = s->yy - slope * s->xy;
    const bool follows = s->xy * s->xy > FOLLOWED_VARIANCE_MIN * s->xx * s->yy;
    d->scaled = true;
    d->gain = follows ? 1 / slope : NAN;
    d->at_zero = follows ? s->x - s->y / slope : NAN;
    d->rms = sqrt(fmax(s->xx > 0 ? left : s->yy, 0) / s->n);
}

/* Sets *good to the samples without those that the recording itself shows to be bad. Returns false
 * if out of memory. */
static bool find_good(struct recording *recording, const struct series *all, struct arena *arena,
                      struct series *good)
{
    struct error ignored;
    unsigned char *use = arena_alloc(arena, all->n + 1);
    double *t = arena_array(arena, all->n + 1, sizeof *t),
           *y = arena_array(arena, all->n + 1, sizeof *y);
    if (!use || !t || !y)
        return false;
    if (!series_outliers(all, arena, use)) {
        struct recording clean = *recording; /* its arrays are shared */
        clean.cleaned = true;
        return recording_series(&clean, arena, 2, good, &ignored);
    }
    *good = *all;
    good->t = t;
    good->y = y;
    good->n = 0;
    for (size_t i = 0; i < all->n; i++)
        if (use[i]) {
            t[good->n] = all->t[i];
            y[good->n++] = all->y[i];
        }
    return true;
}

/* Returns the mean difference if it dominates the rms and is visible, else NAN. */
static double main_offset(const struct overlap_sums *s)
{
    static const double share_of_square = 0.5, visible = 0.1 /* standard deviations */;
    const double offset = s->y - s->x, square = offset * offset;
    return square > share_of_square * s->apart / s->n && square > visible * visible * s->yy / s->n
               ? offset
               : NAN;
}

/* Computes in *distance the rms distance of the recording's good samples from the run; recordings
 * of another quantity get a fitted scale. *distance remains unchanged if they cannot be
 * compared. */
void find_distance(const struct run *run, struct recording *recording,
                   struct data_distance *distance)
{
    struct arena arena = {0};
    struct series all, good;
    struct error ignored;
    struct data_distance result = *distance;
    result.derivative = recorded_derivative(recording, run);
    if (!can_compare(run, recording))
        return;
    const enum quantity own = recording->column[recording->value].quantity;
    result.quantity = recorded_bare(recording) ? system_variable(&run->system, 0).quantity : own;
    if (find_faults(recording, NAN, &arena, &ignored) &&
        recording_series(recording, &arena, 2, &all, &ignored) &&
        find_good(recording, &all, &arena, &good)) {
        const size_t used = samples_spanned(run, &good);
        struct overlap_sums moments;
        overlap_sum(run, &good, result.derivative, &moments);
        result.bad = used >= 2 ? samples_spanned(run, &all) - used : 0;
        if (used >= 2 && quantity_is_scaled(own) &&
            own != system_variable(&run->system, 0).quantity) {
            fit_scale(&moments, &result);
        } else if (used >= 2) {
            result.rms = sqrt(moments.apart / (double)used);
            result.offset = result.derivative == 0 ? main_offset(&moments) : NAN;
        }
    }
    arena_reset(&arena);
    *distance = result;
}
