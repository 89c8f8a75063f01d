/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The times of whole cycles, each placed against the mean of all (Woody, Med. Biol. Eng. 5 (1967)
 * 539). */
#include <hooke/base/cancel.h>
#include "modules/recording/period/cycle.h"

#include <math.h>
#include <string.h>

enum {
    /* Bins of the mean cycle, and iterations between mean and positions. */
    BINS_MIN = 16,
    BINS_MAX = 256,
    ALIGN_PASSES = 4,
};

/* Returns the index of the first sample at or after t, searching from the sample `index` nearby. */
static size_t index_near(const struct samples *x, double t, size_t index)
{
    while (index > 0 && x->t[index - 1] >= t)
        index--;
    while (index < x->n && x->t[index] < t)
        index++;
    return index;
}

/* Fits the mean cycle (height and offset) to the samples of the cycle that begins at time t [s], by
 * least squares, and fills *result. *row is in and out: a sample near t, then the cycle's first
 * one. Returns the correlation coefficient, or -1 if there are too few samples. */
static double fit_cycle(const struct cycles *c, double t, size_t *row, struct cycle *result)
{
    const struct samples *x = c->samples;
    const double end = t + c->period, bins = (double)c->bins / c->period;
    double n = 0, f = 0, y = 0, ff = 0, fy = 0, yy = 0, slope = 0;
    *row = index_near(x, t, *row);
    const double y0 = x->y[*row < x->n ? *row : 0];
    for (size_t i = *row; i < x->n && x->t[i] < end; i++) {
        if (!x->use[i])
            continue;
        const double place = (x->t[i] - t) * bins;
        const size_t bin = (size_t)place < c->bins ? (size_t)place : c->bins - 1;
        const double *shape = c->shape + bin, part = place - (double)bin;
        const double rise = shape[1] - shape[0], value = shape[0] + part * rise,
                     previous_rise = shape[0] - shape[-1], next_rise = shape[2] - shape[1],
                     d = previous_rise + rise + part * (next_rise - previous_rise),
                     v = x->y[i] - y0;
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
    slope *= 0.25 * bins * bins;
    *result = (struct cycle){
        .t = t, .height = sfy / sff, .square = syy, .rows = n, .power = sff, .slope = slope};
    result->mean = y0 + (y - result->height * f) / n;
    result->left = fmax(syy - sfy * sfy / sff, 0);
    result->left /= n - 3;
    result->square /= n - 1;
    result->sigma = sqrt(result->left / slope) / fabs(result->height);
    return sfy / sqrt(sff * syy);
}

/* Places one cycle within `reach` periods of the expected time [s], where its correlation with the
 * mean cycle is highest. Returns false if no position resembles the mean cycle. */
static bool place_cycle(const struct cycles *c, double expected, double reach, struct cycle *result)
{
    enum { PLACES = 2 * (BINS_MAX / 8) + 3 };
    const double step = c->period / (double)c->bins;
    const int reach_bins = (int)ceil(reach * (double)c->bins);
    double r[PLACES] = {0}, *top = NULL, t = expected;
    struct cycle trial;
    size_t row = samples_index(c->samples, expected);
    for (int k = 0; k <= 2 * reach_bins + 2; k++)
        r[k] = fit_cycle(c, expected + (k - reach_bins - 1) * step, &row, &trial);
    for (int k = 1; k <= 2 * reach_bins + 1; k++)
        if (r[k] > 0 && (!top || r[k] > *top))
            top = &r[k];
    if (!top)
        return false;
    const double bend = top[-1] - 2 * top[0] + top[1];
    t += (double)(top - r - reach_bins - 1) * step;
    if (bend < 0)
        t += step * fmin(fmax(0.5 * (top[-1] - top[1]) / bend, -0.5), 0.5);
    return fit_cycle(c, t, &row, result) > 0 && result->height > 0;
}

/* Sets c->shape to the mean of cycles begin to end - 1, each less its mean and divided by its
 * height, in bins over the period, with weights by height; the shape continues periodically by a
 * bin before and two behind. Returns false if a bin stays empty or the shape is constant. */
static bool mean_shape(struct cycles *c, size_t begin, size_t end)
{
    const struct samples *x = c->samples;
    double sum = 0, used = 0;
    memset(c->shape, 0, c->bins * sizeof *c->shape);
    memset(c->weight, 0, c->bins * sizeof *c->weight);
    for (size_t k = begin; k < end; k++) {
        const struct cycle *cycle = &c->cycle[k];
        for (size_t i = samples_index(x, cycle->t); i < x->n && cycle->height > 0; i++) {
            const double phase = (x->t[i] - cycle->t) / c->period;
            if (phase >= 1)
                break;
            const double position = phase * (double)c->bins, part = position - floor(position),
                         value = x->use[i] ? (x->y[i] - cycle->mean) / cycle->height : 0;
            const size_t bin = (size_t)position % c->bins, next = (bin + 1) % c->bins;
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
    c->shape[-1] = c->shape[c->bins - 1];
    c->shape[c->bins] = c->shape[0];
    c->shape[c->bins + 1] = c->shape[1];
    return used > 0;
}

/* Places all cycles, from the middle one outwards, each one period after or before its neighbour,
 * within `reach` periods. Returns false if cancelled. */
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

/* Returns where the first cycle should begin [periods after the first sample], at most `spare`:
 * where the series changes least, so that no pulse is cut. Sets *excess to the change there
 * relative to the least change anywhere. */
static double quiet_begin(const struct samples *x, double period, double spare, double *excess)
{
    enum { PLACES = 16 };
    double change[PLACES] = {0}, least = HUGE_VAL, least_allowed = HUGE_VAL, begin = 0.5 * spare;
    for (size_t i = 1; i < x->n; i++) {
        const double phase = (x->t[i] - x->t[0]) / period;
        change[(size_t)(PLACES * (phase - floor(phase))) % PLACES] +=
            (x->y[i] - x->y[i - 1]) * (x->y[i] - x->y[i - 1]);
    }
    for (size_t k = 0; k < PLACES; k++) {
        const double place = (double)k / PLACES,
                     here = change[k] + change[(k + PLACES - 1) % PLACES];
        least = fmin(least, here);
        if (place <= spare && here < least_allowed) {
            least_allowed = here;
            begin = place;
        }
    }
    *excess = least_allowed / least;
    return begin;
}

/* Divides the series into cycles of `guess` [s]. Returns false if they or their samples are too
 * few, or if out of memory. */
static bool cycles_init(struct cycles *c, const struct samples *x, double guess,
                        struct arena *arena)
{
    const double span = x->t[x->n - 1] - x->t[0], samples = guess / (span / (double)(x->n - 1));
    /* If the cut changes more than change_max times as much as the quietest position, one cycle is
     * given up for a better cut, provided that CYCLES_LEFT_MIN remain. */
    static const double change_max = 2;
    enum { CYCLES_LEFT_MIN = 5 };
    *c = (struct cycles){.samples = x, .period = guess, .count = (size_t)(span / guess + 0.02)};
    c->bins = (size_t)fmin(fmax(samples, BINS_MIN), BINS_MAX);
    if (c->count < CYCLES_MIN || samples < BINS_MIN / 2)
        return false;
    c->cycle = arena_array(arena, c->count, sizeof *c->cycle);
    c->weight = arena_array(arena, c->bins, sizeof *c->weight);
    double *shape = arena_array(arena, c->bins + 3, sizeof *c->shape);
    if (!c->cycle || !shape || !c->weight)
        return false;
    c->shape = shape + 1;
    double excess, begin = quiet_begin(x, guess, fmax(span / guess - (double)c->count, 0), &excess);
    if (excess > change_max && c->count > CYCLES_LEFT_MIN) {
        c->count--;
        begin = quiet_begin(x, guess, 1, &excess);
    }
    const double first = x->t[0] + begin * guess;
    for (size_t k = 0; k < c->count; k++)
        c->cycle[k] = (struct cycle){.t = first + (double)k * guess, .height = 1};
    return true;
}

/* Corrects for each cycle's own part in the mean. */
double cycles_explained_share(const struct cycles *c)
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

double cycles_share_needed(size_t cycles)
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

/* Divides the samples into cycles of about `guess` [s], and alternates between placing the cycles
 * and computing their mean. Stops early if they explain far less than share_min of the variance.
 * Returns false if there are too few samples, or if cancelled or out of memory. */
bool cycles_find(struct cycles *c, const struct samples *x, double guess, double share_min,
                 struct arena *arena)
{
    /* Better positions of the cycles do not help if they explain less than this part of
     * share_min. */
    static const double hopeless = 0.75;
    static const double gain_min = 1e-3;
    double previous_share = 0;
    if (!cycles_init(c, x, guess, arena))
        return false;
    const size_t middle = c->count / 2, few = c->count < 8 ? c->count : 8;
    if (!mean_shape(c, middle - few / 2, middle - few / 2 + few))
        return false;
    for (int pass = 0; pass < ALIGN_PASSES; pass++) {
        if (!place_cycles(c, pass == 0 ? 0.1 : 0.04))
            return false;
        const double share = cycles_explained_share(c);
        if (!mean_shape(c, 0, c->count))
            return false;
        if (share < hopeless * share_min || fabs(share - previous_share) < gain_min)
            break;
        previous_share = share;
    }
    return true;
}

/* Reads the period, near `guess` [s], from a line through the starts of cycles, if these are alike.
 * Returns false if they are not. */
bool cycle_period(const struct series *series, double guess, struct arena *arena,
                  struct period *period)
{
    struct samples x;
    struct cycles c;
    size_t used = 0, placed = 0;
    double level = 0;
    if (!samples_init(&x, series, arena) || !cycles_find(&c, &x, guess, 0, arena) ||
        cycles_explained_share(&c) < cycles_share_needed(c.count))
        return false;
    struct crossing *begin = arena_array(arena, c.count, sizeof *begin);
    if (!begin)
        return false;
    for (size_t k = 0; k < c.count; k++)
        if (c.cycle[k].height > 0) {
            begin[placed++] = (struct crossing){c.cycle[k].t, c.cycle[k].sigma, true};
            level += c.cycle[k].mean;
        }
    *period = (struct period){.how = "cycles"};
    if (placed < CYCLES_MIN ||
        !crossings_period(begin, placed, guess, false, arena, period, &used) ||
        5 * used < 4 * c.count)
        return false;
    period->level = level / (double)placed;
    return true;
}
