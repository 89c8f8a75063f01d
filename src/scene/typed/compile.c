/* SPDX-License-Identifier: GPL-3.0-or-later */
/* typed_compile(): makes a model of typed lines: its state, its parameters, and the sum of forces
 * or the derivative of each variable. */
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <stdlib.h>
#include <string.h>

#include "scene/model/model.h"
#include "scene/typed/compile.h"

/* ---- expressions ---- */

/* Compiles the expression of a line. Returns false with an error, also if the user cancels. */
static bool read_expr(struct compile *c, const struct typed_line *line, const struct expr **expr)
{
    if (cancelled(c->typed->cancel))
        return error_set(c->error, ERROR_CANCELLED, "stopped; nothing was changed");
    const struct expr_scope scope = {.context = c, .find = typed_find, .offer = typed_offer};
    const struct text text = line->expr;
    size_t used;
    *expr = expr_compile(text, &scope, &c->typed->arena, &used, c->error);
    if (!*expr)
        return typed_explain(c, line);
    const struct text rest = text_trim(text_after(text, used));
    if (rest.len == 0)
        return true;
    error_at(c->error, rest, "the expression ends before '%.*s'", (int)rest.len, rest.data);
    if (unit_match(rest))
        return error_hint(c->error,
                          "only values have units: type 'param NAME = 0.2 N/m' and use NAME here");
    return !strchr(")=,;'", rest.data[0]) ? error_hint(c->error, "write products with *, as in 2*x")
                                          : false;
}

/* Reads all lines. Observables come first: each knows those above, and equations know all. */
static bool read_all(struct compile *c)
{
    struct typed *typed = c->typed;
    for (int i = 0; i < typed->lines; i++) {
        const struct typed_line *line = &typed->line[i];
        if (line->kind != TYPED_OBSERVE)
            continue;
        if (typed->observes == LIMIT_OBSERVED)
            return error_at(c->error, line->name, "a scene has at most %d observed quantities",
                            LIMIT_OBSERVED);
        if (!read_expr(c, line, &typed->observe[typed->observes]) ||
            typed_symbol(c, line->name, SYMBOL_OBSERVED, typed->observes, line->name) < 0)
            return false;
        struct variable *variable = &typed->observed[typed->observes++];
        *variable = (struct variable){.quantity = QUANTITY_NUMBER};
        memcpy(variable->name, line->name.data, line->name.len);
    }
    for (int i = 0; i < c->unknowns; i++)
        if (c->unknown[i].equation && !read_expr(c, c->unknown[i].equation, &c->unknown[i].expr))
            return false;
    for (int i = 0; i < typed->lines; i++) {
        const struct typed_line *line = &typed->line[i];
        if ((line->kind == TYPED_FORCE && !read_expr(c, line, &c->force[i])) ||
            (line->kind == TYPED_POTENTIAL && !read_expr(c, line, &typed->potential)))
            return false;
    }
    return true;
}

/* ---- layout ---- */

/* Returns the quantity of a velocity of a variable with this quantity. */
static enum quantity rate_of(enum quantity quantity)
{
    if (quantity == QUANTITY_LENGTH)
        return QUANTITY_VELOCITY;
    return quantity == QUANTITY_ANGLE ? QUANTITY_ANGULAR_FREQUENCY : QUANTITY_NUMBER;
}

/* Notes the first variable that has no equation yet. */
static void incomplete_find(struct compile *c)
{
    c->typed->incomplete = -1;
    for (int i = c->unknowns - 1; i >= 0; i--)
        if (!c->unknown[i].equation)
            c->typed->incomplete = (int)(c->unknown[i].line - c->typed->line);
}

/* Assigns indices in the state to the variables, with velocities behind all positions, and adds the
 * formulas of their initial values. A variable has a velocity if its equation is of second order
 * or, without one, if its velocity is used; the scene is of second order if all variables are.
 * Returns false with an error. */
static bool state_lay_out(struct compile *c)
{
    struct typed *typed = c->typed;
    struct model *model = &typed->model;
    int second = 0;
    for (int i = 0; i < c->unknowns; i++) {
        struct unknown *u = &c->unknown[i];
        const bool moves = u->velocity >= 0 && (u->speed || c->symbol[u->velocity].used);
        if (u->equation)
            u->order = u->equation->order;
        else
            u->order = moves ? 2 : 1;
        second += u->order == 2;
    }
    model->order = c->unknowns > 0 && second == c->unknowns ? 2 : 1;
    model->n = c->unknowns + second;
    if (model->n > LIMIT_VARIABLES)
        return error_set(c->error, ERROR_COMMAND,
                         "a scene has at most %d variables, velocities among them",
                         LIMIT_VARIABLES);
    struct variable *variable = arena_array(&typed->arena, (size_t)model->n + 1, sizeof *variable);
    if (!variable)
        return error_memory(c->error);
    model->variable = variable;
    for (int i = 0, velocity = c->unknowns; i < c->unknowns; i++) {
        const struct unknown *u = &c->unknown[i];
        struct symbol *symbol = &c->symbol[u->symbol];
        symbol->slot = 1 + i;
        memcpy(variable[i].name, symbol->name, sizeof symbol->name);
        variable[i].quantity = u->line->quantity;
        typed->initial[i] = c->bases + c->owns;
        if (!typed_initial(c, u->line->name, u->line, u->line->quantity, u->line->name))
            return false;
        typed->velocity[i] = -1;
        if (u->order != 2)
            continue;
        typed->velocity[i] = velocity;
        typed->velocity[velocity] = -1;
        symbol = &c->symbol[u->velocity];
        symbol->slot = 1 + velocity;
        memcpy(variable[velocity].name, symbol->name, sizeof symbol->name);
        variable[velocity].quantity = rate_of(u->line->quantity);
        typed->initial[velocity] = c->bases + c->owns;
        if (!typed_initial(c, text_of(symbol->name), u->speed, variable[velocity].quantity,
                           u->line->name))
            return false;
        velocity++;
    }
    typed->t0 = c->bases + c->owns;
    return typed_start_time(c);
}

/* Numbers the names as struct typed has them; only parameters that are read get a number. Returns
 * false if there are too many. */
static bool number_names(struct compile *c)
{
    struct typed *typed = c->typed;
    typed->mass = -1;
    for (int i = 0; i < c->symbols; i++) {
        struct symbol *symbol = &c->symbol[i];
        if (symbol->kind == SYMBOL_STATE)
            symbol->slot = 1 + symbol->index;
        if (symbol->kind != SYMBOL_PARAM)
            continue;
        if (!typed->base && symbol_is(symbol, TEXT("m")))
            typed->mass = symbol->index;
        if (!symbol->used)
            continue;
        if (typed->reads == TYPED_READS)
            return error_set(c->error, ERROR_COMMAND, "the equations use more than %d parameters",
                             TYPED_READS);
        typed->read[typed->reads] = symbol->index;
        symbol->slot = typed_first_read(typed) + typed->reads++;
    }
    for (int i = 0; i < c->symbols; i++)
        if (c->symbol[i].kind == SYMBOL_OBSERVED)
            c->symbol[i].slot = typed_first_observed(typed) + c->symbol[i].index;
    return true;
}

/* Replaces the slots of an expression, which are symbols, by the numbers of names. */
static void renumber(const struct compile *c, const struct expr *expr)
{
    for (size_t i = 0; expr && i < expr->count; i++)
        if (expr->op[i].kind == OP_NAME)
            expr->op[i].slot = c->symbol[expr->op[i].slot].slot;
}

/* Does that in all expressions. */
static void renumber_all(const struct compile *c)
{
    for (int i = 0; i < c->typed->observes; i++)
        renumber(c, c->typed->observe[i]);
    for (int i = 0; i < c->unknowns; i++)
        renumber(c, c->unknown[i].expr);
    for (int i = 0; i < c->typed->lines; i++)
        renumber(c, c->force[i]);
    renumber(c, c->typed->potential);
}

/* ---- rows and groups ---- */

/* Sets depends [names] to the bits of enum typed_dependence of each name. */
static void find_dependence(const struct compile *c, unsigned *depends)
{
    const struct typed *typed = c->typed;
    const int n = typed->model.n;
    depends[0] = DEPENDS_TIME;
    for (int i = 0; i < n; i++)
        depends[1 + i] =
            typed->model.order == 2 && i >= n / 2 ? DEPENDS_VELOCITY : DEPENDS_POSITION;
    for (int i = 0; i < typed->observes; i++)
        depends[typed_first_observed(typed) + i] = typed_depends(typed->observe[i], depends);
}

/* Returns the first line of that kind; NULL if there is none. */
static const struct typed_line *first_line(const struct typed *typed, enum typed_kind kind)
{
    for (int i = 0; i < typed->lines; i++)
        if (typed->line[i].kind == kind)
            return &typed->line[i];
    return NULL;
}

/* Returns true if forces and a potential are allowed in this scene; otherwise sets an error. */
static bool check_mechanics(const struct compile *c, const unsigned *depends)
{
    const struct typed *typed = c->typed;
    const struct typed_line *force = first_line(typed, TYPED_FORCE),
                            *potential = first_line(typed, TYPED_POTENTIAL);
    if ((force || potential) && typed->model.order != 2 && typed->incomplete < 0) {
        error_set(c->error, ERROR_COMMAND, "a %s needs a scene of second order",
                  force ? "force" : "potential");
        return error_hint(c->error, "every variable x needs x'' = EXPR");
    }
    if (potential && typed_depends(typed->potential, depends) & (DEPENDS_TIME | DEPENDS_VELOCITY))
        return error_at(c->error, potential->expr,
                        "a potential depends on positions only, not on time or velocities");
    return true;
}

/* Sets *whole to the sum of all that the user typed for a row of the equations of motion, or to
 * NULL if there is nothing. In a scene of second order it is an acceleration, to which forces
 * contribute divided by the mass. Returns false with an error. */
static bool row_sum(struct compile *c, int row, const struct expr **whole)
{
    struct typed *typed = c->typed;
    struct arena *arena = &typed->arena;
    *whole = NULL;
    if (typed->model.order == 1) {
        for (int i = 0, velocity = c->unknowns; i < c->unknowns; i++) {
            const struct unknown *u = &c->unknown[i];
            const struct op speed = {.kind = OP_NAME, .slot = 1 + velocity};
            if (row == i)
                *whole = u->order == 2 ? typed_value(arena, speed) : u->expr;
            else if (row == velocity && u->order == 2)
                *whole = u->expr;
            velocity += u->order == 2;
        }
        return *whole || typed->incomplete >= 0 || typed->base || error_memory(c->error);
    }
    if (!typed->base)
        *whole = c->unknown[row].expr;
    for (int i = 0; i < typed->lines; i++) {
        const struct typed_line *line = &typed->line[i];
        if (!c->force[i] || !text_equal(line->name, row == 0 && line->name.len == 0
                                                        ? line->name
                                                        : text_of(typed->model.variable[row].name)))
            continue;
        const struct op mass = {.kind = OP_NAME, .slot = typed_mass_name(typed)};
        const struct expr *divisor = typed_value(arena, mass);
        const struct expr *part = divisor
                                      ? typed_join(arena, c->force[i], divisor, OP_DIV, c->error)
                                      : (error_memory(c->error), NULL);
        if (!part || !(*whole = *whole ? typed_join(arena, *whole, part, OP_ADD, c->error) : part))
            return false;
    }
    return true;
}

/* Splits the right-hand side of each equation into sums of summands that depend on the same things
 * (enum typed_group), and stores them in typed->group. depends [names] tells what each name depends
 * on. Returns false with an error. */
static bool group_rows(struct compile *c, const unsigned *depends)
{
    struct typed *typed = c->typed;
    const int rows = typed_rows(typed);
    const struct typed_sort sort = {&typed->arena, c->error, depends,
                                    typed->potential || (typed->model.order == 2 && !typed->base)};
    for (int row = 0; row < rows; row++) {
        const struct expr *whole, *group[GROUPS] = {NULL, NULL, NULL};
        if (cancelled(typed->cancel))
            return error_set(c->error, ERROR_CANCELLED, "stopped; nothing was changed");
        if (!row_sum(c, row, &whole) || (whole && !typed_sort(&sort, whole, group)))
            return false;
        for (int g = 0; g < GROUPS; g++) {
            if (!group[g])
                continue;
            if (!typed->group[g])
                typed->group[g] = arena_array(&typed->arena, (size_t)rows, sizeof *typed->group[g]);
            if (!typed->group[g])
                return error_memory(c->error);
            typed->group[g][row] = group[g];
        }
    }
    return true;
}

/* ---- the model ---- */

/* Makes the catalogs of the model's parameters and terms. The first c->bases parameters are those
 * of the built-in scene that was extended (typed->base, or NULL), the c->owns others were typed.
 * The terms of the built-in scene are followed by one for each group (enum typed_group) that has
 * summands. Returns false if out of memory. */
static bool make_tables(struct compile *c)
{
    static const char *const name[GROUPS] = {"typed force", "typed force", "typed drag"};
    static const char *const brief[GROUPS] = {
        "depends on positions only", "depends on positions and time", "depends on velocities"};
    struct typed *typed = c->typed;
    const struct model *base = typed->base;
    const size_t terms = base ? base->terms->count : 0, params = (size_t)c->bases + (size_t)c->owns;
    struct param_row *param = arena_array(&typed->arena, params, sizeof *param);
    typed->row = arena_array(&typed->arena, terms + GROUPS, sizeof *typed->row);
    if (!param || !typed->row)
        return error_memory(c->error);
    for (size_t i = 0; i < params; i++)
        param[i] = base && i < (size_t)c->bases
                       ? *(const struct param_row *)(const void *)catalog_row(base->params, i)
                       : c->own[i - (size_t)c->bases];
    size_t count = 0;
    for (; count < terms; count++)
        typed->row[count] = *(const struct term_row *)(const void *)catalog_row(base->terms, count);
    for (int g = 0; g < GROUPS; g++)
        if (typed->group[g])
            typed->row[count++].row =
                typed->model.order == 2
                    ? (struct row){name[g], base ? "m/s^2" : "", brief[g], "", NULL}
                    : (struct row){"equations", "", "typed by the user", "", NULL};
    typed->params = (struct catalog){"parameter", param, params, sizeof *param, NULL, 0};
    typed->terms = (struct catalog){
        base ? base->terms->kind : "term", typed->row, count, sizeof *typed->row, NULL, 0};
    return true;
}

/* Makes the model from the expressions that were read: a copy of the built-in one that was extended
 * (typed->base) or a new one, with its parameters and terms. Returns false with an error. */
static bool make_model(struct compile *c)
{
    struct typed *typed = c->typed;
    struct model *model = &typed->model;
    if (typed->base) {
        *model = *typed->base;
        model->exact = NULL;
    } else {
        model->row = (struct row){typed->name, "", "equations typed by the user", "", NULL};
        model->derived = &no_derived;
        model->begin = typed_begin;
        if (!state_lay_out(c))
            return false;
    }
    model->params = &typed->params;
    model->terms = &typed->terms;
    model->typed = typed;
    typed->preset = (struct preset){.row = model->row, .model = model};
    incomplete_find(c);
    if (!number_names(c))
        return false;
    renumber_all(c);
    unsigned *depends = calloc((size_t)typed_names(typed), sizeof *depends);
    if (!depends)
        return error_memory(c->error);
    find_dependence(c, depends);
    const bool fine = check_mechanics(c, depends) && group_rows(c, depends);
    free(depends);
    if (!fine || !make_tables(c))
        return false;
    if (typed->base || model->order != 2 || model->n != 2)
        return true;
    model->derived = &typed->derived;
    return derived_for_typed(model, &typed->arena, &typed->derived) || error_memory(c->error);
}

/* Declares names, reads expressions, and makes the model, with memory for the lines that there
 * are. */
bool typed_compile(struct typed *typed, struct error *error)
{
    const size_t lines = (size_t)typed->lines;
    const size_t base = typed->base ? (size_t)typed->base->n + typed->base->params->count : 0;
    struct compile c = {.typed = typed, .error = error};
    c.symbol = calloc(base + 4 * lines + 2, sizeof *c.symbol); /* x, vx, x0, vx0; t, t0 */
    c.unknown = calloc(lines + 1, sizeof *c.unknown);
    c.own = calloc(PARAM_MAX, sizeof *c.own);
    c.force = calloc(lines + 1, sizeof *c.force);
    typed->observe = arena_array(&typed->arena, lines + 1, sizeof *typed->observe);
    typed->observed = arena_array(&typed->arena, lines + 1, sizeof *typed->observed);
    const bool allocated =
        c.symbol && c.unknown && c.own && c.force && typed->observe && typed->observed;
    const bool fine =
        allocated ? typed_declare(&c) && read_all(&c) && make_model(&c) : error_memory(error);
    free(c.symbol);
    free(c.unknown);
    free(c.own);
    free(c.force);
    return fine;
}
