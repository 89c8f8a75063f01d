/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is not asked for costs nothing; what recording, watching, decimating and compensated sums
 * cost. */
#include "bench/bench.h"
#include <hooke/base/catalog.h>
#include "modules/solving/compute/solve.h"

#include <stdio.h>
#include <stdlib.h>

#define DT 0.01
#define STEPS 61440 /* whole chunks of the loop by hand */
/* [byte] a trace of 8192 rows: the same is done beyond a million, in samples too long to be
 * quiet */
#define CAP 196608
/* steps between two looks of a live pane: fewer than 60 a second would ask for */
#define SLICE 8192

struct job {
    struct scene scene;
    const char *method;
    struct run_settings settings;
    int64_t steps;
    bool watched;  /* the energy, live */
    bool exported; /* the energy of every row, afterwards */
};

static double run_job(void *self)
{
    const struct job *job = self;
    struct run *run = bench_run(&job->scene, bench_method(job->method), &job->settings,
                                (double)job->steps * job->settings.dt);
    if (!run)
        return NAN;
    const struct observable *energy =
        (const void *)catalog_find(&observable_catalog, TEXT("energy"));
    double sum = 0;
    const int64_t begin = clock_ns();
    while (run->steps < job->steps) {
        const int64_t left = job->steps - run->steps;
        const struct run_target target = {.t = HUGE_VAL,
                                          .steps = job->watched && left > SLICE ? SLICE : left};
        while (run_advance(run, &target, 0, NULL)) {
        }
        if (job->watched)
            sum += run_observable(run, energy);
    }
    double ns = (double)(clock_ns() - begin) / (double)run->steps;
    if (job->exported) {
        double *column = malloc(trace_count(run->trace) * sizeof *column);
        const int64_t start = clock_ns();
        struct error error = {0};
        if (!column || !run_column(run, energy, column, &error))
            bench_die("energy", error.text);
        ns = (double)(clock_ns() - start) / (double)trace_count(run->trace);
        free(column);
    }
    run_destroy(run);
    return ns + 1e-300 * sum;
}

/* The steps alone: nothing is recorded. */
struct bare {
    struct system system;
    struct solver solver;
    int64_t steps;
};

static double run_bare(void *self)
{
    struct bare *bare = self;
    const int64_t begin = clock_ns();
    solver_start(&bare->solver);
    if (solver_run(&bare->solver, NULL, NULL) != STOP_END)
        return NAN;
    return (double)(clock_ns() - begin) / (double)bare->steps;
}

static void bare_init(struct bare *bare, const struct job *job)
{
    struct error error = {0};
    struct run_settings settings = job->settings;
    const struct method *method = bench_method(job->method);
    bare->steps = job->steps;
    if (!scene_bind(&job->scene, &bare->system, &error) ||
        !method_applies(method, &bare->system, &settings.drag, &error) ||
        !solver_init(&bare->solver, &bare->system, method, &settings,
                     (double)job->steps * settings.dt))
        bench_die(job->method, error.text);
}

/* A loop by hand that keeps the last chunk only. */
struct ring {
    const struct hand_scene *scene;
    hand_loop *loop;
    int64_t steps;
};

static double run_ring(void *self)
{
    enum { CHUNK = 4096 };
    const struct ring *ring = self;
    static double row[CHUNK * 2];
    double state[] = {1, 0};
    const int64_t begin = clock_ns();
    for (int64_t i = 0; i < ring->steps; i += CHUNK)
        ring->loop(&ring->scene->known, DT, i, CHUNK, state, row);
    return (double)(clock_ns() - begin) / (double)ring->steps + 1e-300 * state[0];
}

static struct job job(const char *preset, const char *method, int64_t steps)
{
    return (struct job){.scene = bench_scene(preset, NULL, 0),
                        .method = method,
                        .settings = {.dt = DT, .kernel = KERNEL_PROPAGATOR},
                        .steps = steps};
}

static void zero(struct scene *scene, const char *name)
{
    struct error error = {0};
    if (!scene_set(scene, scene_param(scene, name), (struct measured){0, 0}, &error))
        bench_die(name, error.text);
}

static void left_out(void)
{
    static const char *const kernels[] = {"propagator", "kernel", "general"};
    table_begin("What is not asked for", "ns a step");
    for (enum kernel kernel = KERNEL_PROPAGATOR; kernel <= KERNEL_GENERAL; kernel++) {
        struct job plain =
            job(kernel == KERNEL_PROPAGATOR ? "spring" : "duffing", "rk4", STEPS >> 2 * kernel);
        plain.settings.kernel = kernel;
        struct job zeroed = plain;
        zero(&zeroed.scene, "gamma");
        zero(&zeroed.scene, "F0");
        zero(&zeroed.scene, "C");
        zero(&zeroed.scene, "mu");
        struct arm arm[] = {ARM(run_job, &zeroed), ARM(run_job, &plain)};
        char what[64];
        contest(arm, 2);
        snprintf(what, sizeof what, "rk4, drag and drive set to 0: %s", kernels[kernel]);
        table_row(what, &arm[0], "never set", &arm[1], 1.03);
    }
}

static void recording(void)
{
    struct job few = job("duffing", "verlet", STEPS), many = few;
    struct job watched = many, rare = many, exported = few;
    many.settings.memory = watched.settings.memory = CAP;
    watched.watched = true;
    exported.exported = true;
    rare.settings.record = (struct recording_rule){.rule = RECORD_EVERY, .every = 1000};
    struct bare bare;
    bare_init(&bare, &few);
    struct ring ring = {hand_scene("duffing"), hand_find(hand_scene("duffing"), "verlet"), STEPS};
    struct arm arm[] = {ARM(run_job, &few),     ARM(run_bare, &bare), ARM(run_job, &many),
                        ARM(run_job, &watched), ARM(run_job, &rare),  ARM(run_ring, &ring),
                        ARM(run_job, &exported)};
    contest(arm, 7);
    table_begin("Recording: verlet on the Duffing spring", "ns a step");
    table_row("every step recorded", &arm[0], "not recorded", &arm[1], 1.03);
    table_row("decimated on the way, to 8192 rows", &arm[2], "C loop, unrecorded", &arm[5], 1.15);
    table_row("and the energy watched live", &arm[3], "C loop, unrecorded", &arm[5], 1.15);
    table_row("every thousandth step recorded", &arm[4], "C loop, unrecorded", &arm[5], 1.05);
    table_row("energy of each row, when exported", &arm[6], "a step", &arm[0], NAN);
    solver_free(&bare.solver);
}

static void compensated(void)
{
    static const char *const methods[] = {"verlet", "rk4", "dopri5"};
    table_begin("Compensated sums", "ns a step");
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        struct job plain = job("duffing", methods[i], STEPS / 8), careful, general;
        careful = general = plain;
        careful.settings.compensated = true;
        general.settings.kernel = KERNEL_GENERAL;
        struct arm arm[] = {ARM(run_job, &careful), ARM(run_job, &plain), ARM(run_job, &general)};
        contest(arm, 3);
        table_row(methods[i], &arm[0], "plain, kernel", &arm[1], NAN);
        table_row("", &arm[0], "plain, general", &arm[2], NAN);
    }
}

void bench_cost(void)
{
    left_out();
    recording();
    compensated();
}
