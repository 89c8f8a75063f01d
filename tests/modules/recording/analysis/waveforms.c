/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The period of what is no single damped sine: waves of any shape, step responses, swings with a
 * knock before or a hand after them. The truth is a closed form, or crossings by another
 * integration.
 */
#include <stdio.h>
#include <string.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/detect_recordings.h"

#include <gsl/gsl_sf_ellint.h>
#include <gsl/gsl_sf_elljac.h>

static int cases(int quick)
{
    return is_long() ? 10 * quick : quick;
}

struct tally {
    int wrong, silent, refused, all;
};

/* Reads the period and counts it as wrong where it is off by more than `tolerance`, silent where
 * nothing is said about that. */
static void count_period(struct drawn *d, double tolerance, const char *name, struct tally *tally)
{
    const struct series series = {.t = d->t, .y = d->y, .n = d->n, .quantity = QUANTITY_LENGTH};
    struct period p = {.period = {NAN, NAN}};
    struct arena arena = {0};
    struct error error = {0};
    tally->all++;
    if (!series_period(&series, &arena, &p, &error)) {
        tally->refused++;
        print_message("%s T %g (%g periods, %zu samples): %s\n", name, d->period,
                      d->span / d->period, d->n, error.text);
    } else if (!(fabs(p.period.value / d->period - 1) <= tolerance)) {
        tally->wrong++;
        tally->silent += !p.warning[0];
        print_message("%s T %.8g read as %.8g +- %.2g (%g periods, %zu samples, %s) %s\n", name,
                      d->period, p.period.value, p.period.uncertainty, d->span / d->period, d->n,
                      p.how, p.warning);
    }
    arena_reset(&arena);
    free(d->t);
    free(d->y);
}

/* Nothing is wrong without a word (but undersampled pulses, one in a hundred), and hardly anything
 * wrong or refused. */
static void assert_tally(const char *name, const struct tally *t)
{
    print_message("%s: %d of %d wrong (%d silent), %d refused\n", name, t->wrong, t->all, t->silent,
                  t->refused);
    assert_true(100 * t->silent <= t->all);
    assert_true(50 * (t->wrong + t->refused) <= t->all + 25);
}

/* ---- pendulums: theta = 2 asin(k sn(K - omega0 t, k)), T = 4 K(k)/omega0 ---- */

static struct drawn pendulum(double amplitude, double periods, double samples, double sigma)
{
    const double omega0 = sqrt(9.81), k = sin(0.5 * amplitude),
                 quarter = gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE), period = 4 * quarter / omega0;
    struct drawn d = draw((size_t)(periods * samples), samples / period);
    d.period = period;
    for (size_t i = 0; i < d.n; i++) {
        double sn, cn, dn;
        gsl_sf_elljac_e(quarter - omega0 * d.t[i], k * k, &sn, &cn, &dn);
        d.y[i] = 2 * asin(k * sn);
    }
    add_noise(&d, sigma);
    return d;
}

TEST(pendulums_up_to_the_top)
{
    struct tally clean = {0}, noisy = {0};
    random_state = 171;
    for (int i = 0; i < cases(30); i++) {
        const double degrees = i % 2 ? 180 - of_random_size(0.01, 20) : random_between(1, 179);
        struct drawn d =
            pendulum(degrees * PI / 180, random_between(3.2, 25), of_random_size(60, 1500), 0);
        char name[40];
        snprintf(name, sizeof name, "pendulum %.5g", degrees);
        count_period(&d, 1e-5, name, &clean);
        d = pendulum(degrees * PI / 180, random_between(3.2, 25), of_random_size(60, 500),
                     of_random_size(1e-3, 0.05) * degrees * PI / 180);
        count_period(&d, 0.01, name, &noisy);
    }
    assert_tally("pendulums", &clean);
    assert_tally("noisy pendulums", &noisy);
}

/* ---- pulse trains and other shapes ---- */

static double wave_shape(int shape, double phase, double sharp)
{
    const double x = phase - floor(phase);
    switch (shape) {
    case 0:
        return exp(10 * sharp * (cos(2 * PI * x) - 1)); /* narrow pulses */
    case 1:
        return x; /* a sawtooth */
    case 2:
        return x < 0.2 + 0.3 * sharp / 6 ? 1 : 0; /* rectangles */
    case 3:
        return exp(-x * sharp); /* loaded at once, drained slowly */
    case 4:
        return fmax(sin(2 * PI * x), 0); /* half a wave */
    case 5:
        return tanh(sharp * sin(2 * PI * x)) + 0.3 * cos(2 * PI * x); /* relaxation */
    case 6: /* two pulses a period, of different height */
        return exp(10 * sharp * (cos(2 * PI * x) - 1)) +
               0.7 * exp(10 * sharp * (cos(2 * PI * (x - 0.5)) - 1));
    case 7: /* a strong third harmonic */
        return 0.5 * cos(2 * PI * x) + cos(6 * PI * x) + 0.2 * sin(10 * PI * x);
    default: /* pulse, undershoot, wave: a heart beat */
        return exp(-0.5 * pow((x - 0.3) / 0.015, 2)) -
               0.25 * exp(-0.5 * pow((x - 0.34) / 0.02, 2)) +
               0.25 * exp(-0.5 * pow((x - 0.6) / 0.05, 2));
    }
}

enum { SHAPES = 9 };

TEST(waves_of_any_shape)
{
    struct tally tally = {0};
    random_state = 172;
    for (int i = 0; i < cases(63); i++) {
        const double periods = random_between(4, 40),
                     samples = of_random_size(i % SHAPES == 8 ? 60 : 30, 200),
                     sharp = random_between(1, 6), phase = random_uniform(),
                     sigma = i % 3 ? of_random_size(1e-3, 0.1) : 0;
        struct drawn d = draw((size_t)(periods * samples), 50);
        d.period = samples / 50;
        for (size_t k = 0; k < d.n; k++)
            d.y[k] = wave_shape(i % SHAPES, d.t[k] / d.period + phase, sharp);
        add_noise(&d, sigma);
        char name[60];
        snprintf(name, sizeof name, "shape %d sharp %.3g noise %.2g", i % SHAPES, sharp, sigma);
        count_period(&d, 0.005, name, &tally);
    }
    assert_tally("waves", &tally);
}

/* Pulses of one or two samples and of two heights are taken for what they are, wherever they fall
 * between samples. */
TEST(pulses_of_few_samples)
{
    struct tally tally = {0};
    random_state = 177;
    for (int i = 0; i < cases(40); i++) {
        const double samples = floor(random_between(14, 22)) + random_between(0.48, 0.52),
                     width = random_between(0.8, 1) / samples, phase = random_uniform(),
                     small = random_between(0.65, 0.75);
        struct drawn d = draw((size_t)(random_between(15, 35) * samples), 30);
        d.period = samples / 30;
        for (size_t k = 0; k < d.n; k++) {
            const double x = remainder(d.t[k] / d.period + phase, 1),
                         half = remainder(d.t[k] / d.period + phase - 0.5, 1);
            d.y[k] = exp(-pow(x / width, 2)) + small * exp(-pow(half / width, 2));
        }
        add_noise(&d, 0.01);
        char name[60];
        snprintf(name, sizeof name, "pulses of width %.3g, 1 and %.3g", width, small);
        count_period(&d, 0.005, name, &tally);
    }
    assert_tally("pulses", &tally);
}

/* Pulses with edges are not taken for several by where their edges fall between samples. */
TEST(pulses_with_edges)
{
    struct tally tally = {0};
    random_state = 185;
    for (int i = 0; i < cases(60); i++) {
        const bool known = i % 3 == 0; /* a recording of old: pulses of 15 % in 40 cycles */
        const double samples = known ? 2000 / 40.2 : of_random_size(30, 300) + 0.5 * (i % 2),
                     width = known ? 0.15 : random_between(0.05, 0.4), phase = random_uniform();
        struct drawn d = draw((size_t)((known ? 40.2 : random_between(10, 40)) * samples), 100);
        d.period = samples / 100;
        for (size_t k = 0; k < d.n; k++) {
            const double x = d.t[k] / d.period + phase;
            d.y[k] = x - floor(x) < width;
        }
        add_noise(&d, known ? 0.02 : of_random_size(3e-3, 0.05));
        char name[60];
        snprintf(name, sizeof name, "edges %.3g apart", width);
        count_period(&d, 0.003, name, &tally);
    }
    assert_tally("pulses with edges", &tally);
}

/* A line near a third of the frequency, as of a load that also swings, makes no period of three. */
TEST(lines_near_a_third)
{
    struct tally tally = {0};
    random_state = 186;
    for (int i = 0; i < cases(30); i++) {
        const double samples = random_between(15, 25), cycles = random_between(20, 30),
                     slow = random_between(0.335, 0.345), angle = random_between(0, 2 * PI);
        struct drawn d = draw((size_t)(cycles * samples), 40);
        d.period = samples / 40;
        for (size_t k = 0; k < d.n; k++) {
            const double x = 2 * PI * d.t[k] / d.period;
            d.y[k] = exp(-0.02 * x / PI) * cos(x) + 0.025 * cos(slow * x + angle);
        }
        add_noise(&d, 0.015);
        count_period(&d, 0.01, "line near a third", &tally);
    }
    assert_tally("lines near a third", &tally);
}

/* Waves whose successive cycles differ a little: pulses of two heights in turn, a weak line at half
 * or a third of the strongest frequency. The period is that after which they repeat. */
TEST(cycles_that_differ_in_turn)
{
    struct tally tally = {0};
    random_state = 182;
    for (int i = 0; i < cases(60); i++) {
        const int n = i % 3 == 2 ? 3 : 2;
        const double cycles = random_between(n == 3 ? 18 : 15, 60),
                     samples = of_random_size(20, 150), phase = random_uniform(),
                     width = random_between(0.04, 0.12), small = random_between(0.9, 0.95),
                     line = random_between(0.02, 0.05), angle = random_between(0, 2 * PI);
        struct drawn d = draw((size_t)(cycles * samples), 40);
        d.period = n * samples / 40;
        for (size_t k = 0; k < d.n; k++) {
            const double x = n * d.t[k] / d.period + phase, near = remainder(x, 1);
            const double height = fmod(floor(x + 0.5), 2) == 0 ? 1 : small;
            d.y[k] = i % 3 == 0 ? height * exp(-0.5 * pow(near / width, 2))
                                : sin(2 * PI * x) + line * sin(2 * PI * x / n + angle);
        }
        add_noise(&d, i % 4 ? of_random_size(1e-4, 5e-3) : 0);
        char name[60];
        snprintf(name, sizeof name, "cycles that differ, of %d", n);
        count_period(&d, 1e-3, name, &tally);
    }
    assert_tally("differing cycles", &tally);
}

/* The lines of narrow pulses have the amplitudes of their Fourier series: no pulse is left out. */
TEST(spectra_of_narrow_pulses)
{
    random_state = 183;
    for (int i = 0; i < cases(30); i++) {
        const double samples = of_random_size(60, 300), width = random_between(1.5, 6) / samples,
                     phase = random_uniform();
        struct drawn d = draw((size_t)(random_between(9, 30) * samples), 100);
        d.period = samples / 100;
        for (size_t k = 0; k < d.n; k++)
            d.y[k] = exp(-0.5 * pow(remainder(d.t[k] / d.period + phase, 1) / width, 2));
        add_noise(&d, i % 3 ? of_random_size(1e-3, 0.02) : 0);
        const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
        struct spectrum_peak peak[1] = {{.amplitude = {NAN, NAN}}};
        struct arena arena = {0};
        const int count = series_peaks(&series, &arena, peak, 1);
        const double harmonic = nearbyint(peak[0].frequency.value * d.period),
                     right = 2 * sqrt(2 * PI) * width * exp(-2 * pow(PI * width * harmonic, 2));
        if (count != 1 || !(fabs(peak[0].amplitude.value / right - 1) < 0.15))
            fail_msg("pulses of width %.3g, %.4g samples a period: line %g has %.4g, right %.4g",
                     width, samples, harmonic, peak[0].amplitude.value, right);
        arena_reset(&arena);
        free(d.t);
        free(d.y);
    }
}

/* The uncertainty of a wave with edges or unequal flanks holds. */
TEST(uncertainties_of_waves)
{
    int beyond = 0, all = 0;
    random_state = 178;
    for (int i = 0; i < cases(60); i++, all++) {
        const double samples = floor(random_between(25, 50)) + random_between(-0.1, 0.1),
                     rise = random_between(0.75, 0.9), phase = random_uniform();
        struct drawn d = draw((size_t)(random_between(12, 28) * samples), 40);
        d.period = samples / 40;
        for (size_t k = 0; k < d.n; k++) {
            const double x = d.t[k] / d.period + phase - floor(d.t[k] / d.period + phase);
            d.y[k] = i % 2 ? x < 0.5 : x < rise ? x / rise : (1 - x) / (1 - rise);
        }
        add_noise(&d, of_random_size(1e-3, 0.005));
        const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
        struct period p = {.period = {NAN, NAN}};
        struct arena arena = {0};
        struct error error = {0};
        if (!series_period(&series, &arena, &p, &error) ||
            !(fabs(p.period.value - d.period) < 4 * p.period.uncertainty + 1e-6 * d.period)) {
            beyond++;
            print_message("%s T %.8g read as %.8g +- %.2g (%s)\n", i % 2 ? "square" : "triangle",
                          d.period, p.period.value, p.period.uncertainty, p.how);
        }
        arena_reset(&arena);
        free(d.t);
        free(d.y);
    }
    print_message("%d of %d periods beyond 4 standard uncertainties\n", beyond, all);
    assert_true(50 * beyond <= all);
}

/* ---- rows of stiff runs ---- */

/* A relaxation oscillation as a stiff method records it: long steps on the slow branches, from 2 to
 * 1, and most rows in the jumps. The first two cycles take another time, as a start off the cycle
 * does.
 */
static struct drawn relaxation(size_t cycles, size_t slow, size_t fast, double jump, double longer)
{
    struct drawn d = draw(2 * cycles * (slow + fast), 1);
    const double half = random_between(1, 50);
    size_t n = 0;
    double t = 0;
    for (size_t k = 0; k < 2 * cycles; k++) {
        const double sign = k % 2 ? -1 : 1, lasts = half * (k < 4 ? longer : 1);
        for (size_t i = 0; i < slow; i++, n++) {
            const double u = ((double)i + 0.1 * random_uniform()) / (double)slow;
            d.t[n] = t + (1 - jump) * lasts * u;
            d.y[n] = sign * (1 + sqrt(1 - u));
        }
        for (size_t i = 0; i < fast; i++, n++) {
            const double u = ((double)i + 0.5 * random_uniform()) / (double)fast;
            d.t[n] = t + (1 - jump + jump * u) * lasts;
            d.y[n] = sign * (1 - 3 * u * u * (3 - 2 * u));
        }
        t += lasts;
    }
    d.period = 2 * half;
    d.span = t;
    return d;
}

TEST(stiff_runs)
{
    struct tally tally = {0};
    random_state = 179;
    for (int i = 0; i < cases(40); i++) {
        const size_t slow = (size_t)of_random_size(20, 100), fast = (size_t)of_random_size(60, 400);
        const double jump = of_random_size(1e-5, 1e-2),
                     longer = i % 2 ? 1 + (i % 4 - 2) * random_between(0.03, 0.1) : 1;
        struct drawn d = relaxation((size_t)random_between(10, 24), slow, fast, jump, longer);
        char name[60];
        snprintf(name, sizeof name, "jumps of %.2g, %zu and %zu rows", jump, slow, fast);
        count_period(&d, 1e-4, name, &tally);
    }
    assert_tally("stiff runs", &tally);
}

/* ---- a part that swings ---- */

static struct drawn ring_down(double before, double swings, double after, double zeta,
                              double samples, double level, double sigma)
{
    const size_t n = (size_t)((before + swings + after) * samples);
    struct drawn d = draw(n, 50);
    d.period = samples / 50;
    const double omega = 2 * PI / d.period, start = before * d.period,
                 end = (before + swings) * d.period, decay = zeta / sqrt(1 - zeta * zeta) * omega;
    for (size_t i = 0; i < n; i++) {
        const double s = d.t[i] - start;
        if (d.t[i] < start)
            d.y[i] = level;
        else if (d.t[i] < end)
            d.y[i] = exp(-decay * s) * (cos(omega * s) + decay / omega * sin(omega * s));
    }
    add_noise(&d, sigma);
    return d;
}

/* Damped oscillations begin at a step from a constant level. A period that is off by more than 2 %
 * counts as wrong. */
TEST(step_responses)
{
    struct tally tally = {0};
    random_state = 173;
    for (int i = 0; i < cases(40); i++) {
        const double zeta = of_random_size(0.02, 0.4), lasts = fmin(2.3 / (2 * PI * zeta), 20);
        struct drawn d = ring_down(random_between(0.5, 15), fmax(3 * lasts, 3), 0, zeta,
                                   of_random_size(25, 150), 1, of_random_size(2e-4, 0.02));
        char name[60];
        snprintf(name, sizeof name, "step zeta %.3g", zeta);
        count_period(&d, 0.02, name, &tally);
    }
    assert_tally("steps", &tally);
}

TEST(knocks_and_hands)
{
    struct tally tally = {0};
    random_state = 174;
    for (int i = 0; i < cases(40); i++) {
        const double before = random_between(1, 6), swings = random_between(5, 25),
                     after = random_between(1, 5), loud = of_random_size(0.5, 5);
        struct drawn d = ring_down(before, swings, after, of_random_size(0.002, 0.04),
                                   of_random_size(25, 100), 0, of_random_size(2e-3, 0.02));
        const double t0 = i % 2 ? 0 : (before + swings) * d.period,
                     t1 = i % 2 ? before * d.period : HUGE_VAL;
        double at = 0;
        for (size_t k = 0; k < d.n; k++) /* a hand: smooth noise */
            if (d.t[k] >= t0 && d.t[k] < t1) {
                at += 0.1 * (random_normal() - at);
                d.y[k] += 4 * loud * at;
            }
        char name[60];
        snprintf(name, sizeof name, "%s %.3g", i % 2 ? "knock before" : "hand after", loud);
        count_period(&d, 0.02, name, &tally);
    }
    assert_tally("knocks", &tally);
}

/* Where one damped sine does not follow it all, the refusal names a window that it does follow. */
TEST(refusals_name_the_window)
{
    int refused = 0, followed = 0;
    random_state = 176;
    for (int i = 0; i < cases(30); i++) {
        struct drawn d =
            ring_down(random_between(2, 6), random_between(6, 20), 0, of_random_size(0.01, 0.1),
                      of_random_size(25, 100), i % 2 ? 1 : 0, of_random_size(1e-3, 0.01));
        const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
        struct fit fit;
        struct error error = {0};
        double window[2];
        if (!fit_named("damped", &series, &fit, &error)) {
            const char *hint = strstr(error.hint, "window=");
            const bool named = hint && sscanf(hint, "window=%lf:%lf", &window[0], &window[1]) == 2;
            const struct series part = named ? series_window(series, window[0], window[1]) : series;
            refused++;
            if (named && fit_named("damped", &part, &fit, &error) &&
                fabs(fit.period.value / d.period - 1) < 0.02)
                followed++;
            else
                print_message("T %g (%g periods): %s; %s\n", d.period, d.span / d.period,
                              error.text, error.hint);
        }
        free(d.t);
        free(d.y);
    }
    print_message("%d of %d refused, %d of the windows do\n", refused, cases(30), followed);
    assert_true(refused > 0);
    assert_int_equal(followed, refused);
}

/* ---- coarse sensors ---- */

TEST(coarse_sensors)
{
    struct tally tally = {0};
    random_state = 175;
    for (int i = 0; i < cases(20); i++) {
        const double quantum = 3, amplitude = of_random_size(4, 40), sigma = random_between(0, 0.5),
                     zeta = of_random_size(1e-4, 0.01), middle = random_between(200, 203);
        struct drawn d = ring_down(0, random_between(8, 40), 0, zeta, of_random_size(20, 80), 0, 0);
        for (size_t k = 0; k < d.n; k++)
            d.y[k] = quantum *
                     nearbyint((middle + amplitude * d.y[k] + sigma * random_normal()) / quantum);
        char name[60];
        snprintf(name, sizeof name, "3 mm, A %.3g noise %.2g zeta %.2g", amplitude, sigma, zeta);
        count_period(&d, 0.02, name, &tally);
    }
    assert_tally("coarse", &tally);
}

RUN_TESTS(NULL, NULL)
