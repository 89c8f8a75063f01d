/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Constants of sine and cosine, shared by scalar code and by code for vectors of any width so that
 * both return the same bits.
 *
 * x = n pi/2 + r (Cody & Waite 1980), pi/2 in three parts; the products of n (at most 19 bits) with
 * the first two are exact. Polynomials for |r| <= pi/4 (Remez exchange in 400 bits, weights of the
 * relative error, coefficients rounded one after another, the others found again each time): sin r
 * = r + r^3 S(r^2) to 2^-57.9, cos r = 1 - r^2/2 + r^4 C(r^2) to 2^-64.
 */
#pragma once

#define HALF_PI_1 0x1.921fb54400000p+0 /* 33 bits each, and what follows */
#define HALF_PI_2 0x1.0b4611a600000p-34
#define HALF_PI_3 0x1.3198a2e037073p-69
#define TWO_OVER_PI 0x1.45f306dc9c883p-1
#define CIRCLE_FAR 0x1p19 /* |x| beyond takes all of pi's digits */
#define CIRCLE_CLOSE                                                                               \
    0x1p-40               /* and so does what is left of n pi/2 where it is less than this n       \
                           */
#define CIRCLE_NEAR 0.785 /* nothing to reduce below */
/* Added to a number, it removes the fraction; the low bits of the sum are the integer. */
#define ROUND_TO_INTEGER 0x1.8p52

/* S and C, s = r^2, q = s^2; GIVE(coefficient of S, that of C) chooses. */
#define CIRCLE_SERIES(GIVE, s, q)                                                                  \
    ((GIVE(-0x1.5555555555548p-3, 0x1.555555555554bp-5) +                                          \
      (s)*GIVE(0x1.111111110f730p-7, -0x1.6c16c16c15013p-10)) +                                    \
     (q) * ((GIVE(-0x1.a01a019be9212p-13, 0x1.a01a019c8ed07p-16) +                                 \
             (s)*GIVE(0x1.71de35552aaacp-19, -0x1.27e4f7f141083p-22)) +                            \
            (q) * (GIVE(-0x1.ae5e4b830f1f3p-26, 0x1.1ee9db8e24ed5p-29) +                           \
                   (s)*GIVE(0x1.5d8b553fce991p-33, -0x1.8fa65e88311bfp-37))))
