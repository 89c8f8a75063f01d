/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A reference that is wrong is found out by the runs that it calls wrong, and what cannot be
 * resolved is said. */
#include "cmocka_testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "modules/comparison/compute/verify.h"
#include "modules/comparison/compute/suspect.h"
#include "unit/scene/typing.h"

static const char *const duffing[] = {"var x = 1", "x'' = -x - x^3", NULL};

static struct method_choice named(const char *name)
{
    return (struct method_choice){method_by_name(text_of(name)), DRAG_DEFAULT};
}

/* The kept reference of a scene is bent by `by` in its second half: as if both of its methods had
 * missed a push. */
static void bend(struct references *references, const struct scene *scene, double span, double by)
{
    struct system system;
    struct reference reference;
    struct error error = {0};
    assert_true(scene_bind(scene, &system, &error));
    assert_true(references_get(references, scene, &system, span, NULL, &reference, &error));
    reference_free(&reference);
    for (int i = 0; i < REFERENCES_STORED; i++)
        for (int k = STUDY_TIMES / 2; k < STUDY_TIMES && references->stored[i].used; k++)
            references->stored[i].reference.y[k * system.n] += by;
}

TEST(test_wrong_one_is_computed_again)
{
    struct scene scene;
    struct error error = {0};
    struct references references = {0};
    struct typed_models *models = typed_create(&error);
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, duffing));
    bend(&references, &scene, 10, 0.01);
    const struct method_choice choice[] = {named("dopri5"), named("rodas5p")};
    const struct precision_request request = {.scene = &scene,
                                              .choice = choice,
                                              .choices = 2,
                                              .dt = {NAN, NAN},
                                              .tol = {1e-6, 1e-10},
                                              .duration = 10,
                                              .timing = TIMING_OFF,
                                              .references = &references};
    struct precision precision;
    assert_true(study_precision(&request, &precision, &error));
    assert_true(precision.reference.again && !precision.reference.dissenting_method[0]);
    assert_int_equal(precision.curves, 2);
    assert_int_equal(precision.points, 10);
    assert_true(precision.point[4].errors.max < 1e-8 && precision.point[9].errors.max < 1e-8);
    precision_free(&precision);
    assert_true(references_find(&references, &scene, 10)->again);
    assert_true(study_precision(&request, &precision, &error)); /* the new one is kept */
    assert_true(precision.reference.stored && precision.point[9].errors.max < 1e-8);
    precision_free(&precision);
    references_free(&references);
    typed_destroy(models);
}

/* Once it was computed again and is contradicted still, that is said, and the runs are not called
 * lost. */
TEST(test_what_stays_is_said)
{
    struct scene scene;
    struct error error = {0};
    struct references references = {0};
    struct typed_models *models = typed_create(&error);
    struct buffer text = {0};
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, duffing));
    bend(&references, &scene, 10, 2);
    for (int i = 0; i < REFERENCES_STORED; i++)
        references.stored[i].reference.again = true;
    const struct method_choice choice[] = {named("dopri5"), named("rodas5p")};
    const struct precision_request request = {.scene = &scene,
                                              .choice = choice,
                                              .choices = 2,
                                              .dt = {NAN, NAN},
                                              .tol = {1e-6, 1e-10},
                                              .duration = 10,
                                              .timing = TIMING_OFF,
                                              .references = &references};
    struct precision precision;
    struct arena arena = {0};
    assert_true(study_precision(&request, &precision, &error));
    assert_string_equal(precision.reference.dissenting_method[0]->row.name, "dopri5");
    assert_string_equal(precision.reference.dissenting_method[1]->row.name, "rodas5p");
    assert_true(fabs(precision.reference.apart * precision.reference.amplitude[0] - 2) < 0.01);
    reference_describe(&precision.reference, &text);
    assert_non_null(strstr(text.data, "which one is right is unknown"));
    assert_false(precision_rows(&precision, &arena)[0].resolved);
    buffer_free(&text);
    arena_reset(&arena);
    precision_free(&precision);
    references_free(&references);
    typed_destroy(models);
}

/* Runs that pass over what the reference has found, and so agree, are no witnesses. */
TEST(test_long_steps_are_no_witnesses)
{
    struct scene scene;
    struct system system;
    struct error error = {0};
    struct typed_models *models = typed_create(&error);
    const char *lines[] = {"var x = 0", "x' = exp(-((t - 5.123)/1e-4)^2)*1e4/sqrt(pi)", NULL};
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    assert_true(scene_bind(&scene, &system, &error));
    const struct method_choice choice[] = {named("dopri5"), named("rodas5p")};
    const struct precision_request request = {.scene = &scene,
                                              .choice = choice,
                                              .choices = 2,
                                              .dt = {NAN, NAN},
                                              .tol = {1e-6, 1e-10},
                                              .duration = 10,
                                              .timing = TIMING_OFF};
    struct precision precision;
    assert_true(study_precision(&request, &precision, &error));
    assert_true(precision.reference.shortest > 0 && precision.reference.shortest < 0.1);
    assert_false(precision.reference.again || precision.reference.dissenting_method[0]);
    assert_true(precision.point[4].errors.max > 0.9);
    precision_free(&precision);
    typed_destroy(models);
}

RUN_TESTS(NULL, NULL)
