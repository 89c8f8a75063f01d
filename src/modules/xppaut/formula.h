/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas of .ode files as trees. */
#pragma once

#include "modules/xppaut/ode.h"

enum ode_node_kind {
    NODE_NUMBER,
    NODE_NAME,
    NODE_INDEX, /* i' of a sum */
    NODE_SIGN,  /* -a, not(a): op */
    NODE_JOIN,  /* a op b */
    NODE_CALL,
    NODE_IF,
    NODE_SUM /* sum with first index, last index and summand */
};

/* '<' and '>' also stand for <= and >= with `equal`, '=' for == and '!' for != or not(). */
struct ode_node {
    enum ode_node_kind kind;
    char op;
    bool equal;
    double number;
    struct text name;
    const struct ode_node **argument;
    int arguments;
};

/* Returns NULL if an error is set. */
const struct ode_node *ode_parse(struct arena *arena, int line, struct text text,
                                 struct error *error);
