/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Decimals inside base: what the reader and the writer of numbers share.
 *
 * With 10^p = 5^p 2^p and 5^27 < 2^63, m 10^p is an exact 128-bit integer for every double mantissa
 * m and 0 <= p <= 27, so that both directions are exact integer arithmetic for the numbers a
 * laboratory has; the rest goes through libc.
 */
#pragma once

#include <hooke/base/number.h>

/* Machines of 32 bits have no such integer: there all goes through libc, with the same results. */
#ifdef __SIZEOF_INT128__
#define HAVE_WIDE 1
__extension__ typedef unsigned __int128 wide;
#else
#define HAVE_WIDE 0
#endif

#define POWER5_MAX 27
#define POWER10_MAX 22 /* the largest power of ten that is a double */

extern const uint64_t decimal_power5[POWER5_MAX + 1];
extern const double decimal_power10[POWER10_MAX + 1];

/* digits * 10^exponent */
struct decimal {
    bool negative;
    uint64_t digits; /* less than 10^17 */
    int exponent;
};

/* The finite value with the fewest digits that read back to it, and of those the nearest; no
 * trailing zeros. */
struct decimal decimal_shortest(double value);
/* "e-7" at `cursor`, without NUL; returns its end. */
char *decimal_power(char *cursor, int exponent);
/* Plain notation while low <= decade < high, else d.ddde-7. Returns the length without the NUL. */
size_t decimal_write(struct decimal decimal, int low, int high, char output[REAL_TEXT_SIZE]);
