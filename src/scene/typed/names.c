/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names of a typed scene: variables, their velocities, parameters, initial values, and those of the
 * built-in scene to which forces are added. */
#include <hooke/base/unit.h>
#include <string.h>

#include "scene/typed/compile.h"

/* Returns true for a name with ' at its end, which is a velocity. */
static bool is_primed(struct text name)
{
    return name.len > 1 && name.data[name.len - 1] == '\'';
}

static struct text unprimed(struct text name)
{
    return (struct text){name.data, name.len - 1};
}

/* Returns true if the symbol has this name, which may be primed: y' is the velocity of y. */
static bool symbol_matches(const struct compile *c, const struct symbol *symbol, struct text name)
{
    if (is_primed(name))
        return symbol->kind >= SYMBOL_VELOCITY && symbol->primed >= 0 &&
               symbol_is(&c->symbol[symbol->primed], unprimed(name));
    return symbol_is(symbol, name);
}

/* Returns the line of that kind and name, or NULL if there is none. */
static const struct typed_line *typed_line_of(const struct typed *typed, enum typed_kind kind,
                                              struct text name)
{
    for (int i = 0; i < typed->lines; i++)
        if (typed->line[i].kind == kind && text_equal(typed->line[i].name, name))
            return &typed->line[i];
    return NULL;
}

/* Finds the symbol of a name that expressions may use, and marks it as used. */
bool typed_find(const void *context, struct text name, int *slot)
{
    const struct compile *c = context;
    for (int i = 0; i < c->symbols; i++) {
        if (c->symbol[i].hidden || !symbol_matches(c, &c->symbol[i], name))
            continue;
        *slot = i;
        c->symbol[i].used = true;
        return true;
    }
    return false;
}

void typed_offer(const void *context, struct suggestion *suggestion)
{
    const struct compile *c = context;
    for (int i = 0; i < c->symbols; i++)
        if (!c->symbol[i].hidden)
            suggestion_offer(suggestion, c->symbol[i].name);
}

/* Explains an unknown name: it is defined later, by itself, or is a velocity of first order. */
bool typed_explain(struct compile *c, const struct typed_line *line)
{
    const struct text name = c->error->where;
    if (!c->error->unknown || !text_is(text_of(c->error->unknown), "name"))
        return false;
    const struct typed_line *observe_line = typed_line_of(c->typed, TYPED_OBSERVE, name);
    if (observe_line == line)
        return error_at(c->error, name, "%.*s cannot be defined by itself", (int)name.len,
                        name.data);
    if (observe_line) {
        error_at(c->error, name, "%.*s comes after %.*s", (int)name.len, name.data,
                 (int)line->name.len, line->name.data);
        return error_hint(
            c->error,
            "a definition can use only what was typed before it ('scene' shows the order)");
    }
    if (!is_primed(name) || !typed_line_of(c->typed, TYPED_VAR, unprimed(name)))
        return false;
    error_at(c->error, name, "%.*s is not known: %.*s has an equation of first order",
             (int)name.len, name.data, (int)name.len - 1, name.data);
    return error_hint(c->error, "in scenes of second order (%.*s' = EXPR) it is the velocity",
                      (int)name.len, name.data);
}

/* Returns true if the name can be used for something new; otherwise sets an error. */
bool typed_name_fits(struct text name, struct error *error)
{
    bool fine = name.len > 0;
    for (size_t i = 0; i < name.len; i++) {
        const char character = name.data[i];
        const bool letter = (character >= 'a' && character <= 'z') ||
                            (character >= 'A' && character <= 'Z') || (character == '_' && i > 0);
        fine = fine && (letter || (i > 0 && character >= '0' && character <= '9'));
    }
    if (!fine)
        return error_at(error, name,
                        "a name begins with a letter and has letters, digits and underscores");
    if (name.len > TYPED_NAME_MAX)
        return error_at(error, name, "a name has at most %d letters", TYPED_NAME_MAX);
    if (!text_is(name, "pi") && !text_is(name, "t") && !catalog_find(&function_catalog, name))
        return true;
    error_at(error, name, "'%.*s' already means something", (int)name.len, name.data);
    return error_hint(error, "choose another name, as %.*s_1", (int)name.len, name.data);
}

/* Adds a symbol, unless its name is taken. */
int typed_symbol(struct compile *c, struct text name, enum symbol_kind kind, int index,
                 struct text where)
{
    struct symbol *symbol = &c->symbol[c->symbols];
    for (int i = 0; i < c->symbols; i++) {
        if (!symbol_is(&c->symbol[i], name))
            continue;
        if (i <= c->state + c->bases && c->typed->base) {
            error_at(c->error, where, "%s already has '%.*s'", c->typed->base->row.name,
                     (int)name.len, name.data);
            error_hint(c->error, "var NAME = VALUE begins an empty scene");
            return -1;
        }
        const char *role;
        if (c->symbol[i].kind == SYMBOL_VELOCITY)
            role = ": it is the velocity of another variable";
        else
            role = c->symbol[i].hidden ? ": it is an initial value" : "";
        error_at(c->error, where, "'%.*s' is defined twice%s", (int)name.len, name.data, role);
        error_hint(c->error, "choose another name, as %.*s_1", (int)name.len, name.data);
        return -1;
    }
    *symbol = (struct symbol){.kind = kind, .index = index, .primed = -1};
    memcpy(symbol->name, name.data, name.len < LIMIT_SYMBOL ? name.len : LIMIT_SYMBOL);
    return c->symbols++;
}

/* ---- parameters ---- */

/* Adds a parameter and its symbol; `positive` excludes values of 0 and below. Returns false with an
 * error. */
static bool add_param(struct compile *c, struct text name, double value, enum quantity quantity,
                      const char *brief, bool positive, struct text where)
{
    if (c->bases + c->owns >= PARAM_MAX)
        return error_at(c->error, where,
                        "a scene has at most %d parameters, initial values among them", PARAM_MAX);
    const int symbol = typed_symbol(c, name, SYMBOL_PARAM, c->bases + c->owns, where);
    if (symbol < 0)
        return false;
    c->own[c->owns++] = (struct param_row){
        .row = {arena_text(&c->typed->arena, name), quantity_unit(quantity), brief, "", NULL},
        .quantity = quantity,
        .initial = value,
        .min = positive ? 0 : -HUGE_VAL,
        .min_excluded = positive};
    return c->own[c->owns - 1].row.name || error_memory(c->error);
}

/* Returns true if a symbol has this name. */
static bool symbol_named(const struct compile *c, struct text name)
{
    for (int i = 0; i < c->symbols; i++)
        if (symbol_is(&c->symbol[i], name))
            return true;
    return false;
}

/* Sets the error that a line uses the name of a variable's initial value. Returns false. */
static bool refuse_initial(const struct compile *c, struct text name, struct text variable,
                           struct text where)
{
    const struct typed_line *param = typed_line_of(c->typed, TYPED_PARAM, name),
                            *var = typed_line_of(c->typed, TYPED_VAR, name);
    const struct typed_line *line = param ? param : var;
    const char *const kind = param ? "parameter" : "variable";
    return error_at(c->error, line ? line->name : where,
                    "%.*s is the initial value of %.*s: the %s %.*s needs another name",
                    (int)name.len, name.data, (int)variable.len, variable.data, kind, (int)name.len,
                    name.data);
}

/* The initial value of y is y0, that of x1 is x1_0. */
bool typed_initial(struct compile *c, struct text variable, const struct typed_line *line,
                   enum quantity quantity, struct text where)
{
    struct buffer name = {0}, brief = {0};
    const char last = variable.data[variable.len - 1];
    buffer_put(&name, variable);
    buffer_put(&name, last >= '0' && last <= '9' ? TEXT("_0") : TEXT("0"));
    buffer_put(&brief, variable);
    buffer_put(&brief, TEXT(" at t0"));
    const char *const explanation =
        brief.failed ? NULL : arena_text(&c->typed->arena, buffer_text(&brief));
    const bool taken = symbol_named(c, buffer_text(&name));
    bool fine;
    if (taken)
        fine = refuse_initial(c, buffer_text(&name), variable, where);
    else if (!name.failed && explanation)
        fine = add_param(c, buffer_text(&name), line ? line->value : 0, quantity, explanation,
                         false, where);
    else
        fine = error_memory(c->error);
    buffer_free(&name);
    buffer_free(&brief);
    if (fine)
        c->symbol[c->symbols - 1].hidden = true;
    return fine;
}

bool typed_start_time(struct compile *c)
{
    if (!add_param(c, TEXT("t0"), 0, QUANTITY_TIME, "time at the start", false, (struct text){0}))
        return false;
    c->symbol[c->symbols - 1].hidden = true;
    return true;
}

/* ---- declarations ---- */

/* Declares the state variables and parameters of the built-in scene. Returns false with an
 * error. */
static bool declare_base(struct compile *c)
{
    const struct model *base = c->typed->base;
    const int half = base->n / 2;
    c->state = base->n;
    for (int i = 0; i < base->n; i++) {
        const int symbol =
            typed_symbol(c, text_of(base->variable[i].name), SYMBOL_STATE, i, (struct text){0});
        if (symbol >= 0 && base->order == 2 && i >= half)
            c->symbol[symbol].primed = symbol - half;
    }
    c->bases = (int)base->params->count;
    for (int i = 0; i < c->bases; i++)
        if (typed_symbol(c, text_of(catalog_row(base->params, (size_t)i)->name), SYMBOL_PARAM, i,
                         (struct text){0}) < 0)
            return false;
    return true;
}

/* Declares the velocity vx of a variable x. A line with the name vx takes precedence until x has an
 * equation, because x' = vx may follow. Returns false with an error. */
static bool declare_velocity(struct compile *c, struct unknown *u)
{
    const struct text variable = u->line->name;
    struct buffer name = {0};
    buffer_char(&name, 'v');
    buffer_put(&name, variable);
    if (name.failed) {
        buffer_free(&name);
        return error_memory(c->error);
    }
    const bool decided = u->equation || u->speed;
    const bool taken = typed_line_of(c->typed, TYPED_VAR, buffer_text(&name)) ||
                       typed_line_of(c->typed, TYPED_PARAM, buffer_text(&name)) ||
                       typed_line_of(c->typed, TYPED_OBSERVE, buffer_text(&name));
    const bool declares = decided || !taken;
    if (declares)
        u->velocity =
            typed_symbol(c, buffer_text(&name), SYMBOL_VELOCITY, c->unknowns - 1, variable);
    buffer_free(&name);
    if (u->velocity >= 0)
        c->symbol[u->velocity].primed = u->symbol;
    return u->velocity >= 0 || !declares;
}

/* Declares a variable, and its velocity unless its equation is of first order. Returns false with
 * an error. */
static bool declare_unknown(struct compile *c, const struct typed_line *line)
{
    struct unknown *u = &c->unknown[c->unknowns];
    *u = (struct unknown){.line = line, .velocity = -1};
    u->equation = typed_line_of(c->typed, TYPED_EQUATION, line->name);
    u->symbol = typed_symbol(c, line->name, SYMBOL_VARIABLE, c->unknowns, line->name);
    if (u->symbol < 0)
        return false;
    for (int i = 0; i < c->typed->lines; i++) {
        const struct typed_line *other = &c->typed->line[i];
        if (other->kind == TYPED_VAR && is_primed(other->name) &&
            text_equal(unprimed(other->name), line->name))
            u->speed = other;
    }
    c->unknowns++;
    if (u->equation && u->equation->order == 1)
        return !u->speed ||
               error_at(c->error, u->equation->expr,
                        "%.*s has an initial velocity, so it needs %.*s'' = …", (int)line->name.len,
                        line->name.data, (int)line->name.len, line->name.data);
    return declare_velocity(c, u);
}

/* Declares time, the base, then variables and parameters in the order of their lines. */
bool typed_declare(struct compile *c)
{
    const struct typed *typed = c->typed;
    if (typed_symbol(c, TEXT("t"), SYMBOL_TIME, 0, (struct text){0}) < 0 ||
        (typed->base && !declare_base(c)))
        return false;
    for (int i = 0; i < typed->lines; i++) {
        const struct typed_line *line = &typed->line[i];
        if (line->kind == TYPED_VAR && !is_primed(line->name) && !declare_unknown(c, line))
            return false;
        if (line->kind == TYPED_PARAM &&
            !add_param(c, line->name, line->value, line->quantity, "typed by the user",
                       !typed->base && text_is(line->name, "m") && line->value > 0, line->name))
            return false;
    }
    return true;
}
