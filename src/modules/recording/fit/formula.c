/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas in t as curves: compiles a formula, with unknown names as its parameters, and evaluates
 * its values and derivatives. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/scene/formula.h>
#include "modules/recording/fit/formula.h"

#include <string.h>

/* Names that are met while a formula is compiled. Their slots are numbered: columns (t last),
 * parameters, known names. */
struct formula_names {
    struct formula *formula;
    const struct expr_scope *known;
    struct arena *arena;
    double *constant; /* [CONSTANTS_MAX] values of known names */
    int constants;
    /* The reason for which the compiler stopped, if it was not the text: too many parameters, or
     * memory. */
    enum { NAMES_FINE, NAMES_MANY, NAMES_MEMORY } state;
};

enum {
    /* Slots of the first parameter and of the first known name, and the number of known names at
     * most. */
    FIRST_PARAMETER = 64,
    FIRST_CONSTANT = FIRST_PARAMETER + CURVE_PARAMETERS,
    CONSTANTS_MAX = 256
};

/* Context of the compiler's scope, const for it; the names behind it grow. */
struct scope_context {
    struct formula_names *names;
};

/* Returns the index of the parameter with that name, or -1 if there is none. */
static int find_parameter(const struct formula *f, struct text name)
{
    for (int j = 0; j < f->parameters; j++)
        if (text_is(name, f->name[j]))
            return j;
    return -1;
}

/* Finds a known name, stores its present value as a constant, and sets *slot. Returns false if the
 * name is unknown or there are too many. */
static bool find_constant(struct formula_names *n, struct text name, int *slot)
{
    int known;
    if (!n->known || !n->known->find(n->known->context, name, &known) ||
        n->constants == CONSTANTS_MAX)
        return false;
    n->constant[n->constants] = n->known->load(n->known->context, known);
    *slot = FIRST_CONSTANT + n->constants++;
    return true;
}

/* Finds the slot of a name for the compiler of fit formulas: t, a column, a parameter or a
 * constant. An unknown name becomes a new parameter. Returns false if it cannot be one, with
 * n->state set if there are too many or if out of memory. New names must not contain a hyphen,
 * since b1-b2 is then a difference, nor be names of functions. */
static bool formula_name_find(const void *context, struct text name, int *slot)
{
    struct formula_names *n = ((const struct scope_context *)context)->names;
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
    if (j < 0 && (memchr(name.data, '-', name.len) || name.len > LIMIT_NAME ||
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

/* Marks the parameters in which the formula is linear together. Where this leaves a choice, the
 * first ones win. */
static void mark_linear(struct formula *f)
{
    int chosen[CURVE_PARAMETERS], count = 0;
    for (int j = 0; j < f->parameters; j++) {
        chosen[count] = FIRST_PARAMETER + j;
        f->linear[j] = expr_linear(f->expr, chosen, count + 1);
        count += f->linear[j];
    }
}

/* Compiles the text into *formula, in the arena. `known` finds constants (NULL for none), column[]
 * are further inputs; other names become parameters as they appear. *used is the length of the
 * formula in the text. Returns false with the error. */
bool formula_compile(struct text text, const struct expr_scope *known,
                     const struct formula_column *column, int columns, struct arena *arena,
                     struct formula *formula, size_t *used, struct error *error)
{
    *formula = (struct formula){.column = column, .columns = columns};
    formula->constant = arena_array(arena, CONSTANTS_MAX, sizeof(double));
    if (!formula->constant)
        return error_memory(error);
    struct formula_names names = {
        .formula = formula, .known = known, .arena = arena, .constant = formula->constant};
    struct scope_context context = {&names};
    struct expr_scope scope = {
        .context = &context, .find = formula_name_find, .offer = known ? known->offer : NULL};
    formula->expr = expr_compile(text, &scope, arena, used, error);
    if (names.state == NAMES_MEMORY)
        return error_memory(error);
    if (names.state == NAMES_MANY)
        return error_at(error, text, "the formula has more than %d parameters", CURVE_PARAMETERS);
    if (!formula->expr)
        return false;
    if (formula->parameters == 0) {
        error_at(error, (struct text){text.data, *used}, "the formula has no parameter to fit");
        return error_hint(error, "unknown names are its parameters, as in a*exp(-b*t) + c");
    }
    mark_linear(formula);
    return true;
}

/* Returns the index of a parameter, or -1 with an error and a suggestion if the formula has none of
 * that name. */
static int require_parameter(const struct formula *f, struct text name, struct error *error)
{
    int j = find_parameter(f, name);
    if (j >= 0)
        return j;
    struct suggestion suggestion = {.wanted = name};
    error_at(error, name, "the formula has no parameter '%.*s'",
             name.len < LIMIT_NAME ? (int)name.len : LIMIT_NAME, name.data);
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
        f->started[j] = true;
    }
    return j >= 0;
}

/* ---- evaluation ---- */

/* Number of all slots. */
enum { NAMES = FIRST_CONSTANT + CONSTANTS_MAX };

/* A formula translated for evaluation: input [NAMES] has the values of its names, output the value
 * and then the derivatives; frame[0] is the work space of `value`, frame[1] that of `all`. */
struct formula_program {
    struct program *value, *all; /* computes the value; the value and all derivatives */
    double *input, *output, *frame[2];
};

/* Makes the two programs of the formula: `value` computes its value only, which searches call most,
 * and `all` the value followed by the derivatives by all parameters. In derivatives a product with
 * 0 is 0 (equations_keep_limits()), so that the infinite slope of sqrt at 0 does not spoil them.
 * Memory is the arena's. Returns false with the error if out of memory or if a derivative does not
 * exist. */
static bool make_programs(struct formula *f, struct equations *e, struct arena *arena,
                          struct error *error)
{
    struct formula_program *p = f->program;
    bool *known = arena_array(arena, NAMES, sizeof *known);
    double *constant = arena_array(arena, NAMES, sizeof *constant);
    int name[CURVE_PARAMETERS];
    if (!known || !constant)
        return error_memory(error);
    for (int j = 0; j < f->parameters; j++)
        name[j] = FIRST_PARAMETER + j;
    for (int i = 0; i < CONSTANTS_MAX; i++) {
        known[FIRST_CONSTANT + i] = true;
        constant[FIRST_CONSTANT + i] = f->constant[i];
    }
    equations_keep_limits(e);
    if (!equations_add(e, f->expr, error) ||
        !equations_derive(e, 0, 1, name, f->parameters, error) ||
        !(p->value = program_create(e, 0, 1, known, constant, true, error)) ||
        !(p->all = program_create(e, 0, 1 + f->parameters, known, constant, true, error)))
        return false;
    p->input = arena_array(arena, NAMES, sizeof *p->input);
    p->output = arena_array(arena, 1 + CURVE_PARAMETERS, sizeof *p->output);
    for (int i = 0; i < 2; i++) {
        const struct program *program = i ? p->all : p->value;
        p->frame[i] = arena_array(arena, program_frame(program), sizeof **p->frame);
        if (!p->frame[i])
            return error_memory(error);
        program_prepare(program, p->frame[i]);
    }
    return (p->input && p->output) || error_memory(error);
}

/* Builds the equations of the formula and translates them. */
bool formula_ready(struct formula *f, struct arena *arena, struct error *error)
{
    f->program = arena_alloc(arena, sizeof *f->program);
    if (!f->program)
        return error_memory(error);
    struct equations *equations = equations_create(NAMES, error);
    const bool made = equations && make_programs(f, equations, arena, error);
    equations_destroy(equations);
    if (!made)
        formula_done(f);
    return made;
}

void formula_done(struct formula *f)
{
    program_destroy(f->program->value);
    program_destroy(f->program->all);
}

/* Computes value [n] and, unless NULL, derivative [n][parameters] of the formula at times t [n].
 * `context` is the struct formula. Returns false if a value is not finite or if cancelled. */
bool formula_evaluate(void *context, const double *parameter, const double *t, size_t n,
                      double *value, double *derivative)
{
    const struct formula *f = context;
    const struct formula_program *p = f->program;
    const struct program *program = derivative ? p->all : p->value;
    const size_t parameters = (size_t)f->parameters;
    memcpy(p->input + FIRST_PARAMETER, parameter, parameters * sizeof *parameter);
    for (size_t i = 0; i < n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(f->cancel))
            return false;
        for (int k = 0; k < f->columns; k++)
            p->input[k] = f->column[k].value ? f->column[k].value[i] : t[i];
        p->input[f->columns] = t[i];
        value[i] = program_eval(program, p->input, p->output, p->frame[!!derivative]);
        if (!isfinite(value[i]))
            return false;
        if (derivative)
            memcpy(derivative + i * parameters, p->output + 1, parameters * sizeof *derivative);
    }
    return true;
}
