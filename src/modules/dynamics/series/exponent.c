/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The largest Lyapunov exponent of a series, or the reason why it is not determined.
 * series_exponent() checks the series, embeds it, and measures how fast neighbours separate. */
#include <hooke/base/cancel.h>
#include "modules/dynamics/series/space.h"

#include "modules/dynamics/series/series_exponent.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#define MEAN_CROSSINGS_MIN 20 /* crossings of the mean, upwards */
#define SERIES_PARTS 4 /* parts of the series, which are compared to see whether it is steady */
#define PART_SIZE_RATIO_MAX 2 /* largest ratio of the standard deviations of two parts */
#define PART_MEAN_DRIFT_MAX 2 /* largest difference of their means, in standard deviations */
/* Largest prediction error relative to that of a linear function. */
#define PREDICTION_ERROR_RATIO 0.7
#define EXTRA_DELAYS 2   /* additional delays, whose effect counts as an error */
#define HORIZON_TURNS 40 /* largest number of turns for which neighbours are followed */
/* Largest relative difference between the exponents of both halves. */
#define HALVES_DIFFERENCE_MAX 0.5
/* Distances that grow by less than this factor do not grow at all. */
#define DISTANCE_GROWTH_MIN 3.0

/* Error of flows with known exponents beyond the scatter (Lorenz x and z, Roessler, the driven
 * pendulum, Duffing; 5000 and 20 000 samples, 16 starts each: -11 to +13 %). */
#define SYSTEMATIC_ERROR_RELATIVE 0.08

/* Stores the reason why the exponent is not determined. Returns true, since that is a result. */
static bool set_undetermined(struct series_exponent *found, const char *format, ...)
    PRINTF_LIKE(2, 3);
/* The text is cut off if it is longer than found->reason. */
static bool set_undetermined(struct series_exponent *found, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(found->reason, sizeof found->reason, format, args);
    va_end(args);
    return true;
}

/* ---- requirements ---- */

/* Mean and standard deviation of a part of the series. */
struct part_moments {
    double mean, sigma;
};

/* Returns mean and standard deviation of samples begin to end - 1. */
static struct part_moments moments_of_part(const double *y, size_t begin, size_t end)
{
    struct part_moments p = {0};
    const double n = (double)(end - begin);
    for (size_t i = begin; i < end; i++)
        p.mean += y[i] / n;
    for (size_t i = begin; i < end; i++)
        p.sigma += (y[i] - p.mean) * (y[i] - p.mean) / n;
    p.sigma = sqrt(p.sigma);
    return p;
}

/* Returns true if size (standard deviation) and mean of the motion are much the same in
 * SERIES_PARTS successive parts; otherwise stores the reason. */
static bool is_steady(const struct samples *x, struct series_exponent *found)
{
    double low = HUGE_VAL, high = 0, left = HUGE_VAL, right = -HUGE_VAL;
    for (size_t k = 0; k < SERIES_PARTS; k++) {
        const struct part_moments p =
            moments_of_part(x->y, k * x->n / SERIES_PARTS, (k + 1) * x->n / SERIES_PARTS);
        low = fmin(low, p.sigma);
        high = fmax(high, p.sigma);
        left = fmin(left, p.mean);
        right = fmax(right, p.mean);
    }
    if (high > PART_SIZE_RATIO_MAX * low)
        return !set_undetermined(
            found,
            "the size of the motion changes: between quarters of the time by a factor of %.3g",
            high / low);
    if (right - left > PART_MEAN_DRIFT_MAX * high)
        return !set_undetermined(
            found,
            "the motion drifts: between quarters of the time its mean moves by %.3g times its size",
            (right - left) / high);
    return true;
}

/* Returns the number of upward crossings of the mean, and sets *turn to the mean time between them
 * [samples]. */
static size_t count_turns(const struct samples *x, double mean, double *turn)
{
    size_t count = 0;
    for (size_t i = 1; i < x->n; i++)
        count += x->y[i - 1] < mean && x->y[i] >= mean;
    *turn = count > 0 ? (double)x->n / (double)count : (double)x->n;
    return count;
}

/* Returns true if the series can be analysed; otherwise stores the reason. Sets *turn as
 * count_turns(). */
static bool is_suitable(const struct samples *x, const struct part_moments *moments, double *turn,
                        struct series_exponent *found)
{
    if (x->n < EXPONENT_SAMPLES)
        return !set_undetermined(found, "%zu samples are too few, %d are needed", x->n,
                                 EXPONENT_SAMPLES);
    if (!x->uniform)
        return !set_undetermined(
            found, "the samples are not evenly spaced in time (of a run: a method with fixed "
                   "steps)");
    if (!(moments->sigma > 1e-12 * fabs(moments->mean)) || !isfinite(moments->sigma))
        return !set_undetermined(found, "nothing moves");
    if (!is_steady(x, found))
        return false;
    const size_t turns = count_turns(x, moments->mean, turn);
    if (turns < MEAN_CROSSINGS_MIN)
        return !set_undetermined(found, "the motion turns only %zu times; %d turns are needed",
                                 turns, MEAN_CROSSINGS_MIN);
    return true;
}

/* ---- embedding ---- */

/* Chooses the delay and the dimension; if the first delay unfolds nothing, half and a quarter of it
 * are tried. sigma is the standard deviation of the samples. Returns false if out of memory or if
 * cancelled; found->dimensions is 0, with the reason set, if no number of delays unfolds the
 * motion. */
static bool choose_embedding(struct delay_space *space, const struct samples *x, double sigma,
                             struct arena *arena, struct series_exponent *found)
{
    double share = NAN;
    int dimensions = 0;
    space->delay = choose_delay(x->y, x->n, x->cancel, arena);
    if (space->delay == 0 || !space_sort(space, x->n, arena))
        return false;
    for (int half = 0; half < 3 && dimensions == 0; half++) {
        if (half > 0 && space->delay < 2)
            break;
        space->delay /= half > 0 ? 2 : 1;
        dimensions = choose_dimensions(space, x->n, sigma, &share);
    }
    if (dimensions < 0)
        return false;
    found->dimensions = dimensions;
    found->delay = space->delay * x->dt;
    return dimensions > 0 ||
           set_undetermined(
               found,
               "no number of delays up to %d unfolds the motion (%.2g %% false neighbours): it "
               "is noise, or has too many variables for this record",
               SPACE_DIMENSIONS - 2, 100 * share);
}

/* ---- separation of neighbours ---- */

/* Returns for how many samples neighbours are followed; `turn` is the mean time between crossings
 * [samples]. */
static size_t horizon_of(const struct samples *x, int delays, int delay, double turn)
{
    const size_t window = (size_t)(delays * delay);
    return (size_t)fmin((double)(x->n - window) / 4, HORIZON_TURNS * turn);
}

/* Computes divergence and growth with that number of delayed values. Returns false if out of memory
 * or cancelled. */
static bool measure_growth(const struct delay_space *space, const struct samples *x, int dimensions,
                           double turn, struct arena *arena, struct divergence *divergence,
                           struct even_growth *growth)
{
    struct delay_space s = *space;
    s.dimensions = dimensions;
    const size_t window = (size_t)((dimensions - 1) * s.delay),
                 horizon = horizon_of(x, dimensions - 1, s.delay, turn);
    s.points = x->n - window - horizon - 1;
    if (!divergence_find(&s, horizon, arena, divergence))
        return false;
    *growth = divergence_growth(divergence, window / divergence->stride + 1);
    return true;
}

/* Returns true with a reason stored if distances do not grow exponentially. `step` [s] is that of
 * the divergence. */
static bool is_not_exponential(const struct divergence *d, const struct even_growth *g, double step,
                               struct series_exponent *found)
{
    const double growth = g->slope * (double)(g->last - g->first),
                 rise = d->last - d->mean[g->first];
    if (rise < log(DISTANCE_GROWTH_MIN))
        return set_undetermined(
            found,
            "neighbours do not separate: the motion is periodic or quasi-periodic, or decays");
    if (!(g->error >= 0) || !(growth >= log(EXPONENT_GROWTH)))
        return set_undetermined(
            found,
            "distances grow exponentially by less than a factor of %g before they reach "
            "the size of the motion: too much noise, or too short a record",
            EXPONENT_GROWTH);
    if (fabs(g->halves[0] - g->halves[1]) > HALVES_DIFFERENCE_MAX * g->slope)
        return set_undetermined(found,
                                "distances do not grow exponentially: at %.3g, then at %.3g 1/s",
                                g->halves[0] / step, g->halves[1] / step);
    return false;
}

/* Sets *found to the exponent of the series with its error, or to the reason why there is none. The
 * error combines the scatter between parts of the series, the change with more delays, the
 * difference between both halves of the curve of growth, and a systematic part. `turn` is the
 * duration of one oscillation [sample]. Returns false if out of memory or cancelled. */
static bool find_exponent(const struct delay_space *space, const struct samples *x, double turn,
                          struct arena *arena, struct series_exponent *found)
{
    struct divergence d;
    struct even_growth g, deeper;
    double spread = 0;
    if (!measure_growth(space, x, space->dimensions, turn, arena, &d, &g))
        return false;
    const double step = x->dt * (double)d.stride;
    found->pairs = d.pairs;
    if (is_not_exponential(&d, &g, step, found))
        return true;
    for (int k = 1; k <= EXTRA_DELAYS; k++) {
        struct divergence other;
        if (!measure_growth(space, x, space->dimensions + k, turn, arena, &other, &deeper))
            return false;
        if (isfinite(deeper.slope))
            spread = fmax(spread, fabs(deeper.slope - g.slope));
    }
    const double halves = fabs(g.halves[0] - g.halves[1]) / 2,
                 method = space->delay > 1 ? SYSTEMATIC_ERROR_RELATIVE * g.slope : 0,
                 error =
                     sqrt(g.error * g.error + spread * spread + halves * halves + method * method);
    if (error > HALVES_DIFFERENCE_MAX * g.slope)
        return set_undetermined(found,
                                "%.3g 1/s is not significantly different from 0 (error %.3g)",
                                g.slope / step, error / step);
    found->value = (struct measured){g.slope / step, error / step};
    found->t_begin = (double)g.first * step;
    found->t_end = (double)g.last * step;
    found->growth = exp(g.slope * (double)(g.last - g.first));
    found->determined = true;
    return true;
}

/* Checks the series, embeds it, compares predictions with a linear function, then measures exponent
 * and dimension. */
bool series_exponent(const struct series *series, struct arena *arena,
                     struct series_exponent *found, struct error *error)
{
    struct samples x;
    double turn = 0;
    *found = (struct series_exponent){.value = {NAN, NAN}, .dimension = {NAN, NAN}};
    snprintf(found->dimension_reason, sizeof found->dimension_reason,
             "no number of delays unfolds the motion");
    if (!samples_init(&x, series, arena))
        return cancelled(series->cancel) ? error_set(error, ERROR_CANCELLED, "stopped")
                                         : error_memory(error);
    const struct part_moments moments = moments_of_part(x.y, 0, x.n);
    if (!is_suitable(&x, &moments, &turn, found))
        return true;
    struct delay_space space = {.y = x.y, .theiler_window = (size_t)turn, .cancel = series->cancel};
    found->theiler_window = turn * x.dt;
    bool fine = choose_embedding(&space, &x, moments.sigma, arena, found);
    if (fine && found->dimensions > 0) {
        const double ratio = prediction_ratio(&space, x.n, (size_t)space.delay);
        if (!(ratio < PREDICTION_ERROR_RATIO))
            set_undetermined(found,
                             "a linear function of the same values predicts %s: noise, or sines",
                             ratio < 1 / PREDICTION_ERROR_RATIO ? "as well" : "better");
        else
            fine = find_exponent(&space, &x, turn, arena, found) &&
                   correlation_dimension(&space, x.n, arena, found);
    }
    if (fine)
        return true;
    return cancelled(series->cancel) ? error_set(error, ERROR_CANCELLED, "stopped")
                                     : error_memory(error);
}
