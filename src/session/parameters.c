/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parameters, derived quantities and variables by name; they depend on the model of the scene.
 * Typed scenes as commands. */
#include <hooke/run.h>
#include <hooke/result.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <string.h>
#include <stdlib.h>

/* Appends the typed lines of the scene, each behind the prefix. */
void scene_lines(const struct scene *scene, const char *prefix, struct buffer *text)
{
    for (int i = 0; i < typed_lines(scene->model); i++) {
        buffer_put(text, text_of(prefix));
        typed_describe(typed_line(scene->model, i), text);
        buffer_char(text, '\n');
    }
}

/* Appends the typed lines of the scene as commands, by kind, so that each name is defined before it
 * is used. */
void scene_script(const struct scene *scene, const char *end, struct buffer *text)
{
    static const enum typed_kind order[] = {TYPED_VAR,      TYPED_PARAM, TYPED_OBSERVE,
                                            TYPED_EQUATION, TYPED_FORCE, TYPED_POTENTIAL};
    for (size_t kind = 0; kind < COUNT_OF(order); kind++)
        for (int i = 0; i < typed_lines(scene->model); i++) {
            if (typed_line(scene->model, i)->kind != order[kind])
                continue;
            typed_describe(typed_line(scene->model, i), text);
            buffer_put(text, text_of(end));
        }
}

/* Things that change when a parameter changes: nothing, the start only, or the equations. */
enum effect { EFFECT_NONE, EFFECT_START, EFFECT_FORCE };

/* Returns what changes if the parameter changes in the present scene (the frequency of a drive
 * without amplitude changes nothing), by comparing the systems bound with both values. a and b are
 * scratch memory. */
static enum effect effect_between(const struct scene *scene, int index, struct system *a,
                                  struct system *b)
{
    struct scene other = *scene;
    const double value = scene->value[index];
    other.value[index] = value == 0 ? 0.125 : 0.875 * value; /* towards 0: within bounds */
    if (!scene_bind_rates(scene, a) || !scene_bind_rates(&other, b) || a->terms != b->terms ||
        a->mass != b->mass)
        return EFFECT_FORCE;
    for (int i = 0; i < a->terms; i++)
        if (!bound_term_equal(&a->term[i], &b->term[i]))
            return EFFECT_FORCE;
    const bool moved =
        a->t0 != b->t0 || memcmp(a->start, b->start, (size_t)a->n * sizeof *a->start) != 0;
    return moved ? EFFECT_START : EFFECT_NONE;
}

/* Returns what a change of the parameter changes; EFFECT_FORCE if out of memory. */
static enum effect effect_of(const struct scene *scene, int index)
{
    struct system *both = malloc(2 * sizeof *both);
    const enum effect effect =
        both ? effect_between(scene, index, &both[0], &both[1]) : EFFECT_FORCE;
    free(both);
    return effect;
}

bool param_is_start(const struct scene *scene, int index)
{
    return effect_of(scene, index) == EFFECT_START;
}

/* Returns true if a short description of the scene includes the parameter. */
bool param_matters(const struct scene *scene, int index)
{
    const struct param_row *row = param_at(scene, index);
    const struct text name = text_of(row->row.name);
    const bool set = scene->chosen[index] || scene->value[index] != row->initial;
    if (is_oscillator(scene))
        return text_is(name, "m") || text_is(name, "k") || (set && scene->value[index] != 0);
    return scene->value[index] != 0 && !text_is(name, "t0") &&
           effect_of(scene, index) != EFFECT_NONE;
}

int model_variable(const struct model *model, struct text name)
{
    return model_state(model, name);
}

/* Returns the index of an observation of a typed model, or -1. */
int model_observation(const struct model *model, struct text name)
{
    for (int i = 0; i < model_observed(model); i++)
        if (text_is(name, model_observed_variable(model, i).name))
            return i;
    return -1;
}

/* Returns true if name is a parameter, derived quantity or variable of the model. */
static bool model_has(const struct model *model, struct text name)
{
    return catalog_find(model->params, name) || catalog_find(model->derived, name) ||
           model_variable(model, name) >= 0;
}

/* Returns the first built-in model with that name, or NULL. */
const struct model *model_with(struct text name)
{
    for (const struct model *const *model = scene_models; *model; model++)
        if (model_has(*model, name))
            return *model;
    return NULL;
}

/* Returns the name of a preset with that model. */
static const char *model_scene(const struct model *model)
{
    for (size_t i = 0; i < preset_catalog.count; i++) {
        const struct preset *preset = preset_at(i);
        if ((preset->model ? preset->model : &oscillator_model) == model)
            return preset->row.name;
    }
    return model->row.name;
}

enum quantity model_quantity(const struct model *model, const struct observable *observable)
{
    const struct system system = {.model = model, .n = model->n, .order = model->order};
    return observable_quantity(observable, &system);
}

/* Returns the observable of that name, except y of typed models, or NULL. */
const struct observable *model_observable(const struct model *model, struct text name)
{
    const struct row *row =
        model->typed && text_is(name, "y") ? NULL : catalog_find(&observable_catalog, name);
    return observable_from(row);
}

/* Returns true if runs of the model have the observable: it needs nothing that a model of this
 * order never has. */
bool model_offers(const struct model *model, const struct observable *observable)
{
    unsigned never = 0;
    if (model->order != 2)
        never = NEED_MECHANICS | (model->typed ? NEED_EXACT : 0u);
    return !(observable->needs & never) && model_observable(model, text_of(observable->row.name));
}

/* Adds a hint if the name belongs to another model. Returns false if it does not. */
bool hint_other_model(const struct session *session, struct text name, struct error *error)
{
    const struct scene *scene = &session->setup.scene;
    const struct model *other = model_has(scene->model, name) ? NULL : model_with(name);
    if (other)
        error_hint(error, "'%.*s' belongs to another scene: scene %s", (int)name.len, name.data,
                   model_scene(other));
    return other != NULL;
}

/* Returns the user's scene of that name, or NULL. */
const struct preset *own_scene(const struct setup *setup, struct text name)
{
    for (int i = 0; i < setup->owns; i++)
        if (text_is(name, setup->own[i]->row.name))
            return setup->own[i];
    return NULL;
}

/* Appends "atol NAME = VALUE" of variable i. */
void atol_describe(const struct scene *scene, int i, struct buffer *text)
{
    const struct variable *variable = &scene->model->variable[i];
    buffer_format(text, "atol %s = ", variable->name);
    if (scene->atol[i] > 0)
        buffer_exact(text, (struct measured){scene->atol[i], 0}, variable->quantity);
    else
        buffer_put(text, TEXT("off"));
}

/* Appends the absolute tolerances that were set as commands, each before `end`. */
void atol_script(const struct scene *scene, const char *end, struct buffer *text)
{
    for (int i = 0; i < scene->model->n; i++)
        if (scene->atol[i] > 0) {
            atol_describe(scene, i, text);
            buffer_put(text, text_of(end));
        }
}
