/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * elementary: elementary functions that give the same bits on every machine. Everything that enters
 * a step of fixed size uses these instead of the C library's.
 *
 * They consist of sums, products, quotients and square roots of doubles in a fixed order, each
 * rounded as IEEE 754 requires; a fused multiply-add occurs only where its result is exact. The
 * error is below 0.9 units in the last place, and special values are those of C11 annex F. They do
 * not set errno, the exception flags are unspecified, and the rounding mode must be to nearest.
 * Angles are in radians.
 */
#pragma once

/* Return type double, with an attribute that lets compilers merge calls: the result depends on the
 * arguments alone, and the function writes nothing. */
#if defined(__GNUC__)
#define FIXED_FUNCTION __attribute__((const)) double
#else
#define FIXED_FUNCTION double
#endif

FIXED_FUNCTION fixed_sin(double x);
FIXED_FUNCTION fixed_cos(double x);
FIXED_FUNCTION fixed_tan(double x);
FIXED_FUNCTION fixed_asin(double x);
FIXED_FUNCTION fixed_acos(double x);
FIXED_FUNCTION fixed_atan(double x);
FIXED_FUNCTION fixed_atan2(double y, double x);
FIXED_FUNCTION fixed_exp(double x);
FIXED_FUNCTION fixed_expm1(double x);
FIXED_FUNCTION fixed_sinh(double x);
FIXED_FUNCTION fixed_cosh(double x);
FIXED_FUNCTION fixed_tanh(double x);
FIXED_FUNCTION fixed_log(double x);
FIXED_FUNCTION fixed_log10(double x);
FIXED_FUNCTION fixed_pow(double x, double y);
FIXED_FUNCTION fixed_cbrt(double x);
FIXED_FUNCTION fixed_hypot(double x, double y);

/* Compute results[i] = f(x[i]) for n values with the vector instructions of the machine, with the
 * same bits as fixed_sin(), fixed_cos() and fixed_exp(). `results` may be equal to x. */
void fixed_sines(int n, const double *x, double *results);
void fixed_cosines(int n, const double *x, double *results);
void fixed_exponentials(int n, const double *x, double *results);
