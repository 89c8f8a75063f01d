/* SPDX-License-Identifier: GPL-3.0-or-later */
/* system_drive(): the period with which forces repeat in time. For each part of an expression it is
 * found out whether it is steady, grows with time at a steady rate, or repeats. */
#include <math.h>
#include <string.h>

#include "scene/formula/expr.h"
#include "scene/typed/typed.h"

#define RATIO_MOST 64   /* largest whole number in the ratio i:j of two periods */
#define RATIO_NEAR 1e-9 /* relative error of that ratio */

/* A part of an expression as a function of time. */
struct drive_part {
    bool known;    /* the value at t = 0 does not depend on the state */
    double value;  /* that value */
    double rate;   /* [1/s] rate at which it grows; 0 if it is steady or repeats */
    double period; /* [s] 0 if it does not repeat; NAN if it is neither steady nor repeats */
};

static const struct drive_part unknown = {false, 0, 0, 0}, neither = {false, 0, 0, NAN};

/* Returns the shortest time that is a whole multiple of both periods; NAN if there is none. A
 * period of 0 stands for a steady part. */
static double common_period(double p, double q)
{
    if (p == 0 || q == 0)
        return p == 0 ? q : p;
    for (int i = 1; i <= RATIO_MOST; i++) {
        const double j = nearbyint(i * p / q);
        if (j >= 1 && j <= RATIO_MOST && fabs(i * p - j * q) <= RATIO_NEAR * i * p)
            return i * p;
    }
    return NAN;
}

/* Returns true if the part does not depend on time. */
static bool steady(const struct drive_part *part)
{
    return part->rate == 0 && part->period == 0;
}

/* Returns a + sign b. */
static struct drive_part sum_of(const struct drive_part *a, const struct drive_part *b, double sign)
{
    const double rate = a->rate + sign * b->rate;
    const double period = common_period(a->period, b->period);
    if (rate != 0 && period != 0)
        return neither;
    return (struct drive_part){a->known && b->known, a->value + sign * b->value, rate, period};
}

/* Returns a b, which grows at a steady rate only if one of them does and the other is a known
 * number. */
static struct drive_part product_of(const struct drive_part *a, const struct drive_part *b)
{
    if ((steady(a) && a->known && a->value == 0) || (steady(b) && b->known && b->value == 0))
        return (struct drive_part){.known = true};
    if (a->rate == 0 && b->rate == 0)
        return (struct drive_part){a->known && b->known, a->value * b->value, 0,
                                   common_period(a->period, b->period)};
    const struct drive_part *moving = a->rate != 0 ? a : b;
    const struct drive_part *other = a->rate != 0 ? b : a;
    if (!steady(other) || !other->known)
        return neither;
    return (struct drive_part){moving->known, moving->value * other->value,
                               moving->rate * other->value, 0};
}

/* Returns the value of a function whose first argument depends on time: it repeats for mod() and
 * circular functions of time. */
static struct drive_part call_of(const char *name, const struct drive_part *argument)
{
    if (strcmp(name, "mod") == 0 && argument[0].rate != 0 && steady(&argument[1]) &&
        argument[1].known && argument[1].value != 0)
        return (struct drive_part){.period = fabs(argument[1].value / argument[0].rate)};
    double turn;
    if (strcmp(name, "sin") == 0 || strcmp(name, "cos") == 0)
        turn = 2 * acos(-1);
    else
        turn = strcmp(name, "tan") == 0 ? acos(-1) : 0;
    if (argument[0].rate != 0)
        return turn > 0 ? (struct drive_part){.period = turn / fabs(argument[0].rate)} : neither;
    return (struct drive_part){.period = argument[0].period};
}

/* Returns what an operation on the operands a [arity] is as a part of a drive: a constant, a
 * function of time with a period or a rate, or `neither`. */
static struct drive_part operation_apply(const struct op *op, const struct drive_part *a, int arity)
{
    static const struct drive_part none = {.known = true};
    double stack[3], period = 0;
    bool known = true, moves = false;
    for (int i = 0; i < arity; i++) {
        known = known && a[i].known && steady(&a[i]);
        moves = moves || a[i].rate != 0;
        period = common_period(period, a[i].period);
        stack[i] = a[i].value;
    }
    if (known) {
        op_apply(op, stack + arity);
        return (struct drive_part){.known = true, .value = stack[0]};
    }
    switch (op->kind) {
    case OP_ADD:
        return sum_of(&a[0], &a[1], 1);
    case OP_SUB:
        return sum_of(&a[0], &a[1], -1);
    case OP_NEG:
        return sum_of(&none, &a[0], -1);
    case OP_MUL:
        return product_of(&a[0], &a[1]);
    case OP_DIV: {
        struct drive_part divisor = a[1];
        if (divisor.rate != 0)
            return neither;
        divisor.value = 1 / divisor.value;
        return product_of(&a[0], &divisor);
    }
    case OP_CALL:
        if (!moves || arity == 1 || a[1].rate == 0)
            return moves ? call_of(op->function->row.name, a)
                         : (struct drive_part){.period = period};
        return neither;
    default:
        return moves ? neither : (struct drive_part){.period = period};
    }
}

/* Returns the expression as a function of time, given its names. */
static struct drive_part part_of(const struct expr *expr, const struct drive_part *name)
{
    struct drive_part stack[LIMIT_EXPR_DEPTH] = {{.known = false}};
    int top = 0;
    for (size_t i = 0; i < expr->count; i++) {
        const struct op *op = &expr->op[i];
        if (op->kind == OP_NUMBER) {
            stack[top++] = (struct drive_part){.known = true, .value = op->number};
        } else if (op->kind == OP_NAME) {
            stack[top++] = name[op->slot];
        } else {
            const int arity = op_arity(op);
            top -= arity;
            stack[top] = operation_apply(op, stack + top, arity);
            top++;
        }
    }
    return stack[0];
}

/* Returns the period of all typed forces; NAN if they do not repeat. c are the values of a bound
 * term. */
static double typed_drive(const struct typed *typed, const double *c)
{
    struct drive_part name[TYPED_NAMES_MAX];
    const int n = typed->model.n, first = typed_first_observed(typed);
    double period = 0;
    name[0] = (struct drive_part){.known = true, .rate = 1};
    for (int i = 0; i < n; i++)
        name[1 + i] = unknown;
    for (int i = 0; i <= typed->reads; i++)
        name[1 + n + i] = (struct drive_part){.known = true, .value = c[1 + i]};
    for (int i = 0; i < typed->observes; i++)
        name[first + i] = part_of(typed->observe[i], name);
    for (int g = 0; g < GROUPS; g++)
        for (int i = 0; typed->group[g] && i < typed_rows(typed); i++)
            if (typed->group[g][i]) {
                const struct drive_part part = part_of(typed->group[g][i], name);
                period = common_period(period, part.rate != 0 ? NAN : part.period);
            }
    return period;
}

/* Returns the common period of built-in drives and typed forces. */
double system_drive(const struct system *system)
{
    double period = 0;
    for (int i = 0; i < system->terms; i++) {
        const struct bound_term *term = &system->term[i];
        if (term->row->bind && term->row->flags & TERM_TIME)
            period =
                2 * acos(-1) / (strcmp(term->row->row.name, "drive") == 0 ? fabs(term->c[1]) : 1);
    }
    const struct typed *typed = system->model->typed;
    return typed && system->typed.row ? common_period(period, typed_drive(typed, system->typed.c))
                                      : period;
}
