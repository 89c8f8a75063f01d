/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables and networks of .ode files, which are read once (ode_table_read, ode_net_read) and written
 * out as formulas where they are used (ode_table_at, ode_net_at). */
#pragma once

#include "modules/xppaut/formula.h"

/* A function of one argument, linear between its points and beyond the outer ones. */
struct ode_table {
    int points;
    double x_low, x_high; /* arguments of the first and the last point */
    struct text formula;  /* formula of t that gives the values */
    const double *value;  /* [points] in the arena, or NULL before the table is used */
    bool begun; /* its values are being computed, so that a table in its own formula is noticed */
    bool reads; /* its formula has parameters, whose values in the file are used */
};

/* A network: NAME(i) is the sum of weight[j] * quantity[i + j] for j from -reach to reach, and 0 if
 * i is not from 0 to count - 1. */
struct ode_net {
    char edge;        /* quantities beyond the ends: 'e' mirrored, 'p' periodic, otherwise none */
    int count, reach; /* number of quantities, and of neighbours on either side */
    struct text weights, first; /* names of a table and of the first quantity */
};

/* Read the table or network from the text of the symbol into symbol->table or symbol->net. Return
 * false with an error. */
bool ode_table_read(struct ode *ode, struct ode_symbol *symbol);
bool ode_net_read(struct ode *ode, struct ode_symbol *symbol);

/* Return the value at an argument, or at index `place`, as a formula in the arena. Return NULL with
 * an error. */
const struct ode_node *ode_table_at(struct ode *ode, struct ode_symbol *symbol,
                                    const struct ode_node *argument);
const struct ode_node *ode_net_at(struct ode *ode, struct ode_symbol *symbol, double place);
