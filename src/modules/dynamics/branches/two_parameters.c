/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Folds, Hopf points, period doublings and Neimark-Sacker points as curves in two parameters
 * (special_follow): the equations of the solution and one more, the condition, which is 0 at such a
 * point; unknowns are those of the solution, with the first parameter, and the second parameter
 * (Govaerts 2000, 4 and 8). Derivatives of the condition are differences; they only guide Newton's
 * method, so that the points are as accurate as the equations. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/branches/walk.h"

#define DIFFERENCE_STEP_RELATIVE 1e-6
#define FOLD_DIFFERENCE_UNITS 1e-4 /* step along a fold of orbits, in units of the unknowns */
/* Weight of the second parameter in the sum of both, which then has no special direction. */
#define SECOND_PARAM_WEIGHT 0.618
#define CONDITION_REUSE_DISTANCE 1e-4 /* farther away the condition of an orbit is derived anew */
#define FIRST_STEP_LENGTH 0.01        /* arclength of the first step and of the longest one */
#define STEP_LENGTH_MAX 0.05
/* Cosine of an orbit's phase to the reference, below which the reference is renewed. */
#define PHASE_COSINE_MIN 0.9
#define CURVE_POINTS_DEFAULT 1000

/* A curve of special points. */
struct special_curve {
    struct solution_curve base;
    enum special kind;
    int second;                                /* index of the second parameter in the scene */
    double qsize;                              /* unit of the second parameter: its range */
    double point[CURVE_MAX], slope[CURVE_MAX]; /* derivatives of the condition at `point` */
    /* derivatives of the equations by the second parameter */
    double by_second[CURVE_MAX];
    bool derived; /* these derivatives are known */
    /* The tangent of a fold at a fixed second parameter, or the direction along the fold. */
    double tangent[CURVE_MAX];
    struct curve_problem problem;
};

/* ---- the condition ---- */

/* Copies the derivatives of the first n equations by the first n unknowns. */
static void square_part(const struct special_curve *c, int n, double *square)
{
    const int all = c->base.problem->n + 1;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            square[i * n + j] = c->base.work->jacobian[i * all + j];
}

/* Returns the condition of the special point at the place examined last, or NAN if unknown. */
static double condition(const struct special_curve *c)
{
    const int n = c->base.field.n;
    double square[FIELD_VARIABLES * FIELD_VARIABLES], sums[21 * 21];
    struct multipliers m;
    switch (c->kind) {
    case SPECIAL_FOLD:
        square_part(c, c->base.problem->n, c->base.work->matrix);
        return matrix_determinant(c->base.problem->n, c->base.work->matrix);
    case SPECIAL_HOPF:
        square_part(c, n, square);
        matrix_pair_sums(n, square, sums);
        return matrix_determinant(n * (n - 1) / 2, sums);
    default:
        if (!orbit_curve_multipliers(&c->base.orbit, &m))
            return NAN;
        return c->kind == SPECIAL_DOUBLING ? multipliers_doubling(&m) : multipliers_torus(&m);
    }
}

/* Computes the residuals of the equations f [n] and the condition of the special point f[n], which
 * all are 0 on the curve, at u: the n unknowns, the first and, as u[n + 1] in units of c->qsize,
 * the second parameter. Returns false if one cannot be evaluated. */
static bool evaluate_condition(struct special_curve *c, const double *u, double *f)
{
    const int n = c->base.problem->n;
    if (!field_hold(&c->base.field, c->second, u[n + 1] * c->qsize) ||
        !c->base.problem->residual(c->base.problem->context, u, f, c->base.work->jacobian))
        return false;
    f[n] = condition(c);
    return isfinite(f[n]);
}

/* Returns true if the derivatives of an orbit's condition were computed near enough. */
static bool is_fresh(const struct special_curve *c, const double *u)
{
    return c->derived && c->base.kind != SOLUTION_EQUILIBRIUM &&
           curve_distance(c->problem.n + 1, c->point, u) < CONDITION_REUSE_DISTANCE;
}

/* Computes the derivatives of the condition by differences. Those of equilibria are central: they
 * cost little and show where two folds meet. Returns false if the condition cannot be evaluated. */
static bool derive_condition(struct special_curve *c, const double *u)
{
    const int n = c->base.problem->n;
    const bool both = c->base.kind == SOLUTION_EQUILIBRIUM;
    double side[2][CURVE_MAX], moved[CURVE_MAX];
    if (!both && !evaluate_condition(c, u, side[0]))
        return false;
    for (int k = 0; k <= n + 1; k++) {
        const double step = DIFFERENCE_STEP_RELATIVE * fmax(1, fabs(u[k]));
        memcpy(moved, u, sizeof moved);
        moved[k] = u[k] - step;
        if (both && !evaluate_condition(c, moved, side[0]))
            return false;
        moved[k] = u[k] + step;
        if (!evaluate_condition(c, moved, side[1]))
            return false;
        c->slope[k] = (side[1][n] - side[0][n]) / (both ? 2 * step : step);
        for (int i = 0; k == n + 1 && i < n; i++)
            c->by_second[i] = (side[1][i] - side[0][i]) / (both ? 2 * step : step);
    }
    memcpy(c->point, u, sizeof c->point);
    c->derived = true;
    return true;
}

/* Computes, for the curve of special points, the n equations of the solution and the condition of
 * the special point as f [n + 1], and their derivatives by the unknowns u [n + 2] as jacobian [n +
 * 1][n + 2]; context is the struct special_curve. Returns false if that fails or if cancelled. */
static bool residual(void *context, const double *u, double *f, double *jacobian)
{
    struct special_curve *c = context;
    const int n = c->base.problem->n, all = n + 2;
    if (cancelled(c->base.field.cancel) || (!is_fresh(c, u) && !derive_condition(c, u)) ||
        !evaluate_condition(c, u, f))
        return false;
    for (int i = 0; i < n; i++) {
        memcpy(jacobian + i * all, c->base.work->jacobian + i * (n + 1),
               (size_t)(n + 1) * sizeof *jacobian);
        jacobian[i * all + n + 1] = c->by_second[i];
    }
    memcpy(jacobian + n * all, c->slope, (size_t)all * sizeof *jacobian);
    return true;
}

/* ---- points of codimension two ---- */

/* Returns the product of the two eigenvalues whose sum is nearest to 0: omega squared for a Hopf
 * point, negative for a saddle. */
static double pair_product(int n, const struct eigenvalue *v)
{
    double best = HUGE_VAL, product = NAN;
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++) {
            const double sum = hypot(v[i].re + v[j].re, v[i].im + v[j].im);
            if (sum < best) {
                best = sum;
                product = v[i].re * v[j].re - v[i].im * v[j].im;
            }
        }
    return product;
}

/* Returns the sum of the products of all eigenvalues but one, which is 0 where two of them are
 * 0. */
static double products_of_others(int n, const struct eigenvalue *v)
{
    double sum = 0;
    for (int i = 0; i < n; i++) {
        double re = 1, im = 0;
        for (int j = 0; j < n; j++) {
            const double old = re;
            re = i == j ? re : re * v[j].re - im * v[j].im;
            im = i == j ? im : old * v[j].im + im * v[j].re;
        }
        sum += re;
    }
    return sum;
}

/* Computes the test for cusps on a fold of orbits: the change of the condition along the tangent at
 * a fixed second parameter, which is 0 where two folds meet. */
static void test_orbit_fold(void *context, const double *u, const double *jacobian,
                            const double *tangent, double *value)
{
    struct special_curve *c = context;
    const int n = c->base.problem->n;
    double fold_tangent[CURVE_MAX], f[CURVE_MAX], moved[CURVE_MAX], side[2];
    (void)jacobian;
    (void)tangent;
    value[0] = NAN;
    if (!evaluate_condition(c, u, f) || !curve_tangent(c->base.problem, c->tangent, fold_tangent))
        return;
    for (int k = 0; k < 2; k++) {
        memcpy(moved, u, sizeof moved);
        for (int i = 0; i <= n; i++)
            moved[i] += (k == 0 ? -FOLD_DIFFERENCE_UNITS : FOLD_DIFFERENCE_UNITS) * fold_tangent[i];
        if (!evaluate_condition(c, moved, f))
            return;
        side[k] = f[n];
    }
    memcpy(c->tangent, fold_tangent, sizeof c->tangent);
    value[0] = (side[1] - side[0]) / (2 * FOLD_DIFFERENCE_UNITS);
}

/* Computes the tests for Bogdanov-Takens and generalised Hopf points along Hopf points, for cusps
 * and Bogdanov-Takens points along folds of equilibria. */
static void special_curve_test(void *context, const double *u, const double *jacobian,
                               const double *tangent, double *value)
{
    struct special_curve *c = context;
    struct solution_curve *base = &c->base;
    const int n = base->field.n;
    struct curve_place point;
    struct solution s;
    (void)jacobian;
    (void)tangent;
    value[0] = value[1] = NAN;
    memcpy(point.u, u, sizeof point.u);
    if (!solutions_at(base, &point, false, &s))
        return;
    if (c->kind == SPECIAL_HOPF) {
        double error;
        value[0] = pair_product(n, s.value);
        value[1] = value[0] > 0
                       ? lyapunov_coefficient(&base->field, s.state, sqrt(value[0]), &error)
                       : NAN;
        return;
    }
    /* The combined parameter leaves a tangent along the fold, also where the first parameter alone
     * does not cross it. */
    double base_tangent[CURVE_MAX], *by_param = base->work->jacobian + n;
    for (int i = 0; i < n; i++)
        by_param[i * (n + 1)] += SECOND_PARAM_WEIGHT * c->by_second[i];
    if (!curve_tangent(base->problem, c->tangent, base_tangent))
        return;
    memcpy(c->tangent, base_tangent, sizeof c->tangent);
    value[0] = 0;
    for (int i = 0; i < n; i++)
        value[0] += c->slope[i] * base_tangent[i];
    value[1] = n > 1 ? products_of_others(n, s.value) : NAN;
}

/* Returns the kind of special point at which a test is 0. */
static enum special special_of(const struct special_curve *c, int test)
{
    static const enum special hopf[] = {SPECIAL_DOUBLE, SPECIAL_BAUTIN},
                              fold[] = {SPECIAL_CUSP, SPECIAL_DOUBLE};
    assert(test == 0 || test == 1);
    return (c->kind == SPECIAL_HOPF ? hopf : fold)[test];
}

/* ---- the start of the curve ---- */

/* Makes the residuals of the solution accurate to rounding. */
static void special_curve_aim(void *context, bool fine)
{
    struct special_curve *c = context;
    (void)fine; /* differences need all digits */
    if (c->base.problem->aim)
        c->base.problem->aim(c->base.problem->context, true);
}

/* Frees what the curve holds. */
static void special_curve_end(struct special_curve *c)
{
    solutions_end(&c->base);
    free(c->problem.work);
}

/* Sets up the curve of special points like r->leave in the plane of the two parameters, and finds
 * its first place, with a tangent towards growing (side 1) or falling (side -1) values of the
 * second parameter, or of the first if the curve is normal to the second. Returns false with
 * *error. */
static bool begin_curve_side(struct special_curve *c, const struct branch_request *r, int side,
                             struct curve_place *first, struct error *error)
{
    double u[CURVE_MAX];
    const double now = r->scene->value[r->second->param];
    *c = (struct special_curve){.kind = r->leave->special,
                                .second = r->second->param,
                                .qsize = r->second->high - r->second->low};
    if (!solutions_begin(&c->base, r->scene, r->param, r->high - r->low, &r->leave->solution,
                         r->cancel, u, error))
        return false;
    const int n = c->base.problem->n, all = n + 1;
    const bool still = c->base.kind == SOLUTION_EQUILIBRIUM &&
                       (c->kind == SPECIAL_FOLD || c->kind == SPECIAL_HOPF),
               fold = !still && c->kind == SPECIAL_FOLD; /* a fold of orbits */
    memcpy(c->tangent, r->leave->tangent, (size_t)c->base.field.n * sizeof *c->tangent);
    int tests = fold;
    if (still)
        tests = c->base.field.n > 1 ? 2 : 1;
    c->problem = (struct curve_problem){.context = c,
                                        .n = all,
                                        .residual = residual,
                                        .test = fold ? test_orbit_fold : special_curve_test,
                                        .tests = tests,
                                        .aim = special_curve_aim,
                                        .work = malloc(sizeof *c->problem.work)};
    if (!c->problem.work || all >= CURVE_MAX) {
        special_curve_end(c);
        return c->problem.work ? error_set(error, ERROR_COMMAND, "the orbit is too long for that")
                               : error_memory(error);
    }
    u[all] = now / c->qsize;
    for (int k = 0; k < 2; k++) { /* the curve may be normal to one of the parameters */
        double direction[CURVE_MAX] = {0};
        direction[k == 0 ? all : n] = side;
        if (curve_correct(&c->problem, u, direction, true, first))
            return true;
    }
    special_curve_end(c);
    return error_set(error, ERROR_COMMAND, "no curve of such points begins there");
}

/* ---- the walk ---- */

/* A walk along such a curve in one direction. */
struct special_walk {
    const struct branch_request *request;
    struct special_curve *curve;
    struct branch *branch;
    char *end; /* [96] takes the reason of the end */
};

/* Stores the reason of the end of the walk. */
static void special_walk_end_set(struct special_walk *w, const char *why)
{
    snprintf(w->end, 96, "%s", why);
}

/* Appends a point. Returns false if out of memory or if its solution is not found again. */
static bool record_point(struct special_walk *w, const struct curve_place *point,
                         enum special special)
{
    struct special_curve *c = w->curve;
    struct solution s;
    const int n = c->base.problem->n;
    if (!field_hold(&c->base.field, c->second, point->u[n + 1] * c->qsize) ||
        !solutions_at(&c->base, point, true, &s))
        return false;
    s.param[1] = point->u[n + 1] * c->qsize;
    return branch_append(w->branch, &c->base, point, special, &s);
}

/* Records the special points between two successive places of the curve, where a test function
 * changes its sign. Returns false if out of memory, if a solution is not found again, or if the
 * curve ends at a Bogdanov-Takens point (w->end). */
static bool record_specials(struct special_walk *w, const struct curve_place *current,
                            const struct curve_place *next)
{
    struct special_curve *c = w->curve;
    for (int k = 0; k < c->problem.tests; k++) {
        struct curve_place point;
        double uncertainty;
        if (!isfinite(current->test[k]) || !isfinite(next->test[k]) ||
            signbit(current->test[k]) == signbit(next->test[k]) ||
            !curve_locate(&c->problem, current, next, k, &point, &uncertainty))
            continue;
        if (!record_point(w, &point, special_of(c, k)))
            return false;
        w->branch->point[w->branch->count - 1].accuracy = uncertainty;
        if (c->kind == SPECIAL_HOPF && k == 0) {
            special_walk_end_set(
                w,
                "a Bogdanov-Takens point; beyond it the pair of eigenvalues belongs to a saddle");
            return false;
        }
    }
    return true;
}

/* Prepares the next step along orbits: renews the reference of the phase, and cuts segments along
 * which differences grow too much, if there is room. `upright` is the cosine of
 * orbit_curve_upright(). Returns false if that fails. */
static bool prepare_curve_side(struct special_walk *w, struct curve_place *point, double upright)
{
    struct special_curve *c = w->curve;
    struct orbit_curve *orbit = &c->base.orbit;
    if (c->base.kind == SOLUTION_EQUILIBRIUM)
        return true;
    if (upright < PHASE_COSINE_MIN)
        orbit_curve_refer(orbit, point->u, NULL);
    if (!orbit_curve_is_long(orbit) || c->problem.n + 1 + c->base.field.n > CURVE_MAX)
        return true;
    double u[CURVE_MAX], direction[CURVE_MAX];
    const int base_count = c->base.problem->n;
    const double q = point->u[base_count + 1], param_slope = point->tangent[base_count + 1];
    memcpy(u, point->u, sizeof u);
    memcpy(direction, point->tangent, sizeof direction);
    if (!orbit_curve_cut(orbit, u, direction) || c->base.problem->n + 2 > CURVE_MAX)
        return false;
    c->problem.n = c->base.problem->n + 1;
    c->derived = false;
    for (int i = c->base.field.n; i <= c->problem.n; i++)
        c->tangent[i] = 0;
    u[c->problem.n] = q;
    direction[c->problem.n] = param_slope;
    return curve_correct(&c->problem, u, direction, false, point);
}

/* Follows a curve of special points (such as folds) in two parameters, from `point` in one
 * direction, and records its points and the special points on it. Ends at the edge of the
 * parameters' range, after r->max points, when no further step is possible, or when cancelled, and
 * stores that reason. */
static void special_walk_follow(struct special_walk *w, struct curve_place point)
{
    const struct branch_request *r = w->request;
    const struct cancel *cancel = r->cancel;
    const struct curve_problem *problem = &w->curve->problem;
    const double psize = r->high - r->low, qsize = w->curve->qsize;
    const struct curve_ranges ranges = {
        2, {r->low / psize, r->second->low / qsize}, {r->high / psize, r->second->high / qsize}};
    const double longest = r->step > 0 ? r->step : STEP_LENGTH_MAX;
    const int max = r->max > 0 ? r->max : CURVE_POINTS_DEFAULT;
    double step = fmin(FIRST_STEP_LENGTH, longest);
    special_walk_end_set(w, "the requested number of points");
    for (int i = 0; i < max; i++) {
        struct curve_place next;
        if (!curve_next(problem, NULL, &point, &step, longest, NULL, cancel, &next)) {
            special_walk_end_set(w,
                                 cancelled(cancel) ? "cancelled" : "no further step is possible");
            return;
        }
        const bool leaves = !ranges_contain(&ranges, problem, &next);
        if (leaves && !ranges_step_to_edge(&ranges, problem, &point, &next)) {
            special_walk_end_set(w, cancelled(cancel) ? "cancelled" : "the parameters' range");
            return;
        }
        const double upright = w->curve->base.kind == SOLUTION_EQUILIBRIUM
                                   ? 1
                                   : orbit_curve_upright(&w->curve->base.orbit);
        if (!record_specials(w, &point, &next) ||
            !record_point(w, &next, leaves ? SPECIAL_END : SPECIAL_NONE))
            return;
        if (leaves) {
            special_walk_end_set(w, "the parameters' range");
            return;
        }
        if (next.corrections <= 3)
            step = fmin(1.5 * step, longest * curve_unit(problem->n, next.u));
        point = next;
        if (!prepare_curve_side(w, &point, upright)) {
            special_walk_end_set(w, cancelled(cancel)
                                        ? "cancelled"
                                        : "small differences grow too much along the orbit");
            return;
        }
    }
}

/* Follows the curve of special points from r->leave in both directions, or only in the growing one
 * if r->forward; the falling side is put in front. If a side cannot begin, what the other has found
 * is returned. Returns false with *error if nothing was found. */
bool special_follow(const struct branch_request *r, struct branch *branch, struct error *error)
{
    const int64_t start_time = clock_ns();
    *branch = (struct branch){.count = 0};
    const enum special kind = r->leave ? r->leave->special : SPECIAL_NONE;
    if (kind != SPECIAL_FOLD && kind != SPECIAL_HOPF && kind != SPECIAL_DOUBLING &&
        kind != SPECIAL_TORUS)
        return error_set(error, ERROR_COMMAND,
                         "a curve in two parameters must begin at an LP, HB, PD or NS point");
    struct special_curve *curve = malloc(sizeof *curve); /* too large for a stack */
    for (int side = curve ? -1 : 2; side <= 1; side += 2) {
        struct curve_place first;
        if (r->forward && side < 0)
            continue;
        if (!begin_curve_side(curve, r, side, &first, error)) {
            free(curve);
            branch->cancelled = cancelled(r->cancel);
            return branch->count > 0;
        }
        struct special_walk w = {
            .request = r, .curve = curve, .branch = branch, .end = branch->ends[side > 0]};
        branch->kind = curve->base.kind;
        if (branch->count > 0 || record_point(&w, &first, r->leave->special))
            special_walk_follow(&w, first);
        if (side < 0)
            branch_reverse(branch);
        branch->evals += curve->base.field.evals;
        special_curve_end(curve);
    }
    free(curve);
    branch->cancelled = cancelled(r->cancel);
    branch->seconds = clock_seconds(start_time);
    return branch->count > 0 || error_memory(error);
}
