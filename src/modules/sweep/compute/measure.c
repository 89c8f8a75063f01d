/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names of the quantities that a sweep can vary and of those that it can measure. */
#include <hooke/base/catalog.h>
#include <hooke/scene/typed.h>
#include "modules/sweep/compute/worker.h"

#include <stdio.h>
#include <string.h>

/* ---- axes ---- */

/* Finds what `name` varies in the scene: dt, tol, a parameter, or a derived quantity that can be
 * set. Fills in target, index, quantity and name of the axis. Returns false if it varies
 * nothing. */
bool sweep_axis_find(const struct scene *scene, struct text name, struct sweep_axis *axis)
{
    const struct catalog *params = scene_params(scene), *derived = scene_derived(scene);
    const struct row *row;
    if (text_is(name, "dt") || text_is(name, "tol")) {
        const bool dt = text_is(name, "dt");
        axis->target = dt ? SWEEP_DT : SWEEP_TOL;
        axis->quantity = dt ? QUANTITY_TIME : QUANTITY_NUMBER;
    } else if ((row = catalog_find(params, name))) {
        const struct param_row *param = (const struct param_row *)(const void *)row;
        axis->target = SWEEP_PARAM;
        axis->index = (int)(param - (const struct param_row *)params->rows);
        axis->quantity = param->quantity;
    } else if ((row = catalog_find(derived, name)) &&
               ((const struct derived_row *)(const void *)row)->inverse) {
        axis->target = SWEEP_DERIVED;
        axis->index = (int)((const struct derived_row *)(const void *)row -
                            (const struct derived_row *)derived->rows);
        axis->quantity = ((const struct derived_row *)(const void *)row)->quantity;
    } else {
        return false;
    }
    snprintf(axis->name, sizeof axis->name, "%.*s", (int)name.len, name.data);
    return true;
}

/* Returns value number i of the axis, in SI units. */
double sweep_axis_value(const struct sweep_axis *axis, int i)
{
    if (i == 0 || axis->count < 2)
        return axis->begin;
    const double fraction = (double)i / (axis->count - 1);
    if (i == axis->count - 1)
        return axis->end;
    return axis->log ? axis->begin * pow(axis->end / axis->begin, fraction)
                     : axis->begin + (axis->end - axis->begin) * fraction;
}

/* ---- measures ---- */

static const struct row rows[] = {
    [SWEEP_AMPLITUDE] =
        {"amplitude", "",
         "half the peak-to-peak value of the first variable in the last third of the duration", "",
         NULL},
    [SWEEP_PERIOD] = {"period", "", "mean time between its maxima in the last third", "", NULL},
    [SWEEP_MEAN] = {"mean", "", "its mean over the last third", "", NULL},
    [SWEEP_MAX] = {"max", "", "its largest value in the whole run; max(z) for z, and so on", "",
                   NULL},
    [SWEEP_MIN] = {"min", "", "its smallest value in the whole run", "", NULL},
    [SWEEP_ERROR] = {"error", "",
                     "largest distance from the exact solution, divided by the amplitude", "",
                     NULL},
    [SWEEP_ENERGY_ERROR] = {"energy_error", "", "largest error of the energy balance", "",
                            "energy-error"},
    [SWEEP_STEPS] = {"steps", "", "steps taken", "", NULL},
    [SWEEP_EVALS] = {"evals", "", "force evaluations", "", NULL},
    [SWEEP_REACHED] = {"reached", "", "the time reached, or the time when it diverged", "", NULL},
    [SWEEP_ATTRACTOR] = {"attractor", "",
                         "the attractor: 0 equilibrium, 1 orbit, with a drive the number of its "
                         "periods, -1 does not repeat",
                         "", NULL},
};

const struct catalog sweep_measure_catalog = CATALOG("measure", rows);

/* Finds a quantity of a run that is evaluated at each row: a variable, a typed quantity or an
 * observable, in this order. Sets column and its index or observable in *measure. Returns false if
 * there is none of this name. */
static bool measured_column_find(const struct model *model, struct text name,
                                 struct sweep_measure *measure)
{
    measure->column = SWEEP_VARIABLE;
    for (measure->variable = 0; measure->variable < model->n; measure->variable++)
        if (text_is(name, model->variable[measure->variable].name))
            return true;
    measure->column = SWEEP_OBSERVED;
    for (measure->variable = 0; measure->variable < model_observed(model); measure->variable++)
        if (text_is(name, model_observed_variable(model, measure->variable).name))
            return true;
    measure->column = SWEEP_OBSERVABLE;
    measure->observable = observable_by_name(name);
    return measure->observable;
}

/* Sets the error for an unknown measure, with similar names as a hint. `column` means that name was
 * in the parentheses of a measure, as in max(z). Returns false. */
static bool refuse_unknown_measure(const struct model *model, struct text name, bool column,
                                   struct error *error)
{
    struct suggestion suggestion = {.wanted = name};
    for (size_t i = 0; i < COUNT_OF(rows) && !column; i++)
        suggestion_offer(&suggestion, rows[i].name);
    for (size_t i = 0; i < observable_catalog.count; i++)
        suggestion_offer(&suggestion, catalog_row(&observable_catalog, i)->name);
    for (int i = 0; i < model->n; i++)
        suggestion_offer(&suggestion, model->variable[i].name);
    for (int i = 0; i < model_observed(model); i++)
        suggestion_offer(&suggestion, model_observed_variable(model, i).name);
    error_at(error, name, "a sweep cannot measure '%.*s'", (int)(name.len < 64 ? name.len : 64),
             name.data);
    suggestion_hint(&suggestion, error);
    if (column)
        return error_hint(error, "the parentheses need a quantity of a run, such as y or energy");
    return error_hint(
        error,
        "possible are amplitude, period, mean, max, min (of z: max(z)), error, energy_error, "
        "steps, evals, reached, attractor, and quantities of a run such as y, energy ...");
}

/* Splits a name such as max(z) into the row of its kind and the name of the column. Returns false
 * if it is not of that form or the kind is not watched. */
static bool split_watched(struct text name, const struct row **row, struct text *column)
{
    const char *paren = memchr(name.data, '(', name.len);
    if (!paren || name.data[name.len - 1] != ')')
        return false;
    const struct text first = {name.data, (size_t)(paren - name.data)};
    *row = catalog_find(&sweep_measure_catalog, text_trim(first));
    if (!*row || *row - rows > SWEEP_MIN)
        return false;
    *column = text_trim((struct text){paren + 1, name.len - first.len - 2});
    return true;
}

/* Finds a measure by its name: one of the catalog, a variable, quantity or observable at the end of
 * the run, or a reduction of one of these, as in max(z). Fills in *measure. Returns false with an
 * error. */
bool sweep_measure_find(const struct model *model, struct text name, struct sweep_measure *measure,
                        struct error *error)
{
    const struct row *own = catalog_find(&sweep_measure_catalog, name);
    struct text column = name;
    *measure = (struct sweep_measure){.column = SWEEP_VARIABLE};
    if (own) {
        measure->kind = (enum sweep_kind)(own - rows);
        snprintf(measure->name, sizeof measure->name, "%s", own->name);
        return true;
    }
    const bool watched = split_watched(name, &own, &column);
    if (!measured_column_find(model, column, measure))
        return refuse_unknown_measure(model, column, watched, error);
    if (measure->column == SWEEP_OBSERVABLE && model->order != 2 &&
        measure->observable->needs & NEED_MECHANICS)
        return error_at(error, column, "%.*s needs a scene with positions and velocities",
                        (int)column.len, column.data);
    measure->kind = watched ? (enum sweep_kind)(own - rows) : measure->column;
    if (watched)
        snprintf(measure->name, sizeof measure->name, "%s(%.*s)", own->name, (int)column.len,
                 column.data);
    else
        snprintf(measure->name, sizeof measure->name, "%s",
                 measure->column == SWEEP_OBSERVABLE ? measure->observable->row.name : "");
    if (measure->name[0] == 0)
        snprintf(measure->name, sizeof measure->name, "%.*s", (int)column.len, column.data);
    return true;
}

/* Returns true if the measure is a function of state and time and can be taken at an event. */
bool sweep_at_section(const struct sweep_measure *measure)
{
    return measure->kind == SWEEP_VARIABLE || measure->kind == SWEEP_OBSERVED ||
           (measure->kind == SWEEP_OBSERVABLE &&
            !(measure->observable->needs &
              ~(unsigned)(NEED_MECHANICS | NEED_LINE | NEED_POWER | NEED_ENERGY)));
}

const char *sweep_measure_name(const struct sweep_measure *measure)
{
    if (measure->formula)
        return measure->formula->text;
    return measure->name[0] ? measure->name : rows[measure->kind].name;
}

/* Returns the physical quantity of the measure's values, from which their unit follows. */
enum quantity sweep_measure_quantity(const struct sweep_measure *measure, const struct model *model)
{
    const struct system system = {.model = model, .n = model->n, .order = model->order};
    if (measure->formula)
        return measure->formula->quantity;
    if (measure->kind == SWEEP_PERIOD || measure->kind == SWEEP_REACHED)
        return QUANTITY_TIME;
    if (!sweep_watches(measure) && measure->kind < SWEEP_VARIABLE)
        return QUANTITY_NUMBER;
    switch (measure->column) {
    case SWEEP_FORMULA:
        return measure->expression->quantity;
    case SWEEP_OBSERVED:
        return model_observed_variable(model, measure->variable).quantity;
    case SWEEP_OBSERVABLE:
        return observable_quantity(measure->observable, &system);
    default:
        return model->variable[measure->variable].quantity;
    }
}
