/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Sliding along switches: between the fields on their two sides, in the shares that keep every argument where it is
 * (Filippov 1988, Differential Equations with Discontinuous Righthand Sides, 4; where several switches add up, the
 * equivalent control of Utkin 1992, Sliding Modes in Control and Optimization, 2).
 */
#include <math.h>
#include <string.h>

#include "scene/typed/typed.h"

#define DEPENDENT 1e-12 /* a row that adds this part of its square to those before says nothing new */
#define BESIDE 1e-5     /* of a variable's size: for differences */

static const struct sliding *sliding_of(const double *c)
{
    const struct sliding *sliding;
    memcpy(&sliding, c, sizeof sliding);
    return sliding;
}

/* How fast each argument changes along the field f. */
static void rates(const struct sliding *s, double t, const double *y, const double *f, double *rate)
{
    const int n = s->side[0].n;
    double a[LIMIT_VARIABLES], b[LIMIT_VARIABLES], before[LIMIT_SWITCHES], after[LIMIT_SWITCHES];
    for (int i = 0; i < n; i++) {
        a[i] = y[i] - s->near * f[i];
        b[i] = y[i] + s->near * f[i];
    }
    switch_arguments(&s->side[0], t - s->near, a, before);
    switch_arguments(&s->side[0], t + s->near, b, after);
    for (int k = 0; k < s->count; k++)
        rate[k] = (after[s->at[k]] - before[s->at[k]]) / (2 * s->near);
}

/* The fields around a point. */
struct around {
    double field[LIMIT_VARIABLES];               /* below all switches */
    double jump[LIMIT_SLIDING][LIMIT_VARIABLES]; /* what each adds above */
    double rate[LIMIT_SLIDING];                  /* of the arguments along `field`, */
    double by[LIMIT_SLIDING][LIMIT_SLIDING];     /* and what each jump adds to that of argument [i] */
};

static void look_around(const struct sliding *s, double t, const double *y, struct around *around)
{
    const int n = s->side[0].n;
    system_derivative(&s->side[0], t, y, around->field);
    rates(s, t, y, around->field, around->rate);
    for (int j = 0; j < s->count; j++) {
        double rate[LIMIT_SLIDING];
        system_derivative(&s->side[1 + j], t, y, around->jump[j]);
        rates(s, t, y, around->jump[j], rate);
        for (int i = 0; i < n; i++)
            around->jump[j][i] -= around->field[i];
        for (int i = 0; i < s->count; i++)
            around->by[i][j] = rate[i] - around->rate[i];
    }
}

/* The x nearest to x that has by x = right; rows that depend on those before are left out. */
static void solve(int count, double (*by)[LIMIT_SLIDING], const double *right, double *x)
{
    double q[LIMIT_SLIDING][LIMIT_SLIDING];
    for (int i = 0; i < count; i++) {
        double whole = 0, own = 0, miss = right[i];
        for (int k = 0; k < count; k++)
            whole += by[i][k] * by[i][k];
        memcpy(q[i], by[i], sizeof q[i]);
        for (int j = 0; j < i; j++) {
            double along = 0;
            for (int k = 0; k < count; k++)
                along += q[i][k] * q[j][k];
            for (int k = 0; k < count; k++)
                q[i][k] -= along * q[j][k];
        }
        for (int k = 0; k < count; k++) {
            own += q[i][k] * q[i][k];
            miss -= by[i][k] * x[k];
        }
        const bool fresh = own > DEPENDENT * whole;
        for (int k = 0; k < count; k++) {
            x[k] += fresh ? miss / own * q[i][k] : 0;
            q[i][k] = fresh ? q[i][k] / sqrt(own) : 0;
        }
    }
}

/* The share of the side above each switch. */
static void shares(const struct sliding *s, double t, const double *y, struct around *around, double *share)
{
    double right[LIMIT_SLIDING];
    look_around(s, t, y, around);
    for (int i = 0; i < s->count; i++) {
        share[i] = 0.5;
        right[i] = -around->rate[i];
    }
    solve(s->count, around->by, right, share);
}

static void add(const double *c, double t, const double *y, double *a)
{
    const struct sliding *s = sliding_of(c);
    const struct system *system = &s->side[0];
    const int rows = system->order == 2 ? system->n / 2 : system->n, first = system->n - rows;
    struct around around;
    double share[LIMIT_SLIDING];
    shares(s, t, y, &around, share);
    for (int i = 0; i < rows; i++) {
        double sum = around.field[first + i];
        for (int j = 0; j < s->count; j++)
            sum += share[j] * around.jump[j][first + i];
        a[i] += sum;
    }
}

static void jacobian(const double *c, double t, const double *y, double *jac)
{
    const struct system *system = &sliding_of(c)->side[0];
    const int n = system->n, rows = system->order == 2 ? n / 2 : n;
    double at[LIMIT_VARIABLES];
    memcpy(at, y, (size_t)n * sizeof *y);
    for (int j = 0; j < n; j++) {
        const double by = BESIDE * fmax(system->scale[j], fabs(y[j]));
        double below[LIMIT_VARIABLES] = {0}, above[LIMIT_VARIABLES] = {0};
        at[j] = y[j] - by;
        add(c, t, at, below);
        at[j] = y[j] + by;
        add(c, t, at, above);
        at[j] = y[j];
        for (int i = 0; i < rows; i++)
            jac[i * n + j] += (above[i] - below[i]) / (2 * by);
    }
}

static const struct term_row sliding_row = {
    .row = {"sliding", "", "along switches", "Filippov 1988", NULL}, .add = add, .jacobian = jacobian};

bool system_slide(const struct system *system, const double *branch, const bool *slides, double near,
                  struct sliding *sliding, struct system *frozen)
{
    double below[LIMIT_SWITCHES];
    memcpy(below, branch, (size_t)system->switches * sizeof *below);
    sliding->count = 0;
    sliding->near = near;
    system_freeze(system, below, &sliding->side[0]);
    for (int i = 0; i < system->switches; i++) {
        if (!slides[i])
            continue;
        if (sliding->count == LIMIT_SLIDING)
            return false;
        const int k = sliding->count++;
        sliding->at[k] = i;
        sliding->level[k] = switch_kind_of(system, i) == SWITCH_WHOLE ? below[i] + 1 : 0;
        below[i]++;
        system_freeze(system, below, &sliding->side[1 + k]);
        below[i]--;
    }
    *frozen = sliding->side[0];
    if (sliding->count == 0)
        return true;
    frozen->sliding = sliding;
    if (sliding_rests(sliding)) {
        sliding_freeze_rest(frozen);
        return true;
    }
    frozen->terms = 0;
    frozen->typed.row = &sliding_row;
    memcpy(frozen->typed.c, &sliding, sizeof sliding);
    return true;
}

bool sliding_return(const struct sliding *s, double t, double *y)
{
    struct around around;
    double argument[LIMIT_SWITCHES], miss[LIMIT_SLIDING], by[LIMIT_SLIDING] = {0};
    bool off = false;
    if (sliding_rests(s)) {
        off = y[1] != 0;
        y[1] = 0;
        return off;
    }
    switch_arguments(&s->side[0], t, y, argument);
    for (int k = 0; k < s->count; k++) {
        miss[k] = s->level[k] - argument[s->at[k]];
        off = off || miss[k] != 0;
    }
    if (!off)
        return false;
    look_around(s, t, y, &around);
    solve(s->count, around.by, miss, by);
    for (int j = 0; j < s->count; j++)
        for (int i = 0; i < s->side[0].n && isfinite(by[j]); i++)
            y[i] += by[j] * around.jump[j][i];
    return true;
}

/* Of the switches along which it slides: the product of both sides' shares. */
void sliding_guards(const struct sliding *s, double t, const double *y, double *guard)
{
    struct around around;
    double share[LIMIT_SLIDING];
    shares(s, t, y, &around, share);
    for (int k = 0; k < s->count; k++)
        guard[s->at[k]] = share[k] * (1 - share[k]);
}

double sliding_leaves(const struct sliding *s, int i, double t, const double *y)
{
    struct around around;
    double share[LIMIT_SLIDING];
    shares(s, t, y, &around, share);
    for (int k = 0; k < s->count; k++)
        if (s->at[k] == i)
            return s->level[k] - (switch_kind_of(&s->side[0], i) == SWITCH_WHOLE) + (share[k] > 0.5);
    return NAN;
}
