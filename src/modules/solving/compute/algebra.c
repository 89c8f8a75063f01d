/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear algebra of small matrices, by the LU factors of implicit methods and by GSL. */
#include "modules/solving/compute/algebra.h"

#include "method/step/lu_body.h"

#include <assert.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <string.h>

static bool all_finite(int n, const double *x)
{
    bool finite = true;
    for (int i = 0; i < n; i++)
        finite = finite && isfinite(x[i]);
    return finite;
}

double vector_length(int n, const double *x)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += x[i] * x[i];
    return sqrt(sum);
}

/* Divides x [n] by its length. Returns false if that is 0 or infinite. */
bool vector_normalise(int n, double *x)
{
    const double length = vector_length(n, x);
    for (int i = 0; i < n; i++)
        x[i] /= length;
    return length > 0 && isfinite(length);
}

/* Solves a x = b for a [n][n]: a is overwritten, b becomes x. Returns false if a is singular. */
bool matrix_solve(int n, double *a, double *b)
{
    double pivot[MATRIX_MAX];
    assert(n <= MATRIX_MAX);
    if (!lu_factor_size(n, a, pivot))
        return false;
    lu_solve_size(n, a, pivot, b);
    return all_finite(n, b);
}

/* Returns the determinant of a [n][n], which is overwritten, or NAN if an element is not finite.
 * The exponent is summed apart and limited, so that no partial product overflows. */
double matrix_determinant(int n, double *a)
{
    enum { EXPONENT_MAX = 1000 };
    double pivot[MATRIX_MAX], product = 1;
    int exponent = 0, more;
    assert(n <= MATRIX_MAX);
    if (!all_finite(n * n, a))
        return NAN;
    if (!lu_factor_size(n, a, pivot))
        return 0;
    for (int p = 0; p < n; p++) {
        product =
            frexp((int)pivot[p] == p ? product / a[p * n + p] : -product / a[p * n + p], &more);
        exponent += more;
    }
    int bounded;
    if (exponent < -EXPONENT_MAX)
        bounded = -EXPONENT_MAX;
    else
        bounded = exponent > EXPONENT_MAX ? EXPONENT_MAX : exponent;
    return ldexp(product, bounded);
}

/* Computes the eigenvalues and, unless `vector` is NULL, the eigenvectors as its columns. Returns
 * false if an element is not finite, if out of memory, or without convergence. */
static bool decompose(int n, const double *matrix, gsl_vector_complex *value,
                      gsl_matrix_complex *vector)
{
    const size_t size = (size_t)n;
    gsl_matrix *copy = gsl_matrix_alloc(size, size);
    gsl_eigen_nonsymmv_workspace *work = gsl_eigen_nonsymmv_alloc(size);
    bool ok = copy && work && value && all_finite(n * n, matrix);
    if (ok) {
        memcpy(copy->data, matrix, size * size * sizeof *matrix);
        /* balances the matrix, since rates differ by many powers of ten */
        gsl_eigen_nonsymmv_params(1, work);
        if (!vector)
            gsl_eigen_nonsymm_params(0, 1, work->nonsymm_workspace_p);
        ok = (vector ? gsl_eigen_nonsymmv(copy, value, vector, work)
                     : gsl_eigen_nonsymm(copy, value, work->nonsymm_workspace_p)) == GSL_SUCCESS;
    }
    if (work)
        gsl_eigen_nonsymmv_free(work);
    if (copy)
        gsl_matrix_free(copy);
    return ok;
}

/* Computes the [n] eigenvalues of a matrix. */
bool matrix_eigenvalues(int n, const double *matrix, struct eigenvalue *value)
{
    gsl_vector_complex *found = gsl_vector_complex_alloc((size_t)n);
    const bool ok = decompose(n, matrix, found, NULL);
    for (int i = 0; ok && i < n; i++) {
        const gsl_complex z = gsl_vector_complex_get(found, (size_t)i);
        value[i] = (struct eigenvalue){GSL_REAL(z), GSL_IMAG(z)};
    }
    if (found)
        gsl_vector_complex_free(found);
    return ok;
}

/* Finds the eigenvector re + i im [n], of length 1, of the eigenvalue nearest to `estimate`.
 * Returns false if out of memory or without convergence. */
bool matrix_eigenvector(int n, const double *matrix, struct eigenvalue estimate, double *re,
                        double *im)
{
    gsl_vector_complex *value = gsl_vector_complex_alloc((size_t)n);
    gsl_matrix_complex *vector = gsl_matrix_complex_alloc((size_t)n, (size_t)n);
    const bool ok = vector && decompose(n, matrix, value, vector);
    size_t nearest = 0;
    double least = HUGE_VAL;
    for (size_t k = 0; ok && k < (size_t)n; k++) {
        const gsl_complex z = gsl_vector_complex_get(value, k);
        const double apart = hypot(GSL_REAL(z) - estimate.re, GSL_IMAG(z) - estimate.im);
        if (apart < least) {
            least = apart;
            nearest = k;
        }
    }
    for (int i = 0; ok && i < n; i++) {
        const gsl_complex z = gsl_matrix_complex_get(vector, (size_t)i, nearest);
        re[i] = GSL_REAL(z);
        im[i] = GSL_IMAG(z);
    }
    if (value)
        gsl_vector_complex_free(value);
    if (vector)
        gsl_matrix_complex_free(vector);
    return ok;
}

/* Computes in vector [n], of length 1, the direction orthogonal to `known` in the plane that a [n -
 * 1][n] maps nearly to 0, which the right singular vectors of the two smallest singular values
 * span. Returns false if out of memory or if it cannot be computed. */
bool matrix_second_null(int n, const double *a, const double *known, double *vector)
{
    const size_t size = (size_t)n;
    gsl_matrix *left = gsl_matrix_calloc(size, size), *right = gsl_matrix_alloc(size, size);
    gsl_vector *singular = gsl_vector_alloc(size);
    bool ok = left && right && singular && all_finite((n - 1) * n, a);
    if (ok) {
        memcpy(left->data, a, size * (size - 1) * sizeof *a);
        ok = gsl_linalg_SV_decomp_jacobi(left, right, singular) == GSL_SUCCESS;
    }
    double projection[2] = {0}, length = 0;
    for (size_t i = 0; ok && i < size; i++)
        for (size_t k = 0; k < 2; k++)
            projection[k] += known[i] * gsl_matrix_get(right, i, size - 1 - k);
    for (size_t i = 0; ok && i < size; i++) {
        vector[i] = projection[1] * gsl_matrix_get(right, i, size - 1) -
                    projection[0] * gsl_matrix_get(right, i, size - 2);
        length = hypot(length, vector[i]);
    }
    for (size_t i = 0; ok && i < size; i++)
        vector[i] /= length;
    if (left)
        gsl_matrix_free(left);
    if (right)
        gsl_matrix_free(right);
    if (singular)
        gsl_vector_free(singular);
    return ok && length > 0;
}
