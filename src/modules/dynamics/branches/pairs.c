/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Special points that come in pairs within a step, where a test passes 0 and comes back: steps are
 * shortened to separate them (step_is_resolved), and the minimum of a test is searched
 * (walk_record_pairs). */
#include <math.h>
#include <string.h>

#include "modules/dynamics/branches/walk.h"

/* Shares of a step along equilibria at which tests are evaluated as well. */
static const double inner_share[] = {0.2, 0.4, 0.6, 0.8};
enum { MINIMUM_STEPS_MAX = 16 };
/* A minimum whose predicted value exceeds this part of the least value found does not reach 0. */
static const double minimum_part = 0.5;
/* Smallest distance, relative to the bracket, of a new sample from the least one. */
static const double nearest_part = 0.1;
/* A bracket narrower than this, relative to the distance of both ends, is given up. */
static const double bracket_min = 1e-7;

/* Evaluates the tests at four places within the step and counts their changes of sign. */
bool step_is_resolved(struct branch_walk *w, const struct curve_place *current,
                      const struct curve_place *next)
{
    int last[CURVE_TESTS], changes[CURVE_TESTS] = {0};
    const int tests = w->path->problem->tests;
    bool resolved = true;
    if (w->path->kind != SOLUTION_EQUILIBRIUM)
        return true;
    for (int k = 0; k < tests; k++)
        last[k] = walk_sign(w, current, k);
    for (size_t i = 0; i <= COUNT_OF(inner_share); i++) {
        struct curve_place inner;
        const bool is_end = i == COUNT_OF(inner_share);
        if (!is_end && !curve_between(w->path->problem, current, next, inner_share[i], &inner))
            continue;
        for (int k = 0; k < tests; k++) {
            const int sign = walk_sign(w, is_end ? next : &inner, k);
            changes[k] += sign * last[k] < 0;
            last[k] = sign != 0 ? sign : last[k];
        }
    }
    for (int k = 0; k < tests; k++)
        resolved = resolved && changes[k] <= 1;
    return resolved;
}

/* ---- the least value of a test ---- */

/* A place, its arclength, and its test times the sign that the test has around it. */
struct test_sample {
    struct curve_place place;
    double position, value;
};

/* Search for the minimum of a test times its sign. */
struct test_minimum {
    struct branch_walk *walk;
    int test, sign;
    struct test_sample *low, *middle, *high, *fresh; /* four samples that change places */
};

/* Returns the test at a place times the sign that it has around the minimum. */
static double value_at(const struct test_minimum *m, const struct curve_place *point)
{
    return m->sign * point->test[m->test];
}

/* Returns the position of the vertex of the parabola through three samples, and sets *value to its
 * value there. */
static double parabola_vertex(const struct test_minimum *m, double *value)
{
    const double h = m->high->position - m->middle->position,
                 l = m->low->position - m->middle->position,
                 dh = (m->high->value - m->middle->value) / h,
                 dl = (m->low->value - m->middle->value) / l, bend = (dh - dl) / (h - l),
                 slope = dl - bend * l;
    const double shift = bend > 0 ? -slope / (2 * bend) : 0;
    *value = m->middle->value + shift * (slope + bend * shift);
    return m->middle->position + shift;
}

/* Computes the sample m->fresh at a position. Returns false if no solution is found there or if the
 * test has no value. */
static bool sample_at(const struct test_minimum *m, double position)
{
    const bool is_before = position < m->middle->position;
    const struct test_sample *a = is_before ? m->low : m->middle;
    const struct test_sample *b = is_before ? m->middle : m->high;
    const double share = (position - a->position) / (b->position - a->position);
    if (!curve_between(m->walk->path->problem, &a->place, &b->place, share, &m->fresh->place))
        return false;
    m->fresh->position = position;
    m->fresh->value = value_at(m, &m->fresh->place);
    return isfinite(m->fresh->value);
}

/* Returns the next position to examine: the vertex, unless it is known already. */
static double next_sample(const struct test_minimum *m, double vertex)
{
    const double low = m->low->position, middle = m->middle->position, high = m->high->position,
                 least = nearest_part * (high - low);
    const double further = high - middle > middle - low ? fmin(least, (high - middle) / 2)
                                                        : -fmin(least, (middle - low) / 2);
    if (fabs(vertex - middle) < fabs(further) || vertex <= low || vertex >= high)
        return middle + further;
    return vertex;
}

/* Takes the fresh sample into the bracket low, middle, high of a minimum, in which the least value
 * is in the middle; the sample that drops out becomes the memory for the next fresh one. */
static void narrow(struct test_minimum *m)
{
    struct test_sample *fresh = m->fresh, **side;
    const bool is_below = fresh->position < m->middle->position;
    if (fresh->value < m->middle->value) {
        side = is_below ? &m->high : &m->low;
        m->fresh = *side;
        *side = m->middle;
        m->middle = fresh;
    } else {
        side = is_below ? &m->low : &m->high;
        m->fresh = *side;
        *side = fresh;
    }
}

/* Searches a place between m->low and m->high where the test has the other sign than m->sign, by
 * parabolas that approach the minimum; that place becomes m->fresh. Returns false if there is none:
 * if the predicted minimum is more than minimum_part of the least value so far, the bracket has
 * become narrow, a sample fails, or after MINIMUM_STEPS_MAX samples. */
static bool find_other_sign(struct test_minimum *m)
{
    const double length = m->high->position - m->low->position;
    for (int k = 0; k < MINIMUM_STEPS_MAX; k++) {
        double least;
        const double vertex = parabola_vertex(m, &least);
        if (least > minimum_part * m->middle->value ||
            m->high->position - m->low->position < bracket_min * length ||
            cancelled(m->walk->request->cancel) || !sample_at(m, next_sample(m, vertex)))
            return false;
        if (walk_sign(m->walk, &m->fresh->place, m->test) == -m->sign)
            return true;
        narrow(m);
    }
    return false;
}

/* ---- pairs ---- */

/* Records a special point and moves it to position *index of the branch, which is advanced. Returns
 * false if out of memory. */
static bool record_at(struct branch_walk *w, const struct found_special *f, int *index)
{
    struct branch *b = w->branch;
    const int count = b->count;
    if (!special_record(w, f))
        return false;
    if (b->count == count)
        return true;
    const struct branch_point point = b->point[count];
    memmove(&b->point[*index + 1], &b->point[*index], (size_t)(count - *index) * sizeof *b->point);
    b->point[(*index)++] = point;
    w->fold_at = 0; /* the index is invalid, since points have moved */
    return true;
}

/* Searches the minimum of each test by parabolas; if it has the other sign there, both zeros beside
 * it are located. */
bool walk_record_pairs(struct branch_walk *w, const struct curve_place *previous,
                       const struct curve_place *point, int index, const struct curve_place *next)
{
    const int unknowns = w->path->problem->n + 1;
    struct test_sample sample[4];
    for (int k = 0; k < w->path->problem->tests; k++) {
        const int sign = walk_sign(w, point, k);
        struct test_minimum m = {w, k, sign, &sample[0], &sample[1], &sample[2], &sample[3]};
        struct found_special pair[2];
        if (sign == 0 || walk_sign(w, previous, k) != sign || walk_sign(w, next, k) != sign)
            continue;
        sample[0] = (struct test_sample){*previous, 0, value_at(&m, previous)};
        sample[1] = (struct test_sample){*point, curve_distance(unknowns, previous->u, point->u),
                                         value_at(&m, point)};
        sample[2] = (struct test_sample){
            *next, sample[1].position + curve_distance(unknowns, point->u, next->u),
            value_at(&m, next)};
        if (sample[1].value > fmin(sample[0].value, sample[2].value) || !find_other_sign(&m))
            continue;
        const bool is_before = m.fresh->position < m.middle->position;
        const struct curve_place *low = &(is_before ? m.low : m.middle)->place;
        const struct curve_place *high = &(is_before ? m.middle : m.high)->place;
        int place =
            m.fresh->position < curve_distance(unknowns, previous->u, point->u) ? index : index + 1;
        if (special_locate(w, low, &m.fresh->place, k, &pair[0]) &&
            special_locate(w, &m.fresh->place, high, k, &pair[1]) &&
            !(record_at(w, &pair[0], &place) && record_at(w, &pair[1], &place)))
            return false;
    }
    return true;
}
