/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * number: numbers in and out of text.
 *
 * One reader and one writer, independent of the locale. The reader rounds correctly; hexadecimal,
 * nan and inf, trailing garbage, overflow and a decimal comma are refused. The writer gives the
 * shortest decimal that reads back to the same double (at most 17 digits, plain for 1e-4 <= |x| <
 * 1e17, else 1.5e-7), `nan`, `inf`, `-inf` for the rest.
 */
#pragma once

#include <hooke/base/text.h>

#define REAL_TEXT_SIZE 32

enum real_status {
    REAL_OK,
    REAL_EMPTY,
    REAL_MALFORMED,
    REAL_OVERFLOW,
    REAL_UNDERFLOW /* value is kept (denormal or 0) */
};

/* Reads the longest number at the start of `text`. *used [byte]: its length, 0 if there is none.
 * decimal: '.' or ','. */
enum real_status real_scan(struct text text, char decimal, double *value, size_t *used);
/* Reads a text that is a number as a whole, with a decimal point. */
enum real_status real_parse(struct text text, double *value);
/* Writes the shortest decimal. Returns its length [byte] without the NUL. */
size_t real_format(double value, char output[REAL_TEXT_SIZE]);
void buffer_real(struct buffer *buffer, double value); /* appends the shortest decimal */
/* Appends `digits` significant digits without trailing zeros. */
void buffer_short(struct buffer *buffer, double value, int digits);
/* Appends "1.9373 +- 0.0002": the uncertainty to one digit, to two if it starts with 1, and the
 * value to the same place; 6 digits of the value if the uncertainty is not known. */
void buffer_uncertain(struct buffer *buffer, double value, double uncertainty);
/* Appends a phase [rad] in degrees, with whole turns apart: "381 turns + 204.9 deg"; "-" if it is
 * not finite. */
void buffer_phase(struct buffer *buffer, double radians);
