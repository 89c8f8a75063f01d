/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Henon and Heiles' star in a galaxy: orderly at low energy, chaotic towards the escape energy 1/6.
 * No units. */
#include <hooke/base/catalog.h>
#include "scene/model/forces.h"

#define PARAMS(P)                                                                                  \
    P(x0, "", NUMBER, 0, UNBOUNDED_BELOW, "x at t0")                                               \
    P(y0, "", NUMBER, 0, UNBOUNDED_BELOW, "y at t0")                                               \
    P(vx0, "", NUMBER, 0.24, UNBOUNDED_BELOW, "velocity along x at t0")                            \
    P(vy0, "", NUMBER, 0.32, UNBOUNDED_BELOW, "velocity along y at t0")                            \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

TERM_BIND(well)
{
    return true;
}
TERM_JACOBIAN(well)
{
    jac[0] -= 1 + 2 * y[1];
    jac[1] -= 2 * y[0];
    jac[4] -= 2 * y[0];
    jac[5] -= 1 - 2 * y[1];
}
TERM_POTENTIAL(well)
{
    (void)c;
    return (y[0] * y[0] + y[1] * y[1]) / 2 + (y[0] * y[0] - y[1] * y[1] / 3) * y[1];
}

static const struct term_row terms[] = {
    {.row = {"well", "", "V = (x^2 + y^2)/2 + x^2 y - y^3/3", "Henon, Heiles 1964, eq. 11", NULL},
     .flags = TERM_CONSERVATIVE,
     .equation = {"-x-2*x*y", "-y-x^2+y^2"},
     .ordered = {NULL, "-y-(x^2-y^2)"},
     .force = FORCE_well,
     .bind = well_bind,
     .add = well_add,
     .jacobian = well_jacobian,
     .potential = well_potential},
};
static const struct catalog term_table = CATALOG("force term", terms);

/* Sets the start and the natural sizes: the length of the state vector. */
static void henon_heiles_scales(const double *param, struct system *system)
{
    static const int index[] = {P_x0, P_y0, P_vx0, P_vy0};
    double size = 0;
    for (int i = 0; i < 4; i++) {
        system->start[i] = param[index[i]];
        size = fixed_hypot(size, system->start[i]);
    }
    for (int i = 0; i < 4; i++)
        system->scale[i] = scale_clamp(size);
    system->t0 = param[P_t0];
    system->mass = 1;
}

static const struct variable variables[] = {{"x", QUANTITY_NUMBER},
                                            {"y", QUANTITY_NUMBER},
                                            {"vx", QUANTITY_NUMBER},
                                            {"vy", QUANTITY_NUMBER}};

const struct model henon_heiles_model = {
    .row = {"henon-heiles", "", "a star in a galaxy: two springs and a cubic coupling",
            "Henon, Heiles 1964", NULL},
    .order = 2,
    .n = 4,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &no_derived,
    .begin = henon_heiles_scales,
};
