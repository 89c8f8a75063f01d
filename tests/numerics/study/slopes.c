/* SPDX-License-Identifier: GPL-3.0-or-later */
/* precision over the whole catalogue: every method that applies shows the order it claims, or says
 * that it does not. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include <hooke/study.h>

static int check(const char *preset, const struct method *method, double duration)
{
    struct scene scene;
    struct precision precision;
    struct error error = {0};
    const struct method_choice choice = {method, DRAG_DEFAULT};
    const struct row *row = catalog_find(&preset_catalog, text_of(preset));
    assert_non_null(row);
    scene_init(&scene, (const struct preset *)(const void *)row);
    const struct precision_request request = {.scene = &scene,
                                              .choice = &choice,
                                              .choices = 1,
                                              .dt = {ldexp(duration, -15), duration},
                                              .tol = {NAN, NAN},
                                              .duration = duration};
    int fitted = 0;
    if (study_precision(&request, &precision, &error)) {
        const struct precision_curve *curve = &precision.curve[0];
        fitted = curve->fitted;
        /* More than the claim is no lie: rodas5p has next to no error of order 5 on linear scenes.
         */
        if (curve->fitted && curve->differs && !(curve->slope > curve->expected)) {
            print_error("%s on %s: slope %.3f (%d points, R^2 %.5f), claimed %g\n",
                        method->row.name, preset, curve->slope, curve->fitted, curve->r2,
                        curve->expected);
            fail();
        }
        /* Errors fall until rounding: no point of the slope is better than the reference. */
        for (int i = 0; i < precision.points; i++)
            assert_false(precision.point[i].asymptotic && precision.point[i].below);
    }
    precision_free(&precision);
    return fitted;
}

static void test_every_method_on(const char *preset, double duration)
{
    int fitted = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method =
            (const struct method *)(const void *)catalog_row(&method_catalog, i);
        if (method->order > 0 && !(method->flags & METHOD_EXTERNAL))
            fitted += check(preset, method, duration) > 0;
    }
    assert_true(fitted >= 12);
}

static void test_damped(void **state)
{
    (void)state;
    test_every_method_on("damped", 2);
}

static void test_spring(void **state)
{
    (void)state;
    /* no whole number of quarter periods: the end is nothing special */
    test_every_method_on("spring", 2.3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_damped),
                                       cmocka_unit_test(test_spring)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
