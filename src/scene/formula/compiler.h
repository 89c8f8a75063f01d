/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The compiler of expressions: what its two files, operators and units, share. */
#pragma once

#include "scene/formula/expr.h"

/* An operator, an open parenthesis or an open call that waits for its operands. */
struct pending {
    enum { WAIT_OPERATOR, WAIT_PARENTHESIS, WAIT_CALL } what;
    enum op_kind op;
    int precedence;
    int arguments; /* number of commas so far in a call */
    const struct function *function;
    struct text where;
};

struct compiler {
    struct text text;
    size_t position, end; /* next byte; behind the last word that belongs to the expression */
    const struct expr_scope *scope;
    struct arena *arena;
    struct error *error;
    struct expr *expr;
    size_t values; /* number of values on the stack after the operations so far */
    struct pending pending[LIMIT_EXPR_DEPTH];
    size_t depth;
    /* One for each value on the stack, where the scope knows quantities; else NULL. */
    struct typed_operand *operand;
    size_t operands; /* that there is memory for */
    /* kind of word that ends the complete operand */
    enum { LAST_NAME, LAST_NUMBER, LAST_UNIT } last;
};

static inline struct text compiler_slice(const struct compiler *c, size_t begin, size_t len)
{
    return (struct text){c->text.data + begin, len};
}

/* A value goes onto the stack; an operation takes the last `arity` of them. */
bool compiler_emit_value(struct compiler *c, struct op value);
bool compiler_emit(struct compiler *c, struct op operation, size_t arity);

/* ---- units (units.c), where the scope knows quantities ---- */

/* The value that was just emitted was typed there. */
bool units_of_value(struct compiler *c, struct text typed, struct dimension dimension);
/* Finds the dimension of the result before an operation is emitted, and converts Hz beside rad/s.
 * Returns false if its operands do not go together. */
bool units_of_operation(struct compiler *c, const struct op *operation, size_t arity);
/* The last value stands in parentheses, which open at `open` and end here. */
void units_of_parenthesis(struct compiler *c, const char *open);
/* A unit here belongs to the number or the parenthesis before it. */
bool units_read(struct compiler *c);
