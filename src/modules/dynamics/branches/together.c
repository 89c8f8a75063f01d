/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Special points that no test shows by its sign: eigenvalues or multipliers that become critical
 * together, as those of symmetric scenes do, or one soon after the other. The number of them that
 * grow is counted; where it changes by more than the special points found explain, shorter parts of
 * the chord are examined, and in the end the sum of the rates of those that pass. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "modules/dynamics/branches/walk.h"

/* A rate above this part of the largest eigenvalue, or of a multiplier's logarithm, has a certain
 * sign. */
#define CERTAIN_RATE_RELATIVE 1e-5
#define HALVINGS_BEFORE_COMMON 4 /* halvings after which the remaining ones may pass together */
#define HALVINGS_MAX 14          /* largest number of halvings of a chord */
/* Eigenvalues farther from passing than this, in the units of CERTAIN_RATE_RELATIVE, do not pass
 * together. */
#define AT_ONCE 1e-7
#define COMPLEX_PAIR_IMAG_MIN 1e-5 /* imaginary part above which an eigenvalue is complex */

/* Returns the growth of a difference: a rate [1/s], or the logarithm of a multiplier. */
static double growth_exponent(const struct solution *s, int k)
{
    return s->kind == SOLUTION_EQUILIBRIUM ? s->value[k].re
                                           : log(hypot(s->value[k].re, s->value[k].im));
}

/* Returns the largest eigenvalue, or 1 for multipliers. */
static double unit_of(const struct solution *s)
{
    double most = DBL_MIN;
    for (int k = 0; k < s->values; k++)
        most = fmax(most, hypot(s->value[k].re, s->value[k].im));
    return s->kind == SOLUTION_EQUILIBRIUM ? most : 1;
}

/* Counts the eigenvalues that grow; -1 if one is too near to the border to tell. */
int walk_grows(struct branch_walk *w, const struct solution *s)
{
    int count = s->values > 0 ? 0 : -1;
    w->unit = fmax(w->unit, unit_of(s));
    for (int k = 0; k < s->values; k++) {
        const double rate = growth_exponent(s, k);
        if (!(fabs(rate) > CERTAIN_RATE_RELATIVE * w->unit))
            return -1;
        count += rate > 0;
    }
    return count;
}

/* Finds the indices place [count] of the eigenvalues that are nearest to becoming critical. */
static void nearest_critical(const struct solution *s, int count, int *place)
{
    bool taken[DYNAMICS_VARIABLES] = {false};
    for (int i = 0; i < count; i++) {
        place[i] = -1;
        for (int k = 0; k < s->values; k++)
            if (!taken[k] &&
                (place[i] < 0 || fabs(growth_exponent(s, k)) < fabs(growth_exponent(s, place[i]))))
                place[i] = k;
        taken[place[i]] = true;
    }
}

/* A part of a branch between two places. */
struct chord_piece {
    struct branch_walk *w;
    const struct curve_place *a, *b;
    int count; /* number of eigenvalues that pass between them */
};

/* Finds the place and solution at a share of the chord. Returns false if there is none. */
static bool place_at(const struct chord_piece *p, double share, struct curve_place *point,
                     struct solution *s)
{
    return curve_between(p->w->path->problem, p->a, p->b, share, point) &&
           solutions_at(p->w->path, point, false, s) && s->values >= p->count;
}

/* Returns the sum of the rates of the eigenvalues that pass, a smooth function even where they
 * meet; NAN if unknown. `context` is a struct chord_piece. */
static double rate_sum(void *context, const struct curve_place *point)
{
    const struct chord_piece *p = context;
    int place[DYNAMICS_VARIABLES];
    double sum = 0;
    struct solution s;
    if (!solutions_at(p->w->path, point, false, &s) || s.values < p->count)
        return NAN;
    nearest_critical(&s, p->count, place);
    for (int i = 0; i < p->count; i++)
        sum += growth_exponent(&s, place[i]);
    return sum;
}

/* Returns the kind of special point at which `count` eigenvalues with these indices pass. */
static enum special special_kind_of(const struct solution *s, double unit, int count,
                                    const int *place)
{
    bool pair = false, turned = false;
    for (int i = 0; i < count; i++) {
        const struct eigenvalue v = s->value[place[i]];
        pair = pair || fabs(v.im) > COMPLEX_PAIR_IMAG_MIN * unit;
        turned = turned || v.re < 0;
    }
    const bool is_map = s->kind != SOLUTION_EQUILIBRIUM;
    if (pair)
        return is_map ? SPECIAL_TORUS : SPECIAL_HOPF;
    return is_map && turned ? SPECIAL_DOUBLING : SPECIAL_CROSSING;
}

/* Locates a special point at which all of p->count eigenvalues pass together. Returns false if they
 * do not. Not inlined, since chord_specials_find() is recursive and needs a small stack frame. */
static __attribute__((noinline)) bool pass_together(struct chord_piece *p,
                                                    struct found_special *found)
{
    int place[DYNAMICS_VARIABLES];
    if (!curve_find_zero(p->w->path->problem, p->a, p->b, rate_sum, p, &found->point,
                         &found->uncertainty) ||
        !solutions_at(p->w->path, &found->point, true, &found->solution))
        return false;
    nearest_critical(&found->solution, p->count, place);
    for (int i = 0; i < p->count; i++)
        if (fabs(growth_exponent(&found->solution, place[i])) > AT_ONCE * p->w->unit)
            return false;
    found->special = special_kind_of(&found->solution, p->w->unit, p->count, place);
    return true;
}

/* Finds a place near the middle of the chord at which the number of growing eigenvalues is certain.
 * Returns false if there is none. */
static __attribute__((noinline)) bool certain_middle(const struct chord_piece *p,
                                                     struct curve_place *point, int *grows)
{
    static const double share[] = {0.5, 0.4, 0.6, 0.3, 0.7};
    struct solution s;
    for (size_t k = 0; k < COUNT_OF(share); k++)
        if (place_at(p, share[k], point, &s) && (*grows = walk_grows(p->w, &s)) >= 0)
            return true;
    return false;
}

/* Finds the special points between two places at which a_grows and b_grows eigenvalues grow, by
 * halving the chord. Appends them to found [*count]. */
static void chord_specials_find(struct branch_walk *w, const struct curve_place *a, int a_grows,
                                const struct curve_place *b, int b_grows, int depth,
                                struct found_special *found, int *count)
{
    struct chord_piece p = {w, a, b, abs(a_grows - b_grows)};
    const int saved_count = *count;
    if (p.count == 0 || (p.count == 1 && depth == 0) || cancelled(w->request->cancel))
        return;
    if (specials_by_signs(w, a, b, found, count) >= p.count)
        return;
    *count = saved_count;
    /* A single eigenvalue that passes changes the sign of a test. */
    if (p.count > 1 && depth >= HALVINGS_BEFORE_COMMON && saved_count < SPECIALS_MOST &&
        pass_together(&p, &found[saved_count])) {
        *count += is_in_range(w->request, &found[saved_count].solution.param[0]);
        return;
    }
    struct curve_place middle;
    int grows;
    if (depth == HALVINGS_MAX || !certain_middle(&p, &middle, &grows))
        return;
    chord_specials_find(w, a, a_grows, &middle, grows, depth + 1, found, count);
    chord_specials_find(w, &middle, grows, b, b_grows, depth + 1, found, count);
}

/* Returns true if the same special point was recorded since w->sure. */
static bool is_known(const struct branch_walk *w, const struct found_special *f)
{
    const struct branch *b = w->branch;
    for (int i = b->count - 1; i >= 0 && i >= w->sure_point; i--)
        if (b->point[i].special == f->special &&
            fabs(b->point[i].solution.param[0] - f->solution.param[0]) < SPECIALS_SAME * w->psize)
            return true;
    return false;
}

/* Compares the number of growing eigenvalues at `next` (that of `solution`) with the last sure one
 * and with what the located points, found [*count], explain. If more have changed, the chord is
 * searched, and the points found there, except known ones, replace all of found. */
void specials_unseen(struct branch_walk *w, const struct curve_place *next,
                     const struct solution *solution, struct found_special *found, int *count)
{
    const int grows = walk_grows(w, solution);
    for (int i = 0; i < *count; i++)
        w->explained += special_passes(found[i].special);
    if (grows < 0)
        return;
    if (w->sure_grows >= 0 && abs(grows - w->sure_grows) > w->explained) {
        struct found_special unseen[SPECIALS_MOST];
        int more = 0;
        chord_specials_find(w, &w->sure, w->sure_grows, next, grows, 0, unseen, &more);
        if (more > 0)
            *count = 0;
        for (int i = 0; i < more; i++) {
            unseen[i].distance =
                curve_distance(w->path->problem->n + 1, unseen[i].point.u, w->sure.u);
            if (!is_known(w, &unseen[i]))
                found[(*count)++] = unseen[i];
        }
    }
    specials_sure(w, next, grows);
}

void specials_sure(struct branch_walk *w, const struct curve_place *point, int grows)
{
    w->sure = *point;
    w->sure_grows = grows;
    w->sure_point = w->branch->count;
    w->explained = 0;
}
