/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas of .ode files as trees: ode_parse() makes one (parse.c), ode_formula() of ode.h writes
 * it as a formula of a typed scene (formula.c). */
#pragma once

#include "modules/xppaut/ode.h"

/* Kinds of nodes. */
enum ode_node_kind {
    NODE_NUMBER,
    NODE_NAME,
    NODE_INDEX, /* the index i' of a sum */
    NODE_SIGN,  /* -a or not(a), by op */
    NODE_JOIN,  /* a op b */
    NODE_CALL,
    NODE_IF,
    NODE_SUM /* a sum; its arguments are first index, last index and summand */
};

/* A node of a formula, in an arena. The characters of `op` are those of the file, but '<' and '>'
 * with `equal` are <= and >=, '=' is ==, and '!' is != or not(). */
struct ode_node {
    enum ode_node_kind kind;
    char op;
    bool equal;
    double number;                    /* value of NODE_NUMBER */
    struct text name;                 /* name of NODE_NAME and NODE_CALL */
    const struct ode_node **argument; /* [arguments] operands */
    int arguments;
};

/* Parses a formula that stands in that line of the file. Memory is from the arena, and names point
 * into `text`. Returns NULL with an error. */
const struct ode_node *ode_parse(struct arena *arena, int line, struct text text,
                                 struct error *error);
