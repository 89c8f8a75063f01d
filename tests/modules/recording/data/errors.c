/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Which column of a recording holds the uncertainties of its samples. */
#include "modules/recording/data/fixture.h"

/* Errors of a file of so many rows "t y … error"; the series is all of it. NULL: none. */
static const double *errors_of(const char *header, const char *before, double same, int rows,
                               struct arena *arena, size_t *n)
{
    struct buffer text = {0};
    struct series series;
    struct error error = {0};
    const double *half;
    buffer_put(&text, text_of(header));
    for (int i = 0; i < rows; i++) {
        buffer_format(&text, "%.2f\t%.3f\t", 0.01 * i, 20 + cos(0.1 * i));
        buffer_put(&text, text_of(before));
        if (same > 0)
            buffer_format(&text, "%g\n", same);
        else
            buffer_format(&text, "%.3f\n", 0.1 + 0.01 * (i % 7));
    }
    buffer_char(&text, '\0');
    assert_false(text.failed);
    struct recording *recording = fixture_good(text.data, "");
    assert_true(recording_series(recording, arena, 1, &series, &error));
    assert_true(recording_errors(recording, &series, arena, &half));
    *n = series.n;
    recording_destroy(recording);
    buffer_free(&text);
    return half;
}

TEST(test_columns)
{
    static const struct {
        const char *header, *before;
        double same; /* 0: they differ */
        int rows;
        double third; /* [SI] of the row; NAN: there is none */
    } cases[] = {
        {"Time (s)\tDistance (cm)\tDist Error (cm)\n", "", 0.239, 300, NAN}, /* a calibration */
        {"Time (s)\tDistance (cm)\tDist Error (cm)\n", "", 0.239, 40, 0.00239},
        {"Time (s)\tDistance (cm)\tDist Error (cm)\n", "", 0, 300, 0.0012},
        {"t (s)\ty (m)\tsigma (m)\n", "", 0, 300, 0.12},
        {"t (s)\ty (m)\tyerr (cm)\n", "", 0, 300, 0.0012},
        {"t (s)\ty (m)\txerr (m)\n", "", 0, 300, NAN},
        {"t (s)\ty (m)\terror (m/s)\n", "", 0, 300, NAN},
        {"t (s)\ty (m)\tvelocity (m/s)\n", "", 0, 300, NAN},
        {"t (s)\ty (m)\txerr (m)\tyerr (m)\n", "9\t", 0, 300, 0.12},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct arena arena = {0};
        size_t n;
        const double *half =
            errors_of(cases[i].header, cases[i].before, cases[i].same, cases[i].rows, &arena, &n);
        if ((half != NULL) != !isnan(cases[i].third))
            fail_msg("%s: %s", cases[i].header, half ? "errors" : "no errors");
        if (half && fabs(half[2] - cases[i].third) > 1e-9)
            fail_msg("%s: %g", cases[i].header, half[2]);
        arena_reset(&arena);
    }
}

/* Those of the samples that are left: of a window, without a missing value. */
TEST(test_samples)
{
    static const char text[] = "t (s)\ty (cm)\terr (cm)\n0\t1\t0.1\n1\t\t0.2\n2\t3\t0.3\n3\t2\t-1\n"
                               "4\t1\t0.5\n5\t2\t0.6\n";
    struct arena arena = {0};
    struct error error = {0};
    struct series series;
    const double *half;
    (void)state;
    struct recording *recording = fixture_good(text, "");
    assert_true(recording_series(recording, &arena, 1, &series, &error));
    assert_true(recording_errors(recording, &series, &arena, &half));
    assert_int_equal(series.n, 5);
    assert_true(fabs(half[0] - 0.001) < 1e-12 && fabs(half[1] - 0.003) < 1e-12);
    assert_true(isnan(half[2])); /* a negative error is none */
    assert_true(fabs(half[4] - 0.006) < 1e-12);
    assert_true(recording_window(recording, 4, 5, &error));
    assert_true(recording_series(recording, &arena, 1, &series, &error));
    assert_true(recording_errors(recording, &series, &arena, &half));
    assert_int_equal(series.n, 2);
    assert_true(fabs(half[0] - 0.005) < 1e-12);
    recording_destroy(recording);
    arena_reset(&arena);
}

RUN_TESTS(fixture_setup, fixture_teardown)
