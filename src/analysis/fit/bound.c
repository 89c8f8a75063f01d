/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Bounds of parameters by a change of variables (James & Roos 1975, MINUIT): x = low + (high - low)
 * (1 + sin u)/2, or low - 1 + sqrt(u^2 + 1) in units of the start.
 */
#include "analysis/fit/least_squares.h"

#include <math.h>

double inside(const struct problem *p, int j, double u, double *slope)
{
    double low = p->low ? p->low[j] : -INFINITY, high = p->high ? p->high[j] : INFINITY,
           unit = p->unit[j];
    *slope = 1;
    if (isfinite(low) && isfinite(high)) {
        *slope = 0.5 * (high - low) * cos(u);
        return low + 0.5 * (high - low) * (1 + sin(u));
    }
    if (!isfinite(low) && !isfinite(high))
        return u;
    /* root - 1 without cancellation */
    double root = sqrt(1 + u * u), beyond = unit * u * u / (root + 1);
    *slope = isfinite(low) ? unit * u / root : -unit * u / root;
    return isfinite(low) ? low + beyond : high - beyond;
}

double outside(const struct problem *p, int j, double x)
{
    double low = p->low ? p->low[j] : -INFINITY, high = p->high ? p->high[j] : INFINITY,
           unit = p->unit[j];
    if (isfinite(low) && isfinite(high))
        return asin(fmin(fmax(2 * (x - low) / (high - low) - 1, -0.999), 0.999));
    if (!isfinite(low) && !isfinite(high))
        return x;
    double beyond = fmax(isfinite(low) ? x - low : high - x, 1e-6 * unit) / unit + 1;
    return sqrt((beyond - 1) * (beyond + 1));
}

bool on_bound(const struct problem *p, int j, double x, double *inward)
{
    double near = 1e-7 * p->unit[j];
    bool low = p->low && x - p->low[j] <= near, high = p->high && p->high[j] - x <= near;
    *inward = low ? 1 : -1;
    return low || high;
}
