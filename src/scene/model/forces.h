/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces of models that kernels compile in once more, as those of terms.def: one text, so both give
 * the same bits. */
#ifndef HOOKE_SCENE_MODEL_FORCES_H
#define HOOKE_SCENE_MODEL_FORCES_H

#include "scene/model/model.h"

/* Which text a term's force is; 0: one that no kernel knows. */
enum force {
    FORCE_OTHER,
#define CONSERVATIVE_TERM(name, ...) FORCE_##name,
#define POWERED_TERM(name, ...) FORCE_##name,
#include "scene/model/terms.def"
    FORCE_TERMS_END, /* of the oscillator */
    FORCE_weight,
    FORCE_attraction,
    FORCE_well,
    FORCE_reaction,
};

#define MODEL_FORCE(name)                                                                          \
    static inline void name##_add(const double *c, UNUSED double t, const double *y, double *a)

#define MODEL_SLOPES(name)                                                                         \
    static inline void name##_jacobian(const double *c, UNUSED double t, const double *y,          \
                                       double *jac)

/* pendulum */
#include "scene/model/weight.def"

MODEL_SLOPES(weight)
{
    jac[0] -= c[0] * fixed_cos(y[0]);
}

/* kepler */
MODEL_FORCE(attraction)
{
    double square = y[0] * y[0] + y[1] * y[1], pull = c[0] / (square * sqrt(square));
    a[0] -= pull * y[0];
    a[1] -= pull * y[1];
}

/* henon-heiles */
MODEL_FORCE(well)
{
    (void)c;
    a[0] -= y[0] + 2 * y[0] * y[1];
    a[1] -= y[1] + (y[0] * y[0] - y[1] * y[1]);
}

/* robertson */
MODEL_FORCE(reaction)
{
    double forth = c[0] * y[0], burn = c[1] * y[1] * y[1], back = c[2] * y[1] * y[2];
    a[0] += back - forth;
    a[1] += forth - back - burn;
    a[2] += burn;
}

MODEL_SLOPES(reaction)
{
    double burn = 2 * c[1] * y[1], by_b = c[2] * y[2], by_c = c[2] * y[1];
    double change[9] = {-c[0], by_b, by_c, c[0], -by_b - burn, -by_c, 0, burn, 0};
    for (int i = 0; i < 9; i++)
        jac[i] += change[i];
}

#endif
