/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The Oregonator of Field and Noyes: a chemical clock whose concentrations jump over five powers of
 * ten. */
#include <hooke/base/catalog.h>
#include "scene/model/model.h"

#define PARAMS(P)                                                                                  \
    P(s, "1/s", RATE, 77.27, ABOVE(0), "fast rate; its inverse appears in the second equation")    \
    P(q, "", NUMBER, 8.375e-6, AT_LEAST(0), "limit of the first concentration")                    \
    P(w, "1/s", RATE, 0.161, AT_LEAST(0), "slow rate")                                             \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

TERM_BIND(reaction)
{
    c[0] = param[P_s];
    c[1] = param[P_q];
    c[2] = param[P_w];
    return true;
}
TERM_ADD(reaction)
{
    a[0] += c[0] * (y[1] + y[0] * (1 - c[1] * y[0] - y[1]));
    a[1] += (y[2] - (1 + y[0]) * y[1]) / c[0];
    a[2] += c[2] * (y[0] - y[2]);
}
TERM_JACOBIAN(reaction)
{
    jac[0] += c[0] * (1 - 2 * c[1] * y[0] - y[1]);
    jac[1] += c[0] * (1 - y[0]);
    jac[3] -= y[1] / c[0];
    jac[4] -= (1 + y[0]) / c[0];
    jac[5] += 1 / c[0];
    jac[6] += c[2];
    jac[8] -= c[2];
}

static const struct term_row terms[] = {
    {.row = {"reaction", "1/s", "three-variable model of the Belousov-Zhabotinskii reaction",
             "Field, Noyes 1974", NULL},
     .equation = {"s*(y2+y1*(1-q*y1-y2))", "(y3-(1+y1)*y2)/s", "w*(y1-y3)"},
     .bind = reaction_bind,
     .add = reaction_add,
     .jacobian = reaction_jacobian},
};
static const struct catalog term_table = CATALOG("term", terms);

/* Sets the start, and natural sizes of 1: between its spikes of up to 1e5 everything is near 1, and
 * the next spike is decided then. */
static void orego_scales(const double *param, struct system *system)
{
    system->t0 = param[P_t0];
    system->mass = 1;
    for (int i = 0; i < 3; i++) {
        system->start[i] = i + 1;
        system->scale[i] = 1;
    }
}

static const struct variable variables[] = {
    {"y1", QUANTITY_NUMBER}, {"y2", QUANTITY_NUMBER}, {"y3", QUANTITY_NUMBER}};

const struct model orego_model = {
    .row = {"orego", "", "the Oregonator: a chemical clock", "Field, Noyes 1974", NULL},
    .order = 1,
    .n = 3,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &no_derived,
    .begin = orego_scales,
};
