/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Comparisons: expr [unit] < expr [unit]. */
#include "scene/formula/expr.h"

static void skip_blanks(struct text text, size_t *at)
{
    while (*at < text.len && (text.at[*at] == ' ' || text.at[*at] == '\t'))
        ++*at;
}

/* One side, from text[*at]. */
static const struct expr *side(struct text text, size_t *at, const struct expr_scope *scope,
                               struct arena *arena, const struct unit **unit, struct error *error)
{
    size_t used;
    const struct expr *expr =
        expr_compile((struct text){text.at + *at, text.len - *at}, scope, arena, &used, error);
    if (!expr)
        return NULL;
    *at += used;
    size_t next = *at;
    skip_blanks(text, &next);
    *unit = unit_match((struct text){text.at + next, text.len - next});
    if (*unit)
        *at = next + text_of((*unit)->row.name).len;
    return expr;
}

static bool no_comparison(struct text text, struct text sign, struct error *error)
{
    error_at(error, sign, "a condition needs <, <=, > or >=");
    if (!text_is(sign, "="))
        return false;
    const struct text left = text_trim((struct text){text.at, (size_t)(sign.at - text.at)});
    struct text right = {sign.at + 1, text.len - (size_t)(sign.at + 1 - text.at)};
    while (text_starts(right, TEXT("=")))
        right = (struct text){right.at + 1, right.len - 1};
    right = text_trim(right);
    return error_hint(error, "steps pass it: '%.*s >= %.*s'", (int)left.len, left.at,
                      (int)right.len, right.at);
}

bool condition_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                       struct condition *condition, size_t *used, struct error *error)
{
    const struct unit *left, *right;
    size_t at = 0;
    struct condition made = {.left = side(text, &at, scope, arena, &left, error)};
    if (!made.left)
        return false;
    skip_blanks(text, &at);
    struct text sign = {text.at + at, at < text.len};
    if (!text_is(sign, "<") && !text_is(sign, ">"))
        return no_comparison(text, sign, error);
    made.less = text_is(sign, "<");
    at++;
    made.or_equal = at < text.len && text.at[at] == '=';
    at += made.or_equal;
    made.right = side(text, &at, scope, arena, &right, error);
    if (!made.right)
        return false;
    if (left && right && left->quantity != right->quantity)
        return error_at(error, text, "the two sides do not compare: %s is a unit of %s, %s of %s",
                        left->row.name, quantity_name(left->quantity), right->row.name,
                        quantity_name(right->quantity));
    made.left_factor = left ? left->factor : 1;
    made.right_factor = right ? right->factor : 1;
    *condition = made;
    *used = at;
    return true;
}

double condition_value(const struct condition *condition, const struct expr_scope *scope)
{
    double left = expr_value(condition->left, scope) * condition->left_factor;
    double right = expr_value(condition->right, scope) * condition->right_factor;
    return condition->less ? left - right : right - left;
}

bool condition_holds(const struct condition *condition, double value)
{
    return condition->or_equal ? value <= 0 : value < 0;
}
