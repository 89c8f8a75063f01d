/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Solutions as points of a curve: unknowns, eigenvalues or multipliers, extrema, and the kind of
 * special points. */
#include "modules/dynamics/orbits/solutions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/catalog.h>
#include <hooke/base/numeric.h>

#include "modules/solving/compute/algebra.h"

static const struct row special_rows[] = {
    {"LP", "", "fold (limit point): the branch turns back", "", NULL},
    {"HB", "", "Hopf point: an orbit is born", "", NULL},
    {"BP", "", "branch point: another branch crosses", "", NULL},
    {"PD", "", "period doubling", "", NULL},
    {"NS", "", "Neimark-Sacker: motion with two frequencies is born", "", NULL},
    {"EP", "", "end of the branch", "", NULL},
    {"CP", "", "cusp: two folds meet", "", NULL},
    {"BT", "", "Bogdanov-Takens point: two eigenvalues are 0", "", NULL},
    {"GH", "", "generalised Hopf point: the first Lyapunov coefficient is 0", "", NULL},
};
const struct catalog special_catalog = CATALOG("special point", special_rows);

void solutions_end(struct solution_curve *path)
{
    field_free(&path->field);
    free(path->work);
    path->work = NULL;
}

/* Sets up the field and the problem of that kind of solution, and converts the guess to
 * unknowns. */
bool solutions_begin(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct solution *guess, const struct cancel *cancel,
                     double *u, struct error *error)
{
    struct scene guess_scene = *scene;
    guess_scene.value[param] = guess->param[0];
    path->kind = guess->kind;
    if (!field_init(&path->field, &guess_scene, &param, 1, error))
        return false;
    struct vector_field *field = &path->field;
    field->cancel = cancel;
    path->work = malloc(sizeof *path->work);
    if (!path->work) {
        field_free(field);
        return error_memory(error);
    }
    /* sizes are those of the solution, not of the scene's start */
    for (int i = 0; i < field->n; i++)
        field->size[i] = fmax(field->size[i], fabs(guess->state[i]));
    if (guess->kind == SOLUTION_EQUILIBRIUM) {
        equilibrium_curve_init(&path->equilibrium, field, psize);
        path->equilibrium.problem.work = path->work;
        path->problem = &path->equilibrium.problem;
        for (int i = 0; i < field->n; i++)
            u[i] = guess->state[i] / field->size[i];
        u[field->n] = guess->param[0] / psize;
        return true;
    }
    path->problem = &path->orbit.problem;
    if (orbit_curve_init(&path->orbit, field, psize, guess->state, guess->period,
                         guess->multiple) &&
        orbit_curve_unknowns(
            &path->orbit, guess->state,
            path->orbit.forced ? guess->multiple * field_drive(field) : guess->period, u)) {
        orbit_curve_refer(&path->orbit, u, NULL);
        path->orbit.problem.work = path->work;
        return true;
    }
    solutions_end(path);
    return error_set(error, ERROR_COMMAND, "the motion from there ends within one period");
}

bool solutions_correct_at(struct solution_curve *path, const double *u, int sign,
                          struct curve_place *point)
{
    double direction[CURVE_MAX] = {0};
    direction[path->problem->n] = sign;
    return curve_correct(path->problem, u, direction, true, point);
}

/* ---- properties of a solution ---- */

/* Extends the extrema of variable i to the value y. */
static void extend_extremes(struct solution *s, int i, double y)
{
    s->top[i] = fmax(s->top[i], y);
    s->bottom[i] = fmin(s->bottom[i], y);
}

/* Extends the extrema of variable i in *s by y1 and by those of the cubic over a time h with values
 * y0, y1 and rates f0, f1 at its ends. */
static void cubic_extremes(struct solution *s, int i, double h, double y0, double f0, double y1,
                           double f1)
{
    extend_extremes(s, i, y1);
    if (signbit(f0) == signbit(f1))
        return;
    /* y' = f0 + theta (2 c) + theta^2 (3 d), in units of h */
    const double c = 3 * (y1 - y0) / h - 2 * f0 - f1, d = f0 + f1 - 2 * (y1 - y0) / h;
    const double root = sqrt(fmax(c * c - 3 * d * f0, 0)), q = -(c + copysign(root, c));
    for (int k = 0; k < 2; k++) {
        const double theta = k == 0 ? q / (3 * d) : f0 / q;
        if (theta > 0 && theta < 1)
            extend_extremes(s, i, hermite(theta, h, y0, f0, y1, f1));
    }
}

/* Finds the extrema of all variables segment by segment, as differences may grow much over the
 * whole orbit. Between two states it uses the cubic through both. Returns false if the orbit cannot
 * be followed. */
static bool find_extremes(struct solution_curve *path, const double *u, struct solution *s)
{
    struct vector_field *field = &path->field;
    const int n = field->n;
    double grid[FIELD_TIMES * FIELD_VARIABLES], rate[2][FIELD_VARIABLES], t, span;
    for (int segment = 0; segment < path->orbit.segments; segment++) {
        if (!orbit_curve_follow(&path->orbit, u, segment, &t, &span, grid))
            return false;
        const double h = span / (FIELD_TIMES - 1);
        system_derivative(&field->system, t, grid, rate[0]);
        for (int i = 0; i < n; i++)
            extend_extremes(s, i, grid[i]);
        for (int k = 1; k < FIELD_TIMES; k++) {
            const double *left = grid + (k - 1) * n, *right = grid + k * n;
            system_derivative(&field->system, t + k * h, right, rate[k % 2]);
            for (int i = 0; i < n; i++)
                cubic_extremes(s, i, h, left[i], rate[(k - 1) % 2][i], right[i], rate[k % 2][i]);
        }
    }
    return true;
}

/* Computes the eigenvalues from the Jacobian, and counts those that grow. Returns false if that
 * fails. */
static bool fill_equilibrium(struct solution_curve *path, const double *jacobian,
                             struct solution *s)
{
    const int n = path->field.n;
    double square[FIELD_VARIABLES * FIELD_VARIABLES], size = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            size = fmax(size, fabs(square[i * n + j] = jacobian[i * (n + 1) + j]));
    s->values = n;
    s->trivial = NAN;
    if (!matrix_eigenvalues(n, square, s->value))
        return false;
    for (int i = 0; i < n; i++)
        s->unstable += s->value[i].re > 1e-12 * size;
    return true;
}

/* Computes period and multipliers, and counts those that grow. Returns false if that fails. */
static bool fill_orbit(struct solution_curve *path, const double *u, struct solution *s)
{
    struct multipliers m;
    if (!orbit_curve_multipliers(&path->orbit, &m))
        return false;
    s->values = m.count;
    memcpy(s->value, m.value, sizeof s->value);
    s->noise = m.noise;
    s->trivial = m.trivial;
    s->period = orbit_curve_period(&path->orbit, u);
    s->multiple = path->orbit.forced ? path->orbit.multiple : 0;
    for (int i = 0; i < s->values; i++)
        s->unstable += hypot(s->value[i].re, s->value[i].im) > 1 + 1e-10;
    return true;
}

/* Sets kind and state of the solution from the unknowns of a point. */
static void set_state(const struct solution_curve *path, const struct curve_place *point,
                      struct solution *s)
{
    const struct vector_field *field = &path->field;
    *s = (struct solution){.kind = path->kind, .n = field->n};
    for (int i = 0; i < field->n; i++)
        s->state[i] = s->top[i] = s->bottom[i] = point->u[i] * field->size[i];
}

/* Evaluates the residual for the Jacobian or the maps, from which eigenvalues or multipliers
 * follow. */
bool solutions_at(struct solution_curve *path, const struct curve_place *point, bool extremes,
                  struct solution *s)
{
    struct vector_field *field = &path->field;
    double f[CURVE_MAX], *jacobian = path->work->jacobian;
    set_state(path, point, s);
    if (!path->problem->residual(path->problem->context, point->u, f, jacobian))
        return false;
    for (int i = 0; i < path->problem->n; i++)
        s->residual = fmax(s->residual, fabs(f[i]));
    s->param[0] = field->scene.value[field->param[0]];
    if (path->kind == SOLUTION_EQUILIBRIUM)
        return fill_equilibrium(path, jacobian, s);
    return fill_orbit(path, point->u, s) && (!extremes || find_extremes(path, point->u, s));
}

/* Uses the maps that the last correction has left, except for equilibria, which cost little. */
bool solutions_seen(struct solution_curve *path, const struct curve_place *point,
                    struct solution *s)
{
    struct vector_field *field = &path->field;
    if (path->kind == SOLUTION_EQUILIBRIUM)
        return solutions_at(path, point, false, s);
    set_state(path, point, s);
    s->residual = point->residual;
    s->param[0] = point->u[path->problem->n] * path->orbit.psize;
    return field_set(field, s->param) && fill_orbit(path, point->u, s) &&
           find_extremes(path, point->u, s);
}

/* Returns true if a complex pair of eigenvalues is on the imaginary axis, or for a `map` on the
 * unit circle, so that the test of the pair is not 0 because of two real ones. */
static bool has_critical_pair(const struct solution *s, bool map)
{
    double best = HUGE_VAL, im = 0, size = 0;
    for (int i = 0; i < s->values; i++) {
        const double distance =
            map ? fabs(hypot(s->value[i].re, s->value[i].im) - 1) : fabs(s->value[i].re);
        size = fmax(size, hypot(s->value[i].re, s->value[i].im));
        if (s->value[i].im > 0 && distance < best) {
            best = distance;
            im = s->value[i].im;
        }
    }
    return im > 0 && best < 1e-5 * size;
}

int solution_ones(const struct solution *s)
{
    int count = 0;
    for (int i = 0; i < s->values; i++)
        count += hypot(s->value[i].re - 1, s->value[i].im) < SOLUTION_ONE;
    return count;
}

/* Returns true if a multiplier is -1. */
static bool has_multiplier_minus_one(const struct solution *s)
{
    for (int i = 0; i < s->values; i++)
        if (fabs(s->value[i].re + 1) < 1e-3 && fabs(s->value[i].im) < 1e-3)
            return true;
    return false;
}

/* Checks that eigenvalues really are where the test says, since tests are 0 for neutral saddles,
 * too. */
enum special solutions_special(const struct solution_curve *path, int test,
                               const struct solution *solution)
{
    static const enum special equilibrium[] = {[EQUILIBRIUM_FOLD] = SPECIAL_FOLD,
                                               [EQUILIBRIUM_CROSSING] = SPECIAL_CROSSING,
                                               [EQUILIBRIUM_HOPF] = SPECIAL_HOPF},
                              orbit[] = {[ORBIT_FOLD] = SPECIAL_FOLD,
                                         [ORBIT_CROSSING] = SPECIAL_CROSSING,
                                         [ORBIT_DOUBLING] = SPECIAL_DOUBLING,
                                         [ORBIT_TORUS] = SPECIAL_TORUS};
    const bool is_map = path->kind != SOLUTION_EQUILIBRIUM;
    const enum special special = (is_map ? orbit : equilibrium)[test];
    bool is_real = true;
    if (special == SPECIAL_HOPF || special == SPECIAL_TORUS)
        is_real = has_critical_pair(solution, is_map);
    else if (special == SPECIAL_DOUBLING)
        is_real = has_multiplier_minus_one(solution);
    return is_real ? special : SPECIAL_NONE;
}
