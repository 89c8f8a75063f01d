/* SPDX-License-Identifier: GPL-3.0-or-later */
/* plain_number() reads the plain numbers that instruments write, faster than real_scan(). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Reads a number at `cursor`, after blanks, with at most 15 digits and an exponent down to -22: two
 * exact doubles and one rounding (Clinger 1990) give the same bits as real_scan(). Returns the end
 * of the number, or NULL for anything else, which real_scan() must read. */
static inline const char *plain_number(const char *cursor, const char *end, char decimal,
                                       double *value)
{
    static const double decimal_power10[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                             1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                             1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    while (cursor < end && *cursor == ' ')
        cursor++;
    const bool negative = cursor < end && *cursor == '-';
    const char *first = cursor += negative, *point = NULL;
    uint64_t digits = 0;
    for (; cursor < end; cursor++) {
        const unsigned digit = (unsigned)(*cursor - '0');
        if (digit < 10) {
            digits = 10 * digits + digit;
        } else if (*cursor == decimal && !point) {
            point = cursor;
        } else {
            break;
        }
    }
    const ptrdiff_t count = cursor - first - (point != NULL);
    ptrdiff_t exponent = point ? point + 1 - cursor : 0;
    if (count < 1 || count > 15)
        return NULL;
    if (cursor < end && (*cursor == 'E' || *cursor == 'e')) {
        const bool low = ++cursor < end && *cursor == '-';
        cursor += low;
        const unsigned digit = cursor < end ? (unsigned)(*cursor - '0') : 10;
        if (digit > 9 ||
            (++cursor < end && (unsigned)(*cursor - '0') < 10)) /* one digit is usual */
            return NULL;
        exponent += low ? -(ptrdiff_t)digit : (ptrdiff_t)digit;
        if (exponent < -22)
            return NULL;
    }
    const double size = exponent < 0 ? (double)digits / decimal_power10[-exponent]
                                     : (double)digits * decimal_power10[exponent];
    *value = negative ? -size : size;
    return cursor;
}
