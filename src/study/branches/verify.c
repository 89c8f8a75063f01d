/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What a special point says, held against runs on both sides of it: the solution is moved a little
 * along the eigenvector in question, and the run's distance from it, as the left eigenvector sees
 * it, must grow or shrink as the eigenvalue or multiplier says; and solutions must be there, or not
 * be there, as the label says.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include <hooke/base/numeric.h>

#include "study/branches/eigen.h"
#include "study/branches/walk.h"
#include "study/dynamics/solutions.h"

#define BESIDE 1e-3   /* of the range, */
#define FARTHEST 0.07 /* where nothing can be told so near */
#define SAME 1e-9     /* two labels at one value */
#define ARM 0.01      /* arclength from a fold along both its arms */
#define FAR 0.5
#define BEYOND 1e-9 /* relative, of the parameter */
#define MOVED 1e-6  /* units of size */
#define NEARLY 0.7
#define AGREES 0.05 /* relative, of rates */
#define STILL 1e-6  /* growth of a run that is none */
#define FAST 5      /* logarithm of how much anything else may grow in it */
#define LONG 50     /* times of the fastest motion that a run lasts at most */

/* Which eigenvalue a label is about: the one nearest to where it passes; of two about as near the
 * one that grows. */
static int critical(const struct branch_point *at, const struct solution *s)
{
    const bool map = s->kind != SOLUTION_EQUILIBRIUM,
               pair = at->special == SPECIAL_HOPF || at->special == SPECIAL_TORUS;
    int best = -1;
    double least = HUGE_VAL;
    for (int i = 0; i < s->values; i++) {
        const struct eigenvalue v = s->value[i];
        const bool grows = map ? hypot(v.re, v.im) > 1 : v.re > 0;
        const double size = hypot(v.re, v.im), turned = at->special == SPECIAL_DOUBLING
                                                            ? atan2(v.im, -v.re)
                                                            : atan2(v.im, v.re);
        double off = pair && map ? fabs(log(size))
                     : pair      ? fabs(v.re)
                     : map       ? hypot(log(size), turned)
                                 : size;
        off *= grows ? NEARLY : 1;
        /* real ones meet and leave the axis in conservative motion */
        if ((pair ? v.im > 0 : v.im >= 0) && off < least) {
            least = off;
            best = i;
        }
    }
    return best;
}

/* [1/s] or, over a period, of its logarithm */
static double rate_of(const struct solution *s, struct eigenvalue v)
{
    return s->kind == SOLUTION_EQUILIBRIUM ? v.re : log(hypot(v.re, v.im)) / s->period;
}

static void matrix_of(struct solution_curve *path, double *a)
{
    const int n = path->field.n, all = path->problem->n + 1;
    if (path->kind != SOLUTION_EQUILIBRIUM) {
        orbit_curve_map(&path->orbit, a);
        return;
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            a[i * n + j] = path->work->jacobian[i * all + j];
}

static double time_of(const struct solution *s, struct eigenvalue v)
{
    double fastest = 0, growth = DBL_MIN;
    if (s->kind != SOLUTION_EQUILIBRIUM)
        return s->period;
    for (int i = 0; i < s->values; i++) {
        fastest = fmax(fastest, hypot(s->value[i].re, s->value[i].im));
        growth = fmax(growth, s->value[i].re);
    }
    return fmin(v.im > 0 ? TWO_PI / v.im : fmin(1 / fabs(v.re), LONG / fastest), FAST / growth);
}

/* The rate at which a run leaves or nears the solution along that eigenvector; NAN: not found. */
static double rate_of_run(struct solution_curve *path, const struct solution *s,
                          struct eigenvalue v)
{
    struct vector_field *field = &path->field;
    const int n = field->n;
    double a[FIELD_VARIABLES * FIELD_VARIABLES], turned[FIELD_VARIABLES * FIELD_VARIABLES];
    double right[2][FIELD_VARIABLES], left[2][FIELD_VARIABLES], begin[2][FIELD_VARIABLES],
        end[2][FIELD_VARIABLES], seen[2][2] = {{0}};
    matrix_of(path, a);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            turned[i * n + j] = a[j * n + i];
    const double span = time_of(s, v), t0 = field->system.t0;
    if (!matrix_eigenvector(n, a, v, right[0], right[1]) ||
        !matrix_eigenvector(n, turned, v, left[0], left[1]))
        return NAN;
    for (int i = 0; i < n; i++) {
        begin[0][i] = s->state[i];
        begin[1][i] = s->state[i] + MOVED * right[0][i] * field->size[i];
    }
    field->tol = 1e-13;
    for (int k = 0; k < 2; k++)
        if (!field_flow(field, t0, begin[k], span, end[k], NULL))
            return NAN;
    for (int part = 0; part < 2; part++)
        for (int i = 0; i < n; i++) {
            seen[0][part] += left[part][i] * (begin[1][i] - begin[0][i]) / field->size[i];
            seen[1][part] += left[part][i] * (end[1][i] - end[0][i]) / field->size[i];
        }
    return log(hypot(seen[1][0], seen[1][1]) / hypot(seen[0][0], seen[0][1])) / span;
}

/* What is found at that arclength along the branch. */
struct side {
    double param; /* in units of its range */
    double rate;  /* > 0: a difference grows */
    bool found, agrees;
};

static struct side side_at(struct solution_curve *path, const struct branch_point *at,
                           const struct curve_place *point)
{
    struct side side = {.found = false};
    struct solution s;
    const int i = solutions_at(path, point, false, &s) ? critical(at, &s) : -1;
    if (i < 0)
        return side;
    const double run = rate_of_run(path, &s, s.value[i]), still = STILL / time_of(&s, s.value[i]);
    side.found = true;
    side.param = point->u[path->problem->n];
    side.rate = rate_of(&s, s.value[i]);
    side.agrees = fabs(run - side.rate) <= AGREES * fabs(side.rate) + still;
    side.rate = fabs(side.rate) <= still ? 0 : side.rate;
    return side;
}

static struct side look_at_side(const struct branch_request *r, const struct branch_point *at,
                                double arm, double beside, int sign)
{
    struct side side = {.found = false};
    struct solution_curve path;
    struct curve_place point;
    struct error ignored;
    double u[CURVE_MAX], direction[CURVE_MAX], guess[CURVE_MAX];
    if (!solutions_begin(&path, r->scene, r->param, r->to - r->from, &at->solution, r->cancel, u,
                         &ignored))
        return side;
    const int n = path.problem->n;
    bool fine = solutions_along(&path, at, u, direction);
    const double by = sign * (at->special == SPECIAL_FOLD || !fine
                                  ? arm
                                  : beside / fmax(fabs(direction[n]), beside / arm));
    for (int i = 0; i <= n && fine; i++)
        guess[i] = u[i] + by * direction[i];
    if (fine && curve_correct(path.problem, guess, direction, true, &point))
        side = side_at(&path, at, &point);
    solutions_end(&path);
    return side;
}

/* Beyond a fold there is nothing near. */
static bool is_empty(const struct branch_request *r, const struct branch_point *at, double param)
{
    struct solution_curve path;
    struct curve_place point;
    struct error ignored;
    double u[CURVE_MAX];
    struct solution guess = at->solution;
    guess.param[0] = param * (r->to - r->from);
    if (!solutions_begin(&path, r->scene, r->param, r->to - r->from, &guess, r->cancel, u,
                         &ignored))
        return true;
    const bool near = solutions_correct_at(&path, u, 1, &point) &&
                      curve_distance(path.problem->n, point.u, u) < 2 * ARM;
    solutions_end(&path);
    return !near;
}

/* The orbit that is born at a Hopf point is on the side that the criticality says: 1, -1, or 0. */
static int is_born_there(const struct branch_request *r, const struct branch_point *at,
                         double unstable)
{
    struct solution_curve path;
    struct curve_place first;
    struct error ignored;
    const double psize = r->to - r->from, here = at->solution.param[0] / psize;
    if (at->criticality == 0 || !isfinite(at->criticality))
        return 1;
    if (!solutions_leave(&path, r->scene, r->param, psize, at, 1, r->cancel, &first, &ignored))
        return 0;
    const double by = first.u[path.problem->n] - here;
    solutions_end(&path);
    return (by > 0) == ((at->criticality < 0) == (unstable > 0)) ? 1 : -1;
}

/* On the branch that crosses there, to one side. */
static struct side look_across(const struct branch_request *r, const struct branch_point *at,
                               int sign)
{
    struct side side = {.found = false};
    struct solution_curve path;
    struct curve_place first;
    struct error ignored;
    if (!solutions_leave(&path, r->scene, r->param, r->to - r->from, at, sign, r->cancel, &first,
                         &ignored))
        return side;
    side = side_at(&path, at, &first);
    solutions_end(&path);
    return side;
}

/* 1, -1, or 0: it cannot be told. */
static int confirm_fold(const struct branch_request *r, const struct branch_point *at)
{
    const double here = at->solution.param[0] / (r->to - r->from);
    for (double arm = ARM; arm < FAR; arm *= 4) {
        const struct side before = look_at_side(r, at, arm, 0, -1),
                          after = look_at_side(r, at, arm, 0, 1);
        const double b = before.param - here, a = after.param - here;
        if (!before.found || !after.found)
            return 0;
        if (fmin(fabs(a), fabs(b)) < BEYOND * fabs(here))
            continue; /* the parameter has hardly changed */
        return before.agrees && after.agrees && (before.rate > 0) != (after.rate > 0) &&
                       (a > 0) == (b > 0) && is_empty(r, at, here - a)
                   ? 1
                   : -1;
    }
    return 0;
}

/* beside: how far in the parameter, part of its range. */
static int confirm(const struct branch_request *r, const struct branch_point *at, double beside)
{
    if (at->special == SPECIAL_FOLD)
        return confirm_fold(r, at);
    struct side before = look_at_side(r, at, ARM, beside, -1),
                after = look_at_side(r, at, ARM, beside, 1);
    const double here = at->solution.param[0] / (r->to - r->from);
    /* a branch that turns back there, as a pitchfork's, leaves its change to the one it crosses */
    if (at->special == SPECIAL_CROSSING && before.found && after.found && before.agrees &&
        after.agrees && (before.param > here) == (after.param > here)) {
        before = look_across(r, at, -1);
        after = look_across(r, at, 1);
    }
    if (!before.found || !after.found || (before.rate == 0 && after.rate == 0))
        return 0;
    const double unstable = (before.rate > 0 ? before : after).param - here;
    if (!(before.agrees && after.agrees && (before.rate > 0) != (after.rate > 0)))
        return -1;
    return at->special == SPECIAL_HOPF ? is_born_there(r, at, unstable) : 1;
}

/* Not beyond the next special point. */
static double beside_of(const struct branch_request *r, const struct branch *branch, int place)
{
    const double here = branch->point[place].solution.param[0];
    double beside = FARTHEST;
    for (int i = 0; i < branch->count; i++) {
        const double far = fabs(branch->point[i].solution.param[0] - here) / (r->to - r->from);
        if (branch->point[i].special != SPECIAL_NONE && far > SAME)
            beside = fmin(beside, far / 4);
    }
    return beside;
}

void branch_verify(const struct branch_request *r, struct branch *branch)
{
    const int64_t since = clock_ns();
    for (int i = 0; i < branch->count && !cancelled(r->cancel); i++) {
        struct branch_point *point = &branch->point[i];
        if (point->special == SPECIAL_NONE || point->special >= SPECIAL_END || r->second)
            continue;
        if (r->progress)
            r->progress(r->context, FOLLOWED + (1 - FOLLOWED) * i / branch->count);
        const double most = beside_of(r, branch, i);
        int verdict = confirm(r, point, fmin(BESIDE, most));
        for (double beside = 4 * BESIDE; verdict == 0 && beside <= fmin(most, FARTHEST);
             beside *= 4)
            verdict = confirm(r, point, beside); /* differences hardly grow nearer to it */
        if (!cancelled(r->cancel))
            point->verified = verdict;
    }
    branch->seconds += clock_seconds(since);
}
