/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes formulas of .ode files as formulas of typed scenes. */
#include <hooke/base/number.h>
#include "modules/xppaut/formula.h"
#include "modules/xppaut/net.h"

#include <string.h>

enum {
    DEEPEST = 4500,    /* largest depth of trees, through functions that are called */
    LONGEST = 1 << 16, /* largest size of a formula [byte] */
    TERMS = 4096       /* largest number of terms of a sum */
};

/* The loosest expression that may stand at a position without parentheses. */
enum { ANY, TERM, FACTOR, POWER, ATOM };

/* Names around an expression: arguments of a function, or (function NULL) the index of a sum. */
struct scope {
    const struct scope *outer; /* scope around a sum, or in which a function is called */
    const struct ode_symbol *function;
    /* arguments of the call, to be read in the outer scope */
    const struct ode_node *const *argument;
    double index;
};

struct ode_writing {
    const struct ode_reader *reader;
    struct buffer *output;
    int depth;    /* depth of trees so far */
    bool numbers; /* parameters are written as their values */
};

typedef const struct ode_node *node;

static bool formula_put(struct ode_writing *w, node expr, const struct scope *scope, int may);

/* Sets an error whose text consists of prefix, name and suffix. */
static bool ode_writing_fail(struct ode_writing *w, const char *prefix, struct text name,
                             const char *suffix)
{
    return ode_error(w->reader->ode->error, w->reader->line, "%s%.*s%s", prefix,
                     (int)(name.len < 60 ? name.len : 60), name.data, suffix);
}

/* Appends text. Returns false with an error if the formula becomes too long. */
static bool ode_text_put(struct ode_writing *w, const char *text)
{
    buffer_put(w->output, text_of(text));
    if (w->output->len > LONGEST)
        return ode_writing_fail(w, "the formula is too long after its functions are inserted",
                                TEXT(""), "");
    return true;
}

struct ode_symbol *ode_find(const struct ode *ode, struct text name)
{
    for (int i = 0; i < ode->symbols; i++)
        if (ode->symbol[i].kind != ODE_AUX && text_equal(ode->symbol[i].name, name))
            return &ode->symbol[i];
    return NULL;
}

/* Returns the argument that a name denotes, to be read in scope *where, or NULL if it is none. */
static node argument_named(const struct scope *scope, struct text name, const struct scope **where)
{
    while (scope && !scope->function)
        scope = scope->outer;
    for (int i = 0; scope && i < scope->function->arguments; i++)
        if (text_equal(scope->function->argument[i], name)) {
            *where = scope->outer;
            return scope->argument[i];
        }
    return NULL;
}

static const struct scope *sum_around(const struct scope *scope)
{
    while (scope && scope->function)
        scope = scope->outer;
    return scope;
}

static bool ode_number_put(struct ode_writing *w, double number);

/* Writes a parameter of a table as its value, a derived one as a formula; false if it changes. */
static bool ode_value_put(struct ode_writing *w, const struct ode_symbol *symbol, struct text name)
{
    struct ode *ode = w->reader->ode;
    if (symbol->kind == ODE_PARAM) {
        w->reader->subject->table->reads = true;
        return ode_number_put(w, symbol->value);
    }
    if (symbol->kind != ODE_DERIVED)
        return ode_writing_fail(w, "a table has '", name, "', which changes");
    const node body = ode_parse(ode->arena, symbol->line, symbol->text, ode->error);
    return body && formula_put(w, body, NULL, ATOM);
}

/* Writes the symbol called name, or its value in a table. Fails for NULL and names out of reach. */
static bool put_symbol(struct ode_writing *w, const struct ode_symbol *symbol, struct text name)
{
    const struct ode_symbol *owner = w->reader->subject;
    if (!symbol)
        return ode_writing_fail(w, "there is no '", name, "'");
    if (symbol->kind >= ODE_FUNCTION)
        return ode_writing_fail(w, "", name, " is a function");
    if (w->numbers)
        return ode_value_put(w, symbol, name);
    if (owner && owner->kind == ODE_DERIVED && symbol->kind != ODE_PARAM &&
        symbol->kind != ODE_DERIVED)
        return ode_writing_fail(w, "'", name, "' is not a parameter: it changes");
    if (owner && owner->kind == symbol->kind && owner->index <= symbol->index)
        return ode_writing_fail(
            w, "'", name,
            "' is defined later, where XPPAUT would use its value of the previous step");
    return ode_text_put(w, symbol->as);
}

/* Writes a name: the argument that it denotes, t, pi, or a symbol. */
static bool ode_name_put(struct ode_writing *w, struct text name, const struct scope *scope,
                         int may)
{
    const struct scope *where;
    const node argument = argument_named(scope, name, &where);
    if (argument)
        return formula_put(w, argument, where, may);
    if (text_is(name, "t") || text_is(name, "pi"))
        return ode_text_put(w, text_is(name, "t") ? "t" : "pi");
    return put_symbol(w, ode_find(w->reader->ode, name), name);
}

static bool ode_number_put(struct ode_writing *w, double number)
{
    char text[REAL_TEXT_SIZE];
    real_format(number, text);
    return number < 0 || (number == 0 && text[0] == '-')
               ? ode_text_put(w, "(") && ode_text_put(w, text) && ode_text_put(w, ")")
               : ode_text_put(w, text);
}

/* Evaluates numbers, indices of sums and + - * / of them. Returns false for anything else. */
static bool ode_node_value(node expr, const struct scope *scope, int depth, double *value)
{
    const struct scope *where = sum_around(scope);
    double a, b;
    if (depth > 50)
        return false;
    if (expr->kind == NODE_INDEX && where)
        *value = where->index;
    else if (expr->kind == NODE_NUMBER)
        *value = expr->number;
    else if (expr->kind == NODE_SIGN && expr->op == '-' &&
             ode_node_value(expr->argument[0], scope, depth + 1, &a))
        *value = -a;
    else if (expr->kind == NODE_NAME) {
        const node argument = argument_named(scope, expr->name, &where);
        return argument && ode_node_value(argument, where, depth + 1, value);
    } else if (expr->kind == NODE_JOIN && strchr("+-*/", expr->op) &&
               ode_node_value(expr->argument[0], scope, depth + 1, &a) &&
               ode_node_value(expr->argument[1], scope, depth + 1, &b)) {
        if (expr->op == '+')
            *value = a + b;
        else if (expr->op == '-')
            *value = a - b;
        else
            *value = expr->op == '*' ? a * b : a / b;
    } else
        return false;
    return true;
}

/* Returns true for comparisons and logical operations, whose value is 0 or 1. */
static bool is_logical(node expr)
{
    return (expr->kind == NODE_JOIN && strchr("<>=!&|", expr->op)) ||
           (expr->kind == NODE_SIGN && expr->op == '!');
}

/* Writes an expression that is 1 where the given one is not 0. */
static bool put_truth(struct ode_writing *w, node expr, const struct scope *scope)
{
    if (is_logical(expr))
        return formula_put(w, expr, scope, ATOM);
    return ode_text_put(w, "abs(sign(") && formula_put(w, expr, scope, ANY) &&
           ode_text_put(w, "))");
}

static bool put_compared(struct ode_writing *w, node expr, const struct scope *scope,
                         const char *sign)
{
    return ode_text_put(w, "(") && formula_put(w, expr->argument[0], scope, TERM) &&
           ode_text_put(w, sign) && formula_put(w, expr->argument[1], scope, TERM) &&
           ode_text_put(w, ")");
}

/* Writes logical operators as products, maxima and differences of comparisons (0 or 1). */
static bool put_logical(struct ode_writing *w, node expr, const struct scope *scope)
{
    const node *a = expr->argument;
    switch (expr->op) {
    case '<':
        return put_compared(w, expr, scope, expr->equal ? " <= " : " < ");
    case '>':
        return put_compared(w, expr, scope, expr->equal ? " >= " : " > ");
    case '&':
        return ode_text_put(w, "(") && put_truth(w, a[0], scope) && ode_text_put(w, "*") &&
               put_truth(w, a[1], scope) && ode_text_put(w, ")");
    case '|':
        return ode_text_put(w, "max(") && put_truth(w, a[0], scope) && ode_text_put(w, ", ") &&
               put_truth(w, a[1], scope) && ode_text_put(w, ")");
    case '=':
        return ode_text_put(w, "(") && put_compared(w, expr, scope, " <= ") &&
               ode_text_put(w, "*") && put_compared(w, expr, scope, " >= ") && ode_text_put(w, ")");
    default: /* '!' */
        return ode_text_put(w, "(1 - ") &&
               (expr->kind == NODE_SIGN
                    ? put_truth(w, a[0], scope)
                    : put_compared(w, expr, scope, " <= ") && ode_text_put(w, "*") &&
                          put_compared(w, expr, scope, " >= ")) &&
               ode_text_put(w, ")");
    }
}

/* Writes if(condition)then(a)else(b) as if(condition, a, b). */
static bool put_choice(struct ode_writing *w, node expr, const struct scope *scope)
{
    const node *a = expr->argument;
    return ode_text_put(w, "if(") &&
           (is_logical(a[0]) ? formula_put(w, a[0], scope, ANY)
                             : ode_text_put(w, "abs(") && formula_put(w, a[0], scope, ANY) &&
                                   ode_text_put(w, ")")) &&
           ode_text_put(w, ", ") && formula_put(w, a[1], scope, ANY) && ode_text_put(w, ", ") &&
           formula_put(w, a[2], scope, ANY) && ode_text_put(w, ")");
}

/* ---- calls ---- */

/* Functions of XPPAUT, and what they are called in typed scenes. */
static const struct builtin {
    const char *name, *as;
    int arguments;
} builtins[] = {
    {"sin", "sin", 1},   {"cos", "cos", 1},   {"tan", "tan", 1},     {"asin", "asin", 1},
    {"acos", "acos", 1}, {"atan", "atan", 1}, {"atan2", "atan2", 2}, {"sinh", "sinh", 1},
    {"cosh", "cosh", 1}, {"tanh", "tanh", 1}, {"abs", "abs", 1},     {"exp", "exp", 1},
    {"ln", "log", 1},    {"log", "log", 1},   {"log10", "log10", 1}, {"sqrt", "sqrt", 1},
    {"heav", "step", 1}, {"sign", "sign", 1}, {"flr", "floor", 1},   {"max", "max", 2},
    {"min", "min", 2},
};

/* Sets an error for a function that expressions lack, with a reason if known. Returns false. */
static bool refuse_call(struct ode_writing *w, struct text name)
{
    static const struct {
        const char *name, *why;
    } known[] = {{"delay", "scenes have no delays: "},
                 {"del_shft", "scenes have no delays: "},
                 {"ran", "scenes have no random numbers: "},
                 {"normal", "scenes have no random numbers: "},
                 {"poisson", "scenes have no random numbers: "},
                 {"hom_bcs", "scenes have no boundary conditions: "},
                 {"ishift", "scenes have no values by index: "},
                 {"set", "formulas cannot set values in scenes: "}};
    for (size_t i = 0; i < COUNT_OF(known); i++)
        if (text_is(name, known[i].name))
            return ode_writing_fail(w, known[i].why, name, "");
    return ode_writing_fail(w, "expressions have no function '", name, "'");
}

/* Writes XPPAUT's mod(a, b): fmod(), plus b if negative. A constant b > 0 needs only mod(a, b). */
static bool put_mod(struct ode_writing *w, node expr, const struct scope *scope)
{
    const node *a = expr->argument;
    double b;
    if (ode_node_value(a[1], scope, 0, &b) ? b > 0
                                           : a[1]->kind == NODE_NAME && text_is(a[1]->name, "pi"))
        return ode_text_put(w, "mod(") && formula_put(w, a[0], scope, ANY) &&
               ode_text_put(w, ", ") && formula_put(w, a[1], scope, ANY) && ode_text_put(w, ")");
    if (!ode_text_put(w, "(sign(") || !formula_put(w, a[0], scope, ANY) ||
        !ode_text_put(w, ")*mod(abs(") || !formula_put(w, a[0], scope, ANY) ||
        !ode_text_put(w, "), abs(") || !formula_put(w, a[1], scope, ANY) ||
        !ode_text_put(w, ")) + "))
        return false;
    return formula_put(w, a[1], scope, ATOM) && ode_text_put(w, "*(sign(") &&
           formula_put(w, a[0], scope, ANY) && ode_text_put(w, ")*mod(abs(") &&
           formula_put(w, a[0], scope, ANY) && ode_text_put(w, "), abs(") &&
           formula_put(w, a[1], scope, ANY) && ode_text_put(w, ")) < 0))");
}

/* Writes shift(NAME, k): the symbol defined k places after NAME, among those of NAME's kind. */
static bool put_shift(struct ode_writing *w, node expr, const struct scope *scope)
{
    const struct ode *ode = w->reader->ode;
    double shift;
    const struct ode_symbol *base = expr->arguments == 2 && expr->argument[0]->kind == NODE_NAME
                                        ? ode_find(ode, expr->argument[0]->name)
                                        : NULL;
    if (!base || !ode_node_value(expr->argument[1], scope, 0, &shift))
        return ode_writing_fail(w, "", expr->name, "() needs a name and a shift");
    for (int i = 0; i < ode->symbols; i++)
        if (ode->symbol[i].kind == base->kind && base->kind < ODE_FUNCTION &&
            ode->symbol[i].index == base->index + floor(shift))
            return put_symbol(w, &ode->symbol[i], ode->symbol[i].name);
    return ode_writing_fail(w, "there is no such index after ", base->name, "");
}

/* Writes the body of a function with the arguments of the call in it. */
static bool put_function(struct ode_writing *w, node expr, struct ode_symbol *function,
                         const struct scope *scope, int may)
{
    struct ode *ode = w->reader->ode;
    if (function->arguments != expr->arguments)
        return ode_writing_fail(w, "", expr->name,
                                "() is called with the wrong number of arguments");
    if (!function->body)
        function->body = ode_parse(ode->arena, function->line, function->text, ode->error);
    const struct scope inner = {.outer = scope, .function = function, .argument = expr->argument};
    return function->body && formula_put(w, function->body, &inner, may);
}

/* Writes the value of a table at the call's argument, or that of a network at its index. */
static bool put_places(struct ode_writing *w, node expr, struct ode_symbol *symbol,
                       const struct scope *scope, int may)
{
    double place;
    if (expr->arguments != 1)
        return ode_writing_fail(w, "", expr->name,
                                "() is called with the wrong number of arguments");
    if (symbol->kind == ODE_TABLE) {
        const node sum = ode_table_at(w->reader->ode, symbol, expr->argument[0]);
        return sum && formula_put(w, sum, scope, may);
    }
    if (!ode_node_value(expr->argument[0], scope, 0, &place))
        return ode_writing_fail(w, "the index in '", symbol->name, "' has to be a number");
    const node sum = ode_net_at(w->reader->ode, symbol, place);
    return sum && formula_put(w, sum, NULL, may);
}

static bool put_call(struct ode_writing *w, node expr, const struct scope *scope, int may)
{
    struct ode_symbol *function = ode_find(w->reader->ode, expr->name);
    if (function && function->kind == ODE_FUNCTION)
        return put_function(w, expr, function, scope, may);
    if (function && function->kind > ODE_FUNCTION)
        return put_places(w, expr, function, scope, may);
    if (text_is(expr->name, "shift"))
        return put_shift(w, expr, scope);
    if (text_is(expr->name, "mod") && expr->arguments == 2)
        return put_mod(w, expr, scope);
    const struct builtin *builtin = builtins, *end = builtins + COUNT_OF(builtins);
    while (builtin < end && !text_is(expr->name, builtin->name))
        builtin++;
    if (builtin == end)
        return refuse_call(w, expr->name);
    if (builtin->arguments != expr->arguments)
        return ode_writing_fail(w, "", expr->name,
                                "() is called with the wrong number of arguments");
    if (!ode_text_put(w, builtin->as) || !ode_text_put(w, "("))
        return false;
    for (int i = 0; i < expr->arguments; i++)
        if ((i > 0 && !ode_text_put(w, ", ")) || !formula_put(w, expr->argument[i], scope, ANY))
            return false;
    return ode_text_put(w, ")");
}

/* Writes the terms of a sum, one for each value of its index. The limits must be numbers. */
static bool put_sum(struct ode_writing *w, node expr, const struct scope *scope)
{
    double first, last;
    struct scope inner = {.outer = scope};
    if (!ode_node_value(expr->argument[0], scope, 0, &first) ||
        !ode_node_value(expr->argument[1], scope, 0, &last))
        return ode_writing_fail(w, "the limits of a sum must be numbers", TEXT(""), "");
    first = floor(first);
    last = floor(last);
    if (!(last - first < TERMS))
        return ode_writing_fail(w, "the sum has too many terms", TEXT(""), "");
    if (!(first <= last))
        return ode_text_put(w, "0");
    if (!ode_text_put(w, "("))
        return false;
    for (inner.index = first; inner.index <= last; inner.index++)
        if ((inner.index > first && !ode_text_put(w, " + ")) ||
            !formula_put(w, expr->argument[2], &inner, inner.index > first ? FACTOR : TERM))
            return false;
    return ode_text_put(w, ")");
}

/* Returns true for a + b and a - b or, unless `sum`, for a*b and a/b. */
static bool is_link(node expr, bool sum)
{
    return expr->kind == NODE_JOIN && strchr(sum ? "+-" : "*/", expr->op);
}

static bool put_link(struct ode_writing *w, node expr, const struct scope *scope)
{
    const char *sign;
    if (expr->op == '+')
        sign = " + ";
    else if (expr->op == '-')
        sign = " - ";
    else
        sign = expr->op == '*' ? "*" : "/";
    return ode_text_put(w, sign) &&
           formula_put(w, expr->argument[1], scope, is_link(expr, true) ? FACTOR : POWER);
}

/* Writes a chain of sums or products by a loop, as recursion over thousands of terms is deep. */
static bool put_chain(struct ode_writing *w, node expr, const struct scope *scope, int may)
{
    const bool sum = is_link(expr, true);
    const int own = sum ? TERM : FACTOR;
    size_t links = 0;
    node first = expr;
    for (; is_link(first, sum); first = first->argument[0])
        links++;
    node *link = arena_array(w->reader->ode->arena, links + 1, sizeof *link);
    if (!link)
        return error_memory(w->reader->ode->error);
    first = expr;
    for (size_t i = links; i > 0; first = first->argument[0])
        link[--i] = first;
    if ((may > own && !ode_text_put(w, "(")) || !formula_put(w, first, scope, own))
        return false;
    for (size_t i = 0; i < links; i++)
        if (!put_link(w, link[i], scope))
            return false;
    return may <= own || ode_text_put(w, ")");
}

static bool put_power(struct ode_writing *w, node expr, const struct scope *scope, int may)
{
    return (may <= POWER || ode_text_put(w, "(")) &&
           formula_put(w, expr->argument[0], scope, ATOM) && ode_text_put(w, "^") &&
           formula_put(w, expr->argument[1], scope, ATOM) && (may <= POWER || ode_text_put(w, ")"));
}

/* Writes an expression by its kind, in parentheses if its operator is looser than `may`. */
static bool put_kind(struct ode_writing *w, node expr, const struct scope *scope, int may)
{
    const struct scope *enclosing_sum = sum_around(scope);
    switch (expr->kind) {
    case NODE_NUMBER:
        return ode_number_put(w, expr->number);
    case NODE_INDEX:
        return enclosing_sum ? ode_number_put(w, enclosing_sum->index)
                             : ode_writing_fail(w, "i' is used outside of a sum", TEXT(""), "");
    case NODE_NAME:
        return ode_name_put(w, expr->name, scope, may);
    case NODE_CALL:
        return put_call(w, expr, scope, may);
    case NODE_IF:
        return put_choice(w, expr, scope);
    case NODE_SUM:
        return put_sum(w, expr, scope);
    case NODE_SIGN:
    case NODE_JOIN:
        break;
    }
    if (is_logical(expr))
        return put_logical(w, expr, scope);
    if (expr->kind == NODE_JOIN)
        return expr->op == '^' ? put_power(w, expr, scope, may) : put_chain(w, expr, scope, may);
    return (may <= TERM || ode_text_put(w, "(")) && ode_text_put(w, "-") &&
           formula_put(w, expr->argument[0], scope, ATOM) && (may <= TERM || ode_text_put(w, ")"));
}

/* Writes an expression. Returns false with an error. */
static bool formula_put(struct ode_writing *w, node expr, const struct scope *scope, int may)
{
    if (++w->depth > DEEPEST)
        return ode_writing_fail(w, "functions call each other, or too many are nested", TEXT(""),
                                "");
    const bool fine = put_kind(w, expr, scope, may);
    w->depth--;
    return fine;
}

bool ode_formula(const struct ode_reader *reader, struct text text, struct buffer *output)
{
    struct ode_writing w = {.reader = reader, .output = output};
    struct ode *ode = reader->ode;
    const node whole = ode_parse(ode->arena, reader->line, text, ode->error);
    if (!whole || !formula_put(&w, whole, NULL, ANY))
        return false;
    return !output->failed || error_memory(ode->error);
}

bool ode_formula_at(struct ode *ode, const struct ode_symbol *owner, const struct ode_node *whole,
                    double t, struct buffer *output)
{
    const struct ode_symbol time = {.argument = {TEXT("t")}, .arguments = 1};
    const struct ode_node number = {.kind = NODE_NUMBER, .number = t};
    const struct ode_node *const argument[] = {&number};
    const struct scope scope = {.function = &time, .argument = argument};
    const struct ode_reader reader = {ode, owner, owner->line};
    struct ode_writing w = {.reader = &reader, .output = output, .numbers = true};
    return formula_put(&w, whole, &scope, ANY) && (!output->failed || error_memory(ode->error));
}
