/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The times of whole cycles, each placed against the mean of all (Woody, Med. Biol. Eng. 5 (1967)
 * 539), and what they leave open. */
#include "analysis/period/cycle.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    CYCLES_MIN = 3, /* fewer cycles prove nothing */
    BINS_MIN = 16,  /* of the mean cycle */
    BINS_MAX = 256,
    ALIGN_PASSES = 4,
    CYCLES_USED = 128, /* to judge what they leave open */
};

struct cycle {
    double t, sigma;     /* [s] its begin */
    double mean, height; /* y = mean + height f(phase) */
    double square, left; /* variances, about its mean and about the mean cycle */
    double rows, power, slope; /* of the mean cycle: rows, and sums of squares of it and by time */
};

struct cycles {
    const struct samples *samples;
    double period;       /* [s] */
    struct cycle *cycle; /* [count] */
    size_t count;
    double *shape, *weight; /* [bins] the mean cycle */
    size_t bins;
};

/* Returns the mean cycle at a phase, in periods. */
static double shape_at(const struct cycles *c, double phase)
{
    const double x = (phase - floor(phase)) * (double)c->bins;
    const size_t k = (size_t)x % c->bins, next = (k + 1) % c->bins;
    const double part = x - floor(x);
    return c->shape[k] + part * (c->shape[next] - c->shape[k]);
}

/* Least squares of one cycle against the mean cycle, begun at t. Returns the correlation. */
static double fit_cycle(const struct cycles *c, double t, struct cycle *out)
{
    const struct samples *x = c->samples;
    const double bin = 1.0 / (double)c->bins;
    double n = 0, f = 0, y = 0, ff = 0, fy = 0, yy = 0, slope = 0;
    const size_t from = samples_index(x, t), to = samples_index(x, t + c->period);
    const double y0 = x->y[from < x->n ? from : 0];
    for (size_t i = from; i < to; i++) {
        if (!x->use[i])
            continue;
        const double phase = (x->t[i] - t) / c->period, value = shape_at(c, phase),
                     d = shape_at(c, phase + bin) - shape_at(c, phase - bin), v = x->y[i] - y0;
        n++;
        f += value;
        y += v;
        ff += value * value;
        fy += value * v;
        yy += v * v;
        slope += d * d;
    }
    const double sff = ff - f * f / n, sfy = fy - f * y / n, syy = yy - y * y / n;
    if (n < BINS_MIN / 2 || !(sff > 0) || !(syy > 0))
        return -1;
    slope /= 4 * bin * bin * c->period * c->period;
    *out = (struct cycle){
        .t = t, .height = sfy / sff, .square = syy, .rows = n, .power = sff, .slope = slope};
    out->mean = y0 + (y - out->height * f) / n;
    out->left = fmax(syy - sfy * sfy / sff, 0);
    out->left /= n - 3;
    out->square /= n - 1;
    out->sigma = sqrt(out->left / slope) / fabs(out->height);
    return sfy / sqrt(sff * syy);
}

/* Places one cycle within `reach` periods of the time where it is expected. Returns false if none
 * is like the mean cycle. */
static bool place_cycle(const struct cycles *c, double expected, double reach, struct cycle *out)
{
    const double step = c->period / (double)c->bins;
    const int most = (int)ceil(reach * (double)c->bins);
    double best = 0, value[3] = {NAN, NAN, NAN}, t = expected;
    struct cycle trial;
    for (int k = -most; k <= most; k++) {
        const double r = fit_cycle(c, expected + k * step, &trial);
        if (r > best) {
            best = r;
            t = expected + k * step;
        }
    }
    if (!(best > 0))
        return false;
    for (int k = 0; k < 3; k++)
        value[k] = fit_cycle(c, t + (k - 1) * step, &trial);
    const double bend = value[0] - 2 * value[1] + value[2];
    if (bend < 0)
        t += step * fmin(fmax(0.5 * (value[0] - value[2]) / bend, -0.5), 0.5);
    return fit_cycle(c, t, out) > 0 && out->height > 0;
}

/* Sets the shape to the mean over cycles [from, to), each less its mean and over its height. */
static bool mean_shape(struct cycles *c, size_t from, size_t to)
{
    const struct samples *x = c->samples;
    double sum = 0, used = 0;
    memset(c->shape, 0, c->bins * sizeof *c->shape);
    memset(c->weight, 0, c->bins * sizeof *c->weight);
    for (size_t k = from; k < to; k++) {
        const struct cycle *cycle = &c->cycle[k];
        for (size_t i = samples_index(x, cycle->t); i < x->n && cycle->height > 0; i++) {
            const double phase = (x->t[i] - cycle->t) / c->period;
            if (phase >= 1)
                break;
            const double at = phase * (double)c->bins, part = at - floor(at),
                         value = x->use[i] ? (x->y[i] - cycle->mean) / cycle->height : 0;
            const size_t bin = (size_t)at % c->bins, next = (bin + 1) % c->bins;
            const double w = x->use[i] * cycle->height * cycle->height;
            c->shape[bin] += w * (1 - part) * value;
            c->shape[next] += w * part * value;
            c->weight[bin] += w * (1 - part);
            c->weight[next] += w * part;
        }
    }
    for (size_t k = 0; k < c->bins; k++) {
        if (!(c->weight[k] > 0))
            return false;
        c->shape[k] /= c->weight[k];
        sum += c->shape[k];
    }
    for (size_t k = 0; k < c->bins; k++) {
        c->shape[k] -= sum / (double)c->bins;
        used += c->shape[k] * c->shape[k];
    }
    return used > 0;
}

/* Places all cycles, from the middle one outwards, each where those before it lead. */
static bool place_cycles(struct cycles *c, double reach)
{
    const size_t middle = c->count / 2;
    for (size_t k = middle; k < c->count; k++) {
        const double expected = k > middle ? c->cycle[k - 1].t + c->period : c->cycle[k].t;
        if (cancelled(c->samples->cancel))
            return false;
        if (!place_cycle(c, expected, reach, &c->cycle[k]))
            c->cycle[k] = (struct cycle){.t = expected};
    }
    for (size_t k = middle; k-- > 0;) {
        const double expected = c->cycle[k + 1].t - c->period;
        if (cancelled(c->samples->cancel))
            return false;
        if (!place_cycle(c, expected, reach, &c->cycle[k]))
            c->cycle[k] = (struct cycle){.t = expected};
    }
    return true;
}

static bool cycles_init(struct cycles *c, const struct samples *x, double guess,
                        struct arena *arena)
{
    const double span = x->t[x->n - 1] - x->t[0], samples = guess / (span / (double)(x->n - 1));
    *c = (struct cycles){.samples = x, .period = guess, .count = (size_t)(span / guess + 0.02)};
    c->bins = (size_t)fmin(fmax(samples, BINS_MIN), BINS_MAX);
    if (c->count < CYCLES_MIN || samples < BINS_MIN / 2)
        return false;
    c->cycle = arena_array(arena, c->count, sizeof *c->cycle);
    c->shape = arena_array(arena, c->bins, sizeof *c->shape);
    c->weight = arena_array(arena, c->bins, sizeof *c->weight);
    if (!c->cycle || !c->shape || !c->weight)
        return false;
    const double first = x->t[0] + 0.5 * fmax(span - (double)c->count * guess, 0);
    for (size_t k = 0; k < c->count; k++)
        c->cycle[k] = (struct cycle){.t = first + (double)k * guess, .height = 1};
    return true;
}

/* Returns the share of the power that the mean of the other cycles explains of each. */
static double explained_share(const struct cycles *c)
{
    const double others = (double)c->count / (double)(c->count - 1);
    double square = 0, left = 0;
    for (size_t k = 0; k < c->count; k++) {
        const struct cycle *cycle = &c->cycle[k];
        square += cycle->square;
        left +=
            cycle->height > 0 ? fmin(cycle->left * others * others, cycle->square) : cycle->square;
    }
    return square > 0 ? 1 - left / square : 0;
}

/* Returns the share from which on that number of cycles is alike: drift, steps and random walks
 * stay below it (tests/unit/analysis/detect.c). */
static double share_needed(size_t cycles)
{
    static const struct {
        size_t cycles;
        double share;
    } needed[] = {{20, 0.3}, {10, 0.4}, {6, 0.6}, {4, 0.8}};
    for (size_t k = 0; k < COUNT_OF(needed); k++)
        if (cycles >= needed[k].cycles)
            return needed[k].share;
    return 0.9;
}

/* Places all cycles of about `guess` [s] against their mean. Returns false if they are too few, or
 * if out of memory. */
static bool cycles_find(struct cycles *c, const struct samples *x, double guess,
                        struct arena *arena)
{
    if (!cycles_init(c, x, guess, arena))
        return false;
    const size_t middle = c->count / 2, few = c->count < 8 ? c->count : 8;
    if (!mean_shape(c, middle - few / 2, middle - few / 2 + few))
        return false;
    for (int pass = 0; pass < ALIGN_PASSES; pass++)
        if (!place_cycles(c, pass == 0 ? 0.1 : 0.04) || !mean_shape(c, 0, c->count))
            return false;
    return true;
}

bool cycle_period(const struct series *series, double guess, struct arena *arena,
                  struct period *period)
{
    struct samples x;
    struct cycles c;
    size_t used = 0, placed = 0;
    double level = 0;
    if (!samples_init(&x, series, arena) || !cycles_find(&c, &x, guess, arena) ||
        explained_share(&c) < share_needed(c.count))
        return false;
    struct crossing *begin = arena_array(arena, c.count, sizeof *begin);
    double *scratch = arena_array(arena, c.count, sizeof *scratch);
    if (!begin || !scratch)
        return false;
    for (size_t k = 0; k < c.count; k++)
        if (c.cycle[k].height > 0) {
            begin[placed++] = (struct crossing){c.cycle[k].t, c.cycle[k].sigma, true};
            level += c.cycle[k].mean;
        }
    *period = (struct period){.how = "cycles"};
    if (placed < CYCLES_MIN || !fit_beat(begin, placed, guess, scratch, false, period, &used) || 5 * used < 4 * c.count)
        return false;
    period->level = level / (double)placed;
    return true;
}

/* ---- what the cycles leave open ---- */

/* Returns the chance that values that follow a straight line or a parabola differ in turn, one in
 * `turns`, as much as these do by their uncertainties, or by their scatter where it is larger. */
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
    if (!cholesky(columns, WIDTH, a, 1e-10, a))
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

/* What is read of every cycle that may tell it from its neighbours. */
enum { CYCLE_HEIGHT, CYCLE_MEAN, CYCLE_TIME, CYCLE_VALUES };

/* Sets [count] values of one kind, whose uncertainties come of a variance of the rows and of how
 * far [y] the mean cycle may be off all along a cycle. */
static void cycle_values(const struct cycles *c, int kind, double variance, double off,
                         struct measured *value)
{
    double height = 0;
    for (size_t k = 0; k < c->count; k++)
        height += c->cycle[k].height / (double)c->count;
    for (size_t k = 0; k < c->count; k++) {
        const struct cycle *y = &c->cycle[k];
        const double row = variance + off * off * y->rows, relative = sqrt(row / y->power) / height;
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

/* Returns how far the mean cycle is off the rows where the times of the samples repeat after so
 * many cycles, so that it may be off by the same in each of these: half of what noise does not
 * explain. Else, or at least, a small part of the rows' size. */
static double template_error(const struct cycles *c, size_t turns, double left, double noise)
{
    static const double small = 1e-3, coherent = 0.3, all_noise = 1.5;
    const struct samples *x = c->samples;
    const double samples = c->period / (x->t[x->n - 1] - x->t[0]) * (double)(x->n - 1),
                 drift = fabs(remainder((double)turns * samples, 1)) * (double)c->count;
    const double size = small * sqrt(cycles_square(c));
    return turns == 0 || drift < 2 ? hypot(size, coherent * sqrt(fmax(left - all_noise * noise * noise, 0))) : size;
}

/* Returns the variance of the rows that the mean cycle leaves, or -1 if it is like none of some. */
static double cycles_left(const struct cycles *c)
{
    static const double least = 0.2; /* of the mean height */
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

/* Returns the least chance that the cycles differ in turn by what is read of them; NAN if not all
 * are like their mean. */
static double cycles_chance(const struct cycles *c, size_t turns, double noise,
                            struct measured *value)
{
    const double left = cycles_left(c), off = template_error(c, turns, left, noise);
    double least = 1;
    if (left < 0)
        return NAN;
    for (int kind = 0; kind < CYCLE_VALUES; kind++) {
        cycle_values(c, kind, left, off, value);
        least = fmin(least, turns_chance(value, c->count, turns));
    }
    return least;
}

/* The posterior of times of cycles that scatter beyond their uncertainties. */
struct times_model {
    double scatter, walk; /* [s^2] variances of each, and of what each adds to all later ones */
    double likelihood;    /* its logarithm */
    struct measured period; /* [s] */
};

/* Follows the times less multiples of a period (a Kalman filter of time and period). */
static void follow_times(const struct measured *time, size_t n, double spread,
                         struct times_model *m)
{
    static const double unknown = 1e6;
    double x = 0, d = 0, xx = unknown * spread, xd = 0, dd = unknown * spread;
    m->likelihood = 0;
    for (size_t k = 0; k < n; k++) {
        const double f = xx + m->scatter + time[k].uncertainty * time[k].uncertainty,
                     off = time[k].value - x, gain_x = xx / f, gain_d = xd / f;
        m->likelihood -= 0.5 * (log(f) + off * off / f);
        x += gain_x * off;
        d += gain_d * off;
        dd -= gain_d * xd;
        xd -= gain_d * xx;
        xx -= gain_x * xx;
        m->period = (struct measured){d, sqrt(fmax(dd, 0))};
        x += d;
        xx += 2 * xd + dd + m->walk;
        xd += dd;
    }
}

/*
 * Reads from the times of cycles by how much the period is off the one that they are less multiples
 * of [s]. Each may come some random time off its place, or off the cycle before: the mean over
 * both, by how likely they make the times. *beyond: by how much that makes the variance
 * larger than noise alone does, which is that share of the variances of the times.
 */
static struct measured period_of_times(const struct measured *time, size_t n, double noise_share,
                                       bool *surprising, double *beyond)
{
    enum { STEPS = 6 };
    static const double step = 4, first_scatter = 1.0 / 64, first_walk = 1.0 / 16;
    /* For more than noise, over that for noise alone: it is up to 4 where neither is likelier. */
    static const double evidence_min = 4, evidence_sure = 8;
    struct line_fit line;
    double place[CYCLES_USED], spread = 0, weight = 0, value = 0, square = 0, variance = 0;
    struct times_model model[STEPS + 1][STEPS + 1], *none = &model[0][0];
    for (size_t k = 0; k < n; k++)
        place[k] = (double)k;
    *beyond = 0;
    *surprising = false;
    if (!line_fit(place, time, (int)n, &line))
        return (struct measured){0, HUGE_VAL};
    for (size_t k = 0; k < n; k++) {
        const double off = time[k].value - line.intercept.value - line.slope.value * place[k];
        spread += (off * off + time[k].uncertainty * time[k].uncertainty) / (double)n;
    }
    for (int i = 0; i <= STEPS; i++)
        for (int j = 0; j <= STEPS; j++) {
            struct times_model *m = &model[i][j];
            m->scatter = i == 0 ? 0 : spread * first_scatter * pow(step, i - 1);
            m->walk = j == 0 ? 0 : spread * first_walk / (double)n * pow(step, j - 1);
            follow_times(time, n, spread, m);
            const double prior = (i == 0 ? 1 : 1.0 / STEPS) * (j == 0 ? 1 : 1.0 / STEPS),
                         w = prior * exp(fmin(m->likelihood - none->likelihood, 600));
            weight += w;
            value += w * m->period.value;
            square += w * m->period.value * m->period.value;
            variance += w * m->period.uncertainty * m->period.uncertainty;
        }
    value /= weight;
    variance = variance / weight + fmax(square / weight - value * value, 0);
    const double noise = none->period.uncertainty * none->period.uncertainty;
    *surprising = weight > evidence_sure;
    *beyond = (weight > evidence_min ? variance : noise) - noise_share * noise;
    return (struct measured){value, sqrt(variance)};
}

/* Takes the rows that the cycles are judged by. */
static bool doubt_rows(const struct series *series, const struct period *p, struct arena *arena,
                       struct series *rows)
{
    enum { ROWS_A_CYCLE = 64 };
    static const double whole = 0.8;
    struct series part = *series;
    if (p->last > p->first && p->last - p->first < whole * (part.t[part.n - 1] - part.t[0]))
        part = series_window(*series, p->first - p->period.value,
                             p->last + p->period.value);
    if (part.n < 2)
        return false;
    const double cycles = (part.t[part.n - 1] - part.t[0]) / p->period.value,
                 each = (double)part.n / cycles, by = floor(fmax(each / ROWS_A_CYCLE, 1)),
                 used = fmin(each / by * (CYCLES_USED - 1), (double)part.n);
    return cycles >= CYCLES_MIN && series_lively_part(&part, (size_t)by, (size_t)used, arena, rows);
}

/* Widens a period by what the times of its cycles leave open, and warns where that is most of it.
 */
static void widen_by_times(const struct cycles *c, double noise, struct measured *value,
                           struct period *period)
{
    static const double contradicts = 3, share_min = 0.8, most = 2;
    double beyond;
    bool surprising;
    const double left = cycles_left(c), error = template_error(c, 0, left, noise),
                 left_share = left / (left + error * error * c->cycle[0].rows);
    const bool same = strcmp(period->how, "cycles") == 0; /* the same times */
    cycle_values(c, CYCLE_TIME, left, error, value);
    const struct measured off =
        period_of_times(value, c->count, same ? left_share : 1, &surprising, &beyond);
    const double share = fmin((double)c->count / fmax(period->periods, 1), 1),
                 more = sqrt(fmax(share * beyond, 0)), stated = period->period.uncertainty;
    period->period.uncertainty = fmax(stated, more);
    if (share > share_min &&
        fabs(off.value) > contradicts * hypot(off.uncertainty, period->period.uncertainty))
        period->period.uncertainty = hypot(period->period.uncertainty, off.value);
    if (surprising && period->period.uncertainty > most * stated && !period->warning[0])
        snprintf(period->warning, sizeof period->warning,
                 "the cycles come off their places, or off those before, by more than the noise: T "
                 "is their mean, and known the less the fewer they are");
}

void period_doubt(const struct series *series, struct arena *arena, struct period *period)
{
    static const double chance_min = 3e-3, alike_min = 0.8, noise_max = 0.05;
    enum { MULTIPLES = 3, PARTS = 4 };
    struct series rows;
    struct samples x;
    struct cycles c;
    struct measured value[CYCLES_USED];
    const double T = period->period.value;
    if (series_is_uneven(series) || !doubt_rows(series, period, arena, &rows) ||
        !samples_init(&x, &rows, arena))
        return;
    double *scratch = arena_array(arena, x.n, sizeof *scratch);
    if (!scratch)
        return;
    const double noise = samples_noise(&x, scratch);
    if (cycles_find(&c, &x, T, arena) && c.count <= CYCLES_USED) {
        const bool alike = cycles_left(&c) >= 0 && explained_share(&c) >= share_needed(c.count);
        for (size_t n = 2; n <= MULTIPLES && alike && !period->warning[0]; n++)
            if (cycles_chance(&c, n, noise, value) < chance_min)
                snprintf(period->warning, sizeof period->warning,
                         "the period may be %zu times as long: one cycle in %zu differs from the "
                         "others by more than the noise",
                         n, n);
        if (alike)
            widen_by_times(&c, noise, value, period);
        else if (noise * noise < noise_max * cycles_square(&c) && !period->warning[0])
            snprintf(period->warning, sizeof period->warning,
                     "cycles of this length are not all alike: T may not be their period");
    }
    for (size_t n = PARTS; n >= 2 && !period->warning[0]; n--)
        if (cycles_find(&c, &x, T / (double)n, arena) && cycles_left(&c) >= 0 &&
            explained_share(&c) > alike_min)
            snprintf(period->warning, sizeof period->warning,
                     "T holds %zu cycles of %.5g s that are alike but for their sizes and %.2g %%",
                     n, T / (double)n, 100 * sqrt(fmax(1 - explained_share(&c), 0)));
}
