/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Newton's method for a periodic orbit near a guess (orbit_close). Where orbits come in families,
 * of conservative motion, the shooting equations are singular; the smallest correction is then
 * taken, which stays near the present amplitude. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/orbits/solutions.h"

#define RESIDUAL_CLOSED_SIZES 1e-8 /* largest residual of a closed orbit, in natural sizes */
/* Tolerance of a second solution, whose difference from the first tells the error. */
#define SECOND_SOLUTION_TOLERANCE 1e-12
#define RESIDUAL_POLISHED_SIZES 1e-11 /* residual below which nothing more is to be gained */
#define JACOBIAN_ENTRIES_MAX ((size_t)CURVE_MAX * CURVE_MAX)

/* Closes the orbit with unknowns u by the Gauss-Newton method with the smallest step, which also
 * works in families. The unknowns do not move along `normal`, of length 1, unless that is NULL.
 * room [2][JACOBIAN_ENTRIES_MAX] is work memory. Returns false if it does not converge. */
static bool close_least(struct solution_curve *path, const double *normal, double *room, double *u)
{
    const struct curve_problem *problem = path->problem;
    const int n = problem->n, all = n + 1;
    double f[CURVE_MAX], *jacobian = room, *a = room + JACOBIAN_ENTRIES_MAX, correction[CURVE_MAX],
                         last = HUGE_VAL;
    double begin[CURVE_MAX];
    bool fine = false;
    memcpy(begin, u, (size_t)n * sizeof *u);
    problem->aim(problem->context, fine);
    for (int iteration = 0; iteration < 40; iteration++) {
        double worst = 0, trace = 0, size = 0;
        if (!problem->residual(problem->context, u, f, jacobian))
            return false;
        for (int i = 0; i < n; i++)
            worst = fmax(worst, fabs(f[i]));
        double distance = 0;
        for (int i = 0; i < n && normal; i++)
            distance += normal[i] * (u[i] - begin[i]);
        if (fine && (worst < 1e-13 || (worst < RESIDUAL_CLOSED_SIZES && worst > last / 2)))
            return true;
        if (!fine && worst < 1e-5) {
            problem->aim(problem->context, fine = true);
            last = HUGE_VAL;
            continue;
        }
        for (int i = 0; i < n; i++) {
            correction[i] = normal ? -normal[i] * distance : 0;
            for (int k = 0; k < n; k++)
                correction[i] -= jacobian[k * all + i] * f[k];
            for (int j = 0; j < n; j++) {
                a[i * n + j] = normal ? normal[i] * normal[j] : 0;
                for (int k = 0; k < n; k++)
                    a[i * n + j] += jacobian[k * all + i] * jacobian[k * all + j];
            }
            trace += a[i * n + i];
        }
        for (int i = 0; i < n; i++) /* a family makes the matrix singular */
            a[i * n + i] += 1e-13 * trace / n;
        if (!matrix_solve(n, a, correction))
            return false;
        for (int i = 0; i < n; i++)
            size = fmax(size, fabs(correction[i]) / fmax(1, fabs(u[i])));
        for (int i = 0; i < n; i++)
            u[i] += correction[i] * fmin(1, 0.2 / size);
        last = worst;
    }
    return false;
}

double orbit_extent(const struct vector_field *field, const struct solution *s)
{
    double most = 0;
    for (int i = 0; i < s->n; i++)
        most = fmax(most, (s->top[i] - s->bottom[i]) / field->size[i]);
    return most;
}

/* Returns the error of a solution by comparison with flows at a looser tolerance, or NAN if
 * unknown. */
static double solution_error(struct solution_curve *path, const struct curve_place *point,
                             double *room)
{
    const int n = path->problem->n;
    double f[CURVE_MAX], *jacobian = room, *a = room + JACOBIAN_ENTRIES_MAX, most = 0;
    path->field.tol = SECOND_SOLUTION_TOLERANCE;
    const bool fine = path->problem->residual(path->problem->context, point->u, f, jacobian);
    for (int i = 0; fine && i < n; i++)
        memcpy(a + i * n, jacobian + i * (n + 1), (size_t)n * sizeof *a);
    if (!fine || !matrix_solve(n, a, f))
        return NAN;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(f[i]) / fmax(1, fabs(point->u[i])));
    return most;
}

/* Converts the direction `normal` to units of the unknowns (start and period), of length 1. */
static void held_direction_set(const struct solution_curve *path, const double *normal,
                               double *held)
{
    const int n = path->problem->n, variables = path->field.n;
    memset(held, 0, (size_t)n * sizeof *held);
    for (int i = 0; i < variables; i++)
        held[i] = normal[i] * path->field.size[i];
    held[n - 1] = normal[variables];
    vector_normalise(n, held);
}

/* Sets up the shooting problem, solves it, and checks that the result is an orbit and no slow
 * spiral into an equilibrium. */
bool orbit_close(struct orbit_search *s, const double *state, double period, int multiple,
                 const double *normal, struct found_orbit *orbit)
{
    struct solution guess = {.kind = multiple > 0 ? SOLUTION_RESPONSE : SOLUTION_ORBIT,
                             .n = s->field.n,
                             .period = period,
                             .multiple = multiple};
    struct solution_curve path;
    struct curve_place point = {.corrections = 0}, better;
    struct error ignored;
    guess.param[0] = s->field.scene.value[s->field.param[0]];
    memcpy(guess.state, state, (size_t)s->field.n * sizeof *state);
    if (!solutions_begin(&path, s->request->scene, s->field.param[0], s->field.unit[0], &guess,
                         s->request->cancel, point.u, &ignored))
        return false;
    double held[CURVE_MAX];
    if (normal)
        held_direction_set(&path, normal, held);
    double *room = malloc(2 * JACOBIAN_ENTRIES_MAX * sizeof *room);
    bool fine = room && close_least(&path, normal ? held : NULL, room, point.u) &&
                solutions_at(&path, &point, true, &orbit->solution);
    orbit->family = fine && (normal || solution_ones(&orbit->solution) > 0);
    if (fine && !orbit->family && orbit->solution.residual > RESIDUAL_POLISHED_SIZES &&
        solutions_correct_at(&path, point.u, 1, &better)) {
        memcpy(point.u, better.u, sizeof point.u);
        fine = solutions_at(&path, &point, true, &orbit->solution);
    }
    orbit->error = fine && !orbit->family ? solution_error(&path, &point, room) : NAN;
    if (fine && orbit->family) { /* double multipliers are less accurate */
        orbit->solution.unstable = 0;
        for (int i = 0; i < orbit->solution.values; i++)
            orbit->solution.unstable +=
                hypot(orbit->solution.value[i].re, orbit->solution.value[i].im) > 1 + SOLUTION_ONE;
    }
    s->field.evals += path.field.evals;
    solutions_end(&path);
    free(room);
    const double extent = fine ? orbit_extent(&s->field, &orbit->solution) : 0;
    /* A motion that winds ever more slowly into an equilibrium nearly closes, too. */
    return fine && orbit->solution.period > 0 && orbit->solution.residual < RESIDUAL_CLOSED_SIZES &&
           (multiple > 0 || (extent > 1e-6 && extent > 1e-3 * s->extent &&
                             orbit->solution.residual < RESIDUAL_CLOSED_SIZES * extent));
}
