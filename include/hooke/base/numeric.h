/* SPDX-License-Identifier: GPL-3.0-or-later */
/* numeric: numerical functions that several layers need: order statistics, sorting, random numbers,
 * Hermite interpolation, small dense matrices. Nothing here allocates; work memory is the caller's.
 */
#pragma once

#include <hooke/base/text.h>

struct cancel;

/* The circle constant, because <math.h> of ISO C has none. */
#define PI 3.14159265358979323846
#define TWO_PI 6.28318530717958647692
/* Ratio of the standard deviation to the median of |x| for normal noise of mean 0. */
#define MAD_TO_SIGMA 1.4826
/* Tuning constant of Tukey's bisquare weights in robust standard deviations; 95 % efficiency for
 * normal noise (Holland & Welsch 1977). */
#define BISQUARE_TUNING 4.685

/* Attribute of functions that are compiled once for each set of vector instructions; the best one
 * that the machine has is chosen at the start of the program, and all give the same bits. It is
 * empty without optimisation, because functions that pass vectors are then called instead of
 * inlined, and each set of instructions passes vectors differently. CLONES_FOR takes the names of
 * the sets; CLONES is the usual choice. */
#if defined(__x86_64__) && defined(__OPTIMIZE__) && !defined(__clang__) &&                         \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CLONES_FOR(...) __attribute__((target_clones("default", __VA_ARGS__)))
#else
#define CLONES_FOR(...)
#endif
#define CLONES CLONES_FOR("avx2", "avx512f")

/* Returns the smaller of two integers. */
static inline int int_min(int a, int b)
{
    return a < b ? a : b;
}

/* Returns the larger of two integers. */
static inline int int_max(int a, int b)
{
    return a > b ? a : b;
}

/* Returns the smaller of two integers of 64 bits. */
static inline int64_t int64_min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* Returns the quantile `share` (0 to 1) of values [n]: the element at that fraction of their
 * ascending order, rounded to the nearest index, so that 0.5 gives the median (the upper one for an
 * even n). Reorders the values, none of which may be NAN. Returns NAN if n is 0. */
double values_quantile(double *values, size_t n, double share);
/* Sorts values [n] in ascending order; none may be NAN. scratch [n] is work memory. Returns false
 * if cancelled, with the values in any order or lost; cancel may be NULL. */
bool sort_values(double *values, size_t n, double *scratch, const struct cancel *cancel);

/* Returns a random number in [0, 1) and advances *state, any 64 bits at first (splitmix64; Steele,
 * Lea & Flood 2014). */
double random_fraction(uint64_t *state);

/* Returns the index of the first of n ascending values that is >= x, or n if there is none. */
size_t first_from(const double *ascending, size_t n, double x);

/* Returns the cubic Hermite polynomial on a step of length h: values y0, y1 and derivatives f0, f1
 * at its ends, evaluated at the fraction theta (0 to 1) of it (Hairer, Norsett, Wanner I, eq.
 * II.6.7). */
static inline double hermite(double theta, double h, double y0, double f0, double y1, double f1)
{
    const double bend = (1 - 2 * theta) * (y1 - y0) + (theta - 1) * h * f0 + theta * h * f1;
    return (1 - theta) * y0 + theta * y1 + theta * (theta - 1) * bend;
}

/* Computes the Cholesky factor L, A = L L^T, of a symmetric positive definite matrix: the leading n
 * by n block of `a`, whose rows are `width` apart and of which only the lower triangle is read. `l`
 * has the same layout and may be equal to `a`. Returns false, with `l` undefined, if a pivot is not
 * larger than the fraction `independent` of its diagonal element (1e-14 allows for rounding only).
 */
bool matrix_cholesky(int n, int width, const double *a, double independent, double *l);
/* Replaces x [n] by L^-1 x; `l` and `width` are those of matrix_cholesky(). */
void cholesky_forward(int n, int width, const double *l, double *x);
/* Replaces x [n] by L^-T x. */
void cholesky_backward(int n, int width, const double *l, double *x);

/* ---- square matrices [n][n], row by row ---- */

/* Computes product = a b; `product` must not overlap a or b. */
void matrix_multiply(int n, const double *a, const double *b, double *product);
/* Returns the infinity norm: the largest sum of magnitudes in a row. */
double matrix_norm(int n, const double *a);
/* Replaces a by exp(a) 2^-k and returns k, which is 0 unless exp(a) would overflow or underflow
 * (Moler, Van Loan 2003, SIAM Rev. 45:3, method 3: scaling and squaring). work has 2 n^2 doubles.
 */
double matrix_exponential(int n, double *a, double *work);

/* Real and imaginary part of an eigenvalue. */
struct eigenvalue {
    double re, im;
};

/* Appends "1.4530(4)": the value, and its uncertainty in units of the last digit. Uncertainties
 * that are 0, NAN, above 9.5 or below about 1e-6 are left out, and the value then has 6 decimals.
 */
void buffer_parenthesis(struct buffer *output, double value, double uncertainty);
