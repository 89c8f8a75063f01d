/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows of methods, to be read by others. */
#include <hooke/method/table.h>
#include "method/step/step.h"

bool method_runge_kutta(const struct method *method, struct runge_kutta *table)
{
    const struct tableau *t = method->tableau;
    if (t)
        *table = (struct runge_kutta){t->stages, t->fsal, t->c, t->b, t->a, t->b_hat};
    return t != NULL;
}

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
