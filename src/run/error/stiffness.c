/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Stiffness of a scene along a run: the spectral radius of its Jacobian, from which opinion.c
 * chooses the method of the second solution. */
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <math.h>
#include <stdlib.h>

#define JACOBIANS_MAX 32    /* Number of Jacobians whose spectral radius is estimated. */
#define POWER_ITERATIONS 12 /* Number of multiplications by each Jacobian. */
/* Number of the last multiplications whose growth is averaged; an even number, so that eigenvalue
 * pairs +-lambda do not matter. */
#define POWER_ITERATIONS_COUNTED 6

size_t run_spread_row(const struct run *run, size_t first, size_t k, size_t count)
{
    const size_t rows = trace_count(run->trace) - first;
    return first + (size_t)((double)(k + 1) * (double)rows / (double)count) - 1;
}

/* Returns an estimate of the spectral radius of the Jacobian [n][n] [1/s], by the power method: its
 * geometric mean growth. */
static double spectral_radius(const double *jacobian, int n)
{
    double v[LIMIT_VARIABLES], w[LIMIT_VARIABLES], grown = 1;
    /* The vector at the start has parts along all eigenvectors, most likely. */
    for (int i = 0; i < n; i++)
        v[i] = 1 + 0.1 * i - 0.3 * (i % 3);
    for (int round = 0; round < POWER_ITERATIONS; round++) {
        double old_square = 0, new_square = 0;
        for (int i = 0; i < n; i++) {
            w[i] = 0;
            for (int j = 0; j < n; j++)
                w[i] += jacobian[i * n + j] * v[j];
            old_square += v[i] * v[i];
            new_square += w[i] * w[i];
        }
        if (new_square == 0)
            return 0;
        if (round >= POWER_ITERATIONS - POWER_ITERATIONS_COUNTED)
            grown *= new_square / old_square;
        for (int i = 0; i < n; i++)
            v[i] = w[i] / sqrt(new_square);
    }
    return fixed_exp(fixed_log(grown) / (2 * POWER_ITERATIONS_COUNTED));
}

/* Adds up spectral radii of Jacobians times the times between the rows at which they are taken. */
double run_stiffness(const struct run *run)
{
    const struct system *system = &run->system;
    static const double evals_a_look = 512, looks_min = 4; /* a small share of the run's work */
    const size_t rows = trace_count(run->trace) - 1,
                 max = (size_t)fmin(JACOBIANS_MAX,
                                    fmax(looks_min, (double)run->cost.evals / evals_a_look)),
                 count = rows < max ? rows : max;
    double *jacobian = malloc((size_t)system->n * (size_t)system->n * sizeof *jacobian), sum = 0;
    size_t row = 0;
    for (size_t k = 0; jacobian && k < count; k++) {
        const size_t next = run_spread_row(run, 1, k, count);
        system_jacobian(system, trace_time(run->trace, row), trace_state(run->trace, row),
                        jacobian);
        sum += spectral_radius(jacobian, system->n) *
               fabs(trace_time(run->trace, next) - trace_time(run->trace, row));
        row = next;
    }
    free(jacobian);
    return sum;
}
