/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Work on many samples in pieces: what a part is good for, and that the flag ends it. */
#include "cmocka_testing.h"

#include <gsl/gsl_fft_real.h>
#include <hooke/base/cancel.h>
#include "modules/recording/fit/formula.h"
#include "modules/recording/analysis/testing.h"

/* Of more than CURVE_MANY samples only a part is fitted first: what is projected has no room for
 * another number of samples. */
TEST(many_samples_without_starts)
{
    enum { MANY = 30001 };
    struct arena arena = {0};
    struct formula formula;
    struct curve_fit fit;
    struct error error = {0};
    size_t used;
    double *t = arena_array(&arena, MANY, sizeof *t), *y = arena_array(&arena, MANY, sizeof *y);
    for (size_t i = 0; i < MANY; i++) {
        t[i] = 1e-3 * (double)i;
        y[i] = 2 * cos(8.7 * t[i]) + 0.5 * sin(8.7 * t[i]) + 3;
    }
    const struct series series = {.t = t, .y = y, .n = MANY};
    assert_true(formula_compile(TEXT("a*cos(w*t) + b*sin(w*t) + c"), NULL, NULL, 0, &arena,
                                &formula, &used, &error));
    assert_true(formula_start(&formula, TEXT("w"), 8.6, &error));
    assert_true(formula_fit(&formula, &series, NULL, &arena, &fit, &error));
    assert_true(fit.converged);
    const double expected[] = {2, 8.7, 0.5, 3};
    for (int j = 0; j < 4; j++)
        assert_true(fabs(fit.value[j].value - expected[j]) < 1e-9);
    arena_reset(&arena);
}

/* Of 2^18 values a transform in pieces is GSL's, and the flag ends it, as it ends all the rest. */
TEST(transforms_and_sorts_in_pieces)
{
    enum { N = 1 << 18 };
    struct arena arena = {0};
    struct cancel cancel = {0};
    double *in = arena_array(&arena, 4 * (size_t)N, sizeof *in), *gsl = in + N, *scratch = gsl + N,
           *sorted = scratch + N, worst = 0;
    uint64_t random = 1;
    for (size_t i = 0; i < N; i++)
        in[i] = gsl[i] = sorted[i] = random_fraction(&random) - 0.5;
    gsl_fft_real_radix2_transform(gsl, 1, N);
    assert_true(transform_real(in, N, scratch, &cancel));
    for (size_t i = 0; i < N; i++)
        worst = fmax(worst, fabs(in[i] - gsl[i]));
    assert_true(worst < 1e-11 * N);
    assert_true(worst < 1e-9);
    assert_true(sort_values(sorted, N, scratch, &cancel));
    for (size_t i = 1; i < N; i++)
        assert_true(sorted[i - 1] <= sorted[i]);
    atomic_store(&cancel.requested, 1);
    assert_false(transform_real(in, N, scratch, &cancel));
    assert_false(sort_values(sorted, N, scratch, &cancel));
    arena_reset(&arena);
}

/* What is ended says that, and not that the samples are at fault. */
TEST(ended_by_the_flag)
{
    enum { N = 70000 };
    struct arena arena = {0};
    struct cancel cancel = {.requested = 1};
    struct error error = {0};
    double *t = arena_array(&arena, N, sizeof *t), *y = arena_array(&arena, N, sizeof *y);
    for (size_t i = 0; i < N; i++) {
        t[i] = 1e-3 * (double)i;
        y[i] = cos(8.7 * t[i]) + 1e-3 * cos(7.77e4 * t[i]);
    }
    const struct series series = {.t = t, .y = y, .n = N, .cancel = &cancel};
    const double at = 1;
    struct period period;
    struct reading reading;
    struct decay decay;
    assert_false(series_period(&series, &arena, &period, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_false(series_amplitudes(&series, &arena, &at, 1, 0, &reading, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_false(series_decay(&series, &arena, NULL, 0, &decay, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    arena_reset(&arena);
}

/* Long noise is refused by means of its neighbours; a line of a tenth of it, which no single sample
 * shows, is found all the same. */
TEST(weak_lines_are_found_in_long_noise)
{
    enum { ROWS = 100000 };
    static const double periods[] = {0, 7.3, 90, 1300, 20000}; /* samples; 0 means noise alone */
    for (size_t k = 0; k < COUNT_OF(periods); k++) {
        struct arena arena = {0};
        struct period period;
        struct error error = {0};
        uint64_t seed = 11 + k;
        double *t = arena_array(&arena, ROWS, sizeof *t), *y = arena_array(&arena, ROWS, sizeof *y);
        for (size_t i = 0; i < ROWS; i++) {
            t[i] = 1e-3 * (double)i;
            y[i] = normal_from(&seed);
            if (periods[k] > 0)
                y[i] += 0.1 * sin(TWO_PI * (double)i / periods[k]);
        }
        const struct series series = {.t = t, .y = y, .n = ROWS};
        const bool found = series_period(&series, &arena, &period, &error);
        assert_int_equal(found, periods[k] > 0);
        if (found)
            assert_true(fabs(period.period.value - 1e-3 * periods[k]) <
                        4 * period.period.uncertainty);
        arena_reset(&arena);
    }
}

RUN_TESTS(NULL, NULL)
