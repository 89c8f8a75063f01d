/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes fitted to recordings of known truth: values, intervals, starts, held values, refusals. */
#include <hooke/base/cancel.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/scene/fit_testing.h"

struct case_of {
    const char *preset;
    struct setting truth[10], start[10];
    double rate, span, noise;
    const char *found; /* parameters whose values are compared */
};

static const struct case_of cases[] = {
    {"damped",
     {{"k", 15.11}, {"gamma", 0.024}, {"y0", 0.05}, {"v0", 0.1}},
     {{"gamma", 0.1}, {"y0", 0.01}},
     100,
     40,
     1e-4,
     "k gamma y0 v0"},
    {"drag",
     {{"m", 0.2166}, {"k", 15.1}, {"gamma", 0.012}, {"C", 0.5}, {"y0", 0.051}, {"v0", -0.2}},
     {{"m", 0.2166}},
     100,
     60,
     2e-4,
     "k gamma C y0 v0"},
    {"duffing",
     {{"gamma", 0.02}, {"k3", 0.8}, {"k", 1.1}, {"y0", 1.3}, {"v0", 0.4}},
     {{"k3", 0.4}, {"y0", 1}},
     20,
     120,
     2e-3,
     "k k3 gamma y0 v0"},
    {"pendulum",
     {{"length", 0.83}, {"gamma", 0.03}, {"theta0", 1.8}, {"rate0", 0.3}},
     {{"length", 1}, {"theta0", 1}},
     50,
     60,
     3e-3,
     "length gamma theta0 rate0"},
    {"vanderpol", {{"mu", 1.2}, {"y0", 1.5}}, {{"mu", 1}}, 20, 60, 1e-2, "k mu width y0 v0"},
    {"driven",
     {{"gamma", 0.3}, {"F0", 0.025}, {"phase", 0.4}, {"y0", 0.01}},
     {{"F0", 0.02}},
     50,
     30,
     1e-4,
     "k gamma F0 phase y0 v0"},
};

/* Fits of simulated recordings with noise, from a start beside the truth, converge to the true
 * values of all parameters in `found` and to the noise that was added. */
TEST(known_truths_are_found)
{
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct case_of *c = &cases[i];
        const struct scene truth = scene_with(c->preset, c->truth);
        struct scene start = scene_with(c->preset, c->start);
        random_state = 5 + i;
        struct recorded r = record(&truth, 0, c->rate, c->span, c->noise, 0.2);
        memset(start.chosen, 0, sizeof start.chosen); /* nothing is held */
        struct fitted f = fit_to(&start, &r.series, NULL, true);
        assert_converged(&f);
        struct text rest = text_of(c->found), name;
        while (text_split(&rest, ' ', &name) && name.len) {
            char word[LIMIT_NAME + 1] = "";
            memcpy(word, name.data, name.len);
            assert_found(&f, word, truth.value[scene_param(&truth, word)], 0.2);
        }
        close_to(f.fit.curve.sigma, c->noise, 0.1 * c->noise);
        arena_reset(&f.arena);
        forget(&r);
    }
}

/* ---- uncertainties ---- */

/* In 95 of 100 recordings the truth lies inside the interval: three standard deviations of that
 * count are allowed. */
TEST(intervals_cover_the_truth)
{
    const int trials = is_long() ? 200 : 10;
    const char *const names[] = {"k", "gamma", "C", "y0", "v0"};
    int inside = 0, asked = 0;
    random_state = 99;
    for (int trial = 0; trial < trials; trial++) {
        const struct scene truth = scene_with(
            "drag",
            SETTINGS({"k", 14 + 2 * random_uniform()}, {"gamma", 0.02 + 0.03 * random_uniform()},
                     {"C", 1 + random_uniform()}, {"y0", 0.05}, {"v0", random_uniform() - 0.5}));
        const struct scene start = scene_with("drag", NO_SETTINGS);
        struct recorded r = record(&truth, 0, 40, 25, 3e-4, 0.21);
        struct fitted f = fit_to(&start, &r.series, NULL, true);
        assert_converged(&f);
        for (size_t i = 0; i < COUNT_OF(names); i++) {
            const double value = truth.value[scene_param(&truth, names[i])];
            for (int j = 0; j < f.fit.curve.parameters; j++)
                if (strcmp(f.fit.name[j], names[i]) == 0) {
                    inside +=
                        f.fit.curve.interval[j][0] <= value && value <= f.fit.curve.interval[j][1];
                    asked++;
                }
        }
        arena_reset(&f.arena);
        forget(&r);
    }
    assert_int_equal(asked, trials * (int)COUNT_OF(names));
    print_message("%d of %d intervals hold the truth\n", inside, asked);
    /* The parameters of one recording are correlated: as if half as many were asked. */
    const double fraction = (double)inside / asked, spread = sqrt(0.95 * 0.05 / (0.5 * asked));
    assert_true(fabs(fraction - 0.95) < 3 * spread);
}

/* k follows from k/m: what is not known of m is not known of k. */
TEST(held_values_add_their_uncertainty)
{
    struct error error = {0};
    const struct scene truth = scene_with("damped", SETTINGS({"gamma", 0.1}));
    struct recorded r = record(&truth, 0, 50, 20, 1e-4, 0);
    struct scene start = truth;
    memset(start.chosen, 0, sizeof start.chosen);
    struct fitted exact = fit_to(&start, &r.series, "k gamma y0 v0", false);
    assert_true(scene_set(&start, scene_param(&start, "m"), (struct measured){0.2, 0.002}, &error));
    struct fitted loose = fit_to(&start, &r.series, "k gamma y0 v0", false);
    assert_converged(&exact);
    assert_converged(&loose);
    const struct measured k = fitted_value(&exact, "k"), wide = fitted_value(&loose, "k");
    close_to(wide.uncertainty, hypot(k.uncertainty, 0.01 * k.value), 1e-4 * wide.uncertainty);
    close_to(fitted_value(&loose, "gamma").uncertainty, fitted_value(&exact, "gamma").uncertainty,
             1e-6);
    arena_reset(&exact.arena);
    arena_reset(&loose.arena);
    forget(&r);
}

/* ---- what the series is ---- */

TEST(velocities_and_accelerations_are_fitted)
{
    const struct scene truth =
        scene_with("damped", SETTINGS({"k", 16}, {"gamma", 0.2}, {"y0", 0.04}, {"v0", 0.2}));
    const struct scene start = scene_with("damped", SETTINGS({"m", 0.2}));
    struct recorded r = record(&truth, 1, 50, 20, 1e-3, 0);
    struct fitted velocity = fit_to(&start, &r.series, "k gamma y0 v0", false);
    assert_converged(&velocity);
    assert_found(&velocity, "k", 16, 0.01);
    assert_found(&velocity, "y0", 0.04, 0.1);
    arena_reset(&velocity.arena);
    /* y'' = -(k/m) y - gamma v of a recorded motion */
    struct recorded y = record(&truth, 0, 50, 20, 0, 0);
    struct recorded v = record(&truth, 1, 50, 20, 0, 0);
    for (size_t i = 0; i < y.series.n; i++)
        y.y[i] = -16 / 0.2 * y.y[i] - 0.2 * v.y[i] + 1e-2 * random_normal();
    y.series.quantity = QUANTITY_ACCELERATION;
    struct fitted acceleration = fit_to(&start, &y.series, "k gamma y0 v0", false);
    assert_converged(&acceleration);
    assert_found(&acceleration, "k", 16, 0.01);
    assert_found(&acceleration, "gamma", 0.2, 0.1);
    assert_found(&acceleration, "v0", 0.2, 0.1);
    y.series.quantity = QUANTITY_MASS;
    struct fitted mass = fit_to(&start, &y.series, "k", false);
    assert_false(mass.ok);
    assert_int_equal(mass.error.code, ERROR_COMMAND);
    arena_reset(&acceleration.arena);
    arena_reset(&mass.arena);
    forget(&r);
    forget(&y);
    forget(&v);
}

/* ---- what the data do not tell, and what is not allowed ---- */

TEST(what_is_not_determined_is_not_converged)
{
    const struct scene truth = scene_with("damped", SETTINGS({"gamma", 0.1}));
    struct recorded r = record(&truth, 0, 50, 10, 1e-4, 0);
    struct fitted f = fit_to(&truth, &r.series, "m k gamma y0 v0", false); /* only k/m acts */
    assert_true(f.ok);
    assert_false(f.fit.curve.converged);
    arena_reset(&f.arena);
    forget(&r);
}

/* Without drag in the data C goes to its bound, where it has no uncertainty. */
TEST(ranges_hold)
{
    const struct scene truth = scene_with("damped", SETTINGS({"gamma", 0.01}));
    struct recorded r = record(&truth, 0, 50, 20, 1e-4, 0);
    for (size_t i = 0; i < r.series.n; i++) /* an envelope that bends the other way */
        r.y[i] *= 1 - 2e-4 * r.t[i] * r.t[i];
    struct scene start = scene_with("drag", NO_SETTINGS);
    struct fitted f = fit_to(&start, &r.series, "k gamma C y0 v0", false);
    assert_true(f.ok);
    const struct measured c = fitted_value(&f, "C");
    assert_true(c.value >= 0 && c.value < 1e-3);
    arena_reset(&f.arena);
    forget(&r);
}

TEST(a_held_start_must_come_first)
{
    const struct scene truth = scene_with("damped", SETTINGS({"gamma", 0.1}));
    struct recorded r = record(&truth, 0, 50, 10, 1e-4, 0);
    struct scene late = truth;
    struct error error = {0};
    assert_true(scene_set(&late, scene_param(&late, "t0"), (struct measured){3, 0}, &error));
    struct fitted fixed = fit_to(&late, &r.series, "k gamma", false);
    assert_false(fixed.ok);
    assert_int_equal(fixed.error.code, ERROR_COMMAND);
    /* t0 goes to the first sample */
    struct fitted moved = fit_to(&late, &r.series, "k gamma y0 v0", false);
    assert_converged(&moved);
    close_to(moved.fit.scene.value[scene_param(&late, "t0")], r.t[0], 0);
    struct fitted whole = fit_to(&truth, &r.series, "k gamma", false); /* the true start is held */
    assert_converged(&whole);
    assert_found(&whole, "k", 15, 0.001);
    arena_reset(&fixed.arena);
    arena_reset(&moved.arena);
    arena_reset(&whole.arena);
    forget(&r);
}

TEST(the_usual_parameters)
{
    struct error error = {0};
    int index[PARAM_MAX], fixed[PARAM_MAX], fixed_count;
    struct scene scene = scene_with("drag", NO_SETTINGS);
    assert_int_equal(scene_fit_usual(&scene, index, fixed, &fixed_count), 5); /* k gamma C y0 v0 */
    assert_int_equal(fixed_count, 0);
    const int k = scene_param(&scene, "k");
    assert_true(scene_set(&scene, k, (struct measured){15, 0}, &error));
    assert_int_equal(scene_fit_usual(&scene, index, fixed, &fixed_count), 4);
    assert_int_equal(fixed_count, 1);
    assert_int_equal(fixed[0], k);
    /* an estimate: fitted again */
    assert_true(scene_set(&scene, k, (struct measured){15, 0.1}, &error));
    assert_int_equal(scene_fit_usual(&scene, index, fixed, &fixed_count), 5);
}

TEST(spikes_do_not_pull)
{
    const struct scene truth = scene_with("damped", SETTINGS({"k", 15.5}, {"gamma", 0.05}));
    const struct scene start = scene_with("damped", NO_SETTINGS);
    struct recorded r = record(&truth, 0, 50, 20, 1e-4, 0.2);
    for (size_t i = 7; i < r.series.n; i += 23)
        r.y[i] += 0.03;
    struct fitted f = fit_to(&start, &r.series, NULL, true);
    assert_converged(&f);
    assert_found(&f, "k", 15.5, 0.001);
    assert_found(&f, "gamma", 0.05, 0.05);
    assert_true(f.fit.curve.rejected >= r.series.n / 23);
    arena_reset(&f.arena);
    forget(&r);
}

TEST(a_fit_can_be_stopped)
{
    const struct scene scene = scene_with("damped", NO_SETTINGS);
    struct recorded r = record(&scene, 0, 50, 20, 1e-4, 0);
    struct cancel cancel = {0};
    atomic_store(&cancel.requested, 1);
    const int index = scene_param(&scene, "k");
    struct arena arena = {0};
    struct scene_fit fit;
    struct error error = {0};
    const struct scene_fit_request request = {.scene = &scene,
                                              .series = &r.series,
                                              .free = &index,
                                              .frees = 1,
                                              .offset = true,
                                              .cancel = &cancel};
    assert_false(study_fit_scene(&request, &arena, &fit, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    arena_reset(&arena);
    forget(&r);
}

/* A stiff scene goes by rodas5p, whose Jacobian of the variational equations is that of second
 * derivatives. */
TEST(stiff_scenes_are_fitted)
{
    const struct scene truth =
        scene_with("prothero-robinson", SETTINGS({"lambda", -3}, {"y0", 1.7}));
    struct scene stiff =
        scene_with("overdamped", SETTINGS({"gamma", 3e5}, {"k", 4e4}, {"y0", 0.05}, {"C", 1e-3}));
    struct recorded slow = record(&truth, 0, 50, 10, 1e-3, 0);
    struct fitted f = fit_to(&truth, &slow.series, "lambda y0", false);
    assert_converged(&f);
    assert_found(&f, "lambda", -3, 0.1);
    arena_reset(&f.arena);
    forget(&slow);
    struct recorded r = record(&stiff, 0, 50, 10, 1e-5, 0);
    struct scene start = stiff;
    start.value[scene_param(&start, "k")] = 3.5e4;
    f = fit_to(&start, &r.series, "k y0", false);
    assert_converged(&f);
    assert_string_equal(f.fit.method->row.name, "rodas5p");
    assert_found(&f, "k", 4e4, 0.01);
    arena_reset(&f.arena);
    forget(&r);
    /* Noise of a stiff curve's derivatives moves steps by 1e-8 of an uncertainty: these are small.
     */
    for (int k = 0; k < (is_long() ? 200 : 8); k++) {
        r = record(&stiff, 0, 50, 10, k % 2 ? 1e-5 : 1e-7, 0);
        f = fit_to(&start, &r.series, "k y0", false);
        assert_converged(&f);
        assert_string_equal(f.fit.method->row.name, "rodas5p");
        arena_reset(&f.arena);
        forget(&r);
    }
}

/* ---- linear scenes: the exact solution, by steps that fit the times of the samples ---- */

/* A term too small to be seen makes the same scene one that is not linear, which is integrated. */
TEST(exact_and_integrated_curves_agree)
{
    const struct scene truth =
        scene_with("damped", SETTINGS({"k", 15.11}, {"gamma", 0.2}, {"v0", 0.1}));
    const struct scene linear = scene_with("damped", SETTINGS({"m", 0.2}));
    struct scene bent = scene_with("damped", SETTINGS({"m", 0.2}, {"k3", 1e-9}));
    random_state = 77;
    struct recorded r = record(&truth, 0, 60, 20, 1e-4, 0.2);
    for (int rounded = 0; rounded < 2; rounded++) {
        for (size_t i = 0; i < r.series.n && rounded; i++) /* as 1/60 s is printed; and a gap */
            r.t[i] = (round(1000 * r.t[i]) + (i > 600 ? 777 : 0)) / 1000;
        struct fitted exact = fit_to(&linear, &r.series, "k gamma y0 v0", true),
                      steps = fit_to(&bent, &r.series, "k gamma y0 v0", true);
        assert_true(exact.ok && steps.ok);
        assert_string_equal(exact.fit.method->row.name, "exact");
        assert_string_equal(steps.fit.method->row.name, "dop853");
        for (int j = 0; j < exact.fit.curve.parameters; j++) {
            const struct measured a = exact.fit.curve.value[j], b = steps.fit.curve.value[j];
            if (!(fabs(a.value - b.value) <= 1e-3 * a.uncertainty) ||
                !(fabs(a.uncertainty - b.uncertainty) <= 1e-3 * a.uncertainty))
                fail_msg("%s: %.12g +- %g exactly, %.12g +- %g by steps", exact.fit.name[j],
                         a.value, a.uncertainty, b.value, b.uncertainty);
        }
        arena_reset(&exact.arena);
        arena_reset(&steps.arena);
    }
    forget(&r);
}

/* The disk's drag is not linear: a linear law misses most where the motion is loud, which is no
 * outlier. */
TEST(a_loud_start_is_not_rejected)
{
    const struct scene truth =
        scene_with("drag", SETTINGS({"m", 0.2166}, {"k", 15.1}, {"gamma", 0.005}, {"C", 6},
                                    {"y0", 0.071}, {"v0", 0}));
    const struct scene start = scene_with("damped", SETTINGS({"m", 0.2166}));
    random_state = 12;
    struct recorded r = record(&truth, 0, 60, 60, 1e-4, 0.25);
    for (size_t i = 7; i < r.series.n; i += 97)
        r.y[i] += 0.03;
    struct fitted robust = fit_to(&start, &r.series, NULL, true);
    assert_true(robust.ok);
    assert_true(robust.fit.curve.rejected < r.series.n / 50);
    const double y0 = fitted_value(&robust, "y0").value;
    if (!(y0 > 0.055 && y0 < 0.071))
        fail_msg("y0 = %g m of 0.071, %zu rejected", y0, robust.fit.curve.rejected);
    arena_reset(&robust.arena);
    forget(&r);
}

/* More than are fitted at once: the same answer as the exact law demands, within its uncertainty.
 */
TEST(long_recordings_are_fitted)
{
    const struct scene truth =
        scene_with("damped", SETTINGS({"k", 15.11}, {"gamma", 0.01}, {"v0", 0.1}));
    const struct scene start = scene_with("damped", SETTINGS({"m", 0.2}));
    random_state = 41;
    struct recorded r = record(&truth, 0, 200, 150, 2e-4, 0.2);
    for (size_t i = 11; i < r.series.n; i += 50)
        r.y[i] -= 0.02;
    assert_true(r.series.n > 20000);
    struct fitted f = fit_to(&start, &r.series, NULL, true);
    assert_converged(&f);
    assert_found(&f, "k", 15.11, 1e-3);
    assert_found(&f, "gamma", 0.01, 0.1);
    assert_found(&f, "v0", 0.1, 0.1);
    assert_true(f.fit.curve.rejected >= r.series.n / 50 && f.fit.curve.rejected < r.series.n / 40);
    arena_reset(&f.arena);
    forget(&r);
}

RUN_TESTS(NULL, NULL)
