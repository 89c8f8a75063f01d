/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables of constants for exp (powers_of_two), log (elementary_reciprocals) and tan
 * (elementary_tangents); scripts/elementary writes them. */
#pragma once

#include "base/elementary/wide.h"

/* Rows of the tables for exp and log, which divide a factor of two into 128 parts. */
#define TABLE_ROWS 128
#define ROW_SHIFT 45 /* shifts the bits of a double to the number of the row */

/*
 * Row j holds 2^(j/128) = T (1 + (t - 2^14) 2^-67) with T = 1 + j/128 - d. One word has t from bit
 * TAIL_SHIFT on and d, in units of the last place of T, below it, so that vectors gather one word.
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
/* c near 1/m, and -log c = high + low. */
struct reciprocal {
    double c, high, low;
};
extern const struct reciprocal elementary_reciprocals[TABLE_ROWS];

/* tan j/32 in the first and cot j/32 in the second row, for 4 <= j; others are 0. */
#define TANGENT_ROWS 26
extern const struct wide elementary_tangents[2][TANGENT_ROWS];
