/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables of constants: powers of two, elementary_reciprocals of few bits with their logarithms,
 * elementary_tangents. */
#pragma once

#include "base/elementary/wide.h"

#define TABLE_ROWS 128
#define ROW_SHIFT 45 /* shifts the bits of a double to the number of the row */

/*
 * 2^(j/128) = T (1 + (t - 2^14) 2^-67), T = 1 + j/128 - d: t, and below TAIL_SHIFT d in bits of T.
 * In one number, which vectors gather.
 */
#define TAIL_SHIFT 49
#define TAIL_ONE 0x1p-15 /* its last place is that of tails */
#define TAIL_ZERO (TAIL_ONE + 0x1p-53)
extern const uint64_t powers_of_two[TABLE_ROWS];

/*
 * Table of reciprocals. Row j holds for the doubles m with bits from FIRST_M + (j << ROW_SHIFT) on,
 * 0.697 <= m < 1.395. It has c, of at most 9 bits, such that m c - 1 is a double of less than
 * 0.00528, and -log c, whose first part is a multiple of 2^-42. 1 is in the middle of a row, with c
 * = 1.
 */
#define FIRST_M 0x3FE6500000000000
struct reciprocal {
    double c, high, low;
};
extern const struct reciprocal elementary_reciprocals[TABLE_ROWS];

/* tan j/32 and cot j/32, 4 <= j */
#define TANGENT_ROWS 26
extern const struct wide elementary_tangents[2][TANGENT_ROWS];
