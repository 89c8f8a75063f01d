/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tests a period by its cycles one by one: whether they alternate, and how their times scatter. */
#include "modules/recording/period/cycle.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Largest number of cycles that are judged. */
enum { CYCLES_USED = 128 };

/* Returns the probability that values x [n] which follow a straight line or a parabola differ by
 * chance as much as these do between every `turns`-th one and the others. The test uses their
 * uncertainties or, if larger, their scatter. Returns 1 if there are too few values. */
static double turns_chance(const struct measured *x, size_t n, size_t turns)
{
    enum { COLUMNS = 5, WIDTH = COLUMNS + 1, PARABOLA_MIN = 8 };
    static const double scatter_chance = 0.05;
    const int smooth = n < PARABOLA_MIN ? 2 : 3, columns = smooth + (int)turns - 1;
    double a[WIDTH * WIDTH] = {0}, square = 0, gained = 0;
    if (n < (size_t)columns)
        return 1;
    for (size_t k = 0; k < n; k++) {
        const double u = 2 * (double)k / (double)(n - 1) - 1;
        double column[WIDTH] = {1, u, u * u};
        for (int j = smooth; j < columns; j++)
            column[j] = k % turns == (size_t)(j - smooth);
        column[columns] = x[k].value - x[0].value;
        for (int i = 0; i <= columns; i++)
            for (int j = 0; j <= i; j++)
                a[WIDTH * i + j] += column[i] * column[j] / (x[k].uncertainty * x[k].uncertainty);
    }
    double *r = a + WIDTH * columns;
    square = r[columns];
    if (!matrix_cholesky(columns, WIDTH, a, 1e-10, a))
        return 1;
    cholesky_forward(columns, WIDTH, a, r);
    for (int j = 0; j < columns; j++) {
        square -= r[j] * r[j];
        gained += j < smooth ? 0 : r[j] * r[j];
    }
    const double ways = (double)turns - 1, freedom = (double)n - columns,
                 chance = gsl_cdf_chisq_Q(gained, ways);
    if (freedom < 1 || gsl_cdf_chisq_Q(square, freedom) > scatter_chance)
        return chance;
    return fmax(chance, gsl_cdf_fdist_Q(gained / ways / (square / freedom), ways, freedom));
}

/* Values of a cycle that may distinguish it from its neighbours. */
enum { CYCLE_HEIGHT, CYCLE_MEAN, CYCLE_TIME, CYCLE_VALUES };

/* Sets value [count] to one quantity of each cycle. The uncertainties follow from the variance of
 * the rows and from shape_error [y], by which the mean cycle may be off all along a cycle. */
static void cycle_values(const struct cycles *c, int kind, double variance, double shape_error,
                         struct measured *value)
{
    double height = 0;
    for (size_t k = 0; k < c->count; k++)
        height += c->cycle[k].height / (double)c->count;
    for (size_t k = 0; k < c->count; k++) {
        const struct cycle *y = &c->cycle[k];
        const double row = variance + shape_error * shape_error * y->rows,
                     relative = sqrt(row / y->power) / height;
        if (kind == CYCLE_HEIGHT)
            value[k] = (struct measured){log(y->height), relative * height / y->height};
        else if (kind == CYCLE_MEAN)
            value[k] = (struct measured){y->mean, sqrt(row / y->rows)};
        else
            value[k] = (struct measured){y->t - c->cycle[0].t - (double)k * c->period,
                                         sqrt(row / y->slope) / y->height};
    }
}

/* Returns the mean square of the rows about the mean of their cycle. */
static double cycles_square(const struct cycles *c)
{
    double square = 0;
    for (size_t k = 0; k < c->count; k++)
        square += c->cycle[k].square / (double)c->count;
    return square;
}

/* Returns by how much [y] sampling alone may separate the rows of cycles with edges, 0 without
 * edges: an edge falls between samples, up to half a sample off. If the true period has `turns`
 * cycles, all cycles of one position in it may share that. */
static double edge_error(const struct cycles *c, size_t turns, double noise)
{
    /* least edge and largest noise, relative to the range */
    static const double edge_min = 0.75, noise_max = 0.1;
    const struct samples *x = c->samples;
    double low = HUGE_VAL, high = -HUGE_VAL, edge = 0;
    for (size_t i = 0; i < x->n; i++) {
        low = fmin(low, x->y[i]);
        high = fmax(high, x->y[i]);
        edge = fmax(edge, i > 0 ? fabs(x->y[i] - x->y[i - 1]) : 0);
    }
    if (edge < edge_min * (high - low) || noise > noise_max * (high - low))
        return 0;
    return edge * sqrt((double)c->count / (double)turns / 6 / c->cycle[0].rows);
}

/* Returns by how much [y] the mean cycle is off the rows. If the samples repeat their positions
 * after `turns` cycles, it may be off equally in each: by what noise does not explain and by what
 * straight lines between bins miss. A step of the sensor and a small part of the size are always
 * included. */
static double template_error(const struct cycles *c, size_t turns, double left, double noise)
{
    static const double small = 1e-3, coherent = 0.3, all_noise = 1.5, rounding = 0.3;
    const struct samples *x = c->samples;
    const double samples = c->period / (x->t[x->n - 1] - x->t[0]) * (double)(x->n - 1),
                 drift = fabs(remainder((double)turns * samples, 1)) * (double)c->count,
                 angle = TWO_PI / fmin(samples, (double)c->bins), size = sqrt(cycles_square(c)),
                 least = hypot(turns > 0 ? edge_error(c, turns, noise) : 0,
                               hypot(small * size, rounding * samples_quantum(x))),
                 missed = coherent * sqrt(fmax(left - all_noise * noise * noise, 0));
    if (turns > 0 && !(drift < 2))
        return least;
    return hypot(hypot(least, missed), turns > 0 ? size * angle * angle / 8 : 0);
}

/* Returns the variance of the rows about the mean cycle, summed over cycles, or -1 if some cycle
 * does not resemble the mean. */
static double cycles_left(const struct cycles *c)
{
    static const double least = 0.2; /* least height of a cycle relative to the mean */
    double left = 0, height = 0;
    for (size_t k = 0; k < c->count; k++)
        height += c->cycle[k].height / (double)c->count;
    for (size_t k = 0; k < c->count; k++) {
        if (!(c->cycle[k].height > least * height))
            return -1;
        left += c->cycle[k].left / (double)(c->count - 1);
    }
    return left;
}

/* Returns the smallest probability, over height, mean and time, that the cycles alternate by
 * chance; NAN if not all resemble their mean. value [count] is work space. */
static double cycles_chance(const struct cycles *c, size_t turns, double noise,
                            struct measured *value)
{
    const double left = cycles_left(c), shape_error = template_error(c, turns, left, noise);
    double least = 1;
    if (left < 0)
        return NAN;
    for (int kind = 0; kind < CYCLE_VALUES; kind++) {
        cycle_values(c, kind, left, shape_error, value);
        least = fmin(least, turns_chance(value, c->count, turns));
    }
    return least;
}

/* A model for times of cycles that scatter more than their uncertainties, and what it yields. */
struct times_model {
    /* [s^2] variance of each time; variance that each adds to all later ones */
    double scatter, walk;
    double likelihood;      /* logarithm of the likelihood */
    struct measured period; /* [s] */
};

/* Estimates m->period by a Kalman filter of time and period over n times less multiples of a
 * period, with the scatter and walk of the model, and its likelihood. spread [s^2] sets the unknown
 * start. */
static void follow_times(const struct measured *time, size_t n, double spread,
                         struct times_model *m)
{
    static const double unknown = 1e6;
    double x = 0, d = 0, xx = unknown * spread, xd = 0, dd = unknown * spread;
    m->likelihood = 0;
    for (size_t k = 0; k < n; k++) {
        const double f = xx + m->scatter + time[k].uncertainty * time[k].uncertainty,
                     innovation = time[k].value - x, gain_x = xx / f, gain_d = xd / f;
        m->likelihood -= 0.5 * (log(f) + innovation * innovation / f);
        x += gain_x * innovation;
        d += gain_d * innovation;
        dd -= gain_d * xd;
        xd -= gain_d * xx;
        xx -= gain_x * xx;
        m->period = (struct measured){d, sqrt(fmax(dd, 0))};
        x += d;
        xx += 2 * xd + dd + m->walk;
        xd += dd;
    }
}

/* Returns the correction to the period from the times of cycles, which are less multiples of the
 * period [s]. Each may be a random time off its place, or off the previous cycle: the mean over
 * both models is weighted by their likelihoods. Sets *excess to the variance beyond that of noise
 * alone, of which noise_share is already accounted for, and *surprising if the times clearly
 * scatter more. */
static struct measured period_of_times(const struct measured *time, size_t n, double noise_share,
                                       bool *surprising, double *excess)
{
    enum { STEPS = 6 };
    static const double step = 4, first_scatter = 1.0 / 64, first_walk = 1.0 / 16;
    /* Likelihood of more than noise over that of noise alone; it is up to 4 where neither is
     * likelier. */
    static const double evidence_min = 4, evidence_sure = 20;
    struct line_fit line;
    double place[CYCLES_USED], spread = 0, weight = 0, value = 0, square = 0, variance = 0;
    struct times_model model[STEPS + 1][STEPS + 1], *none = &model[0][0];
    for (size_t k = 0; k < n; k++)
        place[k] = (double)k;
    *excess = 0;
    *surprising = false;
    if (!line_fit(place, time, (int)n, &line))
        return (struct measured){0, HUGE_VAL};
    for (size_t k = 0; k < n; k++) {
        const double residual = time[k].value - line.intercept.value - line.slope.value * place[k];
        spread += (residual * residual + time[k].uncertainty * time[k].uncertainty) / (double)n;
    }
    for (int i = 0; i <= STEPS; i++)
        for (int j = 0; j <= STEPS; j++) {
            struct times_model *m = &model[i][j];
            *m = (struct times_model){.scatter = 0};
            double prior = 1;
            if (i > 0) {
                m->scatter = spread * first_scatter * pow(step, i - 1);
                prior *= 1.0 / STEPS;
            }
            if (j > 0) {
                m->walk = spread * first_walk / (double)n * pow(step, j - 1);
                prior *= 1.0 / STEPS;
            }
            follow_times(time, n, spread, m);
            const double w = prior * exp(fmin(m->likelihood - none->likelihood, 600));
            weight += w;
            value += w * m->period.value;
            square += w * m->period.value * m->period.value;
            variance += w * m->period.uncertainty * m->period.uncertainty;
        }
    value /= weight;
    variance = variance / weight + fmax(square / weight - value * value, 0);
    const double noise = none->period.uncertainty * none->period.uncertainty;
    *surprising = weight > evidence_sure;
    *excess = (weight > evidence_min ? variance : noise) - noise_share * noise;
    return (struct measured){value, sqrt(variance)};
}

/* Selects in *rows the part of the series by which the cycles of the period p are judged, thinned
 * if there are many. Returns false if there are too few. */
static bool doubt_rows(const struct series *series, const struct period *p, struct arena *arena,
                       struct series *rows)
{
    enum { ROWS_A_CYCLE = 64, ROWS_MIN = 16 };
    /* This number of rows shows how few cycles differ, and many no less. */
    static const double whole = 0.8, rows_max = 3072;
    struct series part = *series;
    if (p->last > p->first && p->last - p->first < whole * (part.t[part.n - 1] - part.t[0]))
        part = series_window(*series, p->first - p->period.value, p->last + p->period.value);
    part = series_longest_stretch(&part, p->period.value);
    if (part.n < 2)
        return false;
    const double cycles = (part.t[part.n - 1] - part.t[0]) / p->period.value,
                 each = (double)part.n / cycles,
                 wanted = fmin(ROWS_A_CYCLE, rows_max / fmin(cycles, CYCLES_USED)),
                 stride = floor(fmax(each / wanted, 1)),
                 used = fmin(each / stride * (CYCLES_USED - 1), (double)part.n);
    return cycles >= CYCLES_MIN &&
           series_lively_part(&part, (size_t)stride, (size_t)used, arena, rows) &&
           rows->n >= ROWS_MIN;
}

/* Widens a period by the scatter of its cycles' times, and warns if that is most of its
 * uncertainty. `noise` is that of a sample, value [c->count] is work space. */
static void widen_by_times(const struct cycles *c, double noise, struct measured *value,
                           struct period *period)
{
    static const double contradicts = 3, share_min = 0.8, most = 2;
    double excess;
    bool surprising;
    const double left = cycles_left(c), error = template_error(c, 0, left, noise),
                 left_share = left / (left + error * error * c->cycle[0].rows);
    const bool same = strcmp(period->how, "cycles") == 0; /* the same times */
    cycle_values(c, CYCLE_TIME, left, error, value);
    const struct measured difference =
        period_of_times(value, c->count, same ? left_share : 1, &surprising, &excess);
    const double share = fmin((double)c->count / fmax(period->periods, 1), 1),
                 more = sqrt(fmax(share * excess, 0)), stated = period->period.uncertainty;
    period->period.uncertainty = fmax(stated, more);
    if (share > share_min &&
        fabs(difference.value) >
            contradicts * hypot(difference.uncertainty, period->period.uncertainty))
        period->period.uncertainty = hypot(period->period.uncertainty, difference.value);
    if (surprising && period->period.uncertainty > most * stated && !period->warning[0])
        snprintf(period->warning, sizeof period->warning,
                 "the times of the cycles vary by more than the noise; T is their mean, with a "
                 "larger uncertainty");
}

/* Returns false if a weaker line near `turns` periods may make cycles alternate by chance: a line
 * at no whole number of periods, whose period [s] is stored in *line, or a small one beside a sine,
 * whose frequency is uncertain. residual [n] is work space. */
static bool repeats_in_turn(const struct cycles *c, size_t turns, double *residual, double *line)
{
    /* Amplitude and distance of a line in standard deviations; relative distance. */
    static const double seen = 5, apart = 3, far = 0.15;
    /* Amplitude relative to the wave; relative uncertainty of the frequency. */
    static const double weak = 0.05, spread_max = 2e-3;
    struct samples x = *c->samples;
    const double n = (double)turns, middle = 0.5 * (x.t[0] + x.t[x.n - 1]);
    struct harmonic wave = {.omega = TWO_PI / c->period, .origin = middle},
                    slow = {.omega = TWO_PI / (n * c->period), .origin = middle};
    *line = NAN;
    if (!harmonic_fit(&x, FREE_GAMMA, &wave, residual))
        return true;
    x.y = residual;
    if (!harmonic_fit(&x, FREE_OMEGA, &slow, NULL) || !slow.converged)
        return true;
    const double sigma = harmonic_sigma(&slow, FREE_OMEGA), ratio = n * slow.omega / wave.omega,
                 spread = sigma * sqrt(slow.inverse[RATE_OMEGA][RATE_OMEGA]) * n / wave.omega,
                 size = hypot(slow.a, slow.b), least = weak * hypot(wave.a, wave.b);
    if (size < seen * sigma * sqrt(2 / (double)slow.used) || fabs(ratio - 1) > far)
        return true;
    if (fabs(ratio - 1) > apart * spread)
        *line = TWO_PI / slow.omega;
    return isnan(*line) && !(size < least && sigma < least && spread > spread_max);
}

/* Tests whether the true period is 2 or 3 times the one found. If that is practically certain,
 * period->period is multiplied and the result is true. Otherwise, if it is probable, or a weaker
 * oscillation makes the cycles differ, only a warning is set. `noise` is the noise of the samples;
 * value and scratch [rows] are work space. */
static bool test_multiples(const struct cycles *c, double noise, struct measured *value,
                           double *scratch, struct period *period)
{
    static const double chance_min = 2e-3, chance_sure = 1e-7;
    enum { MULTIPLES = 3 };
    const double T = period->period.value;
    for (size_t n = 2; n <= MULTIPLES; n++) {
        const double chance = cycles_chance(c, n, noise, value), times = (double)n;
        double line = NAN;
        const bool sure =
            chance < chance_sure && c->count >= 2 * n && repeats_in_turn(c, n, scratch, &line);
        if (isfinite(line)) {
            snprintf(period->warning, sizeof period->warning,
                     "the cycles differ because of a weaker oscillation with a period of %.4g s "
                     "('fit modes 2' finds both)",
                     line);
            return false;
        }
        if (sure) {
            period->period = (struct measured){times * T, times * period->period.uncertainty};
            period->periods = floor(period->periods / times);
            snprintf(period->warning, sizeof period->warning,
                     "cycles of %.5g s alternate: the motion repeats only after %zu of them", T, n);
            return true;
        }
        if (chance < chance_min) {
            if (!period->warning[0])
                snprintf(period->warning, sizeof period->warning,
                         "the period may be %zu times as long: one cycle in %zu differs from the "
                         "others by more than the noise",
                         n, n);
            return false;
        }
    }
    return false;
}

/* Tests a period by the cycles of the series: widens its uncertainty by their times, and replaces
 * it by a multiple or warns if cycles differ in turn. */
void period_doubt(const struct series *series, struct arena *arena, struct period *period)
{
    static const double noise_max = 0.05;
    enum { DOUBLINGS = 3 };
    struct series rows;
    struct samples x;
    struct cycles c;
    struct measured value[CYCLES_USED];
    if (series_is_uneven(series) || !doubt_rows(series, period, arena, &rows) ||
        !samples_init(&x, &rows, arena))
        return;
    double *scratch = arena_array(arena, x.n, sizeof *scratch);
    if (!scratch)
        return;
    const double noise = samples_noise(&x, scratch);
    bool longer = true;
    for (int pass = 0; pass <= DOUBLINGS && longer; pass++) {
        longer = false;
        if (!cycles_find(&c, &x, period->period.value, 0, arena))
            return;
        if (c.count > CYCLES_USED)
            break;
        const bool alike =
            cycles_left(&c) >= 0 && cycles_explained_share(&c) >= cycles_share_needed(c.count);
        if (alike && pass == 0)
            widen_by_times(&c, noise, value, period);
        if (alike)
            longer = test_multiples(&c, noise, value, scratch, period);
        else if (noise * noise < noise_max * cycles_square(&c) && !period->warning[0])
            snprintf(period->warning, sizeof period->warning,
                     "cycles of this length differ, so T may not be the period");
    }
}
