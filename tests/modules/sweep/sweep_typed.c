/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps of typed scenes: the same numbers in lanes and alone, whatever is 0 on the way, in shards
 * and by threads. */
#include "cmocka_testing.h"

#include "modules/sweep/compute/sweep.h"
#include "modules/solving/testing.h"

#include "unit/scene/typing.h"

#include <stdlib.h>

static struct typed_models *models;

struct typed_sweep {
    const char *preset, *lines, *method, *measures;
    double dt, duration;
    struct {
        const char *name;
        double from, to;
        int count;
    } axis[2];
    enum drag drag;
    int64_t min; /* points that go in lanes */
};

static void type_all(struct scene *scene, const struct typed_sweep *one)
{
    const char *lines[12] = {0};
    char text[400];
    scene_init(scene, one->preset ? preset_by_name(text_of(one->preset)) : NULL);
    snprintf(text, sizeof text, "%s", one->lines);
    int count = 0;
    for (char *at = text; at; count++) {
        char *end = strchr(at, ';');
        lines[count] = at;
        at = end ? end + 1 : NULL;
        if (end)
            *end = 0;
    }
    assert_true(type_scene(models, scene, lines));
}

static struct sweep_request request_of(const struct scene *scene, const struct typed_sweep *one)
{
    struct sweep_request request = {
        .scene = scene,
        .method = method_named(one->method),
        .settings = {.dt = one->dt, .drag = one->drag, .kernel = KERNEL_SPECIALISED},
        .duration = one->duration,
        .shard = 1,
        .shards = 1};
    struct text rest = text_of(one->measures), name;
    struct error error = {0};
    while (text_split(&rest, ' ', &name))
        if (!sweep_measure_find(scene->model, name, &request.measure[request.measures++], &error))
            fail_msg("%s", error.text);
    for (; request.axes < 2 && one->axis[request.axes].name; request.axes++) {
        struct sweep_axis *axis = &request.axis[request.axes];
        axis->begin = one->axis[request.axes].from;
        axis->end = one->axis[request.axes].to;
        axis->count = one->axis[request.axes].count;
        assert_true(sweep_axis_find(scene, text_of(one->axis[request.axes].name), axis));
    }
    return request;
}

static void compare(const struct sweep *whole, const struct sweep *part, const char *what)
{
    for (int64_t i = 0; i < part->count; i++) {
        const int64_t k = i + part->first;
        if (whole->status[k] != part->status[i])
            fail_msg("%s, point %lld: status %d and %d", what, (long long)k, whole->status[k],
                     part->status[i]);
        for (int m = 0; m < whole->measures; m++)
            if (memcmp(&whole->value[k * whole->measures + m],
                       &part->value[i * whole->measures + m], sizeof(double)) != 0)
                fail_msg("%s, point %lld, measure %d: %.17g and %.17g", what, (long long)k, m,
                         whole->value[k * whole->measures + m],
                         part->value[i * whole->measures + m]);
    }
}

static const struct typed_sweep cases[] = {
    {NULL,
     "var x = 1;param a = 1;param b = 0.2;x' = -a*x + b*cos(3*t)",
     "rk4",
     "x amplitude period mean max min steps evals reached",
     0.01,
     9,
     {{"a", 0, 2, 70}, {"b", -0.2, 0.2, 3}},
     DRAG_DEFAULT,
     150},
    {NULL,
     "var x = 1;param a = 1;param b = 0.2;x' = -a*x + b*cos(3*t)",
     "rk4",
     "x amplitude period mean max min steps evals reached",
     0.01,
     9,
     {{"dt", 0.005, 0.05, 70}},
     DRAG_DEFAULT,
     70},
    {NULL,
     "var x = 1;param a = 1;param b = 0.2;x' = -a*x + b*cos(3*t)",
     "dopri5",
     "x amplitude period mean max min steps evals reached",
     0.01,
     9.0037,
     {{"t0", -1, 1, 70}},
     DRAG_DEFAULT,
     70},
    {"driven",
     "param b = 20;force -b*y^3 + 0.1*sin(t)",
     "verlet",
     "y v amplitude period mean max min steps evals reached",
     0.01,
     9,
     {{"t0", -1, 1, 9}, {"dt", 0.001, 0.04, 9}},
     DRAG_DEFAULT,
     81},
    {NULL,
     "var x = 1;param a = 1;param b = 0.2;x' = -a*x + b*cos(3*t)",
     "dopri5",
     "x amplitude period mean max min evals",
     0.01,
     9.0037,
     {{"a", 0, 2, 70}},
     DRAG_DEFAULT,
     69},
    {NULL,
     "var x = 1;var y = 1;var z = 20;param r = 28;x' = 10*(y - x);y' = x*(r - z) - y;z' = x*y - "
     "8/3*z",
     "rk4",
     "x y z amplitude mean max min",
     0.01,
     7,
     {{"r", 0, 60, 100}},
     DRAG_DEFAULT,
     95},
    {NULL,
     "var y = 0.5;param k = 40;param c = 1;y'' = -k*y - c*y'*abs(y')",
     "rk4",
     "y vy amplitude period evals energy",
     0.02,
     6,
     {{"c", 0, 3, 67}, {"k", 10, 60, 2}},
     DRAG_DEFAULT,
     120},
    {NULL,
     "var y = 0.5;param k = 40;param c = 1;y'' = -k*y - c*y'*abs(y')",
     "dopri5",
     "y amplitude period mean evals",
     0.02,
     6.003,
     {{"c", 0, 3, 67}},
     DRAG_DEFAULT,
     60},
    {NULL,
     "var y = 0.5;param k = 40;param g = 1;y'' = -k*y - g*y'",
     "verlet",
     "y amplitude period",
     0.02,
     6,
     {{"g", 0, 3, 67}},
     DRAG_EXPLICIT,
     60},
    {NULL,
     "var x = 1;var y = 0;var y' = 1;x'' = -x/hypot(x, y)^3;y'' = -y/hypot(x, y)^3;potential "
     "-1/hypot(x, y);"
     "observe r = hypot(x, y)",
     "yoshida4",
     "x y vx amplitude period energy r",
     0.02,
     20,
     {{"vy0", 0.7, 1.1, 66}},
     DRAG_DEFAULT,
     60},
    {NULL,
     "var x = 1;param a = 1;x' = a*x^2",
     "rk4",
     "x reached steps amplitude",
     0.01,
     1.5,
     {{"a", -1, 2, 40}},
     DRAG_DEFAULT,
     20},
    {"damped",
     "param b = 20;force -b*y^3",
     "verlet",
     "y amplitude period energy",
     0.01,
     5,
     {{"b", 0, 100, 66}},
     DRAG_DEFAULT,
     60},
    {"spring",
     "param b = 20;force -b*v*abs(v)",
     "rk4",
     "y amplitude period mean energy evals",
     0.01,
     5.004,
     {{"b", 0, 100, 66}},
     DRAG_DEFAULT,
     60},
};

TEST(test_lanes_equal_runs)
{
    for (size_t c = 0; c < COUNT_OF(cases); c++) {
        struct scene scene;
        struct sweep lanes, other;
        struct error error = {0};
        type_all(&scene, &cases[c]);
        struct sweep_request request = request_of(&scene, &cases[c]);
        request.threads = 1;
        if (!study_sweep(&request, &lanes, &error))
            fail_msg("%s: %s", cases[c].lines, error.text);
        if (lanes.side_by_side < cases[c].min)
            fail_msg("%s: only %lld of %lld points side by side", cases[c].lines,
                     (long long)lanes.side_by_side, (long long)lanes.count);
        request.threads = 3;
        assert_true(study_sweep(&request, &other, &error));
        compare(&lanes, &other, "threads");
        sweep_free(&other);
        for (request.shard = 1, request.shards = 5; request.shard <= 5; request.shard++) {
            assert_true(study_sweep(&request, &other, &error));
            compare(&lanes, &other, "shard");
            sweep_free(&other);
        }
        request.shard = request.shards = 1;
        request.settings.kernel = KERNEL_GENERAL; /* never in lanes */
        assert_true(study_sweep(&request, &other, &error));
        assert_int_equal(other.side_by_side, 0);
        compare(&lanes, &other, cases[c].lines);
        sweep_free(&other);
        sweep_free(&lanes);
    }
}

static int setup(void **state)
{
    struct error error;
    (void)state;
    models = typed_create(&error);
    return models ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    typed_destroy(models);
    return 0;
}

RUN_TESTS(setup, teardown)
