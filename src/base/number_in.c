/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads decimal numbers, correctly rounded and independent of the locale: by exact integers for
 * usual numbers, else by strtod(). */
#define _GNU_SOURCE /* strtod_l */
#include "base/decimal.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>

/* Neighbouring doubles differ within their first 768 significant digits; of later digits it matters
 * only if one of them is not zero. */
#define DIGITS_MAX 800
#define EXPONENT_MAX 1000000000000000 /* larger than any that could matter, far from overflow */

const uint64_t decimal_power5[POWER5_MAX + 1] = {
    1u,
    5u,
    25u,
    125u,
    625u,
    3125u,
    15625u,
    78125u,
    390625u,
    1953125u,
    9765625u,
    48828125u,
    244140625u,
    1220703125u,
    6103515625ull,
    30517578125ull,
    152587890625ull,
    762939453125ull,
    3814697265625ull,
    19073486328125ull,
    95367431640625ull,
    476837158203125ull,
    2384185791015625ull,
    11920928955078125ull,
    59604644775390625ull,
    298023223876953125ull,
    1490116119384765625ull,
    7450580596923828125ull,
};

const double decimal_power10[POWER10_MAX + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/* A number as written, by its first 19 digits; the rest is found again through its position. */
struct scanned {
    bool negative;
    uint64_t leading;                 /* the first (up to) 19 significant digits */
    size_t digits;                    /* significant digits, without leading zeros */
    int64_t exponent;                 /* value = all digits as an integer * 10^exponent */
    size_t first, mantissa_end, used; /* [byte] positions of the digits, and length */
};

/* Returns the exponent of the number at text[*position], and moves *position behind it; returns 0
 * and leaves *position if there is no complete exponent. */
static int64_t scan_exponent(struct text text, size_t *position)
{
    size_t i = *position;
    if (i >= text.len || (text.data[i] != 'e' && text.data[i] != 'E'))
        return 0;
    i++;
    bool negative = i < text.len && text.data[i] == '-';
    if (i < text.len && (text.data[i] == '-' || text.data[i] == '+'))
        i++;
    if (i >= text.len || !is_digit_char(text.data[i]))
        return 0;
    int64_t value = 0;
    for (; i < text.len && is_digit_char(text.data[i]); i++)
        value = value < EXPONENT_MAX ? value * 10 + (text.data[i] - '0') : value;
    *position = i;
    return negative ? -value : value;
}

/* Scans sign, digits with one decimal mark, and exponent at the start of text. Returns false if
 * there is no digit. */
static bool number_scan(struct text text, char decimal, struct scanned *s)
{
    *s = (struct scanned){0};
    size_t i = 0;
    if (text.len > 0 && (text.data[0] == '-' || text.data[0] == '+'))
        s->negative = text.data[i++] == '-';
    bool point = false, any = false;
    for (s->first = i; i < text.len; i++) {
        char c = text.data[i];
        if (c == decimal && !point) {
            point = true;
            continue;
        }
        if (!is_digit_char(c))
            break;
        any = true;
        s->exponent -= point;
        if (s->digits > 0 || c != '0') {
            if (s->digits < 19)
                s->leading = s->leading * 10 + (uint64_t)(c - '0');
            s->digits++;
        }
    }
    s->mantissa_end = i;
    if (any) {
        s->exponent += scan_exponent(text, &i);
        s->used = i;
    }
    return any;
}

#if HAVE_WIDE
/* Returns n * 2^exponent rounded to nearest even, with n >= 2^53. `more` means that n has lost a
 * non-zero tail (it then has at least 64 bits). */
static double round_scaled_integer(wide n, int exponent, bool more)
{
    uint64_t high = (uint64_t)(n >> 64);
    int bits = high ? 128 - __builtin_clzll(high) : 64 - __builtin_clzll((uint64_t)n);
    int drop = bits - 53;
    uint64_t mantissa = (uint64_t)(n >> drop);
    wide half = (wide)1 << (drop - 1), rest = n & (2 * half - 1);
    if (rest > half || (rest == half && (more || (mantissa & 1))))
        mantissa++;
    return ldexp((double)mantissa, exponent + drop);
}

/* Returns w * 10^e, |e| <= POWER5_MAX, correctly rounded, by one exact product or quotient of
 * integers. */
static double value_by_integers(uint64_t w, int e)
{
    if (e >= 0)
        return round_scaled_integer((wide)w * decimal_power5[e], e, false);
    /* A numerator with its top bit set leaves a quotient of at least 65 bits. */
    const int shift = 64 + __builtin_clzll(w);
    const wide numerator = (wide)w << shift;
    return round_scaled_integer(numerator / decimal_power5[-e], e - shift,
                                numerator % decimal_power5[-e] != 0);
}
#endif

/* Converts a number with any number of digits by strtod() in the "C" locale, which allocates
 * nothing and changes no locale. */
static double value_by_library(struct text text, const struct scanned *s)
{
    char z[DIGITS_MAX + 32];
    size_t len = 0, seen = 0;
    bool more = false;
    for (size_t i = s->first; i < s->mantissa_end; i++) {
        char c = text.data[i];
        if (!is_digit_char(c) || (seen == 0 && c == '0'))
            continue;
        if (seen++ < DIGITS_MAX)
            z[len++] = c;
        else
            more = more || c != '0';
    }
    int64_t exponent = s->exponent + (int64_t)(seen - len);
    if (more) {
        z[len++] = '1';
        exponent--;
    }
    if (exponent > 2000)
        exponent = 2000;
    else
        exponent = exponent < -2000 ? -2000 : exponent;
    *decimal_power(z + len, (int)exponent) = '\0';
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return plain ? strtod_l(z, NULL, plain) : NAN;
}

/* Returns the absolute value of the scanned number, correctly rounded, by the fastest way that is
 * exact for it. */
static double scanned_magnitude(struct text text, const struct scanned *s)
{
    const uint64_t w = s->leading;
    const int64_t e = s->exponent;
    if (w == 0)
        return 0.0;
    if (s->digits > 19 || e < -POWER5_MAX || e > POWER5_MAX)
        return value_by_library(text, s);
    /* Clinger (1990): both factors are exact doubles, so that one rounding is all there is. */
    if (w <= (uint64_t)1 << 53 && e >= -POWER10_MAX && e <= POWER10_MAX)
        return e < 0 ? (double)w / decimal_power10[-e] : (double)w * decimal_power10[e];
#if HAVE_WIDE
    return value_by_integers(w, (int)e);
#else
    return value_by_library(text, s);
#endif
}

/* Reads the longest number at the start of text: its value, and its length *used [byte]. */
enum real_status real_scan(struct text text, char decimal, double *value, size_t *used)
{
    struct scanned s;
    *used = 0;
    if (text.len == 0)
        return REAL_EMPTY;
    if (!number_scan(text, decimal, &s))
        return REAL_MALFORMED;
    double size = scanned_magnitude(text, &s);
    *value = s.negative ? -size : size;
    *used = s.used;
    if (!isfinite(size))
        return REAL_OVERFLOW;
    return s.leading != 0 && size < 0x1p-1022 ? REAL_UNDERFLOW : REAL_OK;
}

/* Reads a text that is a number as a whole; *value stays unchanged if it is none. */
enum real_status real_parse(struct text text, double *value)
{
    size_t used;
    double number;
    enum real_status status = real_scan(text, '.', &number, &used);
    if (status == REAL_EMPTY || status == REAL_MALFORMED)
        return status;
    if (used != text.len)
        return REAL_MALFORMED;
    *value = number;
    return status;
}
