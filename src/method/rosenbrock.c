/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One step of any Rosenbrock method. Source: Hairer, Wanner 1996, Solving ODEs II, IV.7, eq. 7.25. */
#include "lu.h"
#include "step.h"

/* Distance of the two points of a difference quotient in t, as a share of h: its error stays far below the step's. */
static const double APART = 1. / 8192;

/* work: u [stages][n], the Jacobian, the matrix, then four states. A step that is tried again finds f, J and df/dt. */
size_t rosenbrock_work(const struct method *method, int n)
{
    return (size_t)(method->rosenbrock->stages + n + 4) * (size_t)n + LU_ROOM(n);
}

/* df/dt at (t, y) into `slope`; two states of scratch. Closed form for the driven oscillator, else by differences. */
static void time_derivative(struct step *step, double *slope, double *after)
{
    const struct system *system = step->system;
    const struct oscillator *o = &system->oscillator;
    int n = system->n;
    if (o->whole && system->order == 2 && n == 2) {
        slope[0] = 0;
        slope[1] = -o->drive * o->omega * sin(o->omega * step->t + o->phase);
        return;
    }
    double earlier = step->t - step->h * (APART / 2), later = step->t + step->h * (APART / 2);
    system_derivative(system, earlier, step->y, slope);
    system_derivative(system, later, step->y, after);
    step->cost.evals += 2;
    for (int i = 0; i < n; i++)
        slope[i] = later != earlier ? (after[i] - slope[i]) / (later - earlier) : 0;
}

#define INSTANCE static inline __attribute__((always_inline))
#define UNROLLED _Pragma("GCC unroll 4")

/* sum_j w_j u_j over the weights that are not zero, from the first to the last */
INSTANCE void combine(int n, const double *w, int count, const double *u, double *sum)
{
    UNROLLED for (int i = 0; i < n; i++) sum[i] = -0.0;
    for (int j = 0; j < count; j++, u += n)
        if (w[j] != 0)
            UNROLLED for (int i = 0; i < n; i++) sum[i] += w[j] * u[i];
}

/* Stage s is at the same point of time and space as the one before it (ros3p): f is known. row: its part of a. */
INSTANCE bool same_point(const struct rosenbrock *rosenbrock, const double *row, int s)
{
    return row[s - 1] == 0 && rosenbrock->alpha[s] == rosenbrock->alpha[s - 1] &&
           memcmp(row, row - (s - 1), (size_t)(s - 1) * sizeof *row) == 0;
}

/* Up to 3 unknowns the inverse is multiplied: shorter chains of operations than two substitutions. */
enum { INVERTED = 3 };

INSTANCE bool factor(int n, double *matrix, double *inverse)
{
    if (!lu_factor(n, matrix))
        return false;
    for (int j = 0; n <= INVERTED && j < n; j++) {
        for (int i = 0; i < n; i++)
            inverse[j * n + i] = i == j;
        lu_solve(n, matrix, inverse + j * n); /* column j */
    }
    return true;
}

/* sum = inverse x + start */
INSTANCE void multiply(int n, const double *inverse, const double *x, const double *start, double *sum)
{
    for (int i = 0; i < n; i++)
        sum[i] = start[i];
    for (int j = 0; j < n; j++)
        UNROLLED for (int i = 0; i < n; i++) sum[i] += inverse[j * n + i] * x[j];
}

/* Inlined for each small n, so that loops over the state vanish. */
INSTANCE enum step_status step_of(int n, const struct rosenbrock *rosenbrock, struct step *step)
{
    static const double nothing[INVERTED] = {-0.0, -0.0, -0.0};
    const struct system *system = step->system;
    const double h = step->h, *a = rosenbrock->a, *c = rosenbrock->c, *y = step->y;
    const int stages = rosenbrock->stages;
    double *u = step->work, *jacobian = u + stages * n, *matrix = jacobian + n * n, *first = matrix + LU_ROOM(n);
    double *slope = first + n, *z = slope + n, *f = first, *later = z + n;
    double inverse[INVERTED * INVERTED], sum[LIMIT_VARIABLES];

    bool timed = !system->autonomous;
    if (!step->again) {
        if (timed)
            time_derivative(step, slope, later);
        system_jacobian(system, step->t, y, jacobian);
        system_derivative(system, step->t, y, first);
        step->cost.jacobians++;
        step->cost.evals++;
    }
    double diagonal = 1 / (rosenbrock->gamma * h), rate = 1 / h;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            matrix[i * n + j] = (i == j ? diagonal : -0.0) - jacobian[i * n + j];
    if (!factor(n, matrix, inverse))
        return STEP_NO_SOLUTION;

    for (int s = 0; s < stages; a += s, c += s, s++) {
        if (s > 0 && !same_point(rosenbrock, a, s)) {
            f = later;
            combine(n, a, s, u, sum);
            for (int i = 0; i < n; i++)
                z[i] = y[i] + sum[i];
            system_derivative(system, step->t + rosenbrock->alpha[s] * h, z, f);
            step->cost.evals++;
        }
        combine(n, c, s, u, sum);
        for (int i = 0; i < n; i++)
            sum[i] *= rate;
        if (timed && rosenbrock->d[s] != 0)
            for (int i = 0; i < n; i++)
                sum[i] += rosenbrock->d[s] * h * slope[i];
        if (n <= INVERTED) { /* f last: what does not depend on it need not wait for it */
            multiply(n, inverse, sum, nothing, sum + n);
            multiply(n, inverse, f, sum + n, u + s * n);
        } else {
            for (int i = 0; i < n; i++)
                u[s * n + i] = f[i] + sum[i];
            lu_solve(n, matrix, u + s * n);
        }
        step->cost.solves++;
    }

    if (step->error && rosenbrock->companion) {
        for (int i = 0; i < n; i++)
            step->error[i] = -0.0;
        for (int s = 0; s < stages; s++)
            if (rosenbrock->m[s] != rosenbrock->companion[s])
                for (int i = 0; i < n; i++)
                    step->error[i] += (rosenbrock->m[s] - rosenbrock->companion[s]) * u[s * n + i];
    }
    combine(n, rosenbrock->m, stages, u, sum);
    return step_increase(step, sum);
}

enum step_status rosenbrock_step(const struct method *method, struct step *step)
{
    const struct rosenbrock *rosenbrock = method->rosenbrock;
    int n = step->system->n;
    return n == 2 ? step_of(2, rosenbrock, step) : n == 3 ? step_of(3, rosenbrock, step) : step_of(n, rosenbrock, step);
}

void rosenbrock_dense(const struct method *method, const struct step *step, double theta, double *y)
{
    const struct rosenbrock *rosenbrock = method->rosenbrock;
    const double *u = step->work;
    int n = step->system->n, stages = rosenbrock->stages;
    double sum[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        y[i] = 0;
    for (int m = rosenbrock->degree; m-- > 0;) {
        combine(n, rosenbrock->dense + m * stages, stages, u, sum);
        for (int i = 0; i < n; i++)
            y[i] = y[i] * theta + sum[i];
    }
    combine(n, rosenbrock->m, stages, u, sum);
    for (int i = 0; i < n; i++)
        y[i] = step->y[i] + (1 - theta) * (theta * y[i] - sum[i]);
}

/*
 * theta (1 - theta) (e_0 + e_1 theta + …), degree 4 at most, in the form of Hermite's: between the brackets
 * e_0 + theta (twist + (1 - theta) (d_0 + theta d_1)).
 */
void rosenbrock_polynomial(const struct method *method, const struct step *step, int i, struct dense_polynomial *out)
{
    const struct rosenbrock *rosenbrock = method->rosenbrock;
    const int n = step->system->n, stages = rosenbrock->stages;
    double e[ROSENBROCK_DEGREE] = {0};
    for (int m = 0; m < rosenbrock->degree; m++)
        e[m] = weighted_sum(rosenbrock->dense + m * stages, stages, step->work, n, i);
    const double last = -e[3], bend = last - e[2];
    *out = (struct dense_polynomial){.end = step->y[i],
                                     .h = 1,
                                     .rise = weighted_sum(rosenbrock->m, stages, step->work, n, i),
                                     .first = e[0],
                                     .twist = e[1] - bend,
                                     .bends = 2,
                                     .bend = {bend, last}};
}
