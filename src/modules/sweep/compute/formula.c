/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Evaluates expressions of a sweep: those of columns of a run, at each recorded row, and those of
 * the measures of a point. */
#include <hooke/base/catalog.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/typed.h>
#include "modules/sweep/compute/worker.h"

#include <stdlib.h>

/* Returns the value of a parameter or derived quantity by its slot. */
double sweep_scene_value(const struct scene *scene, int slot)
{
    if (slot < SWEEP_SLOT_DERIVED)
        return scene->value[slot - SWEEP_SLOT_PARAM];
    const struct row *row = catalog_row(scene_derived(scene), (size_t)(slot - SWEEP_SLOT_DERIVED));
    return ((const struct derived_row *)(const void *)row)->value(scene).value;
}

/* Values of an expression's slots: numbers from slot 0 on, then those of the scene. */
struct numbers {
    const double *value;
    const struct scene *scene;
};

/* Returns the value of a slot. */
static double load_number(const void *context, int slot)
{
    const struct numbers *numbers = context;
    return slot < SWEEP_SLOT_PARAM ? numbers->value[slot] : sweep_scene_value(numbers->scene, slot);
}

/* Fills result with the values of a slot of run_scope() at all recorded rows. Slots are numbered:
 * state variables, typed quantities, then observables. Returns false if an observable cannot be
 * computed. */
static bool slot_column(const struct run *run, int slot, double *result)
{
    const size_t n = trace_count(run->trace);
    const int observable = slot - run->system.n - model_observed(run->system.model);
    const struct moving moving = run_scope_moving(run, slot);
    struct error ignored = {0};
    if (moving.kind == MOVING_OTHER && observable >= 0)
        return run_column(run, observable_at((size_t)observable), result, &ignored);
    if (moving.kind == MOVING_OTHER)
        run_observed_column(run, slot - run->system.n, result);
    else if (moving.kind == MOVING_STATE)
        run_variable_column(run, moving.index, result);
    for (size_t i = 0; i < n && moving.kind == MOVING_TIME; i++)
        result[i] = trace_time(run->trace, i);
    return true;
}

/* Evaluates the expression at all recorded rows into result, with the scene's parameters. Returns
 * false if out of memory or if an observable cannot be computed. */
bool expression_column(const struct run *run, const struct sweep_expression *expression,
                       const struct scene *scene, double *result)
{
    const size_t n = trace_count(run->trace);
    double *column = calloc(n * (size_t)expression->columns + 1, sizeof *column);
    double value[SWEEP_COLUMNS] = {0};
    const struct numbers numbers = {value, scene};
    const struct expr_scope scope = {.context = &numbers, .load = load_number};
    bool ok = column;
    for (int c = 0; ok && c < expression->columns; c++)
        ok = slot_column(run, expression->column[c], column + (size_t)c * n);
    for (size_t i = 0; ok && i < n; i++) {
        for (int c = 0; c < expression->columns; c++)
            value[c] = column[(size_t)c * n + i];
        result[i] = expr_value(expression->expr, &scope);
    }
    free(column);
    return ok;
}

/* Returns the value of a slot of a formula: a measure, the root of a measure, or a value of the
 * scene. */
static double load_measure(const void *context, int slot)
{
    return slot >= SWEEP_MEASURES && slot < SWEEP_SLOT_PARAM
               ? sqrt(load_number(context, slot - SWEEP_MEASURES))
               : load_number(context, slot);
}

/* Computes the shown columns of point i from its measures in worker->part: formulas, or copies of
 * one measure (at request->place). Does nothing if measures are shown without formulas. */
void sweep_combine(struct sweep_worker *worker, int64_t i)
{
    const struct sweep_request *request = worker->job->request;
    if (request->columns == 0)
        return;
    const struct numbers numbers = {worker->part, &worker->scene};
    const struct expr_scope scope = {.context = &numbers, .load = load_measure};
    struct error ignored;
    double *result = worker->job->sweep->value + i * worker->job->sweep->measures;
    sweep_point(request, worker->job->sweep, i, &worker->scene, &worker->settings, &ignored);
    for (int c = 0; c < request->columns; c++)
        result[c] = request->shown[c].formula ? expr_value(request->shown[c].formula->expr, &scope)
                                              : worker->part[request->place[c]];
}
