/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns that a run can show over its rows (`export`, `plot`): state variables, observations of a
 * typed scene, and observables, chosen by name. */
#include <hooke/run.h>
#include <hooke/base/unit.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <stdio.h>
#include <string.h>

static bool variables_alike(struct variable a, struct variable b)
{
    return strcmp(a.name, b.name) == 0 && a.quantity == b.quantity;
}

/* Returns true if both models have the same variables and observations in the same order. */
bool models_alike(const struct model *a, const struct model *b)
{
    bool alike = a == b || (a->typed && b->typed && a->order == b->order && a->n == b->n &&
                            model_observed(a) == model_observed(b));
    for (int i = 0; a != b && alike && i < a->n; i++)
        alike = variables_alike(a->variable[i], b->variable[i]);
    for (int i = 0; a != b && alike && i < model_observed(a); i++)
        alike = variables_alike(model_observed_variable(a, i), model_observed_variable(b, i));
    return alike;
}

/* Finds a column of a run by name: a state variable (numbered from 0), an observation (from
 * model->n on) or an observable. Returns false with the error set. */
bool chosen_find(const struct model *model, struct text name, struct chosen_column *column,
                 struct error *error)
{
    const int variable = model_variable(model, name), observed = model_observation(model, name);
    *column = (struct chosen_column){NULL, variable >= 0 ? variable : model->n + observed};
    if (variable >= 0 || observed >= 0)
        return true;
    column->observable = model_observable(model, name);
    column->variable = -1;
    if (column->observable)
        return true;
    error_at(error, name, "this run has no state variable '%.*s'", (int)name.len, name.data);
    struct buffer own = {0};
    for (int v = 0; v < model->n; v++)
        buffer_format(&own, "%s%s", v ? ", " : "", model->variable[v].name);
    for (int v = 0; v < model_observed(model); v++)
        buffer_format(&own, ", %s", model_observed_variable(model, v).name);
    error_hint(error, "it has %s", buffer_view(&own));
    buffer_free(&own);
    return false;
}

/* Returns name and quantity of the column. */
struct variable chosen_variable(const struct system *system, const struct chosen_column *column)
{
    const struct model *model = system->model;
    if (!column->observable)
        return column->variable < model->n
                   ? model->variable[column->variable]
                   : model_observed_variable(model, column->variable - model->n);
    struct variable variable = {.quantity = model_quantity(model, column->observable)};
    snprintf(variable.name, sizeof variable.name, "%s", column->observable->row.name);
    return variable;
}

const char *chosen_unit(const struct system *system, const struct chosen_column *column)
{
    return column->observable ? observable_unit(column->observable, system)
                              : quantity_unit(chosen_variable(system, column).quantity);
}

/* Computes the column over all recorded rows. Returns false with the error set. */
bool chosen_values(const struct run *run, const struct chosen_column *column, double *values,
                   struct error *error)
{
    if (column->observable)
        return run_column(run, column->observable, values, error);
    if (column->variable < run->system.n)
        run_variable_column(run, column->variable, values);
    else
        run_observed_column(run, column->variable - run->system.n, values);
    return true;
}
