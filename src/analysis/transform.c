/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The Fourier transform of real values in pieces, between which it can be ended. */
#include "analysis/internal.h"

#include <gsl/gsl_fft_real.h>
#include <math.h>

#define PIECE                                                                                      \
    ((size_t)1 << 17) /* values: some 5 ms, and what comes out is GSL's to the last bit            \
                       */
#define ROTATIONS 64  /* of a phase between two that are computed */

/* Of even and odd values, each half complex, that of all (Cooley and Tukey 1965). */
static bool combine(const double *even, const double *odd, size_t n, double *out,
                    const struct cancel *cancel)
{
    const size_t half = n / 2;
    const double angle = TWO_PI / (double)n, turn_c = cos(angle), turn_s = sin(angle);
    double c = 1, s = 0;
    out[0] = even[0] + odd[0];
    out[half] = even[0] - odd[0];
    out[half / 2] = even[half / 2];
    out[n - half / 2] = -odd[half / 2];
    for (size_t k = 1; k < half / 2; k++) {
        if (k % LOOK_EACH_ROWS == 0 && cancelled(cancel))
            return false;
        const double before = c;
        c = k % ROTATIONS ? c * turn_c - s * turn_s : cos(angle * (double)k);
        s = k % ROTATIONS ? before * turn_s + s * turn_c : sin(angle * (double)k);
        const double a = even[k], b = even[half - k];
        const double re = c * odd[k] + s * odd[half - k], im = c * odd[half - k] - s * odd[k];
        out[k] = a + re;
        out[n - k] = b + im;
        out[half - k] = a - re;
        out[half + k] = im - b;
    }
    return true;
}

bool transform_real(double *data, size_t n, double *scratch, const struct cancel *cancel)
{
    const size_t half = n / 2;
    if (cancelled(cancel))
        return false;
    if (n <= PIECE)
        return gsl_fft_real_radix2_transform(data, 1, n) == 0;
    for (size_t i = 0; i < half; i++) {
        scratch[i] = data[2 * i];
        scratch[half + i] = data[2 * i + 1];
    }
    return transform_real(scratch, half, data, cancel) &&
           transform_real(scratch + half, half, data, cancel) &&
           combine(scratch, scratch + half, n, data, cancel);
}
