/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Comparisons of two expressions. */
#include "scene/formula/expr.h"

static void skip_blanks(struct text text, size_t *at)
{
    while (*at < text.len && (text.at[*at] == ' ' || text.at[*at] == '\t'))
        ++*at;
}

/* One side, from text[*at]. */
static const struct expr *side(struct text text, size_t *at, const struct expr_scope *scope,
                               struct arena *arena, struct error *error)
{
    size_t used;
    const struct expr *expr =
        expr_compile((struct text){text.at + *at, text.len - *at}, scope, arena, &used, error);
    *at += expr ? used : 0;
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
    size_t at = 0;
    struct condition made = {.left = side(text, &at, scope, arena, error)};
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
    made.right = side(text, &at, scope, arena, error);
    if (!made.right || !expr_compare(made.left, &made.right, arena, error))
        return false;
    *condition = made;
    *used = at;
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
