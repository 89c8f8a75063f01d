/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lanes of typed scenes without memory: refused, and good again afterwards; their steps never
 * allocate. */
#include "cmocka_testing.h"

#include "unit/scene/typing.h"

#include "modules/lanes/lanes.h"

#include "faults/failing_malloc.h"

/* At least so many allocations make room; each may fail, and nothing is allocated afterwards. */
static void go_in_lanes(struct lanes *lanes, const struct system *system, int least)
{
    const struct method *rk4 = method_by_name(TEXT("rk4"));
    malloc_calls = 0;
    assert_true(lanes_fit(rk4, system, DRAG_DEFAULT, 0.01));
    assert_int_equal(malloc_calls, 0);
    int failed = 0;
    for (long at = 0; failed == at; at++) { /* one after the other, until nothing fails */
        malloc_calls = 0;
        malloc_fail_at = at;
        failed += !lanes_begin(lanes, rk4, DRAG_DEFAULT, system, 0.01);
        malloc_fail_at = -1;
    }
    assert_true(failed >= least);
    malloc_calls = 0;
    for (int lane = 0; lane < LANE_COUNT; lane++)
        lanes_set(lanes, lane, system);
    lanes_march(lanes, 500, NULL); /* with turning points */
    assert_int_equal(malloc_calls, 0);
    double y[2];
    lanes_state(lanes, LANE_COUNT - 1, y);
    assert_true(fabs(y[0]) < 1 && y[1] != 0);
}

TEST(test_lanes)
{
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    struct error error = {0};
    struct scene scene;
    struct system system;
    struct typed_models *models = typed_create(&error);
    struct lanes *lanes = lanes_create();
    scene_init(&scene, NULL);
    assert_true(models && lanes);
    assert_true(type_scene(
        models, &scene,
        (const char *const[]){"var y = 1", "param c = 2", "y'' = -y - c*y'*abs(y')", NULL}));
    assert_true(scene_bind(&scene, &system, &error));
    go_in_lanes(lanes, &system, 1); /* its programs are there already */
    scene_init(&scene, preset_by_name(TEXT("drag")));
    assert_true(scene_bind(&scene, &system, &error));
    go_in_lanes(lanes, &system, 10);
    lanes_destroy(lanes);
    typed_destroy(models);
}

RUN_TESTS(NULL, NULL)
