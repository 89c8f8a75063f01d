/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The beginning of the branch that leaves a special point (solutions_leave). */
#include <math.h>
#include <string.h>

#include <hooke/base/numeric.h>

#include "modules/dynamics/orbits/solutions.h"

#define DIFFERENCE_STEP_UNITS 1e-6 /* step of a difference, in the unknowns' units */

/* Distances from the special point that are tried, in units of the curve. */
static const double distances[] = {0.1, 0.02, 0.005, 0.001, 1e-4};

/* Finds a place of the other branch at one of these distances along `direction`. Returns false if
 * none is found. */
static bool find_beside(struct solution_curve *path, const double *u, const double *direction,
                        struct curve_place *first)
{
    const int n = path->problem->n;
    for (size_t k = 0; k < COUNT_OF(distances); k++) {
        double guess[CURVE_MAX];
        for (int i = 0; i <= n; i++)
            guess[i] = u[i] + distances[k] * direction[i];
        if (curve_correct(path->problem, guess, direction, false, first))
            return true;
    }
    return false;
}

/*
 * Converts a displacement of the start to a direction in the space of unknowns, in which all
 * segments move with it. `displacement` [n + 2] is that of the state [n], of the period and of the
 * parameter, each in its unit. u are the unknowns there. Returns false if a flow cannot be
 * followed.
 */
static bool spread_displacement(struct solution_curve *path, const struct solution *solution,
                                double period, const double *displacement, double *u,
                                double *direction)
{
    struct vector_field *field = &path->field;
    struct orbit_curve *orbit = &path->orbit;
    const int n = field->n, all = path->problem->n;
    const double p = solution->param[0],
                 aside = p + DIFFERENCE_STEP_UNITS * displacement[n + 1] * orbit->psize;
    double moved[CURVE_MAX], state[FIELD_VARIABLES];
    for (int i = 0; i < n; i++)
        state[i] = solution->state[i] + DIFFERENCE_STEP_UNITS * displacement[i] * field->size[i];
    if (!field_set(field, &aside) ||
        !orbit_curve_unknowns(
            orbit, state, period + DIFFERENCE_STEP_UNITS * displacement[n] * orbit->tsize, moved) ||
        !field_set(field, &p) || !orbit_curve_unknowns(orbit, solution->state, period, u))
        return false;
    for (int i = 0; i <= all; i++)
        direction[i] = moved[i] - u[i];
    return vector_normalise(all + 1, direction);
}

/* The tangent that is stored for an orbit moves its start; all segments have to move with it. */
bool solutions_along(struct solution_curve *path, const struct branch_point *special, double *u,
                     double *direction)
{
    const struct solution *s = &special->solution;
    if (path->kind != SOLUTION_EQUILIBRIUM)
        return spread_displacement(path, s, orbit_curve_period(&path->orbit, u), special->tangent,
                                   u, direction);
    memcpy(direction, special->tangent, (size_t)(path->problem->n + 1) * sizeof *direction);
    return true;
}

/* Computes the Jacobian in units of sizes. */
static bool scaled_jacobian(struct vector_field *field, const double *state, double *jacobian)
{
    const int n = field->n;
    field_jacobian(field, state, jacobian);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            jacobian[i * n + j] *= field->size[j] / field->size[i];
    return true;
}

/* Returns the angular frequency of the eigenvalue pair nearest to the imaginary axis [1/s], or 0 if
 * there is none. */
static double hopf_frequency(const struct solution *s)
{
    double best = HUGE_VAL, omega = 0;
    for (int i = 0; i < s->values; i++)
        if (s->value[i].im > 0 && fabs(s->value[i].re) < best) {
            best = fabs(s->value[i].re);
            omega = s->value[i].im;
        }
    return omega;
}

/* Finds an orbit born at a Hopf point: a small ellipse in the plane of the eigenvector, turned by
 * each segment's share of the period, then corrected. `param` is followed in units of psize. Sets
 * *path and its first place; returns false with *error if there is none. */
static bool leave_hopf(struct solution_curve *path, const struct scene *scene, int param,
                       double psize, const struct solution *hopf, const struct cancel *cancel,
                       struct curve_place *first, struct error *error)
{
    const double omega = hopf_frequency(hopf);
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], re[FIELD_VARIABLES], im[FIELD_VARIABLES],
        u[CURVE_MAX], direction[CURVE_MAX] = {0};
    struct solution orbit = *hopf;
    struct vector_field field;
    struct scene there = *scene;
    there.value[param] = hopf->param[0];
    orbit.kind = SOLUTION_ORBIT;
    orbit.period = TWO_PI / omega;
    if (!field_init(&field, &there, &param, 1, error))
        return false;
    for (int i = 0; i < field.n; i++)
        field.size[i] = fmax(field.size[i], fabs(hopf->state[i]));
    scaled_jacobian(&field, hopf->state, jacobian);
    if (!matrix_eigenvector(field.n, jacobian, (struct eigenvalue){0, omega}, re, im) ||
        !solutions_begin(path, scene, param, psize, &orbit, cancel, u, error))
        return error_set(error, ERROR_COMMAND, "no orbit was found near the Hopf point");
    for (int k = 0; k < path->orbit.segments; k++)
        for (int i = 0; i < field.n; i++) {
            const double turned = TWO_PI * path->orbit.share[k];
            direction[k * field.n + i] = re[i] * cos(turned) - im[i] * sin(turned);
            u[k * field.n + i] = hopf->state[i] / path->field.size[i];
        }
    vector_normalise(path->problem->n + 1, direction);
    /* the phase is fixed in the plane across the orbit, which moves along -im */
    memcpy(path->orbit.reference, u, sizeof path->orbit.reference);
    for (int i = 0; i < field.n; i++)
        path->orbit.normal[i] = -im[i];
    vector_normalise(field.n, path->orbit.normal);
    if (find_beside(path, u, direction, first))
        return true;
    solutions_end(path);
    return error_set(error, ERROR_COMMAND, "no orbit was found near the Hopf point");
}

/* Finds an orbit of twice the period, displaced along the eigenvector of the multiplier -1 of
 * `doubling`. `param` is followed in units of psize. Sets *path and its first place; returns false
 * with *error if there is none. */
static bool leave_doubling(struct solution_curve *path, const struct scene *scene, int param,
                           double psize, const struct solution *doubling,
                           const struct cancel *cancel, struct curve_place *first,
                           struct error *error)
{
    double u[CURVE_MAX], re[FIELD_VARIABLES + 2] = {0}, im[FIELD_VARIABLES],
                                              direction[CURVE_MAX] = {0};
    struct curve_place point = {.corrections = 0};
    struct solution ignored, twice = *doubling;
    if (!solutions_begin(path, scene, param, psize, doubling, cancel, u, error))
        return false;
    memcpy(point.u, u, sizeof u);
    bool fine = solutions_at(path, &point, false, &ignored);
    if (fine) {
        double map[FIELD_VARIABLES * FIELD_VARIABLES];
        orbit_curve_map(&path->orbit, map);
        fine = matrix_eigenvector(path->field.n, map, (struct eigenvalue){-1, 0}, re, im);
    }
    solutions_end(path);
    twice.period *= 2;
    twice.multiple *= 2;
    if (fine && solutions_begin(path, scene, param, psize, &twice, cancel, u, error)) {
        if (spread_displacement(path, &twice, twice.period, re, u, direction) &&
            find_beside(path, u, direction, first))
            return true;
        solutions_end(path);
    }
    return error_set(error, ERROR_COMMAND, "no orbit of twice the period was found there");
}

/* Ends the curve and sets *error. Returns false. */
static bool refuse_crossing(struct solution_curve *path, struct error *error)
{
    solutions_end(path);
    return error_set(error, ERROR_COMMAND, "no other branch was found at the branch point");
}

/* Finds a place of the other branch at a branch point: the Jacobian has two null vectors there, one
 * along the known branch and the wanted one. side (1 or -1) chooses the direction along it. `param`
 * is followed in units of psize. Returns false with *error if there is none. */
static bool leave_crossing(struct solution_curve *path, const struct scene *scene, int param,
                           double psize, const struct branch_point *special, int side,
                           const struct cancel *cancel, struct curve_place *first,
                           struct error *error)
{
    double u[CURVE_MAX], f[CURVE_MAX], direction[CURVE_MAX];
    if (!solutions_begin(path, scene, param, psize, &special->solution, cancel, u, error))
        return false;
    double *jacobian = path->work->jacobian;
    const int n = path->problem->n;
    if (path->problem->residual(path->problem->context, u, f, jacobian)) {
        double known[CURVE_MAX];
        if (!solutions_along(path, special, u, known))
            return refuse_crossing(path, error);
        if (matrix_second_null(n + 1, jacobian, known, direction)) {
            for (int i = 0; i <= n; i++)
                direction[i] *= side;
            if (find_beside(path, u, direction, first))
                return true;
        }
    }
    return refuse_crossing(path, error);
}

/* Each kind of special point has its own direction: eigenvector, doubled orbit, or second null
 * vector. */
bool solutions_leave(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct branch_point *point, int side,
                     const struct cancel *cancel, struct curve_place *first, struct error *error)
{
    switch (point->special) {
    case SPECIAL_HOPF:
        return leave_hopf(path, scene, param, psize, &point->solution, cancel, first, error);
    case SPECIAL_DOUBLING:
        return leave_doubling(path, scene, param, psize, &point->solution, cancel, first, error);
    case SPECIAL_CROSSING:
        return leave_crossing(path, scene, param, psize, point, side, cancel, first, error);
    default:
        return error_set(error, ERROR_COMMAND,
                         "no branch leaves such a point; only HB, BP and PD points have one");
    }
}
