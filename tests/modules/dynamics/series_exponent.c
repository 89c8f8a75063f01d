/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exponents and dimensions of series alone: of known attractors within their errors, of everything
 * else not at all. */
#include <hooke/base/cancel.h>

#include "cmocka_testing.h"

#include "long_form.h"

#include "modules/dynamics/series/series_exponent.h"
#include "modules/dynamics/series/space.h"

#include <math.h>
#include <string.h>

static uint64_t seed = 1;

static double normal(void)
{
    return sqrt(-2 * log(1 - random_fraction(&seed))) * cos(TWO_PI * random_fraction(&seed));
}

/* ---- series ---- */

#define MOST 20000

typedef void rates(double t, const double *y, double *f);

static void lorenz(double t, const double *y, double *f)
{
    (void)t;
    f[0] = 10 * (y[1] - y[0]);
    f[1] = y[0] * (28 - y[2]) - y[1];
    f[2] = y[0] * y[1] - 8.0 / 3 * y[2];
}

static void roessler(double t, const double *y, double *f)
{
    (void)t;
    f[0] = -y[1] - y[2];
    f[1] = y[0] + 0.2 * y[1];
    f[2] = 0.2 + y[2] * (y[0] - 5.7);
}

static void pendulum(double t, const double *y, double *f)
{
    f[0] = y[1];
    f[1] = -y[1] / 2 - sin(y[0]) + 1.5 * cos(2 * t / 3);
    f[2] = 0;
}

static void vanderpol(double t, const double *y, double *f)
{
    (void)t;
    f[0] = y[1];
    f[1] = (1 - y[0] * y[0]) * y[1] - y[0];
    f[2] = 0;
}

/* By rk4, after 100 s from a random start; noise: of the second rate [1/sqrt(s)]. */
static void flow(rates *rate, double dt, int which, double noise, size_t n, double *out)
{
    static const double share[] = {0, 0.5, 0.5, 1};
    const int steps = 6;
    const double h = dt / steps;
    double y[3], k[4][3], z[3];
    for (int i = 0; i < 3; i++)
        y[i] = 1 + random_fraction(&seed);
    const long skip = lround(100 / dt);
    for (long s = 0; s < (skip + (long)n) * steps; s++) {
        if (s % steps == 0 && s / steps >= skip)
            out[s / steps - skip] = y[which];
        for (int j = 0; j < 4; j++) {
            for (int i = 0; i < 3; i++)
                z[i] = y[i] + (j > 0 ? share[j] * h * k[j - 1][i] : 0);
            rate(((double)s + share[j]) * h, z, k[j]);
        }
        for (int i = 0; i < 3; i++)
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
        if (noise > 0)
            y[1] += noise * sqrt(h) * normal();
    }
}

static void henon(size_t n, double *out)
{
    double a = 0.1 * random_fraction(&seed), b = 0.1;
    for (size_t i = 0; i < n + 100; i++) {
        const double next = 1 - 1.4 * a * a + b;
        b = 0.3 * a;
        a = next;
        if (i >= 100)
            out[i - 100] = a;
    }
}

/* p times the value before, less q times the one before that, and noise */
static void autoregression(double p, double q, size_t n, double *out)
{
    double a = 0, b = 0;
    for (size_t i = 0; i < n + 1000; i++) {
        const double next = p * a - q * b + normal();
        b = a;
        a = next;
        if (i >= 1000)
            out[i - 1000] = a;
    }
}

static struct series_exponent analyse(const double *y, size_t n, double dt)
{
    static double t[MOST];
    struct series_exponent found;
    struct arena arena = {0};
    struct error error = {0};
    for (size_t i = 0; i < n; i++)
        t[i] = (double)i * dt;
    const struct series series = {t, y, n, QUANTITY_NUMBER, NULL, 0};
    if (!series_exponent(&series, &arena, &found, &error))
        fail_msg("%s", error.text);
    arena_reset(&arena);
    assert_true(found.determined == (found.reason[0] == '\0'));
    assert_true(found.determined == isfinite(found.value.value));
    return found;
}

/* ---- what is known ---- */

/* Exponents [1/s]: Sprott 2003, tables 4.1 and 5; the pendulum's by tangents. Dimensions:
 * correlation, Sprott 2003. */
static const struct {
    const char *name;
    rates *rate; /* NULL: the Henon map */
    double dt;
    int which;
    size_t n;
    double exponent, dimension;
} known[] = {{"Lorenz x", lorenz, 0.02, 0, 10000, 0.9056, 2.05},
             {"Lorenz z", lorenz, 0.05, 2, MOST, 0.9056, 2.05},
             {"Roessler x", roessler, 0.1, 0, 10000, 0.0714, 1.99},
             {"pendulum v", pendulum, 0.2, 1, MOST, 0.1125, NAN},
             {"Lorenz x, short", lorenz, 0.04, 0, 4000, 0.9056, 2.05},
             {"Henon", NULL, 1, 0, 3000, 0.4192, 1.22}};
#define QUICK 4 /* those from here on take no long time */

static struct series_exponent of_known(size_t k)
{
    static double y[MOST];
    if (known[k].rate)
        flow(known[k].rate, known[k].dt, known[k].which, 0, known[k].n, y);
    else
        henon(known[k].n, y);
    return analyse(y, known[k].n, known[k].dt);
}

/* Estimates the exponent of known systems from several starts: at most a tenth are beyond two
 * stated uncertainties, their deviations in units of these have an rms below 1.5, and the
 * uncertainty is below 30 % of the value. In the short form only the quick ones, from one start. */
TEST(test_known)
{
    const int starts = is_long() ? 40 : 1;
    for (size_t k = is_long() ? 0 : QUICK; k < COUNT_OF(known); k++) {
        double square = 0, mean = 0, error = 0;
        int count = 0, beyond = 0;
        for (int i = 0; i < starts; i++) {
            const struct series_exponent f = of_known(k);
            if (isfinite(f.dimension.value) && isfinite(known[k].dimension))
                assert_true(fabs(f.dimension.value - known[k].dimension) <
                            4 * f.dimension.uncertainty);
            if (!f.determined)
                continue;
            const double off = (f.value.value - known[k].exponent) / f.value.uncertainty;
            count++;
            square += off * off;
            mean += f.value.value;
            error += f.value.uncertainty;
            beyond += fabs(off) > 2;
            assert_true(f.growth >= EXPONENT_GROWTH);
            assert_true(f.value.uncertainty < 0.3 * known[k].exponent);
        }
        if (is_long())
            print_message("%s: %d of %d determined, %.4f +- %.4f, known %.4f, rms %.2f errors, "
                          "%d beyond 2\n",
                          known[k].name, count, starts, mean / count, error / count,
                          known[k].exponent, sqrt(square / count), beyond);
        assert_true(count > 0);
        assert_true(beyond <= (count + 9) / 10);
        assert_true(sqrt(square / count) < 1.5 || count == 0);
    }
}

/* ---- what has none ---- */

static void sines(size_t n, double second, double decay, double noise, double *y)
{
    for (size_t i = 0; i < n; i++)
        y[i] = exp(-decay * (double)i / (double)n) *
                   (sin(0.1 * (double)i) + second * sin(0.1 * sqrt(2) * (double)i)) +
               noise * normal();
}

static void refused(const char *what, const double *y, size_t n, const char *why)
{
    const struct series_exponent f = analyse(y, n, 0.1);
    if (f.determined)
        fail_msg("%s: %g +- %g", what, f.value.value, f.value.uncertainty);
    if (!strstr(f.reason, why))
        fail_msg("%s: %s", what, f.reason);
}

TEST(test_not_determined)
{
    static double y[MOST];
    const size_t n = is_long() ? 8000 : 2000;
    sines(n, 0, 0, 0, y);
    refused("sine", y, n, "noise, or sines");
    sines(n, 0, 0, 0.02, y);
    refused("noisy sine", y, n, "noise, or sines");
    sines(n, 0.7, 0, 0, y);
    refused("two sines", y, n, "noise, or sines");
    sines(n, 0, 3, 0, y);
    refused("damped sine", y, n, "the size of the motion changes");
    sines(n, 0, 0.3, 0, y);
    refused("sine, hardly damped", y, n, "noise, or sines");
    flow(vanderpol, 0.1, 0, 0, n, y);
    refused("limit cycle", y, n, "neighbours do not separate");
    const struct series_exponent cycle = analyse(y, n, 0.1);
    assert_false(fabs(cycle.dimension.value - 1) > 2 * cycle.dimension.uncertainty);
    flow(vanderpol, 0.1, 0, 0.1, n, y);
    refused("limit cycle with a noisy drive", y, n, "");
    for (size_t i = 0; i < n; i++)
        y[i] = normal();
    refused("white noise", y, n, "unfolds");
    autoregression(1.95, 0.96, n, y);
    refused("noise of a resonance", y, n, "noise");
    autoregression(0.95, 0, n, y);
    refused("red noise", y, n, "noise");
    for (size_t i = 1; i < n; i++)
        y[i] += y[i - 1];
    refused("drift", y, n, "");
    for (size_t i = 0; i < n; i++)
        y[i] = 3;
    refused("rest", y, n, "nothing moves");
    flow(lorenz, 0.02, 0, 0, n, y);
    refused("short", y, EXPONENT_SAMPLES - 1, "too few");
    refused("of few turns", y, 1000, "");
    for (size_t i = 0; i < n; i++)
        y[i] += 2 * normal();
    refused("Lorenz in noise", y, n, "");
}

/* No noise is taken for chaos, whatever its colour. */
TEST(test_noise)
{
    static double y[MOST];
    const int series = is_long() ? 300 : 4;
    for (int i = 0; i < series; i++) {
        const double radius = 0.5 + 0.495 * random_fraction(&seed),
                     angle = PI * random_fraction(&seed);
        const size_t n = 1000 + (size_t)((is_long() ? 3000 : 500) * random_fraction(&seed));
        autoregression(2 * radius * cos(angle), radius * radius, n, y);
        for (size_t k = 0; k < n && i % 3 == 1; k++)
            y[k] = exp(0.05 * y[k]); /* seen through a bent scale */
        for (size_t k = 2; k < n && i % 3 == 2; k++)
            y[n + 1 - k] = (y[n + 1 - k] + y[n - k] + y[n - 1 - k]) / 3;
        const struct series_exponent f = analyse(y, n, 1);
        if (f.determined)
            fail_msg("noise %d of radius %g, angle %g: %g +- %g", i, radius, angle, f.value.value,
                     f.value.uncertainty);
    }
}

/* ---- parts ---- */

TEST(test_neighbours)
{
    static double y[3000];
    struct arena arena = {0};
    flow(lorenz, 0.05, 0, 0, COUNT_OF(y), y);
    for (int dimensions = 1; dimensions <= 6; dimensions++) {
        struct delay_space s = {.y = y, .delay = 3, .dimensions = dimensions, .theiler_window = 20};
        s.points = COUNT_OF(y) - 3 * (size_t)(dimensions - 1);
        assert_true(space_sort(&s, COUNT_OF(y), &arena));
        for (size_t i = 0; i < s.points; i += 97) {
            struct neighbours near;
            space_nearest(&s, i, SPACE_NEAREST, &near);
            assert_int_equal(near.count, SPACE_NEAREST);
            size_t nearer = 0;
            for (size_t j = 0; j < s.points; j++)
                nearer += (j > i ? j - i : i - j) > s.theiler_window &&
                          space_distance2(&s, i, j) > 0 &&
                          space_distance2(&s, i, j) < near.square[SPACE_NEAREST - 1];
            assert_int_equal(nearer, SPACE_NEAREST - 1);
        }
    }
    arena_reset(&arena);
}

TEST(test_cancelled)
{
    static double t[MOST], y[MOST];
    struct arena arena = {0};
    struct error error = {0};
    struct series_exponent found;
    flow(lorenz, 0.02, 0, 0, MOST, y);
    for (size_t i = 0; i < MOST; i++)
        t[i] = 0.02 * (double)i;
    struct cancel cancel;
    atomic_init(&cancel.requested, 1);
    const struct series series = {t, y, MOST, QUANTITY_NUMBER, &cancel, 0};
    assert_false(series_exponent(&series, &arena, &found, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    arena_reset(&arena);
}

RUN_TESTS(NULL, NULL)
