/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Single steps by kernels: the same bits as the specification, the error estimate, the cost and the
 * output too. */
#include "unit/run/fixture.h"

enum { ROOM = 8192 };

struct walker {
    double y[LIMIT_VARIABLES], error[LIMIT_VARIABLES], work[ROOM];
    struct step step;
    struct controller controller;
};

static void begin(struct walker *walker, const struct method *method, const struct system *system,
                  enum drag drag, bool special)
{
    *walker = (struct walker){.controller = {.tol = 1e-7}};
    memcpy(walker->y, system->start, (size_t)system->n * sizeof *walker->y);
    walker->step = (struct step){.system = system,
                                 .drag = drag,
                                 .t = system->t0,
                                 .y = walker->y,
                                 .error = walker->error,
                                 .work = walker->work};
    method_choose_kernels(method, &walker->step, special);
}

static void assert_same(const struct walker *a, const struct walker *b, const char *method)
{
    const int n = a->step.system->n;
    const size_t size = (size_t)n * sizeof *a->y;
    if (memcmp(a->y, b->y, size) != 0 || memcmp(a->error, b->error, size) != 0)
        fail_msg("%s: other bits at t = %.17g", method, a->step.t);
    assert_memory_equal(&a->step.cost, &b->step.cost, sizeof a->step.cost);
    assert_memory_equal(&a->controller.h, &b->controller.h, sizeof a->controller.h);
    assert_bits(a->step.t, b->step.t);
}

/* Up to a time that a step has to be cut short for, back again, and from where no step leads on. */
static void compare_ends(const struct method *method, struct walker *fast, struct walker *plain)
{
    const double h = plain->controller.h,
                 ends[] = {plain->step.t + 2.5 * h, plain->step.t - 3.5 * h};
    for (size_t e = 0; e < COUNT_OF(ends); e++)
        for (int i = 0; i < 40 && plain->step.t != ends[e]; i++) {
            const enum step_status status =
                method_adapt(method, &fast->step, &fast->controller, ends[e]);
            assert_int_equal(method_adapt(method, &plain->step, &plain->controller, ends[e]),
                             status);
            assert_same(fast, plain, method->row.name);
            if (status != STEP_OK)
                return;
        }
    fast->y[0] = plain->y[0] = HUGE_VAL;
    fast->step.warm = plain->step.warm = false;
    const enum step_status status = method_adapt(method, &fast->step, &fast->controller, ends[0]);
    assert_int_equal(method_adapt(method, &plain->step, &plain->controller, ends[0]), status);
    assert_memory_equal(&fast->step.cost, &plain->step.cost, sizeof fast->step.cost);
    assert_bits(fast->step.t, plain->step.t);
    assert_bits(fast->controller.h, plain->controller.h);
}

static void compare(const struct method *method, const struct system *system, enum drag drag)
{
    static struct walker fast, plain;
    double before[LIMIT_VARIABLES], here[LIMIT_VARIABLES], there[LIMIT_VARIABLES];
    const size_t size = (size_t)system->n * sizeof *here;
    begin(&fast, method, system, drag, true);
    begin(&plain, method, system, drag, false);
    for (int i = 0; i < 60; i++) {
        memcpy(before, plain.y, size);
        if (method->flags & METHOD_ADAPTIVE) {
            const double end = system->t0 + 1e9;
            const enum step_status status = method_adapt(method, &fast.step, &fast.controller, end);
            assert_int_equal(method_adapt(method, &plain.step, &plain.controller, end), status);
            if (status != STEP_OK)
                return;
        } else {
            fast.step.h = plain.step.h = 0.013;
            const enum step_status status = method_step(method, &fast.step);
            assert_int_equal(method_step(method, &plain.step), status);
            if (status != STEP_OK)
                return;
        }
        assert_same(&fast, &plain, method->row.name);
        method_dense(method, &fast.step, before, 0.3, here);
        method_dense(method, &plain.step, before, 0.3, there);
        assert_memory_equal(here, there, size);
    }
    if (method->flags & METHOD_ADAPTIVE)
        compare_ends(method, &fast, &plain);
}

/* Every preset, and every combination of terms of the oscillator. */
TEST(test_same_bits)
{
    static const struct {
        const char *name;
        double value;
    } terms[] = {{"gamma", 0.3}, {"C", 2}, {"k3", 200}, {"F0", 0.1}, {"mu", 2}, {"g", 1}};
    const size_t combinations = (size_t)1 << COUNT_OF(terms);
    int compared = 0;
    for (size_t i = 0; i < preset_catalog.count + combinations; i++) {
        struct scene scene;
        struct system system;
        struct error error;
        const bool own = i >= preset_catalog.count;
        scene_init(&scene, own ? NULL : preset_at(i));
        for (size_t k = 0; own && k < COUNT_OF(terms); k++)
            if ((i - preset_catalog.count) >> k & 1)
                set(&scene, terms[k].name, terms[k].value);
        assert_true(scene_bind(&scene, &system, &error));
        for (size_t m = 0; m < method_catalog.count; m++) {
            enum drag drag = DRAG_DEFAULT;
            if (!method_step_kernel(method_at(m), &system) ||
                !method_applies(method_at(m), &system, &drag, &error))
                continue;
            compare(method_at(m), &system, drag);
            compared++;
        }
    }
    print_message("# %d combinations of method and scene\n", compared);
    assert_true(compared > 500);
}

/* What a kernel is not for, it hands on: compensated sums. */
TEST(test_compensated_sums)
{
    const struct scene scene = spring();
    const struct run_settings settings = {.dt = 0.01, .compensated = true};
    struct run_settings general = settings;
    general.kernel = KERNEL_GENERAL;
    struct run *a = start(&scene, "dopri5", settings, 20),
               *b = start(&scene, "dopri5", general, 20);
    go_to(a, 20);
    go_to(b, 20);
    assert_same_trace(a, b);
    run_destroy(a);
    run_destroy(b);
}

/* The linear shapes are those of a spring with and without damping, and of nothing else. */
TEST(test_shapes)
{
    struct scene plain = spring(), damped = spring(), weight = spring(), steady = spring();
    struct system system;
    struct error error;
    const struct method *rk4 = method_named("rk4");
    set(&damped, "gamma", 0.1);
    set(&weight, "g", 9.81);
    set(&steady, "k", 0);
    set(&steady, "gamma", 0.1);
    const struct scene *const scenes[] = {&plain, &damped, &weight, &steady};
    march_function *march[COUNT_OF(scenes)];
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        assert_true(scene_bind(scenes[i], &system, &error));
        march[i] = method_kernel(rk4, &system, DRAG_DEFAULT);
        assert_non_null(march[i]);
        assert_non_null(method_step_kernel(rk4, &system));
        assert_null(method_step_kernel(method_named("verlet"), &system));
    }
    assert_true(march[0] != march[1] && march[0] != march[2] && march[1] != march[2] &&
                march[2] == march[3]);
}

RUN_TESTS(NULL, NULL)
