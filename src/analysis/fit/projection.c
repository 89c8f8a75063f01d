/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Variable projection: the parameters in which a curve is linear are solved for exactly, so that
 * only the others are searched (Golub & Pereyra 2003; derivatives in Kaufman's form, BIT 15, 1975).
 */
#include "analysis/fit/projection.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <string.h>

#define PIVOT_MIN 1e-12 /* sine of the angle between a column and those before it */

bool projection_init(struct projection *v, const struct fit_curve *curve, const bool *linear,
                     const struct series *series, struct arena *arena)
{
    size_t n = series->n;
    *v = (struct projection){.curve = curve, .series = series};
    for (int j = 0; j < curve->parameters; j++) {
        if (linear[j])
            v->linear[v->linears++] = j;
        else
            v->other[v->others++] = j;
    }
    for (int k = 0; k < v->others; k++)
        v->name[k] = curve->name[v->other[k]];
    v->value = arena_array(arena, n, sizeof(double));
    v->derivative = arena_array(arena, n * (size_t)curve->parameters, sizeof(double));
    v->basis = arena_array(arena, n * (size_t)(v->linears + 1), sizeof(double));
    v->column = arena_array(arena, n, sizeof(double));
    return v->value && v->derivative && v->basis && v->column;
}

/* Takes out of the column what lies in the space of the basis. */
static void orthogonalise(const gsl_matrix *qr, const gsl_vector *tau, gsl_vector *column)
{
    gsl_linalg_QR_QTvec(qr, tau, column);
    for (size_t k = 0; k < tau->size; k++)
        gsl_vector_set(column, k, 0);
    gsl_linalg_QR_Qvec(qr, tau, column);
}

static double column_into(const struct projection *v, int j, gsl_vector *column)
{
    for (size_t i = 0; i < v->series->n; i++)
        gsl_vector_set(column, i, v->derivative[i * (size_t)v->curve->parameters + (size_t)j]);
    return gsl_blas_dnrm2(column);
}

bool project(struct projection *v, double *x, double *value, double *derivative, double *rss)
{
    const struct fit_curve *curve = v->curve;
    size_t n = v->series->n, m = (size_t)v->linears;
    const double *t = v->series->t, *y = v->series->y;
    double tau_of[CURVE_PARAMETERS], norm[CURVE_PARAMETERS];
    gsl_vector_view r = gsl_vector_view_array(v->column, n),
                    tau = gsl_vector_view_array(tau_of, m ? m : 1);
    gsl_matrix_view qr = gsl_matrix_view_array(v->basis, n, m ? m : 1);
    for (size_t k = 0; k < m; k++)
        x[v->linear[k]] = 0;
    if (n <= m || cancelled(v->series->cancel) ||
        !curve->evaluate(curve->context, x, t, n, v->value, v->derivative))
        return false;
    for (size_t k = 0; k < m; k++) {
        gsl_vector_view column = gsl_matrix_column(&qr.matrix, k);
        norm[k] = column_into(v, v->linear[k], &column.vector);
        if (!(norm[k] > 0) || !isfinite(norm[k]))
            return false;
        gsl_vector_scale(&column.vector, 1 / norm[k]);
    }
    for (size_t i = 0; i < n; i++)
        v->column[i] = y[i] - v->value[i];
    if (m > 0) {
        gsl_linalg_QR_decomp(&qr.matrix, &tau.vector);
        for (size_t k = 0; k < m; k++)
            if (!(fabs(gsl_matrix_get(&qr.matrix, k, k)) > PIVOT_MIN))
                return false;
        gsl_linalg_QR_QTvec(&qr.matrix, &tau.vector, &r.vector);
        for (size_t k = m; k-- > 0;) {
            double sum = v->column[k];
            for (size_t i = k + 1; i < m; i++)
                sum -= gsl_matrix_get(&qr.matrix, k, i) * x[v->linear[i]] * norm[i];
            x[v->linear[k]] = sum / gsl_matrix_get(&qr.matrix, k, k) / norm[k];
            v->column[k] = 0;
        }
        gsl_linalg_QR_Qvec(&qr.matrix, &tau.vector, &r.vector);
    }
    double length = gsl_blas_dnrm2(&r.vector);
    *rss = length * length;
    for (size_t i = 0; i < n && value; i++)
        value[i] = y[i] - v->column[i];
    if (!derivative)
        return isfinite(length);
    if (!curve->evaluate(curve->context, x, t, n, v->value, v->derivative))
        return false;
    for (int k = 0; k < v->others; k++) {
        if (cancelled(v->series->cancel))
            return false;
        column_into(v, v->other[k], &r.vector);
        if (m > 0)
            orthogonalise(&qr.matrix, &tau.vector, &r.vector);
        for (size_t i = 0; i < n; i++)
            derivative[i * (size_t)v->others + (size_t)k] = v->column[i];
    }
    return isfinite(length);
}

bool projection_evaluate(void *context, const double *parameter, const double *t, size_t n,
                         double *value, double *derivative)
{
    struct projection *v = context;
    double x[CURVE_PARAMETERS], rss;
    (void)t;
    if (n != v->series->n) /* there is room for that series only */
        return false;
    for (int k = 0; k < v->others; k++)
        x[v->other[k]] = parameter[k];
    return project(v, x, value, derivative, &rss);
}
