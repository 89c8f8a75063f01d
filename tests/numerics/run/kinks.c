/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Turning points with quadratic drag, q'' = -q - 0.1 |q'| q': the force is only C^1 there. Steps
 * that end at them keep the order of the method; across them it is lost.
 */
#include <hooke/run.h>
#include <hooke/scene/formula.h>
#include "numerics/references.h"

#define SPAN 10
/* The state there, of references.csv: located turning points, confirmed by a first integral. */
static const double truth[2] = {-6.038516824236533039553e-1, 3.788995987997463649905e-1};

static struct scene drag_scene(double c)
{
    struct scene scene = spring();
    set(&scene, "m", 1);
    set(&scene, "k", 1);
    set(&scene, "y0", 1);
    set(&scene, "C", c);
    set(&scene, "rho", 1);
    set(&scene, "area", 1);
    return scene;
}

static struct run *solve(const struct scene *scene, const char *method,
                         struct run_settings settings, double t)
{
    struct run *run = start(scene, method, settings, t);
    go_to(run, t);
    assert_int_equal(run->stop, STOP_END);
    return run;
}

static double error_of(const struct run *run)
{
    return fmax(fabs(run->y[0] - truth[0]), fabs(run->y[1] - truth[1]));
}

static double fixed_error(const char *method, int steps)
{
    const struct scene scene = drag_scene(0.1);
    struct run *run =
        solve(&scene, method, (struct run_settings){.dt = (double)SPAN / steps}, SPAN);
    assert_int_equal(run->steps, steps);
    const double error = error_of(run);
    run_destroy(run);
    return error;
}

/* ---- the order ---- */

/* The slope between the last two errors of a sweep of halved steps that have no rounding in them.
 */
static double measured_order(const char *method)
{
    double order = NAN, coarse = fixed_error(method, 5);
    for (int steps = 10; steps <= 5 << 9; steps *= 2) {
        const double fine = fixed_error(method, steps);
        if (fine < 1e-12)
            break;
        order = log2(coarse / fine);
        coarse = fine;
    }
    return order;
}

TEST(test_order_of_fixed_steps)
{
    const struct scene scene = drag_scene(0.1);
    struct system system;
    struct error error;
    assert_true(scene_bind(&scene, &system, &error) && system.kinks);
    int count = 0, wrong = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        enum drag drag = DRAG_DEFAULT;
        if (!method_turns(method, &system) || !method_applies(method, &system, &drag, &error))
            continue;
        const double order = measured_order(method->row.name);
        const bool bad = !(order > 0.95 * method->order && order < method->order + 0.5);
        if (bad || getenv("VERBOSE"))
            print_message("%-18s order %d, measured %.2f%s\n", method->row.name, method->order,
                          order, bad ? ": wrong" : "");
        wrong += bad;
        count++;
    }
    assert_true(count >= 15);
    assert_int_equal(wrong, 0);
}

/* Steps that end at the turning points keep the order 8 of dop853. Steps across the turning points
 * have the errors 6.3e-8, 1.3e-9, 4e-10 and 6e-10 instead. */
TEST(test_eighth_order)
{
    const double error[] = {fixed_error("dop853", 20), fixed_error("dop853", 40),
                            fixed_error("dop853", 80), fixed_error("dop853", 160)};
    if (getenv("VERBOSE"))
        print_message("dop853: %.3g %.3g %.3g %.3g\n", error[0], error[1], error[2], error[3]);
    assert_true(log2(error[0] / error[1]) > 7.5 && log2(error[1] / error[2]) > 7.5);
    assert_true(error[3] < 1e-14);
}

TEST(test_adaptive_steps_are_as_good_as_the_tolerance)
{
    const struct scene scene = drag_scene(0.1);
    static const char *const names[] = {"dop853", "dopri5", "tsit5", "radau5", "rodas5p"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (double tol = 1e-6; tol > 1e-12; tol /= 100) {
            struct run *run =
                solve(&scene, names[i], (struct run_settings){.dt = 1e-3, .tol = tol}, SPAN);
            if (!(error_of(run) < tol))
                fail_msg("%s at tol %g: %.3g", names[i], tol, error_of(run));
            /* Of what there is to reject most comes from the turning points. */
            assert_true(names[i][0] == 'r' || run->cost.rejected <= 6);
            run_destroy(run);
        }
}

TEST(test_references)
{
    static const struct {
        const char *name;
        double b, gamma;
    } known[] = {{"qdrag_b0.1,", 0.1, 0}, {"qdrag_b1,", 1, 0}, {"lin0.05", 0.1, 0.05}};
    size_t count = 0;
    int compared = 0;
    struct table_row *table = read_table(&count);
    if (!table) {
        print_message("no references.csv beside HOOKE_DATA: nothing to compare with\n");
        skip();
    }
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < COUNT_OF(known); k++) {
            if (!strstr(table[i].problem, "quadratic_drag") ||
                !strstr(table[i].parameters, known[k].name))
                continue;
            struct scene scene = drag_scene(known[k].b);
            set(&scene, "gamma", known[k].gamma);
            struct run *fixed =
                solve(&scene, "dop853", (struct run_settings){.dt = 0.05}, table[i].t);
            struct run *adaptive = solve(
                &scene, "dop853", (struct run_settings){.dt = 1e-3, .tol = 1e-14}, table[i].t);
            const int index = index_of(&table[i]);
            assert_close(fixed->y[index], table[i].value, 1e-13);
            assert_close(adaptive->y[index], table[i].value, 1e-13);
            run_destroy(fixed);
            run_destroy(adaptive);
            compared++;
        }
    assert_int_equal(compared, 12);
    free(table);
}

/* ---- what must stay ---- */

static const struct {
    const char *method;
    struct run_settings settings;
} ways[] = {{"dop853", {.dt = 0.3}},
            {"rk4", {.dt = 0.1}},
            {"gauss4", {.dt = 0.25}},
            {"rk4", {.dt = 0.1, .compensated = true}},
            {"dopri5", {.dt = 0.01, .tol = 1e-8}},
            {"rodas5p", {.dt = 0.01, .tol = 1e-6}}};

TEST(test_rows_do_not_depend_on_the_calls)
{
    const struct scene scene = drag_scene(0.5);
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        struct run *whole = start(&scene, ways[i].method, ways[i].settings, HUGE_VAL);
        struct run *parts = start(&scene, ways[i].method, ways[i].settings, HUGE_VAL);
        go_steps(whole, 200);
        for (int k = 0; k < 200; k++)
            go_steps(parts, 1);
        assert_same_trace(whole, parts);
        run_destroy(whole);
        run_destroy(parts);
    }
}

/* Kernels, which know nothing of turning points, take the steps between them: the same rows, to the
 * bit. */
TEST(test_kernels_between_turning_points)
{
    static const char *const names[] = {"rk4", "dopri5", "dop853", "verlet"};
    static const double steps[] = {0.7, 0.1, 0.01, 0.0013};
    const struct scene scene = drag_scene(0.5);
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (size_t k = 0; k < COUNT_OF(steps); k++) {
            struct run *fast =
                start(&scene, names[i], (struct run_settings){.dt = steps[k]}, HUGE_VAL);
            struct run *general =
                start(&scene, names[i],
                      (struct run_settings){.dt = steps[k], .kernel = KERNEL_GENERAL}, HUGE_VAL);
            for (int piece = 1; piece < 3000; piece *= 3)
                go_steps(fast, piece);
            go_steps(general, fast->steps);
            assert_same_trace(fast, general);
            assert_int_equal(fast->cost.evals, general->cost.evals);
            run_destroy(fast);
            run_destroy(general);
        }
}

/* The rows stand on the grid. */
TEST(test_rows_stay_on_the_grid)
{
    const struct scene scene = drag_scene(0.5);
    struct run *run = solve(&scene, "rk4", (struct run_settings){.dt = 0.1}, SPAN);
    struct run *general =
        solve(&scene, "rk4", (struct run_settings){.dt = 0.1, .kernel = KERNEL_GENERAL}, SPAN);
    assert_int_equal(trace_count(run->trace), 101);
    for (size_t i = 0; i < 101; i++)
        assert_close(trace_time(run->trace, i), 0.1 * (double)i, 1e-14);
    assert_same_trace(run, general);
    assert_true(run->cost.evals > 4 * 100);
    run_destroy(run);
    run_destroy(general);
}

/* A condition at the turning point itself is found there, whichever side the step to it ends on. */
TEST(test_conditions)
{
    const struct scene scene = drag_scene(0.1);
    double first = NAN;
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        struct run_settings settings = ways[i].settings;
        if (settings.tol > 0)
            settings.tol = 1e-11;
        else
            settings.dt = 0.01;
        struct run *run = start(&scene, ways[i].method, settings, HUGE_VAL);
        struct expr_scope scope;
        struct arena arena = {0};
        struct condition condition;
        struct error error;
        size_t used;
        assert_true(run_scope(run, &scope));
        assert_true(condition_compile(TEXT("v > 0"), &scope, &arena, &condition, &used, &error));
        struct run_target target = {
            .t = SPAN, .steps = -1, .condition = &condition, .scope = &scope};
        assert_false(run_advance(run, &target, 0, NULL));
        assert_int_equal(run->stop, STOP_CONDITION);
        assert_true(run->y[1] > 0 && run->y[1] < 1e-13);
        if (isnan(first))
            first = run->t;
        assert_close(run->t, first, 1e-8);
        arena_reset(&arena);
        run_destroy(run);
    }
}

TEST(test_nothing_to_locate)
{
    struct scene rest = drag_scene(0.1), fall = drag_scene(0.1);
    set(&rest, "y0", 0);
    set(&fall, "k", 0);
    set(&fall, "g", 1);
    const struct scene *const scenes[] = {&rest, &fall}; /* v = a = 0; v = 0 at the start only */
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        struct run *run = solve(scenes[i], "rk4", (struct run_settings){.dt = 0.1}, SPAN);
        assert_int_equal(run->cost.evals, 400);
        run_destroy(run);
    }
    struct scene smooth = drag_scene(0);
    struct run *run =
        solve(&smooth, "rk4", (struct run_settings){.dt = 0.1, .kernel = KERNEL_GENERAL}, SPAN);
    assert_false(run->system.kinks);
    assert_int_equal(run->cost.evals, 400);
    run_destroy(run);
}

TEST(test_backwards)
{
    const struct scene scene = drag_scene(0.1);
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        struct run_settings settings = ways[i].settings;
        if (settings.tol > 0)
            settings.tol = 1e-12;
        else
            settings.dt = 1e-3;
        struct run *run = solve(&scene, ways[i].method, settings, 7);
        go_to(run, 0);
        assert_close(run->y[0], 1, 2e-10);
        assert_close(run->y[1], 0, 2e-10);
        run_destroy(run);
    }
}

/* The strongest drag: turning points where the velocity changes within a small part of a step. */
TEST(test_violent_drag)
{
    struct scene scene = drag_scene(1e6);
    struct run *run = solve(&scene, "radau5", (struct run_settings){.dt = 1e-6, .tol = 1e-8}, 100);
    assert_true(isfinite(run->y[0]) && fabs(run->y[0]) <= 1 && run->cost.evals < 100000);
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
