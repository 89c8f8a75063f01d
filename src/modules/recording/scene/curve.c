/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The motion of a scene as a curve with parameters (curve.h). The steps are chosen once and then
 * stay fixed: the curve is then a smooth function of the parameters, and the same steps of the
 * variational equations give its derivatives exactly (internal numerical differentiation: Bock
 * 1981). Samples are read off the dense output, one polynomial a step. A linear scene needs no
 * steps. */
#include <hooke/base/cancel.h>
#include "modules/recording/scene/curve.h"

#include <stdlib.h>
#include <string.h>

/* Smallest tolerance of rodas5p, for stiff scenes. */
#define TOLERANCE_STIFF 1e-8
/* Largest number of steps of a mesh. */
#define STEPS_MOST 2000000

/* ---- the curve ---- */

/* Sets *value to the curve's variable (or its rate of change, for c->rate) plus the offset, at time
 * t, and derivative [parameters], unless NULL, to its derivatives. y holds the state, followed by
 * its derivative by each free parameter; `system` has the curve's variables first. */
static void take_sample(const struct scene_curve *c, const struct system *system, double t,
                        const double *y, double offset, double *value, double *derivative)
{
    double rate[LIMIT_VARIABLES];
    const int n = c->variation->base.n;
    if (c->rate) {
        system_derivative(system, t, y, rate);
        y = rate;
    }
    *value = y[c->variable] + offset;
    for (int j = 0; j < c->frees && derivative; j++)
        derivative[j] = y[n * (j + 1) + c->variable];
    if (c->offset && derivative)
        derivative[c->frees] = 1;
}

/* Components of the state from which samples are computed: the series' variable and its derivatives
 * by parameters or, if its rate is observed, all. */
struct wanted_solutions {
    int count, index[LIMIT_VARIABLES];
};

/* Returns the components that the curve needs. */
static struct wanted_solutions wanted_of(const struct scene_curve *c, const struct system *system)
{
    struct wanted_solutions w = {.count = 0};
    const int n = c->variation->base.n;
    for (int i = 0; i < system->n; i++)
        if (c->rate || i % n == c->variable)
            w.index[w.count++] = i;
    return w;
}

/* Stores sample i, computed from the state y. */
static void put_sample(const struct scene_curve *c, const struct system *system,
                       const struct sampling *s, size_t i, const double *y)
{
    take_sample(c, system, s->t[i], y, s->offset, &s->value[i],
                s->derivative ? s->derivative + i * s->columns : NULL);
}

/* Stores the samples at the start time. */
bool scene_curve_first(const struct scene_curve *c, const struct system *system,
                       const struct sampling *s, size_t *i)
{
    for (*i = 0; *i < s->n && s->t[*i] <= system->t0; ++*i) {
        if (s->t[*i] < system->t0)
            return false;
        put_sample(c, system, s, *i, system->start);
    }
    return true;
}

/* Evaluates the step's polynomials at the samples within it, from number *i on, which becomes that
 * of the first sample after the step. t_begin is the begin of the step [s]. */
void scene_curve_inside(const struct scene_curve *c, const struct step *step,
                        const struct sampling *s, double t_begin, size_t *i)
{
    const struct wanted_solutions w = wanted_of(c, step->system);
    struct dense_polynomial polynomial[LIMIT_VARIABLES];
    double inside[LIMIT_VARIABLES];
    if (*i < s->n && s->t[*i] < step->t) {
        for (int k = 0; k < w.count; k++)
            method_polynomial(c->method, step, w.index[k], &polynomial[k]);
        do {
            const double theta = (s->t[*i] - t_begin) / step->h;
            for (int k = 0; k < w.count; k++)
                inside[w.index[k]] = dense_polynomial_at(&polynomial[k], theta);
            put_sample(c, step->system, s, *i, inside);
        } while (++*i < s->n && s->t[*i] < step->t);
    }
    for (; *i < s->n && s->t[*i] == step->t; ++*i)
        put_sample(c, step->system, s, *i, step->y);
}

/* Integrates the system along the mesh of steps and stores the samples. Returns false if a step
 * failed, if a sample lies before the start or beyond the mesh, or if cancelled. */
static bool march_curve(const struct scene_curve *c, const struct system *system,
                        const struct sampling *s)
{
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES] = {0};
    struct step step = {.system = system, .t = system->t0, .y = y, .low = low, .work = c->work};
    size_t i;
    memcpy(y, system->start, (size_t)system->n * sizeof *y);
    if (!scene_curve_first(c, system, s, &i))
        return false;
    for (size_t k = 0; i < s->n; k++) {
        const double t_begin = step.t;
        if (k == c->points || !(c->mesh[k] > t_begin) || ((k & 63) == 0 && cancelled(c->cancel)))
            return false;
        step.h = c->mesh[k] - t_begin;
        if (method_step(c->method, &step) != STEP_OK)
            return false;
        step.t = c->mesh[k];
        scene_curve_inside(c, &step, s, t_begin, &i);
    }
    return true;
}

/* Computes the motion of a linear scene exactly, sample by sample. Returns false if a sample lies
 * before the start, or if cancelled. */
static bool follow_linear(const struct scene_curve *c, const struct system *system,
                          const struct sampling *s)
{
    double y[LIMIT_VARIABLES], t = system->t0;
    size_t i;
    memcpy(y, system->start, (size_t)system->n * sizeof *y);
    linear_motion_bind(c->linear, c->variation, s->derivative ? c->variation->directions : 0);
    if (!scene_curve_first(c, system, s, &i))
        return false;
    for (; i < s->n; i++) {
        if ((i & 4095) == 0 && cancelled(c->cancel))
            return false;
        t = linear_motion_advance(c->linear, t, s->t[i], y);
        put_sample(c, system, s, i, y);
    }
    return true;
}

/* Sets *scene to the curve's scene with these values of the free parameters. Returns false if one
 * is outside its range. */
static bool scene_at(const struct scene_curve *c, const double *parameter, struct scene *scene)
{
    struct error ignored;
    *scene = c->scene;
    for (int j = 0; j < c->frees; j++)
        if (!scene_set(scene, c->index[j], (struct measured){parameter[j], 0}, &ignored))
            return false;
    return true;
}

/* Computes value [n] at times t [n] and, unless NULL, derivative [n][parameters] of the scene with
 * these parameters. `context` is the struct scene_curve. Returns false if the scene refuses them,
 * if the motion fails, or if cancelled. */
bool scene_curve_evaluate(void *context, const double *parameter, const double *t, size_t n,
                          double *value, double *derivative)
{
    struct scene_curve *c = context;
    struct scene scene;
    struct error ignored;
    const struct sampling sampling = {t,     n,          c->offset ? parameter[c->frees] : 0,
                                      value, derivative, (size_t)(c->frees + c->offset)};
    if (!scene_at(c, parameter, &scene) ||
        !scene_bind_motion(&scene, &c->variation->base, &ignored) ||
        (derivative && !variation_bind(c->variation, &scene, c->index, c->frees)))
        return false;
    const struct system *system = derivative ? &c->variation->whole : &c->variation->base;
    const bool dry =
        c->variation->base.dry && c->variation->base.switches == 1 && c->variation->base.n == 2;
    bool (*follow)(const struct scene_curve *, const struct system *, const struct sampling *) =
        dry ? scene_dry_march : march_curve;
    if (c->linear)
        follow = follow_linear;
    if (!follow(c, system, &sampling))
        return false;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(value[i]))
            return false;
    return true;
}

void scene_curve_free(struct scene_curve *c)
{
    free(c->linear);
    free(c->mesh);
    free(c->work);
}

/* ---- the steps ---- */

/* Appends the end of a step to the mesh. Returns false if out of memory. */
static bool mesh_add(struct scene_curve *c, double t)
{
    if ((c->points & (c->points - 1)) == 0) { /* the memory doubles at powers of two */
        double *larger = realloc(c->mesh, (c->points ? 2 * c->points : 1) * sizeof *larger);
        if (!larger)
            return false;
        c->mesh = larger;
    }
    c->mesh[c->points++] = t;
    return true;
}

/* Result of choosing steps: done, the method failed, or out of memory. */
enum meshing { MESH_DONE, MESH_FAILED, MESH_MEMORY };

/* Chooses the mesh of steps up to the time `end` by an adaptive run of the named method with the
 * tolerance tol, at most `max` of them. Returns MESH_FAILED if these do not suffice. */
static enum meshing try_mesh(struct scene_curve *c, const struct system *system, const char *name,
                             double tol, size_t max, double end)
{
    double y[LIMIT_VARIABLES];
    struct step step = {.system = system, .t = system->t0, .y = y};
    struct controller controller = {.tol = tol};
    c->method = method_find(name);
    c->points = 0;
    free(c->work);
    c->work = calloc(method_work_size(c->method, system->n * (c->frees + 1)) + 1, sizeof *c->work);
    step.work = c->work;
    if (!c->work)
        return MESH_MEMORY;
    memcpy(y, system->start, (size_t)system->n * sizeof *y);
    while (step.t < end) {
        if (c->points == max || cancelled(c->cancel) ||
            method_adapt(c->method, &step, &controller, end) != STEP_OK)
            return MESH_FAILED;
        if (!mesh_add(c, step.t))
            return MESH_MEMORY;
    }
    return MESH_DONE;
}

/* Prepares the steps for evaluations near these parameters: exact ones for a linear scene; else
 * those of dop853, or of rodas5p for a stiff scene. Returns false with the error. */
bool scene_curve_mesh(struct scene_curve *c, const double *parameter, const struct series *series,
                      struct error *error)
{
    struct scene scene = c->scene;
    struct system system;
    const double end = series->t[series->n - 1];
    for (int j = 0; j < c->frees; j++)
        if (!scene_set(&scene, c->index[j], (struct measured){parameter[j], 0}, error))
            return false;
    if (!scene_bind_motion(&scene, &system, error))
        return false;
    free(c->linear);
    c->linear = system.linear && system.autonomous && 2 * system.n < LIMIT_VARIABLES
                    ? linear_motion_create(system.t0, series->t, series->n)
                    : NULL;
    if (c->linear) {
        c->method = method_find("exact");
        c->points = series->n;
        return true;
    }
    enum meshing meshing = try_mesh(c, &system, "dop853", c->tol, 20000 + 2 * series->n, end);
    if (meshing == MESH_FAILED)
        meshing = try_mesh(c, &system, "rodas5p", fmax(c->tol, TOLERANCE_STIFF), STEPS_MOST, end);
    if (meshing == MESH_DONE)
        return true;
    if (meshing == MESH_MEMORY)
        return error_memory(error);
    if (cancelled(c->cancel))
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    return error_set(error, ERROR_COMMAND,
                     "the scene cannot be integrated from %g to %g s with its present parameters",
                     system.t0, end);
}
