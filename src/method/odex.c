/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Extrapolation of the midpoint rule (Gragg 1965; Bulirsch, Stoer 1966; Hairer, Norsett, Wanner 1993, Solving ODEs I,
 * II.9): COLUMNS runs over the step, in 2, 4, 6, … parts, extrapolated to parts of no length in powers of their square.
 */
#include "step.h"

enum { COLUMNS = 6 };

/* work: the extrapolated increments [COLUMNS][n], then four states */
size_t odex_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)(COLUMNS + 4) * (size_t)n;
}

/*
 * y(t + h) - y after `parts` steps of the midpoint rule, the first one Euler's. Sums of increments, not of states:
 * their rounding shrinks with h.
 */
static void midpoint_run(struct step *step, int parts, const double *first, double *work, double *gained)
{
    int n = step->system->n;
    double part = step->h / parts, *before = work, *f = before + n, *z = f + n;
    for (int i = 0; i < n; i++) {
        before[i] = 0;
        gained[i] = part * first[i];
    }
    for (int m = 1; m < parts; m++) {
        for (int i = 0; i < n; i++)
            z[i] = step->y[i] + gained[i];
        system_derivative(step->system, step->t + m * part, z, f);
        step->cost.evals++;
        for (int i = 0; i < n; i++) {
            double next = before[i] + 2 * part * f[i];
            before[i] = gained[i];
            gained[i] = next;
        }
    }
}

/* T_jl = T_j,l-1 + (T_j,l-1 - T_j-1,l-1) / ((parts_j / parts_j-l)^2 - 1); table[j - l] holds T_jl (Aitken, Neville). */
enum step_status odex_step(const struct method *method, struct step *step)
{
    (void)method;
    int n = step->system->n;
    double *table = step->work, *first = table + COLUMNS * n, *own = first + n;
    if (!step->again) {
        system_derivative(step->system, step->t, step->y, first);
        step->cost.evals++;
    }
    for (int j = 0; j < COLUMNS; j++) {
        midpoint_run(step, 2 * (j + 1), first, own, table + j * n);
        for (int l = j; l-- > 0;) {
            double ratio = (double)(j + 1) / (l + 1), below = ratio * ratio - 1;
            for (int i = l * n; i < (l + 1) * n; i++)
                table[i] = table[i + n] + (table[i + n] - table[i]) / below;
        }
    }
    for (int i = 0; step->error && i < n; i++)
        step->error[i] = table[i] - table[n + i];
    return step_increase(step, table);
}
