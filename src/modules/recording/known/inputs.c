/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The values with which a derived number was computed (struct inputs in known.h). */
#include "modules/recording/known/known.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Relative change of a parameter that shows whether the motion depends on it. */
#define PARAM_NUDGE_RELATIVE 1e-3

/* Adds a value that enters a result: its relative uncertainty is combined with the others; a value
 * without one is listed as exact under its name, once. */
void inputs_use(struct inputs *inputs, const char *name, struct measured value)
{
    if (!(fabs(value.value) > 0))
        return;
    if (value.uncertainty > 0) {
        inputs->relative = hypot(inputs->relative, value.uncertainty / value.value);
        return;
    }
    for (int i = 0; i < inputs->exacts; i++)
        if (strcmp(inputs->exact[i], name) == 0)
            return;
    if (inputs->exacts < INPUTS_MAX)
        inputs->exact[inputs->exacts++] = name;
}

/* Adds a parameter of the scene to the inputs. */
static void use_param(struct inputs *inputs, const struct scene *scene, int index)
{
    inputs_use(inputs, param_at(scene, index)->row.name,
               (struct measured){scene->value[index], scene->uncertainty[index]});
}

void inputs_use_params(struct inputs *inputs, const struct scene *scene, const char *names)
{
    struct text rest = text_of(names), name;
    while (text_split(&rest, ' ', &name)) {
        const int index = scene_param_at(scene, name);
        if (index >= 0)
            use_param(inputs, scene, index);
    }
}

/* Sets motion to the start and to the derivatives of all variables at two states, and *n to the
 * number of variables. Returns false if the scene has no motion. */
static bool sample_motion(const struct scene *scene, double motion[3 * LIMIT_VARIABLES], int *n)
{
    struct system system;
    struct error ignored;
    double y[LIMIT_VARIABLES];
    if (!scene_bind_motion(scene, &system, &ignored))
        return false;
    *n = system.n;
    memcpy(motion, system.start, (size_t)system.n * sizeof *motion);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < system.n; i++)
            y[i] = (k ? -0.3 : 0.7) * (i + 1) * system.scale[i];
        system_derivative(&system, system.t0 + 0.1 * k, y, motion + (k + 1) * system.n);
    }
    return true;
}

/* Adds to the inputs those parameters of the scene that influence its motion, except the fitted
 * ones (is_free): each is changed by PARAM_NUDGE_RELATIVE, and added if the motion changes. */
void inputs_use_motion(struct inputs *inputs, const struct scene *scene, const bool *is_free)
{
    double original[3 * LIMIT_VARIABLES], changed[3 * LIMIT_VARIABLES];
    int n, same;
    if (!sample_motion(scene, original, &n))
        return;
    for (int i = 0; i < (int)scene_params(scene)->count; i++) {
        struct scene other = *scene;
        struct error ignored;
        const struct measured moved = {scene->value[i] * (1 + PARAM_NUDGE_RELATIVE), 0};
        if (is_free[i] || scene->value[i] == 0 || !scene_set(&other, i, moved, &ignored) ||
            !sample_motion(&other, changed, &same) || same != n)
            continue;
        bool differs = false;
        for (int k = 0; k < 3 * n; k++)
            differs = differs || fabs(changed[k] - original[k]) > 1e-9 * fabs(original[k]);
        if (differs)
            use_param(inputs, scene, i);
    }
}

/* The relative uncertainty of the inputs adds in quadrature to that of the value. */
struct measured inputs_widen(const struct inputs *inputs, struct measured value)
{
    value.uncertainty = hypot(value.uncertainty, value.value * inputs->relative);
    return value;
}

void inputs_put(const struct inputs *inputs, struct buffer *text)
{
    const int n = inputs->exacts;
    for (int i = 0; i < n; i++) {
        const char *separator = i + 1 < n ? ", " : " and ";
        buffer_format(text, "%s%s", i > 0 ? separator : "\n  (", inputs->exact[i]);
    }
    if (n > 0)
        buffer_format(text, " %s taken as exact; '%s = VALUE +- UNCERTAINTY' sets an uncertainty)",
                      n > 1 ? "are" : "is", inputs->exact[0]);
}

void inputs_reply(const struct inputs *inputs, struct reply *reply)
{
    reply_array(reply, "exact");
    for (int i = 0; i < inputs->exacts; i++)
        reply_string(reply, NULL, inputs->exact[i]);
    reply_close(reply);
}

void inputs_keep(const struct inputs *inputs, struct exact_names *names)
{
    memset(names, 0, sizeof *names);
    for (int i = 0; i < inputs->exacts && i < EXACT_NAMES; i++)
        snprintf(names->name[i], sizeof names->name[i], "%s", inputs->exact[i]);
}

/* Enters each name with a dummy value of uncertainty 0, which counts as exact. */
void inputs_recall(struct inputs *inputs, const struct exact_names *names)
{
    for (int i = 0; i < EXACT_NAMES && names->name[i][0]; i++)
        inputs_use(inputs, names->name[i], (struct measured){1, 0});
}
