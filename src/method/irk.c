/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any implicit Runge-Kutta tableau. Source: Hairer, Wanner 1996, Solving ODEs II, IV.6, IV.8. */
#include <assert.h>

#include "newton.h"

/*
 * Stage by stage: slopes [stages][n], then z, sum, base [n], then the solver's.
 * All at once: increments z [stages][n], then the solver's.
 */
size_t implicit_work(const struct method *method, int n)
{
    const struct implicit_tableau *tableau = method->implicit;
    size_t values = (size_t)tableau->stages * (size_t)n;
    return tableau->diagonal != 0 ? values + 3 * (size_t)n + newton_room(1, n)
                                  : values + newton_room(tableau->stages, n);
}

/* sum_j w_j k_j[i] over the weights that are not zero, from the first to the last */
static double weighted(const double *w, int count, const double *k, int n, int i)
{
    double sum = -0.0;
    for (int j = 0; j < count; j++)
        if (w[j] != 0)
            sum += w[j] * k[j * n + i];
    return sum;
}

/* ---- stage by stage ---- */

/* The last stage is the new state. */
static bool stiffly_accurate(const struct implicit_tableau *tableau)
{
    int s = tableau->stages;
    for (int i = 0; i < s; i++)
        if (tableau->a[(s - 1) * s + i] != tableau->b[i])
            return false;
    return true;
}

static bool estimate_diagonal(const struct implicit_tableau *tableau, struct step *step, const double *slope,
                              double *own)
{
    int n = step->system->n, stages = tableau->stages;
    for (int i = 0; i < n; i++) {
        double sum = -0.0;
        for (int s = 0; s < stages; s++)
            sum += (tableau->b[s] - tableau->companion[s]) * slope[s * n + i];
        step->error[i] = step->h * sum;
    }
    return newton_filter(newton_euler.tableau, step, step->t, tableau->diagonal * step->h, step->y, step->error, own);
}

static enum step_status diagonal_step(const struct implicit_tableau *tableau, struct step *step)
{
    const int n = step->system->n, stages = tableau->stages;
    const double t = step->t, h = step->h, part = tableau->diagonal * h, *y = step->y;
    double *slope = step->work, *z = slope + stages * n, *sum = z + n, *base = sum + n, *own = base + n;
    if (!step->warm)
        newton_forget(own);

    for (int s = 0; s < stages; s++) {
        const double *row = tableau->a + s * stages;
        double *k = slope + s * n;
        if (row[s] == 0) { /* the first, at y */
            if (tableau->fsal && step->warm) {
                memcpy(k, slope + (stages - 1) * n, (size_t)n * sizeof *k);
            } else {
                system_derivative(step->system, t, y, k);
                step->cost.evals++;
            }
            continue;
        }
        for (int i = 0; i < n; i++)
            base[i] = s > 0 ? y[i] + h * weighted(row, s, slope, n, i) : y[i];
        enum step_status status = newton_stage(step, t + tableau->c[s] * h, part, base, z, sum, own);
        if (status != STEP_OK)
            return status;
        for (int i = 0; i < n; i++)
            k[i] = z[i] / part;
    }
    if (step->error && tableau->companion && !estimate_diagonal(tableau, step, slope, own))
        return STEP_NO_SOLUTION;
    if (stiffly_accurate(tableau) && !step->low)
        return step_finish(step, sum);
    for (int i = 0; i < n; i++)
        z[i] = h * weighted(tableau->b, stages, slope, n, i);
    return step_increase(step, z);
}

/* ---- all at once ---- */

/*
 * The polynomial through 0 at theta = 0 and the increments z_s at theta = c_s, divided by theta, in Newton's form: of
 * one component, in place.
 */
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

static double polynomial(const struct implicit_tableau *tableau, const double *difference, double theta)
{
    double value = difference[tableau->stages - 1];
    for (int s = tableau->stages - 1; s-- > 0;)
        value = difference[s] + (theta - tableau->c[s]) * value;
    return theta * value;
}

/* The collocation polynomial, from the end of the step. */
void implicit_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    const struct implicit_tableau *tableau = method->implicit;
    int n = step->system->n;
    const double *z = step->work;
    for (int i = 0; i < n; i++) {
        double difference[3];
        for (int s = 0; s < tableau->stages; s++)
            difference[s] = z[s * n + i];
        divide_differences(tableau, difference);
        y[i] = step->y[i] + (polynomial(tableau, difference, theta) - polynomial(tableau, difference, 1));
    }
}

/* (real - h J)^-1 (h f(t, at) + sum_s estimate_s z_s) */
static bool estimate(const struct implicit_tableau *tableau, struct step *step, const double *at, const double *z,
                     double *own)
{
    int n = step->system->n;
    double slope[LIMIT_VARIABLES];
    system_derivative(step->system, step->t, at, slope);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        step->error[i] = step->h * slope[i] + weighted(tableau->estimate, tableau->stages, z, n, i);
    return newton_filter(tableau, step, step->t, step->h, step->y, step->error, own);
}

/* In a first step and after a rejection the estimate of a stiff error is too large by far: once more from there. */
static bool estimate_again(const struct implicit_tableau *tableau, struct step *step, const double *z, double *own)
{
    const struct system *system = step->system;
    double at[LIMIT_VARIABLES], sum = 0;
    for (int i = 0; i < system->n; i++) {
        double ratio = step->error[i] / fmax(system->scale[i], fabs(step->y[i]));
        sum += ratio * ratio;
        at[i] = step->y[i] + step->error[i];
    }
    return sqrt(sum / system->n) <= step->tol || estimate(tableau, step, at, z, own);
}

static enum step_status coupled_step(const struct implicit_tableau *tableau, struct step *step)
{
    const struct newton equations = {tableau, newton_stages};
    const int n = step->system->n, stages = tableau->stages;
    double *z = step->work, *own = z + stages * n;
    assert(stages <= 3);
    if (!step->warm)
        newton_forget(own);
    /*
     * From 0, not from the last step's polynomial: that would save iterations, but leads steps that are too long past a
     * fold (van der Pol) to solutions that are none, and would make a step depend on the one before.
     */
    memset(z, 0, (size_t)(stages * n) * sizeof *z);
    enum step_status status = newton_solve(&equations, step, step->t, step->h, step->y, z, own);
    if (status != STEP_OK)
        return status;
    if (step->error && tableau->estimate &&
        (!estimate(tableau, step, step->y, z, own) || (!step->warm && !estimate_again(tableau, step, z, own))))
        return STEP_NO_SOLUTION;
    double increment[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        increment[i] = weighted(tableau->d, stages, z, n, i);
    return step_increase(step, increment);
}

enum step_status implicit_step(const struct method *method, struct step *step)
{
    return method->implicit->diagonal != 0 ? diagonal_step(method->implicit, step)
                                           : coupled_step(method->implicit, step);
}
