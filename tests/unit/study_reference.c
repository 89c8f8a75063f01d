/* SPDX-License-Identifier: GPL-3.0-or-later */
/* reference: closed forms, two kinds that agree, what is said of chaos, of cancellation and of scenes that blow up. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include <hooke/study.h>

static void bind(const char *preset, const char *param, double value, struct system *system)
{
    struct scene scene;
    struct error error = {0};
    const struct row *row = catalog_find(&preset_catalog, text_of(preset));
    assert_non_null(row);
    scene_init(&scene, (const struct preset *)(const void *)row);
    if (param) {
        const int place = scene_param(&scene, param);
        assert_true(place >= 0);
        assert_true(scene_set(&scene, place, (struct measured){value, 0}, &error));
    }
    assert_true(scene_bind(&scene, system, &error));
}

static void test_closed_form(void **state)
{
    (void)state;
    struct system system;
    struct reference reference;
    struct error error = {0};
    bind("spring", NULL, 0, &system);
    assert_true(study_reference(&system, 10, NULL, &reference, &error));
    assert_true(reference.exact && !reference.by[0]);
    assert_int_equal(reference.scored, 1);
    assert_true(reference.amplitude[0] > 0.0499 && reference.amplitude[0] <= 0.05);
    /* eps omega t is 2e-14. */
    assert_true(reference.accuracy > 1e-15 && reference.accuracy < 1e-13);
    for (int k = 0; k < STUDY_TIMES; k++)
        assert_true(fabs(reference.y[2 * k] - 0.05 * cos(sqrt(75) * 10 * k / (STUDY_TIMES - 1))) < 1e-14);
    reference_free(&reference);
}

/* A linear scene whose closed form is hidden: both kinds must give it, to what they claim. */
static void test_two_kinds_against_the_truth(void **state)
{
    (void)state;
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
        assert_ptr_not_equal(found.by[0], found.by[1]);
        assert_true(found.accuracy < 1e-9);
        double most = 0;
        for (int k = 0; k < STUDY_TIMES; k++)
            most = fmax(most, fabs(found.y[2 * k] - truth.y[2 * k]) / truth.amplitude[0]);
        if (!(most <= 3 * found.accuracy + 1e-12)) {
            print_error("%s: off by %g, claimed %g\n", presets[i], most, found.accuracy);
            fail();
        }
        assert_true(found.meaning == found.span);
        reference_free(&truth);
        reference_free(&found);
    }
}

static void test_quadratic_drag(void **state)
{
    (void)state;
    struct system system;
    struct reference reference;
    struct error error = {0};
    struct buffer text = {0};
    bind("drag", NULL, 0, &system);
    assert_true(study_reference(&system, 10, NULL, &reference, &error));
    assert_false(reference.exact);
    assert_true(reference.accuracy < 1e-8);
    reference_describe(&reference, &text);
    assert_non_null(strstr(text.data, reference.by[0]->row.name));
    assert_non_null(strstr(text.data, reference.by[1]->row.name));
    assert_non_null(strstr(text.data, "agree to"));
    assert_null(strstr(text.data, "part at"));
    buffer_free(&text);
    reference_free(&reference);
}

static void test_cancelled(void **state)
{
    (void)state;
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
static void test_loss_of_meaning(void **state)
{
    (void)state;
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
    assert_non_null(strstr(text.data, "they part at"));
    buffer_free(&text);
    reference_free(&reference);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_form),     cmocka_unit_test(test_two_kinds_against_the_truth),
        cmocka_unit_test(test_quadratic_drag),  cmocka_unit_test(test_cancelled),
        cmocka_unit_test(test_loss_of_meaning),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
