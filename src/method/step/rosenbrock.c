/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any Rosenbrock (linearly implicit Runge-Kutta) method, and its dense output. */
#include <hooke/base/elementary.h>

#include "method/step/rosenbrock_body.h"

/* Distance of the two points of a difference quotient in t, as a part of h; the error stays far
 * below that of the step. */
static const double TIME_DIFFERENCE_FRACTION = 1. / 8192;

/* The work array holds u [stages][n], the Jacobian, four states, the matrix. */
size_t rosenbrock_work(const struct method *method, int n)
{
    return (size_t)(method->rosenbrock->stages + n + 4) * (size_t)n + LU_ROOM(n);
}

/* Sets slope [n] to df/dt at the start of the step; later_slope [n] is scratch memory. */
void rosenbrock_time_derivative(struct step *step, double *slope, double *later_slope)
{
    const struct system *system = step->system;
    const struct oscillator *o = &system->oscillator;
    int n = system->n;
    if (o->whole && system->order == 2 && n == 2) {
        slope[0] = 0;
        slope[1] = -o->drive * o->omega * fixed_sin(o->omega * step->t + o->phase);
        return;
    }
    double earlier = step->t - step->h * (TIME_DIFFERENCE_FRACTION / 2),
           later = step->t + step->h * (TIME_DIFFERENCE_FRACTION / 2);
    system_derivative(system, earlier, step->y, slope);
    system_derivative(system, later, step->y, later_slope);
    step->cost.evals += 2;
    for (int i = 0; i < n; i++)
        slope[i] = later != earlier ? (later_slope[i] - slope[i]) / (later - earlier) : 0;
}

/* Computes the stages u_i from y with a factored matrix, for any n; sum [n] is scratch memory.
 * Returns false if the matrix is singular. */
static bool large_stages(const struct rosenbrock *rosenbrock, struct step *step, double *sum)
{
    const struct system *system = step->system;
    const int n = system->n, stages = rosenbrock->stages;
    const double h = step->h, t = step->t, *a = rosenbrock->a, *c = rosenbrock->c, *y = step->y;
    double *const u = step->work, *const jacobian = u + stages * n, *const first = jacobian + n * n;
    double *const drift = first + n, *const z = drift + n, *const later = z + n,
                  *const matrix = later + n;
    const double *f = first, diagonal = 1 / (rosenbrock->gamma * h), rate = 1 / h;
    if (!step->again) {
        if (!system->autonomous)
            rosenbrock_time_derivative(step, drift, later);
        system_jacobian(system, t, y, jacobian);
        system_derivative(system, t, y, first);
        step->cost.jacobians++;
        step->cost.evals++;
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            matrix[i * n + j] = (i == j ? diagonal : -0.0) - jacobian[i * n + j];
    if (!lu_factor(n, matrix))
        return false;
    for (int s = 0; s < stages; a += s, c += s, s++) {
        if (s > 0 && !rosenbrock_same_point(rosenbrock, a, s)) {
            f = later;
            rosenbrock_combine(n, a, s, u, sum);
            for (int i = 0; i < n; i++)
                z[i] = y[i] + sum[i];
            system_derivative(system, t + rosenbrock->alpha[s] * h, z, later);
            step->cost.evals++;
        }
        rosenbrock_combine(n, c, s, u, sum);
        for (int i = 0; i < n; i++)
            sum[i] *= rate;
        if (!system->autonomous && rosenbrock->d[s] != 0)
            for (int i = 0; i < n; i++)
                sum[i] += rosenbrock->d[s] * h * drift[i];
        for (int i = 0; i < n; i++)
            u[s * n + i] = f[i] + sum[i];
        lu_solve(n, matrix, u + s * n);
        step->cost.solves++;
    }
    return true;
}

/* Takes a step for any n by large_stages(). */
static enum step_status large_step(const struct rosenbrock *rosenbrock, struct step *step)
{
    const int n = step->system->n, stages = rosenbrock->stages;
    const double *const u = step->work;
    double sum[LIMIT_VARIABLES];
    if (!large_stages(rosenbrock, step, sum))
        return STEP_NO_SOLUTION;
    for (int i = 0; i < n && step->error && rosenbrock->b_hat; i++)
        step->error[i] = weighted_difference(rosenbrock->m, rosenbrock->b_hat, stages, u, n, i);
    rosenbrock_combine(n, rosenbrock->m, stages, u, sum);
    return step_increase(step, sum);
}

/* Takes a step by the inlined code for up to three variables, else by large_step(). */
enum step_status rosenbrock_step(const struct method *method, struct step *step)
{
    const struct rosenbrock *rosenbrock = method->rosenbrock;
    const struct rosenbrock_forces derivatives = {step_slope, step_jacobian, step->system,
                                                  !step->system->autonomous};
    switch (step->system->n) {
    case 1:
        return rosenbrock_small_step(1, rosenbrock, &derivatives, step);
    case 2:
        return rosenbrock_small_step(2, rosenbrock, &derivatives, step);
    case 3:
        return rosenbrock_small_step(3, rosenbrock, &derivatives, step);
    default:
        return large_step(rosenbrock, step);
    }
}

/* Evaluates the dense output at theta, measured from the end of the step. */
void rosenbrock_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    const struct rosenbrock *rosenbrock = method->rosenbrock;
    const double *u = step->work;
    int n = step->system->n, stages = rosenbrock->stages;
    double sum[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        y[i] = 0;
    for (int m = rosenbrock->degree; m-- > 0;) {
        rosenbrock_combine(n, rosenbrock->dense + m * stages, stages, u, sum);
        for (int i = 0; i < n; i++)
            y[i] = y[i] * theta + sum[i];
    }
    rosenbrock_combine(n, rosenbrock->m, stages, u, sum);
    for (int i = 0; i < n; i++)
        y[i] = step->y[i] + (1 - theta) * (theta * y[i] - sum[i]);
}

/*
 * Rewrites the dense output theta (1 - theta) (e_0 + e_1 theta + …), of degree 4 at most, in the
 * form of struct dense_polynomial: its factor is e_0 + theta (twist + (1 - theta) (d_0 + theta
 * d_1)).
 */
void rosenbrock_polynomial(const struct method *method, const struct step *step, int i,
                           struct dense_polynomial *polynomial)
{
    const struct rosenbrock *rosenbrock = method->rosenbrock;
    const int n = step->system->n, stages = rosenbrock->stages;
    double e[ROSENBROCK_DEGREE] = {0};
    for (int m = 0; m < rosenbrock->degree; m++)
        e[m] = weighted_sum(rosenbrock->dense + m * stages, stages, step->work, n, i);
    const double last = -e[3], bend = last - e[2];
    *polynomial =
        (struct dense_polynomial){.end = step->y[i],
                                  .h = 1,
                                  .rise = weighted_sum(rosenbrock->m, stages, step->work, n, i),
                                  .first = e[0],
                                  .twist = e[1] - bend,
                                  .bends = 2,
                                  .bend = {bend, last}};
}
