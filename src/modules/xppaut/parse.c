/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parses formulas by XPPAUT's grammar: + - | bind loosest, then * / & and signs, then ^ and the
 * comparisons; all are left-associative. A sign may only stand at the begin of a formula or an
 * argument and after '('. */
#include <hooke/base/number.h>
#include <string.h>

#include "modules/xppaut/formula.h"

/* Largest depth of parentheses, and largest number of nodes. */
enum { DEEPEST = 60, NODES = LIMIT_EXPR_SIZE };

/* State of parsing. */
struct ode_parser {
    struct arena *arena;
    struct error *error;
    struct text text;
    size_t position;
    int line, depth, nodes;
};

typedef const struct ode_node *node;

static node sum_parse(struct ode_parser *p);

/* Sets an error that shows the text at the present position. Returns NULL. */
static node parser_fail(struct ode_parser *p, const char *what)
{
    const struct text rest = {p->text.data + p->position, p->text.len - p->position};
    const struct text all = p->text;
    if (rest.len > 0)
        ode_error(p->error, p->line, "%s at '%.*s'", what, (int)(rest.len < 60 ? rest.len : 60),
                  rest.data);
    else
        ode_error(p->error, p->line, "%s at the end of '%.*s'", what,
                  (int)(all.len < 60 ? all.len : 60), all.data);
    return NULL;
}

/* Makes a node of the given kind with room for that many arguments, which the caller fills in.
 * Returns NULL with an error if out of memory, or if the formula has too many nodes. */
static struct ode_node *parser_node_make(struct ode_parser *p, enum ode_node_kind kind,
                                         int arguments)
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

/* Makes a node with two arguments. Returns NULL if one of them is NULL, or with an error. */
static node ode_node_join(struct ode_parser *p, enum ode_node_kind kind, char op, bool equal,
                          node a, node b)
{
    struct ode_node *made = a && b ? parser_node_make(p, kind, 2) : NULL;
    if (!made)
        return NULL;
    made->op = op;
    made->equal = equal;
    made->argument[0] = a;
    made->argument[1] = b;
    return made;
}

/* Makes a node for a sign or `not`. Returns NULL if the operand is NULL, or with an error. */
static node sign_node_make(struct ode_parser *p, char op, node operand)
{
    struct ode_node *made = operand ? parser_node_make(p, NODE_SIGN, 1) : NULL;
    if (made) {
        made->op = op;
        made->argument[0] = operand;
    }
    return made;
}

/* Skips blanks and returns the next character, or 0 at the end. */
static char parser_peek(struct ode_parser *p)
{
    while (p->position < p->text.len &&
           (p->text.data[p->position] == ' ' || p->text.data[p->position] == '\r'))
        p->position++;
    return p->position < p->text.len ? p->text.data[p->position] : '\0';
}

/* Skips the word if it comes next, and returns true then. */
static bool ode_word_take(struct ode_parser *p, const char *word)
{
    parser_peek(p);
    const struct text rest = {p->text.data + p->position, p->text.len - p->position};
    if (!text_starts(rest, text_of(word)))
        return false;
    p->position += strlen(word);
    return true;
}

static bool is_ode_letter(char c)
{
    return (c >= 'a' && c <= 'z') || c == '_';
}

/* Parses "(" sum ")". Returns NULL with an error. */
static node in_parentheses(struct ode_parser *p)
{
    if (!ode_word_take(p, "("))
        return parser_fail(p, "a '(' is missing");
    const node inside = sum_parse(p);
    if (inside && !ode_word_take(p, ")"))
        return parser_fail(p, "a ')' is missing");
    return inside;
}

/* Parses what follows `if`: (condition)then(a)else(b). Returns NULL with an error. */
static node parse_choice(struct ode_parser *p)
{
    const node condition = in_parentheses(p);
    if (condition && !ode_word_take(p, "then"))
        return parser_fail(p, "'then' is missing");
    const node yes = condition ? in_parentheses(p) : NULL;
    if (yes && !ode_word_take(p, "else"))
        return parser_fail(p, "'else' is missing");
    const node no = yes ? in_parentheses(p) : NULL;
    struct ode_node *made = no ? parser_node_make(p, NODE_IF, 3) : NULL;
    if (made) {
        made->argument[0] = condition;
        made->argument[1] = yes;
        made->argument[2] = no;
    }
    return made;
}

/* Parses the arguments of a call in parentheses, of which the name was read. Returns NULL with an
 * error. */
static struct ode_node *call_parse(struct ode_parser *p, struct text name)
{
    node argument[ODE_ARGUMENTS];
    int count = 0;
    ode_word_take(p, "(");
    do {
        if (count == ODE_ARGUMENTS) {
            parser_fail(p, "too many arguments");
            return NULL;
        }
        if (!(argument[count++] = sum_parse(p)))
            return NULL;
    } while (ode_word_take(p, ","));
    if (!ode_word_take(p, ")")) {
        parser_fail(p, "a ')' is missing");
        return NULL;
    }
    struct ode_node *made = parser_node_make(p, NODE_CALL, count);
    if (made) {
        made->name = name;
        memcpy(made->argument, argument, (size_t)count * sizeof *argument);
    }
    return made;
}

/* Parses a sum, sum(from,to)of(formula), of which the name was read. Returns NULL with an error. */
static node parse_series(struct ode_parser *p, struct text name)
{
    struct ode_node *ends = call_parse(p, name);
    if (!ends)
        return NULL;
    if (ends->arguments != 2 || !ode_word_take(p, "of"))
        return parser_fail(p, "write a sum as sum(from,to)of(formula)");
    const node summand = in_parentheses(p);
    struct ode_node *made = summand ? parser_node_make(p, NODE_SUM, 3) : NULL;
    if (made) {
        made->argument[0] = ends->argument[0];
        made->argument[1] = ends->argument[1];
        made->argument[2] = summand;
    }
    return made;
}

/* Parses an expression that begins with a name: i' (the index of a sum), if()then()else(),
 * sum()of(), a call or a name. Returns NULL with an error. */
static node word_parse(struct ode_parser *p)
{
    const size_t begin = p->position;
    while (p->position < p->text.len &&
           (is_ode_letter(p->text.data[p->position]) || is_digit_char(p->text.data[p->position])))
        p->position++;
    const struct text name = {p->text.data + begin, p->position - begin};
    const char next = p->position < p->text.len ? p->text.data[p->position] : '\0';
    if (text_is(name, "i") && next == '\'') {
        p->position++;
        return parser_node_make(p, NODE_INDEX, 0);
    }
    if (next == '\'')
        return parser_fail(p, "a derivative can be only on the left side");
    if (text_is(name, "if"))
        return parse_choice(p);
    if (text_is(name, "not"))
        return parser_fail(p, "'not' needs an operator before it");
    if (text_is(name, "int") && (next == '{' || next == '['))
        return parser_fail(p, "scenes have no integral equations (Volterra):");
    if (parser_peek(p) == '(')
        return text_is(name, "sum") ? parse_series(p, name) : call_parse(p, name);
    struct ode_node *made = parser_node_make(p, NODE_NAME, 0);
    if (made)
        made->name = name;
    return made;
}

/* Parses a number, a name, a call or a formula in parentheses. Returns NULL with an error. */
static node atom_parse(struct ode_parser *p)
{
    const char next = parser_peek(p);
    if (is_digit_char(next) || next == '.') {
        double value;
        size_t used;
        const struct text rest = {p->text.data + p->position, p->text.len - p->position};
        if (real_scan(rest, '.', &value, &used) == REAL_OVERFLOW || used == 0)
            return parser_fail(p, "not a number");
        p->position += used;
        struct ode_node *made = parser_node_make(p, NODE_NUMBER, 0);
        if (made)
            made->number = value;
        return made;
    }
    if (is_ode_letter(next))
        return word_parse(p);
    if (next == '(')
        return in_parentheses(p);
    return parser_fail(p, "a number or a name is missing");
}

/* Parses a chain of powers and comparisons, which have the same precedence in XPPAUT and group from
 * the left. Returns NULL with an error. */
static node parse_power(struct ode_parser *p)
{
    static const struct {
        const char *sign;
        char op;
        bool equal;
    } operators[] = {{"**", '^', false}, {"^", '^', false},  {"<=", '<', true}, {">=", '>', true},
                     {"==", '=', false}, {"!=", '!', false}, {"<", '<', false}, {">", '>', false}};
    node left = atom_parse(p);
    for (size_t i = 0; left && i < COUNT_OF(operators); i++) {
        if (!ode_word_take(p, operators[i].sign))
            continue;
        left =
            ode_node_join(p, NODE_JOIN, operators[i].op, operators[i].equal, left, atom_parse(p));
        i = (size_t)-1;
    }
    return left;
}

/* Skips the word `not` if it comes next, and returns true then. */
static bool takes_not(struct ode_parser *p)
{
    parser_peek(p);
    const struct text rest = {p->text.data + p->position, p->text.len - p->position};
    const bool is =
        text_starts(rest, TEXT("not")) &&
        (rest.len == 3 || !(is_ode_letter(rest.data[3]) || is_digit_char(rest.data[3])));
    p->position += is ? 3 : 0;
    return is;
}

/* Parses a power, which `not` may precede. Returns NULL with an error. */
static node parse_factor(struct ode_parser *p)
{
    return takes_not(p) ? sign_node_make(p, '!', parse_power(p)) : parse_power(p);
}

/* Parses a chain of *, / and &. If `first` is true, this is the first product of a sum and can
 * begin with a minus sign. Returns NULL with an error. */
static node parse_product(struct ode_parser *p, bool first)
{
    node left =
        first && ode_word_take(p, "-") ? sign_node_make(p, '-', parse_factor(p)) : parse_factor(p);
    while (left) {
        const char op = parser_peek(p);
        const bool doubled = p->position + 1 < p->text.len && p->text.data[p->position + 1] == '*';
        if (op != '/' && op != '&' && (op != '*' || doubled))
            break;
        p->position++;
        left = ode_node_join(p, NODE_JOIN, op, false, left, parse_factor(p));
    }
    return left;
}

/* Parses a chain of +, - and |, the operators of lowest precedence. Returns NULL with an error. */
static node sum_parse(struct ode_parser *p)
{
    if (++p->depth > DEEPEST)
        return parser_fail(p, "nested too deeply");
    node left = parse_product(p, true);
    while (left) {
        const char op = parser_peek(p);
        if (op != '+' && op != '-' && op != '|')
            break;
        p->position++;
        left = ode_node_join(p, NODE_JOIN, op, false, left, parse_product(p, false));
    }
    p->depth--;
    return left;
}

/* Parses a formula that stands in that line of the file. Returns NULL with an error. */
const struct ode_node *ode_parse(struct arena *arena, int line, struct text text,
                                 struct error *error)
{
    struct ode_parser p = {.arena = arena, .error = error, .text = text_trim(text), .line = line};
    const node whole = sum_parse(&p);
    if (whole && parser_peek(&p) != '\0')
        return parser_fail(&p, "there is more after the formula,");
    return whole;
}
