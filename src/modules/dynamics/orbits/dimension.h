/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The dimension of Kaplan and Yorke of an attractor, from its Lyapunov exponents. */
#pragma once

#include "modules/dynamics/chaos.h"

/* Returns the dimension of Kaplan and Yorke (1979), D = j + (L1 + ... + Lj)/|L(j+1)| with the
 * largest j whose sum is not negative, for exponents [count] in falling order of a scene with n
 * variables; NAN if more exponents are needed. scale [1/s] is the magnitude of the exponents, below
 * which they count as 0. slope [count] becomes the derivative of D by each exponent. At a whole
 * number D has different derivatives on both sides: slope is the larger one if errors allow for
 * both. */
double kaplan_yorke(const struct exponent *exponent, int count, int n, double scale, double *slope);
