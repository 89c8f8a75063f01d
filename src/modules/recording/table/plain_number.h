/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The fast way to read the numbers that instruments write. */
#ifndef HOOKE_MODULES_RECORDING_TABLE_PLAIN_NUMBER_H
#define HOOKE_MODULES_RECORDING_TABLE_PLAIN_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * A number of at most 15 digits at `at`, behind blanks, times 1e-22 or more: two exact doubles and
 * one rounding (Clinger 1990), the same bits as real_scan's. Returns its end, or NULL for anything
 * else, which the slow way reads.
 */
static inline const char *plain_number(const char *at, const char *end, char decimal, double *value)
{
    static const double decimal_power10[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                             1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                             1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    while (at < end && *at == ' ')
        at++;
    const bool negative = at < end && *at == '-';
    const char *first = at += negative, *point = NULL;
    uint64_t digits = 0;
    for (; at < end; at++) {
        const unsigned digit = (unsigned)(*at - '0');
        if (digit < 10) {
            digits = 10 * digits + digit;
        } else if (*at == decimal && !point) {
            point = at;
        } else {
            break;
        }
    }
    const ptrdiff_t count = at - first - (point != NULL);
    ptrdiff_t exponent = point ? point + 1 - at : 0;
    if (count < 1 || count > 15)
        return NULL;
    if (at < end && (*at == 'E' || *at == 'e')) {
        const bool low = ++at < end && *at == '-';
        at += low;
        const unsigned digit = at < end ? (unsigned)(*at - '0') : 10;
        if (digit > 9 || (++at < end && (unsigned)(*at - '0') < 10)) /* one digit is usual */
            return NULL;
        exponent += low ? -(ptrdiff_t)digit : (ptrdiff_t)digit;
        if (exponent < -22)
            return NULL;
    }
    const double size = exponent < 0 ? (double)digits / decimal_power10[-exponent]
                                     : (double)digits * decimal_power10[exponent];
    *value = negative ? -size : size;
    return at;
}

#endif
