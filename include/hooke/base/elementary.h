/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Elementary functions that give the same bits on every machine: products, sums, quotients and
 * roots of doubles in one order, each rounded as IEEE 754 says, nothing of the C library's; a
 * fused multiply-add only where it rounds nothing. What enters steps of fixed size is made of
 * these.
 *
 * Within 0.9 units of the last place of the true value everywhere, with the special values of C11
 * annex F; errno and the exception flags are not theirs. For rounding to nearest.
 */
#pragma once

/* Nothing but their arguments counts, and nothing is written. */
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

/* Computes n sines at once, in vectors as wide as the machine has, with the same bits as
 * fixed_sin(). out may be x. */
void fixed_sines(int n, const double *x, double *results);
void fixed_cosines(int n, const double *x, double *results);
void fixed_exponentials(int n, const double *x, double *results);
