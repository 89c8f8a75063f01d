/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Elementary functions that give the same bits on every machine: products, sums, quotients and
 * roots of doubles in one order, each rounded as IEEE 754 says, never a fused multiply-add, nothing
 * of the C library's. What enters steps of fixed size is made of these.
 *
 * Within 1 unit of the last place of the true value everywhere, with the special values of C11
 * annex F; errno and the exception flags are not theirs. For rounding to nearest.
 */
#ifndef HOOKE_BASE_ELEMENTARY_H
#define HOOKE_BASE_ELEMENTARY_H

#include <stdint.h>

double fixed_sin(double x);
double fixed_cos(double x);
double fixed_tan(double x);
double fixed_asin(double x);
double fixed_acos(double x);
double fixed_atan(double x);
double fixed_atan2(double y, double x);
double fixed_exp(double x);
double fixed_expm1(double x);
double fixed_sinh(double x);
double fixed_cosh(double x);
double fixed_tanh(double x);
double fixed_log(double x);
double fixed_log10(double x);
double fixed_pow(double x, double y);
double fixed_cbrt(double x);
double fixed_hypot(double x, double y);

/* Of n numbers at once, in vectors as wide as the machine has; out may be x. The same bits. */
void fixed_sines(int n, const double *x, double *out);
void fixed_cosines(int n, const double *x, double *out);
void fixed_exponentials(int n, const double *x, double *out);

#endif
