/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps: many trajectories side by side, against loops over lanes by hand and against one
 * trajectory after another. */
#include "modules/lanes/lanes.h"
#include "bench/bench.h"
#include "modules/sweep/compute/sweep.h"

#include "unit/scene/typing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

#define STEPS 2000
#define H 0.01

static volatile double sink;

/* ---- in lanes ---- */

struct lane_case {
    const char *method, *preset;
    struct lanes *lanes;
    struct system system;
    enum drag drag;
};

/* typed: a force, in place of the preset's; NULL: the preset's own. */
static bool lane_case_init(struct lane_case *one, const char *method, const char *preset,
                           const char *typed)
{
    struct scene scene = bench_scene(preset, NULL, 0);
    struct error error;
    if (typed) {
        struct typed_models *models = typed_create(&error); /* lives as long as the benchmark */
        const char *const lines[] = {"var y = 0.05", "param k = 75", "param c = 0.3",
                                     "param w = 2",  typed,          NULL};
        if (!models || !type_scene(models, &scene, lines))
            bench_die("sweep", typed);
    }
    *one = (struct lane_case){.method = method, .preset = preset, .lanes = lanes_create()};
    if (!one->lanes || !scene_bind(&scene, &one->system, &error) ||
        !method_applies(bench_method(method), &one->system, &one->drag, &error))
        return false;
    return lanes_fit(bench_method(method), &one->system, one->drag, H);
}

/* ns a trajectory-step */
static double in_lanes(void *self)
{
    struct lane_case *one = self;
    if (!lanes_begin(one->lanes, bench_method(one->method), one->drag, &one->system, H))
        bench_die("lanes", "out of memory");
    for (int lane = 0; lane < LANE_COUNT; lane++)
        lanes_set(one->lanes, lane, &one->system);
    const int64_t begin = clock_ns();
    lanes_march(one->lanes, STEPS, NULL);
    return (double)(clock_ns() - begin) / STEPS / LANE_COUNT;
}

static double one_by_one(void *self)
{
    struct lane_case *one = self;
    static double row[STEPS * 2];
    double work[64], y[2] = {one->system.start[0], one->system.start[1]};
    struct step step = {.system = &one->system, .drag = one->drag, .h = H, .y = y, .work = work};
    const struct march march = {&step, 0, 0, STEPS, row};
    enum step_status status;
    const struct method *method = bench_method(one->method);
    const int64_t begin = clock_ns();
    method_turning_march(method, method_kernel(method, &one->system, one->drag), &march, &status);
    sink = y[0];
    return (double)(clock_ns() - begin) / STEPS;
}

/* ---- by hand: loops over lanes that the compiler vectorises ---- */

#if defined(__x86_64__) && !defined(__clang__)
#define CLONES __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define CLONES
#endif

CLONES static void hand_euler(double *restrict y, double *restrict v, const double *restrict k)
{
    for (int i = 0; i < STEPS; i++)
        for (int lane = 0; lane < LANE_COUNT; lane++) {
            y[lane] += H * v[lane];
            v[lane] += H * -(k[lane] * y[lane]);
        }
}

CLONES static void hand_rk4(double *restrict y, double *restrict v, const double *restrict k)
{
    for (int i = 0; i < STEPS; i++)
        for (int lane = 0; lane < LANE_COUNT; lane++) {
            const double y1 = y[lane], v1 = v[lane], a1 = -(k[lane] * y1);
            const double v2 = v1 + H / 2 * a1, a2 = -(k[lane] * (y1 + H / 2 * v1));
            const double v3 = v1 + H / 2 * a2, a3 = -(k[lane] * (y1 + H / 2 * v2));
            const double v4 = v1 + H * a3, a4 = -(k[lane] * (y1 + H * v3));
            y[lane] = y1 + (H / 6 * v1 + H / 3 * v2 + H / 3 * v3 + H / 6 * v4);
            v[lane] = v1 + (H / 6 * a1 + H / 3 * a2 + H / 3 * a3 + H / 6 * a4);
        }
}

typedef void hand_lanes(double *restrict y, double *restrict v, const double *restrict k);

struct hand_case {
    hand_lanes *loop;
};

static double by_hand(void *self)
{
    double y[LANE_COUNT], v[LANE_COUNT], k[LANE_COUNT];
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        y[lane] = 0.05;
        v[lane] = 0;
        k[lane] = 75;
    }
    const int64_t begin = clock_ns();
    ((const struct hand_case *)self)->loop(y, v, k);
    const double ns = (double)(clock_ns() - begin) / STEPS / LANE_COUNT;
    sink = y[0];
    return ns;
}

/* ---- whole sweeps of the driven oscillator ---- */

struct sweep_case {
    const char *method;
    int threads, steps, points[2];
};

static double whole_sweep(void *self)
{
    const struct sweep_case *one = self;
    const struct scene scene = bench_scene("driven", NULL, 0);
    struct sweep_request request = {
        .scene = &scene,
        .method = bench_method(one->method),
        .settings = {.dt = H, .kernel = KERNEL_SPECIALISED},
        .duration = one->steps * H,
        .axis = {{.begin = 0.1, .end = 1, .count = one->points[0]},
                 {.begin = 0.01, .end = 1, .count = one->points[1]}},
        .axes = 2,
        .measure = {{.kind = SWEEP_AMPLITUDE, .column = SWEEP_VARIABLE}},
        .measures = 1,
        .shard = 1,
        .shards = 1,
        .threads = one->threads};
    struct sweep sweep;
    struct error error;
    if (!sweep_axis_find(&scene, TEXT("F0"), &request.axis[0]) ||
        !sweep_axis_find(&scene, TEXT("gamma"), &request.axis[1]) ||
        !study_sweep(&request, &sweep, &error))
        bench_die("sweep", error.text);
    const double ns = sweep.seconds * 1e9 / sweep.steps;
    sweep_free(&sweep);
    return ns;
}

/* Largest memory of the process so far. */
static double megabytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

static void threads_row(const char *method)
{
    struct sweep_case alone = {method, 1, 1000, {100, 300}}, two = {method, 2, 1000, {100, 300}};
    struct arm arm[] = {ARM(whole_sweep, &two), ARM(whole_sweep, &alone)};
    char what[64];
    snprintf(what, sizeof what, "%s, two threads", method);
    contest(arm, 2);
    table_row(what, &arm[0], "one thread", &arm[1], 1 / 1.8);
}

static void large_row(const char *method)
{
    struct sweep_case large = {method, 0, 100, {1000, 1000}};
    const double before = megabytes(), ns = whole_sweep(&large);
    table_note("%s, 1000 x 1000 points of 100 steps: %.2f s on all processors, %.2f us a point, "
               "%.0f MB more than before",
               method, ns * 1e8 * 1e-9, ns * 0.1, megabytes() - before);
}

/* Typed forces against built-in ones in lanes, and one by one. */
static void typed_rows(const char *typed, struct lane_case *built_in, double goal)
{
    struct lane_case one;
    if (!lane_case_init(&one, "rk4", "spring", typed))
        bench_die("sweep", typed);
    struct arm arm[] = {ARM(in_lanes, &one), ARM(one_by_one, &one), ARM(in_lanes, built_in)};
    contest(arm, 3);
    char what[64];
    snprintf(what, sizeof what, "lanes, %s", built_in->preset);
    table_row(typed, &arm[0], what, &arm[2], goal);
    table_row(typed, &arm[0], "one by one", &arm[1], NAN);
    lanes_destroy(one.lanes);
}

static void lane_rows(const char *method, const char *preset, struct hand_case *hand)
{
    struct lane_case one;
    if (!lane_case_init(&one, method, preset, NULL)) {
        table_note("%s with %s does not go in lanes", method, preset);
        lanes_destroy(one.lanes);
        return;
    }
    struct arm arm[] = {ARM(in_lanes, &one), ARM(one_by_one, &one), ARM(by_hand, hand)};
    contest(arm, hand ? 3 : 2);
    char what[64];
    snprintf(what, sizeof what, "%s, %s", method, preset);
    if (hand)
        table_row(what, &arm[0], "lanes by hand, C", &arm[2], 1.05);
    table_row(what, &arm[0], "one by one", &arm[1], NAN);
    table_note("%.2f G trajectory-steps/s a core", 1 / arm[0].minimum);
    lanes_destroy(one.lanes);
}

static void typed_topic(void)
{
    struct lane_case duffing, driven, drag;
    if (!lane_case_init(&duffing, "rk4", "duffing", NULL) ||
        !lane_case_init(&driven, "rk4", "driven", NULL) ||
        !lane_case_init(&drag, "rk4", "drag", NULL))
        bench_die("sweep", "they go in lanes");
    table_begin("Typed forces side by side, rk4", "ns a trajectory-step");
    typed_rows("y'' = -k*y - c*y^3", &duffing, 3);
    typed_rows("y'' = -k*y - c*y'*y^2", &duffing, 3);
    typed_rows("y'' = -k*y - c*y' + cos(w*t)", &driven, 3);
    typed_rows("y'' = -k*y - c*y'*abs(y')", &drag, 3);
    table_note("the last ones step to each turning point, 2.8 in 100 steps here; the second has "
               "as many operations without");
    lanes_destroy(duffing.lanes);
    lanes_destroy(driven.lanes);
    lanes_destroy(drag.lanes);
}

void bench_sweep(void)
{
    struct hand_case euler = {hand_euler}, rk4 = {hand_rk4};
    table_begin("Many trajectories side by side", "ns a trajectory-step");
    lane_rows("symplectic-euler", "spring", &euler);
    lane_rows("symplectic-euler", "driven", NULL);
    lane_rows("rk4", "spring", &rk4);
    lane_rows("rk4", "driven", NULL);
    lane_rows("rk4", "duffing", NULL);
    lane_rows("rk4", "drag", NULL);
    lane_rows("midpoint", "drag", NULL);
    lane_rows("verlet", "drag", NULL);
    table_note("rk4 steps to each turning point of quadratic drag, 2.8 in 100 steps here");
    typed_topic();
    table_begin("A sweep of the driven oscillator: 100 x 300 points, 1000 steps each, amplitude",
                "ns a trajectory-step");
    threads_row("rk4");
    threads_row("symplectic-euler");
    large_row("rk4");
    large_row("symplectic-euler");
}
