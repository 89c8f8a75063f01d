/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Sliding along switches: between the fields on their two sides, in the shares that keep every
 * argument where it is (Filippov 1988, Differential Equations with Discontinuous Righthand Sides,
 * 4; where several switches add up, the equivalent control of Utkin 1992, Sliding Modes in Control
 * and Optimization, 2).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/typed/typed.h"

/* A row that adds less than this part of its square to the rows before depends on them. */
#define ROW_INDEPENDENCE_MIN 1e-12
#define DIFFERENCE_STEP 1e-5 /* Step of finite differences as a part of a variable's size. */
/* Largest number of corrections if rates have to be 0, too, so that the motion can go on at
 * rest. */
#define SECOND_CORRECTIONS_MAX 3
/* Step of differences of arguments, most of which are linear, as a part of all variables' sizes. */
#define ARGUMENT_STEP 1e-2
/* The same for differences of fields; both formulas are of fourth order. */
#define FAR_FIELD 1e-4

static const struct sliding *sliding_of(const double *c)
{
    const struct sliding *sliding;
    memcpy(&sliding, c, sizeof sliding);
    return sliding;
}

/* Computes the rate of each argument along the field f. */
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

/* Returns the time [s] in which a motion by `direction` moves as far as variables are large, or
 * `otherwise` if there is no motion. */
static double moment(const struct system *system, const double *y, const double *direction,
                     double otherwise)
{
    double sum = 0;
    for (int i = 0; i < system->n; i++) {
        const double by = direction[i] / fmax(system->scale[i], fabs(y[i]));
        sum += by * by;
    }
    return sum > 0 ? sqrt(system->n / sum) : otherwise;
}

/* First and second derivatives of the arguments along (time, direction): differences of the fourth
 * order. */
static void differences(const struct sliding *s, double t, double time, const double *y,
                        const double *direction, double *first, double *second)
{
    const struct system *side = &s->side[0];
    const double h = ARGUMENT_STEP * moment(side, y, direction, s->near / ARGUMENT_STEP);
    double at[LIMIT_VARIABLES], a[5][LIMIT_SWITCHES];
    for (int k = 0; k < 5; k++) {
        for (int i = 0; i < side->n; i++)
            at[i] = y[i] + (k - 2) * h * direction[i];
        switch_arguments(side, t + (k - 2) * h * time, at, a[k]);
    }
    for (int i = 0; i < s->count; i++) {
        const int k = s->at[i];
        first[i] = (8 * (a[3][k] - a[1][k]) - (a[4][k] - a[0][k])) / (12 * h);
        second[i] = (16 * (a[3][k] - 2 * a[2][k] + a[1][k]) - (a[4][k] - 2 * a[2][k] + a[0][k])) /
                    (12 * h * h);
    }
}

/* Computes the rate of each argument along the motion on one side, and the rate of that rate. */
static void changes(const struct sliding *s, const struct system *side, double t, const double *y,
                    double *rate, double *second)
{
    static const double weight[] = {1. / 12, -8. / 12, 0, 8. / 12, -1. / 12};
    double f[LIMIT_VARIABLES], at[LIMIT_VARIABLES], beside[LIMIT_VARIABLES],
        bend[LIMIT_VARIABLES] = {0};
    double more[LIMIT_SLIDING], ignored[LIMIT_SLIDING];
    system_derivative(side, t, y, f);
    const double h = FAR_FIELD * moment(side, y, f, s->near / FAR_FIELD);
    for (int k = -2; k <= 2; k++) {
        for (int i = 0; i < side->n; i++)
            at[i] = y[i] + k * h * f[i];
        system_derivative(side, t + k * h, at, beside);
        for (int i = 0; i < side->n; i++)
            bend[i] += weight[k + 2] / h * beside[i];
    }
    differences(s, t, 1, y, f, rate, second);
    differences(s, t, 0, y, bend, more, ignored);
    for (int i = 0; i < s->count; i++)
        second[i] += more[i];
}

/*
 * The fields around a point. Where no jump changes the rate of an argument, as those of forces do
 * not change that of a position, `rate` and `by` are of its second derivative (relative degree 2;
 * Fridman, Levant 2002, Higher Order Sliding Modes, in Sliding Mode Control in Engineering, 3): it
 * stays where both are 0.
 */
struct around {
    double field[LIMIT_VARIABLES];               /* field below all switches */
    double jump[LIMIT_SLIDING][LIMIT_VARIABLES]; /* change of the field above each switch */
    double rate[LIMIT_SLIDING];                  /* rate of each argument along `field`, */
    double by[LIMIT_SLIDING][LIMIT_SLIDING]; /* and what each jump adds to that of argument [i] */
    bool second[LIMIT_SLIDING];
    double first[LIMIT_SLIDING]; /* rate of those whose second derivative it is */
};

static void look_twice(const struct sliding *s, double t, const double *y, struct around *around)
{
    double rate[LIMIT_SLIDING], first[LIMIT_SLIDING], below[LIMIT_SLIDING], above[LIMIT_SLIDING];
    changes(s, &s->side[0], t, y, first, below);
    for (int j = 0; j < s->count; j++) {
        changes(s, &s->side[1 + j], t, y, rate, above);
        for (int i = 0; i < s->count; i++)
            if (around->second[i])
                around->by[i][j] = above[i] - below[i];
    }
    for (int i = 0; i < s->count; i++)
        if (around->second[i]) {
            around->rate[i] = below[i];
            around->first[i] = first[i];
        }
}

static void look_around(const struct sliding *s, double t, const double *y, struct around *around)
{
    const int n = s->side[0].n;
    bool any = false;
    system_derivative(&s->side[0], t, y, around->field);
    rates(s, t, y, around->field, around->rate);
    for (int i = 0; i < s->count; i++)
        around->second[i] = true;
    for (int j = 0; j < s->count; j++) {
        double rate[LIMIT_SLIDING];
        system_derivative(&s->side[1 + j], t, y, around->jump[j]);
        rates(s, t, y, around->jump[j], rate);
        for (int i = 0; i < n; i++)
            around->jump[j][i] -= around->field[i];
        for (int i = 0; i < s->count; i++) {
            around->by[i][j] = rate[i] - around->rate[i];
            around->second[i] = around->second[i] && around->by[i][j] == 0;
        }
    }
    for (int i = 0; i < s->count; i++)
        any = any || around->second[i];
    if (any)
        look_twice(s, t, y, around);
}

/* The x nearest to x that has by x = right; rows that depend on those before are left out. */
static void sliding_solve(int count, double (*by)[LIMIT_SLIDING], const double *right, double *x)
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
        const bool fresh = own > ROW_INDEPENDENCE_MIN * whole;
        for (int k = 0; k < count; k++) {
            x[k] += fresh ? miss / own * q[i][k] : 0;
            q[i][k] = fresh ? q[i][k] / sqrt(own) : 0;
        }
    }
}

/* The share of the side above each switch. */
static void find_fractions(const struct sliding *s, double t, const double *y,
                           struct around *around, double *fraction)
{
    double right[LIMIT_SLIDING] = {0};
    look_around(s, t, y, around);
    for (int i = 0; i < s->count; i++) {
        fraction[i] = 0.5;
        right[i] = -around->rate[i];
    }
    sliding_solve(s->count, around->by, right, fraction);
}

static void sliding_add_rates(const double *c, double t, const double *y, double *a)
{
    const struct sliding *s = sliding_of(c);
    const struct system *system = &s->side[0];
    const int rows = system->order == 2 ? system->n / 2 : system->n, first = system->n - rows;
    struct around around;
    double fraction[LIMIT_SLIDING];
    find_fractions(s, t, y, &around, fraction);
    for (int i = 0; i < rows; i++) {
        double sum = around.field[first + i];
        for (int j = 0; j < s->count; j++)
            sum += fraction[j] * around.jump[j][first + i];
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
        const double by = DIFFERENCE_STEP * fmax(system->scale[j], fabs(y[j]));
        double below[LIMIT_VARIABLES] = {0}, above[LIMIT_VARIABLES] = {0};
        at[j] = y[j] - by;
        sliding_add_rates(c, t, at, below);
        at[j] = y[j] + by;
        sliding_add_rates(c, t, at, above);
        at[j] = y[j];
        for (int i = 0; i < rows; i++)
            jac[i * n + j] += (above[i] - below[i]) / (2 * by);
    }
}

static const struct term_row sliding_row = {
    .row = {"sliding", "", "along switches", "Filippov 1988", NULL},
    .add = sliding_add_rates,
    .jacobian = jacobian};

bool system_slide(const struct system *system, const double *branch, const bool *slides,
                  double near, struct sliding *sliding, struct system *frozen)
{
    double below[LIMIT_SWITCHES];
    memcpy(below, branch, (size_t)system->switches * sizeof *below);
    sliding->count = 0;
    sliding->near = near;
    system_freeze(system, below, frozen);
    for (int i = 0; i < system->switches; i++) {
        if (!slides[i])
            continue;
        if (!sliding->side)
            sliding->side = malloc((LIMIT_SLIDING + 1) * sizeof *sliding->side);
        if (!sliding->side || sliding->count == LIMIT_SLIDING)
            return false;
        const int k = sliding->count++;
        sliding->at[k] = i;
        sliding->level[k] = switch_kind_of(system, i) == SWITCH_WHOLE ? below[i] + 1 : 0;
        below[i]++;
        system_freeze(system, below, &sliding->side[1 + k]);
        below[i]--;
    }
    if (sliding->count == 0)
        return true;
    sliding->side[0] = *frozen;
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

void sliding_free(struct sliding *sliding)
{
    free(sliding->side);
}

/* y moves by so much of each direction. */
static void move(const struct sliding *s, const double *by, double (*direction)[LIMIT_VARIABLES],
                 double *y)
{
    for (int j = 0; j < s->count; j++)
        for (int i = 0; i < s->side[0].n && isfinite(by[j]); i++)
            y[i] += by[j] * direction[j][i];
}

/* Sets direction[j] to the derivative of the field along jump j, which is the Jacobian times the
 * jump, by central differences over s->near: [1/s] times the unit of the jump. */
static void follow_jumps(const struct sliding *s, const struct around *around, double t,
                         const double *y, double (*direction)[LIMIT_VARIABLES])
{
    const int n = s->side[0].n;
    const double h = s->near;
    for (int j = 0; j < s->count; j++) {
        double a[LIMIT_VARIABLES], b[LIMIT_VARIABLES], before[LIMIT_VARIABLES],
            after[LIMIT_VARIABLES];
        for (int i = 0; i < n; i++) {
            a[i] = y[i] - h * around->jump[j][i];
            b[i] = y[i] + h * around->jump[j][i];
        }
        system_derivative(&s->side[0], t, a, before);
        system_derivative(&s->side[0], t, b, after);
        for (int i = 0; i < n; i++)
            direction[j][i] = (after[i] - before[i]) / (2 * h);
    }
}

/* Arguments whose rates alone the jumps change are put back by what follows from these. Returns
 * false if they are there. */
static bool return_twice(const struct sliding *s, const struct around *around, double t,
                         const double *miss, double *y)
{
    double right[LIMIT_SLIDING] = {0}, by[LIMIT_SLIDING] = {0},
           rows[LIMIT_SLIDING][LIMIT_SLIDING] = {{0}};
    double direction[LIMIT_SLIDING][LIMIT_VARIABLES];
    bool off = false;
    for (int i = 0; i < s->count; i++) {
        if (!around->second[i])
            continue;
        right[i] = miss[i];
        memcpy(rows[i], around->by[i], sizeof rows[i]);
        off = off || miss[i] != 0;
    }
    if (!off)
        return false;
    follow_jumps(s, around, t, y, direction);
    sliding_solve(s->count, rows, right, by);
    move(s, by, direction, y);
    return true;
}

/* Computes the distance of each argument from its switch. Returns true if one is off, or if its
 * rate is not 0 where it has to be. */
static bool look_off(const struct sliding *s, double t, const double *y, struct around *around,
                     double *miss)
{
    double argument[LIMIT_SWITCHES];
    bool off = false;
    look_around(s, t, y, around);
    switch_arguments(&s->side[0], t, y, argument);
    for (int k = 0; k < s->count; k++) {
        miss[k] = s->level[k] - argument[s->at[k]];
        off = off || miss[k] != 0 || (around->second[k] && around->first[k] != 0);
    }
    return off;
}

/* Corrects the state by a step of Newton's iteration. */
static void step_back(const struct sliding *s, struct around *around, double t, double *miss,
                      double *y)
{
    double by[LIMIT_SLIDING] = {0};
    if (return_twice(s, around, t, miss, y))
        look_off(s, t, y, around, miss);
    for (int k = 0; k < s->count; k++)
        miss[k] = around->second[k] ? -around->first[k] : miss[k];
    sliding_solve(s->count, around->by, miss, by);
    move(s, by, around->jump, y);
}

bool sliding_return(const struct sliding *s, double t, double *y)
{
    struct around around;
    double miss[LIMIT_SLIDING];
    bool moved = false, twice = true;
    if (sliding_rests(s)) {
        moved = y[1] != 0;
        y[1] = 0;
        return moved;
    }
    for (int k = 0; k < SECOND_CORRECTIONS_MAX && twice && look_off(s, t, y, &around, miss); k++) {
        step_back(s, &around, t, miss, y);
        moved = true;
        twice = false;
        for (int i = 0; i < s->count; i++)
            twice = twice || around.second[i];
    }
    return moved;
}

bool sliding_passes(const struct sliding *s, int i, double t, const double *y, double within)
{
    struct around around;
    if (sliding_rests(s))
        return false;
    look_around(s, t, y, &around);
    for (int k = 0; k < s->count; k++) {
        double max = 0;
        for (int j = 0; j < s->count; j++)
            max = fmax(max, fabs(around.by[k][j]));
        if (s->at[k] == i && around.second[k])
            return !(fabs(around.first[k]) <= max * within);
    }
    return false;
}

/* Computes guards of the switches along which the motion slides: the product of both sides'
 * shares. */
void sliding_guards(const struct sliding *s, double t, const double *y, double *guard)
{
    struct around around;
    double fraction[LIMIT_SLIDING];
    find_fractions(s, t, y, &around, fraction);
    for (int k = 0; k < s->count; k++)
        guard[s->at[k]] = fraction[k] * (1 - fraction[k]);
}

double sliding_leaves(const struct sliding *s, int i, double t, const double *y)
{
    struct around around;
    double fraction[LIMIT_SLIDING];
    find_fractions(s, t, y, &around, fraction);
    for (int k = 0; k < s->count; k++)
        if (s->at[k] == i)
            return s->level[k] - (switch_kind_of(&s->side[0], i) == SWITCH_WHOLE) +
                   (fraction[k] > 0.5);
    return NAN;
}
