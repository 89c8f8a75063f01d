/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What only programs need that hooke has written; no part of hooke. */
#ifndef HOOKE_REPORT_PROGRAM_OWN_H
#define HOOKE_REPORT_PROGRAM_OWN_H

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* x^n by multiplications: n whole or half of that, |n| <= 16 */
static double power(double x, double n)
{
    const int whole = (int)fabs(n);
    int bit = 16;
    while (bit > whole)
        bit /= 2;
    double result = whole > 0 ? x : 1;
    while ((bit /= 2) > 0) {
        result *= result;
        if (whole & bit)
            result *= x;
    }
    if (fabs(n) > whole)
        result *= sqrt(x);
    return n < 0 ? 1 / result : result;
}

#endif
