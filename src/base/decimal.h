/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Decimal numbers as integers, shared by the reader (number_in.c) and the writer (number_out.c).
 *
 * With 10^p = 5^p 2^p and 5^27 < 2^63, m 10^p is an exact 128-bit integer for every double mantissa
 * m and 0 <= p <= 27, so that both directions are exact integer arithmetic for the numbers a
 * laboratory has; the rest goes through libc.
 */
#pragma once

#include <hooke/base/number.h>

/* Machines of 32 bits have no such integer; they use libc for all numbers, with the same results.
 */
#ifdef __SIZEOF_INT128__
#define HAVE_WIDE 1
__extension__ typedef unsigned __int128 wide;
#else
#define HAVE_WIDE 0
#endif

/* Exponent of the largest power of five that fits into 64 bits. */
#define POWER5_MAX 27
#define POWER10_MAX 22 /* the largest power of ten that is a double */

/* 5^p, and 10^p as doubles that are exact. */
extern const uint64_t decimal_power5[POWER5_MAX + 1];
extern const double decimal_power10[POWER10_MAX + 1];

/* The number digits * 10^exponent. */
struct decimal {
    bool negative;
    uint64_t digits; /* less than 10^17 */
    int exponent;
};

/* Returns the decimal with the fewest digits that reads back to a finite value, and of those the
 * nearest one; it has no trailing zeros. */
struct decimal decimal_shortest(double value);
/* Writes an exponent such as "e-7" at cursor, without NUL. Returns its end. */
char *decimal_power(char *cursor, int exponent);
/* Writes plain notation if low <= decade of the first digit < high, else d.ddde-7. Returns the
 * length without the NUL. */
size_t decimal_write(struct decimal decimal, int low, int high, char output[REAL_TEXT_SIZE]);
