/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Memory of runs under an allocator that counts and fails: none inside a step, a bound, every
 * failure survived. */
#include "unit/run/fixture.h"

#include <malloc.h>
#include <stdlib.h>

#if defined __has_feature
#if __has_feature(address_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define SANITIZED 1
#endif

static int64_t calls, fail_at; /* fail_at: number of the call that fails, 0: none */
static bool fail_on;           /* and all after it */
static size_t live, peak;

#ifndef SANITIZED

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *memory);

static bool failing(void)
{
    calls++;
    return fail_at > 0 && (calls == fail_at || (fail_on && calls > fail_at));
}

#define LARGE_PAGE ((size_t)1 << 21)

/* For a block that is aligned to large pages the allocator also takes addresses that nobody
 * touches: no memory. */
static size_t size_of(void *memory)
{
    const bool large = (uintptr_t)memory % LARGE_PAGE == 0;
    return !memory ? 0 : large ? LARGE_PAGE : malloc_usable_size(memory);
}

static void *counted(void *memory)
{
    live += size_of(memory);
    peak = live > peak ? live : peak;
    return memory;
}

void *malloc(size_t size)
{
    return failing() ? NULL : counted(__libc_malloc(size));
}

void *calloc(size_t count, size_t size)
{
    return failing() ? NULL : counted(__libc_calloc(count, size));
}

void *realloc(void *old, size_t size)
{
    if (failing())
        return NULL;
    size_t before = size_of(old);
    void *memory = __libc_realloc(old, size);
    live -= memory ? before : 0;
    return counted(memory);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return failing() ? NULL : counted(__libc_memalign(alignment, size));
}

void free(void *memory)
{
    live -= size_of(memory);
    __libc_free(memory);
}

#define NEEDS_ALLOCATOR()
#else
#define NEEDS_ALLOCATOR()                                                                          \
    do {                                                                                           \
        print_message("the sanitizer's allocator cannot be replaced\n");                           \
        skip();                                                                                    \
    } while (0)
#endif

TEST(test_no_allocation_in_steps)
{
    NEEDS_ALLOCATOR();
    struct scene scene = spring();
    set(&scene, "gamma", 0.1);
    for (size_t i = 0; i < method_catalog.count; i++) {
        struct run_settings settings = {.dt = 1e-3};
        struct error error;
        const struct row *row = catalog_row(&method_catalog, i);
        struct run *run = run_create(&scene, method_named(row->name), &settings, HUGE_VAL, &error);
        if (!run)
            continue;
        go_steps(run, 1);
        int64_t before = calls;
        go_steps(run, 4000); /* within the first chunk of 4096 rows */
        if (calls != before)
            fail_msg("%s: %lld allocations", row->name, (long long)(calls - before));
        go_steps(run, 200); /* the second chunk */
        assert_int_equal(calls, before + 1);
        run_destroy(run);
    }
}

TEST(test_peak_of_a_long_run)
{
    NEEDS_ALLOCATOR();
    size_t before = live;
    struct scene scene = spring();
    peak = live;
    struct run *run =
        start(&scene, "symplectic-euler", (struct run_settings){.dt = 1e-3}, HUGE_VAL);
    go_steps(run, 5 * LIMIT_SAMPLES);
    assert_true(peak - before < 64000000);
    size_t used = live - before;
    /* beside the rows: the run, its method's memory and its one epoch with its plan */
    assert_true(trace_bytes(run->trace) <= used && used < trace_bytes(run->trace) + 110000);
    run_destroy(run);
    assert_int_equal(live, before);
}

/* What a session does with a run. Wherever memory ends, the run stays usable and says so. */
static void scenario(void)
{
    struct scene scene = spring();
    struct error error = {0};
    struct run_settings settings = {.dt = 1e-3};
    struct run *run = run_create(&scene, method_named("rk4"), &settings, HUGE_VAL, &error);
    if (!run) {
        assert_non_null(strstr(error.text, "memory"));
        return;
    }
    do { /* a chunk that cannot be had stops the run; the next call tries again */
        struct run_target target = {.t = HUGE_VAL, .steps = 9000 - run->steps};
        run_advance(run, &target, 0, NULL);
        assert_true(run->stop == STOP_END || run->stop == STOP_FULL);
        assert_int_equal(trace_step(run->trace, trace_count(run->trace) - 1), run->steps);
    } while (run->steps < 9000 && !fail_on);
    set(&scene, "k", 20);
    if (!run_rebind(run, &scene, &error))
        assert_non_null(strstr(error.text, "memory"));
    struct run_target target = {.t = run->t + 0.0105, .steps = -1};
    for (int tries = 0; tries < 2 && run->t < target.t; tries++)
        run_advance(run, &target, 0, NULL);
    if (!fail_on)
        assert_bits(run->t, 9000 * 1e-3 + 0.0105);
    bool enough = trace_count(run->trace) > 5;
    assert_int_equal(run_back(run, 5), enough);
    assert_true(isfinite(run_observable(run, observable_named("energy-error"))));
    run_destroy(run);
}

TEST(test_every_allocation_fails)
{
    NEEDS_ALLOCATOR();
    size_t before = live;
    calls = 0;
    scenario();
    int64_t count = calls;
    assert_true(count >= 8);
    for (int ever = 0; ever < 2; ever++) {
        for (int64_t i = 1; i <= count; i++) {
            calls = 0;
            fail_at = i;
            fail_on = ever != 0;
            scenario();
            fail_at = 0;
            assert_int_equal(live, before);
        }
    }
}

RUN_TESTS(NULL, NULL)
