/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Arithmetic that several layers need: robust statistics, interpolation, small systems. */
#pragma once

#include <hooke/base/text.h>

struct cancel;

#define PI 3.14159265358979323846
#define TWO_PI 6.28318530717958647692
#define MAD_TO_SIGMA 1.4826 /* median |x| of normal noise -> its standard deviation */
/* Tuning constant in robust standard deviations; 95 % efficiency (Holland & Welsch 1977). */
#define BISQUARE_TUNING 4.685

/* Compiles a function for each set of instructions and chooses the best one that the machine has
 * when the program starts; all give the same bits. Not without optimisation: functions that pass
 * vectors are then called, not inlined, and each set of instructions passes vectors in its own way.
 */
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

/* The value [n] nearest to that share of the way through their order, of an even number the upper
 * median; reorders them. Without NAN; of none: NAN. */
double values_quantile(double *values, size_t n, double share);
/* Sorts values in ascending order; none may be NAN. scratch has [n]. Returns false if cancelled,
 * with the values in any order. */
bool sort_values(double *values, size_t n, double *scratch, const struct cancel *cancel);

double random_fraction(uint64_t *state); /* [0, 1): splitmix64 (Steele, Lea & Flood 2014) */

/* The first of n ascending values that is at least x; n: none is. */
size_t first_from(const double *ascending, size_t n, double x);

/* Cubic through y0 and y1 with slopes f0 and f1 at the ends of h, at the share theta of it
 * (Hairer, Norsett, Wanner I, eq. II.6.7). */
static inline double hermite(double theta, double h, double y0, double f0, double y1, double f1)
{
    const double bend = (1 - 2 * theta) * (y1 - y0) + (theta - 1) * h * f0 + theta * h * f1;
    return (1 - theta) * y0 + theta * y1 + theta * (theta - 1) * bend;
}

/*
 * Computes A = L L^T of the first n rows and columns of `a`, whose lower triangle is read. Rows are
 * `width` long; l may be a. Returns false if a column is independent of those before it by less
 * than this part of its square (1e-14 for rounding).
 */
bool matrix_cholesky(int n, int width, const double *a, double independent, double *l);
void cholesky_forward(int n, int width, const double *l, double *x);  /* x = L^-1 x */
void cholesky_backward(int n, int width, const double *l, double *x); /* x = L^-T x */

/* ---- square matrices [n][n], row by row ---- */

void matrix_multiply(int n, const double *a, const double *b, double *product);
/* Returns the largest sum of magnitudes in a row. */
double matrix_norm(int n, const double *a);
/* Replaces a by exp(a) 2^-k and returns k, which is 0 unless exp(a) is out of the range of numbers
 * (Moler, Van Loan 2003, SIAM Rev. 45:3, method 3). work has 2 n^2 doubles. */
double matrix_exponential(int n, double *a, double *work);

struct eigenvalue {
    double re, im;
};

/* Appends "1.4530(4)": the uncertainty in units of the last digit. One of less than a millionth is
 * left out, as that of a simulation. */
void buffer_parenthesis(struct buffer *output, double value, double uncertainty);
