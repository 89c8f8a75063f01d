/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Advancing: splits, slices, going back, partial steps, conditions, stop reasons. */
#include <hooke/base/cancel.h>
#include <hooke/scene/formula.h>
#include "unit/run/fixture.h"

static struct scene lively(void)
{
    struct scene scene = spring();
    set(&scene, "gamma", 0.07);
    set(&scene, "F0", 40); /* so strong and fast that an ulp of t shows */
    set(&scene, "omega", 50);
    return scene;
}

/* Every method, fixed step, scene with drive: one go, two goes, and slices of 1 ns. */
TEST(test_split_is_bit_equal)
{
    struct scene scene = lively();
    for (size_t i = 0; i < method_catalog.count; i++) {
        const char *name = catalog_row(&method_catalog, i)->name;
        struct run_settings settings = {.dt = 0.01};
        struct error error;
        struct run *whole = run_create(&scene, method_named(name), &settings, 3, &error);
        /* not for this scene */
        if (!whole)
            continue;
        struct run *split = start(&scene, name, settings, 3),
                   *sliced = start(&scene, name, settings, 3);
        go_to(whole, 3);
        go_to(split, 0.7);
        assert_bits(split->t, 0.7);
        go_steps(split, 41);
        go_to(split, 2.2);
        go_to(split, 3);
        struct run_target target = {.t = 3, .steps = -1};
        int slices = 0;
        while (run_advance(sliced, &target, 1, NULL))
            slices++;
        assert_true(slices > 2);
        assert_int_equal(whole->steps, 300);
        assert_bits(whole->t, 3.0);
        assert_int_equal(whole->stop, STOP_END);
        assert_same_trace(whole, split);
        assert_same_trace(whole, sliced);
        run_destroy(whole);
        run_destroy(split);
        run_destroy(sliced);
    }
}

TEST(test_back_and_continue)
{
    struct scene scene = spring();
    static const char *const names[] = {"euler", "symplectic-euler", "verlet",
                                        "rk4",   "backward-euler",   "dopri5"};
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct run_settings settings = {.dt = 0.01};
        struct run *there = start(&scene, names[i], settings, 2),
                   *back = start(&scene, names[i], settings, 2);
        go_to(there, 1.5);
        go_to(back, 1.2);
        double was[2] = {trace_state(back->trace, 70)[0], trace_state(back->trace, 70)[1]};
        assert_true(run_back(back, 50));
        assert_int_equal(back->steps, 70);
        assert_bits(back->t, 70 * 0.01);
        assert_memory_equal(back->y, was, sizeof was);
        assert_int_equal(trace_count(back->trace), 71);
        go_to(back, 1.5);
        assert_same_trace(there, back);
        assert_false(run_back(back, 1000)); /* the start is kept */
        assert_int_equal(back->steps, 0);
        assert_int_equal(trace_count(back->trace), 1);
        assert_bits(back->y[0], 0.05);
        assert_true(run_back(back, 0));
        go_to(back, 1.5);
        assert_same_trace(there, back);
        run_destroy(there);
        run_destroy(back);
    }
}

/* Beyond a partial step the grid starts anew; going back over it finds the old one again. */
TEST(test_partial_step_is_local)
{
    struct scene scene = lively();
    set(&scene, "t0", 2);
    struct run_settings settings = {.dt = 0.1};
    struct run *run = start(&scene, "rk4", settings, 0.25);
    assert_int_equal(run->plan.whole, 2);
    assert_close(run->plan.partial, 0.05, 1e-15);
    go_to(run, 2.25);
    assert_int_equal(run->steps, 3);
    assert_bits(run->t, 2.25);
    assert_bits(run->settings.dt, 0.1);
    go_steps(run, 2);
    assert_bits(trace_time(run->trace, 2), 2 + 2 * 0.1);
    assert_bits(trace_time(run->trace, 3), 2.25);
    assert_bits(trace_time(run->trace, 5), 2.25 + 2 * 0.1);
    struct run *straight = start(&scene, "rk4", settings, 1);
    go_to(straight, 2.6);
    run_back(run, 3);
    assert_bits(run->t, 2 + 2 * 0.1);
    go_to(run, 2.6);
    assert_same_trace(run, straight);
    run_destroy(run);
    run_destroy(straight);

    /* dt larger than the span: one step of exactly the span. */
    settings.dt = 7;
    run = start(&scene, "rk4", settings, 0.3);
    go_to(run, 2.3);
    assert_int_equal(run->steps, 1);
    assert_bits(run->t, 2.3);
    struct step step = {.system = &run->system,
                        .drag = run->settings.drag,
                        .t = 2,
                        .h = 2.3 - 2,
                        .y = (double[2]){0}};
    double work[256];
    memcpy(step.y, run->system.start, 2 * sizeof(double));
    step.work = work;
    assert_true(method_work_size(run->method, 2) <= COUNT_OF(work));
    method_step(run->method, &step);
    assert_memory_equal(step.y, run->y, 2 * sizeof(double));
    run_destroy(run);
}

TEST(test_backwards)
{
    struct scene scene = spring();
    struct run_settings settings = {.dt = 0.01};
    struct run *run = start(&scene, "verlet", settings, -1);
    go_to(run, -1);
    assert_int_equal(run->steps, 100);
    assert_bits(run->t, -1.0);
    assert_bits(trace_time(run->trace, 30), -0.3);
    go_to(run, 0); /* and forward again: a symmetric method is back at the start */
    assert_int_equal(run->steps, 200);
    assert_close(run->y[0], 0.05, 1e-15);
    assert_close(run->y[1], 0, 1e-14);
    run_destroy(run);

    run = start(&scene, "dopri5", (struct run_settings){.dt = 0.01, .tol = 1e-9}, -1);
    go_to(run, -1);
    assert_bits(run->t, -1.0);
    assert_close(run->y[0], 0.05 * cos(sqrt(75)), 1e-9);
    run_destroy(run);
}

static bool until(struct run *run, const char *text, double t_end)
{
    struct expr_scope scope;
    struct arena arena = {0};
    struct condition condition;
    struct error error;
    size_t used;
    assert_true(run_scope(run, &scope));
    if (!condition_compile(text_of(text), &scope, &arena, &condition, &used, &error))
        fail_msg("%s: %s", text, error.text);
    struct run_target target = {.t = t_end, .steps = -1, .condition = &condition, .scope = &scope};
    while (run_advance(run, &target, 1, NULL))
        continue;
    arena_reset(&arena);
    return run->stop == STOP_CONDITION;
}

TEST(test_conditions)
{
    struct scene scene = spring();
    double omega0 = sqrt(75), quarter = M_PI_2 / omega0;
    static const struct run_settings both[] = {{.dt = 1e-3}, {.dt = 1e-3, .tol = 1e-12}};
    for (size_t i = 0; i < COUNT_OF(both); i++) {
        struct run *run = start(&scene, "dopri5", both[i], 10);
        assert_true(until(run, "y < 0", 10));
        assert_close(run->t, quarter, 1e-9);
        assert_true(run->y[0] < 0 && run->y[0] > -1e-11);
        assert_int_equal(trace_step(run->trace, trace_count(run->trace) - 1), run->steps);
        assert_bits(trace_time(run->trace, trace_count(run->trace) - 1), run->t);
        /* Holds now, so it must become false first: the next time is a period later. */
        assert_true(until(run, "y < 0", 10));
        assert_close(run->t, 5 * quarter, 1e-9);
        assert_true(until(run, "v > 0.2 m/s", 10));
        assert_true(until(run, "energy < 1 mJ", 1.5) == false);
        assert_int_equal(run->stop, STOP_END);
        assert_bits(run->t, 1.5);
        assert_true(until(run, "t >= 1.625", 10));
        assert_close(run->t, 1.625, 1e-15);
        run_destroy(run);
    }
    /* Work since the start, which comes from the trace, and a condition that is never true. */
    set(&scene, "gamma", 0.5);
    struct run *run = start(&scene, "rk4", both[0], 10);
    assert_true(until(run, "dissipated > 5 mJ", 10));
    assert_close(run_observable(run, observable_named("energy")), 0.5 * 15 * 0.05 * 0.05 - 5e-3,
                 1e-9);
    assert_false(until(run, "energy-0 > 1", 2));
    run_destroy(run);
}

static void explain(const struct run *run, const char *part)
{
    struct buffer text = {0};
    run_explain(run, &text);
    if (!strstr(text.data, part))
        fail_msg("'%s' lacks '%s'", text.data, part);
    buffer_free(&text);
}

TEST(test_divergence)
{
    struct scene scene = spring();
    struct run *run = start(&scene, "verlet", (struct run_settings){.dt = 0.7}, 1e4);
    go_to(run, 1e4);
    assert_int_equal(run->stop, STOP_DIVERGED);
    assert_string_equal(stop_name(run->stop), "diverged");
    assert_true(isfinite(run->y[0]) && fabs(run->y[0]) <= 1e150 && fabs(run->y[0]) > 1e140);
    assert_int_equal(trace_step(run->trace, trace_count(run->trace) - 1), run->steps);
    explain(run, "dt = 0.7 s is above the stability limit 0.231 s of verlet; try dt <= 0.02 s");
    double y = run->y[0];
    int64_t steps = run->steps;
    go_to(run, 1e4); /* again: nothing moves */
    assert_int_equal(run->stop, STOP_DIVERGED);
    assert_int_equal(run->steps, steps);
    assert_bits(run->y[0], y);
    run_destroy(run);

    run = start(&scene, "euler", (struct run_settings){.dt = 0.2}, 1e4);
    go_to(run, 1e4);
    explain(run, "euler is unstable on an undamped oscillator for every dt (growth 2 per step); "
                 "try symplectic-euler");
    run_destroy(run);

    set(&scene, "k", -15);
    run = start(&scene, "rk4", (struct run_settings){.dt = 0.1}, 1e4);
    go_to(run, 1e4);
    explain(run, "the scene itself grows (k < 0)");
    run_destroy(run);

    scene = spring();
    set(&scene, "gamma", -1);
    run = start(&scene, "rk4", (struct run_settings){.dt = 0.1}, 1e4);
    go_to(run, 1e4);
    explain(run, "the scene itself grows (gamma < 0)");
    run_destroy(run);
}

TEST(test_cancel)
{
    struct scene scene = spring();
    struct cancel cancel;
    atomic_init(&cancel.requested, 1);
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, HUGE_VAL);
    struct run_target target = FOREVER;
    assert_false(run_advance(run, &target, 0, &cancel));
    assert_int_equal(run->stop, STOP_CANCELLED);
    assert_int_equal(run->steps, 0);
    atomic_store(&cancel.requested, 0);
    assert_true(run_advance(run, &target, 1000000, &cancel));
    assert_int_equal(run->stop, STOP_NONE);
    int64_t steps = run->steps;
    struct run *other = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, HUGE_VAL);
    go_steps(other, steps);
    assert_same_trace(run, other);
    run_destroy(run);
    run_destroy(other);
}

/* A budget is kept, also by a method whose steps are slow. */
static void slow_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    int64_t begin = clock_ns();
    while (clock_ns() - begin < 20000)
        continue;
    a[0] -= c[0] * y[0];
}

/* A call of run_advance() ends near its budget of time even if steps become much slower during a
 * run: the number of steps between two looks at the clock follows their time. */
TEST(test_budget)
{
    struct scene scene = spring();
    struct run *run =
        start(&scene, "rk4", (struct run_settings){.dt = 1e-3, .kernel = KERNEL_GENERAL}, HUGE_VAL);
    go_steps(run, 100000); /* fast: the clock is read seldom now */
    struct term_row slow = *run->system.term[0].row;
    slow.add = slow_add;
    run->system.term[0].row = &slow;
    struct run_target target = FOREVER;
    /* learns that a step takes 80 us now */
    for (int i = 0; i < 8; i++)
        assert_true(run_advance(run, &target, 2000000, NULL));
    const int64_t before = run->steps;
    assert_true(run_advance(run, &target, 2000000, NULL));
    /* 25 fit into the 2 ms of the budget; counted, not timed */
    assert_true(run->steps - before < 300);
    assert_true(run->seconds > 0.01);
    run_destroy(run);
}

TEST(test_rebind)
{
    struct scene undamped = spring(), scene = undamped;
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 2);
    struct error error;
    go_to(run, 0.5);
    double y[2] = {run->y[0], run->y[1]}, before = run_observable(run, observable_named("energy"));
    set(&scene, "k", 30);
    assert_true(run_rebind(run, &scene, &error));
    assert_memory_equal(run->y, y, sizeof y);
    assert_close(run->scene.value[param_index("k")], 15, 0);
    go_to(run, 1);
    /* The exact solution is carried over the change, and the energy that it brought counts as work.
     */
    struct run_errors errors;
    struct ledger ledger;
    run_errors(run, &errors);
    assert_true(errors.max < 1e-8);
    run_ledger(run, &ledger);
    assert_true(ledger.error_max < 1e-8);
    assert_close(ledger.initial, before, 1e-10);
    assert_close(ledger.work, 0.5 * 15 * y[0] * y[0], 1e-12);
    assert_close(ledger.final, before + 0.5 * 15 * y[0] * y[0], 1e-9);
    /* Going back before the change brings the old spring back. */
    assert_true(run_back(run, 600));
    assert_close(run->system.oscillator.stiffness, 75, 1e-12);
    struct run *straight = start(&undamped, "rk4", (struct run_settings){.dt = 1e-3}, 2);
    go_to(run, 2);
    go_to(straight, 2);
    assert_same_trace(run, straight);
    set(&scene, "m", 0.1);
    set(&scene, "gamma", 0.3);
    assert_true(run_rebind(run, &scene, &error));
    assert_false(run->system.conservative);
    run_destroy(run);
    run_destroy(straight);
}

TEST(test_adaptive_grid_points_and_targets)
{
    struct scene scene = lively();
    struct run *whole = start(&scene, "dopri5", (struct run_settings){.dt = 0.01, .tol = 1e-8}, 10);
    struct run *sliced =
        start(&scene, "dopri5", (struct run_settings){.dt = 0.01, .tol = 1e-8}, 10);
    go_to(whole, 10);
    struct run_target target = {.t = 10, .steps = -1};
    while (run_advance(sliced, &target, 1, NULL))
        continue;
    assert_bits(whole->t, 10.0);
    assert_same_trace(whole, sliced);
    struct run_errors errors;
    run_errors(whole, &errors);
    assert_true(errors.max < 1e-6);
    double t = trace_time(whole->trace, 20);
    assert_true(run_back(whole, (int64_t)trace_count(whole->trace) - 1 - 20));
    assert_bits(whole->t, t);
    assert_memory_equal(whole->y, trace_state(sliced->trace, 20), 2 * sizeof(double));
    run_destroy(whole);
    run_destroy(sliced);
}

/* Advances to t step by step, as an interactive session does, until it stops. */
static void go_one_by_one(struct run *run, double t)
{
    const struct run_target target = {.t = t, .steps = 1};
    do {
        assert_false(run_advance(run, &target, 0, NULL));
    } while (run->stop == STOP_END && run->t != t);
}

static void assert_same_end(const struct run *a, const struct run *b)
{
    assert_int_equal(a->stop, b->stop);
    assert_int_equal(a->steps, b->steps);
    assert_int_equal(a->cost.evals, b->cost.evals);
    assert_int_equal(a->cost.rejected, b->cost.rejected);
    assert_bits(a->controller.h, b->controller.h);
    assert_same_trace(a, b);
}

/* Adaptive steps that are taken many at once are those that are taken one by one, and those without
 * kernels: up to the end, until the numbers diverge, and into a singularity. */
TEST(test_adaptive_steps_at_once)
{
    static const struct {
        const char *name;
        double value, end;
        bool ends;
    } scene_of[] = {{"k", 20, 30, true},
                    {"k3", 4e3, 30, true},
                    {"k", -15, 1e3, false},
                    {"k3", -7e3, 30, false}};
    static const char *const names[] = {"dopri5", "tsit5", "dop853"};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(scene_of) * COUNT_OF(names); i++) {
        const char *name = names[i / COUNT_OF(scene_of)];
        const double end = scene_of[i % COUNT_OF(scene_of)].end;
        struct scene scene = spring();
        set(&scene, scene_of[i % COUNT_OF(scene_of)].name, scene_of[i % COUNT_OF(scene_of)].value);
        struct run_settings settings = {.dt = 0.01, .tol = 1e-7};
        struct run *whole = start(&scene, name, settings, end),
                   *single = start(&scene, name, settings, end),
                   *sliced = start(&scene, name, settings, end);
        settings.kernel = KERNEL_GENERAL;
        struct run *general = start(&scene, name, settings, end);
        go_to(whole, end);
        go_one_by_one(single, end);
        go_to(general, end);
        const struct run_target target = {.t = end, .steps = -1};
        while (run_advance(sliced, &target, 1, NULL)) {
        }
        assert_int_equal(whole->stop == STOP_END, scene_of[i % COUNT_OF(scene_of)].ends);
        assert_same_end(whole, single);
        assert_same_end(whole, sliced);
        assert_same_end(whole, general);
        run_destroy(whole);
        run_destroy(single);
        run_destroy(sliced);
        run_destroy(general);
    }
}

/* Runs that cannot be repeated get their marks in parts once their traces leave steps out: each
 * part leaves a trace of each step behind it. Going back in between begins them anew. */
TEST(test_thinning_in_parts)
{
    struct scene scene = lively();
    const struct run_settings settings = {.dt = 0.002, .compensated = true, .memory = 400 * 24};
    struct run *whole = start(&scene, "rk4", settings, 100),
               *sliced = start(&scene, "rk4", settings, 100);
    const struct run_target target = {.t = 100, .steps = -1};
    struct ledger a, b;
    int parts = 0;
    for (int64_t before = -1; run_advance(sliced, &target, 1, NULL); before = sliced->steps) {
        if (sliced->steps != before)
            continue;
        for (size_t i = 0; i < trace_count(sliced->trace); i++)
            assert_int_equal(trace_step(sliced->trace, i), i);
        if (++parts == 2) {
            run_advance(whole, &(struct run_target){.t = 100, .steps = sliced->steps}, 0, NULL);
            assert_true(run_back(sliced, 3) && run_back(whole, 3));
        }
    }
    go_to(whole, 100);
    assert_true(parts >= 3);
    assert_same_trace(whole, sliced);
    run_ledger(whole, &a);
    run_ledger(sliced, &b);
    assert_bits(a.error_max, b.error_max);
    run_destroy(whole);
    run_destroy(sliced);
}

/* A million nearly equal steps: as a plain sum their rounding would go one way, 2e-6 of a radian
 * here. */
TEST(test_clock)
{
    struct scene scene = spring();
    set(&scene, "m", 1);
    set(&scene, "k", 1e10);
    const struct run_settings settings = {
        .dt = 1e-6, .tol = 1e-14, .record = {RECORD_EVERY, INT64_MAX, 0}};
    struct run *run = start(&scene, "dop853", settings, 1);
    go_to(run, 1);
    assert_true(run->steps > 1000000 && run->t == 1);
    struct run_errors errors;
    run_errors(run, &errors);
    assert_close(errors.phase, 0, 1e-8);
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
