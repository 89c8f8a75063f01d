/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the compiler and the evaluators of expressions. */
#pragma once

#include <hooke/base/elementary.h>
#include <hooke/scene.h>
#include <hooke/scene/dimension.h>

/* Rules for the dimension of a function, given those of its arguments. */
enum function_dimension {
    FUNCTION_PURE,  /* a number of numbers or angles */
    FUNCTION_ANGLE, /* the same of radians */
    FUNCTION_SAME,  /* the dimension of its argument, or of several that are alike */
    FUNCTION_SIGN,  /* a number of anything alike */
    FUNCTION_SQUARE_ROOT,
    FUNCTION_CUBE_ROOT,
    FUNCTION_POWER,
    /* the dimension of the second and the third argument, which are alike */
    FUNCTION_CHOICE
};

/* One of the three is set: it says how many arguments there are. */
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

/* Functions that have to return NaN for a NaN argument, and that programs know without a call. */
/* Those that have a slope, of libm or our own. */
#define ONE(function, ...) double function(double x);
#define TWO(function, ...) double function(double x, double y);
#include "scene/formula/slopes.def"
#undef ONE
#undef TWO
double function_sign(double x);
double function_step(double x);

/* 1 or 0; NaN where an argument is. */
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

/*
 * x^n is multiplications where n is an integer or half of one, at most POWER_MAX in size: the bits
 * of |n| from the highest down, r r for each and r x for a 1, then sqrt(x) for the half; 1/that for
 * n < 0. Everywhere the same, so that it does not matter when n becomes known.
 */
#define POWER_MAX 16

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
    struct typed_operand typed; /* all of it: while the text that it was compiled from exists */
};

/* Operands of an operation that is not a value. */
static inline int op_arity(const struct op *op)
{
    if (op->kind == OP_NEG)
        return 1;
    return op->kind == OP_CALL ? function_arity(op->function) : 2;
}

/* Applies an operator or a function; top points behind the last value. Returns the new top. */
double *op_apply(const struct op *op, double *top);
