/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Factoring and solving of small dense linear systems, real and complex. Source: Golub, Van Loan
 * 1996, Matrix Computations, 3.4. */
#include "method/step/lu_body.h"

/* Does the work of lu_factor_complex(); re is followed by the imaginary parts. Inlined for small
 * n. */
LU_FUNCTION bool factor_complex(int n, double *re)
{
    double *im = re + LU_ROOM(n);
    for (int p = 0; p < n; p++) {
        int best = p;
        for (int i = p + 1; i < n; i++)
            if (fabs(re[i * n + p]) + fabs(im[i * n + p]) >
                fabs(re[best * n + p]) + fabs(im[best * n + p]))
                best = i;
        /* 1/(x + i y), scaled by its size, so that its square neither overflows nor underflows */
        double size = fabs(re[best * n + p]) + fabs(im[best * n + p]), unit = 1 / size;
        if (unit == 0 || !isfinite(unit))
            return false;
        double x = re[best * n + p] * unit, y = im[best * n + p] * unit;
        double inverse = unit / (x * x + y * y), inverse_re = x * inverse,
               inverse_im = -y * inverse;
        re[n * n + p] = best;
        if (best != p)
            for (int j = p; j < n; j++) {
                doubles_swap(&re[p * n + j], &re[best * n + j]);
                doubles_swap(&im[p * n + j], &im[best * n + j]);
            }
        re[p * n + p] = inverse_re;
        im[p * n + p] = inverse_im;
        for (int i = p + 1; i < n; i++) {
            double u = re[i * n + p] * inverse_re - im[i * n + p] * inverse_im;
            double v = re[i * n + p] * inverse_im + im[i * n + p] * inverse_re;
            re[i * n + p] = u;
            im[i * n + p] = v;
            for (int j = p + 1; j < n; j++) {
                re[i * n + j] -= u * re[p * n + j] - v * im[p * n + j];
                im[i * n + j] -= u * im[p * n + j] + v * re[p * n + j];
            }
        }
    }
    return true;
}

/* Does the work of lu_solve_complex(). Inlined for small n. */
LU_FUNCTION void solve_complex(int n, const double *a, double *re, double *im)
{
    const double *b = a + LU_ROOM(n);
    for (int p = 0; p < n; p++) {
        int best = (int)a[n * n + p];
        if (best != p) {
            doubles_swap(&re[p], &re[best]);
            doubles_swap(&im[p], &im[best]);
        }
        for (int i = p + 1; i < n; i++) {
            re[i] -= a[i * n + p] * re[p] - b[i * n + p] * im[p];
            im[i] -= a[i * n + p] * im[p] + b[i * n + p] * re[p];
        }
    }
    for (int i = n; i-- > 0;) {
        for (int j = i + 1; j < n; j++) {
            re[i] -= a[i * n + j] * re[j] - b[i * n + j] * im[j];
            im[i] -= a[i * n + j] * im[j] + b[i * n + j] * re[j];
        }
        double x = re[i], y = im[i];
        re[i] = x * a[i * n + i] - y * b[i * n + i];
        im[i] = x * b[i * n + i] + y * a[i * n + i];
    }
}

/* Factors a; sizes up to 3 have their own code. */
bool lu_factor(int n, double *a)
{
    switch (n) {
    case 1:
        return lu_factor_size(1, a, a + n * n);
    case 2:
        return lu_factor_size(2, a, a + n * n);
    case 3:
        return lu_factor_size(3, a, a + n * n);
    default:
        return lu_factor_size(n, a, a + n * n);
    }
}

/* Solves a x = b in place, by the factors of lu_factor(). */
void lu_solve(int n, const double *a, double *b)
{
    switch (n) {
    case 1:
        lu_solve_size(1, a, a + n * n, b);
        break;
    case 2:
        lu_solve_size(2, a, a + n * n, b);
        break;
    case 3:
        lu_solve_size(3, a, a + n * n, b);
        break;
    default:
        lu_solve_size(n, a, a + n * n, b);
        break;
    }
}

/* Factors the complex a; sizes up to 3 have their own code. */
bool lu_factor_complex(int n, double *a)
{
    switch (n) {
    case 1:
        return factor_complex(1, a);
    case 2:
        return factor_complex(2, a);
    case 3:
        return factor_complex(3, a);
    default:
        return factor_complex(n, a);
    }
}

/* Solves the complex a x = re + i im in place. */
void lu_solve_complex(int n, const double *a, double *re, double *im)
{
    switch (n) {
    case 1:
        solve_complex(1, a, re, im);
        break;
    case 2:
        solve_complex(2, a, re, im);
        break;
    case 3:
        solve_complex(3, a, re, im);
        break;
    default:
        solve_complex(n, a, re, im);
        break;
    }
}
