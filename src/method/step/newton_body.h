/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Newton's iteration for the stages of implicit methods, to rounding. newton.c compiles it for any
 * forces, kernel/implicit.c where the compiler knows them; both give the same bits. Source: Hairer,
 * Wanner 1996, Solving ODEs II, IV.8 (transformed systems, stopping); Hairer, McLachlan,
 * Razakarivony 2008, BIT 48:231 (to rounding).
 */
#pragma once

#include <float.h>

#include "method/step/lu_body.h"
#include "method/step/newton.h"

#ifndef INLINE
#define INLINE static inline __attribute__((always_inline))
#endif

/* Most halvings of an increment that does not reduce the residual, and most iterations. */
enum { HALVINGS = 8, ITERATIONS = 30 };

/* A relative increment below this that does not shrink any more is rounding. */
#define INCREMENT_STALL_RELATIVE 1e-10
/* Increments that shrink more slowly than this require a new Jacobian. */
#define JACOBIAN_REUSE_RATE 0.1
/* Increments that shrink at least by this factor stay near their start (Newton-Kantorovich). */
#define CONTRACTION_MAX 0.5

/* A relative increment below this changes no digit. */
#define INCREMENT_NEGLIGIBLE (DBL_EPSILON / 32)

/* Coefficients of the implicit Euler method, for NEWTON_EULER. */
static const double newton_one[] = {1}, newton_now[] = {0};
#define NEWTON_EULER                                                                               \
    {                                                                                              \
        .stages = 1, .c = newton_now, .a = newton_one, .b = newton_one, .d = newton_one,           \
        .real = 1, .left = newton_one, .right = newton_one                                         \
    }

/* Pointers into the memory of newton_capacity() doubles. */
struct workspace {
    double *h;                       /* step of the factors, 0 if there are none */
    double *rate;                    /* rate at which increments shrank in the last solution */
    double *slope, *residual, *move; /* [stages][n] slopes, residual, increment */
    double *jacobian;                /* [n][n] */
    double *real, *complex;          /* factors for the real eigenvalue and for the complex pair */
};

/* Divides the memory for `stages` stages of n variables. */
INLINE struct workspace workspace_of(int stages, int n, double *work)
{
    struct workspace workspace = {.h = work, .rate = work + 1, .slope = work + 2};
    workspace.residual = workspace.slope + stages * n;
    workspace.move = workspace.residual + stages * n;
    workspace.jacobian = workspace.move + stages * n;
    workspace.real = workspace.jacobian + n * n;
    workspace.complex = workspace.real + LU_ROOM(n);
    return workspace;
}

/* Factors a; an n that the compiler knows needs no choice among sizes. */
INLINE bool newton_lu(int n, double *a)
{
    return __builtin_constant_p(n) ? lu_factor_size(n, a, a + n * n) : lu_factor(n, a);
}

/* Solves with the factors of newton_lu(). */
INLINE void newton_lu_solve(int n, const double *a, double *x)
{
    __builtin_constant_p(n) ? lu_solve_size(n, a, a + n * n, x) : lu_solve(n, a, x);
}

/* Factors real - h J and alpha + i beta - h J, with the Jacobian J at t and y. Returns false if one
 * of them is singular. */
INLINE bool newton_factor(const struct newton *equations, struct step *step, int n, double t,
                          double h, const double *y, struct workspace *workspace)
{
    const struct implicit_tableau *tableau = equations->tableau;
    double *re = workspace->complex, *im = re + LU_ROOM(n);
    equations->jacobian(equations->forces, t, y, workspace->jacobian);
    step->cost.jacobians++;
    *workspace->h = 0;
    for (int i = 0; i < n * n; i++) {
        double hj = h * workspace->jacobian[i], unit = i % (n + 1) == 0;
        workspace->real[i] = tableau->real * unit - hj;
        re[i] = tableau->alpha * unit - hj;
        im[i] = tableau->beta * unit;
    }
    if ((tableau->real != 0 && !newton_lu(n, workspace->real)) ||
        (tableau->beta != 0 && !lu_factor_complex(n, re)))
        return false;
    *workspace->h = h;
    return true;
}

/* Replaces x_i by sum_j m_ij x_j for each component of x [stages][n]. */
INLINE void mix_stages(int stages, int n, const double *m, double *x)
{
    for (int i = 0; i < n; i++) {
        double old[3];
        for (int s = 0; s < stages; s++)
            old[s] = x[s * n + i];
        for (int s = 0; s < stages; s++) {
            double sum = -0.0;
            for (int j = 0; j < stages; j++)
                sum += m[s * stages + j] * old[j];
            x[s * n + i] = sum;
        }
    }
}

/* Calls mix_stages() with a constant number of stages. */
INLINE void newton_mix(int stages, int n, const double *m, double *x)
{
    if (stages == 1)
        mix_stages(1, n, m, x);
    else if (stages == 2)
        mix_stages(2, n, m, x);
    else
        mix_stages(3, n, m, x);
}

/* Replaces x [stages][n] by (1 - h a J)^-1 x, by the factors of newton_factor(). */
INLINE void newton_increment(const struct implicit_tableau *tableau, struct step *step, int n,
                             const struct workspace *workspace, double *x)
{
    int pair = tableau->real != 0;
    newton_mix(tableau->stages, n, tableau->left, x);
    if (pair)
        newton_lu_solve(n, workspace->real, x);
    if (tableau->beta != 0)
        lu_solve_complex(n, workspace->complex, x + pair * n, x + (pair + 1) * n);
    newton_mix(tableau->stages, n, tableau->right, x);
    step->cost.solves++;
}

/* Computes `residual` of the increments z; slope and residual have [stages][n]. */
INLINE void newton_residual(const struct newton *equations, struct step *step, int n, double t,
                            double h, const double *y, const double *z, double *slope,
                            double *residual)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int stages = tableau->stages;
    double sum[LIMIT_VARIABLES];
    for (int s = 0; s < stages; s++) {
        for (int i = 0; i < n; i++)
            sum[i] = y[i] + z[s * n + i];
        equations->slope(equations->forces, t + tableau->c[s] * h, sum, slope + s * n);
    }
    step->cost.evals += stages;
    memcpy(residual, slope, (size_t)(stages * n) * sizeof *residual);
    newton_mix(stages, n, tableau->a, residual);
    for (int i = 0; i < stages * n; i++)
        residual[i] = h * residual[i] - z[i];
}

/* Returns the largest component of x [stages][n] times its weight; NaN if one is NaN. */
INLINE double newton_size(int stages, int n, const double *weight, const double *x)
{
    double largest = 0;
    for (int s = 0; s < stages; s++)
        for (int i = 0; i < n; i++) {
            double size = fabs(x[s * n + i]) * weight[i];
            if (!(size <= largest))
                largest = size;
            if (isnan(size))
                return size;
        }
    return largest;
}

/* Factors with a new Jacobian, at the middle stage of the present iterate. Returns false if the
 * matrix is singular. */
INLINE bool newton_renew(const struct newton *equations, struct step *step, int n, double t,
                         double h, const double *y, const double *z, struct workspace *workspace)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int middle = tableau->stages / 2;
    double sum[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        sum[i] = y[i] + z[middle * n + i];
    return newton_factor(equations, step, n, t + tableau->c[middle] * h, h, sum, workspace);
}

/* Returns true if the real part of the factored determinant is positive, as it is in short
 * steps. */
INLINE bool newton_positive(const struct implicit_tableau *tableau, int n,
                            const struct workspace *workspace)
{
    return tableau->real == 0 || !lu_negative(n, workspace->real);
}

/* Takes back half of the last increment `move`. */
INLINE void newton_halve(int count, double *z, double *move)
{
    for (int i = 0; i < count; i++) {
        move[i] /= 2;
        z[i] -= move[i];
    }
}

/*
 * Iterates until increments stop decreasing, because a tolerance would bias the rounding. An
 * increment that does not bring the equations nearer to 0 is halved. Sets *is_near_root if the
 * solution is the one beside the guess. It is if increments shrink from the first one on, and if
 * the determinant is positive, as it is in short steps.
 */
INLINE enum step_status newton_iterate(const struct newton *equations, struct step *step, int n,
                                       double t, double h, const double *y, double *z,
                                       const double *weight, struct workspace *workspace,
                                       bool *is_near_root)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int stages = tableau->stages;
    double last = HUGE_VAL, previous_residual = HUGE_VAL;
    *is_near_root = newton_positive(tableau, n, workspace);
    for (int iteration = 0, halvings = 0; iteration < ITERATIONS;) {
        equations->residual(equations, step, n, t, h, y, z, workspace->slope, workspace->residual);
        double residual = newton_size(stages, n, weight, workspace->residual);
        if (iteration == 0 && !isfinite(residual))
            return STEP_NONFINITE;
        if (!(residual < previous_residual) && last > INCREMENT_STALL_RELATIVE) {
            if (++halvings > HALVINGS)
                return STEP_NO_SOLUTION;
            *is_near_root = false;
            newton_halve(stages * n, z, workspace->move);
            continue;
        }
        memcpy(workspace->move, workspace->residual, (size_t)(stages * n) * sizeof *z);
        newton_increment(tableau, step, n, workspace, workspace->move);
        double size = newton_size(stages, n, weight, workspace->move);
        for (int i = 0; i < stages * n; i++)
            z[i] += workspace->move[i];
        if (size > CONTRACTION_MAX * last && size > INCREMENT_STALL_RELATIVE)
            *is_near_root = false;
        if (step->system->linear || size <= DBL_EPSILON / 2 ||
            (size >= last && size <= INCREMENT_STALL_RELATIVE)) {
            *is_near_root = *is_near_root && newton_positive(tableau, n, workspace);
            return STEP_OK;
        }
        if (size > JACOBIAN_REUSE_RATE * last &&
            !newton_renew(equations, step, n, t, h, y, z, workspace))
            return STEP_NO_SOLUTION;
        last = size;
        previous_residual = residual;
        halvings = 0;
        iteration++;
    }
    *is_near_root = false;
    return last <= INCREMENT_STALL_RELATIVE ? STEP_OK : STEP_NO_SOLUTION;
}

/* Finds the solution that belongs to y, from z = 0. If the iteration may have found another one,
 * the solution is followed from a step of length 0: the equation of a step of y' = -y^2 has two
 * solutions, and in long steps the iteration may find the wrong one. */
INLINE enum step_status newton_to_rounding(const struct newton *equations, struct step *step, int n,
                                           double t, double h, const double *y, double *z,
                                           const double *weight, struct workspace *workspace)
{
    bool is_near_root;
    const enum step_status status =
        newton_iterate(equations, step, n, t, h, y, z, weight, workspace, &is_near_root);
    if (step->system->linear || status == STEP_NONFINITE || (status == STEP_OK && is_near_root))
        return status;
    if (newton_follow(equations, step, n, t, h, y, z, weight, workspace->h))
        return STEP_OK;
    return status;
}

/* Sets weight to 1/size of each variable, in which increments are measured. */
INLINE void newton_weights(const double *scale, int n, const double *y, double *weight)
{
    for (int i = 0; i < n; i++) {
        double size = fabs(y[i]);
        weight[i] = 1 / (size > scale[i] ? size : scale[i]);
    }
}

/* ---- one stage in closed form ---- */

/*
 * Solves q' = q + h v', v' = v + h (F(q) - stiffness h v' - damping v' - quadratic |v'| v'): a
 * scalar equation in v', because the force that does not depend on velocity is linear in q. `force`
 * is the force at t and y; `dragged` is true if o->quadratic is not 0.
 */
INLINE enum step_status oscillator_stage(const struct oscillator *o, bool dragged, double force,
                                         struct step *step, double h, const double *y, double *z,
                                         double *sum)
{
    /* the same in each step */
    const double a = 1 + o->damping * h + o->stiffness * h * h, inverse = 1 / a;
    const double bend = 4 * (o->quadratic * h * inverse) * inverse, r = y[1] + h * force,
                 u = r * inverse;
    step->cost.evals++;
    step->cost.solves++;
    if (!isfinite(a) || !isfinite(r))
        return STEP_NONFINITE;
    const double v = dragged ? 2 * u / (1 + sqrt(1 + bend * fabs(r))) : u; /* drag_root() */
    const double drag = dragged ? o->quadratic * h * fabs(v) : -0.0;
    const double restoring = h * (o->stiffness * h + o->damping) * v,
                 lost = dragged ? drag * v : -0.0;
    /* The increment is computed from the force if the factor is small: the rounding of a would
     * shift v in the same way at every step. */
    const bool small = fabs(a - 1 + drag) < 1;
    z[0] = h * v;
    z[1] = small ? (h * force - restoring) - lost : v - y[1];
    sum[0] = y[0] + z[0];
    sum[1] = small ? y[1] + z[1] : v;
    return isfinite(v) ? STEP_OK : STEP_NO_SOLUTION;
}

/* ---- one stage of an equation of motion ---- */

/* Sets *inverse to 1 over the derivative of the velocity's equation, and *positive to its sign,
 * which is true in short steps. Returns false if the derivative has no finite inverse. */
INLINE bool motion_factor(jacobian_function *slopes, const void *forces, struct step *step,
                          double t, double h, const double *state, double *inverse, bool *positive)
{
    double jacobian[4];
    slopes(forces, t, state, jacobian);
    step->cost.jacobians++;
    *inverse = 1 / (1 - h * (h * jacobian[2] + jacobian[3]));
    *positive = *inverse > 0;
    return *inverse != 0 && isfinite(*inverse);
}

/* Solves v' = v + h a(t, q + h v', v') for x = v' - v: newton_iterate() with one equation in place
 * of two. If increments shrink so fast that the next one would be below rounding, it is not
 * computed. */
INLINE enum step_status motion_iterate(slope_function *slope, jacobian_function *slopes,
                                       const void *forces, struct step *step, double t, double h,
                                       const double *y, double *x, double weight,
                                       bool *is_near_root)
{
    double inverse, last = HUGE_VAL, previous_residual = HUGE_VAL, move = 0, sum[2] = {y[0], y[1]},
                    dydt[2];
    bool positive;
    if (!motion_factor(slopes, forces, step, t, h, sum, &inverse, &positive))
        return STEP_NO_SOLUTION;
    *is_near_root = positive;
    for (int iteration = 0, halvings = 0; iteration < ITERATIONS;) {
        sum[1] = y[1] + *x;
        sum[0] = y[0] + h * sum[1];
        slope(forces, t, sum, dydt);
        step->cost.evals++;
        const double residual = h * dydt[1] - *x, residual_size = fabs(residual) * weight;
        if (iteration == 0 && !isfinite(residual))
            return STEP_NONFINITE;
        if (!(residual_size < previous_residual) && last > INCREMENT_STALL_RELATIVE) {
            if (++halvings > HALVINGS)
                return STEP_NO_SOLUTION;
            *is_near_root = false;
            move /= 2;
            *x -= move;
            continue;
        }
        move = residual * inverse;
        step->cost.solves++;
        const double size = fabs(move) * weight;
        *x += move;
        if (size > CONTRACTION_MAX * last && size > INCREMENT_STALL_RELATIVE)
            *is_near_root = false;
        if (size <= DBL_EPSILON / 2 || (size >= last && size <= INCREMENT_STALL_RELATIVE) ||
            (iteration > 0 && size * size <= INCREMENT_NEGLIGIBLE * last)) {
            *is_near_root = *is_near_root && positive;
            return STEP_OK;
        }
        if (size > JACOBIAN_REUSE_RATE * last) {
            sum[1] = y[1] + *x;
            sum[0] = y[0] + h * sum[1];
            if (!motion_factor(slopes, forces, step, t, h, sum, &inverse, &positive))
                return STEP_NO_SOLUTION;
        }
        last = size;
        previous_residual = residual_size;
        halvings = 0;
        iteration++;
    }
    *is_near_root = false;
    return last <= INCREMENT_STALL_RELATIVE ? STEP_OK : STEP_NO_SOLUTION;
}

/*
 * Solves a stage as newton_stage(), to rounding, for q'' = a(t, q, q') of one coordinate, with z
 * and y + z [2] and the work of newton_follow(). The functions are separate parameters, so that a
 * compiler that knows them inlines them.
 */
INLINE enum step_status motion_stage(slope_function *slope, jacobian_function *slopes,
                                     const void *forces, struct step *step, double t, double h,
                                     const double *y, double *z, double *sum, double *work)
{
    double weight[2], x = 0;
    bool is_near_root = false;
    newton_weights(step_scale(step), 2, y, weight);
    const double by_position = fabs(h) * weight[0];
    const double larger = weight[1] > by_position ? weight[1] : by_position;
    enum step_status status =
        motion_iterate(slope, slopes, forces, step, t, h, y, &x, larger, &is_near_root);
    z[1] = x;
    z[0] = h * (y[1] + x);
    if (status != STEP_NONFINITE && !(status == STEP_OK && is_near_root)) {
        static const struct implicit_tableau euler = NEWTON_EULER;
        const struct newton equations = {&euler, newton_stages, slope, slopes, forces};
        double all[2] = {z[0], z[1]}, y_begin[2] = {y[0], y[1]};
        if (newton_follow(&equations, step, 2, t, h, y_begin, all, weight, work)) {
            z[0] = all[0];
            z[1] = all[1];
            status = STEP_OK;
        }
    }
    sum[0] = y[0] + z[0];
    sum[1] = y[1] + z[1];
    return status;
}
