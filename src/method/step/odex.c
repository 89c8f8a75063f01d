/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Extrapolation of the midpoint rule (Gragg 1965; Bulirsch, Stoer 1966; Hairer, Norsett, Wanner
 * 1993, Solving ODEs I, II.9): COLUMNS integrations over the step, in 2, 4, 6, … parts, are
 * extrapolated to parts of length 0 in powers of the square of the length.
 *
 * The integrations do not evaluate the force in the last twelfth of the step. If it jumps there,
 * all of them are wrong in the same way and their differences are 0. So each also evaluates the
 * force at the end (Gragg's smoothing, which has an expansion in the same powers), and the
 * difference that makes counts as an error. Wherever a force jumps, this estimate is at least a
 * fifth of the error.
 */
#include "method/step/step.h"

/* Number of integrations with the midpoint rule, and of columns of the extrapolation. */
enum { COLUMNS = 6 };

/* The work array holds the extrapolated increments [COLUMNS][n], the same smoothed, then four
 * states. */
size_t odex_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)(2 * COLUMNS + 4) * (size_t)n;
}

/*
 * Integrates over the step in `parts` steps of the midpoint rule, the first by Euler's; first is
 * the slope at the start. Sets gained to y(t + h) - y and, if an error is to be estimated, smoothed
 * to (y_n-1 + y_n+1)/2 - y. Sums are formed of increments, whose rounding shrinks with h.
 */
static void midpoint_run(struct step *step, int parts, const double *first, double *work,
                         double *gained, double *smoothed)
{
    int n = step->system->n;
    double part = step->h / parts, *previous = work, *f = previous + n, *z = f + n;
    for (int i = 0; i < n; i++) {
        previous[i] = 0;
        gained[i] = part * first[i];
    }
    for (int m = 1; m < parts; m++) {
        for (int i = 0; i < n; i++)
            z[i] = step->y[i] + gained[i];
        system_derivative(step->system, step->t + m * part, z, f);
        step->cost.evals++;
        for (int i = 0; i < n; i++) {
            double next = previous[i] + 2 * part * f[i];
            previous[i] = gained[i];
            gained[i] = next;
        }
    }
    if (!step->error)
        return;
    for (int i = 0; i < n; i++)
        z[i] = step->y[i] + gained[i];
    system_derivative(step->system, step->t + step->h, z, f);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        smoothed[i] = previous[i] + part * f[i];
}

/* Computes row j of the table in place: T_jl = T_j,l-1 + (T_j,l-1 - T_j-1,l-1) / ((parts_j /
 * parts_j-l)^2 - 1); table[j - l] holds T_jl. */
static void extrapolate(int j, int n, double *table)
{
    for (int l = j; l-- > 0;) {
        double ratio = (double)(j + 1) / (l + 1), denominator = ratio * ratio - 1;
        for (int i = l * n; i < (l + 1) * n; i++)
            table[i] = table[i + n] + (table[i + n] - table[i]) / denominator;
    }
}

/* Takes a step and estimates its error by the order or by the smoothed values, whichever is
 * larger. */
enum step_status odex_step(const struct method *method, struct step *step)
{
    (void)method;
    int n = step->system->n;
    double *table = step->work, *smooth = table + COLUMNS * n, *first = smooth + COLUMNS * n,
           *own = first + n;
    if (!step->again) {
        system_derivative(step->system, step->t, step->y, first);
        step->cost.evals++;
    }
    for (int j = 0; j < COLUMNS; j++) {
        midpoint_run(step, 2 * (j + 1), first, own, table + j * n, smooth + j * n);
        extrapolate(j, n, table);
        if (step->error)
            extrapolate(j, n, smooth);
    }
    for (int i = 0; step->error && i < n; i++) {
        const double by_order = table[i] - table[n + i], by_end = table[i] - smooth[i];
        step->error[i] = fabs(by_end) > fabs(by_order) ? by_end : by_order;
    }
    return step_increase(step, table);
}
