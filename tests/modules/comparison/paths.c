/* SPDX-License-Identifier: GPL-3.0-or-later */
/* By which code studies solve and time: the same for all methods that are ranked against each
 * other. */
#include <math.h>
#include "cmocka_testing.h"

#include "modules/comparison/compute/verify.h"
#include "modules/solving/testing.h"

static const char *const scenes[] = {"spring", "damped", "drag", "duffing", "driven", "vanderpol"};

enum { SCENES = COUNT_OF(scenes), METHODS = 7 };

/* Runge-Kutta, splittings, implicit. */
static const char *const methods[METHODS] = {
    "euler",           "midpoint",         "rk4", "symplectic-euler", "verlet",
    "position-verlet", "implicit-midpoint"};

static void choices_for(const struct scene *scene, struct method_choice *choice)
{
    struct system system;
    struct error error = {0};
    assert_true(scene_bind(scene, &system, &error));
    for (int i = 0; i < METHODS; i++) {
        choice[i] = (struct method_choice){method_named(methods[i]), DRAG_DEFAULT};
        if (!method_applies(choice[i].method, &system, &choice[i].drag,
                            &error)) /* van der Pol's force */
            choice[i].drag = DRAG_EXPLICIT;
    }
}

TEST(test_seven_methods_on_six_scenes)
{
    for (int s = 0; s < SCENES; s++) {
        const struct scene scene = scene_with(scenes[s], NO_SETTINGS);
        struct method_choice choice[METHODS];
        choices_for(&scene, choice);
        const double dt = 0.01;
        const struct compare_request compare = {.scene = &scene,
                                                .choice = choice,
                                                .choices = METHODS,
                                                .dt = &dt,
                                                .dts = 1,
                                                .duration = 0.5};
        struct comparison row[METHODS];
        struct error error = {0};
        int count = 0;
        assert_true(study_compare(&compare, row, &count, &error));
        assert_int_equal(count, METHODS);
        for (int i = 0; i < METHODS; i++) {
            if (row[i].path != KERNEL_SPECIALISED)
                print_error("compare: %s on %s is %s\n", methods[i], scenes[s],
                            catalog_row(&kernel_catalog, row[i].path)->name);
            assert_int_equal(row[i].path, KERNEL_SPECIALISED);
            comparison_free(&row[i]);
        }
        const struct precision_request request = {.scene = &scene,
                                                  .choice = choice,
                                                  .choices = METHODS,
                                                  .dt = {0.5 / 64, 0.5 / 64},
                                                  .tol = {NAN, NAN},
                                                  .duration = 0.5};
        struct precision precision;
        assert_true(study_precision(&request, &precision, &error));
        assert_int_equal(precision.points, METHODS);
        for (int i = 0; i < METHODS; i++)
            assert_int_equal(precision.point[i].path, KERNEL_SPECIALISED);
        precision_free(&precision);
    }
}

/* Which families have code of their own; with steps of a fixed size, all of them or none, whatever
 * the scene. */
static bool has_kernels(const struct method *method, const struct system *system)
{
    return method->tableau || method->splitting ||
           (method->implicit && method->order <= 2 && system->n == 2); /* stages one by one */
}

TEST(test_families)
{
    static const char *const shapes[] = {"spring",    "damped",   "drag",   "duffing",     "driven",
                                         "vanderpol", "pendulum", "kepler", "henon-heiles"};
    for (size_t s = 0; s < COUNT_OF(shapes); s++) {
        const struct scene scene = scene_with(shapes[s], NO_SETTINGS);
        struct system system;
        struct error error = {0};
        assert_true(scene_bind(&scene, &system, &error));
        for (size_t m = 0; m < method_catalog.count; m++)
            for (enum drag drag = DRAG_DEFAULT; drag < DRAG_COUNT; drag++) {
                struct run_settings settings = {
                    .dt = 0.01, .drag = drag, .kernel = KERNEL_SPECIALISED};
                if (!method_applies(method_at(m), &system, &settings.drag, &error))
                    continue;
                const enum kernel wanted =
                    has_kernels(method_at(m), &system) ? KERNEL_SPECIALISED : KERNEL_GENERAL;
                const enum kernel path = study_path(&system, method_at(m), &settings);
                if (path != wanted)
                    fail_msg("%s on %s is %s", method_at(m)->row.name, shapes[s],
                             catalog_row(&kernel_catalog, path)->name);
                settings.compensated = true; /* nobody has kernels for these sums */
                assert_int_equal(study_path(&system, method_at(m), &settings), KERNEL_GENERAL);
            }
    }
}

/* A combination of terms for which no kernel of its own was compiled (no shape): Runge-Kutta
 * methods and splittings still all use specialised code, and others the general one. */
TEST(test_forces_without_a_shape)
{
    const struct scene scene = scene_with("drag", SETTINGS({"g", 9.81}, {"F0", 0.1}, {"k3", 20}));
    struct system system;
    struct error error = {0};
    assert_true(scene_bind(&scene, &system, &error));
    for (size_t m = 0; m < method_catalog.count; m++) {
        struct run_settings settings = {.dt = 0.01, .kernel = KERNEL_SPECIALISED};
        if (!method_applies(method_at(m), &system, &settings.drag, &error))
            continue;
        const bool special = method_at(m)->tableau || method_at(m)->splitting;
        assert_int_equal(study_path(&system, method_at(m), &settings),
                         special ? KERNEL_SPECIALISED : KERNEL_GENERAL);
        settings.kernel = KERNEL_GENERAL;
        assert_int_equal(study_path(&system, method_at(m), &settings), KERNEL_GENERAL);
    }
}

RUN_TESTS(NULL, NULL)
