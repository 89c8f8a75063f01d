/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The tree of delay vectors, halved along their widest side, and the nearest of them. */
#include "analysis/exponent/space.h"

#include <math.h>

#define LEAF 12 /* vectors at most */

static void widest_side(struct delay_space *s, size_t from, size_t to, int *along)
{
    const size_t stride = (to - from) / 64 + 1; /* a look is enough */
    double widest = -1;
    for (int d = 0; d < s->dimensions; d++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t k = from; k < to; k += stride) {
            const double y = space_value(s, s->order[k], d);
            low = fmin(low, y);
            high = fmax(high, y);
        }
        if (high - low > widest) {
            widest = high - low;
            *along = d;
        }
    }
}

/* What is below and above the middle on their sides (Hoare 1961). */
static void halve(struct delay_space *s, size_t from, size_t to, size_t middle, int along)
{
    uint32_t *order = s->order;
    size_t low = from, high = to - 1;
    while (low < high) {
        const double pivot = space_value(s, order[low + (high - low) / 2], along);
        size_t i = low, j = high;
        for (;;) {
            while (space_value(s, order[i], along) < pivot)
                i++;
            while (space_value(s, order[j], along) > pivot)
                j--;
            if (i >= j)
                break;
            const uint32_t other = order[i];
            order[i++] = order[j];
            order[j--] = other;
        }
        const size_t end = space_value(s, order[j], along) > pivot ? j - 1 : j;
        if (middle <= end)
            high = end;
        else
            low = end + 1;
    }
}

static bool divide(struct delay_space *s, size_t plane, size_t from, size_t to)
{
    const size_t middle = (from + to) / 2;
    if (plane >= s->planes)
        return true;
    if (to - from > 4096 && cancelled(s->cancel))
        return false;
    int along = 0;
    widest_side(s, from, to, &along);
    halve(s, from, to, middle, along);
    s->plane[plane] = (struct plane){space_value(s, s->order[middle], along), along};
    return divide(s, 2 * plane + 1, from, middle) && divide(s, 2 * plane + 2, middle, to);
}

static size_t planes_for(size_t points)
{
    size_t planes = 0;
    for (size_t each = points; each > LEAF; each = (each + 1) / 2)
        planes = 2 * planes + 1;
    return planes;
}

bool space_init(struct delay_space *s, size_t n, struct arena *arena)
{
    s->order = arena_array(arena, n, sizeof *s->order);
    s->plane = arena_array(arena, planes_for(n) + 1, sizeof *s->plane);
    return s->order && s->plane;
}

bool space_grow(struct delay_space *s)
{
    s->planes = planes_for(s->points);
    for (size_t i = 0; i < s->points; i++)
        s->order[i] = (uint32_t)i;
    return divide(s, 0, 0, s->points);
}

struct neighbour_search {
    const struct delay_space *space;
    size_t i;
    int wanted;
    struct neighbours *found;
};

static void look_at(const struct neighbour_search *search, size_t j)
{
    const struct delay_space *s = search->space;
    struct neighbours *f = search->found;
    const size_t lag = j > search->i ? j - search->i : search->i - j;
    if (lag <= s->apart)
        return;
    const double square = space_distance2(s, search->i, j);
    if (!(square > 0) || (f->count == search->wanted && square >= f->square[f->count - 1]))
        return;
    int k = f->count < search->wanted ? f->count++ : f->count - 1;
    for (; k > 0 && f->square[k - 1] > square; k--) {
        f->square[k] = f->square[k - 1];
        f->at[k] = f->at[k - 1];
    }
    f->square[k] = square;
    f->at[k] = (uint32_t)j;
}

static void look_below(const struct neighbour_search *search, size_t plane, size_t from, size_t to)
{
    const struct delay_space *s = search->space;
    const struct neighbours *f = search->found;
    if (plane >= s->planes) {
        for (size_t k = from; k < to; k++)
            look_at(search, s->order[k]);
        return;
    }
    const size_t middle = (from + to) / 2;
    const struct plane *p = &s->plane[plane];
    const double side = space_value(s, search->i, p->along) - p->at;
    const bool above = side >= 0;
    look_below(search, 2 * plane + 1 + above, above ? middle : from, above ? to : middle);
    if (f->count < search->wanted || side * side < f->square[f->count - 1])
        look_below(search, 2 * plane + 2 - above, above ? from : middle, above ? middle : to);
}

void space_nearest(const struct delay_space *space, size_t i, int wanted, struct neighbours *found)
{
    found->count = 0;
    look_below(&(struct neighbour_search){space, i, wanted, found}, 0, 0, space->points);
}
