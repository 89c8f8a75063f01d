/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows at even times: where they lie, what they hold, and that it does not matter how a run is cut.
 */
#include "cmocka_testing.h"

#include "unit/run/fixture.h"

#define EVERY 0.1

static struct run_settings rows_by_time(double dt, double tol)
{
    return (struct run_settings){.dt = dt, .tol = tol, .record = {RECORD_TIMES, 1, EVERY}};
}

/* All rows but the present lie at t0 + k EVERY, none is left out; the present is the last. */
static void assert_even(const struct run *run)
{
    const size_t last = trace_count(run->trace) - 1;
    for (size_t i = 0; i < last; i++)
        assert_bits(trace_time(run->trace, i), run->system.t0 + (double)i * EVERY);
    const double span = trace_time(run->trace, last) - trace_time(run->trace, last - 1);
    assert_true(span > 0 && span < EVERY * (1 + 1e-12));
    assert_close(trace_time(run->trace, last), run->t, 1e-14);
    assert_memory_equal(trace_state(run->trace, last), run->y,
                        (size_t)run->system.n * sizeof(double));
}

static double largest_error(const struct run *run)
{
    struct run_errors errors;
    run_errors(run, &errors);
    return errors.max;
}

TEST(test_all_adaptive_methods)
{
    struct scene scene = spring();
    set(&scene, "t0", 0.35);
    set(&scene, "gamma", 0.3);
    int seen = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        struct system system;
        struct error error;
        enum drag drag = DRAG_DEFAULT;
        if (!(method->flags & METHOD_ADAPTIVE) || !scene_bind(&scene, &system, &error) ||
            !method_applies(method, &system, &drag, &error))
            continue;
        const bool low = method->order < 4 || (method->flags & METHOD_EXTERNAL);
        const double tol = low ? 1e-6 : 1e-9;
        struct run *run = start(&scene, method->row.name, rows_by_time(0.01, tol), 5);
        struct run *steps =
            start(&scene, method->row.name, (struct run_settings){.dt = 0.01, .tol = tol}, 5);
        go_to(run, 5.38);
        go_to(steps, 5.38);
        assert_int_equal(trace_count(run->trace), 52);
        assert_even(run);
        assert_int_equal(run->steps, steps->steps); /* rows do not shorten steps */
        assert_memory_equal(run->y, steps->y, 2 * sizeof(double));
        const double error_max = largest_error(run), bound = (low ? 100 : 20) * tol;
        if (!(error_max < bound))
            fail_msg("%s: error %.3g of rows, %.3g of steps", method->row.name, error_max,
                     largest_error(steps));
        run_destroy(run);
        run_destroy(steps);
        seen++;
    }
    assert_true(seen >= 8);
}

TEST(test_cut_in_pieces)
{
    static const char *const names[] = {"dop853", "tsit5", "rodas5p", "radau5"};
    struct scene scene = spring();
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct run *whole = start(&scene, names[i], rows_by_time(0.01, 1e-8), 4);
        struct run *pieces = start(&scene, names[i], rows_by_time(0.01, 1e-8), 4);
        go_to(whole, 3.33);
        for (struct run_target one = {.t = 3.33, .steps = 1}; pieces->t < 3.33;)
            assert_false(run_advance(pieces, &one, 0, NULL));
        assert_same_trace(whole, pieces);
        run_destroy(pieces);
        /* Stopped at times between the rows: the same times, the same motion. */
        pieces = start(&scene, names[i], rows_by_time(0.01, 1e-8), 4);
        static const double stops[] = {0.05, 0.1, 0.1000001, 1.27, 1.3, 3.33};
        for (size_t k = 0; k < COUNT_OF(stops); k++)
            go_to(pieces, stops[k]);
        assert_even(pieces);
        assert_int_equal(trace_count(pieces->trace), trace_count(whole->trace));
        assert_true(largest_error(pieces) < 1e-6);
        /* Back into the middle of a step, and on from there. */
        assert_true(run_back(pieces, 10));
        assert_bits(pieces->t, trace_time(whole->trace, 24));
        go_to(pieces, 3.33);
        assert_even(pieces);
        assert_int_equal(trace_count(pieces->trace), trace_count(whole->trace));
        assert_true(largest_error(pieces) < 1e-6);
        run_destroy(pieces);
        run_destroy(whole);
    }
}

/* dt divides the interval: the rows are steps, whatever computes them. */
TEST(test_fixed_steps)
{
    struct scene scene = spring();
    for (int kernel = KERNEL_PROPAGATOR; kernel <= KERNEL_GENERAL; kernel++) {
        struct run_settings settings = rows_by_time(0.01, 0), all = {.dt = 0.01};
        settings.kernel = all.kernel = (enum kernel)kernel;
        struct run *run = start(&scene, "verlet", settings, 100),
                   *steps = start(&scene, "verlet", all, 100);
        go_to(run, 77.777);
        go_to(steps, 77.777);
        assert_int_equal(trace_count(run->trace), 779);
        assert_even(run);
        for (size_t i = 0; i < 778; i++) {
            assert_int_equal(trace_step(run->trace, i), i * 10);
            assert_memory_equal(trace_state(run->trace, i), trace_state(steps->trace, i * 10),
                                2 * sizeof(double));
        }
        assert_memory_equal(run->y, steps->y, 2 * sizeof(double));
        /* After that part of a step the grid is another: rows are between the steps now. */
        go_to(run, 80.05);
        assert_int_equal(trace_count(run->trace), 802);
        assert_even(run);
        assert_true(trace_bytes(run->trace) < 400000); /* not that of 8000 steps in room for 2^20 */
        run_destroy(run);
        run_destroy(steps);
    }
}

TEST(test_between_fixed_steps)
{
    struct scene scene = spring();
    struct run *run = start(&scene, "rk4", rows_by_time(0.0137, 0), 10);
    go_to(run, 9.05);
    assert_even(run);
    assert_int_equal(trace_count(run->trace), 92);
    assert_true(largest_error(run) < 2e-4);
    assert_true(run_back(run, 40)); /* inside a step: from there on another grid */
    assert_close(run->t, 5.1, 1e-12);
    go_to(run, 9.05);
    assert_even(run);
    assert_int_equal(trace_count(run->trace), 92);
    assert_true(largest_error(run) < 2e-4);
    run_destroy(run);
}

TEST(test_backwards_and_turns)
{
    struct scene scene = spring();
    static const struct {
        const char *name;
        double dt, tol;
    } ways[] = {{"dop853", 0.01, 1e-9}, {"verlet", 1e-4, 0}, {"rk4", 0.0173, 0}};
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        struct run *run = start(&scene, ways[i].name, rows_by_time(ways[i].dt, ways[i].tol), -1);
        go_to(run, -0.45);
        go_to(run, 0.15);
        static const double wanted[] = {0,    -0.1, -0.2, -0.3, -0.4, -0.4,
                                        -0.3, -0.2, -0.1, 0,    0.1,  0.15};
        assert_int_equal(trace_count(run->trace), COUNT_OF(wanted));
        for (size_t k = 0; k < COUNT_OF(wanted); k++)
            assert_close(trace_time(run->trace, k), wanted[k], 1e-15);
        assert_true(largest_error(run) < 2e-4);
        run_destroy(run);
    }
}

/* No room in the middle of a step that holds several rows: nothing of the step stays. */
TEST(test_full)
{
    struct scene scene = spring();
    struct run_settings settings = rows_by_time(0.01, 1e-9);
    settings.record.interval = 1e-3;
    settings.memory = 500 * 4 * sizeof(double);
    struct run *run = start(&scene, "dop853", settings, 0.1);
    go_to(run, 2);
    assert_int_equal(run->stop, STOP_FULL);
    const size_t rows = trace_count(run->trace);
    assert_true(rows > 300 && rows <= 501 && run->t < 0.5);
    assert_true(trace_time(run->trace, rows - 2) < run->t &&
                run->t - trace_time(run->trace, rows - 2) <= 1e-3);
    assert_true(run_back(run, 200)); /* makes room */
    go_to(run, 0.3);
    assert_int_equal(run->stop, STOP_END);
    for (size_t i = 0; i < trace_count(run->trace) - 1; i++)
        assert_bits(trace_time(run->trace, i), (double)i * 1e-3);
    run_destroy(run);
}

TEST(test_refused)
{
    struct scene scene = spring();
    struct error error;
    struct run_settings settings = rows_by_time(0.01, 1e-9);
    settings.record.interval = 1e-9;
    assert_null(run_create(&scene, method_named("dop853"), &settings, 10, &error));
    assert_non_null(strstr(error.text, "recording 1e+10 rows needs 3.2e+11 bytes"));
    assert_non_null(strstr(error.hint, "set record every 2.99e-07 s"));
    settings.record.interval = 0;
    assert_null(run_create(&scene, method_named("dop853"), &settings, 10, &error));
    assert_non_null(strstr(error.text, "needs a time > 0"));
}

RUN_TESTS(NULL, NULL)
