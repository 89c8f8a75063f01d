/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables and networks of .ode files. */
#pragma once

#include "modules/xppaut/formula.h"

/* A function of one argument, straight between its points and beyond the outer two. */
struct ode_table {
    int points;
    double x_low, x_high;
    struct text formula;
    const double *value; /* [points], or NULL before it is used */
    bool begun;          /* it is being found */
    bool reads;          /* parameters are in it */
};

/* NAME(i): the sum of weight[j] * quantity[i + j], j from -reach to reach; beyond the places that
 * it has 0. */
struct ode_net {
    char edge; /* 'e' even, 'p' periodic, else nothing */
    int count, reach;
    struct text weights, first; /* names of a table and of the first quantity */
};

/* Reads the table or net from the text of the symbol. */
bool ode_table_read(struct ode *ode, struct ode_symbol *symbol);
bool ode_net_read(struct ode *ode, struct ode_symbol *symbol);

/* Return the value at an argument or at an index, or NULL if an error is set. */
const struct ode_node *ode_table_at(struct ode *ode, struct ode_symbol *symbol,
                                    const struct ode_node *argument);
const struct ode_node *ode_net_at(struct ode *ode, struct ode_symbol *symbol, double place);
