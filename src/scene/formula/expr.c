/* SPDX-License-Identifier: GPL-3.0-or-later */
/* expr_compile(): operator precedence parsing (Dijkstra 1961, the shunting yard) into postfix
 * order, with constants folded. Operands are read and operators in turn; operators wait in
 * compiler.pending until one that binds less follows. Nothing recurses; the stacks are bounded by
 * LIMIT_EXPR_DEPTH. */
#include <hooke/base/catalog.h>
#include <hooke/base/statement.h>
#include <hooke/base/number.h>
#include <hooke/scene/unit_word.h>

#include <string.h>

#include "scene/formula/compiler.h"

enum { COMPARISON, SUM, PRODUCT, SIGN, POWER }; /* precedences: -2^2 is -4, 2^-2 is a quarter */

/* The operators; longer signs first. */
static const struct sign {
    const char *sign;
    enum op_kind op;
    int precedence;
    bool to_right; /* it groups from the right: 2^3^2 is 2^(3^2) */
} operators[] = {
    {"<=", OP_LESS_EQUAL, COMPARISON, false},
    {">=", OP_GREATER_EQUAL, COMPARISON, false},
    {"<", OP_LESS, COMPARISON, false},
    {">", OP_GREATER, COMPARISON, false},
    {"+", OP_ADD, SUM, false},
    {"-", OP_SUB, SUM, false},
    {"*", OP_MUL, PRODUCT, false},
    {"/", OP_DIV, PRODUCT, false},
    {"^", OP_POW, POWER, true},
};

/* Returns the byte `ahead` of the position; 0 behind the end. */
static char compiler_peek(const struct compiler *c, size_t ahead)
{
    return ahead < c->text.len - c->position ? c->text.data[c->position + ahead] : '\0';
}

/* Sets the error that the expression is nested too deep. Returns false. */
static bool too_deep(struct compiler *c)
{
    return error_at(c->error, compiler_slice(c, c->position, c->position < c->text.len),
                    "the expression is nested deeper than %d levels", LIMIT_EXPR_DEPTH);
}

/* Returns a new operation at the end of the expression, which the caller fills; NULL, with an
 * error, if it is too large or out of memory. */
static struct op *new_op(struct compiler *c)
{
    struct expr *expr = c->expr;
    if (expr->count == LIMIT_EXPR_SIZE) {
        error_at(c->error, compiler_slice(c, 0, c->position),
                 "the expression has more than %d operations", LIMIT_EXPR_SIZE);
        return NULL;
    }
    if (expr->count == expr->capacity) {
        size_t capacity = expr->capacity ? 2 * expr->capacity : 16;
        struct op *more = arena_array(c->arena, capacity, sizeof *more);
        if (!more) {
            error_memory(c->error);
            return NULL;
        }
        if (expr->count)
            memcpy(more, expr->op, expr->count * sizeof *more);
        expr->op = more;
        expr->capacity = capacity;
    }
    return &expr->op[expr->count++];
}

/* Appends a number or a name, if the stack has room for its value. */
bool compiler_emit_value(struct compiler *c, struct op value)
{
    if (c->values == LIMIT_EXPR_DEPTH)
        return too_deep(c);
    struct op *op = new_op(c);
    if (!op)
        return false;
    *op = value;
    c->values++;
    return true;
}

/* Appends an operation, or computes it at once if all its operands are numbers. */
bool compiler_emit(struct compiler *c, struct op operation, size_t arity)
{
    if (c->operand && !units_of_operation(c, &operation, arity))
        return false;
    struct expr *expr = c->expr;
    double stack[3];
    size_t numbers = 0;
    while (numbers < arity && expr->op[expr->count - 1 - numbers].kind == OP_NUMBER)
        numbers++;
    c->values -= arity - 1;
    if (numbers < arity) {
        struct op *op = new_op(c);
        if (op)
            *op = operation;
        return op;
    }
    expr->count -= arity;
    for (size_t i = 0; i < arity; i++)
        stack[i] = expr->op[expr->count + i].number;
    op_apply(&operation, stack + arity);
    expr->op[expr->count++] = (struct op){.kind = OP_NUMBER, .number = stack[0]};
    return true;
}

/* Emits the pending operators that bind at least as tightly as `precedence`, down to the innermost
 * parenthesis. Returns false, with an error, if one cannot be emitted. */
static bool reduce(struct compiler *c, int precedence)
{
    while (c->depth > 0) {
        struct pending *top = &c->pending[c->depth - 1];
        if (top->what != WAIT_OPERATOR || top->precedence < precedence)
            return true;
        c->depth--;
        if (!compiler_emit(c, (struct op){.kind = top->op}, top->op == OP_NEG ? 1 : 2))
            return false;
    }
    return true;
}

/* Reads `length` bytes as an operator, parenthesis or call, which becomes pending. Returns false if
 * nested too deep. */
static bool pending_push(struct compiler *c, struct pending pending, size_t length)
{
    if (c->depth == LIMIT_EXPR_DEPTH)
        return too_deep(c);
    pending.where = compiler_slice(c, c->position, length);
    c->pending[c->depth++] = pending;
    c->position += length;
    return true;
}

static void skip_blanks(struct compiler *c)
{
    while (compiler_peek(c, 0) == ' ' || compiler_peek(c, 0) == '\t')
        c->position++;
}

/* Emits a number or a name that was typed as `typed`, with its dimension. */
static bool emit_typed(struct compiler *c, struct op value, struct text typed)
{
    const struct expr_scope *scope = c->scope;
    if (!compiler_emit_value(c, value))
        return false;
    if (!scope || !scope->quantity)
        return true;
    struct dimension dimension = {.kind = DIMENSION_BARE};
    if (value.kind == OP_NAME)
        dimension = dimension_of_name(scope->quantity(scope->context, value.slot));
    else if (text_is(typed, "pi"))
        dimension = dimension_of_pi();
    return units_of_value(c, typed, dimension);
}

/* Reads a number and emits it. Returns false, with an error, if it is malformed or too large. */
static bool number_operand_read(struct compiler *c)
{
    double value;
    size_t used;
    enum real_status status =
        real_scan(compiler_slice(c, c->position, c->text.len - c->position), '.', &value, &used);
    if (used == 0)
        return error_at(c->error, compiler_slice(c, c->position, 1), "malformed number");
    struct text word = compiler_slice(c, c->position, used);
    if (status == REAL_OVERFLOW)
        return error_at(c->error, word, "the number %.*s is too large", used < 40 ? (int)used : 40,
                        word.data);
    c->position += used;
    c->last = LAST_NUMBER;
    return emit_typed(c, (struct op){.kind = OP_NUMBER, .number = value}, word);
}

/* Sets the error that a name is unknown, with similar names as a hint. Returns false. */
static bool unknown_name(struct compiler *c, struct text name)
{
    int shown = name.len < LIMIT_NAME ? (int)name.len : LIMIT_NAME;
    error_at(c->error, name, "unknown name '%.*s'", shown, name.data);
    c->error->unknown = "name";
    struct suggestion suggestion = {.wanted = name};
    if (c->scope && c->scope->offer)
        c->scope->offer(c->scope->context, &suggestion);
    suggestion_offer(&suggestion, "pi");
    for (size_t i = 0; i < function_catalog.count; i++)
        suggestion_offer(&suggestion, catalog_row(&function_catalog, i)->name);
    suggestion_hint(&suggestion, c->error);
    return false;
}

/* Returns the end of the word of letters, digits and underscores that begins `position` bytes
 * ahead, counted from the same place. */
static size_t word_end(const struct compiler *c, size_t position)
{
    while (is_name_start(compiler_peek(c, position)) || is_digit_char(compiler_peek(c, position)))
        position++;
    return position;
}

/* Reads a name, the longest that the scope knows, and emits it as an operand. Names may contain a
 * hyphen (phase-error): a-b is such a name if the scope knows it, else a minus b. A ' behind a name
 * belongs to it, as y' is the velocity of y. Returns false with an error if the name is unknown. */
static bool read_name(struct compiler *c)
{
    size_t length[LIMIT_NAME], count = 0;
    length[0] = word_end(c, 0);
    length[0] += compiler_peek(c, length[0]) == '\'';
    count++;
    while (length[count - 1] < LIMIT_NAME && compiler_peek(c, length[count - 1]) == '-' &&
           is_name_start(compiler_peek(c, length[count - 1] + 1))) {
        length[count] = word_end(c, length[count - 1] + 1);
        count++;
    }
    struct text word = compiler_slice(c, c->position, length[0]);
    struct op op = {.kind = OP_NAME};
    if (text_is(word, "pi")) {
        op = (struct op){.kind = OP_NUMBER, .number = 3.14159265358979323846};
        count = 1;
    } else {
        while (count > 0 &&
               !(c->scope &&
                 c->scope->find(c->scope->context,
                                compiler_slice(c, c->position, length[count - 1]), &op.slot)))
            count--;
        if (count == 0)
            return unknown_name(c, word);
    }
    word.len = length[count - 1];
    c->position += word.len;
    c->last = op.kind == OP_NAME ? LAST_NAME : LAST_NUMBER;
    return emit_typed(c, op, word);
}

/* Reads a call's name with its parenthesis, which becomes pending, or a name. Returns false, with
 * an error, if neither is known. */
static bool read_word(struct compiler *c)
{
    struct text word = compiler_slice(c, c->position, word_end(c, 0));
    const struct row *row = catalog_find(&function_catalog, word);
    size_t paren = word.len;
    while (compiler_peek(c, paren) == ' ')
        paren++;
    if (row && compiler_peek(c, paren) == '(')
        return pending_push(
            c, (struct pending){.what = WAIT_CALL, .function = (const struct function *)row},
            paren + 1);
    if (!row && compiler_peek(c, word.len) == '(') {
        catalog_unknown(&function_catalog, word, c->error);
        c->error->where = word;
        return false;
    }
    int slot;
    if (row && !(c->scope && c->scope->find(c->scope->context, word, &slot)))
        return error_at(c->error, word, "%s is a function; write %.*s", row->name,
                        (int)strcspn(row->brief, ":"), row->brief);
    return read_name(c);
}

/* Sets the error that the innermost call has too many or too few arguments. Returns false. */
static bool wrong_count(struct compiler *c, const struct pending *call)
{
    int arity = function_arity(call->function);
    return error_at(
        c->error,
        (struct text){call->where.data, (size_t)(c->text.data + c->position - call->where.data)},
        "%s takes %d argument%s", call->function->row.name, arity, arity == 1 ? "" : "s");
}

/* Sets the error that an operand is missing, with a hint for ** and for signs that are not ASCII.
 * Returns false. */
static bool missing_operand(struct compiler *c)
{
    struct text where = compiler_slice(c, c->position, c->position < c->text.len);
    const struct pending *top = c->depth > 0 ? &c->pending[c->depth - 1] : NULL;
    if (top)
        error_at(c->error, where, "a number or a name is missing after '%.*s'", (int)top->where.len,
                 top->where.data);
    else
        error_at(c->error, where, "a number or a name is missing");
    const unsigned char first = (unsigned char)compiler_peek(c, 0);
    if (first == '*' && top && top->op == OP_MUL && top->where.data + 1 == where.data)
        return error_hint(c->error, "write powers with ^, as in 2^3");
    return first >= 0xC2 && first <= 0xF4 && /* first byte of a letter in UTF-8 */
           error_hint(c->error, "write names and signs in ASCII: - * / and a to z");
}

/* Reads an operand, or what may come before it. Sets *complete if an operand was read, so that an
 * operator may follow. */
static bool read_operand(struct compiler *c, bool *complete)
{
    char next = compiler_peek(c, 0);
    *complete = is_digit_char(next) || next == '.';
    if (*complete)
        return number_operand_read(c);
    if (is_name_start(next)) {
        size_t depth = c->depth;
        bool fine = read_word(c);
        *complete = c->depth == depth; /* else a call was opened */
        return fine;
    }
    if (next == '(')
        return pending_push(c, (struct pending){.what = WAIT_PARENTHESIS}, 1);
    if (next == '-')
        return pending_push(c, (struct pending){.op = OP_NEG, .precedence = SIGN}, 1);
    if (next == '+' && compiler_peek(c, 1) != '-') {
        c->position++;
        return true;
    }
    const struct pending *top = c->depth > 0 ? &c->pending[c->depth - 1] : NULL;
    if (next == ')' && top && top->what == WAIT_CALL && top->arguments == 0) {
        c->position++;
        return wrong_count(c, top);
    }
    return missing_operand(c);
}

/* Returns the innermost open parenthesis or call; NULL if there is none. */
static struct pending *innermost(struct compiler *c)
{
    for (size_t i = c->depth; i > 0; i--)
        if (c->pending[i - 1].what != WAIT_OPERATOR)
            return &c->pending[i - 1];
    return NULL;
}

/* Returns the operator at the position, or NULL if there is none; "+-" begins an uncertainty. */
static const struct sign *next_operator(const struct compiler *c)
{
    struct text rest = compiler_slice(c, c->position, c->text.len - c->position);
    for (size_t i = 0; i < COUNT_OF(operators); i++)
        if (text_starts(rest, text_of(operators[i].sign)) && !text_starts(rest, TEXT("+-")))
            return &operators[i];
    return NULL;
}

/* Reads what may follow an operand: an operator, a comma, a closing parenthesis or the end. A
 * comparison belongs to the expression only inside of parentheses; outside it ends the expression,
 * as it is part of a condition. Sets *complete if a ')' has completed another operand, and
 * *is_finished if the expression ends here. Returns false with an error. */
static bool read_operator(struct compiler *c, bool *complete, bool *is_finished)
{
    char next = compiler_peek(c, 0);
    *complete = next == ')';
    struct pending *open = innermost(c);
    const struct sign *sign = next_operator(c);
    if (sign && (open || sign->precedence != COMPARISON)) {
        if (!reduce(c, sign->precedence + (sign->to_right || sign->precedence == COMPARISON)))
            return false;
        const struct pending *last = c->depth > 0 ? &c->pending[c->depth - 1] : NULL;
        size_t length = strlen(sign->sign);
        if (sign->precedence == COMPARISON && last && last->what == WAIT_OPERATOR)
            return error_at(c->error, compiler_slice(c, c->position, length),
                            "comparisons do not chain: for a < b < c write (a < b)*(b < c)");
        return pending_push(c, (struct pending){.op = sign->op, .precedence = sign->precedence},
                            length);
    }
    if (next == ',' && open && open->what == WAIT_CALL) {
        c->position++;
        return ++open->arguments < function_arity(open->function) ? reduce(c, 0)
                                                                  : wrong_count(c, open);
    }
    if (next != ')' || !open) {
        *is_finished = true;
        return true;
    }
    if (!reduce(c, 0))
        return false;
    c->position++;
    c->depth--;
    c->last = LAST_NUMBER;
    if (open->what == WAIT_PARENTHESIS) {
        units_of_parenthesis(c, open->where.data);
        return true;
    }
    if (open->arguments + 1 < function_arity(open->function))
        return wrong_count(c, open);
    return compiler_emit(c, (struct op){.kind = OP_CALL, .function = open->function},
                         (size_t)open->arguments + 1);
}

/* Returns true if a number without a unit is followed by a word that is written as a unit: right
 * after the number, or before an operator, a closing parenthesis or the end of the text. */
static bool is_unit_wanted(const struct compiler *c)
{
    if (!c->operand || c->last != LAST_NUMBER || !is_name_start(compiler_peek(c, 0)))
        return false;
    size_t next = unit_word(compiler_slice(c, c->position, c->text.len - c->position)).len;
    while (compiler_peek(c, next) == ' ' || compiler_peek(c, next) == '\t')
        next++;
    return c->end == c->position || c->position + next == c->text.len ||
           strchr(")+-*/^,<>", compiler_peek(c, next));
}

/* Emits what is pending at the end of the expression. Returns false, with an error, if a
 * parenthesis is open or if a word that looks like a unit follows. */
static bool close_expression(struct compiler *c)
{
    const struct pending *open = innermost(c),
                         *top = c->depth > 0 ? &c->pending[c->depth - 1] : NULL;
    const bool sums = top && top->what == WAIT_OPERATOR && top->precedence == SUM && c->values > 1;
    const struct text number = c->operand ? c->operand[c->values - 1].text : (struct text){0};
    const enum quantity quantity = sums && c->operand
                                       ? dimension_quantity(&c->operand[c->values - 2].dimension)
                                       : QUANTITY_OTHER;
    if (!open && reduce(c, 0))
        return true;
    const struct text rest = compiler_slice(c, c->position, c->text.len - c->position);
    if (is_unit_wanted(c))
        return refuse_unit_word(c->scope, unit_word(rest), number, quantity, c->error);
    if (!open)
        return false;
    error_at(c->error, open->where, "missing ')' for '%.*s'", (int)open->where.len,
             open->where.data);
    return c->operand && is_name_start(compiler_peek(c, 0)) &&
           error_hint(c->error, "'%.*s' is not a unit", (int)word_end(c, 0),
                      c->text.data + c->position);
}

/* Reads operands and operators in turn, each perhaps followed by a unit, until neither follows. */
const struct expr *expr_compile(struct text text, const struct expr_scope *scope,
                                struct arena *arena, size_t *used, struct error *error)
{
    struct compiler compiler = {.text = text, .scope = scope, .arena = arena, .error = error},
                    *c = &compiler;
    c->expr = arena_alloc(arena, sizeof *c->expr);
    if (!c->expr) {
        error_memory(error);
        return NULL;
    }
    bool complete = false;
    for (bool is_finished = false; !is_finished; c->end = is_finished ? c->end : c->position) {
        skip_blanks(c);
        const size_t begin = c->position;
        if (complete && c->operand && !units_read(c))
            return NULL;
        if (c->position > begin)
            continue;
        if (!(complete ? read_operator(c, &complete, &is_finished) : read_operand(c, &complete)))
            return NULL;
    }
    if (!close_expression(c))
        return NULL;
    *used = c->end;
    if (c->operand)
        c->expr->typed = c->operand[0];
    return c->expr;
}
