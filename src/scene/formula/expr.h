/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compiled expressions: a list of operations in postfix order for a stack of values. Shared by the
 * compiler (expr.c, units.c) and by everything that evaluates them: values, bounds, programs. */
#pragma once

#include <hooke/base/elementary.h>
#include <hooke/scene.h>
#include <hooke/scene/dimension.h>

/* Rules for the dimensions of a function's arguments and value. */
enum function_dimension {
    FUNCTION_PURE,        /* arguments are numbers or angles, the value is a number */
    FUNCTION_ANGLE,       /* the same, but no argument may be in cycles */
    FUNCTION_SAME,        /* arguments have one dimension, which is that of the value */
    FUNCTION_SIGN,        /* arguments have one dimension, the value is a number */
    FUNCTION_SQUARE_ROOT, /* the value has the argument's dimension to the power 1/2 */
    FUNCTION_CUBE_ROOT,   /* the same for 1/3 */
    FUNCTION_POWER,       /* the value has that of the first to the power of the second */
    FUNCTION_CHOICE       /* the second and third argument have that of the value */
};

/* A function of expressions. One of the pointers is set: that of its number of arguments. */
struct function {
    struct row row;
    enum function_dimension dimension;
    double (*one)(double);
    double (*two)(double, double);
    double (*three)(double, double, double);
};

static inline int function_arity(const struct function *function)
{
    if (function->one)
        return 1;
    return function->two ? 2 : 3;
}

/* Functions with derivatives in slopes.def, of libm or defined here; and those that are constant
 * between jumps. All return NaN for a NaN argument. */
#define ONE(function, ...) double function(double x);
#define TWO(function, ...) double function(double x, double y);
#include "scene/formula/slopes.def"
#undef ONE
#undef TWO
double function_sign(double x);
double function_step(double x);

/* Return the truth of a < b and of a <= b as 1 or 0; NaN if an argument is NaN. */
static inline double less_than(double a, double b)
{
    double holds = a < b;
    return a != a || b != b ? NAN : holds;
}

static inline double less_equal(double a, double b)
{
    double holds = a <= b;
    return a != a || b != b ? NAN : holds;
}

/* Largest |n| for which x^n is made of multiplications, if n is an integer or half of one:
 * <hooke/scene/formula.h> tells in which order. All evaluators use the same, so that the bits of a
 * result do not depend on when n becomes known. */
#define POWER_MAX 16

/* Returns true if x^n is made of multiplications. */
static inline bool power_is_short(double n)
{
    return fabs(n) <= POWER_MAX && 2 * n == floor(2 * n);
}

enum op_kind {
    OP_NUMBER,
    OP_NAME,
    OP_LESS,
    OP_GREATER,
    OP_LESS_EQUAL,
    OP_GREATER_EQUAL,
    OP_ADD,
    OP_SUB,
    OP_MUL,
    OP_DIV,
    OP_POW,
    OP_NEG,
    OP_CALL
};

/* An operation on the stack of values. */
struct op {
    enum op_kind kind;
    union {
        double number;                   /* OP_NUMBER */
        int slot;                        /* OP_NAME */
        const struct function *function; /* OP_CALL */
    };
};

/* Dimension and text of a value on the compiler's stack. */
struct typed_operand {
    struct dimension dimension;
    struct text text;
    /* The number or parenthesis that it ends with, and the unit of that; empty if there is none. */
    struct text number, unit;
};

/* Expression in postfix order. The compiler ensures that the stack never holds more than
 * LIMIT_EXPR_DEPTH values. */
struct expr {
    struct op *op;
    size_t count, capacity;
    struct typed_operand typed; /* dimension and text of all; valid as long as that text exists */
};

/* Returns the number of operands of an operation that is not OP_NUMBER or OP_NAME. */
static inline int op_arity(const struct op *op)
{
    if (op->kind == OP_NEG)
        return 1;
    return op->kind == OP_CALL ? function_arity(op->function) : 2;
}

/* Applies an operator or a function to the last values of a stack, whose end is `top`. Returns the
 * new end. */
double *op_apply(const struct op *op, double *top);
