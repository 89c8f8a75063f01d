/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas of .ode files as formulas of typed scenes: functions and sums are written out. */
#include <hooke/base/number.h>
#include "modules/xppaut/formula.h"
#include "modules/xppaut/net.h"

#include <string.h>

enum {
    DEEPEST = 4500,    /* trees in trees, by way of functions */
    LONGEST = 1 << 16, /* [byte] */
    TERMS = 4096       /* of a sum */
};

enum { ANY, TERM, FACTOR, POWER, ATOM }; /* what may stand somewhere without parentheses */

/* Where names are looked up: the arguments of a function, or the index of a sum. */
struct scope {
    const struct scope *outer; /* a sum: what is around it; a function: where it is called */
    const struct ode_symbol *function;
    const struct ode_node *const *argument;
    double index;
};

struct ode_writing {
    const struct ode_reader *reader;
    struct buffer *out;
    int depth;
    bool numbers; /* parameters as their values */
};

typedef const struct ode_node *node;

static bool formula_put(struct ode_writing *w, node of, const struct scope *scope, int may);

/* before, name, after */
static bool fail(struct ode_writing *w, const char *before, struct text name, const char *after)
{
    return ode_error(w->reader->ode->error, w->reader->line, "%s%.*s%s", before,
                     (int)(name.len < 60 ? name.len : 60), name.at, after);
}

static bool ode_text_put(struct ode_writing *w, const char *text)
{
    buffer_put(w->out, text_of(text));
    if (w->out->len > LONGEST)
        return fail(w, "with its functions written out the formula is too long", TEXT(""), "");
    return true;
}

/* ---- names ---- */

struct ode_symbol *ode_find(const struct ode *ode, struct text name)
{
    for (int i = 0; i < ode->symbols; i++)
        if (ode->symbol[i].kind != ODE_AUX && text_equal(ode->symbol[i].name, name))
            return &ode->symbol[i];
    return NULL;
}

/* The argument that a name is; *where: what it is written in. Returns NULL if there is none. */
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

/* A parameter, or what follows from those before it, as a number or a formula of them. */
static bool ode_value_put(struct ode_writing *w, const struct ode_symbol *symbol, struct text name)
{
    struct ode *ode = w->reader->ode;
    if (symbol->kind == ODE_PARAM) {
        w->reader->of->table->reads = true;
        return ode_number_put(w, symbol->value);
    }
    if (symbol->kind != ODE_DERIVED)
        return fail(w, "a table has '", name, "', which changes");
    const node body = ode_parse(ode->arena, symbol->line, symbol->text, ode->error);
    return body && formula_put(w, body, NULL, ATOM);
}

static bool put_symbol(struct ode_writing *w, const struct ode_symbol *symbol, struct text name)
{
    const struct ode_symbol *of = w->reader->of;
    if (!symbol)
        return fail(w, "there is no '", name, "'");
    if (symbol->kind >= ODE_FUNCTION)
        return fail(w, "", name, " is a function");
    if (w->numbers)
        return ode_value_put(w, symbol, name);
    if (of && of->kind == ODE_DERIVED && symbol->kind != ODE_PARAM && symbol->kind != ODE_DERIVED)
        return fail(w, "'", name, "' is no parameter: it changes");
    if (of && of->kind == symbol->kind && of->index <= symbol->index)
        return fail(w, "'", name, "' comes later: XPPAUT takes its value of the step before");
    return ode_text_put(w, symbol->as);
}

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

/* ---- numbers ---- */

static bool ode_number_put(struct ode_writing *w, double number)
{
    char text[REAL_TEXT_SIZE];
    real_format(number, text);
    return number < 0 || (number == 0 && text[0] == '-')
               ? ode_text_put(w, "(") && ode_text_put(w, text) && ode_text_put(w, ")")
               : ode_text_put(w, text);
}

/* Of what is made of numbers and of indices only. */
static bool ode_node_value(node of, const struct scope *scope, int depth, double *value)
{
    const struct scope *where = sum_around(scope);
    double a, b;
    if (depth > 50)
        return false;
    if (of->kind == NODE_INDEX && where)
        *value = where->index;
    else if (of->kind == NODE_NUMBER)
        *value = of->number;
    else if (of->kind == NODE_SIGN && of->op == '-' &&
             ode_node_value(of->argument[0], scope, depth + 1, &a))
        *value = -a;
    else if (of->kind == NODE_NAME) {
        const node argument = argument_named(scope, of->name, &where);
        return argument && ode_node_value(argument, where, depth + 1, value);
    } else if (of->kind == NODE_JOIN && strchr("+-*/", of->op) &&
               ode_node_value(of->argument[0], scope, depth + 1, &a) &&
               ode_node_value(of->argument[1], scope, depth + 1, &b))
        *value = of->op == '+' ? a + b : of->op == '-' ? a - b : of->op == '*' ? a * b : a / b;
    else
        return false;
    return true;
}

/* ---- logic ---- */

static bool is_logical(node of)
{
    return (of->kind == NODE_JOIN && strchr("<>=!&|", of->op)) ||
           (of->kind == NODE_SIGN && of->op == '!');
}

/* 1 where it is not 0. */
static bool put_truth(struct ode_writing *w, node of, const struct scope *scope)
{
    if (is_logical(of))
        return formula_put(w, of, scope, ATOM);
    return ode_text_put(w, "abs(sign(") && formula_put(w, of, scope, ANY) && ode_text_put(w, "))");
}

static bool put_compared(struct ode_writing *w, node of, const struct scope *scope,
                         const char *sign)
{
    return ode_text_put(w, "(") && formula_put(w, of->argument[0], scope, TERM) &&
           ode_text_put(w, sign) && formula_put(w, of->argument[1], scope, TERM) &&
           ode_text_put(w, ")");
}

static bool put_logical(struct ode_writing *w, node of, const struct scope *scope)
{
    const node *a = of->argument;
    switch (of->op) {
    case '<':
        return put_compared(w, of, scope, of->equal ? " <= " : " < ");
    case '>':
        return put_compared(w, of, scope, of->equal ? " >= " : " > ");
    case '&':
        return ode_text_put(w, "(") && put_truth(w, a[0], scope) && ode_text_put(w, "*") &&
               put_truth(w, a[1], scope) && ode_text_put(w, ")");
    case '|':
        return ode_text_put(w, "max(") && put_truth(w, a[0], scope) && ode_text_put(w, ", ") &&
               put_truth(w, a[1], scope) && ode_text_put(w, ")");
    case '=':
        return ode_text_put(w, "(") && put_compared(w, of, scope, " <= ") && ode_text_put(w, "*") &&
               put_compared(w, of, scope, " >= ") && ode_text_put(w, ")");
    default: /* '!' */
        return ode_text_put(w, "(1 - ") &&
               (of->kind == NODE_SIGN
                    ? put_truth(w, a[0], scope)
                    : put_compared(w, of, scope, " <= ") && ode_text_put(w, "*") &&
                          put_compared(w, of, scope, " >= ")) &&
               ode_text_put(w, ")");
    }
}

static bool put_choice(struct ode_writing *w, node of, const struct scope *scope)
{
    const node *a = of->argument;
    return ode_text_put(w, "if(") &&
           (is_logical(a[0]) ? formula_put(w, a[0], scope, ANY)
                             : ode_text_put(w, "abs(") && formula_put(w, a[0], scope, ANY) &&
                                   ode_text_put(w, ")")) &&
           ode_text_put(w, ", ") && formula_put(w, a[1], scope, ANY) && ode_text_put(w, ", ") &&
           formula_put(w, a[2], scope, ANY) && ode_text_put(w, ")");
}

/* ---- calls ---- */

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

static bool refuse_call(struct ode_writing *w, struct text name)
{
    static const struct {
        const char *name, *why;
    } known[] = {{"delay", "delays are not for scenes: "},
                 {"del_shft", "delays are not for scenes: "},
                 {"ran", "random numbers are not for scenes: "},
                 {"normal", "random numbers are not for scenes: "},
                 {"poisson", "random numbers are not for scenes: "},
                 {"hom_bcs", "boundary conditions are not for scenes: "},
                 {"ishift", "values by place are not for scenes: "},
                 {"set", "formulas do not set anything in scenes: "}};
    for (size_t i = 0; i < COUNT_OF(known); i++)
        if (text_is(name, known[i].name))
            return fail(w, known[i].why, name, "");
    return fail(w, "expressions have no function '", name, "'");
}

/* XPPAUT's remainder is that of fmod(), plus b where it is below 0. */
static bool put_mod(struct ode_writing *w, node of, const struct scope *scope)
{
    const node *a = of->argument;
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

/* The quantity so many places behind another one. */
static bool put_shift(struct ode_writing *w, node of, const struct scope *scope)
{
    const struct ode *ode = w->reader->ode;
    double by;
    const struct ode_symbol *from = of->arguments == 2 && of->argument[0]->kind == NODE_NAME
                                        ? ode_find(ode, of->argument[0]->name)
                                        : NULL;
    if (!from || !ode_node_value(of->argument[1], scope, 0, &by))
        return fail(w, "", of->name, "() takes a name and a number of places");
    for (int i = 0; i < ode->symbols; i++)
        if (ode->symbol[i].kind == from->kind && from->kind < ODE_FUNCTION &&
            ode->symbol[i].index == from->index + floor(by))
            return put_symbol(w, &ode->symbol[i], ode->symbol[i].name);
    return fail(w, "there is nothing so many places behind ", from->name, "");
}

/* Its text as a function of what it is called with. */
static bool put_function(struct ode_writing *w, node of, struct ode_symbol *function,
                         const struct scope *scope, int may)
{
    struct ode *ode = w->reader->ode;
    if (function->arguments != of->arguments)
        return fail(w, "", of->name, "() is called with another number of arguments");
    if (!function->body)
        function->body = ode_parse(ode->arena, function->line, function->text, ode->error);
    const struct scope inner = {.outer = scope, .function = function, .argument = of->argument};
    return function->body && formula_put(w, function->body, &inner, may);
}

/* A table or a network, written out. */
static bool put_places(struct ode_writing *w, node of, struct ode_symbol *symbol,
                       const struct scope *scope, int may)
{
    double place;
    if (of->arguments != 1)
        return fail(w, "", of->name, "() is called with another number of arguments");
    if (symbol->kind == ODE_TABLE) {
        const node sum = ode_table_at(w->reader->ode, symbol, of->argument[0]);
        return sum && formula_put(w, sum, scope, may);
    }
    if (!ode_node_value(of->argument[0], scope, 0, &place))
        return fail(w, "the place in '", symbol->name, "' has to be a number");
    const node sum = ode_net_at(w->reader->ode, symbol, place);
    return sum && formula_put(w, sum, NULL, may);
}

static bool put_call(struct ode_writing *w, node of, const struct scope *scope, int may)
{
    struct ode_symbol *function = ode_find(w->reader->ode, of->name);
    if (function && function->kind == ODE_FUNCTION)
        return put_function(w, of, function, scope, may);
    if (function && function->kind > ODE_FUNCTION)
        return put_places(w, of, function, scope, may);
    if (text_is(of->name, "shift"))
        return put_shift(w, of, scope);
    if (text_is(of->name, "mod") && of->arguments == 2)
        return put_mod(w, of, scope);
    const struct builtin *builtin = builtins, *end = builtins + COUNT_OF(builtins);
    while (builtin < end && !text_is(of->name, builtin->name))
        builtin++;
    if (builtin == end)
        return refuse_call(w, of->name);
    if (builtin->arguments != of->arguments)
        return fail(w, "", of->name, "() is called with another number of arguments");
    if (!ode_text_put(w, builtin->as) || !ode_text_put(w, "("))
        return false;
    for (int i = 0; i < of->arguments; i++)
        if ((i > 0 && !ode_text_put(w, ", ")) || !formula_put(w, of->argument[i], scope, ANY))
            return false;
    return ode_text_put(w, ")");
}

static bool put_sum(struct ode_writing *w, node of, const struct scope *scope)
{
    double from, to;
    struct scope inner = {.outer = scope};
    if (!ode_node_value(of->argument[0], scope, 0, &from) ||
        !ode_node_value(of->argument[1], scope, 0, &to))
        return fail(w, "the ends of a sum have to be numbers", TEXT(""), "");
    from = floor(from);
    to = floor(to);
    if (!(to - from < TERMS))
        return fail(w, "a sum of too many terms", TEXT(""), "");
    if (!(from <= to))
        return ode_text_put(w, "0");
    if (!ode_text_put(w, "("))
        return false;
    for (inner.index = from; inner.index <= to; inner.index++)
        if ((inner.index > from && !ode_text_put(w, " + ")) ||
            !formula_put(w, of->argument[2], &inner, inner.index > from ? FACTOR : TERM))
            return false;
    return ode_text_put(w, ")");
}

/* ---- operations ---- */

/* Returns true if the node continues a chain a + b - c or a*b/c. */
static bool is_link(node of, bool sum)
{
    return of->kind == NODE_JOIN && strchr(sum ? "+-" : "*/", of->op);
}

static bool put_link(struct ode_writing *w, node of, const struct scope *scope)
{
    const char *sign = of->op == '+' ? " + " : of->op == '-' ? " - " : of->op == '*' ? "*" : "/";
    return ode_text_put(w, sign) &&
           formula_put(w, of->argument[1], scope, is_link(of, true) ? FACTOR : POWER);
}

/* A chain without nesting: it may have thousands of links. */
static bool put_chain(struct ode_writing *w, node of, const struct scope *scope, int may)
{
    const bool sum = is_link(of, true);
    const int own = sum ? TERM : FACTOR;
    size_t links = 0;
    node first = of;
    for (; is_link(first, sum); first = first->argument[0])
        links++;
    node *link = arena_array(w->reader->ode->arena, links + 1, sizeof *link);
    if (!link)
        return error_memory(w->reader->ode->error);
    first = of;
    for (size_t i = links; i > 0; first = first->argument[0])
        link[--i] = first;
    if ((may > own && !ode_text_put(w, "(")) || !formula_put(w, first, scope, own))
        return false;
    for (size_t i = 0; i < links; i++)
        if (!put_link(w, link[i], scope))
            return false;
    return may <= own || ode_text_put(w, ")");
}

static bool put_power(struct ode_writing *w, node of, const struct scope *scope, int may)
{
    return (may <= POWER || ode_text_put(w, "(")) && formula_put(w, of->argument[0], scope, ATOM) &&
           ode_text_put(w, "^") && formula_put(w, of->argument[1], scope, ATOM) &&
           (may <= POWER || ode_text_put(w, ")"));
}

static bool put_kind(struct ode_writing *w, node of, const struct scope *scope, int may)
{
    const struct scope *around = sum_around(scope);
    switch (of->kind) {
    case NODE_NUMBER:
        return ode_number_put(w, of->number);
    case NODE_INDEX:
        return around ? ode_number_put(w, around->index)
                      : fail(w, "i' outside of a sum", TEXT(""), "");
    case NODE_NAME:
        return ode_name_put(w, of->name, scope, may);
    case NODE_CALL:
        return put_call(w, of, scope, may);
    case NODE_IF:
        return put_choice(w, of, scope);
    case NODE_SUM:
        return put_sum(w, of, scope);
    case NODE_SIGN:
    case NODE_JOIN:
        break;
    }
    if (is_logical(of))
        return put_logical(w, of, scope);
    if (of->kind == NODE_JOIN)
        return of->op == '^' ? put_power(w, of, scope, may) : put_chain(w, of, scope, may);
    return (may <= TERM || ode_text_put(w, "(")) && ode_text_put(w, "-") &&
           formula_put(w, of->argument[0], scope, ATOM) && (may <= TERM || ode_text_put(w, ")"));
}

static bool formula_put(struct ode_writing *w, node of, const struct scope *scope, int may)
{
    if (++w->depth > DEEPEST)
        return fail(w, "functions that call each other, or too many of them", TEXT(""), "");
    const bool fine = put_kind(w, of, scope, may);
    w->depth--;
    return fine;
}

bool ode_formula(const struct ode_reader *reader, struct text text, struct buffer *out)
{
    struct ode_writing w = {.reader = reader, .out = out};
    struct ode *ode = reader->ode;
    const node whole = ode_parse(ode->arena, reader->line, text, ode->error);
    if (!whole || !formula_put(&w, whole, NULL, ANY))
        return false;
    return !out->failed || error_memory(ode->error);
}

bool ode_formula_at(struct ode *ode, const struct ode_symbol *of, const struct ode_node *whole,
                    double t, struct buffer *out)
{
    const struct ode_symbol time = {.argument = {TEXT("t")}, .arguments = 1};
    const struct ode_node number = {.kind = NODE_NUMBER, .number = t};
    const struct ode_node *const argument[] = {&number};
    const struct scope scope = {.function = &time, .argument = argument};
    const struct ode_reader reader = {ode, of, of->line};
    struct ode_writing w = {.reader = &reader, .out = out, .numbers = true};
    return formula_put(&w, whole, &scope, ANY) && (!out->failed || error_memory(ode->error));
}
