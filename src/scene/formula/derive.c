/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Exact partial derivatives of expressions: the stack machine run on dual numbers (Wengert 1964;
 * forward mode), so that nothing grows and what value and derivatives share is computed once. And
 * which names an expression is linear in.
 */
#include <math.h>
#include <string.h>

#include "scene/formula/expr.h"

enum { LANES = 8 }; /* directions in one pass */

/* ---- slopes of functions: slopes.def with numbers ---- */

#define NUMBER(x) ((double)(x))
#define NEG(a) (-(a))
#define ABS(a) fabs(a)
#define SQRT(a) sqrt(a)
#define ADD(a, b) ((a) + (b))
#define SUB(a, b) ((a) - (b))
#define MUL(a, b) ((a) * (b))
#define DIV(a, b) ((a) / (b))
#define LESS(a, b) less(a, b)
#define LESS_EQUAL(a, b) less_equal(a, b)
#define IF(c, a, b) function_choose(c, a, b)
#define CALL(function, a) function(a)
#define CALL2(function, a, b) function(a, b)

static double slope_one(double (*function)(double), double X, double U)
{
#define ONE(name, by_x)                                                                            \
    if (function == (name))                                                                        \
        return by_x;
#define TWO(name, by_x, by_y)
#include "scene/formula/slopes.def"
#undef ONE
#undef TWO
    return 0;
}

static void slopes_two(double (*function)(double, double), double X, double Y, double U,
                       double by[2])
{
#define ONE(name, by_x)
#define TWO(name, by_x, by_y)                                                                      \
    if (function == (name)) {                                                                      \
        by[0] = by_x;                                                                              \
        by[1] = by_y;                                                                              \
    }
#include "scene/formula/slopes.def"
#undef ONE
#undef TWO
}

/* Partial derivatives by the operands; those that are not set are 0: comparisons are steps. */
static void slopes_op(const struct op *op, const double *x, double value, double by[3])
{
    switch (op->kind) {
    case OP_NEG:
        by[0] = -1;
        break;
    case OP_ADD:
        by[0] = by[1] = 1;
        break;
    case OP_SUB:
        by[0] = 1;
        by[1] = -1;
        break;
    case OP_MUL:
        by[0] = x[1];
        by[1] = x[0];
        break;
    case OP_DIV:
        by[0] = 1 / x[1];
        by[1] = -value / x[1];
        break;
    case OP_POW:
        slopes_two(function_power, x[0], x[1], value, by);
        break;
    case OP_CALL:
        if (op->function->one)
            by[0] = slope_one(op->function->one, x[0], value);
        else if (op->function->two)
            slopes_two(op->function->two, x[0], x[1], value, by);
        else /* if(c, a, b) */
            by[x[0] > 0 ? 1 : 2] = 1;
        break;
    default:
        break;
    }
}

/* ---- evaluation ---- */

struct dual {
    double value, by[LANES];
};

/* What is exactly 0 stays so: sqrt(0) does not spoil what does not depend on it, nor a branch what
 * does not take it. */
static double chain(double slope, double by)
{
    return by == 0 || slope == 0 ? 0 : slope * by;
}

/* Applies an operator or a function; top points behind the last value. Returns the new top. */
static struct dual *apply(const struct op *op, struct dual *top)
{
    int arity = op_arity(op);
    double operand[3], value[3], by[3] = {0, 0, 0};
    struct dual *x = top - arity;
    for (int i = 0; i < arity; i++)
        operand[i] = value[i] = x[i].value;
    op_apply(op, value + arity);
    slopes_op(op, operand, value[0], by);
    for (int k = 0; k < LANES; k++) {
        double sum = chain(by[0], x[0].by[k]);
        for (int i = 1; i < arity; i++)
            sum += chain(by[i], x[i].by[k]);
        x->by[k] = sum;
    }
    x->value = value[0];
    return x + 1;
}

double expr_gradient(const struct expr *expr, const struct expr_scope *scope, const int *slot,
                     int count, double *gradient)
{
    struct dual stack[LIMIT_EXPR_DEPTH];
    for (int first = 0; first == 0 || first < count; first += LANES) {
        struct dual *top = stack;
        int lanes = count - first < LANES ? count - first : LANES;
        for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
            if (op->kind == OP_NUMBER) {
                *top++ = (struct dual){.value = op->number};
            } else if (op->kind == OP_NAME) {
                *top = (struct dual){.value = scope->load(scope->context, op->slot)};
                for (int k = 0; k < lanes; k++)
                    top->by[k] = op->slot == slot[first + k];
                top++;
            } else {
                top = apply(op, top);
            }
        }
        if (lanes > 0)
            memcpy(gradient + first, stack[0].by, (size_t)lanes * sizeof *gradient);
    }
    return stack[0].value;
}

/* ---- linearity ---- */

static bool among(int wanted, const int *slot, int count)
{
    for (int i = 0; i < count; i++)
        if (slot[i] == wanted)
            return true;
    return false;
}

/* Degree of each value on the stack in the chosen names: 0, 1, or 2 for anything that is not
 * linear. */
bool expr_linear(const struct expr *expr, const int *slot, int count)
{
    int stack[LIMIT_EXPR_DEPTH], *top = stack;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NUMBER || op->kind == OP_NAME) {
            *top++ = op->kind == OP_NAME && among(op->slot, slot, count);
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
    return stack[0] < 2;
}
