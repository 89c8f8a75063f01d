/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers as unevaluated sums of two doubles (Dekker 1971; Knuth, TAOCP 2, 4.2.2), and doubles as
 * bits. */
#pragma once

#include <hooke/base/circle.h>
#include <hooke/base/elementary.h>

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

#define SIGN_BIT 0x8000000000000000u
#define EXPONENT_SHIFT 52

/* Returns the bits of x. */
INLINE uint64_t to_bits(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Returns the double with these bits. */
INLINE double from_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Returns 2^n, -1022 <= n <= 1023. */
INLINE double power_of_two(int64_t n)
{
    return from_bits((uint64_t)(n + 1023) << EXPONENT_SHIFT);
}

/* The number high + low, with |low| at most half a last place of high unless a function tells
 * otherwise. */
struct wide {
    double high, low;
};

/* Returns a + b exactly, for |a| >= |b| or a = 0. */
INLINE struct wide ordered_sum(double a, double b)
{
    const double high = a + b;
    return (struct wide){high, b - (high - a)};
}

/* Returns a + b exactly, for any a and b. */
INLINE struct wide wide_sum(double a, double b)
{
    const double high = a + b, of_b = high - a;
    return (struct wide){high, (a - (high - of_b)) + (b - of_b)};
}

/*
 * `fused` selects products and sums in one operation, used only where the result is a double
 * anyway, so that both ways give the same bits. HAS_FUSED_MULTIPLY is true if all target machines
 * have the operation. Otherwise fused_here() asks the machine, and FUSED_CLONE is compiled for
 * those that have it.
 */
#ifdef __FP_FAST_FMA
#define HAS_FUSED_MULTIPLY true
#else
#define HAS_FUSED_MULTIPLY false
#endif
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__FP_FAST_FMA)
#define FUSED_CLONE __attribute__((target("fma")))
#define fused_here() __builtin_cpu_supports("fma")
#endif

/* Returns a b exactly, for |a|, |b| < 2^900 and |a b| > 2^-900 or 0 (Veltkamp's halves, Dekker's
 * product). */
INLINE struct wide exact_product(double a, double b, bool fused)
{
    const double high = a * b;
    if (fused)
        return (struct wide){high, fma(a, b, -high)};
    const double a0 = a * 0x1.0000002p27, b0 = b * 0x1.0000002p27;
    const double a1 = a0 - (a0 - a), a2 = a - a1, b1 = b0 - (b0 - b), b2 = b - b1;
    return (struct wide){high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2};
}

/* Returns a b exactly, in the range of exact_product(). */
INLINE struct wide wide_product(double a, double b)
{
    return exact_product(a, b, HAS_FUSED_MULTIPLY);
}

/* Returns a b to about twice the digits of a double. */
INLINE struct wide wide_times(struct wide a, struct wide b)
{
    const struct wide p = wide_product(a.high, b.high);
    return ordered_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}

/* Returns x cut to 26 bits; products of two such numbers are exact. */
INLINE double upper_part(double x)
{
    return from_bits(to_bits(x) & ~UINT64_C(0x7FFFFFF));
}

/* Returns a/b: high has 26 bits, so that its products with both parts of b are exact, and low is
 * the remainder. */
INLINE struct wide wide_quotient(struct wide a, struct wide b)
{
    const double per_b = 1 / b.high, q = upper_part(a.high * per_b), b1 = upper_part(b.high);
    const double rest = ((a.high - q * b1) - q * (b.high - b1)) + (a.low - q * b.low);
    return (struct wide){q, rest * per_b};
}
