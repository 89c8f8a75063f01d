/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Eigenvalues of a small real matrix. */
#include <hooke/study/verify.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

bool matrix_eigenvalues(int n, const double *matrix, struct eigenvalue *value)
{
    const size_t size = (size_t)n;
    gsl_matrix *copy = gsl_matrix_alloc(size, size);
    gsl_vector_complex *found = gsl_vector_complex_alloc(size);
    gsl_eigen_nonsymm_workspace *work = gsl_eigen_nonsymm_alloc(size);
    bool ok = copy && found && work;
    for (int i = 0; ok && i < n * n; i++) {
        ok = isfinite(matrix[i]);
        copy->data[(size_t)(i / n) * copy->tda + (size_t)(i % n)] = matrix[i];
    }
    if (ok) {
        gsl_eigen_nonsymm_params(0, 1, work); /* balanced: rates differ by many powers of ten */
        ok = gsl_eigen_nonsymm(copy, found, work) == GSL_SUCCESS;
    }
    for (int i = 0; ok && i < n; i++) {
        const gsl_complex z = gsl_vector_complex_get(found, (size_t)i);
        value[i] = (struct eigenvalue){GSL_REAL(z), GSL_IMAG(z)};
    }
    if (work)
        gsl_eigen_nonsymm_free(work);
    if (found)
        gsl_vector_complex_free(found);
    if (copy)
        gsl_matrix_free(copy);
    return ok;
}
