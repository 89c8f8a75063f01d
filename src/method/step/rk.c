/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any explicit Runge-Kutta method, by its tableau, and its dense output. Source:
 * Hairer, Norsett, Wanner 1993, Solving ODEs I, II.1-6, II.10. */
#include "method/control/rk_error.h"

/* The work array holds k [stages + extra][n], one state, and a flag that tells if the extra stages
 * are those of the last step. */
size_t rk_work(const struct method *method, int n)
{
    return (size_t)(method->tableau->stages + method->tableau->extra + 1) * (size_t)n + 1;
}

/* Returns the flag in work that the extra stages of the interpolant belong to the last step. */
static double *interpolant_ready(const struct tableau *tableau, const struct step *step)
{
    return step->work + (tableau->stages + tableau->extra + 1) * step->system->n;
}

/* Takes a step: stages, new state, error estimate. The first slope is reused if it is known: the
 * last of the step before (FSAL), or that of a rejected attempt. */
enum step_status rk_step(const struct method *method, struct step *step)
{
    const struct tableau *tableau = method->tableau;
    int n = step->system->n, stages = tableau->stages;
    double *k = step->work, *z = k + (stages + tableau->extra) * n, rest[LIMIT_VARIABLES];
    double *low = step->low ? memcpy(rest, step->low, (size_t)n * sizeof *rest) : NULL;

    *interpolant_ready(tableau, step) = false;
    bool known = (tableau->fsal && step->warm) || step->again;
    if (tableau->fsal && step->warm)
        memcpy(k, k + (stages - 1) * n, (size_t)n * sizeof *k);
    rk_stages(tableau, n, step_slope, step->system, step->t, step->h, step->y, k, z, low, known);
    step->cost.evals += stages - known;
    if (step->error && tableau->b_hat)
        step->square =
            rk_estimate(tableau, n, step_scale(step), step->h, k, step->y, z, step->error);
    enum step_status status = step_finish(step, z);
    if (low && status == STEP_OK)
        memcpy(step->low, low, (size_t)n * sizeof *low);
    return status;
}

/* Computes the stages that only the interpolant needs, unless they are there already. States are
 * formed from the end of the step: y + h sum a k = y' + h sum (a - b) k. */
static void add_stages(const struct tableau *tableau, const struct step *step)
{
    int n = step->system->n, stages = tableau->stages, all = stages + tableau->extra;
    double *k = step->work, *z = k + all * n, *ready = interpolant_ready(tableau, step);
    if (*ready != 0)
        return;
    for (int s = stages; s < all; s++) {
        const double *a = tableau_row(tableau, s);
        for (int i = 0; i < n; i++) {
            double change = weighted_difference(a, tableau->b, stages, k, n, i) +
                            weighted_sum(a + stages, s - stages, k + stages * n, n, i);
            z[i] = step->y[i] + step->h * change;
        }
        system_derivative(step->system, step->t + (tableau->c[s] - 1) * step->h, z, k + s * n);
    }
    *ready = true;
}

/* Computes the interpolant of variable i: cubic Hermite with bends. */
void rk_polynomial(const struct method *method, const struct step *step, int i,
                   struct dense_polynomial *polynomial)
{
    const struct tableau *tableau = method->tableau;
    const int n = step->system->n, stages = tableau->stages, all = stages + tableau->extra;
    const double *k = step->work;
    add_stages(tableau, step);
    const double rise = weighted_sum(tableau->b, stages, k, n, i);
    const double first = k[i] - rise, last = rise - k[(stages - 1) * n + i];
    *polynomial = (struct dense_polynomial){.end = step->y[i],
                                            .h = step->h,
                                            .rise = rise,
                                            .first = first,
                                            .twist = last - first,
                                            .bends = tableau->bends};
    for (int m = 0; m < tableau->bends; m++)
        polynomial->bend[m] = weighted_sum(tableau->dense + m * all, all, k, n, i);
}

/* Evaluates the interpolant at theta for all variables. */
void rk_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    struct dense_polynomial polynomial;
    for (int i = 0; i < step->system->n; i++) {
        rk_polynomial(method, step, i, &polynomial);
        y[i] = dense_polynomial_at(&polynomial, theta);
    }
}
