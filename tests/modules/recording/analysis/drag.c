/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Laws of drag: recordings made by integrating y'' + gamma y' + b|y'|y' + f sign(y') + Omega^2 y =
 * 0 itself (not its averaged envelope), with noise, and what `fit drag` says about them.
 */
#include <hooke/base/cancel.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#include <string.h>

struct laws {
    double rate[DRAG_RATES]; /* gamma [1/s], b [1/m], f [m/s^2] */
    enum drag_law law;
};

static double acceleration(const struct laws *l, double omega, double y, double v)
{
    const double f = l->rate[2];
    return -l->rate[0] * v - l->rate[1] * fabs(v) * v -
           (v > 0   ? f
            : v < 0 ? -f
                    : 0) -
           omega * omega * y;
}

/* Classical Runge-Kutta, forty steps a sample. */
static struct synthetic drag_make(const struct laws *l, double amplitude, double span, double rate,
                                  double noise)
{
    enum { STEPS = 40 };
    const double omega = 8.37;
    size_t n = (size_t)(span * rate) + 1;
    struct synthetic s = {.t = malloc(n * sizeof(double)), .y = malloc(n * sizeof(double))};
    if (!s.t || !s.y)
        abort();
    double y = amplitude, v = 0, h = 1 / (STEPS * rate);
    for (size_t i = 0; i < n; i++) {
        s.t[i] = 3 + (double)i / rate;
        s.y[i] = 0.21 + y + noise * random_normal();
        for (int k = 0; k < STEPS; k++) {
            double y1 = v, v1 = acceleration(l, omega, y, v);
            double y2 = v + h / 2 * v1, v2 = acceleration(l, omega, y + h / 2 * y1, y2);
            double y3 = v + h / 2 * v2, v3 = acceleration(l, omega, y + h / 2 * y2, y3);
            double y4 = v + h * v3, v4 = acceleration(l, omega, y + h * y3, y4);
            y += h / 6 * (y1 + 2 * (y2 + y3) + y4);
            v += h / 6 * (v1 + 2 * (v2 + v3) + v4);
        }
    }
    s.series = (struct series){.t = s.t, .y = s.y, .n = n, .quantity = QUANTITY_LENGTH};
    return s;
}

static const struct drag_candidate *candidate(const struct fit *fit, enum drag_law law)
{
    for (int i = 0; i < fit->drag.candidates; i++)
        if (fit->drag.candidate[i].law == law)
            return &fit->drag.candidate[i];
    return NULL;
}

static bool holds(struct measured m, double truth)
{
    return close_to(m.value, truth, 3 * m.uncertainty + 0.005 * truth);
}

static const struct laws truths[] = {
    {{0.04, 0, 0}, LAW_LINEAR},
    {{0, 0.12, 0}, LAW_QUADRATIC},
    {{0.0124, 0.0585, 0}, LAW_LINEAR | LAW_QUADRATIC},
    {{0, 0, 0.003}, LAW_DRY},
    {{0.02, 0, 0.003}, LAW_LINEAR | LAW_DRY},
    {{0, 0.12, 0.003}, LAW_QUADRATIC | LAW_DRY},
};

/* The right law with the right coefficients. */
TEST(each_law_is_found)
{
    random_state = 21;
    for (size_t i = 0; i < COUNT_OF(truths); i++) {
        struct synthetic s = drag_make(&truths[i], 0.05, 90, 100, 2e-4);
        struct fit fit;
        struct error error = {0};
        if (!fit_named("drag", &s.series, &fit, &error))
            fail_msg("law %zu: %s", i, error.text);
        const struct drag_candidate *c = candidate(&fit, truths[i].law);
        print_message("%s\n", fit.drag.said);
        assert_int_equal(fit.preferred, truths[i].law);
        assert_true(c->converged);
        for (int k = 0; k < DRAG_RATES; k++)
            assert_true(holds(c->rate[k], truths[i].rate[k]));
        assert_true(fit.drag.delta >= 6 &&
                    strstr(fit.drag.said, drag_law_name(truths[i].law)) == fit.drag.said);
        /* the values that are drawn are those of that law */
        double square = 0, *value = calloc(s.series.n, sizeof *value);
        assert_non_null(value);
        fit_values(&fit, s.t, s.series.n, value);
        for (size_t k = 0; k < s.series.n; k++) {
            double r = s.y[k] - value[k];
            square += r * r;
        }
        free(value);
        assert_true(close_to(sqrt(square / (double)s.series.n), 2e-4, 1e-5));
        synthetic_free(&s);
    }
}

/* Fits recordings with known laws of drag. The preferred law may differ from the true one only by a
 * spurious second term (in at most 1 % of the fits) or by a second term hidden by noise; other
 * doubtful fits must be reported as not distinguishable. */
TEST(wrong_laws_are_rare)
{
    int runs = is_long() ? 150 : 8, wrong = 0, spurious = 0, undecided = 0, hidden = 0, cover = 0;
    random_state = 22;
    for (int run = 0; run < runs; run++) {
        for (size_t i = 0; i < COUNT_OF(truths); i++) {
            double noise = 2e-4 * pow(10, random_uniform());
            struct synthetic s = drag_make(&truths[i], random_between(0.03, 0.06),
                                           random_between(30, 90), 40, noise);
            struct fit fit;
            struct error error = {0};
            if (!fit_named("drag", &s.series, &fit, &error))
                fail_msg("law %zu: %s", i, error.text);
            bool right = fit.preferred == truths[i].law;
            undecided += fit.preferred == LAW_UNDECIDED;
            const bool claimed = fit.preferred != LAW_UNDECIDED;
            spurious += !right && claimed && (fit.preferred & truths[i].law) == truths[i].law;
            hidden += !right && claimed && (fit.preferred & truths[i].law) == fit.preferred;
            wrong += !right && claimed;
            if (!right && claimed)
                print_message("%zu: noise %g: %s\n", i, noise, fit.drag.said);
            const struct drag_candidate *c = candidate(&fit, truths[i].law);
            const int k = truths[i].law & LAW_LINEAR ? 0 : truths[i].law & LAW_QUADRATIC ? 1 : 2;
            cover += close_to(c->rate[k].value, truths[i].rate[k], 1.96 * c->rate[k].uncertainty);
            synthetic_free(&s);
        }
    }
    int all = runs * (int)COUNT_OF(truths);
    print_message("%d laws: %d wrong (%d with a spurious second term), %d with one of two terms "
                  "hidden by noise, %d not "
                  "distinguishable; intervals cover %.1f %%\n",
                  all, wrong, spurious, hidden, undecided, 100.0 * cover / all);
    assert_int_equal(wrong, spurious + hidden);
    assert_true(spurious <= 0.01 * all && hidden <= 0.04 * runs + 1 && undecided <= 0.45 * all);
    assert_true(cover >= (0.95 - 3 * sqrt(0.95 * 0.05 / all)) * all);
}

TEST(too_short_to_tell)
{
    random_state = 23;
    struct synthetic s = drag_make(&truths[0], 0.05, 8, 100, 2e-3);
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("drag", &s.series, &fit, &error));
    assert_int_equal(fit.preferred, LAW_UNDECIDED);
    assert_true(strstr(fit.drag.said, "not distinguishable") == fit.drag.said);
    synthetic_free(&s);
}

TEST(velocities_give_the_same_coefficients)
{
    random_state = 24;
    struct synthetic s = drag_make(&truths[2], 0.05, 90, 100, 0);
    size_t n = s.series.n;
    for (size_t i = 0; i + 2 < n; i++) /* central differences of the positions */
        s.y[i] = (s.y[i + 2] - s.y[i]) * 50 + 2e-3 * random_normal();
    s.series.n = n - 2;
    s.series.quantity = QUANTITY_VELOCITY;
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("drag", &s.series, &fit, &error));
    assert_int_equal(fit.preferred, LAW_LINEAR | LAW_QUADRATIC);
    const struct drag_candidate *c = candidate(&fit, LAW_LINEAR | LAW_QUADRATIC);
    assert_true(holds(c->rate[0], truths[2].rate[0]) && holds(c->rate[1], truths[2].rate[1]));
    synthetic_free(&s);
}

TEST(can_be_stopped)
{
    struct synthetic s = drag_make(&truths[0], 0.05, 20, 50, 1e-4);
    struct cancel cancel;
    atomic_init(&cancel.requested, 1);
    struct arena arena = {0};
    struct fit fit;
    struct error error = {0};
    const struct fit_model *row = fit_model_by_name(TEXT("drag"));
    assert_false(row->fit(&s.series, &arena, &cancel, &fit, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    arena_reset(&arena);
    synthetic_free(&s);
}

RUN_TESTS(NULL, NULL)
