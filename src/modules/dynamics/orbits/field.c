/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene as a vector field with free parameters, its flow with derivatives, and where it jumps. */
#include "modules/dynamics/orbits/field.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/numeric.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/typed.h>

#include "modules/solving/compute/solve.h"

#define FLOW_TOL 1e-13     /* relative tolerance of flows */
#define FLOW_MOST 400000   /* evaluations of a flow after which the equations count as stiff */
#define FLOW_STIFF 2000000 /* largest number of evaluations of a flow by the implicit method */
#define PARAM_STEP_RELATIVE 1e-6 /* step of differences by a parameter, relative to its value */
#define RATES_JUMP 1e-6 /* relative change of the rates across a jump that is not rounding */
/* Part of the largest size below which a natural size is only a floor. */
static const double unseen_size_max = 2e-12;
/* Admissible error of derivatives by a parameter, in units of sizes. */
#define PARAM_DERIVATIVE_ERROR 1e-7

/* ---- rates and their derivatives ---- */

/* Drops what was computed for the old values of the parameters. */
static void forget_derivatives(struct vector_field *field)
{
    field->varied = false;
    field->drive_by[0] = field->drive_by[1] = NAN;
}

/* Sets the sizes in which states are measured. A variable that the motion from the scene's start
 * leaves at rest, as where that is an equilibrium, has none of its own: it gets the largest. */
static void choose_sizes(const struct system *system, double *size)
{
    double most = 0;
    for (int i = 0; i < system->n; i++)
        most = fmax(most, system->scale[i]);
    for (int i = 0; i < system->n; i++)
        size[i] = system->scale[i] < unseen_size_max * most ? most : system->scale[i];
}

/* Copies and binds the scene, and chooses the sizes of its variables. */
bool field_init(struct vector_field *field, const struct scene *scene, const int *param, int params,
                struct error *error)
{
    *field = (struct vector_field){.scene = *scene, .params = params, .tol = FLOW_TOL};
    for (int j = 0; j < params; j++)
        field->param[j] = param[j], field->unit[j] = fmax(fabs(scene->value[param[j]]), 1);
    if (!scene_bind_motion(scene, &field->system, error))
        return false;
    const struct system *system = &field->system;
    field->n = system->n;
    if (system->n > FIELD_VARIABLES)
        return error_set(error, ERROR_COMMAND,
                         "the scene has %d variables; at most %d are supported", system->n,
                         FIELD_VARIABLES);
    choose_sizes(system, field->size);
    for (int i = 0; i < system->n; i++) {
        field->turn[i] = variable_is_angle(system, i) ? TWO_PI : 0;
    }
    forget_derivatives(field);
    return true;
}

void field_free(struct vector_field *field)
{
    free(field->variation);
    field->variation = NULL;
}

/* Binds the scene with other values. Sizes stay, and so does what needs no start: that of the scene
 * may lie outside of the domain with these values. */
static bool rebind(struct vector_field *field)
{
    double scale[LIMIT_VARIABLES];
    const size_t bytes = (size_t)field->n * sizeof *scale;
    memcpy(scale, field->system.scale, bytes);
    forget_derivatives(field);
    if (!scene_bind_rates(&field->scene, &field->system))
        return false;
    memcpy(field->system.scale, scale, bytes);
    return true;
}

/* Binds the scene again only if a value has changed. */
bool field_set(struct vector_field *field, const double *value)
{
    bool same = true;
    for (int j = 0; j < field->params; j++) {
        same = same && field->scene.value[field->param[j]] == value[j];
        field->scene.value[field->param[j]] = value[j];
    }
    return same || rebind(field);
}

bool field_hold(struct vector_field *field, int place, double value)
{
    if (field->scene.value[place] == value)
        return true;
    field->scene.value[place] = value;
    return rebind(field);
}

void field_rate(struct vector_field *field, const double *y, double *rate)
{
    field->evals++;
    system_derivative(&field->system, field->system.t0, y, rate);
}

void field_jacobian(struct vector_field *field, const double *y, double *jacobian)
{
    field->evals++;
    system_jacobian(&field->system, field->system.t0, y, jacobian);
}

/* Copies the scene with free parameter j a little larger and smaller. Returns the difference of its
 * values. */
static double parameter_sides(const struct vector_field *field, int j, struct scene side[2])
{
    const int index = field->param[j];
    const double value = field->scene.value[index],
                 delta = PARAM_STEP_RELATIVE * fmax(fabs(value), 1e-3);
    side[0] = side[1] = field->scene;
    side[0].value[index] = value + delta;
    side[1].value[index] = value - delta;
    return side[0].value[index] - side[1].value[index];
}

/* Computes a central difference of the rates between two values of the parameter. */
bool field_by_parameter(struct vector_field *field, int j, const double *y, double *slope)
{
    struct scene side[2];
    struct system system;
    double rate[2][LIMIT_VARIABLES];
    const double param_difference = parameter_sides(field, j, side);
    for (int s = 0; s < 2; s++) {
        if (!scene_bind_rates(&side[s], &system))
            return false;
        system_derivative(&system, field->system.t0, y, rate[s]);
    }
    field->evals += 2;
    for (int i = 0; i < field->n; i++)
        slope[i] = (rate[0][i] - rate[1][i]) / param_difference;
    return true;
}

double field_drive(const struct vector_field *field)
{
    return system_drive(&field->system);
}

/* Computes a central difference of the drive's period, once for each value of the parameters. */
double field_drive_by(struct vector_field *field, int j)
{
    if (!isnan(field->drive_by[j]))
        return field->drive_by[j];
    struct scene side[2];
    struct system system;
    double period[2];
    const double param_difference = parameter_sides(field, j, side);
    for (int s = 0; s < 2; s++) {
        if (!scene_bind_rates(&side[s], &system))
            return NAN;
        period[s] = system_drive(&system);
    }
    return field->drive_by[j] = (period[0] - period[1]) / param_difference;
}

/* ---- the flow ---- */

/* Integrates the system over `span` with a method and at most `most` evaluations. Sets end [n] and,
 * unless NULL, grid [FIELD_TIMES][n]. Returns false if it does not get there. */
static bool flow_integrate(struct vector_field *field, const struct system *system,
                           const char *name, double span, int64_t most, double *end, double *grid)
{
    struct solver solver;
    struct run_settings settings = {.tol = field->tol, .kernel = KERNEL_SPECIALISED};
    const struct method *method = method_find(name);
    struct error ignored;
    if (!method_applies(method, system, &settings.drag, &ignored) ||
        !solver_init(&solver, system, method, &settings, span))
        return false;
    solver.max = most;
    const enum stop stop = solver_run(&solver, grid, field->cancel);
    field->evals += solver_cost(&solver);
    memcpy(end, solver.y, (size_t)system->n * sizeof *end);
    solver_free(&solver);
    return stop == STOP_END;
}

/* Integrates with dop853, or with radau5 if that takes too many steps because the equations are
 * stiff. Returns false if neither gets there or if cancelled. */
static bool integrate_flow(struct vector_field *field, const struct system *system, double span,
                           double *end, double *grid)
{
    return (!field->stiff && flow_integrate(field, system, "dop853", span, FLOW_MOST, end, grid)) ||
           (!cancelled(field->cancel) &&
            (field->stiff = flow_integrate(field, system, "radau5", span, FLOW_STIFF, end, grid)));
}

/* The system is copied, so that its start and sizes can be replaced. */
bool field_follow(struct vector_field *field, double t, const double *start, double span,
                  double *grid)
{
    double end[LIMIT_VARIABLES];
    struct system system = field->system;
    const double tol = field->tol;
    system.t0 = t;
    memcpy(system.start, start, (size_t)field->n * sizeof *start);
    memcpy(system.scale, field->size, (size_t)field->n * sizeof *start);
    field->tol = 1e-10;
    const bool fine = integrate_flow(field, &system, span, end, grid);
    field->tol = tol;
    return fine;
}

/* Sets up the variational equations for the present parameters. Returns false if out of memory or
 * if a derivative by a parameter is not available. */
static bool bind_variation(struct vector_field *field)
{
    if (field->varied)
        return true;
    if (!field->variation)
        field->variation = malloc(sizeof *field->variation);
    if (!field->variation)
        return false;
    variation_of_start(field->variation, &field->system, field->size);
    for (int j = 0; j < field->params; j++)
        if (!variation_add_parameter(field->variation, &field->scene, field->param[j]))
            return false;
    return field->varied = variation_add_trace(field->variation);
}

/* Converts the solution of the variational equations to derivatives in units of sizes. */
static void take_slopes(const struct vector_field *field, const double *all,
                        struct flow_slopes *slopes)
{
    const int n = field->n;
    for (int c = 0; c < n; c++)
        for (int i = 0; i < n; i++)
            slopes->by_start[i * n + c] = all[n * (c + 1) + i] / field->size[i];
    for (int j = 0; j < field->params; j++)
        for (int i = 0; i < n; i++)
            slopes->by_parameter[j][i] = all[n * (n + 1 + j) + i] / field->size[i];
    slopes->log_determinant = all[field->variation->whole.n - 1];
}

/* Integrates the scene, or its variational equations if derivatives are wanted. */
bool field_flow(struct vector_field *field, double t, const double *start, double span, double *end,
                struct flow_slopes *slopes)
{
    const int n = field->n;
    double all[LIMIT_VARIABLES];
    struct system copy, *system = &copy;
    if (slopes) {
        if (!bind_variation(field))
            return false;
        system = &field->variation->whole;
    } else {
        copy = field->system;
    }
    system->t0 = t;
    memcpy(system->start, start, (size_t)n * sizeof *start);
    for (int i = 0; i < n * (1 + (slopes ? n + field->params : 0)); i++)
        system->scale[i] = field->size[i % n];
    /* derivatives by a parameter are differences: the step must not follow their rounding */
    for (int j = 0; slopes && j < field->params; j++)
        for (int i = 0; i < n; i++)
            system->scale[n * (n + 1 + j) + i] *=
                fmax(PARAM_DERIVATIVE_ERROR / field->tol, 1) / field->unit[j];
    if (!integrate_flow(field, system, span, all, NULL))
        return false;
    memcpy(end, all, (size_t)n * sizeof *end);
    if (slopes)
        take_slopes(field, all, slopes);
    return true;
}

/* ---- distances, and planes that the motion crosses ---- */

double field_apart(const struct vector_field *field, int i, const double *x, const double *y)
{
    const double difference = y[i] - x[i];
    return (field->turn[i] > 0 ? remainder(difference, field->turn[i]) : difference) /
           field->size[i];
}

double field_distance(const struct vector_field *field, const double *x, const double *y)
{
    double most = 0;
    for (int i = 0; i < field->n; i++)
        most = fmax(most, fabs(field_apart(field, i, x, y)));
    return most;
}

/* Projects y on the line, and limits the result to its ends. */
void field_nearest_on_line(const struct vector_field *field, const double *y, const double *a,
                           const double *b, double *nearest)
{
    double projection = 0, length = 0;
    for (int i = 0; i < field->n; i++) {
        const double delta = (b[i] - a[i]) / field->size[i];
        projection += field_apart(field, i, a, y) * delta;
        length += delta * delta;
    }
    const double share = length > 0 ? fmin(fmax(projection / length, 0), 1) : 0;
    for (int i = 0; i < field->n; i++)
        nearest[i] = a[i] + share * (b[i] - a[i]);
}

void field_plane_across(struct vector_field *field, const double *state, struct field_plane *plane)
{
    field_rate(field, state, plane->normal);
    for (int i = 0; i < field->n; i++) {
        plane->origin[i] = state[i];
        plane->normal[i] /= field->size[i];
    }
}

double field_side(const struct vector_field *field, const struct field_plane *plane,
                  const double *y)
{
    double sum = 0;
    for (int i = 0; i < field->n; i++)
        sum += plane->normal[i] * field_apart(field, i, plane->origin, y);
    return sum;
}

/* Context of side_after(). */
struct crossing_search {
    struct vector_field *field;
    double t;
    const double *start;
    const struct field_plane *plane;
    double *point;
};

/* Follows the motion for `span`, and returns the side of the plane on which it is then. */
static double side_after(void *context, double span)
{
    const struct crossing_search *c = context;
    return field_flow(c->field, c->t, c->start, span, c->point, NULL)
               ? field_side(c->field, c->plane, c->point)
               : NAN;
}

double field_crossing(struct vector_field *field, double t, const double *start, double span,
                      const double *end, const struct field_plane *plane, double *point)
{
    struct crossing_search c = {field, t, start, plane, point};
    const double when = root_between(side_after, &c, 0, field_side(field, plane, start), span,
                                     field_side(field, plane, end), 1e-15 * fabs(span));
    return isnan(side_after(&c, when)) ? NAN : when;
}

/* ---- jumps ---- */

/* Returns true if the equations jump where a switch turns over on the chord between two
 * neighbouring states. */
static bool jumps_between(const struct vector_field *field, double t, const double *a,
                          const double *b)
{
    const struct system *system = &field->system;
    const size_t bytes = (size_t)system->switches * sizeof(double);
    double first[LIMIT_SWITCHES], last[LIMIT_SWITCHES], now[LIMIT_SWITCHES], y[LIMIT_VARIABLES],
        rate[2][LIMIT_VARIABLES], lo = 0, hi = 1, size = 0, jump = 0;
    struct system frozen;
    system_branches(system, t, a, first);
    system_branches(system, t, b, last);
    if (memcmp(first, last, bytes) == 0)
        return false;
    while (hi - lo > DBL_EPSILON) {
        const double share = (lo + hi) / 2;
        for (int i = 0; i < field->n; i++)
            y[i] = a[i] + share * (b[i] - a[i]);
        system_branches(system, t, y, now);
        if (memcmp(first, now, bytes) == 0) {
            lo = share;
        } else {
            hi = share;
            memcpy(last, now, bytes);
        }
    }
    for (int s = 0; s < 2; s++) {
        system_freeze(system, s == 0 ? first : last, &frozen);
        system_derivative(&frozen, t, y, rate[s]);
    }
    for (int i = 0; i < field->n; i++) {
        size = fmax(size, fmax(fabs(rate[0][i]), fabs(rate[1][i])) / field->size[i]);
        jump = fmax(jump, fabs(rate[1][i] - rate[0][i]) / field->size[i]);
    }
    return jump > RATES_JUMP * size;
}

/* Follows the motion and examines each part of it in which a switch changes. */
bool field_jumps(struct vector_field *field, double t, const double *start, double span)
{
    const int n = field->n;
    double grid[FIELD_TIMES * FIELD_VARIABLES];
    bool jumps = false;
    if (field->system.switches == 0 || !field_follow(field, t, start, span, grid))
        return false;
    for (int k = 1; k < FIELD_TIMES && !jumps; k++)
        jumps = jumps_between(field, t + (k - 0.5) * span / (FIELD_TIMES - 1), grid + (k - 1) * n,
                              grid + k * n);
    return jumps;
}
