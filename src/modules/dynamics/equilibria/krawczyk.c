/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "modules/dynamics/equilibria/krawczyk.h"

#include <math.h>

#include "modules/dynamics/orbits/field.h"

#define SHRUNK 0.7 /* of the widest side: worth another look before it is cut */

static double middle(struct interval a)
{
    return a.lo + (a.hi - a.lo) / 2;
}

/* An approximate inverse of the middle of the bounds; false: singular. */
static bool invert(int n, const struct interval *by, double *inverse)
{
    for (int column = 0; column < n; column++) {
        double a[FIELD_VARIABLES * FIELD_VARIABLES], unit[FIELD_VARIABLES] = {0};
        for (int i = 0; i < n * n; i++)
            a[i] = middle(by[i]);
        unit[column] = 1;
        if (!matrix_solve(n, a, unit))
            return false;
        for (int i = 0; i < n; i++)
            inverse[i * n + column] = unit[i];
    }
    return true;
}

static struct interval product(double factor, struct interval a)
{
    const double lo = factor * (factor < 0 ? a.hi : a.lo), hi = factor * (factor < 0 ? a.lo : a.hi);
    if (factor == 0)
        return (struct interval){0, 0};
    return (struct interval){nextafter(lo, -HUGE_VAL), nextafter(hi, HUGE_VAL)};
}

static struct interval sum(struct interval a, struct interval b)
{
    return (struct interval){nextafter(a.lo + b.lo, -HUGE_VAL), nextafter(a.hi + b.hi, HUGE_VAL)};
}

static struct interval times(struct interval a, struct interval b)
{
    const double p[] = {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
    struct interval out = {p[0], p[0]};
    for (int i = 1; i < 4; i++) {
        out.lo = fmin(out.lo, p[i]);
        out.hi = fmax(out.hi, p[i]);
    }
    return (struct interval){nextafter(out.lo, -HUGE_VAL), nextafter(out.hi, HUGE_VAL)};
}

/* Half the width that rounding of f(m) alone gives the operator in direction i. */
static double rounding_of(int n, const double *inverse, const struct interval *rate, int i)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += fabs(inverse[i * n + j]) * (rate[j].hi - rate[j].lo) / 2;
    return sum;
}

enum verdict krawczyk(const struct system *bounded, struct interval *box, const struct interval *by,
                      double *rounding)
{
    const int n = bounded->n;
    double inverse[FIELD_VARIABLES * FIELD_VARIABLES];
    struct interval at[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES], k[FIELD_VARIABLES];
    for (int i = 0; rounding && i < n; i++)
        rounding[i] = 0;
    if (!invert(n, by, inverse))
        return UNKNOWN;
    for (int i = 0; i < n; i++)
        at[i].lo = at[i].hi = middle(box[i]);
    system_bounds(bounded, at, rate, NULL);
    bool inside = true, smaller = false;
    for (int i = 0; i < n; i++) {
        if (rounding)
            rounding[i] = rounding_of(n, inverse, rate, i);
        k[i] = at[i];
        for (int j = 0; j < n; j++)
            k[i] = sum(k[i], product(-inverse[i * n + j], rate[j]));
        for (int j = 0; j < n; j++) {
            struct interval rest = {i == j, i == j};
            for (int l = 0; l < n; l++)
                rest = sum(rest, product(-inverse[i * n + l], by[l * n + j]));
            k[i] = sum(k[i], times(rest, sum(box[j], (struct interval){-at[j].lo, -at[j].lo})));
        }
        if (!(k[i].lo <= k[i].hi) || !isfinite(k[i].lo) || !isfinite(k[i].hi))
            return UNKNOWN;
        if (k[i].lo > box[i].hi || k[i].hi < box[i].lo)
            return NONE;
        inside = inside && k[i].lo > box[i].lo && k[i].hi < box[i].hi;
    }
    for (int i = 0; i < n; i++) {
        const double before = box[i].hi - box[i].lo;
        box[i].lo = fmax(box[i].lo, k[i].lo);
        box[i].hi = fmin(box[i].hi, k[i].hi);
        smaller = smaller || box[i].hi - box[i].lo < SHRUNK * before;
    }
    return inside ? ONE : smaller ? SMALLER : UNKNOWN;
}
