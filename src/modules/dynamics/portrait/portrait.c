/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes a phase portrait (portrait_make): nullclines, equilibria, separatrices, lines of equal
 * energy. */
#include "modules/dynamics/orbits/forms.h"
#include "modules/dynamics/portrait/portrait.h"

#include <hooke/scene/formula.h>
#include <hooke/scene/typed.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ENERGY_LEVELS 5 /* number of lines of equal energy */

/* Appends a point; doubles the memory of both coordinates when it is full. Returns false if out of
 * memory. */
bool polyline_put(struct polyline *line, double x, double y)
{
    if (line->n == line->capacity) {
        const size_t capacity = line->capacity > 0 ? 2 * line->capacity : 256;
        double *x_more = realloc(line->x, capacity * sizeof *x_more);
        if (x_more)
            line->x = x_more;
        double *y_more = x_more ? realloc(line->y, capacity * sizeof *y_more) : NULL;
        if (!y_more)
            return false;
        line->y = y_more;
        line->capacity = capacity;
    }
    line->x[line->n] = x;
    line->y[line->n++] = y;
    return true;
}

bool polyline_gap(struct polyline *line)
{
    return polyline_put(line, NAN, NAN);
}

/* ---- functions whose zeros are lines ---- */

/* A function on the plane: a rate, or the energy less a level. */
struct plane_value {
    const struct portrait_work *work;
    int variable; /* variable of the rate, or -1 for the energy */
    double level; /* energy level */
};

/* Sets the state with coordinates (x, y) in the plane; other variables have the values of the
 * request. */
static void plane_state(const struct portrait_work *work, double x, double y, double *state)
{
    memcpy(state, work->request->state, (size_t)work->field.n * sizeof *state);
    state[work->request->variable[0]] = x;
    state[work->request->variable[1]] = y;
}

/* Returns the function at (x, y); `context` is a struct plane_value. */
static double plane_value(const void *context, double x, double y)
{
    const struct plane_value *v = context;
    const struct system *system = &v->work->field.system;
    double state[LIMIT_VARIABLES], rate[LIMIT_VARIABLES];
    plane_state(v->work, x, y, state);
    v->work->portrait->evals++;
    if (v->variable < 0)
        return system_kinetic(system, state) + system_potential(system, state) - v->level;
    system_derivative(system, v->work->request->t, state, rate);
    return rate[v->variable];
}

/* Returns true if the bounds of the rate of a variable (context is a struct plane_value) contain 0
 * on the box {x, y} by {low, high} of the plane; other variables have the values of the plane. */
static bool may_be_zero(const void *context, const double box[2][2])
{
    const struct plane_value *v = context;
    double state[LIMIT_VARIABLES];
    struct interval region[LIMIT_VARIABLES], rate[LIMIT_VARIABLES];
    plane_state(v->work, 0, 0, state);
    for (int i = 0; i < v->work->field.n; i++)
        region[i] = (struct interval){state[i], state[i]};
    for (int k = 0; k < 2; k++)
        region[v->work->request->variable[k]] = (struct interval){box[k][0], box[k][1]};
    system_bounds(v->work->bounded, region, rate, NULL);
    return !(rate[v->variable].lo > 0 || rate[v->variable].hi < 0);
}

/* Appends the lines on which the function is 0. Returns false if out of memory. */
static bool add_level_lines(const struct plane_value *value, struct polyline *line)
{
    const struct portrait_work *work = value->work;
    const bool bounds = value->variable >= 0 && work->bounded && work->field.system.autonomous;
    const struct level_request request = {.value = plane_value,
                                          .may_be_zero = bounds ? may_be_zero : NULL,
                                          .context = value,
                                          .box = work->request->box,
                                          .cancel = work->request->cancel};
    return level_lines(&request, line);
}

/* Appends ENERGY_LEVELS lines of equal energy between the lowest energy and the highest one of 9 x
 * 9 sampled states and all equilibria, at values that grow as squares. Returns false if out of
 * memory. */
static bool add_energy_lines(struct portrait_work *work, struct polyline *line)
{
    struct plane_value value = {.work = work, .variable = -1};
    const double(*box)[2] = work->request->box;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i <= 8; i++)
        for (int j = 0; j <= 8; j++) {
            const double e = plane_value(&value, box[0][0] + i * (box[0][1] - box[0][0]) / 8,
                                         box[1][0] + j * (box[1][1] - box[1][0]) / 8);
            low = isfinite(e) ? fmin(low, e) : low;
            high = isfinite(e) ? fmax(high, e) : high;
        }
    for (int k = 0; k < work->portrait->found.count; k++) {
        const double *state = work->portrait->found.solution[k].state;
        low = fmin(low, plane_value(&value, state[work->request->variable[0]],
                                    state[work->request->variable[1]]));
    }
    bool fine = true;
    for (int k = 1; k <= ENERGY_LEVELS && fine && high > low; k++) {
        /* amplitudes grow evenly where the energy goes as their square */
        value.level = low + (high - low) * (k - 0.5) * (k - 0.5) / (ENERGY_LEVELS * ENERGY_LEVELS);
        fine = add_level_lines(&value, line);
    }
    return fine;
}

/* ---- the portrait ---- */

/* Finds the equilibria in the box of the request. Returns false with *error. */
static bool find_equilibria(struct portrait_work *work, struct error *error)
{
    const struct portrait_request *request = work->request;
    struct equilibria_request wanted = {.scene = request->scene, .cancel = request->cancel};
    memcpy(wanted.box, request->all, sizeof wanted.box);
    for (int k = 0; k < 2; k++)
        memcpy(wanted.box[request->variable[k]], request->box[k], sizeof request->box[k]);
    return equilibria_find(&wanted, &work->portrait->found, error);
}

/* Computes all lines: nullclines, separatrices (of scenes that do not depend on time) and, if
 * requested and the plane is all of the state, lines of equal energy. Returns false if out of
 * memory. */
static bool portrait_draw(struct portrait_work *work)
{
    const struct portrait_request *request = work->request;
    struct polyline *line = work->portrait->line;
    bool fine = true;
    for (int k = 0; k < 2 && fine; k++) {
        const struct plane_value value = {.work = work, .variable = request->variable[k]};
        fine = add_level_lines(&value, &line[PORTRAIT_NULLCLINE + k]);
    }
    if (fine && work->field.system.autonomous)
        fine = portrait_separatrices(work);
    if (fine && request->energy && work->field.n == 2)
        fine = add_energy_lines(work, &line[PORTRAIT_ENERGY]);
    work->portrait->cancelled = cancelled(request->cancel);
    return fine;
}

/* Computes *portrait in four stages: binds the scene (also its form with bounds of the rates, with
 * which the search can prove that it found all equilibria, if there is one); binds its energy if
 * lines of equal energy are requested; finds the equilibria; computes all lines. Returns false with
 * an error; *portrait is then empty. */
bool portrait_make(const struct portrait_request *request, struct portrait *portrait,
                   struct error *error)
{
    const int64_t start_time = clock_ns();
    struct portrait_work work = {.request = request, .portrait = portrait};
    struct typed_models *models = NULL;
    struct system bounded, with_energy;
    struct error ignored;
    *portrait = (struct portrait){.cancelled = false};
    bool fine = field_init(&work.field, request->scene, NULL, 0, error);
    work.field.cancel = request->cancel;
    if (fine && scene_with_bounds(request->scene, &work.field.system, &models, &bounded, &ignored))
        work.bounded = &bounded;
    if (fine && request->energy && scene_bind(request->scene, &with_energy, &ignored))
        work.field.system = with_energy;
    if (fine && !find_equilibria(&work, &ignored)) /* a portrait without them is still useful */
        portrait->found = (struct equilibria){.count = 0};
    if (fine && !portrait_draw(&work))
        fine = error_memory(error);
    portrait->evals += work.field.evals;
    portrait->seconds = clock_seconds(start_time);
    field_free(&work.field);
    typed_destroy(models);
    if (!fine)
        portrait_free(portrait);
    return fine;
}

void portrait_free(struct portrait *portrait)
{
    for (int i = 0; i < PORTRAIT_LINES; i++) {
        free(portrait->line[i].x);
        free(portrait->line[i].y);
    }
    free(portrait->separatrix);
    equilibria_free(&portrait->found);
    *portrait = (struct portrait){.cancelled = false};
}
