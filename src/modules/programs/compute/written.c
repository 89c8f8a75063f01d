/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes the forces of a scene as expressions with one set of names, from the texts of built-in
 * terms and from what was typed. */
#include <string.h>

#include "modules/programs/compute/written.h"
#include "scene/typed/typed.h"

/* ---- names ---- */

/* Finds the velocity that is called by its position's name with a prime, such as x', and sets *slot
 * to its index among the names (0 is the time, then positions, then velocities). Returns false if
 * the name is not such a velocity. */
static bool find_primed(const struct written *w, struct text name, int *slot)
{
    const struct model *model = w->system.model;
    const int half = model->n / 2;
    if (model->order != 2 || name.len < 2 || name.data[name.len - 1] != '\'')
        return false;
    for (int i = 0; i < half; i++)
        if (text_is((struct text){name.data, name.len - 1}, model->variable[i].name)) {
            *slot = 1 + half + i;
            return true;
        }
    return false;
}

/* Finds a name for expr_compile() and sets *slot to its index; context is the struct written. Names
 * of observed quantities are not found here. Returns false if the name is unknown. */
static bool written_slot_find(const void *context, struct text name, int *slot)
{
    const struct written *w = context;
    if (find_primed(w, name, slot))
        return true;
    for (int i = 0; i < w->observed; i++)
        if (text_is(name, w->name[i])) {
            *slot = i;
            return true;
        }
    return false;
}

/* Makes the list w->name of all names in the order of slots: t, variables, parameters, observed
 * quantities; w->zero marks parameters that are 0. Returns false if out of memory. */
static bool make_names(struct written *w)
{
    const struct model *model = w->system.model;
    const int params = (int)model->params->count, observes = model_observed(model);
    w->params = 1 + model->n;
    w->observed = w->params + params;
    w->names = w->observed + observes;
    w->name = arena_array(&w->arena, (size_t)w->names, sizeof *w->name);
    w->zero = arena_array(&w->arena, (size_t)w->names, sizeof *w->zero);
    if (!w->name || !w->zero)
        return false;
    w->name[0] = "t";
    for (int i = 0; i < model->n; i++)
        w->name[1 + i] = model->variable[i].name;
    for (int i = 0; i < params; i++) {
        w->name[w->params + i] = param_at(w->scene, i)->row.name;
        w->zero[w->params + i] = w->scene->value[i] == 0;
    }
    for (int i = 0; i < observes; i++) {
        const struct variable seen = model_observed_variable(model, i);
        w->name[w->observed + i] = arena_text(&w->arena, text_of(seen.name));
        if (!w->name[w->observed + i])
            return false;
    }
    return true;
}

/* ---- expressions of terms ---- */

/* Compiles the text of a built-in term. Returns NULL with an error. */
static const struct expr *built_in(struct written *w, const char *text, struct error *error)
{
    const struct expr_scope scope = {.context = w, .find = written_slot_find};
    size_t used;
    return expr_compile(text_of(text), &scope, &w->arena, &used, error);
}

/* Copies an expression of a typed scene with the slots of this program's names instead of the
 * scene's; a mass that is no parameter becomes its number. Returns NULL with an error if out of
 * memory. */
static const struct expr *rename_expr(struct written *w, const struct typed *typed,
                                      const struct expr *expr, struct error *error)
{
    struct expr *result = arena_alloc(&w->arena, sizeof *result);
    struct op *op = result ? arena_array(&w->arena, expr->count, sizeof *op) : NULL;
    if (!op)
        return error_memory(error), NULL;
    memcpy(op, expr->op, expr->count * sizeof *op);
    for (size_t i = 0; i < expr->count; i++) {
        const int slot = op[i].kind == OP_NAME ? op[i].slot : 0;
        if (slot == typed_mass_name(typed)) {
            const int m = scene_param(w->scene, "m");
            op[i] = m >= 0 ? (struct op){.kind = OP_NAME, .slot = w->params + m}
                           : (struct op){.kind = OP_NUMBER, .number = w->system.mass};
        } else if (slot >= typed_first_observed(typed)) {
            op[i].slot = w->observed + slot - typed_first_observed(typed);
        } else if (slot >= typed_first_read(typed)) {
            op[i].slot = w->params + typed->read[slot - typed_first_read(typed)];
        }
    }
    *result = (struct expr){.op = op, .count = expr->count, .capacity = expr->count};
    return result;
}

/* Finds the expression that a term adds to a row; *expr is NULL if it adds nothing. `as_typed`
 * prefers the readable form to the one that gives the same bits as hooke. Returns false with an
 * error. */
static bool term_row(struct written *w, const struct bound_term *term, int row, bool as_typed,
                     const struct expr **expr, struct error *error)
{
    *expr = NULL;
    if (term->row->bind) {
        const char *const text = !as_typed && term->row->ordered[row] ? term->row->ordered[row]
                                                                      : term->row->equation[row];
        *expr = text ? built_in(w, text, error) : NULL;
        return *expr || !text;
    }
    const struct typed_term *typed = typed_term_of(term->c);
    const struct expr *own = typed->typed->group[typed - typed->part->term][row];
    *expr = own ? rename_expr(w, typed->typed, own, error) : NULL;
    return *expr || !own;
}

/* ---- sums ---- */

/* Returns true if all numbers of the expression are finite. */
static bool has_numbers(const struct expr *expr)
{
    for (size_t i = 0; i < expr->count; i++)
        if (expr->op[i].kind == OP_NUMBER && !isfinite(expr->op[i].number))
            return false;
    return true;
}

/* Adds an expression to a sum, which is NULL at first. Returns false with an error. */
static bool sum_add(struct written *w, const struct expr **sum, const struct expr *more,
                    struct error *error)
{
    if (!has_numbers(more))
        return error_set(error, ERROR_COMMAND, "the forces contain a number that is not finite");
    *sum = *sum ? typed_join(&w->arena, *sum, more, OP_ADD, error) : more;
    return *sum;
}

/* Stores friction/m from the term -friction/m*sign(y'), whose last three operations are the sign,
 * by removing these and the minus. Returns false with an error if out of memory. */
static bool take_dry(struct written *w, const struct expr *expr, struct error *error)
{
    struct expr *force = arena_alloc(&w->arena, sizeof *force);
    if (!force)
        return error_memory(error);
    *force = (struct expr){.op = expr->op, .count = expr->count - 3};
    struct expr *minus = arena_alloc(&w->arena, sizeof *minus);
    struct op *op = minus ? arena_array(&w->arena, force->count + 1, sizeof *op) : NULL;
    if (!op)
        return error_memory(error);
    memcpy(op, force->op, force->count * sizeof *op);
    op[force->count] = (struct op){.kind = OP_NEG};
    *minus = (struct expr){.op = op, .count = force->count + 1};
    w->dry = minus;
    return true;
}

/* Adds all terms of the scene to the sums of each row: all terms, and drag and force apart. Dry
 * friction is stored apart unless as_typed. Returns false with an error. */
static bool add_terms(struct written *w, bool as_typed, struct error *error)
{
    for (int i = 0; i < w->system.terms; i++) {
        const struct bound_term *term = &w->system.term[i];
        const bool drags = term->row->flags & TERM_VELOCITY;
        for (int row = 0; row < w->rows; row++) {
            const struct expr *expr;
            if (!term_row(w, term, row, as_typed, &expr, error))
                return false;
            if (expr && term->row->flags & TERM_DRY && !as_typed) {
                if (!take_dry(w, expr, error))
                    return false;
            } else if (expr && (!sum_add(w, &w->all[row], expr, error) ||
                                !sum_add(w, drags ? &w->drag[row] : &w->force[row], expr, error))) {
                return false;
            }
        }
    }
    return true;
}

/* Sets w->split [rows] to the sums of w->force and w->drag, the forces of splittings that apply
 * both at once; either may be NULL (no such term). Returns false with an error. */
static bool add_split(struct written *w, struct error *error)
{
    for (int row = 0; row < w->rows; row++) {
        w->split[row] = w->force[row];
        if (w->drag[row] && !sum_add(w, &w->split[row], w->drag[row], error))
            return false;
    }
    return true;
}

/* Makes the expressions of observed quantities. Returns false with an error if out of memory. */
static bool add_observed(struct written *w, struct error *error)
{
    const struct typed *typed = w->system.model->typed;
    const int count = w->names - w->observed;
    w->observe = arena_array(&w->arena, (size_t)count + 1, sizeof(const struct expr *));
    if (!w->observe)
        return error_memory(error);
    for (int i = 0; i < count; i++)
        if (!(w->observe[i] = rename_expr(w, typed, typed->observe[i], error)))
            return false;
    return true;
}

/* Makes the expressions of a scene, as typed or as computed. */
bool written_make(struct written *w, const struct scene *scene, bool as_typed, struct error *error)
{
    *w = (struct written){.scene = scene};
    if (!scene_bind(scene, &w->system, error))
        return false;
    w->rows = w->system.order == 2 ? w->system.n / 2 : w->system.n;
    return (make_names(w) || error_memory(error)) && add_terms(w, as_typed, error) &&
           add_split(w, error) && add_observed(w, error);
}

void written_free(struct written *w)
{
    arena_reset(&w->arena);
}
