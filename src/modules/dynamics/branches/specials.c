/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Special points of a branch: located where tests change their signs between two places, and
 * recorded. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/branches/walk.h"

/* Tests that become 0 within this part of the range belong to the same point. */
#define SAME_POINT_RANGE_FRACTION 1e-6
/* An eigenvalue is 0 if it is smaller than this part of the frequency. */
#define ZERO_EIGENVALUE_RELATIVE 1e-6
/* A test counts as 0 if it is smaller than this part of its largest value so far. */
#define ZERO_TEST_RELATIVE 1e-8
/* A point within this part of the range from an edge is on the edge. */
#define RANGE_EDGE_FRACTION 1e-9
/* rounding of the parameter, relative to the range or to its value */
#define PARAM_ROUNDING_RELATIVE 1e-13
/* Folds of orbits whose parameters differ by less than this part come from rounding. */
#define FOLD_ROUNDING_RELATIVE 1e-9

/* Appends a point to the branch, with its solution and the part of the tangent that later branches
 * begin with. */
bool branch_append(struct branch *b, const struct solution_curve *path,
                   const struct curve_place *location, enum special special,
                   const struct solution *solution)
{
    struct branch_point *more = realloc(b->point, ((size_t)b->count + 1) * sizeof *more);
    if (!more)
        return false;
    b->point = more;
    struct branch_point *point = &more[b->count++];
    *point = (struct branch_point){
        .solution = *solution, .special = special, .criticality = NAN, .accuracy = NAN};
    /* An orbit's tangent is stored for its start, its period and the parameter; the remaining
     * unknowns follow. */
    const int n = path->field.n, all = path->problem->n;
    memcpy(point->tangent, location->tangent, (size_t)n * sizeof *point->tangent);
    if (path->kind == SOLUTION_EQUILIBRIUM) {
        point->tangent[n] = location->tangent[all];
    } else {
        point->tangent[n] = path->kind == SOLUTION_ORBIT ? location->tangent[all - 1] : 0;
        point->tangent[n + 1] = location->tangent[all];
    }
    return true;
}

/* ---- special points between two places ---- */

/* Returns true if a test at a place is 0 but for rounding. */
static bool is_test_zero(const struct branch_walk *w, const struct curve_place *p, int test)
{
    if (test > 0)
        return fabs(p->test[test]) <= ZERO_TEST_RELATIVE * w->largest[test];
    /* test 0 is the parameter's part of the tangent, which is rounding if the parameter is
     * constant */
    return fabs(p->test[test]) <= CURVE_LEVEL ||
           (fabs(p->test[test]) <= CURVE_STEEP && w->moved <= CURVE_LEVEL);
}

bool is_in_range(const struct branch_request *r, double *param)
{
    const double margin = RANGE_EDGE_FRACTION * (r->high - r->low);
    if (!(*param >= r->low - margin && *param <= r->high + margin))
        return false;
    *param = fmin(fmax(*param, r->low), r->high);
    return true;
}

/* Locates the zero of test number `test` between two places, in f->point and f->uncertainty. A fold
 * of orbits can be too flat to be located; if its parameter is known to FOLD_ROUNDING_RELATIVE
 * anyway, the place with the smaller test is taken. Returns false if the zero is not found. */
static bool locate_test(const struct branch_walk *w, const struct curve_place *previous,
                        const struct curve_place *next, int test, struct found_special *f)
{
    const struct curve_problem *problem = w->path->problem;
    const int n = problem->n;
    if (curve_locate(problem, previous, next, test, &f->point, &f->uncertainty))
        return true;
    if (w->path->kind == SOLUTION_EQUILIBRIUM || test != ORBIT_FOLD ||
        !(fabs(previous->u[n] - next->u[n]) < FOLD_ROUNDING_RELATIVE * fabs(next->u[n])))
        return false;
    f->point = fabs(previous->test[test]) < fabs(next->test[test]) ? *previous : *next;
    f->uncertainty = fabs(previous->u[n] - next->u[n]);
    return true;
}

int special_passes(enum special special)
{
    return special == SPECIAL_HOPF || special == SPECIAL_TORUS ? 2 : special != SPECIAL_NONE;
}

int walk_sign(const struct branch_walk *w, const struct curve_place *point, int test)
{
    if (!isfinite(point->test[test]) || is_test_zero(w, point, test))
        return 0;
    return signbit(point->test[test]) ? -1 : 1;
}

/* A branch of equilibria turns back at a fold: unless rounding made it, the parameter changes to
 * the same side on both arms. */
static bool turns_back(const struct branch_walk *w, const struct curve_place *previous,
                       const struct curve_place *next, const struct curve_place *fold)
{
    const int n = w->path->problem->n;
    const double a = previous->u[n] - fold->u[n], b = next->u[n] - fold->u[n],
                 rounding = PARAM_ROUNDING_RELATIVE * fmax(fabs(fold->u[n]), 1);
    return fmax(fabs(a), fabs(b)) > rounding &&
           ((a > 0) == (b > 0) || fmin(fabs(a), fabs(b)) <= rounding);
}

/* Locates the zero of a test, computes the solution there, and checks that it is a special point in
 * the range. */
bool special_locate(struct branch_walk *w, const struct curve_place *previous,
                    const struct curve_place *next, int test, struct found_special *f)
{
    if (!locate_test(w, previous, next, test, f) ||
        !solutions_at(w->path, &f->point, true, &f->solution))
        return false;
    f->special = solutions_special(w->path, test, &f->solution);
    if (f->special == SPECIAL_FOLD && w->path->kind == SOLUTION_EQUILIBRIUM &&
        !turns_back(w, previous, next, &f->point))
        return false;
    f->distance = curve_distance(w->path->problem->n + 1, f->point.u, previous->u);
    return f->special != SPECIAL_NONE && is_in_range(w->request, &f->solution.param[0]);
}

/* Locates a special point for each test whose sign differs at two places. */
int specials_by_signs(struct branch_walk *w, const struct curve_place *a,
                      const struct curve_place *b, struct found_special *found, int *count)
{
    int passes = 0;
    for (int k = 0; k < w->path->problem->tests && *count < SPECIALS_MOST; k++)
        if (!is_test_zero(w, a, k) && !is_test_zero(w, b, k) &&
            signbit(a->test[k]) != signbit(b->test[k]) &&
            special_locate(w, a, b, k, &found[*count]))
            passes += special_passes(found[(*count)++].special);
    return passes;
}

/* Locates the zeros of all tests between their last known places (w->known) and `next`, and appends
 * special points to found, of which there are *count. A test that is lost in rounding at `next` has
 * no sign there and keeps its earlier place. */
static void locate_all(struct branch_walk *w, const struct curve_place *next,
                       struct found_special *found, int *count)
{
    const struct curve_problem *problem = w->path->problem;
    for (int k = 0; k < problem->tests; k++) {
        w->largest[k] = fmax(w->largest[k], fabs(next->test[k]));
        w->any[k] = w->any[k] && (k == 0 || !is_test_zero(w, &w->known[k], k));
        if (is_test_zero(w, next, k) || !isfinite(next->test[k]))
            continue;
        const struct curve_place previous = w->known[k];
        const bool changed = w->any[k] && signbit(previous.test[k]) != signbit(next->test[k]);
        w->known[k] = *next;
        w->any[k] = true;
        *count += changed && special_locate(w, &previous, next, k, &found[*count]);
    }
}

/* Removes from found [*count] the folds and Neimark-Sacker points at the same position as a branch
 * point: where two branches cross, the test functions of these may be 0, too. n is the number of
 * unknowns. */
static void leave_doubles_out(struct found_special *found, int *count, int n)
{
    for (int i = 0; i < *count; i++)
        for (int j = 0; j < *count; j++)
            if (i != j && found[i].special == SPECIAL_CROSSING &&
                (found[j].special == SPECIAL_FOLD || found[j].special == SPECIAL_TORUS) &&
                curve_distance(n, found[i].point.u, found[j].point.u) < SAME_POINT_RANGE_FRACTION) {
                found[j] = found[--*count];
                i = -1;
                break;
            }
}

/* Compares two special points by their distance, for qsort(). */
static int by_distance(const void *a, const void *b)
{
    const struct found_special *x = a, *y = b;
    return (x->distance > y->distance) - (x->distance < y->distance);
}

/* Returns the first Lyapunov coefficient of a Hopf point. Returns NAN if a real eigenvalue is 0 or
 * if another pair passes at the same time, as the coefficient of one pair then decides nothing. */
static double criticality(struct branch_walk *w, const struct solution *s)
{
    double omega = 0, best = HUGE_VAL, error;
    int pairs = 0;
    for (int k = 0; k < s->values; k++)
        if (s->value[k].im > 0 && fabs(s->value[k].re) < best) {
            best = fabs(s->value[k].re);
            omega = s->value[k].im;
        }
    for (int k = 0; k < s->values; k++) {
        if (hypot(s->value[k].re, s->value[k].im) < ZERO_EIGENVALUE_RELATIVE * omega)
            return NAN;
        pairs += s->value[k].im > 0 && fabs(s->value[k].re) < ZERO_EIGENVALUE_RELATIVE * omega;
    }
    if (pairs > 1)
        return NAN;
    const double first = lyapunov_coefficient(&w->path->field, s->state, omega, &error);
    return fabs(first) <= 4 * error ? 0 : first;
}

/* Returns true if the found special point *f is a fold that must be recorded. On branches of orbits
 * that change at a nearly constant parameter (canards), rounding turns the parameter back and
 * forth, so that folds appear which differ by less than FOLD_ROUNDING_RELATIVE. Two of them cancel,
 * and of an odd number the one with the extreme parameter counts; the branch's last fold is then
 * changed or removed and the result is false. Raises *accuracy, the fold's relative uncertainty, to
 * the spread of such folds. */
static bool is_fold(struct branch_walk *w, const struct found_special *f, double *accuracy)
{
    struct branch *b = w->branch;
    const double value = f->solution.param[0];
    struct branch_point *best = w->fold_at < b->count ? &b->point[w->fold_at] : NULL;
    const double previous = b->point[b->count - 1].solution.param[0],
                 best_param = best ? best->solution.param[0] : NAN,
                 relative_distance = fabs(value - best_param) / fabs(best_param);
    const bool flat = w->path->kind != SOLUTION_EQUILIBRIUM && w->fold_at > 0 &&
                      relative_distance < FOLD_ROUNDING_RELATIVE;
    if (flat && best && best->special == SPECIAL_FOLD) {
        best->special = SPECIAL_NONE;
        w->fold_spread = fmax(w->fold_spread, relative_distance);
        return false;
    }
    if (flat && best && (value < best_param) != w->fold_least) {
        best->special = SPECIAL_FOLD;
        best->accuracy = fmax(best->accuracy, w->fold_spread);
        return false;
    }
    w->fold_spread = flat ? fmax(w->fold_spread, relative_distance) : 0;
    w->fold_least = flat ? w->fold_least : value < previous;
    w->fold_at = b->count;
    *accuracy = fmax(*accuracy, w->fold_spread);
    return true;
}

/* Appends a located point with its relative accuracy, and the first Lyapunov coefficient of a Hopf
 * point. A zero of the fold test that is no fold is left out. Returns false if out of memory. */
bool special_record(struct branch_walk *w, const struct found_special *f)
{
    double accuracy = f->uncertainty / fmax(fabs(f->point.u[w->path->problem->n]), 1e-3);
    if (f->special == SPECIAL_FOLD && !is_fold(w, f, &accuracy))
        return true;
    if (!branch_append(w->branch, w->path, &f->point, f->special, &f->solution))
        return false;
    struct branch_point *point = &w->branch->point[w->branch->count - 1];
    point->accuracy = accuracy;
    if (point->special == SPECIAL_HOPF)
        point->criticality = criticality(w, &point->solution);
    return true;
}

/* Locates all special points between the last place and `next`, sorts them along the branch and
 * appends them. `seen` is the solution at `next`; if it is given, the points must explain how its
 * number of growing eigenvalues has changed, or more are searched. Returns false if out of
 * memory. */
bool walk_record_specials(struct branch_walk *w, const struct curve_place *next,
                          const struct solution *seen)
{
    struct found_special found[SPECIALS_MOST];
    int count = 0;
    const int n = w->path->problem->n;
    locate_all(w, next, found, &count);
    leave_doubles_out(found, &count, n + 1);
    if (seen)
        specials_unseen(w, next, seen, found, &count);
    qsort(found, (size_t)count, sizeof *found, by_distance);
    for (int i = 0; i < count; i++)
        if (!special_record(w, &found[i]))
            return false;
    return true;
}

/* ---- signs of the tests along a walk ---- */

/* Returns true if a test has a certain sign at a place. */
static bool is_signed(const struct branch_walk *w, const struct curve_place *point, int test)
{
    return isfinite(point->test[test]) && point->test[test] != 0 && !is_test_zero(w, point, test);
}

/* Sets the signs of the tests, their largest values and the number of growing eigenvalues at the
 * start of a walk. A test without a sign at `point` takes that of the first place on the other side
 * of the start (w->opposite), if that is known and has as many unknowns (w->behinds). The last
 * recorded point is the start. */
void walk_start(struct branch_walk *w, const struct curve_place *point)
{
    const int n = w->path->problem->n;
    struct curve_place *opposite = w->behinds == n ? &w->opposite : NULL;
    w->fold_at = 0;
    if (opposite) { /* converted to the direction of this walk */
        for (int i = 0; i <= n; i++)
            opposite->tangent[i] = -opposite->tangent[i];
        opposite->test[EQUILIBRIUM_FOLD] *= -1;
        opposite->test[EQUILIBRIUM_CROSSING] *= -1;
    }
    for (int k = 0; k < w->path->problem->tests; k++) {
        w->largest[k] = fabs(point->test[k]);
        if (k == 0) /* part of a unit vector */
            w->largest[k] = 1;
        else if (opposite)
            w->largest[k] = fmax(w->largest[k], fabs(opposite->test[k]));
        const bool here = is_signed(w, point, k);
        w->known[k] = here || !opposite ? *point : *opposite;
        w->any[k] = here || (opposite && is_signed(w, opposite, k));
    }
    const int grows = walk_grows(w, &w->branch->point[w->branch->count - 1].solution);
    if (grows < 0 && opposite)
        specials_sure(w, opposite, w->behind_grows);
    else
        specials_sure(w, point, grows);
    w->behinds = 0;
}

/* Replaces the stored places by the same place in new unknowns, and keeps the signs of the
 * tests. */
void walk_go_on(struct branch_walk *w, const struct curve_place *point)
{
    specials_sure(w, point, walk_grows(w, &w->branch->point[w->branch->count - 1].solution));
    for (int k = 0; k < w->path->problem->tests; k++) {
        const double sign = copysign(DBL_MIN, w->known[k].test[k]);
        w->largest[k] = k == 0 ? 1 : fabs(point->test[k]);
        w->known[k] = *point;
        if (is_signed(w, point, k))
            w->any[k] = true;
        else
            w->known[k].test[k] = sign; /* the test keeps the sign that it had */
    }
}
