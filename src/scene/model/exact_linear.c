/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The exact solution of y' = A y + b: exp(X) of X = [A b; 0 0] t on the state with a 1 below it, by
 * scaling and squaring (Higham, Functions of Matrices, 2008, 10.3). What is squared is E =
 * exp(X/2^s) - 1, E <- 2 E + E E: so slow motion keeps its digits beside a fast one that is over
 * soon, where exp(X/2^s) would round it away s times. The series of E is that of Taylor, with X/2^s
 * small enough for ten terms; balancing (Parlett, Reinsch 1969, Numer. Math. 13:293) makes X small
 * where units are far apart.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/model/exact.h"

/* largest number of variables: a larger matrix product is slow for each row of a run */
#define LINEAR_MAX 16
#define MATRIX_SIDE_MAX (LINEAR_MAX + 1)
#define EXPM_TERMS 10
#define EXPM_NORM_MAX (1. / 16) /* (1/16)^10/11! is below the rounding of long double. */

typedef long double real;

/* A matrix [n][n]. */
struct matrix {
    int n;
    real entry[MATRIX_SIDE_MAX][MATRIX_SIDE_MAX];
};

/* Sets x to [A b; 0 0], the coefficients of the system; NAN if out of memory. */
static void coefficients(const struct system *system, struct matrix *x)
{
    const int n = system->n;
    double b[LIMIT_VARIABLES], rest[LIMIT_VARIABLES] = {0};
    double *jac = system_new_jacobian(system, system->t0, rest);
    system_derivative(system, system->t0, rest, b);
    x->n = n + 1;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            x->entry[i][j] = jac ? (real)jac[i * n + j] : (real)NAN;
        x->entry[i][n] = (real)b[i];
    }
    for (int j = 0; j <= n; j++)
        x->entry[n][j] = 0;
    free(jac);
}

/* Returns true if the system is linear, does not depend on time, is small, and has finite
 * coefficients. */
bool linear_has_exact(const struct system *system)
{
    struct matrix x;
    bool fine = system->linear && system->autonomous && system->n <= LINEAR_MAX;
    if (fine)
        coefficients(system, &x);
    for (int i = 0; fine && i < x.n; i++)
        for (int j = 0; fine && j < x.n; j++)
            fine = isfinite(x.entry[i][j]);
    return fine;
}

/* Replaces x by D^-1 X D, whose rows and columns are about the same size. d returns the diagonal of
 * D, which has powers of two. */
static void balance(struct matrix *x, real *d)
{
    const int n = x->n - 1;
    bool changed = true;
    for (int i = 0; i <= n; i++)
        d[i] = 1;
    for (int sweep = 0; changed && sweep < 100; sweep++) {
        changed = false;
        for (int i = 0; i < n; i++) {
            real row = 0, column = 0;
            for (int j = 0; j < n; j++) {
                row += j != i ? fabsl(x->entry[i][j]) : 0;
                column += j != i ? fabsl(x->entry[j][i]) : 0;
            }
            const int power = row > 0 && column > 0 ? (ilogbl(row) - ilogbl(column)) / 2 : 0;
            changed = changed || power != 0;
            d[i] = scalbnl(d[i], power);
            for (int j = 0; power != 0 && j <= n; j++) {
                x->entry[i][j] = scalbnl(x->entry[i][j], -power);
                x->entry[j][i] = scalbnl(x->entry[j][i], power);
            }
        }
    }
    /* Nothing depends on the size of the last coordinate, which is always 1, so any will do. */
    real max = 0, shift = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            max = fmaxl(max, fabsl(x->entry[i][j]));
        shift = fmaxl(shift, fabsl(x->entry[i][n]));
    }
    const int power = max > 0 && shift > 0 ? ilogbl(max) - ilogbl(shift) : 0;
    d[n] = scalbnl(1, power);
    for (int i = 0; i < n; i++)
        x->entry[i][n] = scalbnl(x->entry[i][n], power);
}

/* Returns the maximum norm of the matrix: the largest sum of magnitudes in a row. */
static real linear_matrix_norm(const struct matrix *x)
{
    real max = 0;
    for (int i = 0; i < x->n; i++) {
        real sum = 0;
        for (int j = 0; j < x->n; j++)
            sum += fabsl(x->entry[i][j]);
        max = fmaxl(max, sum);
    }
    return max;
}

/* Sets c = part (fraction a + b e). Entries are limited to a size whose square does not overflow,
 * so that growth ends as a large number, not as NaN. */
static void multiply_add(real part, real fraction, const struct matrix *a, const struct matrix *b,
                         const struct matrix *e, struct matrix *c)
{
    const real max = scalbnl(1, LDBL_MAX_EXP / 2 - 8);
    const int n = c->n = a->n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            real sum = fraction * a->entry[i][j];
            for (int k = 0; k < n; k++)
                sum += b->entry[i][k] * e->entry[k][j];
            c->entry[i][j] = fabsl(sum) <= max ? part * sum : copysignl(max, sum);
        }
}

/* Sets *made to exp(x t) - 1 and, unless NULL, *integral to the integral of exp(x t) over t, to a
 * few per cent. */
static void exponential(const struct matrix *x, real t, struct matrix *made,
                        struct matrix *integral)
{
    struct matrix e[2], scaled = {.n = x->n}, previous;
    const real size = linear_matrix_norm(x) * fabsl(t) / (real)EXPM_NORM_MAX;
    const int halvings = size > 1 ? ilogbl(size) + 1 : 0;
    int now = 0;
    for (int i = 0; i < x->n; i++)
        for (int j = 0; j < x->n; j++) {
            scaled.entry[i][j] = scalbnl(x->entry[i][j] * t, -halvings);
            e[now].entry[i][j] = scaled.entry[i][j] / EXPM_TERMS;
        }
    for (int k = EXPM_TERMS - 1; k > 0; k--, now = !now) /* x (1 + x/2 (1 + x/3 (1 + ...))) */
        multiply_add(1 / (real)k, 1, &scaled, &scaled, &e[now], &e[!now]);
    if (integral)
        integral->n = x->n;
    for (int i = 0; integral && i < x->n; i++)
        for (int j = 0; j < x->n; j++)
            integral->entry[i][j] = scalbnl(t * ((i == j) + e[now].entry[i][j] / 2), -halvings);
    for (int k = 0; k < halvings; k++, now = !now) {
        if (integral) {
            previous = *integral;
            multiply_add(1, 2, &previous, &e[now], &previous, integral);
        }
        multiply_add(1, 2, &e[now], &e[now], &e[now], &e[!now]);
    }
    *made = e[now];
}

/* Sets mask[i] to the variables on which variable i depends, directly or through others, as
 * bits. */
static void dependence(const struct matrix *x, unsigned *mask)
{
    const int n = x->n - 1;
    for (int i = 0; i < n; i++) {
        mask[i] = 1u << i;
        for (int j = 0; j < n; j++)
            mask[i] |= (unsigned)(x->entry[i][j] != 0) << j;
    }
    for (int k = 0; k < n; k++) /* Warshall 1962 */
        for (int i = 0; i < n; i++)
            mask[i] |= mask[i] >> k & 1 ? mask[k] : 0;
}

/* Sets floor [n], an estimate of how much the exact state y changes if time or coefficients change
 * by one ulp, below which differences mean nothing. An ulp of the time moves the state by eps |t|
 * y'; as a rate passes through 0 where another one of the same motion is largest, the largest rate
 * that the variable depends on is used, in units of natural sizes. An ulp of a coefficient moves
 * the rate by eps |A| |y|, and the state by the integral of exp(A t) times that; where motion
 * grows, |t| bounds that factor. A decayed variable is the difference of 1 and -E (d scales the
 * variables), in which rounding of long double remains. */
static void find_floor(const struct system *system, const struct matrix *x, const real *d,
                       const struct matrix *integral, const double *start, real t, const real *y,
                       double *floor)
{
    const int n = system->n;
    unsigned mask[LINEAR_MAX];
    real rate[LINEAR_MAX], parts[LINEAR_MAX];
    dependence(x, mask);
    for (int i = 0; i < n; i++) {
        rate[i] = x->entry[i][n];
        parts[i] = fabsl(rate[i]);
        for (int j = 0; j < n; j++) {
            rate[i] += x->entry[i][j] * y[j];
            parts[i] += fabsl(x->entry[i][j] * y[j]);
        }
        rate[i] = fabsl(rate[i]) / (real)system->scale[i];
    }
    for (int i = 0; i < n; i++) {
        real max = 0, moved = 0, begun = 0;
        for (int j = 0; j < n; j++) {
            max = mask[i] >> j & 1 ? fmaxl(max, rate[j]) : max;
            begun = mask[i] >> j & 1 ? fmaxl(begun, d[i] * fabsl((real)start[j]) / d[j]) : begun;
            moved += d[i] * fminl(fabsl(integral->entry[i][j]), fabsl(t)) / d[j] * parts[j];
        }
        floor[i] = (double)((real)DBL_EPSILON *
                                (fabsl(y[i]) + fabsl(t) * max * (real)system->scale[i] + moved) +
                            16 * LDBL_EPSILON * begun);
    }
}

/* Sets z [n + 1] to the state, with the 1 below it, in units of d. */
static void scaled_start(int n, const double *start, const real *d, real *z)
{
    for (int i = 0; i < n; i++)
        z[i] = (real)start[i] / d[i];
    z[n] = 1 / d[n];
}

/* Advances z by one step, whose matrix is e + 1. */
static void linear_advance(const struct matrix *e, real *z)
{
    real increment[MATRIX_SIDE_MAX] = {0};
    for (int i = 0; i < e->n; i++)
        for (int j = 0; j < e->n; j++)
            increment[i] += e->entry[i][j] * z[j];
    for (int i = 0; i < e->n; i++)
        z[i] += increment[i];
}

/* Multiplies the start by the matrix exponential. */
void linear_exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor)
{
    const int n = system->n;
    const real elapsed = (real)t - (real)t0;
    struct matrix x, balanced, e, integral;
    real d[MATRIX_SIDE_MAX], z[MATRIX_SIDE_MAX];
    coefficients(system, &x);
    balanced = x;
    balance(&balanced, d);
    exponential(&balanced, elapsed, &e, floor ? &integral : NULL);
    scaled_start(n, start, d, z);
    linear_advance(&e, z);
    for (int i = 0; i < n; i++) {
        z[i] *= d[i];
        y[i] = (double)z[i];
    }
    if (floor)
        find_floor(system, &x, d, &integral, start, elapsed, z, floor);
}

/* Follows the exact solution in steps that double from stage to stage, and notes the largest
 * values. */
void linear_sizes(const struct system *system, double rate, double *max)
{
    enum { STAGES = 6, STEPS = 16 }; /* each stage takes twice the time of the one before */
    const int n = system->n;
    struct matrix x, e, previous;
    real d[MATRIX_SIDE_MAX], z[MATRIX_SIDE_MAX],
        constant = 0;              /* largest scaled magnitude within one time constant */
    double early[LIMIT_VARIABLES]; /* sizes within that */
    coefficients(system, &x);
    balance(&x, d);
    scaled_start(n, system->start, d, z);
    exponential(&x, (real)(rate > 0 ? 8 / rate : 1) / STEPS, &e, NULL);
    real first = 0;
    for (int stage = 0; stage < STAGES; stage++) {
        real last = 0;
        for (int step = 0; step < STEPS; step++) {
            linear_advance(&e, z);
            for (int i = 0; i < n; i++)
                last = fmaxl(last, fabsl(z[i]));
            for (int i = 0; i < n && (stage == 0 || last <= 4 * first);
                 i++) /* later stages count unless the motion has only grown */
                max[i] = fmax(max[i], fabs((double)(d[i] * z[i])));
            if (stage == 0 && step == STEPS / 8 - 1) {
                constant = last;
                memcpy(early, max, (size_t)n * sizeof *early);
            } else if (stage == 0 && constant > 0 &&
                       last >
                           TRANSIENT_GROWTH_MAX * constant) { /* a run may be too short for this */
                memcpy(max, early, (size_t)n * sizeof *early);
                return;
            }
        }
        first = stage == 0 ? last : first;
        previous = e;
        multiply_add(1, 2, &previous, &previous, &previous, &e);
    }
}
