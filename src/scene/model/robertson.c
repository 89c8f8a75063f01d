/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Robertson's autocatalytic reaction: rates from 0.04 to 3e7, over times from 1e-5 to 1e11. */
#include <hooke/base/catalog.h>
#include "scene/model/forces.h"

#define PARAMS(P)                                                                                  \
    P(k1, "1/s", RATE, 0.04, AT_LEAST(0), "rate of A -> B")                                        \
    P(k2, "1/s", RATE, 3e7, AT_LEAST(0), "rate of B + B -> C + B")                                 \
    P(k3, "1/s", RATE, 1e4, AT_LEAST(0), "rate of B + C -> A + C")                                 \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

TERM_BIND(reaction)
{
    c[0] = param[P_k1];
    c[1] = param[P_k2];
    c[2] = param[P_k3];
    return true;
}

static const struct term_row terms[] = {
    {.row = {"reaction", "1/s", "A -> B, B + B -> C + B, B + C -> A + C", "Robertson 1966", NULL},
     .equation = {"k3*y2*y3-k1*y1", "k1*y1-k3*y2*y3-k2*y2^2", "k2*y2^2"},
     .ordered = {NULL, "k1*y1-k3*y2*y3-k2*y2*y2", "k2*y2*y2"},
     .force = FORCE_reaction,
     .bind = reaction_bind,
     .add = reaction_add,
     .jacobian = reaction_jacobian},
};
static const struct catalog term_table = CATALOG("term", terms);

/* Sets the start and the natural sizes. B stays below sqrt(k1/k2), where it burns as fast as it is
 * made. */
static void robertson_scales(const double *param, struct system *system)
{
    system->t0 = param[P_t0];
    system->mass = 1;
    system->start[0] = 1;
    system->scale[0] = system->scale[2] = 1;
    system->scale[1] = param[P_k2] > param[P_k1] ? scale_clamp(sqrt(param[P_k1] / param[P_k2])) : 1;
}

static const struct variable variables[] = {
    {"y1", QUANTITY_NUMBER}, {"y2", QUANTITY_NUMBER}, {"y3", QUANTITY_NUMBER}};

const struct model robertson_model = {
    .row = {"robertson", "", "a chemical reaction with very different rates", "Robertson 1966",
            NULL},
    .order = 1,
    .n = 3,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &no_derived,
    .begin = robertson_scales,
};
