/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Interrupts at random times: what was computed is a bit-equal prefix, going on gives the run one
 * would have had, and it stops at once. */
#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/cpu_time.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

#include <hooke/base/cancel.h>
#include <hooke/run.h>

#define STEPS 60000

static struct cancel cancel;
static volatile int64_t requested_at;

static void on_alarm(int number)
{
    (void)number;
    requested_at = cpu_ns();
    atomic_store_explicit(&cancel.requested, 1, memory_order_relaxed);
}

static void interrupt_after(long microseconds)
{
    struct itimerval moment = {.it_value = {.tv_usec = microseconds}};
    setitimer(ITIMER_REAL, &moment, NULL);
}

static struct run *new_run(const char *method)
{
    struct scene scene;
    struct error error = {0};
    scene_init(&scene, NULL);
    assert_true(scene_set(&scene, param_index("C"), (struct measured){1, 0}, &error));
    struct run_settings settings = {.dt = 0.001};
    struct run *run =
        run_create(&scene, method_by_name(text_of(method)), &settings, STEPS * 0.001, &error);
    assert_non_null(run);
    return run;
}

static int by_time(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a;
    int64_t y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

TEST(test_random_interrupts)
{
    const int wanted = is_long() ? 1000 : 200;
    static const char *const methods[] = {"verlet", "rk4", "backward-euler"};
    static int64_t latency[1000];
    int interrupts = 0;
    unsigned random = 20261121;
    struct sigaction action = {.sa_handler = on_alarm};
    sigaction(SIGALRM, &action, NULL);
    while (interrupts < wanted) {
        const char *name = methods[interrupts % 3];
        struct run *whole = new_run(name);
        struct run *cut = new_run(name);
        struct run_target target = {.t = STEPS * 0.001, .steps = -1};
        while (run_advance(whole, &target, 0, NULL)) {
        }
        assert_int_equal(whole->steps, STEPS);
        bool more = true;
        while (more && interrupts < wanted) {
            random = random * 1664525u + 1013904223u;
            atomic_store(&cancel.requested, 0);
            requested_at = 0;
            interrupt_after(1 + (long)(random >> 8) % 1500);
            more = run_advance(cut, &target, 0, &cancel);
            const int64_t now = cpu_ns();
            interrupt_after(0);
            more = cut->stop == STOP_CANCELLED;
            if (more && requested_at) {
                latency[interrupts++] = now - requested_at;
            }
            /* The present state is the whole run's at that step, and so is every row before it. */
            const size_t rows = trace_count(cut->trace);
            assert_int_equal(rows, (size_t)cut->steps + 1);
            assert_memory_equal(cut->y, trace_state(whole->trace, rows - 1), 2 * sizeof(double));
        }
        atomic_store(&cancel.requested, 0);
        while (run_advance(cut, &target, 0, NULL)) {
        }
        assert_int_equal(trace_count(cut->trace), trace_count(whole->trace));
        for (size_t i = 0; i < trace_count(whole->trace); i++) {
            double a[2];
            memcpy(a, trace_state(whole->trace, i), sizeof a);
            assert_memory_equal(a, trace_state(cut->trace, i), sizeof a);
            assert_true(trace_time(whole->trace, i) == trace_time(cut->trace, i));
        }
        run_destroy(whole);
        run_destroy(cut);
    }
    qsort(latency, (size_t)interrupts, sizeof latency[0], by_time);
    const double p99 = (double)latency[interrupts * 99 / 100] * 1e-6;
    print_message("# %d interrupts: stopped after %.3f ms (median), %.3f ms (99th percentile)\n",
                  interrupts, (double)latency[interrupts / 2] * 1e-6, p99);
    assert_true(p99 <= 100);
}

RUN_TESTS(NULL, NULL)
