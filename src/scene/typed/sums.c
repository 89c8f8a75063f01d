/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sums sorted by what their summands depend on: typed_sort() splits the right-hand side of an
 * equation into forces, work and drag (enum typed_group). It works on the postfix order of the
 * expression, in which each operation ends an operand that begins somewhere before it. */
#include <stdlib.h>
#include <string.h>

#include "scene/typed/typed.h"

/* ---- making expressions of expressions ---- */

static bool is_value(const struct op *op)
{
    return op->kind == OP_NUMBER || op->kind == OP_NAME;
}

/* Returns true if an evaluation of the expression would need more than LIMIT_EXPR_DEPTH values at
 * once. */
static bool too_deep(const struct expr *expr)
{
    int values = 0, max = 0;
    for (size_t i = 0; i < expr->count; i++) {
        values += is_value(&expr->op[i]) ? 1 : 1 - op_arity(&expr->op[i]);
        max = values > max ? values : max;
    }
    return max > LIMIT_EXPR_DEPTH;
}

/* Makes an expression of one operation. */
const struct expr *typed_value(struct arena *arena, struct op op)
{
    struct expr *made = arena_alloc(arena, sizeof *made);
    struct op *copy = arena_alloc(arena, sizeof *copy);
    if (!made || !copy)
        return NULL;
    *copy = op;
    *made = (struct expr){.op = copy, .count = 1, .capacity = 1};
    return made;
}

/* Appends operations to an expression. */
static bool operations_append(struct arena *arena, struct expr *target, const struct op *op,
                              size_t count)
{
    if (target->count + count > target->capacity) {
        const size_t capacity = 2 * target->capacity + count;
        struct op *more = arena_array(arena, capacity, sizeof *more);
        if (!more)
            return false;
        if (target->count)
            memcpy(more, target->op, target->count * sizeof *more);
        target->op = more;
        target->capacity = capacity;
    }
    if (count)
        memcpy(target->op + target->count, op, count * sizeof *op);
    target->count += count;
    return true;
}

/* Appends the operations of a, of b, and the operation itself. */
const struct expr *typed_join(struct arena *arena, const struct expr *a, const struct expr *b,
                              enum op_kind op, struct error *error)
{
    const struct op last = {.kind = op};
    struct expr *made = arena_alloc(arena, sizeof *made);
    if (made && operations_append(arena, made, a->op, a->count) &&
        (!b || operations_append(arena, made, b->op, b->count)) &&
        operations_append(arena, made, &last, 1)) {
        if (!too_deep(made))
            return made;
        error_set(error, ERROR_COMMAND, "the forces together are nested deeper than %d levels",
                  LIMIT_EXPR_DEPTH);
        return NULL;
    }
    error_memory(error);
    return NULL;
}

/* ---- sorting ---- */

unsigned typed_depends(const struct expr *expr, const unsigned *depends)
{
    unsigned mask = 0;
    for (size_t i = 0; i < expr->count; i++)
        if (expr->op[i].kind == OP_NAME)
            mask |= depends[expr->op[i].slot];
    return mask;
}

/* Returns the group of a summand that depends on `mask`. */
static enum typed_group group_of(const struct typed_sort *sort, unsigned mask)
{
    if (mask & DEPENDS_VELOCITY)
        return GROUP_DRAG;
    return mask & DEPENDS_TIME || !sort->positions ? GROUP_WORK : GROUP_FORCE;
}

/* The operand that an operation ends. */
struct operand {
    size_t begin;             /* index of its first operation */
    unsigned depends, groups; /* bits of the groups that its summands belong to */
};

/* State of typed_sort(). */
struct sorting {
    const struct typed_sort *sort;
    const struct expr *expr;
    struct operand *operand; /* [operations] */
};

/* An operation that has to be applied to a summand, such as a factor before a parenthesis;
 * operations are listed from the inside out. */
struct wrap {
    enum op_kind op;
    const struct expr *other; /* the other operand; NULL for OP_NEG */
    bool other_is_left;       /* the other one is the left operand */
    const struct wrap *outer;
};

/* Rule by which an operation is split into summands: its operands `side` are split, and `wrap` is
 * applied to the summands of each. */
struct parting {
    size_t side[2];      /* operations that end the operands */
    int sides;           /* number of operands that are split; 0 if the operation is one summand */
    struct wrap wrap[2]; /* op is OP_NUMBER if nothing has to be applied */
    size_t factor;       /* operation that ends the other operand, a constant factor */
};

/* Sets *p to the way in which the operation at `index` is split. */
static void operation_parting(const struct sorting *s, size_t index, struct parting *p)
{
    const struct op *top = &s->expr->op[index];
    *p = (struct parting){.side = {index - 1, index - 1},
                          .wrap = {{.op = OP_NUMBER}, {.op = OP_NUMBER}}};
    if (top->kind == OP_NEG) {
        p->sides = 1;
        p->wrap[0].op = OP_NEG;
        return;
    }
    if (top->kind < OP_ADD || top->kind > OP_DIV)
        return;
    const size_t right = index - 1, left = s->operand[right].begin - 1;
    p->side[0] = left;
    p->side[1] = right;
    if (top->kind == OP_ADD || top->kind == OP_SUB) {
        p->sides = 2;
        p->wrap[1].op = top->kind == OP_SUB ? OP_NEG : OP_NUMBER;
        return;
    }
    const bool divisor = s->operand[right].depends == 0;
    p->sides = divisor || (top->kind == OP_MUL && s->operand[left].depends == 0);
    p->side[0] = divisor ? left : right;
    p->factor = divisor ? right : left;
    p->wrap[0] = (struct wrap){.op = top->kind, .other_is_left = !divisor};
}

/* Finds, for each operation, where its operand begins, what it depends on, and to which groups its
 * summands belong. One pass over the postfix order suffices, because operands come before their
 * operation. */
static void operations_scan(struct sorting *s)
{
    const struct expr *expr = s->expr;
    for (size_t i = 0; i < expr->count; i++) {
        const struct op *op = &expr->op[i];
        struct operand *operand = &s->operand[i];
        *operand = (struct operand){
            .begin = i, .depends = op->kind == OP_NAME ? s->sort->depends[op->slot] : 0};
        for (int k = is_value(op) ? 0 : op_arity(op); k > 0; k--) {
            operand->depends |= s->operand[operand->begin - 1].depends;
            operand->begin = s->operand[operand->begin - 1].begin;
        }
        const enum typed_group group = group_of(s->sort, operand->depends);
        struct parting p = {.sides = 0};
        if (group != group_of(s->sort, 0))
            operation_parting(s, i, &p);
        operand->groups = p.sides ? 0 : 1u << group;
        for (int k = 0; k < p.sides; k++)
            operand->groups |= s->operand[p.side[k]].groups;
    }
}

/* Returns the operand that the operation at `index` ends, as an expression. */
static struct expr operand_expr(const struct sorting *s, size_t index)
{
    const size_t begin = s->operand[index].begin;
    return (struct expr){.op = s->expr->op + begin, .count = index + 1 - begin};
}

/* Adds the operand that ends at `index`, with the operations `wrap` applied, to the sum of a group.
 * Returns false with an error. */
static bool group_put(const struct sorting *s, size_t index, const struct wrap *wrap,
                      struct expr *group)
{
    static const struct op plus = {.kind = OP_ADD};
    const struct typed_sort *sort = s->sort;
    const struct expr summand = operand_expr(s, index), *made = &summand;
    for (; made && wrap; wrap = wrap->outer)
        made = wrap->other_is_left
                   ? typed_join(sort->arena, wrap->other, made, wrap->op, sort->error)
                   : typed_join(sort->arena, made, wrap->other, wrap->op, sort->error);
    if (!made)
        return false;
    const bool first = group->count == 0;
    if (operations_append(sort->arena, group, made->op, made->count) &&
        (first || operations_append(sort->arena, group, &plus, 1)))
        return true;
    return error_memory(sort->error);
}

/* Adds the summands of the operand that ends at `index` to the sums of their groups. Summands of
 * one group stay together in the form in which they were written. Returns false with an error. */
static bool sort_ending(const struct sorting *s, size_t index, const struct wrap *wrap,
                        struct expr *group)
{
    for (int g = 0; g < GROUPS; g++)
        if (s->operand[index].groups == 1u << g)
            return group_put(s, index, wrap, &group[g]);
    struct parting p;
    operation_parting(s, index, &p);
    const struct expr factor =
        p.sides == 1 && p.wrap[0].op != OP_NEG ? operand_expr(s, p.factor) : (struct expr){0};
    p.wrap[0].other = factor.count ? &factor : NULL;
    for (int i = 0; i < p.sides; i++) {
        p.wrap[i].outer = wrap;
        if (!sort_ending(s, p.side[i], p.wrap[i].op == OP_NUMBER ? wrap : &p.wrap[i], group))
            return false;
    }
    return true;
}

/* Scans the operations, then puts each summand into the sum of its group. */
bool typed_sort(const struct typed_sort *sort, const struct expr *expr,
                const struct expr *group[GROUPS])
{
    struct sorting s = {
        .sort = sort, .expr = expr, .operand = malloc(expr->count * sizeof *s.operand)};
    struct expr *sum = arena_array(sort->arena, GROUPS, sizeof *sum);
    bool fine = s.operand && sum;
    if (!fine)
        error_memory(sort->error);
    if (fine)
        operations_scan(&s);
    fine = fine && sort_ending(&s, expr->count - 1, NULL, sum);
    free(s.operand);
    for (int g = 0; fine && g < GROUPS; g++) {
        group[g] = sum[g].count > 0 ? &sum[g] : NULL;
        if (too_deep(&sum[g]))
            fine = error_set(sort->error, ERROR_COMMAND,
                             "the forces are nested deeper than %d levels", LIMIT_EXPR_DEPTH);
    }
    return fine;
}
