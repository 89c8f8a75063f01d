/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The drifts and kicks of a splitting's step. split.c compiles them for any splitting, the kernels
 * where the compiler knows weights and forces; both give the same bits.
 */
#pragma once

#include <hooke/base/elementary.h>

#include "method/step/step.h"

#ifndef UNROLL
#define UNROLL
#endif
#define INLINE static inline __attribute__((always_inline))

/* Computes accelerations a [n/2] at t and y; context is data of the function. */
typedef void force_function(const void *context, double t, const double *y, double *a);

/* Forces of a system, for drifts and kicks. */
struct split_forces {
    force_function *force; /* forces that do not depend on velocity */
    force_function *drag;  /* forces that do */
    const void *context;   /* data of these functions */
    const struct oscillator *oscillator;
};

/* Choices of a step that are constant over a run. */
struct split_way {
    const struct splitting *splitting;
    enum drag drag; /* DRAG_DEFAULT if there is none */
    bool symmetric;
    bool drag_at_ends; /* the exact flow of the drag is applied at both ends of the step */
    /* a step that begins and ends with a kick can use the last force of the step before */
    bool continues;
    int kicks; /* force evaluations per step, one fewer if the first force is known */
};

/* Determines how drag enters the steps of the method. */
INLINE void split_choose(struct split_way *way, const struct method *method, enum drag drag)
{
    const struct splitting *splitting = method->splitting;
    const bool symmetric = (method->flags & METHOD_SYMMETRIC) != 0;
    *way = (struct split_way){.splitting = splitting,
                              .drag = drag,
                              .symmetric = symmetric,
                              .drag_at_ends = drag == DRAG_EXACT && symmetric && method->order <= 2,
                              .continues = splitting->kick_first && splitting->count % 2 == 1,
                              .kicks = (splitting->count + splitting->kick_first) / 2};
}

/* Returns true if the first force of the step is known from the step before. */
INLINE bool split_known(const struct split_way *way, const struct step *step)
{
    return way->continues && step->warm;
}

/* Factors of a kick with exact linear drag, v' = E v + F (1 - E)/gamma with E = exp(-gamma w). */
struct frozen {
    double lost, pull; /* 1 - E, (1 - E)/gamma */
};

/* Computes the factors of a kick over w [s]. */
INLINE struct frozen frozen_over(const struct oscillator *oscillator, double w)
{
    const double gamma = oscillator->damping, lost = -fixed_expm1(-gamma * w);
    return (struct frozen){lost, gamma != 0 ? lost / gamma : w};
}

/* Returns v' = v + w (F + drag at v') of one component. */
INLINE double kick_implicit(const struct oscillator *o, double w, double force, double v)
{
    return drag_root(1 + o->damping * w, o->quadratic * w, v + w * force);
}

/*
 * Kicks v' = v + w F, with each variant of drag. `side` is < 0 before the middle of the step, 0 at
 * it, and > 0 after it; a step without symmetry is all "after".
 */
INLINE void split_kick(const struct split_way *way, int n, const struct split_forces *forces,
                       const struct frozen *prepared, int side, double t, double w,
                       const double *pull, double *z, double *low)
{
    const int d = n / 2;
    const struct oscillator *o = forces->oscillator;
    if (way->drag == DRAG_EXPLICIT ||
        (way->drag == DRAG_IMPLICIT && side < 0)) { /* the drag at v */
        double drag[LIMIT_VARIABLES];
        forces->drag(forces->context, t, z, drag);
        for (int i = 0; i < d; i++)
            step_add(&z[d + i], low ? &low[d + i] : NULL, w * (pull[i] + drag[i]));
    } else if (way->drag == DRAG_IMPLICIT && side > 0) { /* evaluated at v' */
        for (int i = 0; i < d; i++)
            z[d + i] = kick_implicit(o, w, pull[i], z[d + i]);
    } else if (way->drag == DRAG_IMPLICIT) {
        /* Drag at (v + v')/2 is half a kick that uses its end, then half one that uses its start.
         */
        for (int i = 0; i < d; i++) {
            const double v = z[d + i];
            z[d + i] = 2 * kick_implicit(o, w / 2, pull[i], v) - v;
        }
    } else if (way->drag == DRAG_EXACT && !way->drag_at_ends) {
        const struct frozen frozen = prepared ? *prepared : frozen_over(o, w);
        for (int i = 0; i < d; i++)
            step_add(&z[d + i], low ? &low[d + i] : NULL,
                     pull[i] * frozen.pull - z[d + i] * frozen.lost);
    } else {
        for (int i = 0; i < d; i++)
            step_add(&z[d + i], low ? &low[d + i] : NULL, w * pull[i]);
    }
}

/*
 * Takes all stages of a step, which change the state z [n]. pull [n/2] is the last force, which is
 * that at the start if `known` is set. `half` is the drag's flow over h/2; frozen [count] is
 * prepared for the kicks, or NULL.
 */
INLINE void split_stages(const struct split_way *way, int n, const struct split_forces *forces,
                         const struct drag_flow *half, const struct frozen *frozen, double t,
                         double h, double *z, double *pull, double *low, bool known)
{
    const struct splitting *splitting = way->splitting;
    const int d = n / 2, count = splitting->count;
    if (way->drag_at_ends)
        for (int j = d; j < n; j++)
            z[j] = drag_flow_apply(half, z[j]);
    UNROLL for (int i = 0; i < count; i++)
    {
        const double w = splitting_weight(splitting, i) * h;
        if ((i % 2 == 0) == splitting->kick_first) {
            if (!(i == 0 && known))
                forces->force(forces->context, t, z, pull);
            const int side = way->symmetric ? 2 * i + 1 - count : 1;
            split_kick(way, n, forces, frozen ? &frozen[i] : NULL, side, t, w, pull, z, low);
        } else {
            for (int j = 0; j < d; j++)
                step_add(&z[j], low ? &low[j] : NULL, w * z[d + j]);
            t += w;
        }
    }
    if (way->drag_at_ends)
        for (int j = d; j < n; j++)
            z[j] = drag_flow_apply(half, z[j]);
}
