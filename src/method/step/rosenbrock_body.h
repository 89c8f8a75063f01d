/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One step of a Rosenbrock method of up to three variables. rosenbrock.c compiles it for any row
 * and system, kernel/rosenbrock.c where the compiler knows both; both give the same bits. Source:
 * Hairer, Wanner 1996, Solving ODEs II, IV.7, eq. 7.25.
 */
#pragma once

#include "method/step/lu_body.h"
#include "method/step/step.h"

#ifndef UNROLL
#define UNROLL
#endif
#ifndef INLINE
#define INLINE static inline __attribute__((always_inline))
#endif

/* Computes the Jacobian jac [n][n] at t and y; forces is data of the function. */
typedef void jacobian_function(const void *forces, double t, const double *y, double *jac);

/* Functions that a step evaluates; `forces` is their data. */
struct rosenbrock_forces {
    slope_function *slope;
    jacobian_function *jacobian;
    const void *forces;
    bool timed; /* the slope depends on t, too */
};

/* Sets sum to sum_j w_j u_j over the weights that are not zero, from the first to the last. */
INLINE void rosenbrock_combine(int n, const double *w, int count, const double *u, double *sum)
{
    for (int i = 0; i < n; i++)
        sum[i] = -0.0;
    for (int j = 0; j < count; j++)
        for (int i = 0; i < n && w[j] != 0; i++)
            sum[i] += w[j] * u[j * n + i];
}

/* Returns true if stage s is at the same point of time and space as the one before it (ros3p), so
 * that f is known. row is its part of a. */
INLINE bool rosenbrock_same_point(const struct rosenbrock *rosenbrock, const double *row, int s)
{
    bool same = row[s - 1] == 0 && rosenbrock->alpha[s] == rosenbrock->alpha[s - 1];
    UNROLL for (int j = 0; j < s - 1; j++) same = same && row[j] == row[j - (s - 1)];
    return same;
}

/* Sets slope [n] to df/dt at the step's t and y: in closed form for the driven oscillator, else by
 * differences. later_slope [n] is scratch memory. */
void rosenbrock_time_derivative(struct step *step, double *slope, double *later_slope);

INLINE void rosenbrock_copy(int count, const double *source, double *target)
{
    for (int i = 0; i < count; i++)
        target[i] = source[i];
}

/* ---- up to three unknowns, in pairs of numbers in registers; multiplying by the inverse is a
 * shorter chain of operations than two substitutions ---- */

/* Largest n whose matrix is inverted, and most stages of a method. */
enum { INVERTED = 3, STAGES_MOST = 8 };

typedef double pair __attribute__((vector_size(16)));

/* A vector of up to three numbers. */
struct few {
    pair pairs[2]; /* unused numbers are 0 */
};

/* Returns component i. */
INLINE double few_get(const struct few *x, int i)
{
    return x->pairs[i / 2][i % 2];
}

/* Returns the vector of x [n]. */
INLINE struct few few_of(int n, const double *x)
{
    struct few few = {{{x[0], n > 1 ? x[1] : 0}, {n > 2 ? x[2] : 0, 0}}};
    return few;
}

/* Adds a x to *sum. */
INLINE void few_add(int n, struct few *sum, double a, const struct few *x)
{
    const pair factor = {a, a};
    for (int q = 0; q < (n + 1) / 2; q++)
        sum->pairs[q] += factor * x->pairs[q];
}

/* Returns sum_j w_j u_j over the weights that are not zero, from the first to the last. */
INLINE struct few few_sum(int n, const double *w, int count, const struct few *u)
{
    struct few sum = {{{-0.0, -0.0}, {-0.0, -0.0}}};
    UNROLL for (int j = 0; j < count; j++) if (w[j] != 0) few_add(n, &sum, w[j], &u[j]);
    return sum;
}

/* Returns start + sum_j column_j x_j, a matrix times a vector. */
INLINE struct few few_multiply(int n, const struct few *column, const double *x, struct few start)
{
    for (int j = 0; j < n; j++)
        few_add(n, &start, x[j], &column[j]);
    return start;
}

/* Computes the columns of the inverse of diagonal - jacobian by elimination. Returns false if it is
 * singular. */
INLINE bool few_eliminate(int n, double diagonal, const double *jacobian, struct few *column)
{
    double a[INVERTED * INVERTED], pivot[INVERTED], x[INVERTED];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            a[i * n + j] = (i == j ? diagonal : -0.0) - jacobian[i * n + j];
    if (!lu_factor_size(n, a, pivot))
        return false;
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < n; i++)
            x[i] = i == k;
        lu_solve_size(n, a, pivot, x);
        column[k] = few_of(n, x);
    }
    return true;
}

/* The case of two unknowns whose determinant overflows or underflows, out of line. */
__attribute__((noinline, cold)) static bool
few_eliminate_two(double diagonal, const double *jacobian, struct few *column)
{
    return few_eliminate(2, diagonal, jacobian, column);
}

/* Computes the columns of the inverse of diagonal - jacobian. Two unknowns use the determinant,
 * which is as exact as the second pivot, but needs neither a choice of rows nor two divisions in a
 * row. Returns false if the matrix is singular. */
INLINE bool few_inverse(int n, double diagonal, const double *jacobian, struct few *column)
{
    if (n != 2)
        return few_eliminate(n, diagonal, jacobian, column);
    const double a = diagonal - jacobian[0], d = diagonal - jacobian[3],
                 det = a * d - jacobian[1] * jacobian[2];
    const double size = fabs(det), inverse_det = 1 / det;
    if (size > 1e-290 && size < 1e290) {
        column[0] = (struct few){{{d * inverse_det, jacobian[2] * inverse_det}}};
        column[1] = (struct few){{{jacobian[1] * inverse_det, a * inverse_det}}};
        return true;
    }
    double copied[4];
    struct few rare[INVERTED];
    rosenbrock_copy(4, jacobian, copied);
    if (!few_eliminate_two(diagonal, copied, rare))
        return false;
    column[0] = rare[0];
    column[1] = rare[1];
    return true;
}

/* Jacobian, slope and its derivative by t at the start of the step. */
struct few_start {
    double jacobian[INVERTED * INVERTED], first[INVERTED], drift[INVERTED];
};

/* Computes the stages u_i from y; column holds the inverse matrix. */
INLINE void few_stages(int n, const struct rosenbrock *rosenbrock,
                       const struct rosenbrock_forces *derivatives, struct step *step,
                       const double *y, const struct few_start *start, const struct few *column,
                       struct few *u)
{
    const double h = step->h, t = step->t, rate = 1 / h;
    const struct few y_begin = few_of(n, y), nothing = {{{-0.0, -0.0}, {-0.0, -0.0}}};
    double f[INVERTED], z[INVERTED];
    int evals = 0;
    rosenbrock_copy(n, start->first, f);
    UNROLL for (int s = 0; s < rosenbrock->stages; s++)
    {
        const double *const a = rosenbrock->a + s * (s - 1) / 2, *const c = rosenbrock->c +
                                                                            s * (s - 1) / 2;
        if (s > 0 && !rosenbrock_same_point(rosenbrock, a, s)) {
            /* the newest stage is added last, so that the other sums do not wait for it */
            struct few state = few_sum(n, a, s - 1, u);
            for (int q = 0; q < (n + 1) / 2; q++)
                state.pairs[q] = y_begin.pairs[q] + state.pairs[q];
            if (a[s - 1] != 0)
                few_add(n, &state, a[s - 1], &u[s - 1]);
            for (int i = 0; i < n; i++)
                z[i] = few_get(&state, i);
            derivatives->slope(derivatives->forces, t + rosenbrock->alpha[s] * h, z, f);
            evals++;
        }
        const struct few sum = few_sum(n, c, s, u);
        double right[INVERTED];
        for (int i = 0; i < n; i++) {
            right[i] = few_get(&sum, i) * rate;
            if (derivatives->timed && rosenbrock->d[s] != 0)
                right[i] += rosenbrock->d[s] * h * start->drift[i];
        }
        for (int i = 0; i < n; i++)
            right[i] = f[i] + right[i];
        u[s] = few_multiply(n, column, right, nothing);
    }
    step->cost.evals += evals;
    step->cost.solves += rosenbrock->stages;
}

/* Takes a step of up to INVERTED variables, where the compiler knows n. */
INLINE enum step_status rosenbrock_small_step(int n, const struct rosenbrock *rosenbrock,
                                              const struct rosenbrock_forces *derivatives,
                                              struct step *step)
{
    const int stages = rosenbrock->stages;
    double *const reused = step->work, *const jacobian = reused + stages * n,
                  *const first = jacobian + n * n;
    double *const drift = first + n, *const error = step->error, y[INVERTED], increment[INVERTED];
    struct few u[STAGES_MOST], column[INVERTED];
    struct few_start start;
    if (n < 1 || stages < 1)
        __builtin_unreachable();
    rosenbrock_copy(n, step->y, y);
    if (step->again) {
        rosenbrock_copy(n * n, jacobian, start.jacobian);
        rosenbrock_copy(n, first, start.first);
    } else {
        if (derivatives->timed)
            rosenbrock_time_derivative(step, drift, drift + n);
        derivatives->jacobian(derivatives->forces, step->t, y, start.jacobian);
        derivatives->slope(derivatives->forces, step->t, y, start.first);
        step->cost.jacobians++;
        step->cost.evals++;
        rosenbrock_copy(n * n, start.jacobian, jacobian);
        rosenbrock_copy(n, start.first, first);
    }
    for (int i = 0; i < n && derivatives->timed; i++)
        start.drift[i] = drift[i];
    if (!few_inverse(n, 1 / (rosenbrock->gamma * step->h), start.jacobian, column))
        return STEP_NO_SOLUTION;
    few_stages(n, rosenbrock, derivatives, step, y, &start, column, u);
    UNROLL for (int s = 0; s < stages; s++) for (int i = 0; i < n; i++) reused[s * n + i] =
        few_get(&u[s], i);
    if (error && rosenbrock->b_hat) {
        struct few sum = {{{-0.0, -0.0}, {-0.0, -0.0}}};
        UNROLL for (int s = 0; s < stages; s++) if (rosenbrock->m[s] != rosenbrock->b_hat[s])
            few_add(n, &sum, rosenbrock->m[s] - rosenbrock->b_hat[s], &u[s]);
        for (int i = 0; i < n; i++)
            error[i] = few_get(&sum, i);
    }
    const struct few sum = few_sum(n, rosenbrock->m, stages, u);
    for (int i = 0; i < n; i++)
        increment[i] = few_get(&sum, i);
    return step_increase_all(step, n, increment);
}
