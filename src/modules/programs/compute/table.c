/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads the coefficients of methods from their rows. */
#include "modules/programs/compute/table.h"
#include "method/control/adapt_body.h"

/* Fills in the table of an explicit Runge-Kutta method. */
bool method_runge_kutta(const struct method *method, struct runge_kutta *table)
{
    static const double straight[16] = {0};
    const struct tableau *t = method->tableau;
    if (!t)
        return false;
    *table = (struct runge_kutta){t->stages, t->fsal, t->c, t->b, t->a, t->b_hat, NULL};
    if (method->dense && t->fsal && t->bends <= 1 && t->extra == 0)
        table->bend = t->bends == 1 ? t->dense : straight;
    return true;
}

/* Describes how the method's steps follow the error. Returns false if they do so in another way. */
bool method_error_control(const struct method *method, double tol, double *most, int *order)
{
    const struct tableau *t = method->tableau;
    if (!(method->flags & METHOD_ADAPTIVE) || !t || !t->fsal || !t->b_hat || t->rough)
        return false;
    const struct controller controller = {.tol = tol};
    *most = largest_estimate(method, controller_tolerance(&controller));
    *order = method->embedded + 1;
    return true;
}

/* Stores the weights of drifts and kicks in turn. Returns their number, or 0. */
int method_splitting(const struct method *method, double weight[SPLITTING_WEIGHTS],
                     bool *kick_first)
{
    const struct splitting *s = method->splitting;
    for (int i = 0; s && i < s->count; i++)
        weight[i] = splitting_weight(s, i);
    *kick_first = s && s->kick_first;
    return s ? s->count : 0;
}

bool method_is_backward_euler(const struct method *method)
{
    const struct implicit_tableau *t = method->implicit;
    return t && t->stages == 1 && t->diagonal == 1 && t->a[0] == 1 && t->b[0] == 1;
}
