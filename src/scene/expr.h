/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the compiler and the evaluator of expressions share. */
#ifndef HOOKE_SCENE_EXPR_H
#define HOOKE_SCENE_EXPR_H

#include <hooke/scene.h>

/* One of the three is set: it says how many arguments there are. */
struct function {
    struct row row;
    double (*one)(double);
    double (*two)(double, double);
    double (*three)(double, double, double);
};

static inline int function_arity(const struct function *function)
{
    return function->one ? 1 : function->two ? 2 : 3;
}

enum op_kind { OP_NUMBER, OP_NAME, OP_ADD, OP_SUB, OP_MUL, OP_DIV, OP_POW, OP_NEG, OP_CALL };

/* An operation on the stack of values. */
struct op {
    enum op_kind kind;
    union {
        double number;                   /* OP_NUMBER */
        int slot;                        /* OP_NAME */
        const struct function *function; /* OP_CALL */
    };
};

/* In postfix order. The stack never holds more than LIMIT_EXPR_DEPTH values: the compiler sees to it. */
struct expr {
    struct op *op;
    size_t count, room;
};

#endif
