/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps at a section: the same bits in lanes and alone, those of a run's own events, the closed
 * form of a driven spring. */
#include "cmocka_testing.h"

#include <hooke/scene/formula.h>

#include "modules/sweep/compute/sweep.h"
#include "modules/solving/testing.h"

#include <string.h>

struct fixture {
    struct scene scene;
    struct sweep_request request;
    struct arena arena;
};

/* at: an event, or period. Columns are the first two variables. */
static void set_up(struct fixture *f, const char *preset, const char *method, double dt,
                   const char *axis, double from, double to, int count, const char *at)
{
    struct error error = {0};
    size_t used;
    *f = (struct fixture){.scene = scene_with(preset, NO_SETTINGS)};
    f->request = (struct sweep_request){.scene = &f->scene,
                                        .method = method_named(method),
                                        .settings = {.dt = dt, .kernel = KERNEL_SPECIALISED},
                                        .duration = 50,
                                        .axis = {{.begin = from, .end = to, .count = count}},
                                        .axes = 1,
                                        .shard = 1,
                                        .shards = 1,
                                        .section = {.wanted = true, .skip = 4, .keep = 6}};
    assert_true(sweep_axis_find(&f->scene, text_of(axis), &f->request.axis[0]));
    for (int k = 0; k < 2; k++)
        assert_true(sweep_measure_find(f->scene.model, text_of(f->scene.model->variable[k].name),
                                       &f->request.measure[f->request.measures++], &error));
    f->request.section.strobe = strcmp(at, "period") == 0;
    if (f->request.section.strobe)
        return;
    struct run *run = run_create(&f->scene, f->request.method, &f->request.settings, 1, &error);
    struct expr_scope scope;
    assert_non_null(run);
    run_scope(run, &scope);
    if (!event_compile(text_of(at), &scope, &f->arena, &f->request.section.event, &used, &error))
        fail_msg("%s", error.text);
    run_destroy(run);
}

static struct sweep sweep_of(const struct sweep_request *request)
{
    struct sweep sweep;
    struct error error = {0};
    if (!study_sweep(request, &sweep, &error))
        fail_msg("%s", error.text);
    return sweep;
}

static void assert_same_bits(const double *a, const double *b, int count, const char *what,
                             long long point)
{
    for (int k = 0; k < count; k++)
        if (memcmp(&a[k], &b[k], sizeof *a) != 0 && !(isnan(a[k]) && isnan(b[k])))
            fail_msg("%s, point %lld, number %d: %.17g and %.17g", what, point, k, a[k], b[k]);
}

static const struct {
    const char *preset, *axis;
    double from, to, dt;
    const char *at;
} cases[] = {
    {"pendulum-driven", "F0", 0.8, 1.4, 0.05, "period"},
    {"pendulum-driven", "omega", 0.5, 0.9, 0.05, "period"},
    {"pendulum-driven", "F0", 0.8, 1.4, 0.05, "rate falling"},
    {"pendulum-driven", "F0", 0.8, 1.4, 0.05, "sin(theta) rising"},
    {"duffing-driven", "F0", 0.2, 0.4, 0.05, "y > 0.5"},
    {"duffing-driven", "gamma", 0.2, 0.4, 0.05, "v"},
    {"duffing-driven", "gamma", 0.2, 0.4, 0.05, "y*v - 0.1 rising"},
    {"duffing-driven", "gamma", 0.2, 0.4, 0.05, "energy - 0.05 rising"},
    {"driven", "omega", 6, 12, 0.02, "period"},
    {"vanderpol", "mu", 0.5, 2, 0.02, "v falling"},
};

/* Alone: as a shard of one point. */
TEST(test_lanes_equal_runs)
{
    static const char *const methods[] = {"rk4", "heun", "dopri5", "verlet", "euler"};
    for (size_t c = 0; c < COUNT_OF(cases); c++)
        for (size_t m = 0; m < COUNT_OF(methods); m++) {
            struct fixture f;
            struct error error = {0};
            if (m > 0 && c != 0 && c != 2) /* the way is the same */
                continue;
            set_up(&f, cases[c].preset, methods[m], cases[c].dt, cases[c].axis, cases[c].from,
                   cases[c].to, 24, cases[c].at);
            struct sweep whole = sweep_of(&f.request);
            if (m == 0 && strncmp(cases[c].at, "energy", 6) != 0)
                assert_in_range(whole.side_by_side, 20, 24);
            for (int i = 0; i < 24; i += m == 0 ? 3 : 9) {
                struct sweep one;
                f.request.shards = 24;
                f.request.shard = i + 1;
                if (!study_sweep(&f.request, &one, &error) || one.count != 1)
                    fail_msg("%s", error.text);
                assert_int_equal(one.status[0], whole.status[i]);
                assert_same_bits(whole.value + i * whole.measures, one.value, whole.measures,
                                 methods[m], i);
                sweep_free(&one);
            }
            sweep_free(&whole);
            arena_reset(&f.arena);
        }
}

/* What 'event ... do record' keeps of a run. */
TEST(test_events_of_a_run)
{
    struct fixture f;
    struct error error = {0};
    set_up(&f, "duffing-driven", "rk4", 0.05, "F0", 0.3, 0.301, 24, "v falling");
    struct sweep sweep = sweep_of(&f.request);
    assert_int_equal(sweep.side_by_side, 24);
    struct run *run = run_create(&f.scene, f.request.method, &f.request.settings, 1, &error);
    struct expr_scope scope;
    run_scope(run, &scope);
    struct event event = f.request.section.event;
    event.scope = &scope;
    const struct run_target target = {.t = 100, .steps = -1, .event = &event, .events = 1};
    while (run_advance(run, &target, 0, NULL)) {
    }
    assert_true(run_event_records(run) >= 10);
    for (int k = 0; k < 6; k++) {
        const double *y = run_event_record_state(run, 4 + (size_t)k);
        const double wanted[] = {run_event_record(run, 4 + (size_t)k)->t, y[0], y[1]};
        assert_same_bits(sweep.value + 1 + 3 * k, wanted, 3, "event", k);
    }
    run_destroy(run);
    sweep_free(&sweep);
    arena_reset(&f.arena);
}

/* m y'' + m gamma y' + k y = F0 cos(omega t): once it has settled, y = Re A e^(i omega t). */
TEST(test_driven_spring)
{
    struct fixture f;
    set_up(&f, "driven", "rk4", 0.01, "omega", 6, 12, 25, "period");
    f.request.section.skip = 250;
    f.request.section.keep = 16;
    const double m = f.scene.value[scene_param(&f.scene, "m")],
                 k = f.scene.value[scene_param(&f.scene, "k")],
                 gamma = f.scene.value[scene_param(&f.scene, "gamma")],
                 force = f.scene.value[scene_param(&f.scene, "F0")];
    struct sweep sweep = sweep_of(&f.request);
    for (int i = 0; i < 25; i++) {
        const double omega = 6 + 0.25 * i, re = k / m - omega * omega, im = gamma * omega;
        const double *value = sweep.value + i * sweep.measures;
        const double y = force / m * re / (re * re + im * im);
        assert_true(value[0] == 1); /* one point */
        close_to(value[1], 251 * (2 * acos(-1) / omega), 1e-12 * value[1]);
        close_to(value[1 + 3 * 15 + 1], y, 2e-5 * force / m / hypot(re, im));
    }
    sweep_free(&sweep);
}

RUN_TESTS(NULL, NULL)
