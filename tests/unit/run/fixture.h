/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the tests of the run layer share: scenes by parameters, runs that must exist, comparing
 * bits. */
#pragma once

#include "cmocka_testing.h"

#include <hooke/base/catalog.h>
#include <hooke/run.h>
#include <math.h>
#include <string.h>

struct measured;
struct row;

#define FOREVER ((struct run_target){.t = HUGE_VAL, .steps = -1})

static inline void set(struct scene *scene, const char *name, double value)
{
    struct error error;
    if (!scene_set(scene, param_index(name), (struct measured){value, 0}, &error))
        fail_msg("set %s: %s", name, error.text);
}

/* The lab's spring: m = 200 g, k = 15 N/m, y0 = 5 cm, undamped. */
static inline struct scene spring(void)
{
    struct scene scene;
    scene_init(&scene, NULL);
    return scene;
}

static inline const struct method *method_named(const char *name)
{
    const struct row *row = catalog_find(&method_catalog, text_of(name));
    if (!row)
        fail_msg("no method %s", name);
    return method_from(row);
}

static inline const struct observable *observable_named(const char *name)
{
    const struct row *row = catalog_find(&observable_catalog, text_of(name));
    if (!row)
        fail_msg("no observable %s", name);
    return observable_from(row);
}

static inline struct run *start(const struct scene *scene, const char *method,
                                struct run_settings settings, double span)
{
    struct error error;
    struct run *run = run_create(scene, method_named(method), &settings, span, &error);
    if (!run)
        fail_msg("%s: %s", method, error.text);
    return run;
}

static inline void go_to(struct run *run, double t)
{
    struct run_target target = {.t = t, .steps = -1};
    assert_false(run_advance(run, &target, 0, NULL));
}

static inline void go_steps(struct run *run, int64_t steps)
{
    struct run_target target = {.t = HUGE_VAL, .steps = steps};
    assert_false(run_advance(run, &target, 0, NULL));
}

static inline uint64_t bits(double x)
{
    uint64_t u;
    memcpy(&u, &x, sizeof u);
    return u;
}

#define assert_bits(a, b) assert_int_equal(bits(a), bits(b))

static inline void assert_close_at(double got, double wanted, double tolerance, const char *what,
                                   int line)
{
    if (!(fabs(got - wanted) <= tolerance))
        fail_msg("line %d: %s = %.17g, wanted %.17g +- %.3g", line, what, got, wanted, tolerance);
}

#define assert_close(got, wanted, tolerance) assert_close_at(got, wanted, tolerance, #got, __LINE__)

/* Same rows, same times, same states, same present: bit for bit. */
static inline void assert_same_trace(const struct run *a, const struct run *b)
{
    assert_int_equal(trace_count(a->trace), trace_count(b->trace));
    for (size_t i = 0; i < trace_count(a->trace); i++) {
        if (trace_step(a->trace, i) != trace_step(b->trace, i) ||
            bits(trace_time(a->trace, i)) != bits(trace_time(b->trace, i)) ||
            memcmp(trace_state(a->trace, i), trace_state(b->trace, i),
                   (size_t)a->system.n * sizeof(double)) != 0)
            fail_msg("row %zu differs: step %lld %lld, t %.17g %.17g", i,
                     (long long)trace_step(a->trace, i), (long long)trace_step(b->trace, i),
                     trace_time(a->trace, i), trace_time(b->trace, i));
    }
    assert_int_equal(a->steps, b->steps);
    assert_bits(a->t, b->t);
    assert_memory_equal(a->y, b->y, (size_t)a->system.n * sizeof(double));
}
