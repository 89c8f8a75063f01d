/* SPDX-License-Identifier: GPL-3.0-or-later */
/* f(x, p) = 0 as a curve. */
#include "modules/dynamics/orbits/problem.h"

#include <math.h>
#include <string.h>

double plain_determinant(int n, double *a)
{
    int exponent;
    const double mantissa = matrix_determinant(n, a, &exponent);
    return ldexp(mantissa, exponent < -1000 ? -1000 : exponent > 1000 ? 1000 : exponent);
}

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

static void test(void *context, const double *u, const double *jacobian, const double *tangent,
                 double *value)
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
    value[EQUILIBRIUM_CROSSING] = plain_determinant(n + 1, bordered);
    if (n > 1) {
        matrix_pair_sums(n, square, sums);
        value[EQUILIBRIUM_HOPF] = plain_determinant(pairs, sums);
    }
}

void equilibrium_curve_init(struct equilibrium_curve *curve, struct vector_field *field,
                            double psize)
{
    *curve = (struct equilibrium_curve){.field = field, .psize = psize};
    curve->problem = (struct curve_problem){.context = curve,
                                            .n = field->n,
                                            .residual = residual,
                                            .test = test,
                                            .tests = field->n > 1 ? 3 : 2,
                                            .singular = 1u << EQUILIBRIUM_CROSSING};
}
