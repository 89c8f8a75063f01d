/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas in t as curves: which names are parameters, and their values and derivatives. */
#include "analysis/fit/formula.h"

#include <stdio.h>
#include <string.h>

/* Slots: the columns (t last), then the parameters, then the known names. */
struct names {
    struct formula *formula;
    const struct expr_scope *known;
    struct arena *arena;
    double *constant; /* [LIMIT_TOKENS] values of known names */
    int constants;
    enum { NAMES_FINE, NAMES_MANY, NAMES_MEMORY } state;
};

enum {
    FIRST_PARAMETER = 64,
    FIRST_CONSTANT = FIRST_PARAMETER + CURVE_PARAMETERS,
    CONSTANTS_MAX = 256
};

struct scope_context {
    struct names *names;
};

static int find_parameter(const struct formula *f, struct text name)
{
    for (int j = 0; j < f->parameters; j++)
        if (text_is(name, f->name[j]))
            return j;
    return -1;
}

static bool find_constant(struct names *n, struct text name, int *slot)
{
    int known;
    if (!n->known || !n->known->find(n->known->context, name, &known) ||
        n->constants == CONSTANTS_MAX)
        return false;
    n->constant[n->constants] = n->known->load(n->known->context, known);
    *slot = FIRST_CONSTANT + n->constants++;
    return true;
}

/* Names with a hyphen are only what is known so: b1-b2 is a difference. */
static bool find(const void *context, struct text name, int *slot)
{
    struct names *n = ((const struct scope_context *)context)->names;
    struct formula *f = n->formula;
    *slot = f->columns;
    if (text_is(name, "t"))
        return true;
    for (int i = 0; i < f->columns; i++) {
        *slot = i;
        if (text_is(name, f->column[i].name))
            return true;
    }
    int j = find_parameter(f, name);
    if (j < 0 && find_constant(n, name, slot))
        return true;
    if (j < 0 && (memchr(name.at, '-', name.len) || name.len > LIMIT_NAME ||
                  catalog_find(&function_catalog, name)))
        return false;
    if (j < 0 && f->parameters == CURVE_PARAMETERS) {
        n->state = NAMES_MANY;
        return false;
    }
    if (j < 0) {
        char *copy = arena_text(n->arena, name);
        if (!copy) {
            n->state = NAMES_MEMORY;
            return false;
        }
        j = f->parameters++;
        f->name[j] = copy;
    }
    *slot = FIRST_PARAMETER + j;
    return true;
}

/* As many parameters as the formula is linear in together, the first ones first. */
static void mark_linear(struct formula *f)
{
    int chosen[CURVE_PARAMETERS], count = 0;
    for (int j = 0; j < f->parameters; j++) {
        chosen[count] = FIRST_PARAMETER + j;
        f->linear[j] = expr_linear(f->expr, chosen, count + 1);
        count += f->linear[j];
    }
}

bool formula_compile(struct text text, const struct expr_scope *known,
                     const struct formula_column *column, int columns, struct arena *arena,
                     struct formula *formula, size_t *used, struct error *error)
{
    *formula = (struct formula){.column = column, .columns = columns};
    formula->constant = arena_array(arena, CONSTANTS_MAX, sizeof(double));
    if (!formula->constant)
        return error_memory(error);
    struct names names = {
        .formula = formula, .known = known, .arena = arena, .constant = formula->constant};
    struct scope_context context = {&names};
    struct expr_scope scope = {
        .context = &context, .find = find, .offer = known ? known->offer : NULL};
    formula->expr = expr_compile(text, &scope, arena, used, error);
    if (names.state == NAMES_MEMORY)
        return error_memory(error);
    if (names.state == NAMES_MANY)
        return error_at(error, text, "the formula has more than %d parameters", CURVE_PARAMETERS);
    if (!formula->expr)
        return false;
    if (formula->parameters == 0) {
        error_at(error, (struct text){text.at, *used}, "the formula has no parameter to fit");
        return error_hint(error,
                          "names that are not known yet are its parameters: a*exp(-b*t) + c");
    }
    for (int j = 0; j < formula->parameters; j++) {
        formula->low[j] = -INFINITY;
        formula->high[j] = INFINITY;
    }
    mark_linear(formula);
    return true;
}

static int require_parameter(const struct formula *f, struct text name, struct error *error)
{
    int j = find_parameter(f, name);
    if (j >= 0)
        return j;
    struct suggestion suggestion = {.wanted = name};
    error_at(error, name, "the formula has no parameter '%.*s'",
             name.len < LIMIT_NAME ? (int)name.len : LIMIT_NAME, name.at);
    for (int i = 0; i < f->parameters; i++)
        suggestion_offer(&suggestion, f->name[i]);
    suggestion_hint(&suggestion, error);
    return -1;
}

bool formula_start(struct formula *f, struct text name, double start, struct error *error)
{
    int j = require_parameter(f, name, error);
    if (j >= 0) {
        f->start[j] = start;
        f->given[j] = true;
    }
    return j >= 0;
}

bool formula_bounds(struct formula *f, struct text name, double low, double high,
                    struct error *error)
{
    int j = require_parameter(f, name, error);
    if (j < 0)
        return false;
    if (!(low < high))
        return error_at(error, name, "the bounds of %s are no range: %g to %g", f->name[j], low,
                        high);
    f->low[j] = low;
    f->high[j] = high;
    return true;
}

/* ---- evaluation ---- */

struct sample_at {
    const struct formula *formula;
    const double *parameter;
    double t;
    size_t i;
};

static double load(const void *context, int slot)
{
    const struct sample_at *p = context;
    const struct formula *f = p->formula;
    if (slot >= FIRST_CONSTANT)
        return f->constant[slot - FIRST_CONSTANT];
    if (slot >= FIRST_PARAMETER)
        return p->parameter[slot - FIRST_PARAMETER];
    return slot < f->columns && f->column[slot].value ? f->column[slot].value[p->i] : p->t;
}

bool formula_evaluate(void *context, const double *parameter, const double *t, size_t n,
                      double *value, double *derivative)
{
    const struct formula *f = context;
    struct sample_at at = {.formula = f, .parameter = parameter};
    struct expr_scope scope = {.context = &at, .load = load};
    int slot[CURVE_PARAMETERS];
    for (int j = 0; j < f->parameters; j++)
        slot[j] = FIRST_PARAMETER + j;
    for (size_t i = 0; i < n; i++) {
        at.t = t[i];
        at.i = i;
        value[i] = derivative ? expr_gradient(f->expr, &scope, slot, f->parameters,
                                              derivative + i * (size_t)f->parameters)
                              : expr_value(f->expr, &scope);
        if (!isfinite(value[i]))
            return false;
    }
    return true;
}

void formula_values(const struct formula *formula, const double *parameter, const double *t,
                    size_t n, double *value)
{
    struct sample_at at = {.formula = formula, .parameter = parameter};
    struct expr_scope scope = {.context = &at, .load = load};
    for (size_t i = 0; i < n; i++) {
        at.t = t[i];
        at.i = i;
        value[i] = expr_value(formula->expr, &scope);
    }
}
