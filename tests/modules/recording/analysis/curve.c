/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Least squares for any curve, and formulas: starts that are looked for, bounds, outliers, what the
 * data cannot tell.
 */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>
#include <hooke/scene/formula.h>
#include "modules/recording/fit/formula.h"
#include "modules/recording/analysis/testing.h"

#include <string.h>

enum { N = 400 };

static double t[N], y[N];
static const struct series series = {.t = t, .y = y, .n = N};

static void sample(double (*curve)(double t), double span, double noise)
{
    for (size_t i = 0; i < N; i++) {
        t[i] = span * (double)i / (N - 1);
        y[i] = curve(t[i]) + noise * random_normal();
    }
}

static double decaying(double at)
{
    return 3 * exp(-0.7 * at) + 1;
}

static double swinging(double at)
{
    return 2 * exp(-0.1 * at) * cos(7.3 * at + 0.5) - 4;
}

static double bell(double at)
{
    return 5 * exp(-(at - 6) * (at - 6) / (2 * 0.8 * 0.8)) + 0.3;
}

static void compile(const char *text, struct arena *arena, struct formula *formula)
{
    struct error error = {0};
    size_t used;
    if (!formula_compile(text_of(text), NULL, NULL, 0, arena, formula, &used, &error))
        fail_msg("%s: %s", text, error.text);
    assert_int_equal(used, strlen(text));
}

static int place(const struct formula *formula, const char *name)
{
    for (int j = 0; j < formula->parameters; j++)
        if (strcmp(formula->name[j], name) == 0)
            return j;
    fail_msg("no parameter %s", name);
    return -1;
}

static void fit(const struct formula *formula, const struct curve_options *options,
                struct arena *arena, struct curve_fit *out)
{
    struct error error = {0};
    if (!formula_fit(formula, &series, options, arena, out, &error))
        fail_msg("%s", error.text);
}

TEST(starts_are_found)
{
    static const struct {
        double (*curve)(double);
        double span;
        const char *text, *name;
        double truth;
    } cases[] = {{decaying, 8, "a*exp(-b*t) + c", "b", 0.7},
                 {decaying, 8, "exp(-b*t + d) + c", "c", 1},
                 {swinging, 12, "A*exp(-g*t/2)*cos(w*t + p) + c", "g", 0.2},
                 {swinging, 12, "exp(-g*t)*(u*cos(w*t) + v*sin(w*t)) + c", "w", 7.3},
                 {bell, 10, "h*exp(-(t - m)^2/(2*s^2)) + b", "m", 6},
                 {decaying, 8, "p0 + p1*t + p2*t^2", "p0", NAN}};
    random_state = 31;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct arena arena = {0};
        struct formula formula;
        struct curve_fit result;
        sample(cases[i].curve, cases[i].span, 0.02);
        compile(cases[i].text, &arena, &formula);
        fit(&formula, NULL, &arena, &result);
        struct measured value = result.value[place(&formula, cases[i].name)];
        if (!result.converged)
            fail_msg("%s: %s", cases[i].text, result.said);
        if (isfinite(cases[i].truth) &&
            !(close_to(fabs(value.value), cases[i].truth, 4 * value.uncertainty) &&
              close_to(result.sigma, 0.02, 0.004)))
            fail_msg("%s: %s = %g +- %g", cases[i].text, cases[i].name, value.value,
                     value.uncertainty);
        assert_true(isnan(cases[i].truth)
                        ? result.autocorrelation > 0.5 && result.runs < -3
                        : fabs(result.autocorrelation) < 0.25 && fabs(result.runs) < 4);
        arena_reset(&arena);
    }
}

TEST(intervals_and_bootstrap)
{
    int covered[2] = {0, 0}, runs = 100;
    random_state = 32;
    for (int run = 0; run < runs; run++) {
        struct arena arena = {0};
        struct formula formula;
        struct curve_fit result;
        struct error error = {0};
        sample(decaying, 8, 0.2);
        compile("a*exp(-b*t) + c", &arena, &formula);
        formula_start(&formula, TEXT("a"), 2, &error);
        formula_start(&formula, TEXT("b"), 1, &error);
        formula_start(&formula, TEXT("c"), 0, &error);
        fit(&formula, NULL, &arena, &result);
        assert_true(result.converged && result.used == N && result.rejected == 0);
        covered[0] += result.interval[1][0] < 0.7 && 0.7 < result.interval[1][1];
        assert_true(close_to(result.covariance[0][1], result.covariance[1][0], 1e-9) &&
                    close_to(result.correlation[2][2], 1, 0) && result.correlation[1][2] > 0.5);
        if (run <
            1) { /* of a nearly linear problem: the same interval, from a different direction */
            struct curve_fit again;
            struct curve_options options = {.bootstrap = 300, .seed = 5};
            fit(&formula, &options, &arena, &again);
            assert_int_equal(again.bootstrapped, 300);
            for (int side = 0; side < 2; side++)
                assert_true(again.interval[1][side] != result.interval[1][side] &&
                            close_to(again.interval[1][side], result.interval[1][side],
                                     0.5 * result.value[1].uncertainty));
        }
        arena_reset(&arena);
    }
    print_message("95 %% intervals: %d of %d\n", covered[0], runs);
    assert_true(covered[0] >= 88 && covered[0] <= 100);
}

TEST(outliers_have_no_weight)
{
    struct arena arena = {0};
    struct formula formula;
    struct curve_fit plain, robust;
    struct curve_options options = {.robust = true};
    random_state = 33;
    sample(decaying, 8, 0.01);
    /* 25 of 400 */
    for (size_t i = 7; i < N; i += 16)
        y[i] = i % 32 == 7 ? 0 : 6;
    compile("a*exp(-b*t) + c", &arena, &formula);
    fit(&formula, NULL, &arena, &plain);
    fit(&formula, &options, &arena, &robust);
    print_message("%s; %zu without weight, b = %g +- %g\n", robust.said, robust.rejected,
                  robust.value[1].value, robust.value[1].uncertainty);
    assert_true(robust.converged && robust.rejected >= 24 && robust.rejected <= 30);
    assert_true(robust.used + robust.rejected == N);
    assert_true(close_to(robust.value[1].value, 0.7, 4 * robust.value[1].uncertainty));
    assert_true(robust.value[1].uncertainty < 0.1 * plain.value[1].uncertainty);
    assert_true(close_to(robust.sigma, 0.01, 0.002));
    arena_reset(&arena);
}

/* The true c is 1. With c <= 0.5 the fit ends at the bound, reports that (result.bound) and gives
 * no uncertainty for c; with 0 <= c <= 2 it finds 1 as without bounds. */
TEST(bounds_hold)
{
    struct arena arena = {0};
    struct formula formula;
    struct curve_fit result;
    struct error error = {0};
    random_state = 34;
    sample(decaying, 8, 0.02);
    compile("a*exp(-b*t) + c", &arena, &formula);
    const double low[3] = {-INFINITY, -INFINITY, -INFINITY}, high[3] = {INFINITY, INFINITY, 0.5};
    fit(&formula, &(struct curve_options){.low = low, .high = high}, &arena, &result);
    assert_true(result.bound[2] && result.value[2].value <= 0.5 &&
                close_to(result.value[2].value, 0.5, 1e-6));
    assert_true(result.converged && !result.bound[1] && result.value[2].uncertainty == 0);
    /* a bound that does not matter changes nothing */
    const double zero[3] = {-INFINITY, -INFINITY, 0}, two[3] = {INFINITY, INFINITY, 2};
    fit(&formula, &(struct curve_options){.low = zero, .high = two}, &arena, &result);
    assert_true(result.converged && !result.bound[2] && close_to(result.value[2].value, 1, 0.02));
    assert_false(formula_start(&formula, TEXT("d"), 1, &error));
    assert_true(strstr(error.text, "no parameter 'd'"));
    arena_reset(&arena);
}

TEST(what_the_data_do_not_tell_is_said)
{
    static const struct {
        const char *text;
        double a, b;
    } cases[] = {{"a*b*t", 1, 2},               /* only the product */
                 {"a*(1 - exp(-b*t))", 5, 400}, /* at its end before the first sample: any b does */
                 {"a*t + 0*b", 1, 1}};
    random_state = 35;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct arena arena = {0};
        struct formula formula;
        struct curve_fit result;
        struct error error = {0};
        for (size_t k = 0; k < N; k++) {
            t[k] = 1 + 0.02 * (double)k;
            y[k] = (i == 1 ? 5 : 2 * t[k]) + 0.1 * random_normal();
        }
        compile(cases[i].text, &arena, &formula);
        formula_start(&formula, TEXT("a"), cases[i].a, &error);
        formula_start(&formula, TEXT("b"), cases[i].b, &error);
        fit(&formula, NULL, &arena, &result);
        if (result.converged || !strstr(result.said, "not determined by the data"))
            fail_msg("%s: %s", cases[i].text, result.said);
        assert_true(!result.determined[1] && isnan(result.value[1].uncertainty));
        arena_reset(&arena);
    }
}

TEST(stopped_early_is_not_converged)
{
    struct arena arena = {0};
    struct formula formula;
    struct curve_fit result;
    struct error error = {0};
    random_state = 36;
    sample(bell, 10, 0.02);
    compile("h*exp(-((t - m)/s)^2) + b", &arena, &formula);
    formula_start(&formula, TEXT("h"), 1, &error);
    formula_start(&formula, TEXT("m"), 3, &error);
    formula_start(&formula, TEXT("s"), 2, &error);
    formula_start(&formula, TEXT("b"), 0, &error);
    struct curve_options options = {.iterations = 1};
    fit(&formula, &options, &arena, &result);
    assert_true(!result.converged && strstr(result.said, "did not converge in"));
    arena_reset(&arena);
}

TEST(refusals)
{
    static const struct {
        const char *text, *says;
    } cases[] = {{"2*t", "no parameter"},
                 {"a*foo(t)", "unknown function"},
                 {"a*sin", "is a function"},
                 {"a*(t", "missing ')'"}};
    struct error error = {0};
    struct arena arena = {0};
    struct formula formula;
    struct curve_fit result;
    size_t used;
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        if (formula_compile(text_of(cases[i].text), NULL, NULL, 0, &arena, &formula, &used,
                            &error) ||
            !strstr(error.text, cases[i].says))
            fail_msg("%s: %s", cases[i].text, error.text);
    sample(decaying, 8, 0.1);
    compile("a*log(-b^2 - t)", &arena, &formula);
    error = (struct error){0};
    assert_false(formula_fit(&formula, &series, NULL, &arena, &result, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    compile("a + b*t + c*t^2", &arena, &formula);
    struct series few = {.t = t, .y = y, .n = 3};
    assert_false(formula_fit(&formula, &few, NULL, &arena, &result, &error));
    assert_true(strstr(error.text, "3 samples cannot determine 3 parameters"));
    struct cancel cancel;
    atomic_init(&cancel.requested, 1);
    struct curve_options options = {.cancel = &cancel};
    assert_false(formula_fit(&formula, &series, &options, &arena, &result, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    arena_reset(&arena);
}

/* Names that somebody knows are constants, unless a column has the name. */
static bool known_find(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = 1;
    return text_is(name, "m") || text_is(name, "phase-error");
}

static double known_load(const void *context, int slot)
{
    (void)context;
    return 2.0 * slot;
}

TEST(known_names_are_constants)
{
    struct arena arena = {0};
    struct formula formula;
    struct error error = {0};
    struct expr_scope known = {.find = known_find, .load = known_load};
    size_t used;
    random_state = 37;
    sample(decaying, 8, 0.02);
    assert_true(formula_compile(TEXT("a*exp(-k*t/m) + b-c*0+b*phase-error"), &known, NULL, 0,
                                &arena, &formula, &used, &error));
    assert_int_equal(formula.parameters, 4);
    assert_string_equal(formula.name[1], "k");
    assert_true(formula.linear[0] && !formula.linear[1] && formula.linear[2]);
    double x[4] = {3, 1.4, 1.0 / 3, 0}, value[2];
    assert_true(formula_ready(&formula, &arena, &error));
    assert_true(formula_evaluate(&formula, x, t, 2, value, NULL));
    formula_done(&formula);
    assert_true(close_to(value[1], decaying(t[1]), 1e-12));
    arena_reset(&arena);
}

/* A decay to a plateau that a coarse sensor rounds: on the plateau all rounding errors are alike.
 */
TEST(plateaus_of_a_coarse_sensor)
{
    const int runs = 60;
    int within = 0;
    random_state = 38;
    for (int run = 0; run < runs; run++) {
        struct arena arena = {0};
        struct formula formula;
        struct curve_fit result;
        const double step = random_between(0.15, 0.6), noise = random_between(0, 0.3) * step;
        sample(decaying, random_between(5, 14), 0);
        const double shift = random_between(0, step);
        for (size_t i = 0; i < N; i++)
            y[i] = step * nearbyint((y[i] + shift + noise * random_normal()) / step);
        compile("a*exp(-b*t) + c", &arena, &formula);
        fit(&formula, NULL, &arena, &result);
        const struct measured b = result.value[place(&formula, "b")];
        within += fabs(b.value - 0.7) < 2 * b.uncertainty;
        arena_reset(&arena);
    }
    print_message("%d of %d within 2 standard uncertainties\n", within, runs);
    assert_true(10 * within >= 9 * runs);
}

RUN_TESTS(NULL, NULL)
