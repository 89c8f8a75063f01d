/* SPDX-License-Identifier: GPL-3.0-or-later */
/* reference: closed forms, two kinds that agree, what is said of chaos, of cancellation and of
 * scenes that blow up. */
#include "cmocka_testing.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include "modules/solving/compute/solve.h"

#include "modules/comparison/compute/verify.h"
#include "long_form.h"
#include "unit/scene/typing.h"

static void bind(const char *preset, const char *param, double value, struct system *system)
{
    struct scene scene;
    struct error error = {0};
    const struct row *row = catalog_find(&preset_catalog, text_of(preset));
    assert_non_null(row);
    scene_init(&scene, preset_from(row));
    if (param) {
        const int index = scene_param(&scene, param);
        assert_true(index >= 0);
        assert_true(scene_set(&scene, index, (struct measured){value, 0}, &error));
    }
    assert_true(scene_bind(&scene, system, &error));
}

TEST(test_closed_form)
{
    struct system system;
    struct reference reference;
    struct error error = {0};
    bind("spring", NULL, 0, &system);
    assert_true(study_reference(&system, 10, NULL, &reference, &error));
    assert_true(reference.exact && !reference.method[0]);
    assert_int_equal(reference.scored, 1);
    assert_true(reference.amplitude[0] > 0.0499 && reference.amplitude[0] <= 0.05);
    /* eps omega t is 2e-14. */
    assert_true(reference.accuracy > 1e-15 && reference.accuracy < 1e-13);
    for (int k = 0; k < STUDY_TIMES; k++)
        assert_true(fabs(reference.y[2 * k] - 0.05 * cos(sqrt(75) * 10 * k / (STUDY_TIMES - 1))) <
                    1e-14);
    reference_free(&reference);
}

/* A linear scene whose closed form is hidden: both kinds must give it, to what they claim. */
TEST(test_two_kinds_against_the_truth)
{
    static const char *const presets[] = {"spring", "damped", "driven"};
    for (size_t i = 0; i < COUNT_OF(presets); i++) {
        struct system system, hidden;
        struct reference truth, found;
        struct error error = {0};
        bind(presets[i], NULL, 0, &system);
        hidden = system;
        hidden.oscillator.whole = hidden.linear = false;
        assert_false(system_has_exact(&hidden));
        assert_true(study_reference(&system, 10, NULL, &truth, &error));
        assert_true(study_reference(&hidden, 10, NULL, &found, &error));
        assert_false(found.exact);
        assert_ptr_not_equal(found.method[0], found.method[1]);
        assert_true(found.accuracy < 1e-9);
        double max = 0;
        for (int k = 0; k < STUDY_TIMES; k++)
            max = fmax(max, fabs(found.y[2 * k] - truth.y[2 * k]) / truth.amplitude[0]);
        if (!(max <= 3 * found.accuracy + 1e-12)) {
            print_error("%s: off by %g, claimed %g\n", presets[i], max, found.accuracy);
            fail();
        }
        assert_true(found.meaning == found.span);
        reference_free(&truth);
        reference_free(&found);
    }
}

TEST(test_quadratic_drag)
{
    struct system system;
    struct reference reference;
    struct error error = {0};
    struct buffer text = {0};
    bind("drag", NULL, 0, &system);
    assert_true(study_reference(&system, 10, NULL, &reference, &error));
    assert_false(reference.exact);
    assert_true(reference.accuracy < 1e-8);
    reference_describe(&reference, &text);
    assert_non_null(strstr(text.data, reference.method[0]->row.name));
    assert_non_null(strstr(text.data, reference.method[1]->row.name));
    assert_non_null(strstr(text.data, "agree to"));
    assert_null(strstr(text.data, "differ from"));
    buffer_free(&text);
    reference_free(&reference);
}

/*
 * Pulses so short that steps of all methods pass over them, of area 1 at t = 5.123 s: one that is
 * typed, one whose clock is a variable, and one as a drive of the spring, which gives it a push J:
 * y = y0 cos(w t) + J/(m w) sin(w (t
 * - 5.123)).
 */
TEST(test_narrow_pulses)
{
    static const char *const pulses[][5] = {
        {"var x = 0", "param w = 1", "x' = exp(-((t - 5.123)/w)^2)/(w*sqrt(pi))"},
        {"var x = 0", "var y = 0", "param w = 1", "y' = 1",
         "x' = exp(-((y - 5.123)/w)^2)/(w*sqrt(pi))"},
        {"param w = 1", "force 0.2*exp(-((t - 5.123)/w)^2)/(w*sqrt(pi))"},
    };
    for (size_t i = 0; i < COUNT_OF(pulses); i++)
        for (size_t k = 0; k < 3; k++) {
            const double width = pow(10, -3 - 2 * (double)k);
            if (!is_long() && k != (i + 2) % 3)
                continue;
            struct scene scene;
            struct system system;
            struct reference reference;
            struct error error = {0};
            struct typed_models *models = typed_create(&error);
            const char *lines[6] = {0};
            memcpy(lines, pulses[i], sizeof pulses[i]);
            scene_init(&scene, NULL);
            assert_true(type_scene(models, &scene, lines));
            assert_true(
                scene_set(&scene, scene_param(&scene, "w"), (struct measured){width, 0}, &error));
            assert_true(scene_bind(&scene, &system, &error));
            if (!study_reference(&system, 10, NULL, &reference, &error))
                fail_msg("%s, width %g: %s", pulses[i][0], width, error.text);
            const double omega = sqrt(75), t = 10,
                         *end = reference.y + (STUDY_TIMES - 1) * system.n;
            const double right =
                i < 2 ? 1 : 0.05 * cos(omega * t) + sin(omega * (t - 5.123)) / omega;
            const double off = fabs(end[0] - right) / reference.amplitude[0];
            /* of the clock, which has eps/w of a short pulse's digits; the push of one is over at
             * once, else (w omega)^2 */
            const double max =
                1e-11 + 16 * DBL_EPSILON * 5 / width + (i == 2 ? pow(width * omega, 2) : 0);
            if (!(off <= max && reference.accuracy <= 1e-11 + 16 * DBL_EPSILON * 5 / width))
                fail_msg("scene %zu, width %g: %.17g for %.17g, accuracy %g", i, width, end[0],
                         right, reference.accuracy);
            reference_free(&reference);
            typed_destroy(models);
        }
}

/*
 * Pulses that only the solution leads to: at each passage of a swing, behind a pulse that starts a
 * clock, and more of them than one in each interval of the grid. A pulse of area 1 in y adds
 * 1/|y'|.
 */
TEST(test_pulses_on_the_way)
{
    static const struct {
        const char *lines[7];
        double right;
        double off; /* 1e-8, and the rounding of what is typed */
    } cases[] = {
        {{"var x = 0", "var y = 1", "var z = 0", "x' = exp(-((y - 0.3)/1e-6)^2)/1e-6/sqrt(pi)",
          "y' = z", "z' = -y"},
         3.1448545101657551,
         1e-8}, /* 3/sqrt(1 - 0.09) */
        {{"var x = 0", "var y = 0", "var z = 0", "z' = exp(-((t - 2.2)/1e-5)^2)/1e-5/sqrt(pi)",
          "y' = z", "x' = exp(-((y - 3.1)/1e-6)^2)/1e-6/sqrt(pi)"},
         1,
         1e-8},
        {{"var x = 0", "x' = exp(-1e10*(sin(t) - 0.5)^2)*1e5/sqrt(pi)"},
         4.6188021535170058,
         1e-8}, /* 4/cos(pi/6) */
        {{"var x = 0", "x' = exp(-(t*t - 2*5.123*t + 5.123^2)/1e-8)*1e4/sqrt(pi)"},
         1,
         2e-7}, /* of (t - 5.123)^2 */
        {{"var x = 0", "x' = exp(-((mod(t, 0.1) - 0.0512)/1e-6)^2)/1e-6/sqrt(pi)"}, 100, 1e-8},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        if (!is_long() && i != 2) /* about a second each */
            continue;
        struct scene scene;
        struct system system;
        struct reference reference;
        struct error error = {0};
        struct typed_models *models = typed_create(&error);
        const char *lines[8] = {0};
        memcpy(lines, cases[i].lines, sizeof cases[i].lines);
        scene_init(&scene, NULL);
        assert_true(type_scene(models, &scene, lines));
        assert_true(scene_bind(&scene, &system, &error));
        assert_true(study_reference(&system, 10, NULL, &reference, &error));
        const double end = reference.y[(STUDY_TIMES - 1) * system.n];
        if (!(fabs(end - cases[i].right) <= cases[i].off))
            fail_msg("%s: %.17g for %.17g, accuracy %g", cases[i].lines[1], end, cases[i].right,
                     reference.accuracy);
        reference_free(&reference);
        typed_destroy(models);
    }
}

/* More to do than there is time for: that is said, within seconds. */
TEST(test_too_much_to_do)
{
    struct scene scene;
    struct system system;
    struct reference reference;
    struct error error = {0};
    struct typed_models *models;
    const char *lines[] = {"var x = 0", "x' = sin(1e4*t) + 1e6*exp(-((t - 5.123)/1e-6)^2)", NULL};
    if (!is_long()) /* some seconds */
        skip();
    models = typed_create(&error);
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    assert_true(scene_bind(&scene, &system, &error));
    const int64_t begin = clock_cpu_ns();
    assert_false(study_reference(&system, 40, NULL, &reference, &error));
    assert_non_null(strstr(error.text, "evaluations"));
    assert_true((double)(clock_cpu_ns() - begin) * 1e-9 < 60); /* 4 in a release */
    typed_destroy(models);
}

TEST(test_cancelled)
{
    struct system system;
    struct reference reference;
    struct error error = {0};
    struct cancel cancel = {0};
    bind("drag", NULL, 0, &system);
    atomic_store(&cancel.requested, 1);
    assert_false(study_reference(&system, 10, &cancel, &reference, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    assert_null(reference.y);
}

/* Chaos amplifies rounding until the two references part: this must be said, with the time. */
TEST(test_loss_of_meaning)
{
    if (!catalog_find(&preset_catalog, TEXT("duffing-driven"))) {
        print_message("no chaotic scene\n");
        skip();
    }
    struct system system;
    struct reference reference;
    struct error error = {0};
    struct buffer text = {0};
    bind("duffing-driven", NULL, 0, &system);
    assert_true(study_reference(&system, 600, NULL, &reference, &error));
    assert_true(reference.accuracy > 1e-3);
    assert_true(reference.meaning > 60 && reference.meaning < 600);
    reference_describe(&reference, &text);
    assert_non_null(strstr(text.data, "; from then on they differ"));
    assert_non_null(strstr(text.data, "chaos"));
    buffer_free(&text);
    reference_free(&reference);
}

RUN_TESTS(NULL, NULL)
