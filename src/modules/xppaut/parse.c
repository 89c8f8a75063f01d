/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * XPPAUT's grammar: + - | bind loosest, then * / & and signs, then ^ and the comparisons; all from
 * the left. A sign stands at the start of a formula, of an argument and behind '(' only.
 */
#include <hooke/base/number.h>
#include <string.h>

#include "modules/xppaut/formula.h"

enum { DEEPEST = 60, NODES = LIMIT_EXPR_SIZE };

struct ode_parser {
    struct arena *arena;
    struct error *error;
    struct text text;
    size_t at;
    int line, depth, nodes;
};

typedef const struct ode_node *node;

static node sum(struct ode_parser *p);

static node fail(struct ode_parser *p, const char *what)
{
    const struct text rest = {p->text.at + p->at, p->text.len - p->at};
    const struct text all = p->text;
    if (rest.len > 0)
        ode_error(p->error, p->line, "%s at '%.*s'", what, (int)(rest.len < 60 ? rest.len : 60),
                  rest.at);
    else
        ode_error(p->error, p->line, "%s at the end of '%.*s'", what,
                  (int)(all.len < 60 ? all.len : 60), all.at);
    return NULL;
}

static struct ode_node *make(struct ode_parser *p, enum ode_node_kind kind, int arguments)
{
    if (++p->nodes > NODES) {
        ode_error(p->error, p->line, "the formula has more than %d operations", NODES);
        return NULL;
    }
    struct ode_node *made = arena_alloc(p->arena, sizeof *made);
    node *argument = made && arguments > 0
                         ? arena_array(p->arena, (size_t)arguments, sizeof *made->argument)
                         : NULL;
    if (!made || (arguments > 0 && !argument)) {
        error_memory(p->error);
        return NULL;
    }
    *made = (struct ode_node){.kind = kind, .argument = argument, .arguments = arguments};
    return made;
}

static node ode_node_join(struct ode_parser *p, enum ode_node_kind kind, char op, bool equal,
                          node a, node b)
{
    struct ode_node *made = a && b ? make(p, kind, 2) : NULL;
    if (!made)
        return NULL;
    made->op = op;
    made->equal = equal;
    made->argument[0] = a;
    made->argument[1] = b;
    return made;
}

static node sign(struct ode_parser *p, char op, node of)
{
    struct ode_node *made = of ? make(p, NODE_SIGN, 1) : NULL;
    if (made) {
        made->op = op;
        made->argument[0] = of;
    }
    return made;
}

static char peek(struct ode_parser *p)
{
    while (p->at < p->text.len && (p->text.at[p->at] == ' ' || p->text.at[p->at] == '\r'))
        p->at++;
    return p->at < p->text.len ? p->text.at[p->at] : '\0';
}

static bool ode_word_take(struct ode_parser *p, const char *word)
{
    peek(p);
    const struct text rest = {p->text.at + p->at, p->text.len - p->at};
    if (!text_starts(rest, text_of(word)))
        return false;
    p->at += strlen(word);
    return true;
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || c == '_';
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* "(" sum ")" */
static node in_parentheses(struct ode_parser *p)
{
    if (!ode_word_take(p, "("))
        return fail(p, "a '(' is missing");
    const node inside = sum(p);
    if (inside && !ode_word_take(p, ")"))
        return fail(p, "a ')' is missing");
    return inside;
}

static node choice(struct ode_parser *p)
{
    const node condition = in_parentheses(p);
    if (condition && !ode_word_take(p, "then"))
        return fail(p, "'then' is missing");
    const node yes = condition ? in_parentheses(p) : NULL;
    if (yes && !ode_word_take(p, "else"))
        return fail(p, "'else' is missing");
    const node no = yes ? in_parentheses(p) : NULL;
    struct ode_node *made = no ? make(p, NODE_IF, 3) : NULL;
    if (made) {
        made->argument[0] = condition;
        made->argument[1] = yes;
        made->argument[2] = no;
    }
    return made;
}

/* What stands in the parentheses of a call. */
static struct ode_node *call(struct ode_parser *p, struct text name)
{
    node argument[ODE_ARGUMENTS];
    int count = 0;
    ode_word_take(p, "(");
    do {
        if (count == ODE_ARGUMENTS) {
            fail(p, "too many arguments");
            return NULL;
        }
        if (!(argument[count++] = sum(p)))
            return NULL;
    } while (ode_word_take(p, ","));
    if (!ode_word_take(p, ")")) {
        fail(p, "a ')' is missing");
        return NULL;
    }
    struct ode_node *made = make(p, NODE_CALL, count);
    if (made) {
        made->name = name;
        memcpy(made->argument, argument, (size_t)count * sizeof *argument);
    }
    return made;
}

static node series(struct ode_parser *p, struct text name)
{
    struct ode_node *ends = call(p, name);
    if (!ends)
        return NULL;
    if (ends->arguments != 2 || !ode_word_take(p, "of"))
        return fail(p, "a sum is sum(from,to)of(formula)");
    const node of = in_parentheses(p);
    struct ode_node *made = of ? make(p, NODE_SUM, 3) : NULL;
    if (made) {
        made->argument[0] = ends->argument[0];
        made->argument[1] = ends->argument[1];
        made->argument[2] = of;
    }
    return made;
}

static node word(struct ode_parser *p)
{
    const size_t from = p->at;
    while (p->at < p->text.len && (is_letter(p->text.at[p->at]) || is_digit(p->text.at[p->at])))
        p->at++;
    const struct text name = {p->text.at + from, p->at - from};
    const char next = p->at < p->text.len ? p->text.at[p->at] : '\0';
    if (text_is(name, "i") && next == '\'') {
        p->at++;
        return make(p, NODE_INDEX, 0);
    }
    if (next == '\'')
        return fail(p, "a derivative stands on the left only");
    if (text_is(name, "if"))
        return choice(p);
    if (text_is(name, "not"))
        return fail(p, "'not' needs an operator before it");
    if (text_is(name, "int") && (next == '{' || next == '['))
        return fail(p, "integral equations (Volterra) are not for scenes:");
    if (peek(p) == '(')
        return text_is(name, "sum") ? series(p, name) : call(p, name);
    struct ode_node *made = make(p, NODE_NAME, 0);
    if (made)
        made->name = name;
    return made;
}

static node atom(struct ode_parser *p)
{
    const char next = peek(p);
    if (is_digit(next) || next == '.') {
        double value;
        size_t used;
        const struct text rest = {p->text.at + p->at, p->text.len - p->at};
        if (real_scan(rest, '.', &value, &used) == REAL_OVERFLOW || used == 0)
            return fail(p, "no number");
        p->at += used;
        struct ode_node *made = make(p, NODE_NUMBER, 0);
        if (made)
            made->number = value;
        return made;
    }
    if (is_letter(next))
        return word(p);
    if (next == '(')
        return in_parentheses(p);
    return fail(p, "a number or a name is missing");
}

static node parse_power(struct ode_parser *p)
{
    static const struct {
        const char *sign;
        char op;
        bool equal;
    } operators[] = {{"**", '^', false}, {"^", '^', false},  {"<=", '<', true}, {">=", '>', true},
                     {"==", '=', false}, {"!=", '!', false}, {"<", '<', false}, {">", '>', false}};
    node left = atom(p);
    for (size_t i = 0; left && i < COUNT_OF(operators); i++) {
        if (!ode_word_take(p, operators[i].sign))
            continue;
        left = ode_node_join(p, NODE_JOIN, operators[i].op, operators[i].equal, left, atom(p));
        i = (size_t)-1;
    }
    return left;
}

/* Reads the word `not` and returns true if it comes next. */
static bool takes_not(struct ode_parser *p)
{
    peek(p);
    const struct text rest = {p->text.at + p->at, p->text.len - p->at};
    const bool is = text_starts(rest, TEXT("not")) &&
                    (rest.len == 3 || !(is_letter(rest.at[3]) || is_digit(rest.at[3])));
    p->at += is ? 3 : 0;
    return is;
}

static node factor(struct ode_parser *p)
{
    return takes_not(p) ? sign(p, '!', parse_power(p)) : parse_power(p);
}

static node product(struct ode_parser *p, bool first)
{
    node left = first && ode_word_take(p, "-") ? sign(p, '-', factor(p)) : factor(p);
    while (left) {
        const char op = peek(p);
        const bool doubled = p->at + 1 < p->text.len && p->text.at[p->at + 1] == '*';
        if (op != '/' && op != '&' && (op != '*' || doubled))
            break;
        p->at++;
        left = ode_node_join(p, NODE_JOIN, op, false, left, factor(p));
    }
    return left;
}

static node sum(struct ode_parser *p)
{
    if (++p->depth > DEEPEST)
        return fail(p, "nested too deeply");
    node left = product(p, true);
    while (left) {
        const char op = peek(p);
        if (op != '+' && op != '-' && op != '|')
            break;
        p->at++;
        left = ode_node_join(p, NODE_JOIN, op, false, left, product(p, false));
    }
    p->depth--;
    return left;
}

const struct ode_node *ode_parse(struct arena *arena, int line, struct text text,
                                 struct error *error)
{
    struct ode_parser p = {.arena = arena, .error = error, .text = text_trim(text), .line = line};
    const node whole = sum(&p);
    if (whole && peek(&p) != '\0')
        return fail(&p, "the formula ends");
    return whole;
}
