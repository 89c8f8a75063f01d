/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lanes of typed scenes without memory: refused, and good again afterwards; their steps never
 * allocate. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "unit/scene/typing.h"

#include <hooke/method.h>

#include "faults/failing_malloc.h"

static void test_lanes(void **state)
{
    (void)state;
    if (!MALLOC_CAN_FAIL) {
        print_message("the sanitizer has its own malloc\n");
        skip();
    }
    struct error error = {0};
    struct scene scene;
    struct system system;
    struct typed_models *models = typed_create(&error);
    const struct method *rk4 =
        (const struct method *)(const void *)catalog_find(&method_catalog, TEXT("rk4"));
    struct lanes *lanes = lanes_create();
    scene_init(&scene, NULL);
    assert_true(models && lanes);
    assert_true(type_scene(
        models, &scene,
        (const char *const[]){"var y = 1", "param c = 2", "y'' = -y - c*y'*abs(y')", NULL}));
    assert_true(scene_bind(&scene, &system, &error));
    malloc_calls = 0;
    assert_true(lanes_fit(rk4, &system, DRAG_DEFAULT, 0.01));
    assert_int_equal(malloc_calls, 0);
    int failed = 0;
    for (long at = 0; failed == at; at++) { /* one after the other, until nothing fails */
        malloc_calls = 0;
        malloc_fail_at = at;
        failed += !lanes_begin(lanes, rk4, DRAG_DEFAULT, &system, 0.01);
        malloc_fail_at = -1;
    }
    assert_int_equal(failed, 2);
    malloc_calls = 0;
    for (int lane = 0; lane < LANES; lane++)
        lanes_set(lanes, lane, &system);
    lanes_march(lanes, 500, NULL); /* with turning points */
    assert_int_equal(malloc_calls, 0);
    double y[2];
    lanes_state(lanes, LANES - 1, y);
    assert_true(fabs(y[0]) < 1 && y[1] != 0);
    lanes_destroy(lanes);
    typed_destroy(models);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lanes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
