/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any implicit Runge-Kutta method, by its tableau: stages solved one by one, or all at
 * once. Source: Hairer, Wanner 1996, Solving ODEs II, IV.6, IV.8. */
#include <assert.h>

#include "method/step/irk_body.h"

/*
 * Returns the size of work. If stages are solved one by one it holds slopes [stages][n], then z,
 * sum and base [n]; otherwise the increments z [stages][n]. The memory of the solver follows.
 */
size_t implicit_work(const struct method *method, int n)
{
    const struct implicit_tableau *tableau = method->implicit;
    size_t values = (size_t)tableau->stages * (size_t)n;
    return tableau->diagonal != 0 ? values + 3 * (size_t)n + newton_capacity(1, n)
                                  : values + newton_capacity(tableau->stages, n);
}

/* ---- stages one by one ---- */

/* Sets step->error to the filtered difference from the embedded method. Returns false if the matrix
 * is singular. */
static bool estimate_diagonal(const struct implicit_tableau *tableau, struct step *step,
                              const double *slope, double *own)
{
    int n = step->system->n, stages = tableau->stages;
    for (int i = 0; i < n; i++) {
        double sum = -0.0;
        for (int s = 0; s < stages; s++)
            sum += (tableau->b[s] - tableau->b_hat[s]) * slope[s * n + i];
        step->error[i] = step->h * sum;
    }
    return newton_filter(&newton_euler, step, step->t, tableau->diagonal * step->h, step->y,
                         step->error, own);
}

/* Solves one stage by newton_stage(), for a stage_function. */
static enum step_status general_stage(const void *system, struct step *step, double t, double h,
                                      const double *y, double *z, double *sum, double *work)
{
    (void)system;
    return newton_stage(step, t, h, y, z, sum, work);
}

/* Takes a step of a method whose stages are solved one by one. */
static enum step_status diagonal_step(const struct implicit_tableau *tableau, struct step *step)
{
    const int n = step->system->n, stages = tableau->stages;
    double *slope = step->work, *z = slope + stages * n, *sum = z + n, *base = sum + n,
           *own = base + n;
    if (!step->warm)
        newton_forget(own);
    const enum step_status status =
        diagonal_stages(tableau, n, general_stage, step_slope, step->system, step, step->warm,
                        slope, z, sum, base, own);
    if (status != STEP_OK)
        return status;
    if (step->error && tableau->b_hat && !estimate_diagonal(tableau, step, slope, own))
        return STEP_NO_SOLUTION;
    if (stiffly_accurate(tableau) && !step->low)
        return step_finish(step, sum);
    diagonal_increment(tableau, n, step->h, slope, z);
    return step_increase(step, z);
}

/* ---- all stages at once ---- */

/* Computes, in place, the divided differences (Newton's form) of the polynomial through 0 at theta
 * = 0 and the increments z_s at theta = c_s, divided by theta; for one component. */
static void divide_differences(const struct implicit_tableau *tableau, double *z)
{
    int stages = tableau->stages;
    const double *c = tableau->c;
    for (int s = 0; s < stages; s++)
        z[s] /= c[s];
    for (int level = 1; level < stages; level++)
        for (int s = stages; s-- > level;)
            z[s] = (z[s] - z[s - 1]) / (c[s] - c[s - level]);
}

/* Evaluates that polynomial at theta. */
static double evaluate_polynomial(const struct implicit_tableau *tableau, const double *difference,
                                  double theta)
{
    double value = difference[tableau->stages - 1];
    for (int s = tableau->stages - 1; s-- > 0;)
        value = difference[s] + (theta - tableau->c[s]) * value;
    return theta * value;
}

/* Evaluates the collocation polynomial, measured from the end of the step. */
void implicit_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    const struct implicit_tableau *tableau = method->implicit;
    int n = step->system->n;
    const double *z = step->work;
    assert(tableau->stages > 0 && tableau->stages <= 3);
    for (int i = 0; i < n; i++) {
        double difference[3];
        for (int s = 0; s < tableau->stages; s++)
            difference[s] = z[s * n + i];
        divide_differences(tableau, difference);
        y[i] = step->y[i] + (evaluate_polynomial(tableau, difference, theta) -
                             evaluate_polynomial(tableau, difference, 1));
    }
}

/* Sets step->error to (real - h J)^-1 (h f(t, state) + sum_s estimate_s z_s). Returns false if the
 * matrix is singular. */
static bool coupled_estimate(const struct implicit_tableau *tableau, struct step *step,
                             const double *state, const double *z, double *own)
{
    int n = step->system->n;
    double slope[LIMIT_VARIABLES];
    system_derivative(step->system, step->t, state, slope);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        step->error[i] =
            step->h * slope[i] + weighted_sum(tableau->estimate, tableau->stages, z, n, i);
    return newton_filter(tableau, step, step->t, step->h, step->y, step->error, own);
}

/* Estimates the error once more if it exceeds the tolerance, at the state changed by the first
 * estimate, because the first estimate of a stiff error is far too large in a first step and after
 * a rejection. Returns false if the matrix is singular. */
static bool estimate_again(const struct implicit_tableau *tableau, struct step *step,
                           const double *z, double *own)
{
    const struct system *system = step->system;
    const double *scale = step_scale(step);
    double state[LIMIT_VARIABLES], sum = 0;
    for (int i = 0; i < system->n; i++) {
        double ratio = step->error[i] / fmax(scale[i], fabs(step->y[i]));
        sum += ratio * ratio;
        state[i] = step->y[i] + step->error[i];
    }
    return sqrt(sum / system->n) <= step->tol || coupled_estimate(tableau, step, state, z, own);
}

/* Takes a step of a method whose stages are solved all at once: solves for their increments z,
 * estimates the error in step->error if that is wanted, and adds the weighted sum of z to the
 * state. Returns the status; STEP_NO_SOLUTION if the estimate fails. */
static enum step_status coupled_step(const struct implicit_tableau *tableau, struct step *step)
{
    const struct newton equations = newton_of(tableau, newton_stages, step->system);
    const int n = step->system->n, stages = tableau->stages;
    double *z = step->work, *own = z + stages * n;
    assert(stages <= 3);
    if (!step->warm)
        newton_forget(own);
    /*
     * The iteration starts from 0 and not from the last step's polynomial, which would save
     * iterations but lead steps that are too long past a fold (van der Pol) to wrong solutions, and
     * make a step depend on the one before.
     */
    memset(z, 0, (size_t)(stages * n) * sizeof *z);
    enum step_status status = newton_solve(&equations, step, step->t, step->h, step->y, z, own);
    if (status != STEP_OK)
        return status;
    if (step->error && tableau->estimate &&
        (!coupled_estimate(tableau, step, step->y, z, own) ||
         (!step->warm && !estimate_again(tableau, step, z, own))))
        return STEP_NO_SOLUTION;
    double increment[LIMIT_VARIABLES] = {0};
    for (int i = 0; i < n; i++)
        increment[i] = weighted_sum(tableau->d, stages, z, n, i);
    return step_increase(step, increment);
}

enum step_status implicit_step(const struct method *method, struct step *step)
{
    return method->implicit->diagonal != 0 ? diagonal_step(method->implicit, step)
                                           : coupled_step(method->implicit, step);
}
