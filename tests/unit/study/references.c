/* SPDX-License-Identifier: GPL-3.0-or-later */
/* References that are kept: the same scene finds its own, to the bit, and any change of it makes
 * another one. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/study.h>

#include "long_form.h"
#include "unit/scene/typing.h"

/* Whether it was kept; what is there equals what is computed anew. */
static bool stored(struct references *references, const struct scene *scene, double span)
{
    struct system system;
    struct reference reference, anew;
    struct error error = {0};
    assert_true(scene_bind(scene, &system, &error));
    const bool expected = references_find(references, scene, span) != NULL;
    assert_true(references_get(references, scene, &system, span, NULL, &reference, &error));
    assert_true(study_reference(&system, span, NULL, &anew, &error));
    assert_memory_equal(reference.y, anew.y, sizeof *anew.y * (size_t)(STUDY_TIMES * anew.n));
    assert_true(reference.accuracy == anew.accuracy && reference.by[0] == anew.by[0]);
    assert_int_equal(reference.stored, expected);
    assert_non_null(references_find(references, scene, span));
    const bool found = reference.stored;
    reference_free(&reference);
    reference_free(&anew);
    return found;
}

static void scene_of(const char *preset, struct scene *scene)
{
    scene_init(scene,
               (const struct preset *)(const void *)catalog_find(&preset_catalog, text_of(preset)));
}

static void test_every_parameter(void **state)
{
    (void)state;
    static const char *const presets[] = {"drag", "pendulum", "duffing-driven", "elastic-pendulum",
                                          "kepler"};
    for (size_t i = 0; i < COUNT_OF(presets); i++) {
        struct references references = {0};
        struct scene scene;
        struct error error = {0};
        scene_of(presets[i], &scene);
        assert_false(stored(&references, &scene, 1));
        assert_true(stored(&references, &scene, 1));
        for (size_t p = is_long() ? 0 : i % 3; p < scene.model->params->count;
             p += is_long() ? 1 : 3) {
            struct scene other = scene;
            struct system system;
            const double value = scene.value[p];
            if (!scene_set(&other, (int)p,
                           (struct measured){value == 0 ? 1e-3 : value * (1 + 1e-15), 0}, &error) ||
                other.value[p] == value || !scene_bind(&other, &system, &error))
                continue;
            assert_false(stored(&references, &other, 1));
            assert_true(stored(&references, &other, 1));
            assert_true(stored(&references, &scene, 1));
        }
        struct scene loose = scene;
        loose.atol[0] = 1e-9;
        assert_false(stored(&references, &loose, 1));
        assert_false(stored(&references, &scene, nextafter(1, 2)));
        assert_true(stored(&references, &scene, 1));
        references_free(&references);
    }
}

static void test_typed_lines(void **state)
{
    (void)state;
    static const char *const lines[] = {"var x = 1", "param c = 2", "x'' = -c*sin(x)", NULL};
    static const char *const more[] = {"x'' = -c*sin(x) - 0.1*x'", "var x = 1.5", "force 0.001*t"};
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    struct references references = {0};
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    assert_false(stored(&references, &scene, 2));
    const struct scene first = scene;
    for (size_t i = 0; i < 2; i++) {
        const char *const line[] = {more[i], NULL};
        assert_true(type_scene(models, &scene, line));
        assert_false(stored(&references, &scene, 2));
        assert_true(stored(&references, &scene, 2));
    }
    assert_true(stored(&references, &first, 2));
    struct scene spring;
    scene_of("spring", &spring);
    assert_false(stored(&references, &spring, 2));
    const char *const force[] = {more[2], NULL};
    assert_true(type_scene(models, &spring, force));
    assert_false(stored(&references, &spring, 2));
    references_free(&references);
    typed_destroy(models);
}

/* As many as REFERENCES, those used last; that there is none, and why, is kept, too. */
static void test_those_used_last(void **state)
{
    (void)state;
    struct references references = {0};
    struct scene scene;
    scene_of("drag", &scene);
    for (int i = 0; i < REFERENCES; i++)
        assert_false(stored(&references, &scene, 1 + i));
    assert_true(stored(&references, &scene, 1));
    assert_false(stored(&references, &scene, 1 + REFERENCES));
    assert_true(stored(&references, &scene, 1));
    assert_false(stored(&references, &scene, 2));
    references_free(&references);

    static const char *const lines[] = {"var x = 1", "x' = x^2", NULL};
    struct error error = {0}, again = {0};
    struct typed_models *models = typed_create(&error);
    struct reference reference;
    struct system system;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    assert_true(scene_bind(&scene, &system, &error));
    assert_false(references_get(&references, &scene, &system, 2, NULL, &reference, &error));
    assert_false(references_get(&references, &scene, &system, 2, NULL, &reference, &again));
    assert_null(reference.y);
    assert_true(fabs(reference.singular.t - 1) < 1e-6);
    assert_string_equal(error.text, again.text);
    assert_int_equal(references.uses, 2);
    assert_null(references_find(&references, &scene, 2));

    /* What was stopped is no answer. */
    struct cancel cancel = {0};
    atomic_store(&cancel.requested, 1);
    scene_of("drag", &scene);
    assert_true(scene_bind(&scene, &system, &error));
    assert_false(references_get(&references, &scene, &system, 9, &cancel, &reference, &error));
    assert_false(stored(&references, &scene, 9));
    references_free(&references);
    typed_destroy(models);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_parameter),
        cmocka_unit_test(test_typed_lines),
        cmocka_unit_test(test_those_used_last),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
