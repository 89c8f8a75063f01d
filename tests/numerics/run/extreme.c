/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Extreme inputs: right or refused, never a hang, never a NaN in the trace. */
#include "unit/run/fixture.h"
#include "unit/cpu_time.h"

static void assert_finite_trace(const struct run *run)
{
    for (size_t i = 0; i < trace_count(run->trace); i++) {
        for (int k = 0; k < run->system.n; k++) {
            if (!isfinite(trace_state(run->trace, i)[k]))
                fail_msg("row %zu is not finite", i);
        }
    }
}

struct value {
    const char *name;
    double value;
};

/* Every fixed-step method on scenes at the ends of the range: ends, or stops with a reason and a
 * finite prefix. */
TEST(test_every_method_ends)
{
    static const struct value scenes[][4] = {
        {{"k", 0}, {"v0", 1}},
        {{"k", 0}, {"gamma", 2}, {"v0", 1}},
        {{"k", -15}},
        {{"gamma", -3}},
        {{"gamma", 1e9}},
        {{"k", 1e24}},
        {{"k", 1e300}, {"m", 1}},
        {{"m", 1e-300}, {"k", 1e-300}},
        {{"y0", 1e-310}},
        {{"y0", 1e-320}, {"gamma", 0.1}},
        {{"y0", 1e140}},
        {{"y0", 1e149}, {"v0", 1e150}},
        {{"y0", 0}, {"v0", 0}, {"C", 1e6}},
        {{"v0", 1e6}, {"C", 1e6}},
        {{"g", 9.81}, {"F0", 100}, {"omega", 0}},
    };
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        struct scene scene = spring();
        for (const struct value *v = scenes[i]; v < scenes[i] + 4 && v->name; v++)
            set(&scene, v->name, v->value);
        for (size_t m = 0; m < method_catalog.count; m++) {
            const struct row *row = catalog_row(&method_catalog, m);
            for (int adaptive = 0; adaptive < 2; adaptive++) {
                struct run_settings settings = {.dt = 0.01, .tol = adaptive ? 1e-6 : 0};
                struct error error;
                struct run *run =
                    run_create(&scene, method_named(row->name), &settings, 10, &error);
                if (!run)
                    continue;
                struct run_target target = {.t = 10, .steps = 5000};
                int64_t begin = cpu_ns();
                assert_false(run_advance(run, &target, 0, NULL));
                if (cpu_ns() - begin > 5000000000)
                    fail_msg("%s on scene %zu took %.1f s", row->name, i,
                             (double)(cpu_ns() - begin) * 1e-9);
                if (run->stop == STOP_NONE)
                    fail_msg("%s on scene %zu did not stop", row->name, i);
                assert_finite_trace(run);
                assert_memory_equal(run->y, trace_state(run->trace, trace_count(run->trace) - 1),
                                    2 * sizeof(double));
                struct buffer text = {0};
                struct ledger ledger;
                struct run_errors errors;
                run_explain(run, &text);
                assert_true(text.len > 10);
                run_ledger(run, &ledger);
                run_errors(run, &errors);
                buffer_free(&text);
                run_destroy(run);
            }
        }
    }
}

/* The amplitude A of forward Euler is multiplied by sqrt(1 + x^2) in each step, x = omega dt, so
 * that it exceeds `max` after 2 ln(max/A) / ln(1 + x^2) steps. A run ends as diverged at max =
 * 1e150. */
TEST(test_divergence_is_predicted)
{
    static const double xs[] = {2, 0.2, 0.05};
    for (size_t i = 0; i < COUNT_OF(xs); i++) {
        struct scene scene = spring();
        double x = xs[i], dt = x / sqrt(75);
        struct run *run = start(&scene, "euler", (struct run_settings){.dt = dt}, HUGE_VAL);
        go_steps(run, 10000000);
        assert_int_equal(run->stop, STOP_DIVERGED);
        double predicted = 2 * (150 * log(10) - log(0.05)) / log1p(x * x);
        assert_close((double)run->steps, predicted, 2 + 0.35 / log1p(x * x) * 2);
        assert_finite_trace(run);
        run_destroy(run);
    }
}

/* Free particle with drag, and falling from an unstable equilibrium: right where a formula with
 * omega would not be. */
TEST(test_degenerate_scenes_are_right)
{
    struct scene scene = spring();
    set(&scene, "k", 0);
    set(&scene, "gamma", 0.5);
    set(&scene, "v0", 1);
    struct run *run = start(&scene, "rk4", (struct run_settings){.dt = 0.01}, 4);
    go_to(run, 4);
    assert_close(run->y[0], 0.05 - expm1(-2) / 0.5, 1e-10);
    struct run_errors errors;
    struct ledger ledger;
    run_errors(run, &errors);
    run_ledger(run, &ledger);
    assert_true(errors.max < 1e-10 && ledger.error_max < 1e-10);
    assert_true(isnan(errors.phase));
    run_destroy(run);

    scene = spring();
    set(&scene, "k", -15);
    run = start(&scene, "rk4", (struct run_settings){.dt = 1e-3}, 4);
    go_to(run, 4);
    run_errors(run, &errors);
    run_ledger(run, &ledger);
    assert_true(errors.max < 1e-7);
    assert_true(ledger.initial < 0 && ledger.error_max < 1e30 && isfinite(ledger.error));
    assert_close(run->y[0] / (0.05 * cosh(sqrt(75) * 4)), 1, 1e-7);
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
