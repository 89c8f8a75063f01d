/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points along a curve, and special points between them. A zero of a test is searched along the
 * chord between two points: each place on it is corrected in the plane across the chord. Where two
 * curves cross, this correction is singular at the zero itself; there the test and the unknowns are
 * interpolated by polynomials through places on both sides of it (Chebyshev nodes), whose errors
 * are rounding divided by the distance. */
#include "modules/dynamics/orbits/continuation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <hooke/base/numeric.h>
#include <hooke/scene/formula.h>

#define CORRECTIONS_MAX 8            /* largest number of Newton's steps */
#define JACOBIAN_REUSE_DISTANCE 3e-6 /* derivatives so near are good enough for a step */
/* A step along the curve ends when the next correction would be smaller. */
#define STEP_NEXT_CORRECTION_MAX 1e-9
/* A correction below this that does not shrink any more is rounding. */
#define STALLED_CORRECTION_MAX 1e-9
#define FINE_CORRECTION_MAX 1e-15 /* a correction below this is rounding */
/* Derivatives that were computed within this distance are exact to rounding. */
#define JACOBIAN_EXACT_DISTANCE 1e-12
#define ZERO_EVALUATIONS_MAX 60      /* evaluations after which a test counts as not smooth */
#define HALVINGS_MAX 12              /* largest number of times that a chord is shortened */
#define STRAIGHT_CHORD_FRACTION 1e-3 /* part of a chord that counts as straight */
/* Rounding error of a test relative to its values at the ends of the chord. */
#define TEST_ROUNDING_RELATIVE 1e-13
#define TANGENT_ROUNDING 1e-14   /* rounding of a tangent */
#define CORRECTION_MAX_UNITS 0.5 /* a larger correction leads to another curve */

/* Returns the dot product of two vectors [n]. */
static double vector_dot(int n, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

double curve_unit(int n, const double *u)
{
    double most = 1;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(u[i]));
    return most;
}

double curve_distance(int n, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum);
}

/* Solves the system of the n rows of the Jacobian and the row `direction` for the right side [n +
 * 1], which becomes the solution. Returns false if it is singular. */
static bool solve_bordered(const struct curve_problem *problem, const double *direction,
                           double *right)
{
    const int n = problem->n;
    double *a = problem->work->matrix;
    memcpy(a, problem->work->jacobian, (size_t)(n * (n + 1)) * sizeof *a);
    memcpy(a + n * (n + 1), direction, (size_t)(n + 1) * sizeof *a);
    return matrix_solve(n + 1, a, right);
}

/* Solves for the null vector of the Jacobian that points along `direction`. */
bool curve_tangent(const struct curve_problem *problem, const double *direction, double *tangent)
{
    const int n = problem->n;
    for (int i = 0; i < n; i++)
        tangent[i] = 0;
    tangent[n] = 1;
    if (!solve_bordered(problem, direction, tangent))
        return false;
    return vector_normalise(n + 1, tangent);
}

/* Returns the largest component of a correction, relative to its unknown if that is larger than
 * 1. */
static double correction_size(int n, const double *correction, const double *u)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(correction[i]) / fmax(1, fabs(u[i])));
    return most;
}

/* Applies Newton's method in the plane through `guess` across `direction`, then computes tangent
 * and tests. Without `fine` it stops when the next correction would be negligible for a step.
 * Returns false if it fails. */
static bool correct_in_plane(const struct curve_problem *problem, const double *guess,
                             const double *direction, bool fine, struct curve_place *point)
{
    const int n = problem->n;
    double *jacobian = problem->work->jacobian, f[CURVE_MAX], plane[CURVE_MAX], last = HUGE_VAL;
    memcpy(plane, guess, (size_t)(n + 1) * sizeof *plane);
    memmove(point->u, guess, (size_t)(n + 1) * sizeof *plane);
    for (point->corrections = 1; point->corrections <= CORRECTIONS_MAX; point->corrections++) {
        if (!problem->residual(problem->context, point->u, f, jacobian))
            return false;
        point->residual = 0;
        for (int i = 0; i < n; i++) {
            point->residual = fmax(point->residual, fabs(f[i]));
            f[i] = -f[i];
        }
        f[n] = vector_dot(n + 1, direction, plane) - vector_dot(n + 1, direction, point->u);
        if (!solve_bordered(problem, direction, f))
            return false;
        const double size = correction_size(n + 1, f, point->u);
        if (!(size < CORRECTION_MAX_UNITS))
            return false;
        for (int i = 0; i <= n; i++)
            point->u[i] += f[i];
        /* size of the next correction if convergence remains quadratic */
        const double next = size * fmin(size / last, 1) * fmin(size / last, 1);
        if (size < FINE_CORRECTION_MAX || (size < STALLED_CORRECTION_MAX && size >= last / 2) ||
            (size < JACOBIAN_EXACT_DISTANCE && isfinite(last) && next < FINE_CORRECTION_MAX) ||
            (!fine && (size < 100 * STEP_NEXT_CORRECTION_MAX ||
                       (size < JACOBIAN_REUSE_DISTANCE && isfinite(last) &&
                        next < STEP_NEXT_CORRECTION_MAX)))) {
            if (!curve_tangent(problem, direction, point->tangent))
                return false;
            if (problem->tests > 0)
                problem->test(problem->context, point->u, jacobian, point->tangent, point->test);
            return true;
        }
        last = size;
    }
    return false;
}

/* Chooses the accuracy of the residuals if the problem has a choice. */
static void curve_problem_aim(const struct curve_problem *problem, bool fine)
{
    if (problem->aim)
        problem->aim(problem->context, fine);
}

bool curve_correct(const struct curve_problem *problem, const double *guess,
                   const double *direction, bool fine, struct curve_place *point)
{
    curve_problem_aim(problem, fine);
    point->careful = fine;
    return correct_in_plane(problem, guess, direction, fine, point);
}

/* Returns true if the parameter changes so little that the correction must go to rounding to show
 * which way it does. */
static bool is_steep(const struct curve_problem *problem, const struct curve_place *point)
{
    const double slope = fabs(point->tangent[problem->n]);
    return slope < CURVE_STEEP && slope > CURVE_LEVEL;
}

/* Predicts by tangent and curvature, then corrects in the plane across the tangent. */
bool curve_step(const struct curve_problem *problem, const struct curve_place *previous,
                const struct curve_place *current, double step, struct curve_place *next)
{
    const int n = problem->n;
    double guess[CURVE_MAX], bend = 0;
    if (previous) {
        double last_step = 0;
        for (int i = 0; i <= n; i++)
            last_step += (current->u[i] - previous->u[i]) * current->tangent[i];
        bend = last_step * step > 0 ? step * step / (2 * last_step) : 0;
    }
    for (int i = 0; i <= n; i++)
        guess[i] = current->u[i] + step * current->tangent[i] +
                   (previous ? bend * (current->tangent[i] - previous->tangent[i]) : 0);
    next->careful = is_steep(problem, current);
    curve_problem_aim(problem, false);
    if (!correct_in_plane(problem, guess, current->tangent, false, next))
        return false;
    if (!next->careful && problem->aim)
        return true;
    /* only what is left of the way to rounding needs residuals that cost as much; those that always
     * are to rounding cost nothing more */
    const int before_that = next->corrections;
    curve_problem_aim(problem, true);
    const bool fine = correct_in_plane(problem, next->u, current->tangent, !problem->aim, next);
    if (!problem->aim || before_that > next->corrections)
        next->corrections = before_that;
    return fine;
}

/* ---- special points ---- */

/* The chord between two points of a curve, on which a zero is searched. */
struct chord {
    const struct curve_problem *problem;
    const struct curve_place *a, *b;
    double direction[CURVE_MAX], length; /* unit vector from a to b, and their distance */
    int test;                 /* index of the test whose zero is searched, unless `value` is set */
    curve_value *value;       /* function whose zero is searched, or NULL for the test */
    void *context;            /* context of `value` */
    int evaluations;          /* number of evaluations so far */
    struct curve_place point; /* last place */
    double share; /* position of `point` on the chord, 0 to 1, or NAN if there is none */
    bool failed;  /* a place could not be corrected */
};

/* Computes a guess at a share (0 to 1) of the chord: along the tangent of the last place if that is
 * near, else by the cubic through both ends with their tangents. */
static void chord_guess(const struct chord *c, double share, double *guess)
{
    const int n = c->problem->n;
    const double advance = (share - c->share) * c->length;
    if (fabs(share - c->share) < STRAIGHT_CHORD_FRACTION && !c->value &&
        !(c->problem->singular >> c->test & 1)) {
        for (int i = 0; i <= n; i++)
            guess[i] = c->point.u[i] + advance * c->point.tangent[i];
    } else {
        for (int i = 0; i <= n; i++) {
            const double slope[] = {c->length * c->a->tangent[i], c->length * c->b->tangent[i]};
            guess[i] = hermite(share, 1, c->a->u[i], slope[0], c->b->u[i], slope[1]);
        }
    }
    /* put into the plane across the chord at this share */
    double distance = share * c->length;
    for (int i = 0; i <= n; i++)
        distance -= c->direction[i] * (guess[i] - c->a->u[i]);
    for (int i = 0; i <= n; i++)
        guess[i] += distance * c->direction[i];
}

/* Evaluates the test, or c->value, at a share of the chord; NAN if there is no solution. A test
 * that is 0 but for rounding gives 0. */
static double chord_test(void *context, double share)
{
    struct chord *c = context;
    double guess[CURVE_MAX];
    chord_guess(c, share, guess);
    c->share = share;
    if (c->evaluations++ == ZERO_EVALUATIONS_MAX ||
        !curve_correct(c->problem, guess, c->direction, true, &c->point)) {
        c->failed = true;
        return c->share = NAN;
    }
    if (c->value)
        return c->value(c->context, &c->point);
    const double value = c->point.test[c->test],
                 size = fmax(fabs(c->a->test[c->test]), fabs(c->b->test[c->test]));
    double rounding = TEST_ROUNDING_RELATIVE * size;
    if (value == c->point.tangent[c->problem->n]) /* the test of a fold */
        rounding = fmax(rounding, TANGENT_ROUNDING);
    return fabs(value) <= rounding ? 0 : value;
}

/* Sets up the chord from a to b. */
static void chord_init(struct chord *c, const struct curve_problem *problem,
                       const struct curve_place *a, const struct curve_place *b, int test)
{
    const int n = problem->n;
    *c = (struct chord){.problem = problem, .a = a, .b = b, .test = test, .share = NAN};
    c->length = curve_distance(n + 1, a->u, b->u);
    for (int i = 0; i <= n; i++)
        c->direction[i] = (b->u[i] - a->u[i]) / c->length;
}

bool curve_between(const struct curve_problem *problem, const struct curve_place *a,
                   const struct curve_place *b, double share, struct curve_place *point)
{
    struct chord c;
    double guess[CURVE_MAX];
    chord_init(&c, problem, a, b, 0);
    chord_guess(&c, share, guess);
    return c.length > 0 && curve_correct(problem, guess, c.direction, true, point);
}

#define INTERPOLATION_NODES 10 /* places through which a polynomial is laid */
#define INTERPOLATION_LEVELS 6 /* largest number of times that their distance is reduced */
#define TOO_NEAR 1e-4          /* smallest value of the test, relative to the largest, at a place */
#define CROSSING_ERROR_MAX 1e-6 /* a crossing that is less accurate than this does not count */

/* Returns the value at `position` of the polynomial through `count` nodes, by Newton's divided
 * differences. */
static double interpolated(int count, const double *node, const double *value, double position)
{
    double d[INTERPOLATION_NODES];
    memcpy(d, value, (size_t)count * sizeof *d);
    for (int level = 1; level < count; level++)
        for (int i = count; i-- > level;)
            d[i] = (d[i] - d[i - 1]) / (node[i] - node[i - level]);
    double sum = d[count - 1];
    for (int i = count - 1; i-- > 0;)
        sum = d[i] + (position - node[i]) * sum;
    return sum;
}

/* Values of a test at nodes. */
struct fitted_test {
    int count;
    double node[INTERPOLATION_NODES], value[INTERPOLATION_NODES];
};

static double fitted_value(void *context, double position)
{
    const struct fitted_test *f = context;
    return interpolated(f->count, f->node, f->value, position);
}

/* Gathers places at Chebyshev nodes around `centre`, up to `half` away. Places too near to the
 * crossing are left out, as their correction may lead to the other curve. Returns false if too few
 * remain on both sides. */
static bool gather_nodes(struct chord *c, double centre, double half, struct fitted_test *fit,
                         struct curve_place *point)
{
    double most = 0;
    fit->count = 0;
    for (int k = 0; k < INTERPOLATION_NODES; k++) {
        const double node = centre - half * cos((2 * k + 1) * PI / (2 * INTERPOLATION_NODES));
        c->failed = false;
        const double value = chord_test(c, node);
        if (c->failed || !isfinite(value))
            continue;
        fit->node[fit->count] = node;
        fit->value[fit->count] = value;
        point[fit->count++] = c->point;
        most = fmax(most, fabs(value));
    }
    int remaining = 0;
    for (int k = 0; k < fit->count; k++) {
        if (fabs(fit->value[k]) < TOO_NEAR * most)
            continue;
        fit->node[remaining] = fit->node[k];
        fit->value[remaining] = fit->value[k];
        point[remaining++] = point[k];
    }
    fit->count = remaining;
    return remaining >= INTERPOLATION_NODES - 3 &&
           signbit(fit->value[0]) != signbit(fit->value[remaining - 1]);
}

/* Finds the crossing near `centre` by polynomials through places up to `half` from it, all as
 * shares of the chord. */
static bool locate_crossing(struct chord *c, double centre, double half, struct curve_place *point,
                            double *share)
{
    const int n = c->problem->n;
    struct fitted_test fit;
    struct curve_place place[INTERPOLATION_NODES];
    if (!gather_nodes(c, centre, half, &fit, place))
        return false;
    const int last = fit.count - 1;
    *share = root_between(fitted_value, &fit, fit.node[0], fit.value[0], fit.node[last],
                          fit.value[last], 4 * DBL_EPSILON);
    double y[INTERPOLATION_NODES];
    *point = place[0];
    for (int i = 0; i <= n; i++) {
        for (int k = 0; k < fit.count; k++)
            y[k] = place[k].u[i];
        point->u[i] = interpolated(fit.count, fit.node, y, *share);
        for (int k = 0; k < fit.count; k++)
            y[k] = place[k].tangent[i];
        point->tangent[i] = interpolated(fit.count, fit.node, y, *share);
    }
    if (!c->value)
        point->test[c->test] = 0;
    return true;
}

/* Finds a crossing from places that come ever nearer, as long as that moves the result less: too
 * near, errors of the corrections and rounding dominate. Returns false if the uncertainty remains
 * too large. */
static bool refine_crossing(struct chord *c, double share, double half, struct curve_place *point,
                            double *uncertainty)
{
    double next;
    *uncertainty = HUGE_VAL;
    for (int k = 0; k < INTERPOLATION_LEVELS; k++, half /= 4) {
        struct curve_place better;
        c->evaluations = 0;
        if (!locate_crossing(c, share, half, &better, &next))
            break;
        const double moved = c->length * fabs(next - share);
        /* The first step measures the distance to the crossing, not the error. */
        if (k > 1 && moved >= *uncertainty)
            break;
        *uncertainty = moved;
        *point = better;
        share = next;
        if (*uncertainty < 1e-12)
            break;
    }
    return *uncertainty < CROSSING_ERROR_MAX;
}

bool curve_find_zero(const struct curve_problem *problem, const struct curve_place *a,
                     const struct curve_place *b, curve_value *value, void *context,
                     struct curve_place *point, double *uncertainty)
{
    struct chord c;
    chord_init(&c, problem, a, b, 0);
    c.value = value;
    c.context = context;
    return c.length > 0 && refine_crossing(&c, 0.5, 0.5, point, uncertainty);
}

/* Finds the crossing on ever shorter parts of the chord, until the test is nearly a polynomial
 * there. */
static bool find_crossing(struct chord *c, struct curve_place *point, double *uncertainty)
{
    double begin = 0, end = 1;
    bool is_negative = signbit(c->a->test[c->test]);
    for (int k = 0; k < HALVINGS_MAX; k++) {
        const double middle = (begin + end) / 2;
        if (refine_crossing(c, middle, (end - begin) / 2, point, uncertainty))
            return true;
        c->failed = false;
        c->evaluations = 0;
        const double value = chord_test(c, middle);
        if (c->failed || !isfinite(value))
            return false;
        *(signbit(value) == is_negative ? &begin : &end) = middle;
    }
    return false;
}

/* Finds the zero of a test on the chord from a to b. Returns false if the chord is too far from the
 * curve. */
static bool locate_on_chord(const struct curve_problem *problem, const struct curve_place *a,
                            const struct curve_place *b, int test, struct curve_place *point,
                            double *uncertainty)
{
    struct chord c;
    chord_init(&c, problem, a, b, test);
    if (problem->singular >> test & 1)
        return find_crossing(&c, point, uncertainty);
    const double root =
        root_between(chord_test, &c, 0, a->test[test], 1, b->test[test], 4 * DBL_EPSILON);
    if (c.failed)
        return false;
    if (c.share != root)
        chord_test(&c, root);
    *point = c.point;
    *uncertainty = c.length * TEST_ROUNDING_RELATIVE;
    return !c.failed;
}

/* If the chord is too far from the curve, one end steps towards the other. */
bool curve_locate(const struct curve_problem *problem, const struct curve_place *a,
                  const struct curve_place *b, int test, struct curve_place *point,
                  double *uncertainty)
{
    struct curve_place left = *a, right = *b, middle;
    for (int k = 0; k < HALVINGS_MAX; k++) {
        if (locate_on_chord(problem, &left, &right, test, point, uncertainty))
            return true;
        if (problem->singular >> test & 1)
            return false;
        double step = curve_distance(problem->n + 1, left.u, right.u) / 2;
        int tries = 0;
        while (!curve_step(problem, NULL, &left, step, &middle) && ++tries < HALVINGS_MAX)
            step /= 2;
        if (tries == HALVINGS_MAX)
            return false;
        if (signbit(middle.test[test]) == signbit(left.test[test]))
            left = middle;
        else
            right = middle;
    }
    return false;
}
