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
#ifndef HOOKE_BASE_ELEMENTARY_H
#define HOOKE_BASE_ELEMENTARY_H

/* Nothing but their arguments counts, and nothing is written. */
#if defined(__GNUC__)
#define FIXED __attribute__((const)) double
#else
#define FIXED double
#endif

FIXED fixed_sin(double x);
FIXED fixed_cos(double x);
FIXED fixed_tan(double x);
FIXED fixed_asin(double x);
FIXED fixed_acos(double x);
FIXED fixed_atan(double x);
FIXED fixed_atan2(double y, double x);
FIXED fixed_exp(double x);
FIXED fixed_expm1(double x);
FIXED fixed_sinh(double x);
FIXED fixed_cosh(double x);
FIXED fixed_tanh(double x);
FIXED fixed_log(double x);
FIXED fixed_log10(double x);
FIXED fixed_pow(double x, double y);
FIXED fixed_cbrt(double x);
FIXED fixed_hypot(double x, double y);

/* Of n numbers at once, in vectors as wide as the machine has; out may be x. The same bits. */
void fixed_sines(int n, const double *x, double *out);
void fixed_cosines(int n, const double *x, double *out);
void fixed_exponentials(int n, const double *x, double *out);

#endif
