/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The curve problem of equilibria, f(y, p) = 0, and its tests for folds, branch points and Hopf
 * points. */
#include "modules/dynamics/orbits/problem.h"

#include <math.h>
#include <string.h>

/* Returns the entry in row i and column j of a [n][n]. */
static double entry(int n, const double *a, int i, int j)
{
    return a[i * n + j];
}

/* Returns the entry of the matrix of pair sums in the row of p > q and the column of r > s. */
static double pair_sum(int n, const double *a, int p, int q, int r, int s)
{
    if (r == q)
        return -entry(n, a, p, s);
    if (r == p)
        return s == q ? entry(n, a, p, p) + entry(n, a, q, q) : entry(n, a, q, s);
    if (s == q)
        return entry(n, a, p, r);
    return s == p ? -entry(n, a, q, r) : 0;
}

void matrix_pair_sums(int n, const double *jacobian, double *pairs)
{
    for (int p = 1; p < n; p++)
        for (int q = 0; q < p; q++)
            for (int r = 1; r < n; r++)
                for (int s = 0; s < r; s++)
                    *pairs++ = pair_sum(n, jacobian, p, q, r, s);
}

/* Computes f and its derivatives by y and p, in units of sizes. Returns false if the scene cannot
 * have p or if cancelled. */
static bool residual(void *context, const double *u, double *f, double *jacobian)
{
    const struct equilibrium_curve *curve = context;
    struct vector_field *field = curve->field;
    const int n = field->n;
    double y[FIELD_VARIABLES], j[FIELD_VARIABLES * FIELD_VARIABLES], slope[FIELD_VARIABLES];
    double p = u[n] * curve->psize;
    for (int i = 0; i < n; i++)
        y[i] = u[i] * field->size[i];
    if (cancelled(field->cancel) || !field_set(field, &p))
        return false;
    field_rate(field, y, f);
    field_jacobian(field, y, j);
    if (!field_by_parameter(field, 0, y, slope))
        return false;
    for (int i = 0; i < n; i++) {
        f[i] /= field->size[i];
        for (int k = 0; k < n; k++)
            jacobian[i * (n + 1) + k] = j[i * n + k] * field->size[k] / field->size[i];
        jacobian[i * (n + 1) + n] = slope[i] * curve->psize / field->size[i];
    }
    return true;
}

/* Computes the tests: the parameter's part of the tangent (fold), the determinant of the bordered
 * Jacobian (branch point), and that of the pair sums (Hopf point). */
static void equilibrium_curve_test(void *context, const double *u, const double *jacobian,
                                   const double *tangent, double *value)
{
    const struct equilibrium_curve *curve = context;
    const int n = curve->field->n, pairs = n * (n - 1) / 2;
    double square[FIELD_VARIABLES * FIELD_VARIABLES], sums[21 * 21],
        bordered[(FIELD_VARIABLES + 1) * (FIELD_VARIABLES + 1)];
    (void)u;
    for (int i = 0; i < n; i++)
        memcpy(square + i * n, jacobian + i * (n + 1), (size_t)n * sizeof *square);
    memcpy(bordered, jacobian, (size_t)(n * (n + 1)) * sizeof *bordered);
    memcpy(bordered + n * (n + 1), tangent, (size_t)(n + 1) * sizeof *bordered);
    value[EQUILIBRIUM_FOLD] = tangent[n];
    value[EQUILIBRIUM_CROSSING] = matrix_determinant(n + 1, bordered);
    if (n > 1) {
        matrix_pair_sums(n, square, sums);
        value[EQUILIBRIUM_HOPF] = matrix_determinant(pairs, sums);
    }
}

/* Scenes of one variable have no Hopf points, hence no third test. */
void equilibrium_curve_init(struct equilibrium_curve *curve, struct vector_field *field,
                            double psize)
{
    *curve = (struct equilibrium_curve){.field = field, .psize = psize};
    curve->problem = (struct curve_problem){.context = curve,
                                            .n = field->n,
                                            .residual = residual,
                                            .test = equilibrium_curve_test,
                                            .tests = field->n > 1 ? 3 : 2,
                                            .singular = 1u << EQUILIBRIUM_CROSSING};
}
