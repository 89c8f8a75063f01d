/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds with a gap: how each operation changes the set of possible values (struct outer). */
#include "scene/formula/outer.h"

struct outer outer_interval(struct interval interval)
{
    return (struct outer){interval, false};
}

static struct outer anything(void)
{
    return outer_interval(interval_all);
}

/* Returns all numbers up to lo and from hi on, rounded outwards; everything if that leaves no
 * gap. */
static struct outer with_gap(double lo, double hi)
{
    const struct interval gap_begin = interval_wide(lo, lo, 2), gap_end = interval_wide(hi, hi, 2);
    if (!(gap_begin.hi < gap_end.lo))
        return anything();
    return (struct outer){{gap_begin.hi, gap_end.lo}, true};
}

static struct outer outer_negate(struct outer a)
{
    return (struct outer){interval_neg(a.interval), a.has_gap};
}

/* A gap shrinks by the width of the interval that is added; two gaps leave none. */
struct outer outer_add(struct outer a, struct outer b)
{
    if (!a.has_gap && !b.has_gap)
        return outer_interval(interval_add(a.interval, b.interval));
    if (a.has_gap && b.has_gap)
        return anything();
    const struct outer gap = a.has_gap ? a : b;
    const struct outer plain = a.has_gap ? b : a;
    if (interval_empty(plain.interval))
        return plain;
    return with_gap(gap.interval.lo + plain.interval.hi, gap.interval.hi + plain.interval.lo);
}

/* Returns numbers with a gap, multiplied by those of an interval above 0. */
static struct outer outer_stretch(struct interval gap, struct interval factor)
{
    const double lo_factor = gap.lo <= 0 ? factor.lo : factor.hi;
    return with_gap(gap.lo * lo_factor, gap.hi * (gap.hi >= 0 ? factor.lo : factor.hi));
}

/* Returns true if 0 is inside of the gap. */
static bool has_zero_in_gap(struct outer a)
{
    return a.has_gap && a.interval.lo < 0 && a.interval.hi > 0;
}

/* Returns bounds of all products of a number in a and one in b. */
static struct outer outer_multiply(struct outer a, struct outer b)
{
    if (!a.has_gap && !b.has_gap)
        return outer_interval(interval_mul(a.interval, b.interval));
    if (a.has_gap && b.has_gap) {
        if (!has_zero_in_gap(a) || !has_zero_in_gap(b))
            return anything();
        return with_gap(fmax(a.interval.hi * b.interval.lo, a.interval.lo * b.interval.hi),
                        fmin(a.interval.hi * b.interval.hi, a.interval.lo * b.interval.lo));
    }
    const struct outer gap = a.has_gap ? a : b;
    const struct outer plain = a.has_gap ? b : a;
    if (interval_empty(plain.interval))
        return plain;
    if (plain.interval.lo > 0)
        return outer_stretch(gap.interval, plain.interval);
    if (plain.interval.hi < 0)
        return outer_negate(outer_stretch(gap.interval, interval_neg(plain.interval)));
    return anything();
}

/* Returns bounds of 1/a. If a contains 0, these are all numbers except a gap around 0. */
static struct outer outer_inverse(struct outer a)
{
    if (!a.has_gap && !interval_has(a.interval, 0))
        return outer_interval(interval_div(interval_point(1), a.interval));
    if (!a.has_gap) {
        const double lo = a.interval.lo < 0 ? 1 / a.interval.lo : -HUGE_VAL;
        const double hi = a.interval.hi > 0 ? 1 / a.interval.hi : HUGE_VAL;
        return a.interval.lo == 0 && a.interval.hi == 0 ? anything() : with_gap(lo, hi);
    }
    if (!has_zero_in_gap(a))
        return anything();
    return outer_interval(interval_wide(1 / a.interval.lo, 1 / a.interval.hi, 2));
}

/* Returns bounds of a^n. */
static struct outer outer_power(struct outer a, int n)
{
    if (n < 0)
        return outer_inverse(outer_power(a, -n));
    if (!a.has_gap)
        return outer_interval(interval_power(a.interval, n));
    struct outer product = outer_interval(interval_point(1));
    for (int k = 0; k < n; k++)
        product = outer_multiply(product, a);
    return product;
}

/* Returns a jet whose value contains a: a constant if that is one number, because functions treat a
 * constant argument differently; else with unknown slopes. */
static struct jet outer_hull(struct outer a)
{
    if (!a.has_gap && a.interval.lo == a.interval.hi)
        return jet_number(a.interval.lo);
    return (struct jet){a.has_gap ? interval_all : a.interval, interval_all, interval_all};
}

/* Returns the bounds of an operation on x; operations other than + - * / and whole powers use
 * intervals. */
static struct outer outer_of_operation(const struct op *op, const struct outer *x)
{
    switch (op->kind) {
    case OP_NUMBER:
        return outer_interval(interval_point(op->number));
    case OP_NEG:
        return outer_negate(x[0]);
    case OP_ADD:
        return outer_add(x[0], x[1]);
    case OP_SUB:
        return outer_add(x[0], outer_negate(x[1]));
    case OP_MUL:
        return outer_multiply(x[0], x[1]);
    case OP_DIV:
        return outer_multiply(x[0], outer_inverse(x[1]));
    case OP_POW: {
        const double n = x[1].interval.lo;
        if (!x[1].has_gap && n == x[1].interval.hi && n == floor(n) && fabs(n) <= 8)
            return outer_power(x[0], (int)n);
        break;
    }
    default:
        break;
    }
    struct jet jet[3];
    for (int i = 0; i < op_arity(op); i++)
        jet[i] = outer_hull(x[i]);
    return outer_interval(jet_apply(op, jet).value);
}

bool outer_excludes_zero(struct outer a)
{
    if (a.has_gap)
        return has_zero_in_gap(a);
    return a.interval.lo > 0 || a.interval.hi < 0 || interval_empty(a.interval);
}

/* Runs the operations in postfix order on a stack of such bounds. */
struct outer expr_outer(const struct expr *expr, const struct jet *jet)
{
    struct outer stack[LIMIT_EXPR_DEPTH], *top = stack;
    stack[0] = stack[1] = outer_interval(interval_point(0));
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NAME) {
            *top++ = outer_interval(jet[op->slot].value);
            continue;
        }
        top -= op->kind == OP_NUMBER ? 0 : op_arity(op);
        *top = outer_of_operation(op, top);
        top++;
    }
    return stack[0];
}
