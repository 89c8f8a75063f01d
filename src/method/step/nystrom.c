/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any Runge-Kutta-Nystrom method, by its tableau. Source: Hairer, Norsett, Wanner 1993,
 * Solving ODEs I, II.14. */
#include "method/step/step.h"

/* The work array holds k [stages][n/2], and one state. */
size_t nystrom_work(const struct method *method, int n)
{
    return (size_t)method->nystrom->stages * (size_t)n / 2 + (size_t)n;
}

/* Computes the acceleration k of state z at t, and counts the evaluation. */
static void acceleration(struct step *step, double t, const double *z, double *k)
{
    system_acceleration(step->system, t, z, k);
    step->cost.evals++;
}

/* Sets the positions of z to q + c h v + h^2 sum_j w_j k_j. */
static void nystrom_position(const struct step *step, double c, const double *w, int count,
                             double *z, double *low)
{
    int d = step->system->n / 2;
    double h = step->h;
    for (int i = 0; i < d; i++) {
        z[i] = step->y[i];
        double rate = c * step->y[d + i] + h * weighted_sum(w, count, step->work, d, i);
        step_add(&z[i], low ? &low[i] : NULL, h * rate);
    }
}

/* Takes a step: stages k, then positions and velocities, then the error estimate. */
enum step_status nystrom_step(const struct method *method, struct step *step)
{
    const struct nystrom *nystrom = method->nystrom;
    int n = step->system->n, d = n / 2, stages = nystrom->stages;
    double h = step->h, *k = step->work, *z = k + stages * d, rest[LIMIT_VARIABLES];
    double *low = step->low ? memcpy(rest, step->low, (size_t)n * sizeof *rest) : NULL;

    memcpy(z, step->y, (size_t)n * sizeof *z);
    if (nystrom->fsal && step->warm)
        memcpy(k, k + (stages - 1) * d, (size_t)d * sizeof *k);
    else if (!step->again)
        acceleration(step, step->t, step->y, k);
    for (int s = 1; s < stages; s++) {
        bool end = nystrom->fsal && s == stages - 1; /* the last row of a equals b */
        nystrom_position(step, nystrom->c[s], nystrom->a + s * (s - 1) / 2, s, z, end ? low : NULL);
        acceleration(step, step->t + nystrom->c[s] * h, z, k + s * d);
    }
    if (!nystrom->fsal)
        nystrom_position(step, 1, nystrom->b, stages, z, low);
    for (int i = 0; i < d; i++)
        step_add(&z[d + i], low ? &low[d + i] : NULL,
                 h * weighted_sum(nystrom->d, stages, k, d, i));

    if (step->error && nystrom->embedded_b)
        for (int i = 0; i < d; i++) {
            step->error[i] =
                h * h * weighted_difference(nystrom->b, nystrom->embedded_b, stages, k, d, i);
            step->error[d + i] =
                h * weighted_difference(nystrom->d, nystrom->embedded_d, stages, k, d, i);
        }
    enum step_status status = step_finish(step, z);
    if (low && status == STEP_OK)
        memcpy(step->low, low, (size_t)n * sizeof *low);
    return status;
}
