/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Statistics of repeated measurements (repeat_values() in fit.h): whether their stated
 * uncertainties explain the scatter, and the value to quote. Birge, Phys. Rev. 40 (1932) 207; Paule
 * & Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377. */
#include "modules/recording/series/internal.h"

#include <gsl/gsl_cdf.h>
#include <math.h>

/* Relative rounding; a smaller uncertainty counts as not stated. */
#define VALUE_ROUNDING_RELATIVE 1e-9

/* Sets *mean to the weighted mean with `sigma_between` added in quadrature to each stated
 * uncertainty. Returns the sum of squares in units of these. */
static double weighted_mean_with(const struct measured *x, int n, double sigma_between,
                                 struct measured *mean)
{
    double w = 0, wx = 0, square = 0;
    for (int i = 0; i < n; i++) {
        const double weight =
            1 / (x[i].uncertainty * x[i].uncertainty + sigma_between * sigma_between);
        w += weight;
        wx += weight * x[i].value;
    }
    *mean = (struct measured){wx / w, 1 / sqrt(w)};
    for (int i = 0; i < n; i++) {
        const double deviation = x[i].value - mean->value;
        square += deviation * deviation /
                  (x[i].uncertainty * x[i].uncertainty + sigma_between * sigma_between);
    }
    return square;
}

/* Returns the standard deviation that has to be added to the uncertainties of x [n] so that the
 * weighted sum of squares becomes n - 1, or 0 if the sum is not larger without it. Found by
 * bisection, starting from `scatter`, the standard deviation of the values, as the sum falls with
 * it. */
static double scatter_between(const struct measured *x, int n, double scatter)
{
    struct measured mean;
    double low = 0, high = 2 * scatter * sqrt(n);
    if (!(weighted_mean_with(x, n, 0, &mean) > n - 1))
        return 0;
    for (int i = 0; i < 100; i++) {
        const double middle = 0.5 * (low + high);
        *(weighted_mean_with(x, n, middle, &mean) > n - 1 ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

/* Computes in *r the statistics of n values: plain and weighted mean, Birge ratio, and the scatter
 * beyond the stated uncertainties (Paule and Mandel). Returns false for fewer than two. */
bool repeat_values(const struct measured *x, int n, struct repeat *r)
{
    double sum = 0, square = 0;
    bool stated = true;
    *r = (struct repeat){
        .n = n, .birge = NAN, .chance = NAN, .excess_scatter = NAN, .weighted = {NAN, NAN}};
    for (int i = 0; i < n; i++) {
        sum += x[i].value;
        stated &= x[i].uncertainty > VALUE_ROUNDING_RELATIVE * fabs(x[i].value);
    }
    if (n < 2)
        return false;
    r->mean.value = sum / n;
    for (int i = 0; i < n; i++)
        square += (x[i].value - r->mean.value) * (x[i].value - r->mean.value);
    r->scatter = sqrt(square / (n - 1));
    r->mean.uncertainty = r->scatter / sqrt(n);
    r->quote = r->mean;
    if (stated) {
        const double chi2 = weighted_mean_with(x, n, 0, &r->weighted);
        r->birge = sqrt(chi2 / (n - 1));
        r->chance = gsl_cdf_chisq_Q(chi2, n - 1);
        r->excess_scatter = scatter_between(x, n, r->scatter);
        weighted_mean_with(x, n, r->excess_scatter, &r->quote);
    }
    r->interval = gsl_cdf_tdist_Pinv(0.975, n - 1) * r->quote.uncertainty;
    return true;
}
