/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A step that fails leaves nothing: every method row, with fixed and adaptive steps, every way of
 * recording, on scenes that end at some time because a force is NaN, a root is gone, a number
 * overflows or drag has a pole. What the run holds then is what it held before, bit for bit: its
 * twin, which was told to stop there, has the same.
 */
#include "unit/run/fixture.h"
#include "unit/scene/typing.h"

#include <float.h>

#define SPAN 3.0
#define LARGEST 1e160 /* positions end at 1e150, velocities at about as much */

static struct typed_models *models;

static struct scene typed_scene(const char *const *lines)
{
    struct scene scene;
    scene_init(&scene, NULL);
    assert_true(type_scene(models, &scene, lines));
    return scene;
}

#define TYPED(...) typed_scene((const char *const[]){__VA_ARGS__, NULL})

static struct scene preset_with(const char *preset, const char *name, double value)
{
    struct scene scene;
    struct error error;
    scene_init(&scene, preset_by_name(text_of(preset)));
    assert_true(scene_set(&scene, scene_param(&scene, name), (struct measured){value, 0}, &error));
    return scene;
}

struct case_of {
    const char *name;
    struct scene scene;
    double span; /* [s] never reached */
    double last; /* [s] no sound state is later, but for a step; HUGE_VAL: depends on the method */
    bool passes; /* steps of fixed size may jump across what ends it */
};

static enum stop go(struct run *run, double span, int64_t steps)
{
    const struct run_target target = {.t = run->system.t0 + span, .steps = steps};
    run_advance(run, &target, 0, NULL);
    return run->stop;
}

static void check_rows(const struct case_of *c, const struct run *run, const char *what)
{
    const size_t rows = trace_count(run->trace);
    for (size_t i = 0; i < rows; i++)
        for (int k = 0; k < run->system.n; k++)
            if (!(fabs(trace_state(run->trace, i)[k]) <= LARGEST))
                fail_msg("%s: row %zu of %zu holds %g", what, i, rows,
                         trace_state(run->trace, i)[k]);
    if (fabs(trace_time(run->trace, rows - 1) - run->t) >
            8 * DBL_EPSILON * fabs(run->t) || /* even times are rounded */
        memcmp(trace_state(run->trace, rows - 1), run->y, (size_t)run->system.n * sizeof *run->y) !=
            0)
        fail_msg("%s: the last row is not the present state", what);
    /* A step that does not look at its end goes beyond by all of it (a step of control: by a part).
     */
    if (!(fabs(run->t) <= c->last + (run->plan.adaptive ? 0.1 : 1.001 * fabs(run->settings.dt))))
        fail_msg("%s: it got to %.17g s", what, run->t);
}

static void check_ledgers(const struct run *a, const struct run *b, const char *what)
{
    struct ledger left, right;
    run_ledger(a, &left);
    run_ledger(b, &right);
    if (bits(left.error) != bits(right.error) || bits(left.error_max) != bits(right.error_max) ||
        bits(left.work) != bits(right.work) || bits(left.final) != bits(right.final))
        fail_msg("%s: the ledgers differ: %g %g, work %g %g", what, left.error_max, right.error_max,
                 left.work, right.work);
}

/* Runs the case by a method. Fails unless the run ends with a reason, its last row is the present
 * state, and rows, state and energy balance have the bits of a second run (twin) that takes exactly
 * the steps which succeeded. Returns false if the method does not apply. */
static bool check(const struct case_of *c, const char *method, const struct run_settings *settings,
                  const char *what)
{
    struct error error;
    struct run *run = run_create(&c->scene, method_named(method), settings, c->span, &error);
    if (!run)
        return false;
    struct run *twin = start(&c->scene, method, *settings, c->span);
    const enum stop stop = go(run, c->span, -1);
    if (stop == STOP_END && c->passes) {
        check_rows(c, run, what);
        run_destroy(run);
        run_destroy(twin);
        return true;
    }
    if (stop != STOP_DIVERGED && stop != STOP_NO_SOLUTION && stop != STOP_STALLED &&
        stop != STOP_SINGULAR)
        fail_msg("%s: %s at %g s", what, stop_name(stop), run->t);
    check_rows(c, run, what);
    if (stop ==
        STOP_SINGULAR) { /* it was stopped by what was seen of it, not by a step that failed */
        run_destroy(run);
        run_destroy(twin);
        return true;
    }
    if (run->steps > 0 && go(twin, c->span, run->steps) != STOP_END)
        fail_msg("%s: its twin ended after %lld of %lld steps", what, (long long)twin->steps,
                 (long long)run->steps);
    if (trace_count(run->trace) != trace_count(twin->trace) || bits(run->t) != bits(twin->t) ||
        memcmp(run->y, twin->y, (size_t)run->system.n * sizeof *run->y) != 0)
        fail_msg("%s: %zu rows to %.17g s, its twin has %zu to %.17g s", what,
                 trace_count(run->trace), run->t, trace_count(twin->trace), twin->t);
    assert_same_trace(run, twin);
    check_ledgers(run, twin, what);
    /* Nor does another try leave anything. Methods that remember earlier steps start again, and
     * would take other steps than before. */
    if (!run->method->growth && !(run->method->flags & METHOD_EXTERNAL))
        go(run, c->span, -1);
    if (trace_count(run->trace) != trace_count(twin->trace))
        fail_msg("%s: another try added rows", what);
    assert_same_trace(run, twin);
    run_destroy(run);
    run_destroy(twin);
    return true;
}

static int check_methods(const struct case_of *c, double dt)
{
    const struct run_settings ways[] = {
        {.dt = dt},
        {.dt = dt, .record = {.rule = RECORD_ALL}},
        {.dt = dt, .record = {.rule = RECORD_EVERY, .every = 7}},
        {.dt = dt, .record = {.rule = RECORD_TIMES, .interval = 0.037}},
        {.dt = dt, .kernel = KERNEL_GENERAL, .compensated = true},
        {.dt = dt, .tol = 1e-6},
        {.dt = dt, .tol = 1e-6, .record = {.rule = RECORD_TIMES, .interval = 0.037}},
    };
    int checked = 0;
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        for (size_t way = 0; way < COUNT_OF(ways); way++) {
            if (ways[way].tol > 0 ? !(method->flags & METHOD_ADAPTIVE)
                                  : (method->flags & METHOD_EXTERNAL) != 0)
                continue;
            char what[200];
            snprintf(what, sizeof what, "%s by %s, dt = %g s, way %zu", c->name, method->row.name,
                     dt, way);
            checked += check(c, method->row.name, &ways[way], what);
        }
    }
    return checked;
}

/* From 1.5 s on sqrt(1.5 - t) is not a number, so that no solution exists beyond. By every method
 * and every way of recording, a run must end there, and be the same as a run of as many steps that
 * does not try to go on (check()). At least 100 combinations must have applied. */
TEST(test_a_force_that_ends)
{
    const struct case_of cases[] = {
        {"a force until 1.5 s", TYPED("var x = 1", "x'' = -x + sqrt(1.5 - t) - sqrt(1.5 - t)"),
         SPAN, 1.5, false},
        {"two coordinates until 1.5 s",
         TYPED("var x = 1", "var y = 0.5", "x'' = y - 2*x", "y'' = x - 2*y + 0*x + sqrt(1.5 - t)"),
         SPAN, 1.5, false},
        {"drag until 1.5 s", TYPED("var x = 1", "x'' = -x - sqrt(1.5 - t)*x'"), SPAN, 1.5, false},
        {"a rate until 1.5 s", TYPED("var x = 1", "x' = -x*sqrt(1.5 - t)"), SPAN, 1.5, false},
        {"a force on the spring until 1.5 s", TYPED("force 0.1*sqrt(1.5 - t)"), SPAN, 1.5, false},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const int checked = check_methods(&cases[i], 0.01) + check_methods(&cases[i], 0.3);
        if (checked < 100)
            fail_msg("%s: only %d set-ups", cases[i].name, checked);
    }
}

TEST(test_a_state_that_ends)
{
    const struct case_of cases[] = {
        {"a root that goes", TYPED("var x = 1", "x'' = -1 - sqrt(x)"), SPAN, 1.2, false},
        {"a quartic hill", TYPED("var x = 1", "var x' = 1", "x'' = -x + 2*x^3"), SPAN, HUGE_VAL,
         true},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        assert_true(check_methods(&cases[i], 0.01) > 100);
}

TEST(test_numbers_that_end)
{
    const struct case_of cases[] = {
        {"an inverted spring", preset_with("inverted", "k", -1500), 100, HUGE_VAL, false},
        {"quadratic drag backwards", preset_with("drag", "v0", -3), -10, HUGE_VAL, true},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        assert_true(check_methods(&cases[i], 0.01) > 100);
}

static int set_up_models(void **state)
{
    struct error error;
    (void)state;
    models = typed_create(&error);
    return models ? 0 : -1;
}

static int free_models(void **state)
{
    (void)state;
    typed_destroy(models);
    return 0;
}

RUN_TESTS(set_up_models, free_models)
