/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any explicit Runge-Kutta tableau. Source: Hairer, Norsett, Wanner 1993, Solving ODEs I, II.1, II.4, II.6.
 */
#include "step.h"

/* work: k [stages][n], then one state */
size_t rk_work(const struct method *method, int n)
{
    return (size_t)(method->tableau->stages + 1) * (size_t)n;
}

static void derivative(struct step *step, double t, const double *y, double *k)
{
    system_derivative(step->system, t, y, k);
    step->cost.evals++;
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

enum step_status rk_step(const struct method *method, struct step *step)
{
    const struct tableau *tableau = method->tableau;
    int n = step->system->n, stages = tableau->stages;
    double h = step->h, *y = step->y, *k = step->work, *z = k + stages * n;

    if (tableau->fsal && step->warm)
        memcpy(k, k + (stages - 1) * n, (size_t)n * sizeof *k);
    else
        derivative(step, step->t, y, k);
    for (int s = 1; s < stages; s++) {
        for (int i = 0; i < n; i++)
            z[i] = y[i] + h * weighted(tableau_row(tableau, s), s, k, n, i);
        derivative(step, step->t + tableau->c[s] * h, z, k + s * n);
    }
    if (!tableau->fsal) /* else z is already there: the last row of a equals b */
        for (int i = 0; i < n; i++)
            z[i] = y[i] + h * weighted(tableau->b, stages, k, n, i);

    if (step->error && tableau->companion)
        for (int i = 0; i < n; i++) {
            double sum = -0.0;
            for (int s = 0; s < stages; s++)
                if (tableau->b[s] != tableau->companion[s])
                    sum += (tableau->b[s] - tableau->companion[s]) * k[s * n + i];
            step->error[i] = h * sum;
        }
    return step_finish(step, z);
}

void rk_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    const struct tableau *tableau = method->tableau;
    int n = step->system->n, stages = tableau->stages, degree = tableau->degree;
    const double *k = step->work;
    double h = step->h;

    /* From the end of the step: y(theta) = y' + h sum_s (b_s(theta) - b_s) k_s. */
    for (int i = 0; i < n; i++)
        y[i] = 0;
    for (int s = 0; s < stages; s++) {
        const double *d = tableau->dense + s * degree;
        double b = 0;
        for (int m = degree; m-- > 0;)
            b = (b + d[m]) * theta;
        for (int i = 0; i < n; i++)
            y[i] += (b - tableau->b[s]) * k[s * n + i];
    }
    for (int i = 0; i < n; i++)
        y[i] = step->y[i] + h * y[i];
}

/* Hairer, Wanner 1996, Solving ODEs II, IV.2: |f(g) - f(g*)| / |g - g*| for two stage values g, g* at t + h. */
double rk_stiffness(const struct method *method, const struct step *step)
{
    const struct tableau *tableau = method->tableau;
    if (!tableau || tableau->stages < 3 || tableau->c[tableau->stages - 1] != 1 || tableau->c[tableau->stages - 2] != 1)
        return 0;
    int n = step->system->n, s = tableau->stages - 1;
    const double *k = step->work, *scale = step->system->scale;
    const double *upper = tableau_row(tableau, s - 1), *lower = tableau_row(tableau, s);
    double slopes = 0, values = 0;
    for (int i = 0; i < n; i++) {
        double df = (k[s * n + i] - k[(s - 1) * n + i]) / scale[i];
        double dg = (weighted(lower, s, k, n, i) - weighted(upper, s - 1, k, n, i)) / scale[i]; /* (g - g*)/h */
        slopes += df * df;
        values += dg * dg;
    }
    return values > 0 ? sqrt(slopes / values) : 0;
}
