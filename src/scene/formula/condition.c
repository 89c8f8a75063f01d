/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Conditions: comparisons of two expressions, as in `run until y < 0`. */
#include "scene/formula/expr.h"

/* Moves *position behind blanks. */
static void skip_blanks(struct text text, size_t *position)
{
    while (*position < text.len && (text.data[*position] == ' ' || text.data[*position] == '\t'))
        ++*position;
}

/* Compiles the expression at text[*position] and moves *position behind it. Returns NULL, with an
 * error, if there is none. */
static const struct expr *condition_side_compile(struct text text, size_t *position,
                                                 const struct expr_scope *scope,
                                                 struct arena *arena, struct error *error)
{
    size_t used;
    const struct expr *expr = expr_compile(text_after(text, *position), scope, arena, &used, error);
    *position += expr ? used : 0;
    return expr;
}

/* Sets the error that a condition has no comparison at `sign`; if that is "=", the hint is to write
 * >=. Returns false. */
static bool no_comparison(struct text text, struct text sign, struct error *error)
{
    error_at(error, sign, "a condition needs <, <=, > or >=");
    if (!text_is(sign, "="))
        return false;
    const struct text left = text_trim((struct text){text.data, (size_t)(sign.data - text.data)});
    struct text right = {sign.data + 1, text.len - (size_t)(sign.data + 1 - text.data)};
    while (text_starts(right, TEXT("=")))
        right = text_after(right, 1);
    right = text_trim(right);
    return error_hint(error, "steps may jump over an exact value; write for example '%.*s >= %.*s'",
                      (int)left.len, left.data, (int)right.len, right.data);
}

/* Reads an expression, a comparison sign and another expression. */
bool condition_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                       struct condition *condition, size_t *used, struct error *error)
{
    size_t position = 0;
    struct condition made = {.left = condition_side_compile(text, &position, scope, arena, error)};
    if (!made.left)
        return false;
    skip_blanks(text, &position);
    struct text sign = {text.data + position, position < text.len};
    if (!text_is(sign, "<") && !text_is(sign, ">"))
        return no_comparison(text, sign, error);
    made.less = text_is(sign, "<");
    position++;
    made.or_equal = position < text.len && text.data[position] == '=';
    position += made.or_equal;
    made.right = condition_side_compile(text, &position, scope, arena, error);
    if (!made.right || !expr_compare(made.left, &made.right, arena, error))
        return false;
    *condition = made;
    *used = position;
    return true;
}

double condition_value(const struct condition *condition, const struct expr_scope *scope)
{
    double left = expr_value(condition->left, scope);
    double right = expr_value(condition->right, scope);
    return condition->less ? left - right : right - left;
}

bool condition_holds(const struct condition *condition, double value)
{
    return condition->or_equal ? value <= 0 : value < 0;
}
