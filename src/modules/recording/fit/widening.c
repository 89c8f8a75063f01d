/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes by how much correlated residuals are less informative about each parameter than
 * independent ones. Amplitude and decay depend on residuals in phase with the oscillation, phase
 * and frequency on those a quarter period off, the offset on slow ones: sway affects only the
 * first, a wandering offset only the last. */
#include "modules/recording/series/internal.h"

#include <math.h>

/* Length of a window in periods, and the smallest number of windows that is judged. */
enum { PERIODS = 2, WINDOWS_MIN = 8 };

/* Sums over windows of the residuals' component in one of the two directions (in phase or in
 * quadrature), scaled to the variance of one sample. */
struct window_sums {
    /* Sums of squares, of products of neighbours, of norms; and the component in the previous
     * window. */
    double square, product, norm, previous;
};

/* Adds one window, given the sum of residual times direction and the squared norm of the
 * direction. */
static void add_window(struct window_sums *d, double sum, double norm)
{
    double z = sum / sqrt(norm);
    d->square += norm * z * z;
    d->product += d->previous == 0 ? 0 : norm * z * d->previous;
    d->norm += norm;
    d->previous = z;
}

/* Returns the factor of the variance: that of the windows relative to the samples, enlarged by the
 * correlation of neighbouring windows; 1 if it exceeds 1 by no more than chance. */
static double factor_of(const struct window_sums *d, double windows, double variance, int fitted)
{
    double ratio = d->square / d->norm / variance * windows / fmax(windows - fitted, 1);
    double rho = d->square > 0 ? d->product / d->square : 0;
    double factor = ratio * autocorrelation_factor(rho - 1 / sqrt(windows));
    return factor > 1 + sqrt(2 / windows) ? factor : 1;
}

/* Returns factors of the variances of amplitude, phase and offset of an oscillation that slow
 * changes in the residuals cause, from sums of windows of two periods. `fitted` is the number of
 * parameters fitted in each direction. Too few windows give the factor of the lag-1 autocorrelation
 * for all. */
struct widening residual_widening(const struct samples *x, const double *residual,
                                  const struct oscillation *o, int fitted)
{
    struct window_sums in_phase = {0}, quadrature = {0};
    double lag = autocorrelation_factor(residual_autocorrelation(x, residual)), square = 0,
           used = 0, windows = 0;
    double period = TWO_PI / o->omega, end = x->n > 0 ? x->t[0] + PERIODS * period : 0;
    double sum[2] = {0, 0}, norm[2] = {0, 0};
    for (size_t i = 0; i <= x->n; i++) {
        if (i == x->n || x->t[i] >= end) {
            bool whole = i < x->n || end - x->t[x->n - 1] < 0.25 * PERIODS * period;
            if (whole && norm[0] > 0 && norm[1] > 0) {
                add_window(&in_phase, sum[0], norm[0]);
                add_window(&quadrature, sum[1], norm[1]);
                windows++;
            }
            end += PERIODS * period;
            sum[0] = sum[1] = norm[0] = norm[1] = 0;
        }
        if (i < x->n && x->use[i]) {
            double s = x->t[i] - o->origin, e = exp(-0.5 * o->gamma * s), c = cos(o->omega * s),
                   d = sin(o->omega * s);
            double u = e * (o->a * c + o->b * d), v = e * (o->b * c - o->a * d);
            sum[0] += u * residual[i];
            sum[1] += v * residual[i];
            norm[0] += u * u;
            norm[1] += v * v;
            square += residual[i] * residual[i];
            used++;
        }
    }
    if (windows < WINDOWS_MIN || !(square > 0))
        return (struct widening){lag, lag, lag};
    double variance = square / used;
    return (struct widening){factor_of(&in_phase, windows, variance, fitted),
                             factor_of(&quadrature, windows, variance, fitted), lag};
}
