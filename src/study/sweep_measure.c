/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a sweep can vary and what it can measure. */
#include "sweep.h"

#include <stdio.h>
#include <string.h>

/* ---- axes ---- */

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
        axis->place = (int)(param - (const struct param_row *)params->rows);
        axis->quantity = param->quantity;
    } else if ((row = catalog_find(derived, name)) && ((const struct derived_row *)(const void *)row)->inverse) {
        axis->target = SWEEP_DERIVED;
        axis->place = (int)((const struct derived_row *)(const void *)row - (const struct derived_row *)derived->rows);
        axis->quantity = ((const struct derived_row *)(const void *)row)->quantity;
    } else {
        return false;
    }
    snprintf(axis->name, sizeof axis->name, "%.*s", (int)name.len, name.at);
    return true;
}

double sweep_axis_value(const struct sweep_axis *axis, int i)
{
    if (i == 0 || axis->count < 2)
        return axis->from;
    const double share = (double)i / (axis->count - 1);
    if (i == axis->count - 1)
        return axis->to;
    return axis->log ? axis->from * pow(axis->to / axis->from, share) : axis->from + (axis->to - axis->from) * share;
}

/* ---- measures ---- */

static const struct row rows[] = {
    [SWEEP_AMPLITUDE] = {"amplitude", "", "half the swing of the first variable in the last third of the duration", "",
                         NULL},
    [SWEEP_PERIOD] = {"period", "", "mean time between its maxima there", "", NULL},
    [SWEEP_MAX] = {"max", "", "its largest value from the start on", "", NULL},
    [SWEEP_ERROR] = {"error", "", "largest distance from the exact solution, over the amplitude", "", NULL},
    [SWEEP_ENERGY_ERROR] = {"energy_error", "", "largest error of the energy balance", "", "energy-error"},
    [SWEEP_STEPS] = {"steps", "", "steps taken", "", NULL},
    [SWEEP_EVALS] = {"evals", "", "force evaluations", "", NULL},
    [SWEEP_REACHED] = {"reached", "", "the time reached: of what diverges, when it did", "", NULL},
};

const struct catalog sweep_measure_catalog = CATALOG("measure", rows);

bool sweep_measure_find(const struct model *model, struct text name, struct sweep_measure *measure,
                        struct error *error)
{
    const struct row *own = catalog_find(&sweep_measure_catalog, name);
    *measure = (struct sweep_measure){.kind = SWEEP_VARIABLE};
    if (own) {
        measure->kind = (enum sweep_kind)(own - rows);
        return true;
    }
    for (int i = 0; i < model->n; i++)
        if (text_is(name, model->variable[i].name)) {
            measure->variable = i;
            return true;
        }
    for (int i = 0; i < model_observed(model); i++) {
        const struct variable quantity = model_observed_variable(model, i);
        if (text_is(name, quantity.name)) {
            *measure = (struct sweep_measure){.kind = SWEEP_OBSERVED, .variable = i};
            memcpy(measure->observed, quantity.name, sizeof quantity.name);
            return true;
        }
    }
    measure->observable = (const struct observable *)(const void *)catalog_find(&observable_catalog, name);
    measure->kind = SWEEP_OBSERVABLE;
    if (measure->observable && (model->order == 2 || !(measure->observable->needs & NEED_MECHANICS)))
        return true;
    if (measure->observable)
        return error_at(error, name, "%.*s needs a scene with positions and velocities", (int)name.len, name.at);
    struct suggestion near = {.wanted = name};
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        suggestion_offer(&near, rows[i].name);
    for (size_t i = 0; i < observable_catalog.count; i++)
        suggestion_offer(&near, catalog_row(&observable_catalog, i)->name);
    for (int i = 0; i < model->n; i++)
        suggestion_offer(&near, model->variable[i].name);
    for (int i = 0; i < model_observed(model); i++)
        suggestion_offer(&near, model_observed_variable(model, i).name);
    error_at(error, name, "'%.*s' is nothing that a sweep measures", (int)(name.len < 64 ? name.len : 64), name.at);
    suggestion_hint(&near, error);
    return error_hint(error, "measures are amplitude, period, max, error, energy_error, steps, evals, reached, and what "
                             "'print' knows of a run: y, energy ...");
}

const char *sweep_measure_name(const struct sweep_measure *measure, const struct model *model)
{
    return measure->kind == SWEEP_VARIABLE     ? model->variable[measure->variable].name
           : measure->kind == SWEEP_OBSERVED   ? measure->observed
           : measure->kind == SWEEP_OBSERVABLE ? measure->observable->row.name
                                               : rows[measure->kind].name;
}

enum quantity sweep_measure_quantity(const struct sweep_measure *measure, const struct model *model)
{
    const struct system system = {.model = model, .n = model->n, .order = model->order};
    switch (measure->kind) {
    case SWEEP_AMPLITUDE:
    case SWEEP_MAX:
        return model->variable[0].quantity;
    case SWEEP_PERIOD:
    case SWEEP_REACHED:
        return QUANTITY_TIME;
    case SWEEP_VARIABLE:
        return model->variable[measure->variable].quantity;
    case SWEEP_OBSERVED:
        return model_observed_variable(model, measure->variable).quantity;
    case SWEEP_OBSERVABLE:
        return observable_quantity(measure->observable, &system);
    default:
        return QUANTITY_NUMBER;
    }
}

/* ---- watching ---- */

void watch_begin(struct watch *watch, double y)
{
    *watch = (struct watch){.top = y};
}

void watch_open(struct watch *watch, double y)
{
    watch->open = true;
    watch->low = watch->high = y;
}

/* Hairer, Norsett, Wanner 1993, eq. II.6.7 */
static double between(double h, double y0, double v0, double y1, double v1, double theta)
{
    const double rise = y1 - y0, rest = 1 - theta;
    return rest * y0 + theta * y1 + theta * rest * ((1 - 2 * theta) * -rise + rest * h * v0 - theta * h * v1);
}

void watch_turn(struct watch *watch, double t0, double y0, double v0, double t1, double y1, double v1)
{
    if (v0 == v1) /* both 0 */
        return;
    const double theta = v0 / (v0 - v1), h = t1 - t0, y = between(h, y0, v0, y1, v1, theta);
    if (signbit(v0)) {
        watch->low = y < watch->low ? y : watch->low;
        return;
    }
    watch->top = y > watch->top ? y : watch->top;
    watch->high = y > watch->high ? y : watch->high;
    if (watch->open) {
        watch->last = t0 + theta * h;
        if (watch->maxima++ == 0)
            watch->first = watch->last;
    }
}

void watch_end(struct watch *watch, double y)
{
    watch->top = y > watch->top ? y : watch->top;
    watch->low = y < watch->low ? y : watch->low;
    watch->high = y > watch->high ? y : watch->high;
}
