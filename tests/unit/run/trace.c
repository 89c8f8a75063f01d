/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The trace: recording rules, decimation against brute force, memory. */
#include <hooke/base/numeric.h>

#include "long_form.h"
#include "run/private.h"
#include "unit/run/fixture.h"

#include <stdlib.h>

/* The steps that buckets of `size` keep of positions q[0 … count): first, earliest smallest,
 * earliest largest. */
static size_t brute_force(const double *q, int64_t count, int64_t size, int64_t *kept)
{
    size_t rows = 0;
    for (int64_t begin = 0; begin < count; begin += size) {
        int64_t low = begin, high = begin;
        for (int64_t i = begin; i < count && i < begin + size; i++) {
            low = q[i] < q[low] ? i : low;
            high = q[i] > q[high] ? i : high;
        }
        kept[rows++] = begin;
        int64_t first = low < high ? low : high, second = low < high ? high : low;
        if (first != begin)
            kept[rows++] = first;
        if (second != begin && second != first)
            kept[rows++] = second;
    }
    return rows;
}

/* A small cap, so that decimation happens often; noise, so that extremes lie anywhere; and all
 * lengths. */
TEST(test_decimation_equals_brute_force)
{
    enum { COUNT = 3000, CAP = 100 };
    static double q[COUNT];
    static int64_t kept[COUNT];
    uint64_t seed = 1;
    struct trace *trace = trace_create(1, false, (struct recording_rule){RECORD_AUTO, 0, 0},
                                       CAP * 2 * sizeof(double));
    assert_non_null(trace);
    assert_true(trace_reserve_grids(trace, 1));
    trace_regrid(trace, (struct time_grid){.first = 0, .origin = 3, .h = 0.1});
    for (int64_t i = 0; i < COUNT; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        q[i] = (double)(seed >> 60) + (i > 2000 ? (double)i : 0); /* with ties */
        assert_true(trace_record(trace, i, 0, &q[i]));
        assert_true(trace->count <= CAP);
        size_t rows = brute_force(q, i + 1, trace->bucket, kept);
        assert_int_equal(trace->count, rows);
        for (size_t k = i % 7 == 0 ? 0 : rows - 1; k < rows; k++) {
            assert_int_equal(trace_step(trace, k), kept[k]);
            assert_bits(trace_state(trace, k)[0], q[kept[k]]);
        }
        trace_present(trace, i, grid_time(trace_grid(trace), i), &q[i]);
        assert_int_equal(trace_count(trace), rows + (kept[rows - 1] != i));
        assert_int_equal(trace_step(trace, trace_count(trace) - 1), i);
        assert_bits(trace_time(trace, 1), 3 + (double)kept[1] * 0.1);
    }
    assert_true(trace->bucket >= 32 && trace_decimated(trace));

    /* Going back to any kept row and offering the same samples again ends the same. */
    size_t rows = trace->count;
    for (size_t back = 0; back < rows; back++) {
        trace_truncate(trace, back);
        assert_int_equal(trace_count(trace), back + 1);
        for (int64_t i = trace->now_step + 1; i < COUNT; i++)
            assert_true(trace_record(trace, i, 0, &q[i]));
        assert_int_equal(trace->count, rows);
        for (size_t k = 0; k < rows; k++)
            assert_int_equal(trace_step(trace, k), kept[k]);
    }
    trace_destroy(trace);
}

/* Many rows that are offered at once, of any width and number, leave what they leave one by one. */
TEST(test_many_rows_at_once)
{
    enum { COUNT = 20000, CAP = 2000, WIDTH = 4 };
    static double row[COUNT * WIDTH];
    const int scenes = is_long() ? 400 : 40;
    uint64_t seed = 7;
    for (int scene = 0; scene < scenes; scene++) {
        const int n = 1 + scene % 3, kind = scene % 5;
        const bool timed = scene % 2;
        const size_t width = (size_t)n + timed;
        const struct recording_rule rule = {RECORD_AUTO, 0, 0};
        struct trace *many = trace_create(n, timed, rule, CAP * (width + 1) * sizeof(double)),
                     *single = trace_create(n, timed, rule, CAP * (width + 1) * sizeof(double));
        for (size_t i = 0; i < COUNT * width; i++) {
            const double noise = floor(8 * random_fraction(&seed)), t = (double)(i / width);
            row[i] = kind == 0   ? noise
                     : kind == 1 ? sin(t / 7) + noise * 0.01
                     : kind == 2 ? sin(t / 300)
                     : kind == 3 ? floor(t / 50)
                                 : t * noise;
        }
        for (int64_t i = 0, more; i < COUNT; i += more) {
            more = 1 + (int64_t)(random_fraction(&seed) * (scene % 4 == 0 ? 40 : 4000));
            more = more < COUNT - i ? more : COUNT - i;
            assert_int_equal(trace_record_many(many, i, row + (size_t)i * width, more), more);
        }
        for (int64_t i = 0; i < COUNT; i++) {
            const double *y = row + (size_t)i * width;
            assert_true(trace_record(single, i, y[width - 1], y));
        }
        assert_true(single->bucket > 1 && many->bucket == single->bucket);
        assert_int_equal(many->count, single->count);
        for (size_t i = 0; i < many->count; i++) {
            assert_int_equal(trace_row_step(many, i), trace_row_step(single, i));
            assert_memory_equal(trace_row(many, i), trace_row(single, i), width * sizeof(double));
        }
        trace_destroy(many);
        trace_destroy(single);
    }
}

/* One sample in 5 million stands out, up or down, wherever it is. */
TEST(test_spike_survives)
{
    const int64_t count = 5000000, index[] = {1, 777777, 2500001, 4999998};
    for (size_t k = 0; k < COUNT_OF(index); k++) {
        struct trace *trace = trace_create(2, false, (struct recording_rule){RECORD_AUTO, 0, 0}, 0);
        for (int64_t i = 0; i < count; i++) {
            double y[2] = {i == index[k] ? (k % 2 ? 7 : -7) : sin((double)i * 1e-3), 0};
            assert_true(trace_record(trace, i, 0, y));
        }
        assert_true(trace_bytes(trace) < 64000000);
        size_t found = 0;
        for (size_t i = 0; i < trace->count; i++)
            found += fabs(trace_state(trace, i)[0]) == 7 && trace_step(trace, i) == index[k];
        assert_int_equal(found, 1);
        trace_destroy(trace);
    }
}

TEST(test_memory_is_bounded)
{
    struct scene scene = spring();
    struct run *run =
        start(&scene, "symplectic-euler", (struct run_settings){.dt = 1e-3}, HUGE_VAL);
    go_steps(run, 2 * LIMIT_SAMPLES);
    size_t bytes = trace_bytes(run->trace);
    assert_true(bytes < 64000000);
    go_steps(run, is_long() ? 1000000000 : 4 * LIMIT_SAMPLES);
    assert_int_equal(trace_bytes(run->trace), bytes);
    assert_true(trace_count(run->trace) <= LIMIT_SAMPLES + 1);
    assert_int_equal(trace_step(run->trace, trace_count(run->trace) - 1), run->steps);
    /* All of it was allocated for rows: what is reported cannot be too little. */
    assert_true(bytes >= trace_count(run->trace) * 3 * sizeof(double));
    run_destroy(run);
}

/* Decimated runs do not depend on slicing either, and can be taken back to what was recorded. */
TEST(test_decimated_run)
{
    struct scene scene = spring();
    /* Specialised: of a decimated trace a propagator cannot find the beginning of its block again.
     */
    struct run_settings settings = {.dt = 1e-2, .memory = 200 * 24, .kernel = KERNEL_SPECIALISED};
    struct run *whole = start(&scene, "verlet", settings, 100),
               *sliced = start(&scene, "verlet", settings, 100);
    struct run *all =
        start(&scene, "verlet",
              (struct run_settings){
                  .dt = 1e-2, .kernel = KERNEL_SPECIALISED, .record = {RECORD_ALL, 0, 0}},
              100);
    go_to(whole, 100);
    go_to(all, 100);
    go_to(sliced, 31.41);
    struct run_target target = {.t = 100, .steps = -1};
    while (run_advance(sliced, &target, 1, NULL))
        continue;
    assert_true(trace_decimated(whole->trace));
    assert_false(trace_decimated(all->trace));
    assert_int_equal(trace_count(all->trace), 10001);
    assert_same_trace(whole, sliced);
    for (size_t i = 0; i < trace_count(whole->trace); i++) {
        size_t step = (size_t)trace_step(whole->trace, i);
        assert_bits(trace_time(whole->trace, i), trace_time(all->trace, step));
        assert_memory_equal(trace_state(whole->trace, i), trace_state(all->trace, step),
                            2 * sizeof(double));
    }
    assert_true(run_back(sliced, 33));
    assert_memory_equal(sliced->y, trace_state(all->trace, (size_t)sliced->steps),
                        2 * sizeof(double));
    go_to(sliced, 100);
    assert_same_trace(whole, sliced);
    run_destroy(whole);
    run_destroy(sliced);
    run_destroy(all);
}

/* Compares the energy balance at the rows of a run with that of another one with each step. */
static void assert_same_balance(const struct run *some, const struct run *all)
{
    const struct observable *balance = observable_named("energy-error");
    struct ledger a, b;
    struct error error;
    run_ledger(some, &a);
    run_ledger(all, &b);
    assert_true(b.error_max > 0 && b.error_max < 1e-3);
    assert_bits(a.error, b.error);
    assert_bits(a.error_max, b.error_max);
    assert_bits(a.work, b.work);
    double *at_rows = malloc(trace_count(some->trace) * sizeof *at_rows),
           *at_steps = malloc(trace_count(all->trace) * sizeof *at_steps);
    assert_true(run_column(some, balance, at_rows, &error) &&
                run_column(all, balance, at_steps, &error));
    for (size_t i = 0; i < trace_count(some->trace); i++)
        assert_bits(at_rows[i], at_steps[(size_t)trace_step(some->trace, i)]);
    free(at_rows);
    free(at_steps);
}

/* The balance of a run does not depend on what is recorded, nor on targets on the way: all bits are
 * those of a run with each step. Adaptive steps are taken again for it when somebody asks; it is
 * kept on the way where sums are compensated. */
TEST(test_balance_at_recorded_rows)
{
    static const char *const names[] = {"dopri5", "dop853", "rodas5p", "tsit5", "rk4"};
    static const struct recording_rule rules[] = {{RECORD_AUTO, 0, 0}, {RECORD_EVERY, 13, 0}};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(names) * COUNT_OF(rules) * 4; i++) {
        const char *name = names[i % COUNT_OF(names)];
        const size_t way = i / COUNT_OF(names) % 4;
        const bool kept = strcmp(name, "rk4") == 0;
        struct run_settings settings = {.dt = 0.01, .tol = 1e-8, .compensated = kept};
        struct scene scene = spring();
        set(&scene, "gamma", way % 2 ? 0.2 : 0);
        set(&scene, "F0", way % 2 ? 0.1 : 0);
        set(&scene, "omega", 8.2);
        settings.record = rules[i / COUNT_OF(names) / 4];
        settings.memory = settings.record.rule == RECORD_AUTO ? 100 * 32 : 0;
        struct run *some = start(&scene, name, settings, 20);
        settings.record = (struct recording_rule){RECORD_ALL, 0, 0};
        settings.memory = 0;
        struct run *all = start(&scene, name, settings, 20);
        for (int k = 0; k < 2; k++) {
            struct run *run = k == 0 ? some : all;
            if (way == 1)
                go_to(run, 7);
            if (way == 2)
                go_steps(run, 123);
            go_to(run, 20);
            if (way == 3)
                go_to(run, kept ? 21 : 15);
        }
        assert_int_equal(trace_marked(some->trace), kept);
        assert_int_equal(some->steps, all->steps);
        assert_same_balance(some, all);
        assert_true(trace_marked(some->trace));
        run_destroy(some);
        run_destroy(all);
    }
}

TEST(test_record_every)
{
    struct scene scene = spring();
    struct run_settings settings = {.dt = 0.01, .record = {RECORD_EVERY, 7, 0}};
    struct run *run = start(&scene, "rk4", settings, 1), *other = start(&scene, "rk4", settings, 1);
    struct run *all = start(&scene, "rk4", (struct run_settings){.dt = 0.01}, 1);
    go_to(all, 1.005);
    go_to(run, 1.005); /* 100 steps and a half */
    assert_int_equal(trace_count(run->trace), 16);
    for (size_t i = 0; i < 16; i++) {
        int64_t step = i < 15 ? (int64_t)i * 7 : 101;
        assert_int_equal(trace_step(run->trace, i), step);
        assert_bits(trace_time(run->trace, i), trace_time(all->trace, (size_t)step));
        assert_memory_equal(trace_state(run->trace, i), trace_state(all->trace, (size_t)step),
                            2 * sizeof(double));
    }
    go_steps(other, 3);
    go_steps(other, 4);
    assert_int_equal(trace_count(other->trace), 2);
    go_steps(other, 1);
    assert_int_equal(trace_count(other->trace), 3);
    assert_true(run_back(other, 1));
    assert_int_equal(other->steps, 7);
    assert_true(run_back(other, 1));
    assert_int_equal(other->steps, 0);
    go_to(other, 1.005);
    assert_same_trace(run, other);
    run_destroy(run);
    run_destroy(other);
    run_destroy(all);
}

TEST(test_full_trace_keeps_the_state)
{
    struct scene scene = spring();
    struct run_settings settings = {.dt = 0.01, .record = {RECORD_ALL, 0, 0}, .memory = 500 * 16};
    struct run *run = start(&scene, "verlet", settings, HUGE_VAL);
    struct run *other = start(&scene, "verlet", (struct run_settings){.dt = 0.01}, HUGE_VAL);
    go_steps(run, 10000);
    assert_int_equal(run->stop, STOP_FULL);
    assert_string_equal(stop_name(run->stop), "full");
    assert_int_equal(run->steps, 499);
    assert_int_equal(trace_count(run->trace), 500);
    go_steps(other, 499);
    assert_same_trace(run, other);
    struct buffer text = {0};
    run_explain(run, &text);
    assert_non_null(strstr(text.data, "500 rows"));
    buffer_free(&text);
    assert_true(run_back(run, 100)); /* makes room */
    go_steps(run, 100);
    assert_same_trace(run, other);
    run_destroy(run);
    run_destroy(other);
}

RUN_TESTS(NULL, NULL)
