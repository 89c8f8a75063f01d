/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of operations and of functions of two arguments, and evaluation of expressions with them.
 * jet_functions.c has the functions of one argument. */
#include "scene/formula/jet.h"

struct jet jet_number(double number)
{
    const struct interval nothing = {0, 0};
    return (struct jet){interval_point(number), nothing, nothing};
}

struct jet jet_jump(double lo, double hi)
{
    return (struct jet){{lo, hi}, interval_all, interval_all};
}

static struct jet jet_neg(struct jet a)
{
    return (struct jet){interval_neg(a.value), interval_neg(a.slope), interval_neg(a.bend)};
}

struct jet jet_add(struct jet a, struct jet b)
{
    return (struct jet){interval_add(a.value, b.value), interval_add(a.slope, b.slope),
                        interval_add(a.bend, b.bend)};
}

static struct jet jet_sub(struct jet a, struct jet b)
{
    return jet_add(a, jet_neg(b));
}

/* Returns true if the bounded function is constant. */
static bool jet_is_number(const struct jet *a)
{
    return a->slope.lo == 0 && a->slope.hi == 0 && a->bend.lo == 0 && a->bend.hi == 0;
}

/* Returns the bounds of factor times a. */
static struct jet jet_scaled(struct interval factor, const struct jet *a)
{
    return (struct jet){interval_mul(factor, a->value), interval_mul(factor, a->slope),
                        interval_mul(factor, a->bend)};
}

/* Returns a b; (a b)'' = a'' b + 2 a' b' + a b''. */
static struct jet jet_mul(struct jet a, struct jet b)
{
    if (jet_is_number(&a) || jet_is_number(&b))
        return jet_is_number(&a) ? jet_scaled(a.value, &b) : jet_scaled(b.value, &a);
    const struct interval both = interval_mul(a.slope, b.slope);
    return (struct jet){
        interval_mul(a.value, b.value),
        interval_add(interval_mul(a.slope, b.value), interval_mul(a.value, b.slope)),
        interval_add(interval_add(interval_mul(a.bend, b.value), interval_mul(a.value, b.bend)),
                     interval_add(both, both))};
}

/* Returns q = a/b; q' = (a' - q b')/b, q'' = (a'' - 2 q' b' - q b'')/b. */
static struct jet jet_div(struct jet a, struct jet b)
{
    struct jet q = {.value = interval_div(a.value, b.value)};
    const struct interval rise = interval_sub(a.slope, interval_mul(q.value, b.slope));
    q.slope = interval_div(rise, b.value);
    const struct interval both = interval_mul(q.slope, b.slope);
    const struct interval bend =
        interval_sub(interval_sub(a.bend, interval_add(both, both)), interval_mul(q.value, b.bend));
    q.bend = interval_div(bend, b.value);
    return q;
}

/* Returns bounds of the truth value (1 or 0) of a < b, or of a <= b if `equal` is true: 0 to 1 if
 * the bounds of a and b do not decide it, NAN if a or b has no value. */
static struct jet jet_less(struct jet a, struct jet b, bool equal)
{
    if (interval_empty(a.value) || interval_empty(b.value))
        return jet_jump(NAN, NAN);
    if (a.value.hi < b.value.lo || (equal && a.value.hi <= b.value.lo))
        return jet_number(1);
    if (a.value.lo > b.value.hi || (!equal && a.value.lo >= b.value.hi))
        return jet_number(0);
    return jet_jump(0, 1);
}

/* Returns one of two branches, or bounds of both, with any slope, if the condition is not
 * decided. */
static struct jet jet_if(struct jet condition, struct jet yes, struct jet no)
{
    if (interval_empty(condition.value))
        return jet_jump(NAN, NAN);
    if (condition.value.lo > 0)
        return yes;
    if (condition.value.hi <= 0)
        return no;
    const struct interval hull = interval_hull(yes.value, no.value);
    return jet_jump(hull.lo, hull.hi);
}

/* ---- functions of two arguments ---- */

/* Returns bounds of a choice between two functions that is continuous, with values from lo to hi;
 * its slope is one of theirs. */
static struct jet jet_choice(const struct jet *a, const struct jet *b, double lo, double hi)
{
    return (struct jet){{lo, hi}, interval_hull(a->slope, b->slope), interval_all};
}

/* Returns the smaller one of a and b. */
static struct jet jet_min(struct jet a, struct jet b)
{
    if (interval_empty(a.value) || interval_empty(b.value))
        return jet_jump(NAN, NAN);
    if (a.value.hi < b.value.lo || b.value.hi < a.value.lo)
        return a.value.hi < b.value.lo ? a : b;
    return jet_choice(&a, &b, fmin(a.value.lo, b.value.lo), fmin(a.value.hi, b.value.hi));
}

/* Returns a^2, with tighter bounds than a a. */
static struct jet jet_square(struct jet a)
{
    struct jet result = jet_mul(a, a);
    const struct interval bend = interval_mul(a.value, a.bend);
    result.value = interval_square(a.value);
    result.bend = interval_add(interval_square(a.slope), bend);
    result.bend = interval_add(result.bend, result.bend);
    return result;
}

/* Returns sqrt(a^2 + b^2); from 0 on without an upper bound if the squares overflow. */
static struct jet jet_hypot(struct jet a, struct jet b)
{
    struct jet result = jet_one(sqrt, jet_add(jet_square(a), jet_square(b)));
    if (!(result.value.hi < HUGE_VAL) && !interval_empty(result.value))
        result.value = (struct interval){0, HUGE_VAL};
    return result;
}

/* Returns the angle of the point (x, y). Its slope is (x y' - y x')/(x^2 + y^2) except where it
 * jumps, at y = 0 with x < 0. */
static struct jet jet_atan2(struct jet y, struct jet x)
{
    if (interval_empty(y.value) || interval_empty(x.value))
        return jet_jump(NAN, NAN);
    const struct jet quarter = jet_number(M_PI_2);
    struct jet result;
    if (x.value.lo > 0)
        return jet_one(fixed_atan, jet_div(y, x));
    if (y.value.lo > 0)
        result = jet_sub(quarter, jet_one(fixed_atan, jet_div(x, y)));
    else if (y.value.hi < 0)
        result = jet_neg(jet_add(quarter, jet_one(fixed_atan, jet_div(x, y))));
    else
        return jet_jump(-4, 4);
    result.value = interval_wide(result.value.lo, result.value.hi, 4);
    return result;
}

/* Returns the remainder of a divided by b, which jumps unless the quotient's whole part is the same
 * everywhere. */
static struct jet jet_mod(struct jet a, struct jet b)
{
    if (interval_empty(a.value) || interval_empty(b.value))
        return jet_jump(NAN, NAN);
    const struct interval ratio = interval_div(a.value, b.value);
    const struct interval wide = interval_wide(ratio.lo, ratio.hi, 4);
    if (floor(wide.lo) == floor(wide.hi) && fabs(wide.hi) < 0x1p52)
        return jet_sub(a, jet_mul(b, jet_number(floor(wide.lo))));
    return jet_jump(fmin(b.value.lo, 0), fmax(b.value.hi, 0));
}

/* Returns x^n for an integer n, or half of one: (x^n)' = n x^(n-1) x'. */
static struct jet jet_power_constant(struct jet x, double n)
{
    if (n == 0)
        return jet_number(1);
    if (n != floor(n)) {
        const struct jet root = jet_one(sqrt, x);
        return jet_mul(jet_power_constant(x, floor(n)), root);
    }
    const int k = (int)n;
    const struct interval one = interval_power(x.value, k - 1), factor = interval_point(n);
    const struct interval two = k == 1 ? interval_point(0) : interval_power(x.value, k - 2);
    const struct interval once = interval_mul(factor, one);
    const struct interval twice = interval_mul(interval_point(n * (n - 1)), two);
    return (struct jet){
        interval_power(x.value, k), interval_mul(once, x.slope),
        interval_add(interval_mul(twice, interval_square(x.slope)), interval_mul(once, x.bend))};
}

/* Returns x^n. In general this is exp(n log x), for which x has to be above 0. */
static struct jet jet_power(struct jet x, struct jet n)
{
    const bool fixed = jet_is_number(&n) && n.value.lo == n.value.hi;
    if (fixed && power_is_short(n.value.lo))
        return jet_power_constant(x, n.value.lo);
    if (interval_empty(x.value) && interval_has(n.value, 0))
        return jet_jump(1, 1); /* pow(NAN, 0) */
    if (interval_empty(x.value) || interval_empty(n.value))
        return jet_jump(NAN, NAN);
    if (x.value.lo > 0)
        return jet_one(fixed_exp, jet_mul(n, jet_one(fixed_log, x)));
    /* An exponent that varies may be a whole number somewhere, for which negative x have a power.
     */
    if (!fixed || n.value.lo == floor(n.value.lo))
        return jet_jump(-HUGE_VAL, HUGE_VAL);
    if (x.value.hi < 0)
        return jet_jump(NAN, NAN);
    /* The power grows with x, from 0 at 0, if n > 0. */
    if (!(n.value.lo > 0))
        return jet_jump(0, HUGE_VAL);
    return jet_jump(0, x.value.hi == 0 ? 0 : jet_power(jet_number(x.value.hi), n).value.hi);
}

/* Returns the bounds of a function of two arguments; no bounds if it is not known here. */
static struct jet jet_two(double (*function)(double, double), struct jet a, struct jet b)
{
    if (function == function_power)
        return jet_power(a, b);
    if (function == function_min)
        return jet_min(a, b);
    if (function == function_max)
        return jet_neg(jet_min(jet_neg(a), jet_neg(b)));
    if (function == function_mod)
        return jet_mod(a, b);
    if (function == (double (*)(double, double))fixed_hypot)
        return jet_hypot(a, b);
    if (function == (double (*)(double, double))fixed_atan2)
        return jet_atan2(a, b);
    return jet_jump(-HUGE_VAL, HUGE_VAL);
}

/* ---- expressions ---- */

/* Returns the bounds of an operation on x. */
struct jet jet_apply(const struct op *op, const struct jet *x)
{
    switch (op->kind) {
    case OP_NUMBER:
        return jet_number(op->number);
    case OP_NEG:
        return jet_neg(x[0]);
    case OP_LESS:
    case OP_LESS_EQUAL:
        return jet_less(x[0], x[1], op->kind == OP_LESS_EQUAL);
    case OP_GREATER:
    case OP_GREATER_EQUAL:
        return jet_less(x[1], x[0], op->kind == OP_GREATER_EQUAL);
    case OP_ADD:
        return jet_add(x[0], x[1]);
    case OP_SUB:
        return jet_sub(x[0], x[1]);
    case OP_MUL:
        return jet_mul(x[0], x[1]);
    case OP_DIV:
        return jet_div(x[0], x[1]);
    case OP_POW:
        return jet_two(function_power, x[0], x[1]);
    case OP_CALL:
        if (op->function->one)
            return jet_one(op->function->one, x[0]);
        return op->function->two ? jet_two(op->function->two, x[0], x[1])
                                 : jet_if(x[0], x[1], x[2]);
    case OP_NAME:
        break;
    }
    return x[0];
}

/* Runs the operations in postfix order on a stack of bounds. */
struct jet expr_jet(const struct expr *expr, const struct jet *jet)
{
    struct jet stack[LIMIT_EXPR_DEPTH], *top = stack;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++) {
        if (op->kind == OP_NAME) {
            *top++ = jet[op->slot];
            continue;
        }
        top -= op->kind == OP_NUMBER ? 0 : op_arity(op);
        *top = jet_apply(op, top);
        top++;
    }
    return stack[0];
}

/* Narrows the bounds of a value to those of the mean value form, centre + slope [-half, half]. */
static void jet_narrow(struct jet *a, struct interval centre, double half)
{
    const struct interval change = interval_mul(a->slope, (struct interval){-half, half});
    const struct interval enclosure = interval_add(centre, change);
    /* no numbers */
    if (!(enclosure.lo <= enclosure.hi && enclosure.lo <= a->value.hi &&
          enclosure.hi >= a->value.lo))
        return;
    a->value.lo = fmax(a->value.lo, enclosure.lo);
    a->value.hi = fmin(a->value.hi, enclosure.hi);
}

/* Runs the operations on two stacks, bounds over the interval and at its centre, which narrow each
 * other. */
struct jet expr_jet_about(const struct expr *expr, const struct jet *jet, const struct jet *centre,
                          double half)
{
    struct jet stack[2][LIMIT_EXPR_DEPTH];
    stack[0][0] = stack[0][1] = stack[1][0] = stack[1][1] = jet_number(0);
    int top = 0;
    for (const struct op *op = expr->op; op < expr->op + expr->count; op++, top++) {
        if (op->kind == OP_NAME) {
            stack[0][top] = jet[op->slot];
            stack[1][top] = centre[op->slot];
            continue;
        }
        top -= op->kind == OP_NUMBER ? 0 : op_arity(op);
        stack[0][top] = jet_apply(op, &stack[0][top]);
        stack[1][top] = jet_apply(op, &stack[1][top]);
        jet_narrow(&stack[0][top], stack[1][top].value, half);
    }
    return stack[0][0];
}

/* Copies the expression: names that move get the slot that slot() returns, others their value. */
const struct expr *expr_settle(const struct expr *expr, const struct expr_scope *scope,
                               int (*slot)(void *context, int slot), void *context,
                               struct arena *arena)
{
    struct expr *settled = arena_alloc(arena, sizeof *settled);
    struct op *op = arena_array(arena, expr->count, sizeof *op);
    if (!settled || !op)
        return NULL;
    *settled = (struct expr){.op = op, .count = expr->count, .capacity = expr->count};
    for (size_t i = 0; i < expr->count; i++) {
        op[i] = expr->op[i];
        if (op[i].kind != OP_NAME)
            continue;
        const int moves = slot(context, op[i].slot);
        if (moves >= 0)
            op[i].slot = moves;
        else
            op[i] =
                (struct op){.kind = OP_NUMBER, .number = scope->load(scope->context, op[i].slot)};
    }
    return settled;
}
