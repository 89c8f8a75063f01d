/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The stack machine: values of expressions that are evaluated once (those that are evaluated often
 * become a program), and expr_linear(). */
#include <math.h>

#include "scene/formula/expr.h"

/* Zeros below the stack, as many as one operation takes at most: an operation on too few values
 * reads them instead of memory before the array. */
#define STACK_BOTTOM 3

/* Applies an operation to the last values of the stack; `top` is its end. Returns the new end. */
static inline double *operation_value(const struct op *op, double *top)
{
    switch (op->kind) {
    case OP_NUMBER: /* The caller handles values. */
    case OP_NAME:
        return top;
    case OP_NEG:
        top[-1] = -top[-1];
        return top;
    case OP_LESS:
        top[-2] = less_than(top[-2], top[-1]);
        return top - 1;
    case OP_GREATER:
        top[-2] = less_than(top[-1], top[-2]);
        return top - 1;
    case OP_LESS_EQUAL:
        top[-2] = less_equal(top[-2], top[-1]);
        return top - 1;
    case OP_GREATER_EQUAL:
        top[-2] = less_equal(top[-1], top[-2]);
        return top - 1;
    case OP_ADD:
        top[-2] += top[-1];
        return top - 1;
    case OP_SUB:
        top[-2] -= top[-1];
        return top - 1;
    case OP_MUL:
        top[-2] *= top[-1];
        return top - 1;
    case OP_DIV:
        top[-2] /= top[-1];
        return top - 1;
    case OP_POW:
        top[-2] = function_power(top[-2], top[-1]);
        return top - 1;
    case OP_CALL:
        break;
    }
    const struct function *f = op->function;
    if (f->one) {
        top[-1] = f->one(top[-1]);
        return top;
    }
    if (f->two) {
        top[-2] = f->two(top[-2], top[-1]);
        return top - 1;
    }
    top[-3] = f->three(top[-3], top[-2], top[-1]);
    return top - 2;
}

double *op_apply(const struct op *op, double *top)
{
    return operation_value(op, top);
}

/* Runs the operations in postfix order on a stack of values. */
double expr_value(const struct expr *expr, const struct expr_scope *scope)
{
    double stack[STACK_BOTTOM + LIMIT_EXPR_DEPTH] = {0}, *top = stack + STACK_BOTTOM;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NUMBER)
            *top++ = op->number;
        else if (op->kind == OP_NAME)
            *top++ = scope->load(scope->context, op->slot);
        else
            top = operation_value(op, top);
    }
    return top[-1]; /* the one value that is left */
}

/* ---- linearity ---- */

/* Returns true if the slot is one of `slot` [count]. */
static bool is_slot_listed(int wanted, const int *slot, int count)
{
    for (int i = 0; i < count; i++)
        if (slot[i] == wanted)
            return true;
    return false;
}

/* The stack holds the degree of each value in the chosen names: 0, 1, or 2 for anything that is not
 * linear. */
bool expr_linear(const struct expr *expr, const int *slot, int count)
{
    int stack[STACK_BOTTOM + LIMIT_EXPR_DEPTH] = {0}, *top = stack + STACK_BOTTOM;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NUMBER || op->kind == OP_NAME) {
            *top++ = op->kind == OP_NAME && is_slot_listed(op->slot, slot, count);
            continue;
        }
        int arity = op_arity(op);
        int first = top[-arity], last = top[-1], all = 0;
        for (int i = 1; i <= arity; i++)
            all += top[-i];
        top -= arity - 1;
        switch (op->kind) {
        case OP_ADD:
        case OP_SUB:
            top[-1] = first > last ? first : last;
            break;
        case OP_MUL:
            top[-1] = all < 2 ? all : 2;
            break;
        case OP_DIV:
            top[-1] = last == 0 ? first : 2;
            break;
        case OP_NEG:
            top[-1] = last;
            break;
        default:
            top[-1] = all == 0 ? 0 : 2;
        }
    }
    return stack[STACK_BOTTOM] < 2;
}
