/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed models and their lines. A model never changes: each line that is typed makes a new one, of
 * the old lines and this one. All models are in a list, from which a sweep removes those that are
 * not used any more. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "scene/typed/typed.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct typed_models {
    struct typed *last; /* list of all models, the last one first */
    size_t count, left; /* number of models, and number left by the last sweep */
};

struct typed_models *typed_create(struct error *error)
{
    struct typed_models *models = calloc(1, sizeof *models);
    if (!models)
        error_memory(error);
    return models;
}

static void destroy(struct typed *typed)
{
    typed_parts_destroy(typed->parts);
    arena_reset(&typed->arena);
    free(typed);
}

/* Destroys all models. */
void typed_destroy(struct typed_models *models)
{
    while (models && models->last) {
        struct typed *typed = models->last;
        models->last = typed->next;
        destroy(typed);
    }
    free(models);
}

/* Destroys models that are not used, once their number has doubled since the last sweep. */
void typed_sweep(struct typed_models *models,
                 bool (*used)(const void *context, const struct model *model), const void *context)
{
    if (models->count < 2 * models->left + SWEEP_FROM)
        return;
    struct typed **list_link = &models->last;
    while (*list_link) {
        struct typed *typed = *list_link;
        if (used(context, &typed->model)) {
            list_link = &typed->next;
        } else {
            *list_link = typed->next;
            destroy(typed);
            models->count--;
        }
    }
    models->left = models->count;
}

/* ---- lines ---- */

int typed_lines(const struct model *model)
{
    return model->typed ? model->typed->lines : 0;
}

const struct typed_line *typed_line(const struct model *model, int i)
{
    return &model->typed->line[i];
}

const struct model *typed_base(const struct model *model)
{
    return model->typed ? model->typed->base : model;
}

/* Returns true if only parameters were typed. */
static bool has_params_only(const struct model *model)
{
    int i = 0;
    while (i < typed_lines(model) && typed_line(model, i)->kind == TYPED_PARAM)
        i++;
    return i == typed_lines(model);
}

bool typed_base_has(const struct model *model, struct text name)
{
    const struct model *base = typed_base(model);
    return base && has_params_only(model) &&
           (model_state(base, name) >= 0 || catalog_find(base->params, name));
}

const struct preset *typed_preset(const struct model *model)
{
    return model->typed && !model->typed->base ? &model->typed->preset : NULL;
}

void typed_describe(const struct typed_line *line, struct buffer *text)
{
    static const char *const word[] = {
        [TYPED_VAR] = "var ",    [TYPED_PARAM] = "param ",        [TYPED_EQUATION] = "",
        [TYPED_FORCE] = "force", [TYPED_POTENTIAL] = "potential", [TYPED_OBSERVE] = "observe "};
    buffer_put(text, text_of(word[line->kind]));
    if (line->kind == TYPED_FORCE && line->name.len > 0)
        buffer_char(text, ' ');
    buffer_put(text, line->name);
    if (line->kind == TYPED_EQUATION)
        buffer_put(text, line->order == 2 ? TEXT("''") : TEXT("'"));
    const bool bare =
        line->kind == TYPED_POTENTIAL || (line->kind == TYPED_FORCE && line->name.len == 0);
    buffer_put(text, bare ? TEXT(" ") : TEXT(" = "));
    if (line->kind != TYPED_VAR && line->kind != TYPED_PARAM) {
        buffer_put(text, line->expr);
        return;
    }
    const char *unit = quantity_unit(line->quantity);
    buffer_real(text, line->value);
    if (*unit)
        buffer_format(text, " %s", unit);
}

/* Copies a text into the arena, and lets *text point to the copy. Returns false if out of
 * memory. */
static bool copy_text(struct arena *arena, struct text *text)
{
    const char *copy = arena_text(arena, *text);
    text->data = copy;
    return copy;
}

/* Returns a model with the lines of `source` and room for one more, not compiled. An empty one has
 * no base, and takes lines along only if these are parameters. `source` may be NULL. Returns NULL
 * with an error. */
static struct typed *typed_copy(const struct model *source, bool empty, struct error *error)
{
    struct typed *typed = calloc(1, sizeof *typed);
    const int lines = !source || (empty && !has_params_only(source)) ? 0 : typed_lines(source);
    if (typed) {
        typed->base = empty ? NULL : typed_base(source);
        snprintf(typed->name, sizeof typed->name, "%s",
                 empty || !source->typed ? "typed" : source->typed->name);
        typed->parts = typed_parts_create();
        typed->line = arena_array(&typed->arena, (size_t)lines + 1, sizeof *typed->line);
    }
    bool fine = typed && typed->parts && typed->line;
    for (int i = 0; fine && i < lines; i++) {
        struct typed_line *line = &typed->line[typed->lines++];
        *line = *typed_line(source, i);
        fine = copy_text(&typed->arena, &line->name) && copy_text(&typed->arena, &line->expr);
    }
    if (fine)
        return typed;
    error_memory(error);
    if (typed)
        destroy(typed);
    return NULL;
}

/* Adds a compiled model to the list. */
static const struct model *typed_model_keep(struct typed_models *models, struct typed *typed)
{
    typed->next = models->last;
    models->last = typed;
    models->count++;
    return &typed->model;
}

/* Compiles the model and adds it to the list. Returns NULL with an error, after destroying it; an
 * error in `copy` is reported at the same place of `chosen`, the caller's line. */
static const struct model *typed_lines_compile(struct typed_models *models, struct typed *typed,
                                               const struct typed_line *copy,
                                               const struct typed_line *chosen, struct error *error)
{
    const bool fine = typed_compile(typed, error);
    typed->cancel = NULL;
    if (fine)
        return typed_model_keep(models, typed);
    bool found = false;
    for (int i = 0; copy && error->where.data && !found && i < 2; i++) {
        const struct text text = i == 0 ? copy->expr : copy->name;
        const struct text original = i == 0 ? chosen->expr : chosen->name;
        found = error->where.data >= text.data && error->where.data <= text.data + text.len;
        if (found)
            error->where.data = original.data + (error->where.data - text.data);
    }
    /* An error in another line, or in none, is reported at this line, which caused it. */
    if (!found)
        error->where = !chosen                ? (struct text){NULL, 0}
                       : chosen->name.len > 0 ? chosen->name
                                              : chosen->expr;
    destroy(typed);
    return NULL;
}

const struct model *typed_new(struct typed_models *models, struct text name, struct error *error)
{
    if (name.len > LIMIT_SYMBOL) {
        error_at(error, name, "the name has more than %d letters", LIMIT_SYMBOL);
        return NULL;
    }
    struct typed *typed = typed_copy(NULL, true, error);
    if (typed && name.len > 0)
        snprintf(typed->name, sizeof typed->name, "%.*s", (int)name.len, name.data);
    return typed ? typed_lines_compile(models, typed, NULL, NULL, error) : NULL;
}

/* Makes a model of all its lines at once. */
const struct model *typed_make(struct typed_models *models, struct text name,
                               const struct typed_line *line, int count,
                               const struct cancel *cancel, struct error *error)
{
    struct typed *typed = typed_copy(NULL, true, error);
    if (!typed)
        return NULL;
    typed->cancel = cancel;
    snprintf(typed->name, sizeof typed->name, "%.*s", (int)name.len, name.data);
    typed->line = arena_array(&typed->arena, (size_t)count + 1, sizeof *line);
    bool fine = typed->line;
    for (; fine && typed->lines < count; typed->lines++) {
        struct typed_line *copy = &typed->line[typed->lines];
        *copy = line[typed->lines];
        fine = copy_text(&typed->arena, &copy->name) && copy_text(&typed->arena, &copy->expr);
    }
    if (fine)
        return typed_lines_compile(models, typed, NULL, NULL, error);
    destroy(typed);
    error_memory(error);
    return NULL;
}

static void typed_line_drop(struct typed *typed, int i)
{
    memmove(&typed->line[i], &typed->line[i + 1],
            (size_t)(typed->lines - i - 1) * sizeof *typed->line);
    typed->lines--;
}

/* Returns the index of the line of that kind and name; -1 if there is none. */
static int typed_line_find(const struct typed *typed, enum typed_kind kind, struct text name)
{
    for (int i = 0; i < typed->lines; i++)
        if (typed->line[i].kind == kind && text_equal(typed->line[i].name, name))
            return i;
    return -1;
}

/* Returns true if a variable has this name; otherwise sets an error. */
static bool has_variable(const struct typed *typed, struct text name, struct error *error)
{
    if (typed_line_find(typed, TYPED_VAR, name) >= 0)
        return true;
    struct suggestion suggestion = {.wanted = name};
    for (int i = 0; i < typed->lines; i++)
        if (typed->line[i].kind == TYPED_VAR)
            suggestion_offer(&suggestion, typed->line[i].name.data);
    error_at(error, name, "there is no variable '%.*s'", (int)name.len, name.data);
    suggestion_hint(&suggestion, error);
    return error_hint(error, "var %.*s = VALUE makes one", (int)name.len, name.data);
}

/* Returns true if a force may act along this name, or if it is empty; otherwise sets an error. */
static bool is_coordinate(const struct typed *typed, struct text name, struct error *error)
{
    const struct model *base = typed->base;
    if (name.len == 0 || (!base && typed_line_find(typed, TYPED_VAR, name) >= 0))
        return true;
    for (int i = 0; base && i < base->n / 2; i++)
        if (text_is(name, base->variable[i].name))
            return true;
    return error_at(error, name, "there is no coordinate '%.*s'", (int)name.len, name.data);
}

/* Returns true if the name of the line agrees with the other lines; otherwise sets an error. */
static bool can_line_fit(const struct typed *typed, const struct typed_line *line,
                         struct error *error)
{
    struct text name = line->name;
    const bool primed = line->kind == TYPED_VAR && name.len > 1 && name.data[name.len - 1] == '\'';
    name.len -= primed;
    if ((line->kind == TYPED_EQUATION || primed) && !has_variable(typed, name, error))
        return false;
    if (line->kind == TYPED_FORCE || line->kind == TYPED_POTENTIAL) {
        if (typed->base && typed->base->order != 2)
            return error_at(
                error, line->expr, "%s has no positions and velocities for a %s to act on",
                typed->base->row.name, line->kind == TYPED_FORCE ? "force" : "potential");
        return is_coordinate(typed, line->kind == TYPED_FORCE ? name : TEXT(""), error);
    }
    return line->kind == TYPED_EQUATION || primed || typed_name_fits(name, error);
}

/* Adds the line, or replaces the one of the same name, in a copy of the model. */
const struct model *typed_add(struct typed_models *models, const struct model *source,
                              const struct typed_line *line, struct error *error)
{
    const bool moves = line->kind == TYPED_VAR || line->kind == TYPED_EQUATION;
    const bool begins = moves || (line->kind == TYPED_PARAM && typed_base_has(source, line->name));
    struct typed *typed = typed_copy(source, begins && typed_base(source), error);
    if (!typed)
        return NULL;
    if (!can_line_fit(typed, line, error)) {
        if (error->where.data && !(error->where.data >= line->name.data &&
                                   error->where.data <= line->name.data + line->name.len))
            error->where = line->expr;
        destroy(typed);
        return NULL;
    }
    const int old = typed_line_find(typed, line->kind, line->name),
              potential = typed_line_find(typed, TYPED_POTENTIAL, TEXT(""));
    int index = old >= 0 ? old : typed->lines++;
    typed->line[index] = *line;
    if (line->kind == TYPED_POTENTIAL)
        typed->line[index].name = TEXT("");
    if (line->kind == TYPED_FORCE && potential >= 0) { /* it belonged to the old forces */
        typed_line_drop(typed, potential);
        index -= potential < index;
    }
    struct typed_line *copy = &typed->line[index];
    if (!copy_text(&typed->arena, &copy->name) || !copy_text(&typed->arena, &copy->expr)) {
        error_memory(error);
        destroy(typed);
        return NULL;
    }
    return typed_lines_compile(models, typed, copy, line, error);
}

/* Returns a remaining line that uses the removed name, or NULL if the error has another reason. */
static const struct typed_line *user_of(const struct typed *typed, const struct error *error)
{
    for (int i = 0; i < typed->lines && error->where.data; i++) {
        const struct text expr = typed->line[i].expr;
        if (expr.data && error->where.data >= expr.data &&
            error->where.data <= expr.data + expr.len)
            return &typed->line[i];
    }
    return NULL;
}

/* Removes the line of that kind and name, if there is one. */
static void drop_line(struct typed *typed, enum typed_kind kind, struct text name)
{
    const int index = typed_line_find(typed, kind, name);
    if (index >= 0)
        typed_line_drop(typed, index);
}

/* Removes a line; a variable takes its equation and its initial velocity along, and a force the
 * potential. */
static void drop_with(struct typed *typed, enum typed_kind kind, struct text name)
{
    char primed[LIMIT_SYMBOL + 2];
    drop_line(typed, kind, name);
    if (kind == TYPED_FORCE)
        drop_line(typed, TYPED_POTENTIAL, TEXT(""));
    if (kind != TYPED_VAR)
        return;
    snprintf(primed, sizeof primed, "%.*s'", (int)name.len, name.data);
    drop_line(typed, TYPED_VAR, text_of(primed));
    drop_line(typed, TYPED_EQUATION, name);
}

/* Sets the error that `name` is still used by the line. */
static void refuse_used(const struct typed_line *line, struct text name, struct error *error)
{
    struct buffer text = {0};
    typed_describe(line, &text);
    const struct text used = buffer_text(&text);
    error_at(error, name, "%.*s is still used by: %.*s", (int)name.len, name.data, (int)used.len,
             used.data);
    buffer_free(&text);
}

/* Compiles a model from which a line was removed. Returns NULL with an error if another line uses
 * the removed name. */
static const struct model *finish_without(struct typed_models *models, struct typed *typed,
                                          enum typed_kind kind, struct text name,
                                          struct error *error)
{
    const int force = kind == TYPED_VAR ? typed_line_find(typed, TYPED_FORCE, name) : -1;
    const struct typed_line *user = force >= 0 ? &typed->line[force] : NULL;
    if (!user && typed_compile(typed, error))
        return typed_model_keep(models, typed);
    user = user ? user : user_of(typed, error);
    error->where = name.len > 0 ? name : (struct text){NULL, 0};
    if (user)
        refuse_used(user, name, error);
    destroy(typed);
    return NULL;
}

/* Removes the line in a copy of the model; without lines, the base is the model. */
const struct model *typed_remove(struct typed_models *models, const struct model *source,
                                 enum typed_kind kind, struct text name, struct error *error)
{
    static const char *const word[] = {"variable", "parameter", "equation",
                                       "force",    "potential", "observed quantity"};
    if (!source->typed || typed_line_find(source->typed, kind, name) < 0) {
        error_set(error, ERROR_COMMAND, "there is no typed %s%s%.*s", word[kind],
                  name.len > 0 ? " " : "", (int)name.len, name.data);
        if (name.len > 0)
            error->where = name;
        return NULL;
    }
    if (source->typed->lines == 1 && source->typed->base)
        return source->typed->base;
    struct typed *typed = typed_copy(source, false, error);
    if (!typed)
        return NULL;
    drop_with(typed, kind, name);
    if (typed->lines == 0 && typed->base) {
        const struct model *base = typed->base;
        destroy(typed);
        return base;
    }
    return finish_without(models, typed, kind, name, error);
}

/* ---- scenes ---- */

static const struct param_row *param_row(const struct model *model, size_t i)
{
    return (const struct param_row *)(const void *)catalog_row(model->params, i);
}

/* Gives the scene the new model, with the values of parameters that both have. */
void scene_remodel(struct scene *scene, const struct model *model)
{
    const struct scene old_scene = *scene;
    scene->model = model;
    if (typed_preset(model))
        scene->preset = typed_preset(model);
    for (size_t i = 0; i < model->params->count; i++) {
        const struct param_row *row = param_row(model, i);
        const int index = scene_param(&old_scene, row->row.name);
        scene->value[i] = row->initial;
        scene->uncertainty[i] = 0;
        scene->chosen[i] = false;
        if (index < 0 || param_row(old_scene.model, (size_t)index)->initial != row->initial)
            continue;
        scene->value[i] = old_scene.value[index];
        scene->uncertainty[i] = old_scene.uncertainty[index];
        scene->chosen[i] = old_scene.chosen[index];
    }
    for (int i = 0; i < LIMIT_VARIABLES; i++) {
        const int index =
            i < model->n ? model_state(old_scene.model, text_of(model->variable[i].name)) : -1;
        scene->atol[i] = index < 0 ? 0 : old_scene.atol[index];
    }
}

/* ---- what there is to look at ---- */

/* Returns the index of a state variable, or of the velocity y' of one; -1 if there is none. */
int model_state(const struct model *model, struct text name)
{
    const bool primed = name.len > 1 && name.data[name.len - 1] == '\'';
    const struct text stem = {name.data, name.len - primed};
    int found = -1;
    for (int i = 0; i < model->n && found < 0; i++)
        if (text_equal(stem, text_of(model->variable[i].name)))
            found = i;
    if (!primed || found < 0)
        return found;
    if (model->order == 2)
        return found < model->n / 2 ? found + model->n / 2 : -1;
    return model->typed && !model->typed->base ? model->typed->velocity[found] : -1;
}

int model_observed(const struct model *model)
{
    return model->typed ? model->typed->observes : 0;
}

struct variable model_observed_variable(const struct model *model, int i)
{
    return model->typed->observed[i];
}

double system_observe(const struct system *system, int i, double t, const double *y)
{
    const struct typed_term *term = typed_term_of(system->typed.c);
    double observed[LIMIT_OBSERVED];
    typed_evaluate(term->observe, system->typed.c, t, y, observed);
    return observed[i];
}
