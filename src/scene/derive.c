/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Exact partial derivatives of expressions: the stack machine run on dual numbers (Wengert 1964; forward mode), so that
 * nothing grows and what value and derivatives share is computed once. And which names an expression is linear in.
 */
#include <math.h>
#include <string.h>

#include "expr.h"

enum { LANES = 8 }; /* directions in one pass */

/* ---- slopes of functions ---- */

static double slope_tan(double x, double value)
{
    (void)x;
    return 1 + value * value;
}

static double slope_asin(double x, double value)
{
    (void)value;
    return 1 / sqrt((1 - x) * (1 + x));
}

static double slope_acos(double x, double value)
{
    (void)value;
    return -1 / sqrt((1 - x) * (1 + x));
}

static double slope_atan(double x, double value)
{
    (void)value;
    return 1 / (1 + x * x);
}

static double slope_sin(double x, double value)
{
    (void)value;
    return cos(x);
}

static double slope_cos(double x, double value)
{
    (void)value;
    return -sin(x);
}

static double slope_sinh(double x, double value)
{
    (void)value;
    return cosh(x);
}

static double slope_cosh(double x, double value)
{
    (void)value;
    return sinh(x);
}

static double slope_tanh(double x, double value)
{
    (void)value;
    double c = cosh(x); /* 1 - tanh^2 would cancel */
    return 1 / (c * c);
}

static double slope_sqrt(double x, double value)
{
    (void)x;
    return 0.5 / value;
}

static double slope_cbrt(double x, double value)
{
    (void)x;
    return 1 / (3 * value * value);
}

static double slope_exp(double x, double value)
{
    (void)x;
    return value;
}

static double slope_log(double x, double value)
{
    (void)value;
    return 1 / x;
}

static double slope_log10(double x, double value)
{
    (void)value;
    return 1 / (2.30258509299404568402 * x);
}

static double slope_abs(double x, double value)
{
    (void)value;
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

/* Functions of one argument that are not here are steps: their slope is 0. */
static const struct {
    double (*function)(double);
    double (*slope)(double x, double value);
} slopes[] = {
    {sin, slope_sin},   {cos, slope_cos},   {tan, slope_tan},   {asin, slope_asin},   {acos, slope_acos},
    {atan, slope_atan}, {sinh, slope_sinh}, {cosh, slope_cosh}, {tanh, slope_tanh},   {sqrt, slope_sqrt},
    {cbrt, slope_cbrt}, {exp, slope_exp},   {log, slope_log},   {log10, slope_log10}, {fabs, slope_abs},
};

static double slope_of(double (*function)(double), double x, double value)
{
    for (size_t i = 0; i < COUNT_OF(slopes); i++)
        if (slopes[i].function == function)
            return slopes[i].slope(x, value);
    return 0;
}

/* Partial derivatives of a^b. Where a factor in front is 0 the limit is taken, not 0 times infinity. */
static void slopes_pow(double a, double b, double value, double by[2])
{
    by[0] = b == 0 ? 0 : b * pow(a, b - 1);
    by[1] = a == 0 && b > 0 ? 0 : value * log(a);
}

static void slopes_two(const struct function *f, double a, double b, double value, double by[2])
{
    if (f->two == pow) {
        slopes_pow(a, b, value, by);
    } else if (f->two == atan2) {
        double r = hypot(a, b);
        by[0] = b / r / r;
        by[1] = -a / r / r;
    } else if (f->two == hypot) {
        by[0] = value > 0 ? a / value : 0;
        by[1] = value > 0 ? b / value : 0;
    } else { /* min, max: that of the one that was chosen */
        by[0] = value == a;
        by[1] = value != a;
    }
}

/* ---- evaluation ---- */

struct dual {
    double value, by[LANES];
};

/* A derivative that is exactly 0 stays so, whatever the slope: sqrt(0) does not spoil what does not depend on it. */
static double chain(double slope, double by)
{
    return by == 0 ? 0 : slope * by;
}

static void apply_one(struct dual *x, double value, double slope)
{
    for (int k = 0; k < LANES; k++)
        x->by[k] = chain(slope, x->by[k]);
    x->value = value;
}

static void apply_two(struct dual *x, const struct dual *y, double value, double by_x, double by_y)
{
    for (int k = 0; k < LANES; k++)
        x->by[k] = chain(by_x, x->by[k]) + chain(by_y, y->by[k]);
    x->value = value;
}

/* Applies an operator or a function; top points behind the last value. Returns the new top. */
static struct dual *apply(const struct op *op, struct dual *top)
{
    struct dual *x = top - 2, *y = top - 1;
    double by[2], value;
    switch (op->kind) {
    case OP_NUMBER: /* values: the caller's business */
    case OP_NAME:
        return top;
    case OP_NEG:
        apply_one(y, -y->value, -1);
        return top;
    case OP_ADD:
        apply_two(x, y, x->value + y->value, 1, 1);
        return y;
    case OP_SUB:
        apply_two(x, y, x->value - y->value, 1, -1);
        return y;
    case OP_MUL:
        apply_two(x, y, x->value * y->value, y->value, x->value);
        return y;
    case OP_DIV:
        value = x->value / y->value;
        apply_two(x, y, value, 1 / y->value, -value / y->value);
        return y;
    case OP_POW:
        value = pow(x->value, y->value);
        slopes_pow(x->value, y->value, value, by);
        apply_two(x, y, value, by[0], by[1]);
        return y;
    case OP_CALL:
        break;
    }
    const struct function *f = op->function;
    if (f->one) {
        value = f->one(y->value);
        apply_one(y, value, slope_of(f->one, y->value, value));
        return top;
    }
    if (f->two) {
        value = f->two(x->value, y->value);
        slopes_two(f, x->value, y->value, value, by);
        apply_two(x, y, value, by[0], by[1]);
        return y;
    }
    /* if(c, a, b) */
    value = f->three(x[-1].value, x->value, y->value);
    x[-1] = x[-1].value > 0 ? *x : *y;
    x[-1].value = value;
    return x;
}

double expr_gradient(const struct expr *expr, const struct expr_scope *scope, const int *slot, int count,
                     double *gradient)
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

/* Degree of each value on the stack in the chosen names: 0, 1, or 2 for anything that is not linear. */
bool expr_linear(const struct expr *expr, const int *slot, int count)
{
    int stack[LIMIT_EXPR_DEPTH], *top = stack;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NUMBER || op->kind == OP_NAME) {
            *top++ = op->kind == OP_NAME && among(op->slot, slot, count);
            continue;
        }
        int arity = op->kind == OP_NEG ? 1 : op->kind == OP_CALL ? function_arity(op->function) : 2;
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
