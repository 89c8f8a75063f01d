/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The parameters of the oscillator, and functions of the scene that hold for the parameters of
 * every model: finding, setting and checking them. */
#include <hooke/base/catalog.h>
#include <hooke/base/number.h>
#include <assert.h>

#include "scene/model/params.h"

static const struct param_row rows[] = {
#define PARAM PARAM_ROW
#include "scene/model/terms.def"
};

const struct catalog param_catalog = CATALOG("parameter", rows);

/* Returns the index of the parameter in its table, or -1 if there is none of that name. */
static int parameter_index(const struct catalog *catalog, struct text name)
{
    const struct row *found = catalog_find(catalog, name);
    return found ? catalog_index(catalog, found) : -1;
}

int param_index(const char *name)
{
    int index = parameter_index(&param_catalog, text_of(name));
    assert(index >= 0);
    return index;
}

const struct catalog *scene_params(const struct scene *scene)
{
    return scene->model->params;
}

const struct catalog *scene_derived(const struct scene *scene)
{
    return scene->model->derived;
}

int scene_param(const struct scene *scene, const char *name)
{
    return parameter_index(scene->model->params, text_of(name));
}

const struct param_row *param_at(const struct scene *scene, int index)
{
    assert(index >= 0 && (size_t)index < scene->model->params->count);
    return (const struct param_row *)(const void *)catalog_row(scene->model->params, (size_t)index);
}

int scene_param_at(const struct scene *scene, struct text name)
{
    return parameter_index(scene->model->params, name);
}

double param_value(const struct scene *scene, const char *name)
{
    const int index = scene_param(scene, name);
    return index >= 0 ? scene->value[index] : NAN;
}

bool param_chosen(const struct scene *scene, const char *name)
{
    const int index = scene_param(scene, name);
    return index >= 0 && scene->chosen[index];
}

bool is_oscillator(const struct scene *scene)
{
    return typed_base(scene->model) == &oscillator_model;
}

bool is_pendulum(const struct scene *scene)
{
    return typed_base(scene->model) == &pendulum_model;
}

/* Returns the value of a parameter in the scene's preset: the one that it sets, or the default. */
static double preset_value(const struct scene *scene, int param)
{
    const struct preset *preset = scene->preset;
    for (size_t i = 0; i < COUNT_OF(preset->value) && preset->value[i].param; i++)
        if (scene_param(scene, preset->value[i].param) == param)
            return preset->value[i].value;
    return param_at(scene, param)->initial;
}

void scene_init(struct scene *scene, const struct preset *preset)
{
    *scene = (struct scene){.preset = preset ? preset : preset_at(0)};
    scene->model = scene->preset->model ? scene->preset->model : &oscillator_model;
    for (size_t i = 0; i < scene->model->params->count; i++)
        scene_unset(scene, (int)i);
}

void scene_set_atol(struct scene *scene, int variable, double atol)
{
    scene->atol[variable] = atol;
}

void scene_unset(struct scene *scene, int param)
{
    scene->value[param] = preset_value(scene, param);
    scene->uncertainty[param] = 0;
    scene->chosen[param] = false;
}

/* Returns true if the value is finite and in the parameter's range; otherwise sets an error. */
static bool in_range(const struct param_row *row, double value, struct error *error)
{
    if (isfinite(value) && (row->min_excluded ? value > row->min : value >= row->min))
        return true;
    char got[REAL_TEXT_SIZE], min[REAL_TEXT_SIZE];
    const char *unit = row->row.unit;
    real_format(value, got);
    if (!isfinite(value))
        return error_set(error, ERROR_COMMAND, "%s must be a finite number (got %s)", row->row.name,
                         got);
    real_format(row->min, min);
    const char *const relation = row->min_excluded ? ">" : ">=";
    return error_set(error, ERROR_COMMAND, "%s must be %s %s (got %s%s%s)", row->row.name, relation,
                     min, got, *unit ? " " : "", unit);
}

/* Returns true if k/m and m are usable numbers; otherwise sets an error. */
bool params_coherent(const double *param, struct error *error)
{
    if (isfinite(param[P_k] / param[P_m]) && param[P_m] >= DBL_MIN)
        return true;
    char k[REAL_TEXT_SIZE], m[REAL_TEXT_SIZE];
    real_format(param[P_k], k);
    real_format(param[P_m], m);
    return error_set(error, ERROR_COMMAND, "k/m overflows: k = %s N/m, m = %s kg", k, m);
}

/* Checks the value by itself, then together with the other parameters, and sets it. */
bool scene_set(struct scene *scene, int param, struct measured value, struct error *error)
{
    if (!in_range(param_at(scene, param), value.value, error))
        return false;
    if (value.uncertainty < 0 || isinf(value.uncertainty))
        return error_set(error, ERROR_COMMAND, "the uncertainty of %s must be a finite number >= 0",
                         param_at(scene, param)->row.name);
    double previous_value = scene->value[param];
    scene->value[param] = value.value;
    if (scene->model->coherent && !scene->model->coherent(scene->value, error)) {
        scene->value[param] = previous_value;
        return false;
    }
    scene->uncertainty[param] = isnan(value.uncertainty) ? 0 : value.uncertainty;
    scene->chosen[param] = true;
    return true;
}
