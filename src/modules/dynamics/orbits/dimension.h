/* SPDX-License-Identifier: GPL-3.0-or-later */
#pragma once

#include "modules/dynamics/chaos.h"

/*
 * Returns the dimension of Kaplan and Yorke (1979), D = j + (L1 + ... + Lj)/|L(j+1)| with the
 * largest j of which the sum is not negative, for falling exponents [count] of n variables; NAN if
 * more exponents are needed. scale [1/s] is the size of all n exponents, as their sum shows it,
 * too. slope [count] becomes its derivative by each exponent. Near a whole number D has one
 * derivative on each side: slope is the larger one if errors allow for both.
 */
double kaplan_yorke(const struct exponent *exponent, int count, int n, double scale, double *slope);
