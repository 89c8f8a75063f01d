/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/base/numeric.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_sort_double.h>
#include <gsl/gsl_statistics_double.h>
#include <string.h>

/* Keeps GSL from ending the program, which its default error handler does even where memory is out:
 * its functions return a status, NULL or NaN, which their callers check. */
__attribute__((constructor)) static void gsl_errors_return(void)
{
    gsl_set_error_handler_off();
}

double quantile(double *values, size_t n, double share)
{
    return n ? gsl_stats_select(values, 1, n, (size_t)(share * (double)(n - 1) + 0.5)) : NAN;
}

/* Two sorted runs, [0, middle) and [middle, n), into `out`. */
static bool merge(const double *in, size_t middle, size_t n, double *out,
                  const struct cancel *cancel)
{
    for (size_t i = 0, a = 0, b = middle; i < n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(cancel))
            return false;
        out[i] = b == n || (a < middle && in[a] <= in[b]) ? in[a++] : in[b++];
    }
    return true;
}

bool sort_values(double *values, size_t n, double *scratch, const struct cancel *cancel)
{
    const size_t middle = n / 2;
    if (cancelled(cancel))
        return false;
    if (n <= LOOK_EACH_ROWS) {
        gsl_sort(values, 1, n);
        return true;
    }
    if (!sort_values(values, middle, scratch, cancel) ||
        !sort_values(values + middle, n - middle, scratch, cancel))
        return false;
    memcpy(scratch, values, n * sizeof *values);
    return merge(scratch, middle, n, values, cancel);
}

size_t first_from(const double *ascending, size_t n, double x)
{
    size_t low = 0, high = n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (ascending[middle] < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

double random_fraction(uint64_t *state)
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

bool cholesky(int n, int width, const double *a, double independent, double *l)
{
    for (int i = 0; i < n; i++) {
        const double min = independent * a[i * width + i];
        for (int j = 0; j <= i; j++) {
            double sum = a[i * width + j];
            for (int k = 0; k < j; k++)
                sum -= l[i * width + k] * l[j * width + k];
            if (i == j && !(sum > min))
                return false;
            l[i * width + j] = i == j ? sqrt(sum) : sum / l[j * width + j];
        }
    }
    return true;
}

void cholesky_forward(int n, int width, const double *l, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= l[i * width + k] * x[k];
        x[i] /= l[i * width + i];
    }
}

void cholesky_backward(int n, int width, const double *l, double *x)
{
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= l[k * width + i] * x[k];
        x[i] /= l[i * width + i];
    }
}
