/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * circle: constants of sine and cosine, which scalar and vector code share so that both give the
 * same bits. Only src/base/elementary and the vector kernels include it.
 *
 * The argument is reduced as x = n pi/2 + r (Cody & Waite 1980) with pi/2 split into three parts;
 * the products of n (at most 19 bits) with the first two parts are exact. For r from -pi/4 to pi/4
 * two polynomials S and C give sin r = r + r^3 S(r^2), with a relative error of 2^-57.9, and
 * cos r = 1 - r^2/2 + r^4 C(r^2), with a relative error of 2^-64. They were found by Remez exchange
 * in 400-bit arithmetic; coefficients were rounded to double one after another, and the others were
 * fitted again after each rounding.
 */
#pragma once

/* pi/2 = HALF_PI_1 + HALF_PI_2 + HALF_PI_3; the first two have 33 significant bits. */
#define HALF_PI_1 0x1.921fb54400000p+0
#define HALF_PI_2 0x1.0b4611a600000p-34
#define HALF_PI_3 0x1.3198a2e037073p-69
#define TWO_OVER_PI 0x1.45f306dc9c883p-1
/* Largest |x| that this reduction can reduce: for a larger |x|, n has more than 19 bits, so that
 * more digits of pi are needed. */
#define CIRCLE_FAR 0x1p19
/* If |r| < n CIRCLE_CLOSE, x is so near to n pi/2 that cancellation leaves too few correct bits in
 * r: then, too, more digits of pi are needed. */
#define CIRCLE_CLOSE 0x1p-40
#define CIRCLE_NEAR 0.785 /* Just below pi/4; a smaller |x| needs no reduction. */
/* Adding this constant to a double x with |x| < 2^51 rounds x to an integer, which is then in the
 * low bits of the sum. */
#define ROUND_TO_INTEGER 0x1.8p52

/* Computes S(s) or C(s) for s = r^2 and q = s^2, by Estrin's scheme. GIVE is the name of a macro of
 * the caller: GIVE(a, b) must expand to a, the coefficient of S, or to b, that of C. */
#define CIRCLE_SERIES(GIVE, s, q)                                                                  \
    ((GIVE(-0x1.5555555555548p-3, 0x1.555555555554bp-5) +                                          \
      (s)*GIVE(0x1.111111110f730p-7, -0x1.6c16c16c15013p-10)) +                                    \
     (q) * ((GIVE(-0x1.a01a019be9212p-13, 0x1.a01a019c8ed07p-16) +                                 \
             (s)*GIVE(0x1.71de35552aaacp-19, -0x1.27e4f7f141083p-22)) +                            \
            (q) * (GIVE(-0x1.ae5e4b830f1f3p-26, 0x1.1ee9db8e24ed5p-29) +                           \
                   (s)*GIVE(0x1.5d8b553fce991p-33, -0x1.8fa65e88311bfp-37))))
