/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures in words: no statement that the values refute. */
#include "cmocka_testing.h"

#include "modules/words/describe.h"

#include <math.h>
#include <string.h>
#include "unit/random_testing.h"

#define N 2000

static double t[N], y[N];

static const char *words(size_t n, bool points, bool second, struct buffer *out)
{
    static double other[N];
    for (size_t i = 0; i < n; i++)
        other[i] = y[i] / 2;
    struct curve curve[] = {{.label = "data", .x = t, .y = y, .n = n, .points = points},
                            {.label = "half", .x = t, .y = other, .n = n}};
    const struct figure figure = {.title = "position",
                                  .x = {.label = "t", .unit = "s"},
                                  .y = {.label = "y", .unit = "m"},
                                  .curve = curve,
                                  .curves = second ? 2 : 1};
    buffer_clear(out);
    assert_true(describe_figure(&figure, out));
    assert_null(strstr(out->data, "inf "));
    assert_null(strstr(out->data, "nan"));
    assert_null(strstr(out->data, " ."));
    return out->data;
}

TEST(test_noise)
{
    struct buffer out = {0};
    (void)state;
    for (int i = 0; i < N; i++) {
        t[i] = 0.01 * i;
        y[i] = 1 + 1e-3 * random_normal();
    }
    assert_non_null(strstr(words(N, true, false, &out), "scatters about 1"));
    assert_null(strstr(out.data, "rises"));
    assert_null(strstr(out.data, "falls"));
    y[300] = y[1500] = 1.0095; /* a few that are far off are no swings */
    y[900] = 0.9905;
    assert_non_null(strstr(words(N, true, false, &out), "scatters about 1"));
    for (int i = 0; i < N; i++)
        y[i] = 3 - 0.2 * t[i] + 0.01 * random_normal();
    assert_non_null(strstr(words(N, true, false, &out), "falls throughout"));
    for (int i = 0; i < N; i++) /* crosses its middle several times, of any parity of indices */
        y[i] = sin(5 * t[i]) + 0.1 * random_normal();
    assert_non_null(strstr(words(N, true, false, &out), "with a period of 1.25"));
    assert_non_null(strstr(out.data, "by less than the noise"));
    buffer_free(&out);
}

TEST(test_sizes)
{
    static const double size[] = {5e-324, 1e-300, 1e-160, 1, 1e160, 1e300, 1.7e308};
    struct buffer out = {0};
    (void)state;
    for (size_t k = 0; k < sizeof size / sizeof *size; k++) {
        for (int i = 0; i < N; i++) {
            t[i] = 0.01 * i;
            y[i] = size[k] * sin(5 * t[i]) * (size[k] < 1e-320 ? 100 : 1);
        }
        for (int second = 0; second < 2; second++) {
            words(N, false, second, &out);
            assert_null(strstr(out.data, "throughout"));
        }
        if (size[k] > 1e-200)
            assert_null(strstr(out.data, "(rms 0 m)"));
    }
    buffer_free(&out);
}

/* Descriptions do not claim a direction, a growth, a middle or a period that a small part of the
 * values only suggests. */
TEST(test_directions)
{
    struct buffer out = {0};
    (void)state;
    for (int i = 0; i < N; i++) { /* goes back by 1 % in the end */
        t[i] = 0.005 * i;
        y[i] = (t[i] - 9) * (t[i] - 9);
    }
    assert_non_null(strstr(words(N, false, false, &out), "falls overall"));
    for (int i = 0; i < N; i++) { /* the last swing is less by chance: no growth */
        t[i] = 0.01 * i;
        y[i] = sin(5 * t[i]) * (1 + 0.02 * sin(0.3 * t[i] * t[i]) - (t[i] > 19 ? 0.012 : 0));
    }
    words(N, false, false, &out);
    assert_false(strstr(out.data, "shrinks") && strstr(out.data, "exponentially at 0") != NULL);
    for (int i = 0; i < N; i++) /* the middle of what grows is nothing beside it */
        y[i] = exp(0.2 * t[i]) * sin(5 * t[i]);
    assert_non_null(strstr(words(N, false, false, &out), "about 0 m"));
    for (int i = 0; i < N; i++) /* a spike has no period */
        y[i] = i == 600 ? 100 : i == 604 ? 90 : 0;
    assert_null(strstr(words(N, false, false, &out), "period of"));
    buffer_free(&out);
}

/* From three to six, whatever there is: three curves with a band, one that is constant, one point.
 */
TEST(test_sentences)
{
    struct buffer out = {0};
    static double spread[N], other[2][N];
    (void)state;
    for (int i = 0; i < N; i++) {
        t[i] = 0.01 * i;
        y[i] = sin(5 * t[i]);
        other[0][i] = y[i] / 2;
        other[1][i] = 3;
        spread[i] = 1e-4 * i;
    }
    const struct curve three[] = {{.label = "a", .x = t, .y = y, .n = N, .spread = spread},
                                  {.label = "b", .x = t, .y = other[0], .n = N},
                                  {.label = "c", .x = t, .y = other[1], .n = N}},
                       constant[] = {{.label = "a", .x = t, .y = other[1], .n = N}},
                       point[] = {{.label = "a", .x = t, .y = other[1], .n = 1}};
    const struct curve *const of[] = {three, constant, point};
    for (int k = 0; k < 3; k++) {
        const struct figure figure = {.title = "position",
                                      .x = {.label = "t", .unit = "s"},
                                      .y = {.label = "y", .unit = "m"},
                                      .curve = of[k],
                                      .curves = k ? 1 : 3};
        int sentences = 0;
        buffer_clear(&out);
        assert_true(describe_figure(&figure, &out));
        for (const char *at = out.data; (at = strchr(at, '.')); at++)
            sentences += at[1] == ' ' || at[1] == '\0';
        if (sentences < 3 || sentences > 6)
            fail_msg("%d sentences: %s", sentences, out.data);
        assert_true(k > 0 || strstr(out.data, "; the band about a is widest, +- 0.1999 m"));
    }
    buffer_free(&out);
}

TEST(test_fixed_axis)
{
    static double decay[N];
    struct buffer out = {0};
    (void)state;
    for (int i = 0; i < N; i++) {
        t[i] = 0.001 * i;
        decay[i] = exp(t[i]);
    }
    struct curve curve = {.label = "run", .x = t, .y = decay, .n = N};
    const struct figure figure = {
        .x = {.label = "t", .unit = "s"},
        .y = {.label = "y", .first_value = -1, .last_value = 5, .fixed = true},
        .curve = &curve,
        .curves = 1};
    assert_true(describe_figure(&figure, &out));
    assert_non_null(strstr(out.data, "doubling every 0.6931 s"));
    buffer_free(&out);
}

RUN_TESTS(NULL, NULL)
