/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The compiler of expressions: declarations shared by expr.c (syntax) and units.c (dimensions). */
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

/* State of the compilation of one expression. */
struct compiler {
    struct text text;
    size_t position, end; /* next byte; end of the last word that belongs to the expression */
    const struct expr_scope *scope;
    struct arena *arena;
    struct error *error;
    struct expr *expr;
    size_t values; /* number of values on the stack after the operations so far */
    struct pending pending[LIMIT_EXPR_DEPTH];
    size_t depth; /* number of pending operators, parentheses and calls */
    /* [values] dimension and text of each value on the stack; NULL if the scope has no quantities,
     * so that no units are allowed */
    struct typed_operand *operand;
    size_t operands; /* number for which there is memory */
    /* kind of word that ends the operand just read */
    enum { LAST_NAME, LAST_NUMBER, LAST_UNIT } last;
};

/* Returns `len` bytes of the text from `begin` on. */
static inline struct text compiler_slice(const struct compiler *c, size_t begin, size_t len)
{
    return (struct text){c->text.data + begin, len};
}

/* Appends a number or name, which goes onto the stack. Returns false, with an error, if the
 * expression is too large or too deep. */
bool compiler_emit_value(struct compiler *c, struct op value);
/* Appends an operation on the last `arity` values, or computes it if all of them are numbers.
 * Returns false, with an error, if it is too large or the dimensions do not match. */
bool compiler_emit(struct compiler *c, struct op operation, size_t arity);

/* ---- units (units.c), if the scope has quantities; false comes with an error ---- */

/* Sets the text and dimension of the value just emitted. Returns false if out of memory. */
bool units_of_value(struct compiler *c, struct text typed, struct dimension dimension);
/* Sets the dimension of the result before an operation is emitted, and converts Hz beside rad/s.
 * Returns false if the dimensions of its operands do not match. */
bool units_of_operation(struct compiler *c, const struct op *operation, size_t arity);
/* Notes that the last value is in parentheses, from `open` to the present position. */
void units_of_parenthesis(struct compiler *c, const char *open);
/* Reads a unit, if one follows, which belongs to the number or the parenthesis before it, and
 * converts that to SI. Returns false if a unit is not allowed there. */
bool units_read(struct compiler *c);
