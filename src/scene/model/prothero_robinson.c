/* SPDX-License-Identifier: GPL-3.0-or-later */
/* y' = lambda (y - cos t) - sin t: the solution is cos t however stiff the pull towards it. Order
 * reduction shows here.
 */
#include <hooke/base/catalog.h>
#include "scene/model/model.h"

#define PARAMS(P)                                                                                  \
    P(lambda, "1/s", RATE, -1e6, UNBOUNDED_BELOW, "rate of the pull towards cos t (< 0: stable)")  \
    P(y0, "", NUMBER, 1, UNBOUNDED_BELOW, "y at t0; cos t0 is on the smooth solution")             \
    P(t0, "s", TIME, 0, UNBOUNDED_BELOW, "time at the start")

PARAM_PLACES(PARAMS);
static const struct param_row params[] = {PARAMS(PARAM_ROW)};
static const struct catalog param_table = CATALOG("parameter", params);

TERM_BIND(pull)
{
    c[0] = param[P_lambda];
    return true;
}
TERM_ADD(pull)
{
    a[0] += c[0] * (y[0] - fixed_cos(t)) - fixed_sin(t);
}
TERM_JACOBIAN(pull)
{
    jac[0] += c[0];
}

static const struct term_row terms[] = {
    {.row = {"pull", "1/s", "lambda (y - cos t) - sin t", "Prothero, Robinson 1974", NULL},
     .flags = TERM_LINEAR | TERM_TIME,
     .equation = {"lambda*(y-cos(t))-sin(t)"},
     .bind = pull_bind,
     .add = pull_add,
     .jacobian = pull_jacobian},
};
static const struct catalog term_table = CATALOG("term", terms);

static void prothero_robinson_scales(const double *param, struct system *system)
{
    system->t0 = param[P_t0];
    system->mass = 1;
    system->start[0] = param[P_y0];
    system->scale[0] = 1;
}

/* Computes the exact solution y = cos t + (y0 - cos t0) exp(lambda (t - t0)), and its floor. */
static void exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor)
{
    double lambda = system->term[0].c[0], x = lambda * (t - t0), away = start[0] - fixed_cos(t0);
    double transient = away != 0 ? away * fixed_exp(x) : 0;
    y[0] = fixed_cos(t) + transient;
    if (floor) /* an ulp in the start decays or grows with what it is an ulp of, an ulp of t moves
                  cos t */
        floor[0] = DBL_EPSILON * (fabs(y[0]) + fabs(t * fixed_sin(t)) + fabs(x * transient) +
                                  fabs(start[0]) * fixed_exp(x));
}

static const struct variable variables[] = {{"y", QUANTITY_NUMBER}};

const struct model prothero_robinson_model = {
    .row = {"prothero-robinson", "", "a stiff pull towards cos t: one variable, known solution",
            "Prothero, Robinson 1974", NULL},
    .order = 1,
    .n = 1,
    .variable = variables,
    .params = &param_table,
    .terms = &term_table,
    .derived = &no_derived,
    .begin = prothero_robinson_scales,
    .exact = exact,
};
