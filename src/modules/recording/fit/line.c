/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The straight line through measured points (line_fit(), declared in internal.h of series). */
#include "modules/recording/series/analysis.h"

#include <math.h>

/* Fits a straight line to n points by least squares, weighted if all have uncertainties; the line's
 * are widened by the scatter if that is larger. Returns false if no line is determined. */
bool line_fit(const double *x, const struct measured *y, int n, struct line_fit *fit)
{
    double w = 0, wx = 0, wy = 0, xx = 0, xy = 0;
    bool weighted = true;
    for (int i = 0; i < n; i++)
        weighted = weighted && y[i].uncertainty > 0;
    *fit = (struct line_fit){.freedom = n - 2};
    for (int i = 0; i < n; i++) {
        const double weight = weighted ? 1 / (y[i].uncertainty * y[i].uncertainty) : 1;
        w += weight;
        wx += weight * x[i];
        wy += weight * y[i].value;
    }
    const double mx = wx / w, my = wy / w;
    for (int i = 0; i < n; i++) {
        const double weight = weighted ? 1 / (y[i].uncertainty * y[i].uncertainty) : 1;
        xx += weight * (x[i] - mx) * (x[i] - mx);
        xy += weight * (x[i] - mx) * (y[i].value - my);
    }
    if (n < 2 || !(xx > 0))
        return false;
    const double slope = xy / xx;
    for (int i = 0; i < n; i++) {
        const double weight = weighted ? 1 / (y[i].uncertainty * y[i].uncertainty) : 1;
        const double r = y[i].value - my - slope * (x[i] - mx);
        fit->chi2 += weight * r * r;
    }
    const double scatter = fit->freedom > 0 ? fit->chi2 / fit->freedom : NAN;
    const double variance = weighted ? fmax(scatter, 1) : scatter; /* fmax passes NAN over */
    fit->slope = (struct measured){slope, sqrt(variance / xx)};
    fit->intercept = (struct measured){my - slope * mx, sqrt(variance * (1 / w + mx * mx / xx))};
    fit->covariance = -variance * mx / xx;
    return true;
}
