/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Steps of fixed size, recording y and v: each method on each scene against the loop by hand, and
 * against libraries. */
#include "bench/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* at most: what they leave behind fits into the second cache, for the loops as for hooke */
#define STEPS 60000
#define SAMPLE_NS 4e5 /* short, so that some samples of a round meet nobody else */
#define DT 0.01

/* A recorded run: time of the steps alone. */
struct recorded {
    struct scene scene;
    const struct method *method;
    struct run_settings settings;
    int64_t steps;
    bool cold;
    double end[LIMIT_VARIABLES];
    const char *way;
};

static double run_recorded(void *self)
{
    struct recorded *r = self;
    struct run *run =
        bench_run(&r->scene, r->method, &r->settings, (double)r->steps * r->settings.dt);
    if (!run)
        return NAN;
    if (r->cold)
        memory_cold();
    const struct run_target target = {.t = HUGE_VAL, .steps = r->steps};
    const int64_t begin = clock_ns();
    while (run_advance(run, &target, 0, NULL)) {
    }
    const double ns = (double)(clock_ns() - begin) / (double)run->steps;
    memcpy(r->end, run->y, sizeof r->end);
    r->way = run->plan.propagates                                         ? "propagator"
             : method_kernel(r->method, &run->system, run->settings.drag) ? "kernel"
             : method_step_kernel(r->method, &run->system)                ? "step kernel"
                                                                          : "general";
    run_destroy(run);
    return ns;
}

/* A loop by hand or by a library, into memory that is warm, or from the system. */
struct looped {
    const struct hand_scene *scene;
    hand_loop *loop;
    double start[LIMIT_VARIABLES], end[LIMIT_VARIABLES];
    double *row;
    int64_t steps;
    bool cold;
};

static double run_looped(void *self)
{
    struct looped *l = self;
    const size_t size = (size_t)(l->steps * l->scene->n) * sizeof(double);
    double state[LIMIT_VARIABLES];
    double *row = l->row;
    memcpy(state, l->start, sizeof state);
    if (l->cold) {
        memory_cold();
        row = malloc(size);
    }
    if (!row)
        return NAN;
    const int64_t begin = clock_ns();
    l->loop(&l->scene->known, DT, 0, l->steps, state, row);
    const double ns = (double)(clock_ns() - begin) / (double)l->steps;
    memcpy(l->end, state, sizeof state);
    if (l->cold)
        free(row);
    return ns;
}

static struct looped looped(const struct hand_scene *scene, hand_loop *loop, double *row)
{
    struct looped l = {.scene = scene, .loop = loop, .row = row, .steps = STEPS};
    const struct scene bound = bench_scene(scene->preset, NULL, 0);
    struct system system;
    struct error error = {0};
    if (!scene_bind(&bound, &system, &error))
        bench_die(scene->name, error.text);
    memcpy(l.start, system.start, sizeof l.start);
    return l;
}

static struct recorded recorded(const struct hand_scene *scene, const char *method,
                                enum kernel kernel)
{
    return (struct recorded){.scene = bench_scene(scene->preset, NULL, 0),
                             .method = bench_method(method),
                             .settings = {.dt = DT, .kernel = kernel},
                             .steps = STEPS};
}

/* Both must do the same. Steps cut at turning points are another method, and a propagator rounds
 * differently. */
static double apart(const struct hand_scene *scene, const double *a, const double *b)
{
    double max = 0;
    for (int i = 0; i < scene->n; i++)
        max = fmax(max, fabs(a[i] - b[i]) / (1 + fabs(a[i])));
    return max;
}

/* So many steps that a sample is short. */
static int64_t few_steps(double ns)
{
    return SAMPLE_NS / ns < STEPS ? (int64_t)(SAMPLE_NS / ns) : STEPS;
}

static double *rows(int n)
{
    double *row = malloc((size_t)(STEPS * n) * sizeof *row);
    if (!row)
        bench_die("rows", "out of memory");
    memset(row, 0, (size_t)(STEPS * n) * sizeof *row);
    return row;
}

static void against_hand(const char *method, const struct hand_scene *scene, double *row)
{
    hand_loop *loop = hand_find(scene, method);
    struct recorded best = recorded(scene, method, KERNEL_PROPAGATOR);
    if (!loop || isnan(run_recorded(&best))) /* warm from now on */
        return;
    struct looped hand = looped(scene, loop, row);
    struct arm arm[] = {ARM(run_recorded, &best), ARM(run_looped, &hand)};
    best.steps = hand.steps = few_steps(run_recorded(&best));
    run_recorded(&best);
    run_looped(&hand);
    const double distance = apart(scene, best.end, hand.end);
    hand.steps = few_steps(run_looped(&hand));
    contest(arm, 2);
    char what[64];
    snprintf(what, sizeof what, "%s, %s: %s", method, scene->name, best.way);
    const double goal = bench_method(method)->flags & METHOD_IMPLICIT ? 1.3 : 1.05;
    table_row(what, &arm[0], distance > 1e-8 ? "C loop (differs)" : "C loop", &arm[1], goal);
}

/* Kernels stay only while they gain. */
static void against_general(const char *method, const char *scene)
{
    struct recorded best = recorded(hand_scene(scene), method, KERNEL_PROPAGATOR);
    struct recorded general = recorded(hand_scene(scene), method, KERNEL_GENERAL);
    struct arm arm[] = {ARM(run_recorded, &best), ARM(run_recorded, &general)};
    char what[64];
    run_recorded(&best);
    best.steps = few_steps(run_recorded(&best));
    general.steps = few_steps(run_recorded(&general));
    contest(arm, 2);
    snprintf(what, sizeof what, "%s, %s: %s", method, scene, best.way);
    table_row(what, &arm[0], "kernel = general", &arm[1], 1);
}

static void against_libraries(double *row)
{
    static const struct {
        const char *method, *name;
        hand_loop *(*find)(const char *method, const char *scene);
    } rivals[] = {
#ifdef HAVE_BOOST
        {"euler", "boost odeint", boost_loop},
        {"rk4", "boost odeint", boost_loop},
        {"dopri5", "boost odeint", boost_loop},
#endif
        {"rk4", "gsl rk4", gsl_loop},
    };
    static const char *const scenes[] = {"duffing", "quadratic drag", "van der pol"};
    table_begin("Fixed step, recorded, against libraries", "ns a step");
    for (size_t i = 0; i < COUNT_OF(rivals); i++)
        for (size_t s = 0; s < COUNT_OF(scenes); s++) {
            const struct hand_scene *scene = hand_scene(scenes[s]);
            struct recorded best = recorded(scene, rivals[i].method, KERNEL_PROPAGATOR);
            struct looped other = looped(scene, rivals[i].find(rivals[i].method, scenes[s]), row);
            struct arm arm[] = {ARM(run_recorded, &best), ARM(run_looped, &other)};
            char what[64];
            run_recorded(&best);
            best.steps = few_steps(run_recorded(&best));
            other.steps = few_steps(run_looped(&other));
            contest(arm, 2);
            snprintf(what, sizeof what, "%s, %s", rivals[i].method, scene->name);
            table_row(what, &arm[0], rivals[i].name, &arm[1], 1);
        }
#ifndef HAVE_BOOST
    table_absent("boost odeint", "not installed (libboost-dev)");
#endif
}

void bench_fixed(void)
{
    static const char *const methods[] = {"euler", "symplectic-euler", "verlet", "rk4", "dopri5",
                                          "pefrl", "implicit-midpoint"};
    double *row = rows(4);
    table_begin("Fixed step, y and v recorded into warm memory", "ns a step");
    for (size_t m = 0; m < COUNT_OF(methods); m++)
        for (const struct hand_scene *scene = hand_scenes; scene->name; scene++)
            against_hand(methods[m], scene, row);
    table_note(
        "C loop: written for this method and scene alone, compiled with the same flags as hooke.");
    table_note("differs: hooke ends steps of order above 2 at the turning points of |v|v and keeps "
               "its order.");
    table_begin("What kernels gain", "ns a step");
    for (size_t m = 0; m < COUNT_OF(methods); m++) {
        against_general(methods[m], "linear drag");
        against_general(methods[m], "duffing");
    }
    against_libraries(row);

    struct recorded fresh = recorded(hand_scene("duffing"), "verlet", KERNEL_PROPAGATOR);
    struct looped hand =
        looped(hand_scene("duffing"), hand_find(hand_scene("duffing"), "verlet"), row);
    fresh.cold = hand.cold = true;
    struct arm arm[] = {ARM(run_recorded, &fresh), ARM(run_looped, &hand)};
    contest(arm, 2);
    table_begin("The same into memory fresh from the system", "ns a step");
    table_row("verlet, duffing", &arm[0], "C loop", &arm[1], 1.05);
    free(row);
}

/* ---- linear scenes ---- */

/* Against the C loop of the first; then each method against the first, for all cost the same. */
void bench_linear(void)
{
    static const char *const methods[] = {"symplectic-euler",  "verlet", "rk4", "dop853",
                                          "implicit-midpoint", "gauss6"};
    const struct hand_scene *scene = hand_scene("linear drag");
    double *row = rows(4);
    struct looped hand = looped(scene, hand_find(scene, methods[0]), row);
    struct recorded of[COUNT_OF(methods)];
    struct arm arm[COUNT_OF(methods) + 1];
    for (size_t i = 0; i < COUNT_OF(methods); i++) {
        of[i] = recorded(scene, methods[i], KERNEL_PROPAGATOR);
        arm[i] = (struct arm)ARM(run_recorded, &of[i]);
    }
    arm[COUNT_OF(methods)] = (struct arm)ARM(run_looped, &hand);
    contest(arm, COUNT_OF(arm));
    table_begin("A linear scene by its propagator, recorded", "ns a step");
    table_row(methods[0], &arm[0], "C loop", &arm[COUNT_OF(methods)], 0.25);
    for (size_t i = 1; i < COUNT_OF(methods); i++)
        table_row(methods[i], &arm[i], methods[0], &arm[0], 1.1);
    free(row);
}
