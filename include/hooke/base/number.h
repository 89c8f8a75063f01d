/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * number: converts between doubles and decimal text, independent of the locale.
 *
 * The reader rounds correctly and refuses hexadecimal numbers, nan, inf and overflow. The writer
 * gives the shortest decimal that reads back to the same double: at most 17 digits, without an
 * exponent for 1e-4 <= |x| < 1e17, else as 1.5e-7; and `nan`, `inf` or `-inf`.
 */
#pragma once

#include <hooke/base/text.h>

/* Size [byte] of any number as text, with its NUL. */
#define REAL_TEXT_SIZE 32

/* Result of reading a number. */
enum real_status {
    REAL_OK,
    REAL_EMPTY, /* The text is empty. */
    /* No number at the start of the text; or, for real_parse(), text after the number. */
    REAL_MALFORMED,
    REAL_OVERFLOW, /* The magnitude is above the largest double. */
    REAL_UNDERFLOW /* The value is 0 or denormal; it is returned nevertheless. */
};

/* Reads the longest number at the start of `text` with `decimal` ('.' or ',') as its decimal point.
 * Sets *used to its length [byte], which is 0, with *value unchanged, if there is none. */
enum real_status real_scan(struct text text, char decimal, double *value, size_t *used);
/* Reads a text that consists of one number with a decimal point; anything after it gives
 * REAL_MALFORMED. *value is unchanged if there is no number. */
enum real_status real_parse(struct text text, double *value);
/* Writes the shortest decimal with a NUL. Returns its length [byte] without the NUL. */
size_t real_format(double value, char output[REAL_TEXT_SIZE]);
void buffer_real(struct buffer *buffer, double value); /* Appends the shortest decimal. */
/* Appends the value rounded to `digits` significant digits (1 to 17), without trailing zeros. For
 * other values of `digits` appends the shortest decimal. */
void buffer_short(struct buffer *buffer, double value, int digits);
/* Appends "1.9373 +- 0.0002": the uncertainty rounded to one digit, or to two if it begins with 1,
 * and the value to the same decimal place. Without an uncertainty (0, NAN or infinite) appends the
 * value with 6 digits. */
void buffer_uncertain(struct buffer *buffer, double value, double uncertainty);
/* Appends a phase [rad] in degrees with whole turns counted separately, "381 turns + 204.9 deg", or
 * "-" if it is not finite. */
void buffer_phase(struct buffer *buffer, double radians);
