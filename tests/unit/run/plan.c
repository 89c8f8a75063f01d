/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The plan: step counts, what is refused, what is left out. */
#include <hooke/run/price.h>

#include "run/private.h"
#include "unit/run/fixture.h"
#include "unit/cpu_time.h"

TEST(test_time_is_never_accumulated)
{
    static const double steps[] = {0.1, 1.0 / 7, 1e-3, 0.2};
    struct scene scene = spring();
    set(&scene, "t0", 5);
    for (size_t k = 0; k < COUNT_OF(steps); k++) {
        struct run *run =
            start(&scene, "symplectic-euler", (struct run_settings){.dt = steps[k]}, HUGE_VAL);
        for (int i = 1; i <= 2000; i++) {
            go_steps(run, 1);
            assert_bits(run->t, 5 + i * steps[k]);
        }
        for (size_t i = 0; i <= 2000; i++)
            assert_bits(trace_time(run->trace, i), 5 + (double)i * steps[k]);
        run_destroy(run);
    }
}

/* A run over T = 1 s with dt = 1/k takes k steps. floor(T/dt) would take one too few for 6.7 % of
 * the k up to 10000, and a loop `while (t < T)` one too many for half of them. */
TEST(test_whole_number_of_steps)
{
    struct scene scene = spring();
    struct system system;
    struct error error;
    struct plan plan;
    assert_true(scene_bind(&scene, &system, &error));
    const struct method *method = method_named("verlet");
    int naive = 0;
    for (int k = 1; k <= 10000; k++) {
        double dt = 1.0 / k;
        assert_true(plan_make(&system, method, &(struct run_settings){.dt = dt, .tol = 0}, 1, &plan,
                              &error));
        assert_int_equal(plan.whole, k);
        assert_true(plan.exact_end && plan.partial == 0);
        double t = 0;
        int count = 0;
        for (; t < 1; t += dt)
            count++;
        naive += count != k;
        if (k % 997 == 3 || k == 49) {
            struct run *run = start(&scene, "verlet", (struct run_settings){.dt = dt}, 1);
            go_to(run, 1);
            assert_int_equal(run->steps, k);
            assert_bits(run->t, 1.0);
            assert_bits(trace_time(run->trace, trace_count(run->trace) - 1), 1.0);
            run_destroy(run);
        }
    }
    assert_true(naive > 4000);

    static const struct {
        double t0, span, dt;
        int64_t whole;
        double partial;
    } row[] = {
        {0, 0.7, 0.1, 7, 0},
        {0, 0.3, 0.1, 3, 0},
        {0, 9.6, 0.01, 960, 0},
        {0, 1, 0.3, 3, 0.1},
        {0, 1, 7, 0, 1},
        {1e6 + 0.1, 10, 0.01, 1000, 0},
        {0.1, 10, 0.001, 10000, 0},
        {0, -1, 0.1, 10, 0},
        {3, -1, 0.3, 3, 0.1},
        {0, 0, 0.1, 0, 0},
        {0, 1e9, 0.1, 10000000000, 0},
        {-5, 5, 0.05, 100, 0},
        {0, 1 + 1e-9, 0.1, 10, 1e-9},
        {1e6 + 0.1, 0.7, 0.1, 7, 0},
    };
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        system.t0 = row[i].t0;
        assert_true(plan_make(&system, method, &(struct run_settings){.dt = row[i].dt}, row[i].span,
                              &plan, &error));
        assert_int_equal(plan.whole, row[i].whole);
        assert_close(plan.partial, row[i].partial, 1e-14);
        assert_int_equal(plan.exact_end, row[i].partial == 0);
    }
}

TEST(test_refusals)
{
    struct scene scene = spring();
    struct system system;
    struct error error;
    struct plan plan;
    assert_true(scene_bind(&scene, &system, &error));
    static const struct {
        double t0, dt, span;
        struct recording_rule record;
        const char *text, *hint; /* NULL: accepted */
    } row[] = {
        {0, 0, 1, {RECORD_AUTO, 0, 0}, "dt must be > 0 (got 0 s)", ""},
        {0, -0.1, 1, {RECORD_AUTO, 0, 0}, "dt must be > 0 (got -0.1 s)", ""},
        {0, NAN, 1, {RECORD_AUTO, 0, 0}, "dt must be > 0", ""},
        {0, INFINITY, 1, {RECORD_AUTO, 0, 0}, "dt must be > 0", ""},
        {0, 0.1, NAN, {RECORD_AUTO, 0, 0}, "duration", ""},
        {0, 0.01, 1e18, {RECORD_AUTO, 0, 0}, "1e+20 steps", "dt must be at least 1.2e+02 s"},
        {0, 5e-324, 1, {RECORD_AUTO, 0, 0}, "2^53", "dt must be at least"},
        {0, 1, 1e15, {RECORD_AUTO, 0, 0}, NULL, NULL},
        {0, 1, 0x1p53, {RECORD_AUTO, 0, 0}, NULL, NULL},
        {0, 1, 0x1p53 * 1.001, {RECORD_AUTO, 0, 0}, "2^53", "dt must be at least"},
        {1e20, 0.01, 1, {RECORD_AUTO, 0, 0}, "below the rounding", "t0 nearer to 0"},
        {0, 1e-320, 1e-319, {RECORD_AUTO, 0, 0}, NULL, NULL},
        {0, 1e-3, 1e12, {RECORD_ALL, 0, 0}, "1.6e+16 bytes", "record every 14901162"},
        {0, 1e-3, 1e12, {RECORD_EVERY, 10, 0}, "1.6e+15 bytes", "record every 14901170"},
        {0, 1e-3, 1e12, {RECORD_EVERY, 20000000, 0}, NULL, NULL},
        {0, 1e-3, 1, {RECORD_EVERY, 0, 0}, "record every N needs N >= 1 (got 0)", ""},
        {0, 1e-3, HUGE_VAL, {RECORD_ALL, 0, 0}, NULL, NULL},
    };
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        int64_t begin = cpu_ns();
        struct run_settings settings = {.dt = row[i].dt, .record = row[i].record};
        system.t0 = row[i].t0;
        memset(&error, 0, sizeof error);
        bool fine =
            plan_make(&system, method_named("verlet"), &settings, row[i].span, &plan, &error);
        if (fine != !row[i].text)
            fail_msg("row %zu: %s", i, fine ? "accepted" : error.text);
        if (!fine && (!strstr(error.text, row[i].text) || !strstr(error.hint, row[i].hint)))
            fail_msg("row %zu: '%s' '%s'", i, error.text, error.hint);
        if (!fine)
            assert_int_equal(error.code, ERROR_COMMAND);
        assert_true(cpu_ns() - begin < 1000000000);
    }
    assert_false(plan_make(&system, method_named("dopri5"),
                           &(struct run_settings){.dt = 1, .tol = -1}, 1, &plan, &error));
    assert_null(
        run_create(&scene, method_named("verlet"), &(struct run_settings){.dt = 0}, 1, &error));
}

/* The plan predicts growth and stability in closed form, with x = omega0 dt: forward Euler grows by
 * sqrt(1 + x^2) a step and is never stable, verlet is stable up to x = 2. */
TEST(test_predictions)
{
    struct scene scene = spring();
    struct system system;
    struct error error;
    struct plan plan;
    assert_true(scene_bind(&scene, &system, &error));
    double omega0 = sqrt(75), x = omega0 * 0.01;
    assert_true(plan_make(&system, method_named("euler"), &(struct run_settings){.dt = 0.01}, 1,
                          &plan, &error));
    assert_close(plan.growth, sqrt(1 + x * x), 1e-15);
    assert_true(plan.limit == 0);
    assert_true(plan_make(&system, method_named("verlet"), &(struct run_settings){.dt = 0.01}, 1,
                          &plan, &error));
    assert_close(plan.growth, 1, 1e-12);
    assert_true(isnan(plan.limit)); /* not looked for */
    assert_close(plan_stable_limit(&system, method_named("verlet"), DRAG_EXACT), 2 / omega0, 1e-9);
    assert_true(isinf(plan_stable_limit(&system, method_named("backward-euler"), DRAG_DEFAULT)));
    assert_true(plan_make(&system, method_named("verlet"), &(struct run_settings){.dt = 0.3}, 1,
                          &plan, &error));
    assert_close(plan.limit, 2 / omega0, 1e-9);
    assert_true(plan.exact_known && !plan.ledger && !plan.adaptive);
    assert_true(plan_make(&system, method_named("dopri5"),
                          &(struct run_settings){.dt = 0.3, .tol = 1e-6}, 1, &plan, &error));
    assert_true(plan.adaptive && isnan(plan.steps) && isnan(plan.growth));
    set(&scene, "k", -3);
    assert_true(scene_bind(&scene, &system, &error));
    assert_true(plan_make(&system, method_named("rk4"), &(struct run_settings){.dt = 0.3}, 1, &plan,
                          &error));
    assert_true(isnan(plan.growth) && isnan(plan.limit));
    scene = spring();
    set(&scene, "gamma", -1); /* the true motion grows: so may the numerical one */
    assert_true(scene_bind(&scene, &system, &error));
    assert_true(plan_make(&system, method_named("rk4"), &(struct run_settings){.dt = 0.01}, 1,
                          &plan, &error));
    assert_close(plan.growth, exp(0.005), 1e-7);
    assert_true(isnan(plan.limit));
    scene = spring();
    set(&scene, "C", 0.5);
    assert_true(scene_bind(&scene, &system, &error));
    assert_true(plan_make(&system, method_named("rk4"), &(struct run_settings){.dt = 0.3}, 1, &plan,
                          &error));
    assert_true(isnan(plan.growth) && !plan.exact_known && plan.ledger);
}

static const char *described(const struct scene *scene, const char *method,
                             struct run_settings settings, double span, struct buffer *text)
{
    struct system system;
    struct error error;
    struct plan plan;
    assert_true(scene_bind(scene, &system, &error));
    assert_true(plan_make(&system, method_named(method), &settings, span, &plan, &error));
    buffer_clear(text);
    plan_describe(scene, &system, method_named(method), &settings, &plan, text);
    const struct run_scenario scenario = {.scene = scene,
                                          .system = &system,
                                          .method = method_named(method),
                                          .settings = &settings,
                                          .plan = &plan,
                                          .span = span};
    struct run_work work;
    run_work_count(&scenario, &work);
    run_prices_describe(&scenario, &work, text);
    return text->data;
}

TEST(test_description)
{
    struct buffer text = {0};
    struct scene scene = spring();
    const char *d = described(&scene, "verlet", (struct run_settings){.dt = 0.01}, 10, &text);
    assert_non_null(strstr(d, "left out  damping, drag, gravity, drive, cubic"));
    assert_non_null(
        strstr(d, "1000 steps of fixed dt = 10 ms, the last of which ends exactly on time"));
    assert_non_null(strstr(d, "dE/E0 of"));
    assert_null(strstr(d, "dissipated"));
    assert_non_null(strstr(d, "phase-error"));
    d = described(&scene, "verlet", (struct run_settings){.dt = 0.3}, 1, &text);
    assert_non_null(
        strstr(d, "one last step of 100 ms; verlet is symplectic only with constant steps"));
    assert_non_null(strstr(d, "(exceeded)"));
    d = described(&scene, "euler", (struct run_settings){.dt = 0.01}, 10, &text);
    assert_non_null(strstr(d, "unstable here for every dt"));
    set(&scene, "C", 0.5);
    set(&scene, "gamma", 0.1);
    d = described(&scene, "dopri5", (struct run_settings){.dt = 0.01, .tol = 1e-6}, 10, &text);
    assert_non_null(strstr(d, "left out  gravity, drive"));
    assert_non_null(strstr(d, "no closed form"));
    assert_non_null(strstr(d, "dissipated"));
    assert_null(strstr(d, "phase-error"));
    assert_non_null(strstr(d, "tol = 1e-6"));
    buffer_free(&text);
}

/* Terms and energies are counted where they are evaluated. */
static int64_t adds, potentials, powers;

static void counting_add(const double *c, double t, const double *y, double *a)
{
    (void)t;
    adds++;
    a[0] -= c[0] * y[0];
}

static double counting_potential(const double *c, const double *y)
{
    potentials++;
    return 0.5 * c[1] * y[0] * y[0];
}

static double counting_power(const double *c, double t, const double *y)
{
    (void)t;
    powers++;
    return -(c[1] * c[0] * y[1] * y[1]);
}

TEST(test_what_is_left_out_is_not_computed)
{
    struct scene scene = spring();
    const struct run_settings settings = {.dt = 0.01, .kernel = KERNEL_GENERAL};
    struct run *run = start(&scene, "rk4", settings, 10);
    assert_int_equal(run->system.terms, 1);
    struct term_row counting = *run->system.term[0].row;
    counting.add = counting_add;
    counting.potential = counting_potential;
    run->system.term[0].row = &counting;
    adds = 0;
    go_to(run, 10);
    assert_int_equal(run->steps, 1000);
    assert_int_equal(run->cost.evals, 4000);
    assert_int_equal(adds, 4000);
    run_destroy(run);

    set(&scene, "gamma", 0.1);
    run = start(&scene, "rk4", settings, 10);
    assert_int_equal(run->system.terms, 2);
    struct term_row damping = *run->system.term[1].row;
    damping.power = counting_power;
    struct system *used[] = {&run->system, &run->private_state->epoch[0].system};
    for (size_t i = 0; i < COUNT_OF(used); i++) {
        used[i]->term[0].row = &counting;
        used[i]->term[1].row = &damping;
    }
    potentials = powers = 0;
    go_to(run, 1);
    assert_int_equal(potentials + powers, 0);
    double out[101];
    struct error error;
    assert_true(run_column(run, observable_named("v"), out, &error));
    assert_int_equal(potentials + powers, 0);
    run_observable(run, observable_named("energy"));
    assert_int_equal(potentials, 1);
    assert_true(run_column(run, observable_named("energy"), out, &error));
    assert_int_equal(potentials, 102);
    assert_int_equal(powers, 0);
    assert_true(run_column(run, observable_named("dissipated"), out, &error));
    /* three nodes a step, and one where a block of them begins */
    assert_int_equal(powers, 100 * 3 + 1);
    /* Asked again at the present, only what is new is integrated. */
    run_observable(run, observable_named("work"));
    powers = 0;
    go_steps(run, 3);
    run_observable(run, observable_named("work"));
    assert_int_equal(powers, 3 * 3 + 1);
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
