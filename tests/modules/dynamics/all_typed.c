/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The text in a term's row says what its function computes: for every preset, and for every model
 * with all of its terms, at random points. */
#include "cmocka_testing.h"

#include "unit/scene/typing.h"
#include "modules/dynamics/orbits/forms.h"

#include <hooke/base/catalog.h>
#include <hooke/base/numeric.h>

#include <float.h>
#include <math.h>

#define POINTS 40
#define ULP 8.0 /* of what is added up */

static struct typed_models *models;

/* What the terms add, each with its sign taken away. */
static double size_of_row(const struct system *system, double t, const double *y, int row)
{
    double size = 0;
    for (int i = 0; i < system->terms; i++) {
        double part[LIMIT_VARIABLES] = {0};
        system->term[i].row->add(system->term[i].c, t, y, part);
        size += fabs(part[row]);
    }
    return size;
}

/* The largest distance of two scenes' right-hand sides, in ulp of what is added up; within the
 * bounds of the texts, where nothing depends on time. */
static double distance(const struct scene *scene, const struct scene *written, bool *inside)
{
    struct system a, b;
    struct error error = {0};
    uint64_t seed = 5;
    double largest = 0;
    assert_true(scene_bind_motion(scene, &a, &error));
    if (!scene_bind_motion(written, &b, &error))
        fail_msg("%s", error.text);
    assert_int_equal(a.n, b.n);
    for (int k = 0; k < POINTS; k++) {
        double y[LIMIT_VARIABLES], rate[2][LIMIT_VARIABLES];
        struct interval box[LIMIT_VARIABLES], bounds[LIMIT_VARIABLES];
        for (int i = 0; i < a.n; i++) {
            y[i] = a.start[i] + a.scale[i] * (2 * random_fraction(&seed) - 1);
            box[i] = (struct interval){y[i], y[i]};
        }
        const double t = 10 * random_fraction(&seed);
        system_derivative(&a, t, y, rate[0]);
        system_derivative(&b, t, y, rate[1]);
        const bool bounded = a.autonomous && system_bounds(&b, box, bounds, NULL);
        *inside = *inside && bounded == a.autonomous;
        for (int i = 0, above = a.order == 2 ? a.n / 2 : 0; i < a.n; i++) {
            const double wide = bounded ? bounds[i].hi - bounds[i].lo : 0;
            const double size =
                i < above ? fabs(y[above + i]) : size_of_row(&a, t, y, i - above) + wide / 1e-15;
            const double apart = fabs(rate[0][i] - rate[1][i]);
            largest = fmax(largest, apart > 0 ? apart / (DBL_EPSILON * size) : 0);
            *inside = *inside && (!bounded || (rate[0][i] >= bounds[i].lo - 4 * wide &&
                                               rate[0][i] <= bounds[i].hi + 4 * wide));
        }
    }
    return largest;
}

static void same_as_written(const struct scene *scene)
{
    struct scene written;
    struct error error = {0};
    bool inside = true;
    if (!typed_written(models, scene, &written, &error))
        fail_msg("%s: %s", scene->model->row.name, error.text);
    const double apart = distance(scene, &written, &inside);
    if (!(apart <= ULP) || !inside)
        fail_msg("%s %s: %g ulp%s", scene->model->row.name, scene->preset->row.name, apart,
                 inside ? "" : ", out of bounds");
}

static void test_presets(void **state)
{
    (void)state;
    for (size_t i = 0; i < preset_catalog.count; i++) {
        struct scene scene;
        scene_init(&scene, preset_at(i));
        same_as_written(&scene);
    }
}

static void all_terms(struct scene *scene, const struct preset *preset)
{
    struct error error = {0};
    scene_init(scene, preset);
    for (size_t i = 0; i < scene->model->params->count; i++) {
        const double value = scene->value[i] != 0 ? 1.1 * scene->value[i] : 0.37;
        if (strcmp(param_at(scene, (int)i)->row.name, "t0") != 0 &&
            !scene_set(scene, (int)i, (struct measured){value, 0}, &error))
            fail_msg("%s", error.text);
    }
}

/* Every term of every model is there, and has a text. */
static void test_models(void **state)
{
    (void)state;
    for (int i = 0; scene_models[i]; i++) {
        const struct preset preset = {.row = {"all", "", "", "", NULL}, .model = scene_models[i]};
        struct scene scene;
        struct system system;
        struct error error = {0};
        all_terms(&scene, &preset);
        if (!scene_bind_motion(&scene, &system, &error))
            fail_msg("%s: %s", scene.preset->row.name, error.text);
        assert_int_equal(system.terms, scene.model->terms->count);
        same_as_written(&scene);
    }
}

/* What was typed on top is taken along, by the names that it had there. */
static void test_on_top(void **state)
{
    (void)state;
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene,
                           (const char *const[]){"param q = 0.25", "observe speed = abs(v)",
                                                 "force -q*v*speed+k*y^2+C", NULL}));
    same_as_written(&scene);
    const struct preset *pendulum = preset_by_name(TEXT("pendulum"));
    scene_init(&scene, pendulum);
    assert_true(type_scene(models, &scene,
                           (const char *const[]){"force -0.02*rate*abs(rate)*length", NULL}));
    same_as_written(&scene);
}

/* The comparison sees a change of one part in 1e14. */
static void test_negative_control(void **state)
{
    (void)state;
    struct scene scene, written;
    struct error error = {0};
    bool inside = true;
    scene_init(&scene, NULL);
    assert_true(typed_written(models, &scene, &written, &error));
    scene.value[scene_param(&scene, "k")] *= 1 + 1e-14;
    assert_true(distance(&scene, &written, &inside) > ULP);
}

int main(void)
{
    struct error error = {0};
    models = typed_create(&error);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_presets),
        cmocka_unit_test(test_models),
        cmocka_unit_test(test_on_top),
        cmocka_unit_test(test_negative_control),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    typed_destroy(models);
    return failed;
}
