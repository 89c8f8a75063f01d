/* SPDX-License-Identifier: GPL-3.0-or-later */
/* stability: limits and growth against closed forms, verified by running for every method; weak
 * instabilities, narrow resonances, scenes that are not linear. */
#include "cmocka_testing.h"

#include <hooke/base/cancel.h>

#include "modules/comparison/compute/verify.h"
#include "long_form.h"
#include "modules/solving/testing.h"

static struct stability study_as(const struct scene *scene, const struct method *method,
                                 enum drag drag, double dt)
{
    const struct stability_request request = {
        .scene = scene, .choice = {method, drag}, .dt = dt, .duration = 10};
    struct stability stability;
    struct error error = {0};
    if (!study_stability(&request, &stability, &error))
        fail_msg("%s: %s", method->row.name, error.text);
    return stability;
}

static struct stability study(const struct scene *scene, const char *name, double dt)
{
    return study_as(scene, method_named(name), DRAG_DEFAULT, dt);
}

/* m = 1, k = 4: omega = 2. */
TEST(test_closed_forms)
{
    const struct scene scene = scene_with("spring", SETTINGS({"m", 1}, {"k", 4}, {"y0", 1}));
    struct stability s = study(&scene, "euler", 0.1);
    close_to(s.growth_predicted, sqrt(1.04), 1e-12);
    close_to(s.growth_measured, sqrt(1.04), 1e-6);
    close_to(s.energy_factor, 1.04, 1e-12);
    assert_true(s.dt_max == 0);
    assert_int_equal(s.verdict, STABILITY_UNSTABLE);
    assert_true(s.agrees);

    s = study(&scene, "verlet", 0.1);
    close_to(s.dt_max, 1, 1e-9);
    assert_int_equal(s.verdict, STABILITY_STABLE);
    assert_int_equal(s.checks, 3);
    assert_true(s.agrees && s.check[2].measured > 1.01);
    assert_int_equal(study(&scene, "verlet", 1.5).verdict, STABILITY_UNSTABLE);

    s = study(&scene, "rk4", 0.1);
    close_to(s.dt_max, sqrt(2), 1e-9);
    assert_true(isinf(study(&scene, "radau5", 0.1).dt_max));
}

TEST(test_damping)
{
    /* zeta = 1/2 */
    const struct scene scene =
        scene_with("spring", SETTINGS({"m", 1}, {"k", 1}, {"gamma", 1}, {"y0", 1}));
    close_to(study(&scene, "euler", 0.1).dt_max, 1, 1e-6);
    close_to(study(&scene, "symplectic-euler", 0.1).dt_max, 2 * (sqrt(1.25) - 0.5), 1e-6);
    close_to(study_as(&scene, method_named("symplectic-euler"), DRAG_IMPLICIT, 0.1).dt_max,
             2 * (sqrt(1.25) + 0.5), 1e-6);
    close_to(study(&scene, "verlet", 0.1).growth_exact, exp(-0.05), 1e-12);
    close_to(study(&scene, "verlet", 0.1).growth_predicted, exp(-0.05), 1e-9);
}

TEST(test_weak_instability_is_named)
{
    const struct scene scene = scene_with("spring", SETTINGS({"m", 1}, {"k", 1}, {"y0", 1}));
    const struct stability s = study(&scene, "heun", 0.1);
    assert_int_equal(s.verdict, STABILITY_MARGINAL);
    close_to(s.weak[0], 0.125, 0.002);
    close_to(s.weak[1], 4, 0.02);
    close_to(s.doubling, 5.5e4, 0.1e4);
    assert_true(s.agrees);
}

TEST(test_narrow_resonance_is_named)
{
    const struct scene scene = scene_with("spring", SETTINGS({"m", 1}, {"k", 1}, {"y0", 1}));
    const struct stability s = study(&scene, "blanes-moan6-11", 0.1);
    close_to(s.window[0], 3.1414311, 1e-6);
    close_to(s.window[1], 3.1423200, 1e-4);
    close_to(s.window[2], 1.00044, 1e-5);
    assert_true(s.agrees);
    assert_true(isnan(study(&scene, "verlet", 0.1).window[0]));
}

/* Predicted and measured, for all methods: at a usual step and on both sides of the limit. */
TEST(test_every_method_agrees)
{
    static const double zetas[] = {0, 0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 0.70710678118654752,
                                   1, 2,     5,    10,   100};
    int studied = 0;
    for (size_t z = 0; z < COUNT_OF(zetas); z++) {
        const struct scene scene =
            scene_with("spring", SETTINGS({"m", 1}, {"k", 1}, {"gamma", 2 * zetas[z]}, {"y0", 1}));
        for (size_t m = 0; m < method_catalog.count; m++) {
            if (!is_long() && (z + m) % 4 != 0) /* each method at three or four of them */
                continue;
            const struct method *method = method_at(m);
            const struct stability_request request = {
                .scene = &scene, .choice = {method, 0}, .dt = 0.3, .duration = 10};
            struct stability s;
            struct error error;
            if (!study_stability(&request, &s, &error))
                continue;
            studied++;
            for (int i = 0; i < s.checks; i++)
                if (!s.check[i].agrees)
                    fail_msg("%s, zeta %g, dt %g: growth %.10g predicted, %.10g measured",
                             method->row.name, zetas[z], s.check[i].dt, s.check[i].predicted,
                             s.check[i].measured);
            assert_true(s.agrees);
        }
    }
    assert_true(studied > (is_long() ? 500 : 120));
}

/* A growth formula that is wrong by half a per cent does not agree with the runs. */
static double off(const struct method *method, double x, double zeta, enum stiffness_sign sign)
{
    (void)method;
    return method_growth_signed(method_named("ab3"), DRAG_DEFAULT, x, zeta, sign) * 1.005;
}

TEST(test_a_wrong_formula_is_found_out)
{
    struct method wrong = *method_named("ab3");
    wrong.growth = off;
    const struct scene scene = scene_with("spring", SETTINGS({"m", 1}, {"k", 1}, {"y0", 1}));
    assert_false(study_as(&scene, &wrong, DRAG_DEFAULT, 0.3).agrees);
    assert_true(study(&scene, "ab3", 0.3).agrees);
}

TEST(test_not_linear)
{
    const struct scene stiff = scene_with("stiff-vanderpol", NO_SETTINGS),
                       pendulum = scene_with("pendulum", NO_SETTINGS),
                       robertson = scene_with("robertson", NO_SETTINGS);
    struct stability s = study(&stiff, "rk4", 0.01);
    assert_false(s.linear);
    assert_int_equal(s.verdict, STABILITY_UNSTABLE);
    assert_int_equal(s.stop, STOP_DIVERGED);
    close_to(s.dt_max, 2.785293563 / 3000, 0.01 / 3000);
    assert_true(s.agrees);

    s = study(&stiff, "radau5", 0.01);
    assert_int_equal(s.verdict, STABILITY_STABLE);
    assert_int_equal(s.stop, STOP_END);
    assert_true(s.agrees);

    /* stiffest at the bottom: omega^2 = g/l */
    s = study(&pendulum, "verlet", 0.1);
    close_to(s.dt_max, 2 / sqrt(9.81), 0.03);
    assert_true(s.agrees);

    s = study(&robertson, "rk4", 0.01);
    assert_int_equal(s.verdict, STABILITY_UNSTABLE);
    assert_int_equal(s.stop, STOP_DIVERGED);
    assert_true(s.agrees);
}

TEST(test_a_scene_that_grows)
{
    const struct scene scene = scene_with("inverted", NO_SETTINGS),
                       free = scene_with("spring", SETTINGS({"k", 0}));
    assert_true(study(&scene, "rk4", 0.01).grows);
    const struct stability s = study(&free, "rk4", 0.01);
    assert_false(s.grows);
    assert_int_equal(s.modes, 0);
    assert_int_equal(s.verdict, STABILITY_STABLE);
    assert_true(s.agrees);
}

/* Negative damping, no force, a force that pushes away: the growth of each method beside the
 * eigenvalues of the scene, and measured. */
TEST(test_growth_of_scenes_that_grow)
{
    static const struct {
        double k, gamma, exact; /* [1/s] the larger real part of the eigenvalues, m = 1 */
        bool repelling;
    } cases[] = {{1, -0.2, 0.1, false},
                 {1, -4, 3.7320508075688773, false},
                 {-1, 0, 1, true},
                 {-1, 1, 0.61803398874989485, true},
                 {-1, -1, 1.6180339887498949, true},
                 {0, 1, 0, true},
                 {0, -1, 1, true}};
    int studied = 0;
    for (size_t c = 0; c < COUNT_OF(cases); c++) {
        const struct scene scene = scene_with(
            "spring", SETTINGS({"m", 1}, {"k", cases[c].k}, {"gamma", cases[c].gamma}, {"y0", 1}));
        for (size_t m = 0; m < method_catalog.count; m++) {
            if (!is_long() && (c + m) % 2 != 0)
                continue;
            const struct method *method = method_at(m);
            const struct stability_request request = {
                .scene = &scene, .choice = {method, 0}, .dt = 0.01, .duration = 10};
            struct stability s;
            struct error error;
            if (!study_stability(&request, &s, &error))
                continue;
            studied++;
            close_to(s.growth_exact, exp(0.01 * cases[c].exact), 1e-12);
            assert_int_equal(s.grows, cases[c].exact > 0);
            assert_int_equal(s.worst.sign != STIFFNESS_POSITIVE, cases[c].repelling);
            if (isnan(s.growth_predicted)) /* no amplification matrix: an adaptive-only method */
                continue;
            if (!s.agrees || s.checks < 1)
                fail_msg("%s, k %g, gamma %g: growth %.10g predicted, %.10g measured",
                         method->row.name, cases[c].k, cases[c].gamma, s.growth_predicted,
                         s.growth_measured);
            if (fabs(s.growth_predicted - s.growth_exact) > 1e-3)
                fail_msg("%s, k %g, gamma %g: growth %.10g a step, %.10g exactly", method->row.name,
                         cases[c].k, cases[c].gamma, s.growth_predicted, s.growth_exact);
        }
    }
    assert_true(studied > (is_long() ? 300 : 150));
}

/* omega dt = 1e148: what grows, overflows at once; what decays, vanishes. */
TEST(test_extremes_of_scale)
{
    const struct scene scene = scene_with("spring", SETTINGS({"m", 1}, {"k", 1e300}, {"y0", 1}));
    struct stability s = study(&scene, "verlet", 0.01);
    assert_true(s.agrees && isinf(s.growth_predicted) && isinf(s.growth_measured));
    close_to(s.dt_max * 1e150, 2, 1e-6);
    s = study(&scene, "backward-euler", 0.01);
    assert_true(s.agrees && s.growth_measured < 1e-10);
    assert_int_equal(s.verdict, STABILITY_STABLE);
}

TEST(test_region)
{
    const struct method_choice rk4 = {method_named("rk4"), 0},
                               verlet = {method_named("verlet"), DRAG_EXACT};
    close_to(stability_growth(&rk4, -1, 0), 1 - 1 + 1. / 2 - 1. / 6 + 1. / 24, 1e-7);
    close_to(stability_growth(&rk4, 0, 1), hypot(1 - 1. / 2 + 1. / 24, 1 - 1. / 6), 1e-12);
    close_to(stability_growth(&rk4, 0.5, 0), exp(0.5), 1e-3);
    close_to(stability_growth(&verlet, 0, 1.5), 1, 1e-12);
}

TEST(test_refusals)
{
    const struct scene scene = scene_with("damped", NO_SETTINGS);
    struct stability_request request = {
        .scene = &scene, .choice = {method_named("nystrom4"), 0}, .dt = 0.01, .duration = 1};
    struct stability s;
    struct error error;
    struct cancel cancel = {1};
    assert_false(study_stability(&request, &s, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    request.choice.method = method_named("rk4");
    request.dt = 0;
    assert_false(study_stability(&request, &s, &error));
    request.dt = 0.01;
    request.cancel = &cancel;
    assert_false(study_stability(&request, &s, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
}

RUN_TESTS(NULL, NULL)
