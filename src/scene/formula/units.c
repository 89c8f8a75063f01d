/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Units in expressions. Each value on the compiler's stack has a dimension; a unit belongs to the
 * number or the parenthesis before it. Functions that return a bool return false with an error. */
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <string.h>

#include "scene/formula/compiler.h"

/* Returns the length of a text that a message quotes. */
static int shown_length(struct text text)
{
    return (int)(text.len < 60 ? text.len : 60);
}

/* Returns the text from begin to end without blanks at its ends. */
static struct text text_between(const char *begin, const char *end)
{
    return text_trim((struct text){begin, (size_t)(end - begin)});
}

/* Returns the end of a text. */
static const char *text_end(struct text text)
{
    return text.data + text.len;
}

/* Enters text and dimension of the value just emitted, for which there may have to be more
 * memory. */
bool units_of_value(struct compiler *c, struct text typed, struct dimension dimension)
{
    if (c->values > c->operands) {
        const size_t operands = c->operands ? 2 * c->operands : 8;
        struct typed_operand *more = arena_array(c->arena, operands, sizeof *more);
        if (!more)
            return error_memory(c->error);
        if (c->operands)
            memcpy(more, c->operand, c->operands * sizeof *more);
        c->operand = more;
        c->operands = operands;
    }
    c->operand[c->values - 1] = (struct typed_operand){.dimension = dimension, .text = typed};
    return true;
}

/* Extends the text of the last value to the parenthesis, which may be followed by a unit. */
void units_of_parenthesis(struct compiler *c, const char *open)
{
    if (!c->operand)
        return;
    struct typed_operand *operand = &c->operand[c->values - 1];
    operand->text = text_between(open, c->text.data + c->position);
    operand->number = operand->unit = (struct text){NULL, 0};
}

/* ---- operands whose dimensions do not match ---- */

/* Adds the hint how an operand whose unit belongs to its last number only was read: 1/30 s is
 * 1/(30 s). Always returns false. */
static bool hint_readings(const struct typed_operand *operand, struct error *error)
{
    if (operand->unit.len == 0 || operand->number.data == operand->text.data)
        return false;
    const struct text prefix = {operand->text.data,
                                (size_t)(operand->number.data - operand->text.data)};
    const struct text whole = text_between(operand->text.data, text_end(operand->number));
    return error_hint(error,
                      "this means %.*s(%.*s %.*s); if you mean (%.*s) %.*s, write the parentheses",
                      shown_length(prefix), prefix.data, shown_length(operand->number),
                      operand->number.data, (int)operand->unit.len, operand->unit.data,
                      shown_length(whole), whole.data, (int)operand->unit.len, operand->unit.data);
}

/* Sets the error that two operands have different dimensions, with a hint. `verb` is "add" or "go
 * together", or "compare". Returns false. */
static bool refuse_pair(struct error *error, const char *verb, const struct typed_operand *a,
                        const struct typed_operand *b)
{
    struct buffer left = {0}, right = {0};
    const struct text all = text_between(a->text.data, text_end(b->text));
    dimension_put(&a->dimension, &left);
    dimension_put(&b->dimension, &right);
    error_at(error, all,
             "'%.*s' (%s) and '%.*s' (%s) do not %s: a unit belongs to the number "
             "before it",
             shown_length(a->text), a->text.data, buffer_view(&left), shown_length(b->text),
             b->text.data, buffer_view(&right), verb);
    buffer_free(&left);
    buffer_free(&right);
    const struct typed_operand pair = {.text = all, .number = b->number, .unit = b->unit};
    const struct dimension *other = &b->dimension;
    const bool adds = strcmp(verb, "add") == 0;
    if (adds && a->dimension.kind == DIMENSION_BARE && b->unit.len > 0) {
        const struct text whole = text_between(all.data, text_end(b->number)),
                          right_text = text_between(text_end(a->text), text_end(b->text));
        struct buffer unit = {0};
        dimension_put_unit(other, &unit);
        error_hint(error, "write (%.*s) %.*s, or %.*s %s %.*s", shown_length(whole), whole.data,
                   (int)b->unit.len, b->unit.data, shown_length(a->text), a->text.data,
                   buffer_view(&unit), shown_length(right_text), right_text.data);
        buffer_free(&unit);
        return false;
    }
    if (adds && b->dimension.kind == DIMENSION_BARE && a->dimension.unit)
        return error_hint(error, "write %.*s %s: both numbers need a unit", shown_length(all),
                          all.data, a->dimension.unit->row.name);
    return adds && hint_readings(&pair, error);
}

/* Emits a conversion of the last value between cycles and radians: times 2 pi for turns > 0, over 2
 * pi for turns < 0. */
static bool turns_emit(struct compiler *c, int turns)
{
    const struct typed_operand typed = c->operand[c->values - 1];
    const struct dimension bare = {.kind = DIMENSION_BARE};
    if (turns == 0)
        return true;
    if (!compiler_emit_value(c, (struct op){.kind = OP_NUMBER, .number = 2 * PI}) ||
        !units_of_value(c, typed.text, bare) ||
        !compiler_emit(c, (struct op){.kind = turns > 0 ? OP_MUL : OP_DIV}, 2))
        return false;
    c->operand[c->values - 1] = typed;
    return true;
}

/* Sets *sum to the dimension of two operands that are added, compared or chosen from; b was emitted
 * last if is_last, and can be converted between cycles and radians then. */
static bool units_of_sum(struct compiler *c, const char *verb, const struct typed_operand *a,
                         const struct typed_operand *b, bool is_last, struct dimension *sum)
{
    int turns;
    if (!dimension_sum(&a->dimension, &b->dimension, sum, &turns) || (turns != 0 && !is_last))
        return refuse_pair(c->error, verb, a, b);
    return turns_emit(c, turns);
}

/* Returns true if the operand is a pure number or an angle, or if no unit was typed in it.
 * Otherwise sets an error, in which `what` is the name of the function or "an exponent". */
static bool check_pure(struct compiler *c, const char *what, const struct typed_operand *a)
{
    const struct dimension *dimension = &a->dimension;
    if (!dimension->unit || dimension->kind != DIMENSION_KNOWN || dimension_is_pure(dimension))
        return true;
    struct buffer name = {0};
    dimension_put(dimension, &name);
    error_at(c->error, a->text, "%s needs a number, not '%.*s' (%s)", what, shown_length(a->text),
             a->text.data, buffer_view(&name));
    buffer_free(&name);
    return false;
}

/* Sets *made to the dimension of the power of operand a, whose exponent is the operand after it, a
 * + 1. A unit can only be raised to a number that was typed. Returns false with an error. */
static bool power_dimension(struct compiler *c, const struct typed_operand *a,
                            struct dimension *made)
{
    const struct typed_operand *exponent = a + 1;
    const struct op *last = &c->expr->op[c->expr->count - 1];
    const struct typed_operand pair = {.text = text_between(a->text.data, text_end(exponent->text)),
                                       .number = exponent->number,
                                       .unit = exponent->unit};
    if (!check_pure(c, "an exponent", exponent)) {
        hint_readings(&pair, c->error);
        return false;
    }
    *made = a->dimension;
    made->is_single = false;
    made->is_product = true;
    if (a->dimension.kind == DIMENSION_UNKNOWN || a->dimension.kind == DIMENSION_MIXED)
        made->has_name |= exponent->dimension.has_name;
    else if (last->kind == OP_NUMBER)
        *made = dimension_power(&a->dimension, last->number);
    else if (a->dimension.unit && !dimension_is_pure(&a->dimension))
        return error_at(c->error, pair.text, "a value with a unit can only be raised to a number");
    else if (!dimension_is_pure(&a->dimension))
        made->kind = DIMENSION_UNKNOWN;
    return true;
}

/* Returns the dimension of a number that is computed from `arity` operands, with what users typed
 * in these. */
static struct dimension number_dimension(const struct typed_operand *a, size_t arity)
{
    struct dimension made = {.kind = DIMENSION_BARE};
    for (size_t i = 0; i < arity; i++) {
        made.kind = a[i].dimension.kind == DIMENSION_BARE ? made.kind : DIMENSION_KNOWN;
        made.has_name |= a[i].dimension.has_name;
        made.unit = made.unit ? made.unit : a[i].dimension.unit;
    }
    return made;
}

/* Sets *made to the dimension of a function's value from its arguments a [arity], by the rule of
 * the function. Returns false with c->error if an argument has a dimension that the function does
 * not allow, or if the arguments' dimensions differ where they must not. */
static bool call_dimension(struct compiler *c, const struct function *function,
                           const struct typed_operand *a, size_t arity, struct dimension *made)
{
    const char *name = function->row.name;
    const enum function_dimension rule = function->dimension;
    *made = number_dimension(a, arity);
    if (rule == FUNCTION_POWER)
        return power_dimension(c, a, made);
    if (rule == FUNCTION_CHOICE)
        return units_of_sum(c, "go together", &a[1], &a[2], true, made);
    if (rule == FUNCTION_SQUARE_ROOT || rule == FUNCTION_CUBE_ROOT) {
        *made = dimension_power(&a[0].dimension, rule == FUNCTION_CUBE_ROOT ? 1.0 / 3 : 0.5);
        return true;
    }
    if (rule == FUNCTION_ANGLE && dimension_counts_cycles(&a->dimension)) {
        error_at(c->error, a->text, "%s needs radians, but '%.*s' is in cycles", name,
                 shown_length(a->text), a->text.data);
        return error_hint(c->error, "one cycle is 2*pi rad: %s(2*pi*%.*s)", name,
                          shown_length(a->text), a->text.data);
    }
    if (rule == FUNCTION_PURE || rule == FUNCTION_ANGLE) {
        for (size_t i = 0; i < arity; i++)
            if (!check_pure(c, name, &a[i]))
                return false;
        return true;
    }
    struct dimension alike = a[0].dimension;
    for (size_t i = 1; i < arity; i++) {
        struct typed_operand so_far = a[0];
        so_far.dimension = alike;
        if (!units_of_sum(c, "go together", &so_far, &a[i], i + 1 == arity, &alike))
            return false;
    }
    alike.is_single = false;
    if (rule == FUNCTION_SAME)
        *made = alike;
    return true;
}

/* Stores the result of the operation, with the dimension that follows from its kind, in place of
 * the first of its operands, which are the last `arity` of c->operand. Returns false with an error
 * if their dimensions do not fit. */
bool units_of_operation(struct compiler *c, const struct op *operation, size_t arity)
{
    struct typed_operand *a = &c->operand[c->values - arity];
    struct typed_operand made = {.text = text_between(a->text.data, text_end(a[arity - 1].text)),
                                 .number = a[arity - 1].number,
                                 .unit = a[arity - 1].unit};
    struct dimension *dimension = &made.dimension;
    switch (operation->kind) {
    case OP_NEG:
        *dimension = a->dimension;
        break;
    case OP_ADD:
    case OP_SUB:
        if (!units_of_sum(c, "add", &a[0], &a[1], true, dimension))
            return false;
        break;
    case OP_MUL:
    case OP_DIV:
        *dimension = dimension_product(&a[0].dimension, &a[1].dimension, operation->kind == OP_DIV);
        break;
    case OP_POW:
        if (!power_dimension(c, a, dimension))
            return false;
        break;
    case OP_CALL:
        /* The call was just closed: its name is still behind the pending ones. */
        made.text = text_between(c->pending[c->depth].where.data, c->text.data + c->position);
        made.number = made.unit = (struct text){NULL, 0};
        if (!call_dimension(c, operation->function, a, arity, dimension))
            return false;
        break;
    default: /* comparisons; numbers and names are no operations */
        if (!units_of_sum(c, "compare", &a[0], &a[1], true, dimension))
            return false;
        *dimension = number_dimension(a, arity);
    }
    c->operand[c->values - arity] = made; /* making room for more may have moved the array */
    return true;
}

/* ---- reading ---- */

/* Returns the unit whose name is this one with ^ before digits, m/s^2 for m/s2; NULL if there is
 * none. */
static const struct unit *powered_unit(const char *name)
{
    char whole[LIMIT_NAME + 1];
    size_t length = 0;
    for (size_t i = 0; name[i] && length + 2 < sizeof whole; i++) {
        if (i > 0 && name[i] >= '2' && name[i] <= '9' && is_name_start(name[i - 1]))
            whole[length++] = '^';
        whole[length++] = name[i];
    }
    return unit_find((struct text){whole, length});
}

/* Refuses what follows a unit and makes no unit with it, written without a blank (m/s^3, kg/m,
 * cm^3), and units written with blanks inside (N / m). Returns true if the unit is fine. */
static bool refuse_glued(struct compiler *c, const struct unit *unit)
{
    const struct text rest = compiler_slice(c, c->position, c->text.len - c->position);
    size_t sign = strlen(unit->row.name), next;
    const bool glued = sign < rest.len && strchr("*/^", rest.data[sign]);
    while (sign < rest.len && strchr(" \t", rest.data[sign]))
        sign++;
    if (sign == rest.len || !strchr("*/^", rest.data[sign]))
        return true;
    next = sign + 1;
    while (next < rest.len && strchr(" \t", rest.data[next]))
        next++;
    const struct text other = {rest.data + next, rest.len - next};
    const size_t word = peek_word(other, "+-*/^()<>=,:").len;
    const bool power = rest.data[sign] == '^';
    if (!power && word < other.len && other.data[word] == '(')
        return true; /* a call, as of min() */
    char whole[LIMIT_NAME];
    struct buffer name = {0};
    buffer_format(&name, "%s%c%.*s", unit->row.name, rest.data[sign], (int)(word < 16 ? word : 16),
                  other.data);
    const bool fits = name.len < sizeof whole, exists = unit_find(buffer_text(&name)) != NULL;
    memcpy(whole, buffer_view(&name), fits ? name.len + 1 : 1);
    whole[fits ? name.len : 0] = '\0';
    buffer_free(&name);
    if (!exists && !power &&
        !(glued && next == sign + 1 && (unit_match(other) || powered_unit(whole))))
        return true;
    const struct typed_operand *operand = &c->operand[c->values - 1];
    const struct text typed = {rest.data, next + word};
    const struct unit *meant = glued ? powered_unit(whole) : NULL;
    if (meant) {
        error_at(c->error, typed, "unknown unit '%s'", whole);
        c->error->unknown = "unit";
        return error_hint(c->error, "the unit is written %s", meant->row.name);
    }
    if (exists)
        return error_at(c->error, typed, "the unit %s is written without blanks", whole);
    error_at(c->error, typed, "unknown unit '%s': %s is one", whole, unit->row.name);
    c->error->unknown = "unit";
    if (!power)
        return error_hint(c->error, "%s is also a name; to use the name, put blanks around it",
                          unit_match(other)->row.name);
    return error_hint(c->error, "a power of a value is written (%.*s %s)^%.*s",
                      shown_length(operand->text), operand->text.data, unit->row.name,
                      (int)(word < 16 ? word : 16), other.data);
}

/* Sets the error that a unit cannot follow a name or another unit. Returns false. */
static bool refuse_unit(struct compiler *c, const struct unit *unit)
{
    const struct typed_operand *operand = &c->operand[c->values - 1];
    const struct text typed = compiler_slice(c, c->position, strlen(unit->row.name));
    size_t begin = 0;
    for (size_t i = c->depth; i > 0 && begin == 0; i--)
        if (c->pending[i - 1].what != WAIT_OPERATOR)
            begin = (size_t)(text_end(c->pending[i - 1].where) - c->text.data);
    const struct text whole = text_between(c->text.data + begin, c->text.data + c->position);
    if (c->last == LAST_NAME) {
        error_at(c->error, typed, "a unit may follow a number or a parenthesis, not '%.*s'",
                 shown_length(operand->text), operand->text.data);
        return error_hint(
            c->error, "a name already has its SI unit; for the number %.*s in %s write (%.*s) %s",
            shown_length(whole), whole.data, unit->row.name, shown_length(whole), whole.data,
            unit->row.name);
    }
    return error_at(c->error, typed, "a value has one unit: '%.*s' has %s",
                    shown_length(operand->text), operand->text.data,
                    operand->dimension.unit->row.name);
}

/* Reads a unit behind a number or a parenthesis, and converts the value to SI. */
bool units_read(struct compiler *c)
{
    const struct unit *unit = unit_match(compiler_slice(c, c->position, c->text.len - c->position));
    struct typed_operand *operand = &c->operand[c->values - 1];
    struct op *last = &c->expr->op[c->expr->count - 1];
    if (!unit || c->last == LAST_UNIT)
        return true;
    if (c->last == LAST_NAME || operand->dimension.unit)
        return refuse_unit(c, unit);
    if (!refuse_glued(c, unit))
        return false;
    struct typed_operand made = {.dimension = dimension_of_unit(unit),
                                 .number = operand->text,
                                 .unit = compiler_slice(c, c->position, strlen(unit->row.name))};
    made.text = text_between(operand->text.data, text_end(made.unit));
    made.dimension.power[BASE_PI] = operand->dimension.power[BASE_PI];
    if (last->kind == OP_NUMBER) {
        unit_convert(unit, unit->quantity, last->number, &last->number);
    } else if (unit->factor != 1) {
        const double inverse = nearbyint(1 / unit->factor);
        const bool divides = unit->factor < 1 && inverse * unit->factor == 1;
        const struct dimension bare = {.kind = DIMENSION_BARE};
        if (!compiler_emit_value(
                c, (struct op){.kind = OP_NUMBER, .number = divides ? inverse : unit->factor}) ||
            !units_of_value(c, made.unit, bare) ||
            !compiler_emit(c, (struct op){.kind = divides ? OP_DIV : OP_MUL}, 2))
            return false;
    }
    c->operand[c->values - 1] = made;
    c->position += made.unit.len;
    c->last = LAST_UNIT;
    return true;
}

/* ---- dimensions of compiled expressions ---- */

const struct dimension *expr_dimension(const struct expr *expr)
{
    return &expr->typed.dimension;
}

bool expr_hint_readings(const struct expr *expr, struct error *error)
{
    return hint_readings(&expr->typed, error);
}

/* Checks that both sides of a comparison have the same dimension. If one is in Hz and the other in
 * rad/s, *right is replaced by an expression in the arena that is converted. Returns false with
 * *error if the dimensions differ or if out of memory. */
bool expr_compare(const struct expr *left, const struct expr **right, struct arena *arena,
                  struct error *error)
{
    const struct typed_operand *a = &left->typed, *b = &(*right)->typed;
    const enum quantity qa = dimension_quantity(&a->dimension),
                        qb = dimension_quantity(&b->dimension);
    const bool names = a->dimension.is_single && b->dimension.is_single && a->dimension.has_name &&
                       b->dimension.has_name && qa != QUANTITY_OTHER && qb != QUANTITY_OTHER;
    struct dimension sum;
    int turns;
    if (!dimension_sum(&a->dimension, &b->dimension, &sum, &turns) || (names && qa != qb)) {
        struct buffer is = {0}, other = {0};
        dimension_put(&a->dimension, &is);
        dimension_put(&b->dimension, &other);
        error_at(error, b->text, "'%.*s' (%s) cannot be compared with '%.*s' (%s)",
                 shown_length(a->text), a->text.data, buffer_view(&is), shown_length(b->text),
                 b->text.data, buffer_view(&other));
        buffer_free(&is);
        buffer_free(&other);
        if (!hint_readings(b, error))
            hint_readings(a, error);
        return false;
    }
    if (turns == 0)
        return true;
    struct expr *turned = arena_alloc(arena, sizeof *turned);
    struct op *op = arena_array(arena, (*right)->count + 2, sizeof *op);
    if (!turned || !op)
        return error_memory(error);
    memcpy(op, (*right)->op, (*right)->count * sizeof *op);
    *turned = **right;
    turned->op = op;
    turned->capacity = turned->count + 2;
    op[turned->count++] = (struct op){.kind = OP_NUMBER, .number = 2 * PI};
    op[turned->count++] = (struct op){.kind = turns > 0 ? OP_MUL : OP_DIV};
    *right = turned;
    return true;
}
