/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses which parameters a fit of a scene leaves free by default. */
#include "modules/recording/scene/scene_fit.h"

#include <hooke/base/catalog.h>
#include "modules/solving/compute/variation.h"

#include <string.h>

/* Parameters of oscillators and pendulums that a recording determines. The others of these models
 * (m, g, area …) have the same effects as these. */
static const struct {
    /* The parameter is free only if `required` is not 0 and `excluded` is 0; NULL means any value.
     */
    const char *name, *required, *excluded;
} usual[] = {{"k", NULL, NULL},     {"gamma", NULL, "mu"}, {"length", NULL, NULL},
             {"C", "C", NULL},      {"k3", "k3", NULL},    {"mu", "mu", NULL},
             {"width", "mu", NULL}, {"F0", "F0", NULL},    {"phase", "F0", NULL}};

/* Returns a parameter's value, or 0 if the scene does not have it. */
static double value_of(const struct scene *scene, const char *name)
{
    const int index = scene_param(scene, name);
    return index >= 0 ? scene->value[index] : 0;
}

/* Returns true if a fit leaves the parameter free by default; in models without a mass, all but
 * t0. */
static bool is_usual(const struct scene *scene, const char *name)
{
    if (scene_param(scene, "m") < 0)
        return strcmp(name, "t0") != 0;
    for (size_t i = 0; i < COUNT_OF(usual); i++)
        if (strcmp(usual[i].name, name) == 0)
            return (!usual[i].required || value_of(scene, usual[i].required) != 0) &&
                   (!usual[i].excluded || value_of(scene, usual[i].excluded) == 0);
    return false;
}

/* Chooses the parameters that a fit of the scene frees if none are named: those that change the
 * motion or its start. Sets index[] and returns their number. Those that the user has set exactly
 * are listed in fixed[] (*fixed_count) instead. */
int scene_fit_usual(const struct scene *scene, int *index, int *fixed, int *fixed_count)
{
    int count = 0;
    *fixed_count = 0;
    for (int i = 0; i < (int)scene_params(scene)->count && count < CURVE_PARAMETERS - 1; i++) {
        const char *name = catalog_row(scene_params(scene), (size_t)i)->name;
        struct parameter_change d;
        if (strcmp(name, "t0") == 0 || !direction_find(scene, i, &d) ||
            (d.changes == 0 && !d.starts))
            continue;
        if (d.changes > 0 && !is_usual(scene, name))
            continue;
        if (d.changes > 0 && scene->chosen[i] && scene->uncertainty[i] == 0)
            fixed[(*fixed_count)++] = i;
        else
            index[count++] = i;
    }
    return count;
}
