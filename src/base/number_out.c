/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes numbers: the shortest decimal that reads back to the same double, numbers of given digits,
 * and values with their uncertainty. */
#include "base/decimal.h"
#include <hooke/base/numeric.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Returns the bits of the value. */
static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* Returns the decimal without trailing zeros. */
static struct decimal without_trailing_zeros(struct decimal d)
{
    while (d.digits && d.digits % 10 == 0) {
        d.digits /= 10;
        d.exponent++;
    }
    return d;
}

/* Returns value rounded to a number of significant digits, with trailing zeros kept. */
static struct decimal rounded_to_digits(double value, int digits)
{
    struct decimal d = {.negative = signbit(value)};
    char z[REAL_TEXT_SIZE];
    snprintf(z, sizeof z, "%.*e", digits - 1, fabs(value));
    const char *c = z;
    for (; *c && *c != 'e'; c++) /* the decimal point of the locale is skipped */
        if (*c >= '0' && *c <= '9')
            d.digits = d.digits * 10 + (uint64_t)(*c - '0');
    int exponent = 0;
    for (const char *e = c + 2; *c && *e; e++)
        exponent = exponent * 10 + (*e - '0');
    d.exponent = (*c && c[1] == '-' ? -exponent : exponent) - (digits - 1);
    return d;
}

/* Returns the finite value rounded to 1 to 17 significant digits, without trailing zeros. */
static struct decimal decimal_rounded(double value, int digits)
{
    struct decimal d = rounded_to_digits(value, digits);
    return d.digits ? without_trailing_zeros(d) : (struct decimal){.negative = d.negative};
}

#if HAVE_WIDE
/* Returns the shortest decimal for 1e-11 <= value < 1e17, in integers. With 17 digits before the
 * point, the value is v 2^-shift, and the interval of numbers that read back to it reaches 2 u
 * 2^-shift up and down, where u = 5^p is a quarter of the distance to the next double. The decimals
 * that read back are the integers in that interval; the shortest is the one that can be divided by
 * 10 most often. */
static struct decimal shortest_exact(double value)
{
    const uint64_t bits = bits_of(value);
    const uint64_t fraction = bits & (((uint64_t)1 << 52) - 1), m = fraction | (uint64_t)1 << 52;
    const int e = (int)(bits >> 52) - 1075;
    /* floor(log10(value)) from the binary exponent, at most one too small; `point` is 17 digits
     * before the point. */
    int decade = (int)floor((e + 52) * 0.30102999566398120);
    decade += decade < 0 ? value >= 1.0 / decimal_power10[-decade - 1]
                         : value >= decimal_power10[decade + 1];
    const int p = 16 - decade;

    const wide u = decimal_power5[p];
    const int left_shift = e + p > 2 ? e + p - 2 : 0;
    const int shift = e + p > 2 ? 0 : 2 - e - p;
    const wide v = (4 * u * m) << left_shift, upper_margin = (2 * u) << left_shift,
               lower_margin = (fraction ? 2 * u : u) << left_shift;
    const wide one = (wide)1 << shift;
    const wide closed = (m & 1) == 0; /* a tie reads as the even mantissa */
    uint64_t low = (uint64_t)((v - lower_margin + one - closed) >> shift);
    uint64_t high = (uint64_t)((v + upper_margin - 1 + closed) >> shift);

    struct decimal d = {.exponent = -p};
    uint64_t scale = 1;
    const uint64_t many = 100000000; /* eight zeros at once: most numbers that people typed */
    if (high / many * many >= low) {
        low = (low + many - 1) / many;
        high /= many;
        scale = many;
        d.exponent += 8;
    }
    while (high / 10 * 10 >= low) {
        low = (low + 9) / 10;
        high /= 10;
        scale *= 10;
        d.exponent++;
    }
    /* The nearest of the remaining ones is chosen. */
    const uint64_t whole = (uint64_t)(v >> shift);
    const wide rest = ((wide)(whole % scale) << shift) + (v & (one - 1));
    const wide all = (wide)scale << shift;
    d.digits = whole / scale;
    d.digits += d.digits < low ||
                (d.digits < high && (2 * rest > all || (2 * rest == all && (d.digits & 1))));
    return d;
}
#endif

/* Returns true if the text of the decimal is read as this value. */
static bool reads_back(struct decimal d, double value)
{
    char z[REAL_TEXT_SIZE];
    double reread;
    size_t len = decimal_write(d, 0, 0, z);
    real_parse((struct text){z, len}, &reread);
    return reread == value;
}

/* Returns the shortest decimal of any finite value, by trying numbers of digits. 15 digits always
 * survive, so that shorter ones come from them by dropping zeros; subnormal numbers may need
 * fewer. */
static struct decimal shortest_by_trying(double value)
{
    const bool power_of_two = (bits_of(value) << 12) == 0;
    for (int digits = value < 0x1p-1022 ? 1 : 15; digits < 17; digits++) {
        struct decimal d = rounded_to_digits(value, digits);
        if (reads_back(d, value))
            return without_trailing_zeros(d);
        /* The doubles are denser below a power of two: the nearest decimal may miss where its
         * neighbour above does not. */
        d.digits++;
        if (power_of_two && reads_back(d, value))
            return without_trailing_zeros(d);
    }
    return decimal_rounded(value, 17);
}

/* Returns the shortest decimal that reads back: by exact integers for usual values, else by
 * trying. */
struct decimal decimal_shortest(double value)
{
    const double size = fabs(value);
    struct decimal d = {0};
#if HAVE_WIDE
    if (size >= 1e-11 && size < 1e17)
        d = shortest_exact(size);
    else
#endif
        if (size > 0)
        d = shortest_by_trying(size);
    d.negative = signbit(value);
    return d;
}

/* Writes the digits of n so that they end before `end`. Returns the first of them. */
static char *decimal_digits(char *end, uint64_t n)
{
    static const char pairs[201] =
        "00010203040506070809101112131415161718192021222324252627282930313233343536373839"
        "40414243444546474849505152535455565758596061626364656667686970717273747576777879"
        "8081828384858687888990919293949596979899";
    for (; n >= 100; n /= 100)
        memcpy(end -= 2, pairs + 2 * (n % 100), 2);
    do
        *--end = (char)('0' + n % 10);
    while (n /= 10);
    return end;
}

/* Writes the exponent without a '+'. */
char *decimal_power(char *cursor, int exponent)
{
    char digits[20], *const end = digits + sizeof digits;
    const char *first = decimal_digits(end, (uint64_t)(exponent < 0 ? -exponent : exponent));
    *cursor++ = 'e';
    if (exponent < 0)
        *cursor++ = '-';
    memcpy(cursor, first, (size_t)(end - first));
    return cursor + (end - first);
}

/* Returns the power of ten of the first digit, which is 0 for 1 to 9; for zero, that of its last
 * place. */
static int decimal_decade(struct decimal decimal)
{
    int decade = decimal.exponent;
    for (uint64_t n = decimal.digits; n >= 10; n /= 10)
        decade++;
    return decade;
}

/* Writes the decimal: digits before the point, the point, further digits, with zeros where the
 * decimal has none, and an exponent unless it is plain. */
size_t decimal_write(struct decimal decimal, int low, int high, char output[REAL_TEXT_SIZE])
{
    char digits[20], *const end = digits + sizeof digits,
                            *first = decimal_digits(end, decimal.digits), *cursor = output;
    const int count = (int)(end - first), point = count + decimal.exponent, decade = point - 1;
    const bool plain = low <= decade && decade < high;
    /* Digits before the point; what is missing there or between the point and the first digit is
     * zeros. */
    const int integer_digits = plain ? point : 1;
    int whole;
    if (integer_digits < 0)
        whole = 0;
    else
        whole = integer_digits < count ? integer_digits : count;
    if (decimal.negative)
        *cursor++ = '-';
    if (integer_digits <= 0)
        *cursor++ = '0';
    memcpy(cursor, first, (size_t)whole);
    cursor += whole;
    for (int i = count; i < integer_digits; i++)
        *cursor++ = '0';
    if (whole < count)
        *cursor++ = '.';
    for (int i = integer_digits; i < 0; i++)
        *cursor++ = '0';
    memcpy(cursor, first + whole, (size_t)(count - whole));
    cursor += count - whole;
    if (!plain && decimal.digits)
        cursor = decimal_power(cursor, decade);
    *cursor = '\0';
    return (size_t)(cursor - output);
}

/* Writes nan, inf or -inf. Returns the length, or 0 if value is finite. */
static size_t write_nonfinite(double value, char output[REAL_TEXT_SIZE])
{
    if (isfinite(value))
        return 0;
    struct text name;
    if (isnan(value))
        name = TEXT("nan");
    else
        name = value < 0 ? TEXT("-inf") : TEXT("inf");
    memcpy(output, name.data, name.len + 1);
    return name.len;
}

size_t real_format(double value, char output[REAL_TEXT_SIZE])
{
    size_t len = write_nonfinite(value, output);
    return len ? len : decimal_write(decimal_shortest(value), -4, 17, output);
}

void buffer_real(struct buffer *buffer, double value)
{
    char z[REAL_TEXT_SIZE];
    size_t len = real_format(value, z);
    buffer_put(buffer, (struct text){z, len});
}

/* Appends value with at most `digits` significant digits; any other number than 1 to 17 gives the
 * shortest decimal. */
void buffer_short(struct buffer *buffer, double value, int digits)
{
    if (digits < 1 || digits > 17) {
        buffer_real(buffer, value);
        return;
    }
    char z[REAL_TEXT_SIZE];
    size_t len = write_nonfinite(value, z);
    if (!len)
        len = decimal_write(decimal_rounded(value, digits), -4, digits > 6 ? digits : 6, z);
    buffer_put(buffer, (struct text){z, len});
}

/* Appends a phase as degrees, to a tenth, with whole turns separately. */
void buffer_phase(struct buffer *buffer, double radians)
{
    /* rounded to a tenth */
    const double degrees = nearbyint(radians / 3.14159265358979323846 * 1800) / 10;
    const double turns = nearbyint(degrees / 360), rest = degrees - 360 * turns;
    if (!isfinite(degrees))
        buffer_char(buffer, '-');
    else if (turns == 0)
        buffer_format(buffer, "%.1f deg", degrees + 0.0);
    else {
        const char sign = rest < 0 ? '-' : '+';
        buffer_format(buffer, "%.0f turn%s %c %.1f deg", turns, fabs(turns) == 1 ? "" : "s", sign,
                      fabs(rest));
    }
}

/* Returns value rounded to a multiple of 10^index with at most 17 digits, trailing zeros kept:
 * 1.9370 for index -4. */
static struct decimal rounded_to_place(double value, int index)
{
    struct decimal d = rounded_to_digits(value, 17);
    const int digits = value != 0 ? decimal_decade(d) - index + 1 : 0;
    if (digits < 1) {
        bool rounds_up = digits == 0 && d.digits >= 50000000000000000u;
        return (struct decimal){d.negative && rounds_up, rounds_up,
                                rounds_up || index < 0 ? index : 0}; /* 0, not 00 */
    }
    d = rounded_to_digits(value, digits);
    for (; d.exponent > index; d.exponent--) /* 9.996 became 10.00 */
        d.digits *= 10;
    return d;
}

/* Appends "1.9373 +- 0.0002". The uncertainty decides the place of rounding, and both numbers share
 * plain or exponential notation. */
void buffer_uncertain(struct buffer *buffer, double value, double uncertainty)
{
    if (!isfinite(value) || !isfinite(uncertainty) || uncertainty <= 0) {
        buffer_short(buffer, value, 6);
        return;
    }
    const struct decimal two = rounded_to_digits(uncertainty, 2),
                         one = rounded_to_digits(uncertainty, 1);
    const int index = two.digits < 20 ? two.exponent : one.exponent - (one.digits == 1);
    const int decade_value = value != 0 ? decimal_decade(rounded_to_digits(value, 17)) : index;
    if (decade_value - index >= 17) { /* more exact than a double can be: nothing to match */
        buffer_real(buffer, value);
        buffer_put(buffer, TEXT(" +- "));
        buffer_short(buffer, uncertainty, 1 + (two.digits < 20));
        return;
    }
    const int decade_error = decimal_decade(one),
              decade = decade_value > decade_error ? decade_value : decade_error;
    const bool plain = decade >= -4 && decade < (index > 0 ? 6 : 15);
    const int high = plain ? 100 : 0, low = -high;
    char z[REAL_TEXT_SIZE];
    size_t len = decimal_write(rounded_to_place(value, index), low, high, z);
    buffer_put(buffer, (struct text){z, len});
    buffer_put(buffer, TEXT(" +- "));
    len = decimal_write(rounded_to_place(uncertainty, index), low, high, z);
    buffer_put(buffer, (struct text){z, len});
}

/* Appends value and uncertainty as 0.7231(4), or with six decimals if the uncertainty is too large,
 * too small or unknown. */
void buffer_parenthesis(struct buffer *output, double value, double uncertainty)
{
    const int decimals_max = 6;
    const int decimals = uncertainty > 0 && uncertainty < 9.5
                             ? (int)fmax(-floor(log10(uncertainty * 1.0526)), 0)
                             : decimals_max + 1;
    if (decimals > decimals_max) /* 1.0526: 9.5 rounds to 10 */
        buffer_format(output, "%.*f", decimals_max, value);
    else
        buffer_format(output, "%.*f(%.0f)", decimals, value, uncertainty * pow(10, decimals));
}
