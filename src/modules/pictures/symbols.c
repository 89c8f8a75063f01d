/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rewrites names, units and numbers from ASCII to UTF-8 as physics prints them: Greek letters,
 * subscripts, superscripts, minus signs. */
#include "modules/pictures/symbols.h"

#include <string.h>

#define CHAR_MINUS 0x2212
#define CHAR_TIMES 0xD7
#define CHAR_MIDDLE_DOT 0xB7
#define CHAR_MICRO 0xB5

static bool is_symbol_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* Appends digits and minus signs as superscripts; other characters are dropped. */
static void put_superscript(struct buffer *output, struct text digits)
{
    static const uint32_t superscript[] = {0x2070, 0xB9,   0xB2,   0xB3,   0x2074,
                                           0x2075, 0x2076, 0x2077, 0x2078, 0x2079};
    for (size_t i = 0; i < digits.len; i++)
        if (is_digit_char(digits.data[i]))
            buffer_codepoint(output, superscript[digits.data[i] - '0']);
        else if (digits.data[i] == '-')
            buffer_codepoint(output, 0x207B);
}

/* Returns the number of leading digits, after an optional sign if `sign` is set, or 0 if there
 * are none. */
static size_t digits_length(struct text text, bool sign)
{
    const size_t start = sign && text.len && (text.data[0] == '-' || text.data[0] == '+');
    size_t len = start;
    while (len < text.len && is_digit_char(text.data[len]))
        len++;
    return len > start ? len : 0;
}

/* ---- numbers ---- */

/* Returns the length of the exponent, such as "e-06", that the text begins with, or 0 if it begins
 * with none. Sets *power to its digits without leading zeros and *negative to whether it has a
 * minus sign; both are unchanged if the result is 0. */
static size_t exponent_length(struct text text, struct text *power, bool *negative)
{
    const size_t len =
        text.len > 1 && text.data[0] == 'e' ? digits_length(text_after(text, 1), true) : 0;
    if (!len || (1 + len < text.len && is_symbol_letter(text.data[1 + len])))
        return 0;
    *negative = text.data[1] == '-';
    *power = (struct text){text.data + 1, len};
    while (power->len > 1 && (!is_digit_char(power->data[0]) || power->data[0] == '0'))
        *power = text_after(*power, 1);
    return 1 + len;
}

/* Appends the number at the beginning of the text, with its exponent as a power of ten. Returns the
 * length of the number in the text. */
static size_t symbol_number_put(struct buffer *output, struct text text)
{
    size_t len = digits_length(text, false);
    struct text power;
    bool negative = false;
    if (len < text.len && text.data[len] == '.')
        len += 1 + digits_length(text_after(text, len + 1), false);
    const size_t exponent = exponent_length(text_after(text, len), &power, &negative);
    const bool unit = len == 1 && text.data[0] == '1'; /* 1e-6 is printed as 10⁻⁶ */
    if (!exponent || !unit)
        buffer_put(output, (struct text){text.data, len});
    if (exponent && !unit)
        buffer_codepoint(output, CHAR_TIMES);
    if (exponent)
        buffer_put(output, TEXT("10"));
    if (exponent && negative)
        put_superscript(output, TEXT("-"));
    if (exponent)
        put_superscript(output, power);
    return len + exponent;
}

/* Appends the number, sign or comparison at position i with symbols. Returns the number of
 * characters that it replaces, or 0 if there is none. */
static size_t put_arithmetic(struct buffer *output, struct text text, size_t i)
{
    const struct text rest = text_after(text, i);
    const char previous = i ? text.data[i - 1] : ' ';
    const bool is_separated = strchr(" ([,;:/=", previous) != NULL; /* a sign, not a hyphen */
    if (is_digit_char(rest.data[0]) && !is_symbol_letter(previous))
        return symbol_number_put(output, rest);
    if (rest.data[0] == '-' && is_separated &&
        (rest.len > 1 && (is_digit_char(rest.data[1]) || rest.data[1] == ' '))) {
        buffer_codepoint(output, CHAR_MINUS);
        return 1;
    }
    if (rest.len > 1 && (rest.data[0] == '<' || rest.data[0] == '>') && rest.data[1] == '=') {
        buffer_codepoint(output, rest.data[0] == '<' ? 0x2264 : 0x2265);
        return 2;
    }
    if (rest.len > 1 && rest.data[0] == '+' && rest.data[1] == '-') {
        buffer_codepoint(output, 0xB1);
        return 2;
    }
    return 0;
}

/* Copies the text, and replaces numbers and signs by symbols. */
void put_number_symbols(struct buffer *output, struct text text)
{
    for (size_t i = 0; i < text.len;) {
        const size_t used = put_arithmetic(output, text, i);
        if (!used)
            buffer_char(output, text.data[i]);
        i += used ? used : 1;
    }
}

/* ---- names ---- */

/* Returns the code point of the Greek letter with this name, or 0 if there is none. */
static uint32_t greek_letter(struct text name)
{
    static const struct {
        const char *name;
        uint32_t letter;
    } letters[] = {{"alpha", 0x3B1},   {"beta", 0x3B2},   {"gamma", 0x3B3}, {"delta", 0x3B4},
                   {"epsilon", 0x3B5}, {"zeta", 0x3B6},   {"eta", 0x3B7},   {"theta", 0x3B8},
                   {"kappa", 0x3BA},   {"lambda", 0x3BB}, {"mu", 0x3BC},    {"nu", 0x3BD},
                   {"xi", 0x3BE},      {"pi", 0x3C0},     {"rho", 0x3C1},   {"sigma", 0x3C3},
                   {"tau", 0x3C4},     {"phi", 0x3C6},    {"chi", 0x3C7},   {"psi", 0x3C8},
                   {"omega", 0x3C9},   {"Gamma", 0x393},  {"Delta", 0x394}, {"Omega", 0x3A9}};
    for (size_t i = 0; i < COUNT_OF(letters); i++)
        if (text_is(name, letters[i].name))
            return letters[i].letter;
    return 0;
}

/* Appends the word at the beginning of the text, with its digits as subscripts if it is a Greek
 * letter or a single letter. Returns the length of word and digits. */
static size_t symbol_name_put(struct buffer *output, struct text rest)
{
    size_t letters = 0;
    while (letters < rest.len && is_symbol_letter(rest.data[letters]))
        letters++;
    const size_t digits = digits_length(text_after(rest, letters), false), len = letters + digits;
    const bool ends =
        len == rest.len || (!is_symbol_letter(rest.data[len]) && rest.data[len] != '_');
    const uint32_t letter = greek_letter((struct text){rest.data, letters});
    if (!ends || (!letter && letters > 1)) {
        buffer_put(output, (struct text){rest.data, len});
        return len;
    }
    if (letter)
        buffer_codepoint(output, letter);
    else
        buffer_char(output, rest.data[0]);
    for (size_t i = letters; i < len; i++)
        buffer_codepoint(output, 0x2080 + (uint32_t)(rest.data[i] - '0'));
    return len;
}

/* Appends a name or formula with symbols: Greek letters, subscripts, powers, middle dots for *,
 * minus signs. */
void put_name_symbols(struct buffer *output, struct text name)
{
    for (size_t i = 0; i < name.len;) {
        const struct text rest = text_after(name, i);
        /* a word begins here: not inside an identifier such as x_max */
        const bool word =
            is_symbol_letter(rest.data[0]) &&
            (i == 0 || (name.data[i - 1] != '_' && (unsigned char)name.data[i - 1] < 128));
        const size_t power = rest.data[0] == '^' ? digits_length(text_after(rest, 1), true) : 0;
        size_t used = word ? symbol_name_put(output, rest) : put_arithmetic(output, name, i);
        if (!used && power) {
            put_superscript(output, (struct text){rest.data + 1, power});
            used = 1 + power;
        }
        if (!used && rest.data[0] == '*') {
            buffer_codepoint(output, CHAR_MIDDLE_DOT);
            used = 1;
        }
        if (!used)
            buffer_char(output, rest.data[0]);
        i += used ? used : 1;
    }
}

/* ---- units ---- */

/* Appends the symbol of one unit without its power: µm for "um", ° for "deg". */
static void put_unit_name(struct buffer *output, struct text name)
{
    if (text_is(name, "deg"))
        buffer_codepoint(output, 0xB0);
    else if (text_is(name, "ohm"))
        buffer_codepoint(output, 0x3A9);
    else if (name.len > 1 && name.data[0] == 'u' && strchr("msgJVANW", name.data[1])) {
        buffer_codepoint(output, CHAR_MICRO);
        buffer_put(output, text_after(name, 1));
    } else {
        buffer_put(output, name);
    }
}

/* Appends a unit such as "m/s^2" with symbols, m·s⁻². Units are joined by middle dots; those behind
 * "/" get negative powers. */
void put_unit_symbols(struct buffer *output, struct text unit)
{
    const size_t old_len = output->len;
    bool in_denominator = false; /* true behind the first '/' */
    for (size_t i = 0; i < unit.len;) {
        size_t len = 0;
        while (i + len < unit.len && !strchr("*/ ^()", unit.data[i + len]))
            len++;
        const struct text name = {unit.data + i, len};
        const struct text remaining = text_after(unit, i + len);
        const size_t power = remaining.len && remaining.data[0] == '^'
                                 ? digits_length(text_after(remaining, 1), true)
                                 : 0;
        if (len && !text_is(name, "1")) {
            if (output->len > old_len)
                buffer_codepoint(output, CHAR_MIDDLE_DOT);
            put_unit_name(output, name);
            const struct text digits = {remaining.data + 1, power};
            const bool negative = power && digits.data[0] == '-';
            if (in_denominator && !negative)
                put_superscript(output, TEXT("-"));
            if (power)
                put_superscript(output,
                                in_denominator && negative ? text_after(digits, 1) : digits);
            else if (in_denominator)
                put_superscript(output, TEXT("1"));
        }
        i += len + (power ? 1 + power : 0);
        if (i < unit.len) {
            in_denominator |= unit.data[i] == '/';
            i += power == 0 || strchr("*/ ()^", unit.data[i]) ? 1 : 0;
        }
    }
}
