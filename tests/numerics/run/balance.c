/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energy balance does not depend on what is recorded, on how a run is cut, nor on who asks
 * when: bit for bit. */
#include "run/private.h"
#include "unit/run/fixture.h"

#include <stdlib.h>

static struct ledger ask(const struct run *run)
{
    struct ledger ledger;
    run_ledger(run, &ledger);
    return ledger;
}

static void assert_same_ledger_at(const struct ledger *a, const struct ledger *b, const char *what,
                                  int line)
{
    if (memcmp(a, b, sizeof *a) != 0)
        fail_msg(
            "line %d, %s: work %.17g %.17g, error %.17g %.17g, max %.17g %.17g, energy %.17g %.17g",
            line, what, a->work, b->work, a->error, b->error, a->error_max, b->error_max, a->final,
            b->final);
    assert_true(isfinite(a->error_max) && a->error_max > 0);
}

#define assert_same_ledger(a, b, what) assert_same_ledger_at(&(a), &(b), what, __LINE__)

/* All, thinned, decimated, at even times on the grid of steps and between them. */
static const struct run_settings rules[] = {
    {.dt = 0.01, .kernel = KERNEL_SPECIALISED, .record = {RECORD_ALL, 0, 0}},
    {.dt = 0.01, .kernel = KERNEL_SPECIALISED, .record = {RECORD_EVERY, 7, 0}},
    {.dt = 0.01, .kernel = KERNEL_SPECIALISED, .record = {RECORD_EVERY, 1000, 0}},
    {.dt = 0.01, .kernel = KERNEL_SPECIALISED, .memory = (size_t)500 * 24},
    {.dt = 0.01, .kernel = KERNEL_SPECIALISED, .record = {RECORD_TIMES, 0, 0.25}},
    {.dt = 0.01, .kernel = KERNEL_SPECIALISED, .record = {RECORD_TIMES, 0, 0.0313}},
};

static const struct {
    const char *param[3];
    double value[3];
} scenes[] = {
    {{NULL}, {0}},
    {{"gamma"}, {0.25}},
    {{"C"}, {4}},
    {{"F0", "gamma", "omega"}, {0.02, 0.3, 8.2}},
    {{"mu", "width"}, {0.5, 0.05}},
    {{"k3"}, {300}},
    {{"F0", "C", "g"}, {0.02, 4, 9.81}}, /* no shape of its own */
};

static struct scene make_scene(size_t i)
{
    struct scene scene = spring();
    for (int k = 0; k < 3 && scenes[i].param[k]; k++)
        set(&scene, scenes[i].param[k], scenes[i].value[k]);
    return scene;
}

/* One of each class: partitioned, Runge-Kutta, implicit, several steps explicit and implicit,
 * Rosenbrock, structural. */
static const char *const methods[] = {
    "symplectic-euler", "verlet",      "rk4", "implicit-midpoint", "gauss4", "ab4", "bdf3", "ros3p",
    "newmark",          "wilson-theta"};

/*
 * What adaptive methods lose is of the size of their tolerance; the balance says no more than that,
 * also where steps are longer than a quintic through their ends can follow.
 */
TEST(test_steps_of_high_order)
{
    static const char *const adaptive[] = {"dopri5", "tsit5",  "dop853",
                                           "odex",   "radau5", "rodas5p"};
    for (size_t i = 0; i < COUNT_OF(adaptive); i++)
        for (double tol = 1e-6; tol > 1e-12; tol /= 1e3) {
            const struct run_settings settings = {
                .dt = 0.01, .kernel = KERNEL_SPECIALISED, .tol = tol};
            struct scene scene = spring();
            set(&scene, "k3", 300);
            set(&scene, "gamma", 0.25);
            set(&scene, "F0", 0.02);
            set(&scene, "omega", 8.2);
            struct run *run = start(&scene, adaptive[i], settings, 10);
            go_to(run, 10);
            const struct ledger ledger = ask(run);
            if (!(ledger.error_max < 20 * tol))
                fail_msg("%s at %g: %g", adaptive[i], tol, ledger.error_max);
            run_destroy(run);
        }
}

TEST(test_whatever_is_recorded)
{
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        const struct scene scene = make_scene(i);
        for (size_t m = 0; m < COUNT_OF(methods); m++) {
            struct ledger wanted = {0};
            if (scenes[i].param[0] && strcmp(scenes[i].param[0], "mu") == 0 &&
                strcmp(methods[m], "verlet") == 0)
                continue; /* it does not know this drag */
            for (size_t r = 0; r < COUNT_OF(rules); r++) {
                struct run *run = start(&scene, methods[m], rules[r], 60.005);
                go_to(run, 60.005); /* ends with a part of a step */
                const struct ledger got = ask(run);
                assert_true(r > 0 || trace_count(run->trace) == 6002);
                assert_true(r == 0 || trace_count(run->trace) < 2000);
                wanted = r == 0 ? got : wanted;
                assert_same_ledger(got, wanted, methods[m]);
                run_destroy(run);
            }
        }
    }
}

/* Adaptive methods, too. */
TEST(test_adaptive)
{
    static const char *const adaptive[] = {"dopri5", "dop853", "radau5", "rodas5p"};
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        const struct scene scene = make_scene(i);
        for (size_t m = 0; m < COUNT_OF(adaptive); m++) {
            struct ledger wanted = {0};
            for (size_t r = 0; r < COUNT_OF(rules); r++) {
                struct run_settings settings = rules[r];
                settings.tol = 1e-5;
                settings.memory = settings.memory ? 100 * 24 : 0;
                struct run *run = start(&scene, adaptive[m], settings, 60);
                go_to(run, 60);
                const struct ledger got = ask(run);
                wanted = r == 0 ? got : wanted;
                assert_same_ledger(got, wanted, adaptive[m]);
                run_destroy(run);
            }
        }
    }
}

/* A run made by many calls, with its energy queried in between, has the same trace and energy
 * balance as a run made by one call. */
TEST(test_runs_in_pieces)
{
    static const int cut[] = {1, 2, 63, 64, 65, 700, 5, 4096, 129};
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        const struct scene scene = make_scene(i);
        for (int r = 0; r < (int)COUNT_OF(rules) + 1; r++) {
            struct run_settings settings = rules[r % (int)COUNT_OF(rules)];
            settings.kernel = r == 0 ? KERNEL_PROPAGATOR : settings.kernel;
            struct run *whole = start(&scene, "rk4", settings, HUGE_VAL),
                       *parts = start(&scene, "rk4", settings, HUGE_VAL);
            go_steps(whole, 9000);
            const struct ledger wanted = ask(whole);
            for (size_t k = 0; parts->steps < 9000; k++) {
                const int64_t left = 9000 - parts->steps, next = cut[k % COUNT_OF(cut)];
                go_steps(parts, next < left ? next : left);
                if (k % 2)
                    run_observable(parts, observable_named("energy-error"));
                if (k % 3 == 1)
                    ask(parts);
            }
            assert_same_trace(whole, parts);
            const struct ledger got = ask(parts);
            assert_same_ledger(got, wanted, "in parts");
            run_destroy(whole);
            run_destroy(parts);
        }
    }
}

/* Back to a row, the balance is what it was there; going on again, it becomes what it would have
 * been. */
TEST(test_back)
{
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        const struct scene scene = make_scene(i);
        for (size_t r = 0; r < COUNT_OF(rules); r++) {
            if (rules[r].record.rule ==
                RECORD_TIMES) /* a row becomes the end of a step: another run */
                continue;
            struct run *run = start(&scene, "rk4", rules[r], HUGE_VAL),
                       *fresh = start(&scene, "rk4", rules[r], HUGE_VAL);
            go_steps(run, 20000);
            ask(run);
            run_back(run, r == 2 ? 7 : 150);
            const struct ledger back = ask(run);
            go_steps(fresh, run->steps);
            const struct ledger wanted = ask(fresh);
            assert_same_ledger(back, wanted, "back");
            go_steps(run, 5000);
            go_steps(fresh, 5000);
            const struct ledger later = ask(run), expected = ask(fresh);
            assert_same_ledger(later, expected, "on again");
            run_destroy(run);
            run_destroy(fresh);
        }
    }
}

/* Jumps of the state and changes of the scene are work, and one does not lose the other. */
static void disturb(struct run *run, const struct scene *scene, int round)
{
    struct scene other = *scene;
    struct error error;
    if (round % 2)
        assert_true(run_kick(run, 1, -0.9 * run->y[1], &error));
    if (round % 3 == 0) {
        set(&other, "k", 15 + round);
        assert_true(run_rebind(run, &other, &error));
    }
}

TEST(test_jumps_and_changes)
{
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        const struct scene scene = make_scene(i);
        struct ledger wanted = {0};
        for (size_t r = 0; r < COUNT_OF(rules); r++) {
            struct run *run = start(&scene, "rk4", rules[r], HUGE_VAL);
            for (int round = 0; round < 9; round++) {
                go_steps(run, 501);
                disturb(run, &scene, round);
                if (r % 2)
                    ask(run);
            }
            go_steps(run, 333);
            const struct ledger got = ask(run);
            wanted = r == 0 ? got : wanted;
            assert_same_ledger(got, wanted, "disturbed");
            assert_true(fabs(got.error) < 2e-3);
            run_destroy(run);
        }
    }
}

static double *column_of(const struct run *run, const char *name)
{
    struct error error;
    double *column = malloc(trace_count(run->trace) * sizeof *column);
    assert_non_null(column);
    assert_true(run_column(run, observable_named(name), column, &error));
    return column;
}

/* Each row has the balance up to it, whatever was left out before. */
TEST(test_columns)
{
    static const char *const names[] = {"work", "dissipated", "energy-error"};
    for (size_t i = 0; i < COUNT_OF(scenes); i++) {
        const struct scene scene = make_scene(i);
        struct run *all = start(&scene, "rk4", rules[0], 60);
        go_to(all, 60);
        for (size_t r = 1; r < COUNT_OF(rules) - 1; r++) {
            struct run *run = start(&scene, "rk4", rules[r], 60);
            go_to(run, 60);
            for (size_t c = 0; c < COUNT_OF(names); c++) {
                double *wanted = column_of(all, names[c]), *got = column_of(run, names[c]);
                for (size_t row = 0; row < trace_count(run->trace); row++) {
                    const double value = wanted[trace_step(run->trace, row)];
                    if (!(got[row] == value) && !(isnan(got[row]) && isnan(value)))
                        fail_msg("%s, scene %zu, rule %zu, row %zu: %.17g, not %.17g", names[c], i,
                                 r, row, got[row], value);
                }
                free(wanted);
                free(got);
            }
            run_destroy(run);
        }
        run_destroy(all);
    }
}

/* Rows inside of steps: the balance there is as good as that at the ends. */
TEST(test_rows_inside_of_steps)
{
    struct scene scene = make_scene(1);
    struct run *run =
        start(&scene, "dop853",
              (struct run_settings){.dt = 0.05, .record = {RECORD_TIMES, 0, 0.0313}}, 60);
    go_to(run, 60);
    double *error = column_of(run, "energy-error"), *work = column_of(run, "work");
    for (size_t i = 0; i < trace_count(run->trace); i++) {
        assert_true(fabs(error[i]) < 1e-5); /* that of the dense output */
        assert_true(i == 0 || work[i] <= work[i - 1]);
    }
    free(error);
    free(work);
    run_destroy(run);
}

/* Where nobody is going to ask, a decimated run keeps no balance, and says so. */
TEST(test_nobody_asks)
{
    struct scene scene = make_scene(1);
    struct run_settings settings = rules[3];
    settings.unbalanced = true;
    struct run *run = start(&scene, "rk4", settings, 60);
    go_to(run, 1);
    assert_true(isfinite(ask(run).error_max));
    go_to(run, 60);
    assert_true(isnan(ask(run).error_max) && isnan(ask(run).work) && isfinite(ask(run).final));
    assert_true(isnan(run_observable(run, observable_named("work"))));
    assert_true(!trace_marked(run->trace));
    run_back(run, 100);
    go_steps(run, 10);
    run_destroy(run);
}

/* Over many decimations: what the balance of a long run says is that of the same run recorded in
 * full. */
TEST(test_long_runs)
{
    /* what rk4 takes in 1e6 steps of omega dt = 0.087 */
    static const double max[] = {0, 2e-6, 2e-4, 3e-4};
    for (size_t i = 1; i <= 3; i++) {
        const struct scene scene = make_scene(i);
        struct run *few =
                       start(&scene, "rk4",
                             (struct run_settings){.dt = 0.01, .memory = (size_t)2000 * 24}, 10000),
                   *all = start(&scene, "rk4",
                                (struct run_settings){.dt = 0.01, .record = {RECORD_ALL, 0, 0}},
                                10000);
        go_to(few, 10000);
        go_to(all, 10000);
        const struct ledger got = ask(few), wanted = ask(all);
        assert_same_ledger(got, wanted, scenes[i].param[0]);
        assert_int_equal(trace_count(all->trace), 1000001);
        assert_true(trace_count(few->trace) < 2200 && got.error_max < max[i]);
        run_destroy(few);
        run_destroy(all);
    }
}

/* A force that counts how often it is asked. */
static int64_t powers;

static double counted_power(const double *c, double t, const double *y)
{
    (void)t;
    powers++;
    return -(c[1] * c[0] * y[1] * y[1]);
}

/* Asked after each step, it costs what one step costs, however long the run is; unasked, nothing.
 */
TEST(test_cost_of_a_question)
{
    struct scene scene = make_scene(1);
    struct run *run =
        start(&scene, "rk4", (struct run_settings){.dt = 0.01, .kernel = KERNEL_GENERAL}, HUGE_VAL);
    struct term_row counted = *run->system.term[1].row;
    counted.power = counted_power;
    run->private_state->epoch[0].system.term[1].row = &counted;
    go_steps(run, 20000);
    assert_int_equal(powers, 0);
    ask(run);
    for (int i = 0; i < 100; i++) {
        powers = 0;
        go_steps(run, 1);
        ask(run);
        run_observable(run, observable_named("energy-error"));
        assert_true(powers <= 4);
    }
    run_destroy(run);
}

RUN_TESTS(NULL, NULL)
