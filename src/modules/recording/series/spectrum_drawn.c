/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The spectrum that is drawn, and that of recordings with gaps: |sum w y exp(i omega t)| over the
 * existing samples, at their true times, so that the height of a line is its amplitude whatever is
 * missing. A sample between points of the grid is spread over the four points around it, by the
 * weights of interpolation (Press and Rybicki 1989, Astrophys. J. 338:277). A grid twice as fine
 * makes that accurate to (3/128) (pi/2)^4 at the end of the axis, and to 3e-5 at ten samples a
 * period. */
#include <hooke/base/cancel.h>
#include "modules/recording/series/internal.h"

#include <math.h>

/* A step longer than this number of median steps is a gap. */
#define GAP_USUAL_STEPS 8
/* Bins per 1/span: a line between two bins is drawn at most 0.3 % too low. */
#define BINS_PER_LINE_WIDTH 8
/* Largest number of bins for that; longer series get one bin for each sample. */
#define FINE_MAX 1048576
/* Points of the grid before the first sample; two follow the last one. */
#define GRID_MARGIN_POINTS 1

/* Returns the usual time step [s], the mean of all that are not gaps, or 0 if there is none. Sets
 * *gap to the shortest step that is a gap. scratch [n] is work space. */
static double usual_step(const struct samples *x, double *scratch, double *gap)
{
    double span = 0;
    size_t steps = 0;
    for (size_t i = 0; i + 1 < x->n; i++)
        scratch[i] = x->t[i + 1] - x->t[i];
    *gap = GAP_USUAL_STEPS * values_quantile(scratch, x->n - 1, 0.5);
    for (size_t i = 0; i + 1 < x->n; i++) {
        const double step = x->t[i + 1] - x->t[i];
        if (step < *gap) {
            span += step;
            steps++;
        }
    }
    return steps > 0 ? span / (double)steps : 0;
}

/* Sets duration [n] to the time [s] that each sample represents: half the step to either neighbour,
 * without gaps. */
static void sample_durations(const struct samples *x, double gap, double step, double *duration)
{
    for (size_t i = 0; i < x->n; i++)
        duration[i] = 0;
    for (size_t i = 0; i + 1 < x->n; i++) {
        const double apart = x->t[i + 1] - x->t[i];
        const double half = 0.5 * (apart < gap ? apart : step);
        duration[i] += half;
        duration[i + 1] += half;
    }
    duration[0] += 0.5 * step;
    duration[x->n - 1] += 0.5 * step;
}

/* Fits a straight line by weighted least squares: line[0] is its value at the time `middle`,
 * line[1] its slope per second. */
static void line_of(const struct samples *x, const double *weight, double middle, double line[2])
{
    double sum = 0, first = 0, second = 0, value = 0, moment = 0;
    for (size_t i = 0; i < x->n; i++) {
        const double s = x->t[i] - middle;
        sum += weight[i];
        first += weight[i] * s;
        second += weight[i] * s * s;
        value += weight[i] * x->y[i];
        moment += weight[i] * s * x->y[i];
    }
    const double determinant = sum * second - first * first;
    line[1] = determinant > 0 ? (sum * moment - first * value) / determinant : 0;
    line[0] = (value - line[1] * first) / sum;
}

/* Adds the value at a position between the points of a grid to the four points around it, with the
 * weights of cubic interpolation. */
static void grid_add(double position, double value, double *grid)
{
    const double lower = floor(position + 1e-6), s = position - lower;
    double *cell = grid + (size_t)lower;
    if (fabs(s) < 1e-5) {
        cell[0] += value;
        return;
    }
    cell[-1] -= value * s * (s - 1) * (s - 2) / 6;
    cell[0] += value * (s + 1) * (s - 1) * (s - 2) / 2;
    cell[1] -= value * (s + 1) * s * (s - 2) / 2;
    cell[2] += value * (s + 1) * s * (s - 1) / 6;
}

/* Spreads the samples, minus their line and under a Hann window over the whole span, on a grid of
 * that spacing [s]. weight [n] is the duration of each sample, `step` the usual step. Returns the
 * sum of the weights. */
static double grid_fill(const struct samples *x, double *weight, double spacing, double step,
                        double *grid)
{
    const double first = x->t[0], span = x->t[x->n - 1] - first + step;
    const double middle = first + 0.5 * (span - step);
    double line[2], gain = 0;
    line_of(x, weight, middle, line);
    for (size_t i = 0; i < x->n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(x->cancel))
            break;
        const double s = x->t[i] - middle;
        const double w = weight[i] * 0.5 * (1 + cos(TWO_PI * s / span));
        gain += w;
        grid_add(GRID_MARGIN_POINTS + (x->t[i] - first) / spacing,
                 w * (x->y[i] - line[0] - line[1] * s), grid);
    }
    return gain;
}

/* Copies the samples that are in use. Returns false if out of memory. */
static bool copy_used(const struct samples *x, struct arena *arena, struct samples *used)
{
    double *t = arena_array(arena, x->n + 1, sizeof *t);
    double *y = arena_array(arena, x->n + 1, sizeof *y);
    *used = *x;
    if (!t || !y)
        return false;
    used->n = 0;
    for (size_t i = 0; i < x->n; i++) {
        if (!x->use[i])
            continue;
        t[used->n] = x->t[i];
        y[used->n++] = x->y[i];
    }
    used->t = t;
    used->y = y;
    return true;
}

/* Returns true if a step is a gap (usual_step()); false for uniform samples, fewer than 8 samples,
 * or if out of memory. Sets *memory to false if out of memory, otherwise to true. */
bool samples_have_gap(const struct samples *x, struct arena *arena, bool *memory)
{
    double gap, *scratch = x->uniform ? NULL : arena_array(arena, x->n + 1, sizeof *scratch);
    *memory = x->uniform || scratch;
    if (!scratch || x->n < 8)
        return false;
    usual_step(x, scratch, &gap);
    for (size_t i = 0; i + 1 < x->n; i++)
        if (x->t[i + 1] - x->t[i] >= gap)
            return true;
    return false;
}

/* Returns the length of the transform, a power of two: finer than the number of points of the
 * times, but limited. */
static size_t bins_of(double points, size_t n)
{
    const double max = fmax(FINE_MAX, 4 * (double)n);
    size_t length = 32;
    while ((double)length < fmin(points, max) ||
           ((double)length < BINS_PER_LINE_WIDTH * points && length < FINE_MAX))
        length *= 2;
    return length;
}

/* Computes the amplitude spectrum of the samples in use, which may have gaps: spreads them on a
 * grid, transforms it, and divides by the sum of the weights. The spectrum is empty if there are
 * too few. Returns false if out of memory or cancelled. */
bool samples_spectrum(const struct samples *all, struct arena *arena, struct spectrum *spectrum)
{
    struct samples x;
    double gap = 0, *weight = arena_array(arena, all->n + 1, sizeof *weight);
    *spectrum = (struct spectrum){.amplitude = NULL};
    if (!weight || !copy_used(all, arena, &x) || cancelled(all->cancel))
        return false;
    const double step = x.n < 8 ? 0 : usual_step(&x, weight, &gap);
    if (!(step > 0))
        return true;
    const double span = x.t[x.n - 1] - x.t[0];
    const size_t finer = x.uniform ? 1 : 2, length = bins_of(span / step + 4, x.n);
    /* If a gap is so long that the grid would be too large, the grid is coarser. */
    const double apart = fmax(step, span / ((double)length - 4));
    double *grid = arena_array(arena, 2 * finer * length, sizeof *grid);
    if (!grid || cancelled(x.cancel))
        return false;
    sample_durations(&x, gap, step, weight);
    const double gain = grid_fill(&x, weight, apart / (double)finer, step, grid);
    if (cancelled(x.cancel) ||
        !transform_real(grid, finer * length, grid + finer * length, x.cancel))
        return false;
    for (size_t k = 0; k <= length / 2; k++) {
        const bool real = k == 0 || 2 * k == finer * length;
        grid[k] = (real ? fabs(grid[k]) : 2 * hypot(grid[k], grid[finer * length - k])) / gain;
    }
    *spectrum = (struct spectrum){grid, length / 2 + 1, 1 / ((double)length * apart)};
    return true;
}

/* Computes the amplitudes of a series' spectrum and the array of their frequencies [Hz], both
 * [*bins] in the arena. Returns false if there are too few samples or if out of memory. */
bool series_spectrum(const struct series *series, struct arena *arena, const double **frequency,
                     const double **amplitude, size_t *bins)
{
    struct samples samples;
    struct spectrum spectrum;
    *bins = 0;
    if (series->n < 8 || !samples_init(&samples, series, arena) ||
        !samples_spectrum(&samples, arena, &spectrum))
        return false;
    double *f = arena_array(arena, spectrum.bins + 1, sizeof *f);
    if (!f || spectrum.bins == 0)
        return false;
    for (size_t k = 0; k < spectrum.bins; k++)
        f[k] = spectrum.step * (double)k;
    *frequency = f;
    *amplitude = spectrum.amplitude;
    *bins = spectrum.bins;
    return true;
}
