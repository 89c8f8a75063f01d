/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Judges the ends of a series whose period is known (series_ends_as_inside()), at the cost of some
 * thousand rows for any length. */
#include <hooke/base/numeric.h>
#include "modules/recording/known/known.h"

#include <float.h>
#include <math.h>

enum {
    TERMS = 3,         /* offset, cosine, sine */
    WIDTH = TERMS + 1, /* width of a row of the normal equations, whose last column is the value */
    STRETCH_ROWS = 32, /* rows used of a stretch */
    /* Smallest number of rows of a stretch. */
    ROWS_MIN = 8,
    END_STRETCHES = 3, /* stretches compared with their neighbours */
    SIDE = 16,         /* stretches at each end */
    MIDDLE = 16,       /* stretches between them */
    ALL = 2 * SIDE + MIDDLE,
};

/* Fit of a sine of the known period to one stretch. */
struct stretch {
    double amplitude;
    double scale;   /* standard deviation of its residuals */
    double largest; /* largest residual */
    bool is_fitted;
};

/* Fits offset, cosine and sine of the angular frequency omega to the rows from time `begin` on for
 * `width` [s], thinned to STRETCH_ROWS. The result's is_fitted is false if there are too few
 * rows. */
static struct stretch fit_stretch(const struct series *s, double begin, double width, double omega)
{
    const size_t first = first_from(s->t, s->n, begin), end = first_from(s->t, s->n, begin + width),
                 each = (end - first) / STRETCH_ROWS + 1;
    double row[STRETCH_ROWS + 1][WIDTH], a[WIDTH * WIDTH] = {0}, *x = a + WIDTH * TERMS, square = 0;
    struct stretch result = {.is_fitted = false};
    size_t n = 0;
    for (size_t i = first; i < end; i += each) {
        const double angle = omega * (s->t[i] - begin),
                     r[WIDTH] = {1, cos(angle), sin(angle), s->y[i] - s->y[first]};
        for (int j = 0; j < WIDTH; j++) {
            row[n][j] = r[j];
            for (int k = 0; k <= j; k++)
                a[WIDTH * j + k] += r[j] * r[k];
        }
        n++;
    }
    if (n < ROWS_MIN || !matrix_cholesky(TERMS, WIDTH, a, 1e-6, a))
        return result;
    cholesky_forward(TERMS, WIDTH, a, x);
    cholesky_backward(TERMS, WIDTH, a, x);
    for (size_t i = 0; i < n; i++) {
        const double r = row[i][TERMS] - x[0] * row[i][0] - x[1] * row[i][1] - x[2] * row[i][2];
        square += r * r;
        result.largest = fmax(result.largest, fabs(r));
    }
    result.amplitude = hypot(x[1], x[2]);
    result.scale = sqrt(square / (double)(n - TERMS));
    result.is_fitted = true;
    return result;
}

/* Returns the median ratio of amplitudes from one stretch to the next, at most 1. */
static double usual_fall(const struct stretch *stretch, size_t n)
{
    double ratio[ALL];
    for (size_t k = 0; k + 1 < n; k++)
        ratio[k] = stretch[k + 1].amplitude / fmax(stretch[k].amplitude, DBL_MIN);
    return fmin(values_quantile(ratio, n - 1, 0.5), 1);
}

/* Returns true if the first stretches, counted from an end of the series, have the amplitudes and
 * residuals that their neighbours let expect. `fall` is the factor of the amplitude per stretch
 * towards that end, `loss` the relative change of the amplitude in a stretch, `scale` the typical
 * residual. */
static bool begins_as_it_continues(const struct stretch *stretch[SIDE], size_t n, double fall,
                                   double loss, double scale)
{
    static const double as_large = 0.75, clear = 1.25, rough_share = 0.2, rough = 3, far_off = 4.5,
                        harmless = 0.01;
    for (size_t k = 0; k < END_STRETCHES; k++) {
        const struct stretch *here = stretch[k];
        double expected = 0, factor = 1;
        for (size_t j = k + 1; j < n; j++) {
            factor *= fall;
            expected = fmax(expected, factor * stretch[j]->amplitude);
        }
        if (!(here->amplitude > as_large * expected) || !(here->amplitude > clear * here->scale) ||
            here->scale > fmax(rough_share * here->amplitude, rough * scale) ||
            here->largest > fmax(far_off * scale, (harmless + loss) * here->amplitude))
            return false;
    }
    return true;
}

/* Returns true if both ends of a series belong to the same free oscillation as its middle:
 * amplitudes and residuals of fitted stretches there are as expected. Returns false also for short
 * series. */
bool series_ends_as_inside(const struct series *s, double period)
{
    enum { STRETCHES_MIN = 4 + 2 * END_STRETCHES };
    const double span = s->t[s->n - 1] - s->t[0], step = span / (double)(s->n - 1),
                 width = period * ceil(ROWS_MIN * step / period),
                 last = s->t[s->n - 1] - width * (1 - 1e-9);
    const size_t all = span / width < ALL ? (size_t)(span / width) : ALL;
    struct stretch stretch[ALL];
    const struct stretch *begin[SIDE], *end[SIDE];
    double scale[ALL];
    if (!(period > 0) || all < STRETCHES_MIN)
        return false;
    const size_t side = all < 2 * SIDE ? all / 2 : SIDE;
    for (size_t k = 0; k < all; k++) {
        double t = s->t[0] + (double)k * width;
        if (k >= all - side)
            t = last - (double)(all - 1 - k) * width;
        else if (k >= side)
            t = s->t[0] + (span - width) * (double)k / (double)(all - 1);
        stretch[k] = fit_stretch(s, t, width, TWO_PI / period);
        if (!stretch[k].is_fitted)
            return false;
        scale[k] = stretch[k].scale;
    }
    for (size_t k = 0; k < side; k++) {
        begin[k] = &stretch[k];
        end[k] = &stretch[all - 1 - k];
    }
    const double fall[] = {usual_fall(stretch, side), usual_fall(stretch + all - side, side)},
                 typical = values_quantile(scale, all, 0.5);
    return begins_as_it_continues(begin, side, 1, -log(fall[0]), typical) &&
           begins_as_it_continues(end, side, fall[1], -log(fall[1]), typical);
}
