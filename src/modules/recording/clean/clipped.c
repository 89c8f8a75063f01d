/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Flat tops (clean_clipped()): a nearer object echoes first, or the range of the sensor ends. */
#include "modules/recording/clean/clean.h"

#include <hooke/base/numeric.h>

#include <math.h>

/* Smallest number of samples in a flat top's layer. */
#define CLIPPED_MIN 12
/* Ratio of the samples in a layer at the top of a sine to those in the one below: 1/(sqrt(2) -
 * 1). */
#define SINE_MAX 2.5

/* A range of values and the number of samples in it. */
struct layer {
    double low, high;
    size_t count;
};

/* Finds, on the upper or lower side of the middle, the layer of values of that width with the most
 * samples, and stores it in *layer; width 0 finds repeated equal values. Returns true if it is a
 * flat top, as a clipped signal has: with more than four times the samples of the layer next to it
 * on the inside, beyond chance, and hardly any samples beyond. */
static bool densest_layer(const struct cleaning *c, bool upper, double width, struct layer *layer)
{
    const double *sorted = c->sorted;
    const size_t n = c->sorted_count;
    const double middle = sorted[n / 2], far = 0.2 * c->swing,
                 reach = fmax(width, fmax(0.01 * c->swing, 1.5 * c->quantum));
    size_t first = 0, last = 0, lower_count = 0, upper_count = 0;
    layer->count = 0;
    /* All of it lies beyond the middle: a wider one would hold most of any noise. */
    const double margin = fmax(far - 0.5 * width, 0), low = upper ? middle + margin : -HUGE_VAL;
    const double high = upper ? HUGE_VAL : middle - width - margin;
    for (size_t i = first_from(sorted, n, low), end = i; i < n && sorted[i] <= high; i++) {
        while (end < n && sorted[end] <= sorted[i] + width)
            end++;
        if (end - i <= layer->count)
            continue;
        *layer = (struct layer){sorted[i], sorted[i] + width, end - i};
        first = i;
        last = end;
    }
    if (layer->count < CLIPPED_MIN)
        return false;
    for (size_t i = first; i-- > 0 && sorted[i] >= layer->low - reach;)
        lower_count++;
    for (size_t i = last; i < n && sorted[i] <= layer->high + reach; i++)
        upper_count++;
    const size_t inside = upper ? lower_count : upper_count;
    const size_t outside = upper ? n - last : first;
    const double n_in = (double)layer->count, n_beside = (double)inside;
    const bool by_chance =
        n_in - SINE_MAX * n_beside < 3 * sqrt(n_in + SINE_MAX * SINE_MAX * n_beside);
    return layer->count > 4 * inside && !by_chance && 4 * outside < layer->count;
}

/* Returns true if sample i lies in the layer. */
static bool in_layer(const struct cleaning *c, size_t i, const struct layer *layer)
{
    return c->y[i] >= layer->low && c->y[i] <= layer->high;
}

/* Searches the upper or lower side for a flat top (a dense layer of values), and if it is spread
 * over at least three cycles, notes it among the findings as clipped and excludes its samples from
 * the fits. */
void clean_clipped(struct cleaning *c, bool upper)
{
    struct finding tops = {.size = NAN}, *clipped = &c->findings->finding[FINDING_CLIPPED];
    struct layer layer = {0};
    size_t max = 0, here = 0;
    double t_end = -HUGE_VAL, sum = 0;
    const double thin = fmax(0.01 * c->swing, 2.1 * c->quantum),
                 widths[] = {0, thin, fmax(thin, 6 * c->typical)};
    bool found = false;
    for (size_t k = 0; k < COUNT_OF(widths) && c->sorted_count >= CLIPPED_MIN && !found; k++)
        found = densest_layer(c, upper, widths[k], &layer);
    if (!found)
        return;
    for (size_t i = 0; i < c->n; i++) {
        if (!in_layer(c, i, &layer))
            continue;
        here = c->t[i] > t_end ? 0 : here;
        clean_note(&tops, c->t[i], 0);
        tops.stretches -= c->t[i] > t_end ? 0 : 1;
        here++;
        max = here > max ? here : max;
        tops.count++;
        sum += c->y[i];
        t_end = c->t[i] + 0.25 * c->period;
    }
    if (tops.stretches < 3 || 2 * max > tops.count || tops.count < 3 * tops.stretches)
        return;
    const bool earlier = clipped->count > 0 && clipped->first[0] < tops.first[0];
    for (int k = 0; k < FINDING_STRETCHES && !earlier; k++)
        clipped->first[k] = tops.first[k];
    clipped->size = sum / (double)tops.count;
    clipped->count += tops.count;
    clipped->stretches += tops.stretches;
    /* Noise carries some samples out of the layer. */
    const double margin = fmax(0.5 * (layer.high - layer.low), fmin(4 * c->typical, thin));
    layer.low -= margin;
    layer.high += margin;
    for (size_t i = 0; i < c->n; i++)
        if (in_layer(c, i, &layer))
            c->excluded[i] = 1;
}
