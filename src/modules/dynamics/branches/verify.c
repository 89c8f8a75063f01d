/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Verification of special points by runs on both sides (branch_verify). The solution is displaced a
 * little along the eigenvector in question, and the run's distance from it, projected on the left
 * eigenvector, must grow or shrink as the eigenvalue or multiplier predicts. Solutions must also
 * exist, or not exist, as the label says. */
#include <float.h>
#include <math.h>

#include <hooke/base/numeric.h>
#include "modules/dynamics/branches/verdict.h"

#include "modules/dynamics/branches/walk.h"
#include "modules/dynamics/orbits/solutions.h"

/* Distance of the sides from a special point, as a part of the range. */
#define SIDE_DISTANCE_FRACTION 1e-3
/* Number of distances, each a quarter of the previous one, at which equilibria are examined; orbits
 * cost more. */
#define NEARER_EQUILIBRIA 9
#define NEARER_ORBITS 3
#define SIDE_DISTANCE_MAX_FRACTION 0.07 /* farthest distance, if nothing can be decided nearer */
#define SAME_LABEL_RELATIVE 1e-9        /* two labels within this part are at one value */
#define FOLD_ARM_LENGTH 0.01            /* arclength from a fold along both its arms */
#define PARAM_ROUNDING_RELATIVE 1e-9    /* relative, of the parameter */
#define RANGE_ROUNDING 1e-13            /* A change below this part of the range does not count. */
/* Largest displacement of a run's start, in natural sizes, and relative to the distance from the
 * special point. */
#define START_SHIFT_SIZES 1e-6
#define MOVED_PART 1e-3
#define RETRY_DISTANCE_FACTOR 0.7 /* preference for the growing one of two similar eigenvalues */
#define RATES_AGREE_RELATIVE 0.05 /* relative, of rates */
/* Largest difference between the growth of two opposite displacements, relative to both. */
#define ASYMMETRY_MAX_FRACTION 0.3
#define GROWTH_NEGLIGIBLE 1e-6 /* growth below which a run does not grow */
/* Largest logarithm of the growth in any other direction during a run. */
#define OTHER_GROWTH_LOG_MAX 5
#define RUN_FAST_TIMES_MAX 50 /* times of the fastest motion that a run lasts at most */

/* Returns the index of the eigenvalue (multiplier, of an orbit) of s whose passage through the
 * critical value makes the special point: the one nearest to that value, where of two at about
 * equal distance the growing one is preferred. For pairs, only the one with positive imaginary part
 * counts. Returns -1 if there is none. */
static int critical_index(const struct branch_point *special, const struct solution *s)
{
    const bool map = s->kind != SOLUTION_EQUILIBRIUM,
               pair = special->special == SPECIAL_HOPF || special->special == SPECIAL_TORUS;
    int best = -1;
    double least = HUGE_VAL;
    for (int i = 0; i < s->values; i++) {
        const struct eigenvalue v = s->value[i];
        const bool grows = map ? hypot(v.re, v.im) > 1 : v.re > 0;
        const double size = hypot(v.re, v.im),
                     turned = atan2(v.im, special->special == SPECIAL_DOUBLING ? -v.re : v.re);
        double distance = size;
        if (pair)
            distance = fabs(map ? log(size) : v.re);
        else if (map)
            distance = hypot(log(size), turned);
        distance *= grows ? RETRY_DISTANCE_FACTOR : 1;
        /* Real eigenvalues of conservative motion meet and leave the axis. */
        if ((pair ? v.im > 0 : v.im >= 0) && distance < least) {
            least = distance;
            best = i;
        }
    }
    return best;
}

/* Returns the growth rate [1/s] of an eigenvalue, or of a multiplier as its logarithm per
 * period. */
static double growth_rate(const struct solution *s, struct eigenvalue v)
{
    return s->kind == SOLUTION_EQUILIBRIUM ? v.re : log(hypot(v.re, v.im)) / s->period;
}

/* Copies the matrix whose eigenvectors are needed: the Jacobian, or the map over a period. */
static void growth_matrix(struct solution_curve *path, double *a)
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

/* Returns how long [s] a run has to be to show the growth of this eigenvalue without others
 * dominating. */
static double run_time(const struct solution *s, struct eigenvalue v)
{
    double fastest = 0, growth = DBL_MIN;
    if (s->kind != SOLUTION_EQUILIBRIUM)
        return s->period;
    for (int i = 0; i < s->values; i++) {
        fastest = fmax(fastest, hypot(s->value[i].re, s->value[i].im));
        growth = fmax(growth, s->value[i].re);
    }
    return fmin(v.im > 0 ? TWO_PI / v.im : fmin(1 / fabs(v.re), RUN_FAST_TIMES_MAX / fastest),
                OTHER_GROWTH_LOG_MAX / growth);
}

/* Returns the rate [1/s] at which runs leave the solution along the eigenvector of v, negative if
 * they approach it. `distance` is that from the special point. Returns NAN if a run fails or if
 * nonlinear terms dominate. */
static double rate_of_run(struct solution_curve *path, const struct solution *s,
                          struct eigenvalue v, double distance)
{
    struct vector_field *field = &path->field;
    const int n = field->n;
    double a[FIELD_VARIABLES * FIELD_VARIABLES], turned[FIELD_VARIABLES * FIELD_VARIABLES];
    double right[2][FIELD_VARIABLES], left[2][FIELD_VARIABLES], begin[2][FIELD_VARIABLES],
        end[2][FIELD_VARIABLES], seen[2][2] = {{0}}, uneven[2] = {0};
    growth_matrix(path, a);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            turned[i * n + j] = a[j * n + i];
    const double span = run_time(s, v), t0 = field->system.t0,
                 moved = fmin(START_SHIFT_SIZES,
                              fmax(MOVED_PART * distance, START_SHIFT_SIZES * MOVED_PART));
    if (!matrix_eigenvector(n, a, v, right[0], right[1]) ||
        !matrix_eigenvector(n, turned, v, left[0], left[1]))
        return NAN;
    for (int i = 0; i < n; i++) {
        /* Opposite displacements cancel quadratic terms, which matter near a special point, where
         * rates are small. */
        begin[0][i] = s->state[i] - moved * right[0][i] * field->size[i];
        begin[1][i] = s->state[i] + moved * right[0][i] * field->size[i];
    }
    field->tol = 1e-13;
    for (int k = 0; k < 2; k++)
        if (!field_flow(field, t0, begin[k], span, end[k], NULL))
            return NAN;
    for (int part = 0; part < 2; part++)
        for (int i = 0; i < n; i++) {
            seen[0][part] += left[part][i] * (begin[1][i] - begin[0][i]) / field->size[i];
            seen[1][part] += left[part][i] * (end[1][i] - end[0][i]) / field->size[i];
            uneven[part] += left[part][i] * (end[1][i] - s->state[i] - (s->state[i] - end[0][i])) /
                            field->size[i];
        }
    if (hypot(uneven[0], uneven[1]) > ASYMMETRY_MAX_FRACTION * hypot(seen[1][0], seen[1][1]))
        return NAN;
    return log(hypot(seen[1][0], seen[1][1]) / hypot(seen[0][0], seen[0][1])) / span;
}

/* Solution found beside a special point. */
struct side {
    double param; /* parameter in units of its range */
    double rate;  /* growth of a difference; > 0 if it grows */
    bool found, agrees;
};

/* Examines a point of a branch: compares the growth of a run with that of the eigenvalue. */
static struct side side_at(struct solution_curve *path, const struct branch_point *special,
                           const struct curve_place *point, double distance)
{
    struct side side = {.found = false};
    struct solution s;
    const int i = solutions_at(path, point, false, &s) ? critical_index(special, &s) : -1;
    if (i < 0)
        return side;
    const double run = rate_of_run(path, &s, s.value[i], distance),
                 still = GROWTH_NEGLIGIBLE / run_time(&s, s.value[i]);
    side.found = !isnan(run);
    side.param = point->u[path->problem->n];
    side.rate = growth_rate(&s, s.value[i]);
    side.agrees = fabs(run - side.rate) <= RATES_AGREE_RELATIVE * fabs(side.rate) + still;
    side.rate = fabs(side.rate) <= still ? 0 : side.rate;
    return side;
}

/* Examines the branch on one side (sign 1 or -1) of a special point, at arclength `arm` from a
 * fold, or where the parameter differs by side_distance. */
static struct side look_at_side(const struct branch_request *r, const struct branch_point *special,
                                double arm, double side_distance, int sign)
{
    struct side side = {.found = false};
    struct solution_curve path;
    struct curve_place point;
    struct error ignored;
    double u[CURVE_MAX], direction[CURVE_MAX], guess[CURVE_MAX];
    if (!solutions_begin(&path, r->scene, r->param, r->high - r->low, &special->solution, r->cancel,
                         u, &ignored))
        return side;
    const int n = path.problem->n;
    bool fine = solutions_along(&path, special, u, direction);
    const double step =
        sign * (special->special == SPECIAL_FOLD || !fine
                    ? arm
                    : side_distance / fmax(fabs(direction[n]), side_distance / arm));
    for (int i = 0; i <= n && fine; i++)
        guess[i] = u[i] + step * direction[i];
    if (fine && curve_correct(path.problem, guess, direction, true, &point))
        side = side_at(&path, special, &point, fabs(step));
    solutions_end(&path);
    return side;
}

/* Returns true if there is no solution at the parameter `param` (a part of its range), beyond a
 * fold, within twice the arclength `arm` of its arms. */
static bool has_no_solution(const struct branch_request *r, const struct branch_point *special,
                            double param, double arm)
{
    struct solution_curve path;
    struct curve_place point;
    struct error ignored;
    double u[CURVE_MAX];
    struct solution guess = special->solution;
    guess.param[0] = param * (r->high - r->low);
    if (!solutions_begin(&path, r->scene, r->param, r->high - r->low, &guess, r->cancel, u,
                         &ignored))
        return true;
    const bool is_occupied = solutions_correct_at(&path, u, 1, &point) &&
                             curve_distance(path.problem->n, point.u, u) < 2 * arm;
    solutions_end(&path);
    return !is_occupied;
}

/* Checks that the orbit born at a Hopf point exists on the side of the parameter that the
 * criticality predicts; `unstable` > 0 means that the equilibrium is unstable at larger values.
 * Returns VERDICT_CONFIRMED also without a criticality, and VERDICT_OPEN if no orbit is found. */
static enum branch_verdict confirm_birth(const struct branch_request *r,
                                         const struct branch_point *special, double unstable)
{
    struct solution_curve path;
    struct curve_place first;
    struct error ignored;
    const double psize = r->high - r->low, here = special->solution.param[0] / psize;
    if (special->criticality == 0 || !isfinite(special->criticality))
        return VERDICT_CONFIRMED;
    if (!solutions_leave(&path, r->scene, r->param, psize, special, 1, r->cancel, &first, &ignored))
        return VERDICT_OPEN;
    const double param_change = first.u[path.problem->n] - here;
    solutions_end(&path);
    return (param_change > 0) == ((special->criticality < 0) == (unstable > 0))
               ? VERDICT_CONFIRMED
               : VERDICT_OTHER_SIDE;
}

/* Examines the branch that crosses at the special point, on one side of it. */
static struct side look_across(const struct branch_request *r, const struct branch_point *special,
                               int sign)
{
    struct side side = {.found = false};
    struct solution_curve path;
    struct curve_place first;
    struct error ignored;
    if (!solutions_leave(&path, r->scene, r->param, r->high - r->low, special, sign, r->cancel,
                         &first, &ignored))
        return side;
    side = side_at(&path, special, &first, START_SHIFT_SIZES / MOVED_PART);
    solutions_end(&path);
    return side;
}

/* Returns the verdict that follows from the growth on both sides. */
static enum branch_verdict growth_verdict(const struct side *left, const struct side *right)
{
    if (!left->found || !right->found || (left->rate == 0 && right->rate == 0))
        return VERDICT_OPEN;
    if (!left->agrees || !right->agrees)
        return VERDICT_OTHER_GROWTH;
    return (left->rate > 0) == (right->rate > 0) ? VERDICT_SAME_GROWTH : VERDICT_CONFIRMED;
}

/* Returns the verdict on a fold: solutions must exist on both arms, which lie on the same side of
 * its parameter with different stability, and none on the other side. `arm` is the length along the
 * branch at which the arms are looked at. VERDICT_OPEN means that the parameter changes too little
 * to decide. */
static enum branch_verdict confirm_fold(const struct branch_request *r,
                                        const struct branch_point *special, double arm)
{
    const double here = special->solution.param[0] / (r->high - r->low);
    const struct side left = look_at_side(r, special, arm, 0, -1),
                      right = look_at_side(r, special, arm, 0, 1);
    const double b = left.param - here, a = right.param - here;
    if (!left.found || !right.found ||
        fmin(fabs(a), fabs(b)) < fmax(PARAM_ROUNDING_RELATIVE * fabs(here), RANGE_ROUNDING))
        return VERDICT_OPEN; /* the parameter has hardly changed */
    if ((a > 0) != (b > 0))
        return VERDICT_NO_TURN;
    const enum branch_verdict verdict = growth_verdict(&left, &right);
    return verdict == VERDICT_CONFIRMED && !has_no_solution(r, special, here - a, arm)
               ? VERDICT_OTHER_SIDE
               : verdict;
}

/* Returns the verdict on a special point from both sides at a distance in the parameter, as a part
 * of its range. */
static enum branch_verdict confirm_at_distance(const struct branch_request *r,
                                               const struct branch_point *special,
                                               double side_distance)
{
    if (special->special == SPECIAL_FOLD)
        return confirm_fold(r, special, side_distance * (FOLD_ARM_LENGTH / SIDE_DISTANCE_FRACTION));
    struct side left = look_at_side(r, special, FOLD_ARM_LENGTH, side_distance, -1),
                right = look_at_side(r, special, FOLD_ARM_LENGTH, side_distance, 1);
    const double here = special->solution.param[0] / (r->high - r->low);
    /* a branch that turns back there, as a pitchfork's, leaves its change to the one it crosses */
    if (special->special == SPECIAL_CROSSING && left.found && right.found && left.agrees &&
        right.agrees && (left.param > here) == (right.param > here)) {
        left = look_across(r, special, -1);
        right = look_across(r, special, 1);
    }
    const enum branch_verdict verdict = growth_verdict(&left, &right);
    const double unstable = (left.rate > 0 ? left : right).param - here;
    return verdict == VERDICT_CONFIRMED && special->special == SPECIAL_HOPF
               ? confirm_birth(r, special, unstable)
               : verdict;
}

/* Returns the verdict from several distances. One confirmation is enough; a contradiction must
 * occur at two distances, as one probe may fail because of other special points or faster growth.
 * Nearer distances come first; those beyond the first, up to `farthest`, are tried only if nothing
 * was decided. */
static enum branch_verdict confirm_anywhere(const struct branch_request *r,
                                            const struct branch_point *special, double farthest)
{
    const int nearer =
        special->solution.kind == SOLUTION_EQUILIBRIUM ? NEARER_EQUILIBRIA : NEARER_ORBITS;
    enum branch_verdict contradiction = VERDICT_OPEN;
    int contradictions = 0;
    double side_distance = fmin(SIDE_DISTANCE_FRACTION, farthest);
    for (int k = 0; k < nearer && !cancelled(r->cancel); k++, side_distance /= 4) {
        const enum branch_verdict verdict = confirm_at_distance(r, special, side_distance);
        if (verdict == VERDICT_CONFIRMED)
            return verdict;
        if (verdict == VERDICT_OPEN && k > 0)
            break;
        contradiction = verdict == VERDICT_OPEN ? contradiction : verdict;
        contradictions += verdict != VERDICT_OPEN;
    }
    for (side_distance = 4 * SIDE_DISTANCE_FRACTION;
         side_distance <= fmin(farthest, SIDE_DISTANCE_MAX_FRACTION) && !cancelled(r->cancel);
         side_distance *= 4) {
        const enum branch_verdict verdict = confirm_at_distance(r, special, side_distance);
        if (verdict == VERDICT_CONFIRMED && contradiction != VERDICT_SAME_GROWTH)
            return verdict;
        contradiction = contradiction == VERDICT_OPEN ? verdict : contradiction;
        contradictions += verdict != VERDICT_OPEN;
    }
    return contradictions > 1 ? contradiction : VERDICT_OPEN;
}

/* Returns the text of a contradiction, or NULL for other verdicts. */
const char *branch_contradiction(int verdict)
{
    switch (verdict) {
    case VERDICT_SAME_GROWTH:
        return "small differences grow, or shrink, on both sides of it";
    case VERDICT_OTHER_GROWTH:
        return "in runs near it differences do not grow as its eigenvalues predict";
    case VERDICT_NO_TURN:
        return "the parameter does not turn back there";
    case VERDICT_OTHER_SIDE:
        return "solutions exist on the side where there should be none";
    default:
        return NULL;
    }
}

/* Returns the largest distance at which the point number `place` is examined, a quarter of that to
 * the next special point. */
static double side_distance_at(const struct branch_request *r, const struct branch *branch,
                               int place)
{
    const double here = branch->point[place].solution.param[0];
    double side_distance = SIDE_DISTANCE_MAX_FRACTION;
    for (int i = 0; i < branch->count; i++) {
        const double far = fabs(branch->point[i].solution.param[0] - here) / (r->high - r->low);
        if (branch->point[i].special != SPECIAL_NONE && far > SAME_LABEL_RELATIVE)
            side_distance = fmin(side_distance, far / 4);
    }
    return side_distance;
}

/* Returns how far from a fold of equilibria the nearest other special point is along the curve, as
 * the distance beside it at which arms remain well before that point. */
static double side_distance_at_fold(const struct branch_request *r, const struct branch *branch,
                                    int place)
{
    struct solution_curve path;
    struct error ignored;
    double u[CURVE_MAX], side_distance = SIDE_DISTANCE_MAX_FRACTION;
    const struct solution *fold = &branch->point[place].solution;
    if (fold->kind != SOLUTION_EQUILIBRIUM ||
        !solutions_begin(&path, r->scene, r->param, r->high - r->low, fold, r->cancel, u, &ignored))
        return SIDE_DISTANCE_MAX_FRACTION;
    for (int i = 0; i < branch->count; i++) {
        const struct branch_point *other = &branch->point[i];
        double far = fabs(other->solution.param[0] - fold->param[0]) / (r->high - r->low);
        for (int k = 0; k < path.field.n; k++)
            far = hypot(far, (other->solution.state[k] - fold->state[k]) / path.field.size[k]);
        if (i != place && other->special != SPECIAL_NONE && other->special < SPECIAL_END)
            side_distance =
                fmin(side_distance, far / 4 / (FOLD_ARM_LENGTH / SIDE_DISTANCE_FRACTION));
    }
    solutions_end(&path);
    return side_distance;
}

/* Verifies all special points of a branch but its ends, each at distances that others do not
 * disturb, and sets their `verified`. Curves of special points in two parameters are left as they
 * are. Progress continues from FOLLOWING_TIME_FRACTION to 1. */
void branch_verify(const struct branch_request *r, struct branch *branch)
{
    const int64_t start_time = clock_ns();
    for (int i = 0; i < branch->count && !cancelled(r->cancel); i++) {
        struct branch_point *point = &branch->point[i];
        if (point->special == SPECIAL_NONE || point->special >= SPECIAL_END || r->second)
            continue;
        if (r->progress)
            r->progress(r->context, FOLLOWING_TIME_FRACTION +
                                        (1 - FOLLOWING_TIME_FRACTION) * i / branch->count);
        const enum branch_verdict verdict =
            confirm_anywhere(r, point,
                             point->special == SPECIAL_FOLD ? side_distance_at_fold(r, branch, i)
                                                            : side_distance_at(r, branch, i));
        if (!cancelled(r->cancel))
            point->verified = verdict;
    }
    branch->seconds += clock_seconds(start_time);
}
