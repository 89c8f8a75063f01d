/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes as typed, in runs: against loops in C, against the built-in scenes, and how soon they are
 * ready. */
#include "bench/bench.h"
#include "modules/solving/compute/solve.h"
#include "unit/scene/typing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 20000 };

struct typed {
    struct typed_models *models;
    struct scene scene;
    const struct method *method;
    struct run_settings settings;
    int64_t steps;
    int64_t entered; /* [ns] when the last line was */
    const char *way;
};

/* Lines between semicolons. */
static void type(struct typed *typed, const char *lines)
{
    struct error error = {0};
    struct text rest = text_of(lines), line;
    typed->models = typed_create(&error);
    if (!typed->models)
        bench_die(lines, error.text);
    scene_init(&typed->scene, NULL);
    while (text_split(&rest, ';', &line)) {
        typed->entered = clock_ns();
        const struct typed_line parsed = typing_line(text_trim(line));
        const struct model *model = typed_add(typed->models, typed->scene.model, &parsed, &error);
        if (!model)
            bench_die(lines, error.text);
        scene_remodel(&typed->scene, model);
    }
}

static double run_typed(void *self)
{
    struct typed *typed = self;
    struct run *run = bench_run(&typed->scene, typed->method, &typed->settings, HUGE_VAL);
    if (!run)
        return NAN;
    const struct run_target target = {.t = HUGE_VAL, .steps = typed->steps};
    const int64_t begin = clock_ns();
    while (run_advance(run, &target, 0, NULL)) {
    }
    const double ns = (double)(clock_ns() - begin) / (double)run->steps;
    typed->way =
        method_kernel(typed->method, &run->system, run->settings.drag) ? "kernel" : "general";
    run_destroy(run);
    return ns;
}

struct hand {
    hand_loop *loop;
    struct known known;
    const double *start;
    double *row;
    int n; /* variables */
    int64_t steps;
};

static double run_hand(void *self)
{
    struct hand *hand = self;
    double state[LIMIT_VARIABLES];
    memcpy(state, hand->start, (size_t)hand->n * sizeof *state);
    const int64_t begin = clock_ns();
    hand->loop(&hand->known, 0.01, 0, hand->steps, state, hand->row);
    return (double)(clock_ns() - begin) / (double)hand->steps;
}

#define FORM(name, form) static const char name[] = form
FORM(duffing, "var y = 1;param k = 1;param b = 1;y'' = -k*y - b*y^3");
FORM(drag, "var y = 1;param k = 75;param c = 0.04;y'' = -k*y - c*y'*abs(y')");
FORM(driven, "var y = 1;param k = 75;param gamma = 0.3;param F = 0.1;param omega = 8.2;"
             "y'' = -k*y - gamma*y' + F*cos(omega*t)");
FORM(vanderpol, "var y = 1;param mu = 1;y'' = mu*(1 - y^2)*y' - y");
FORM(pendulum, "var y = 1;param g = 9.81;param l = 1;y'' = -g/l*sin(y)");
FORM(kepler, "var x = 0.5;var y = 0;var y' = 1.7320508075688772;param k = 1;x'' = -k*x/(x^2 + "
             "y^2)^1.5;y'' = -k*y/(x^2 "
             "+ y^2)^1.5");
FORM(stars, "var x = 0;var y = 0.1;var x' = 0.49;var y' = 0;x'' = -x - 2*x*y;y'' = -y - x^2 + y^2");

static void against_hand(double *row)
{
    static const struct {
        const char *method, *scene, *lines;
        double goal;
    } rows[] = {
        {"rk4", "quadratic drag", drag, 1.8}, {"rk4", "driven", driven, 2.3},
        {"rk4", "duffing", duffing, 1.8},     {"rk4", "van der pol", vanderpol, 1.8},
        {"rk4", "kepler", kepler, 1.8},       {"rk4", "pendulum", pendulum, 2.3},
        {"dopri5", "duffing", duffing, 1.8},  {"symplectic-euler", "duffing", duffing, 1.8},
        {"verlet", "duffing", duffing, 1.8},  {"verlet", "kepler", kepler, 1.8},
        {"pefrl", "duffing", duffing, 1.8},   {"symplectic-euler", "driven", driven, 2.3},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        struct typed typed = {
            .method = bench_method(rows[i].method), .settings = {.dt = 0.01}, .steps = STEPS};
        type(&typed, rows[i].lines);
        struct typed general = typed;
        general.settings.kernel = KERNEL_GENERAL;
        const struct hand_scene *scene = hand_scene(rows[i].scene);
        static const double line[] = {1, 0}, plane[] = {0.5, 0, 0, 1.7320508075688772};
        struct hand hand = {hand_find(scene, rows[i].method),
                            scene->known,
                            scene->n == 2 ? line : plane,
                            row,
                            scene->n,
                            STEPS};
        struct arm arm[] = {ARM(run_typed, &typed), ARM(run_hand, &hand), ARM(run_typed, &general)};
        contest(arm, 3);
        char what[64];
        snprintf(what, sizeof what, "%s, %s as typed: %s", rows[i].method, scene->name, typed.way);
        table_row(what, &arm[0], "C loop", &arm[1], rows[i].goal);
        table_row("  kernel = general", &arm[2], "C loop", &arm[1], NAN);
        typed_destroy(typed.models);
    }
}

/* Larger ones: what their kernels gain. */
static void add_ring(struct buffer *lines, const char *format, int n)
{
    for (int i = 0; i < n; i++)
        buffer_format(lines, format, i + 1, (i + 1) % n + 1, (i + n - 1) % n + 1,
                      (i + n - 2) % n + 1);
}

static void against_general(void)
{
    struct buffer lines[3] = {{0}, {0}, {0}};
    buffer_format(&lines[0], "var x1 = 8.01;param F = 8");
    for (int i = 1; i < 40; i++)
        buffer_format(&lines[0], ";var x%d = 8", i + 1);
    add_ring(&lines[0], ";x%1$d' = (x%2$d - x%4$d)*x%3$d - x%1$d + F", 40);
    buffer_format(&lines[1], "var x1 = 1;param k = 1;param mass = 2;param b = 0.1");
    for (int i = 1; i < 20; i++)
        buffer_format(&lines[1], ";var x%d = 0", i + 1);
    add_ring(&lines[1], ";x%1$d'' = k/mass*(x%2$d - 2*x%1$d + x%3$d) - b/mass*x%1$d^3", 20);
    buffer_format(&lines[2], "force -40*y^3");
    static const char *const name[] = {"Lorenz 96, n = 40", "20 masses", "spring with a force"};
    static const char *const method[] = {"rk4", "verlet", "dopri5"};
    for (int i = 0; i < 3; i++)
        for (size_t m = 0; m < COUNT_OF(method); m++) {
            struct typed typed = {
                .method = bench_method(method[m]), .settings = {.dt = 0.01}, .steps = STEPS / 20};
            if (i == 0 && m == 1)
                continue;
            type(&typed, lines[i].data);
            struct typed general = typed;
            general.settings.kernel = KERNEL_GENERAL;
            struct arm arm[] = {ARM(run_typed, &typed), ARM(run_typed, &general)};
            contest(arm, 2);
            char what[64];
            snprintf(what, sizeof what, "%s, %s: %s", method[m], name[i], typed.way);
            table_row(what, &arm[0], "kernel = general", &arm[1], 1);
            typed_destroy(typed.models);
        }
    for (int i = 0; i < 3; i++)
        buffer_free(&lines[i]);
}

/* Rings against the same by hand. */
static void chains(double *row)
{
    static const int size[] = {4, 8, 16, 32};
    for (size_t i = 0; i < COUNT_OF(size); i++) {
        const int n = size[i];
        const struct known known = {.k = 0.5, .b = 0.05};
        double start[LIMIT_VARIABLES] = {1};
        struct buffer lines = {0};
        buffer_format(&lines, "var x1 = 1;param k = 0.5;param b = 0.05");
        for (int j = 1; j < n; j++)
            buffer_format(&lines, ";var x%d = 0", j + 1);
        add_ring(&lines, ";x%1$d'' = k*(x%2$d - 2*x%1$d + x%3$d) - b*x%1$d^3", n);
        struct typed typed = {
            .method = bench_method("rk4"), .settings = {.dt = 0.01}, .steps = STEPS / 20};
        type(&typed, lines.data);
        struct hand hand = {hand_chain(n), known, start, row, 2 * n, STEPS / 20};
        struct arm arm[] = {ARM(run_typed, &typed), ARM(run_hand, &hand)};
        contest(arm, 2);
        char what[64];
        snprintf(what, sizeof what, "rk4, ring of %d as typed: %s", n, typed.way);
        table_row(what, &arm[0], "C loop", &arm[1], 2);
        typed_destroy(typed.models);
        buffer_free(&lines);
    }
}

/* ---- solves with a tolerance ---- */

static double run_solve(void *self)
{
    struct solver *solver = self;
    const int64_t begin = clock_ns();
    int64_t solves = 0;
    do {
        solver_start(solver);
        solver_run(solver, NULL, NULL);
        solves++;
    } while (clock_ns() - begin < 300000);
    return (double)(clock_ns() - begin) * 1e-3 / (double)solves;
}

static void against_built_in(void)
{
    static const struct {
        const char *method, *preset, *lines;
        double tol, span;
    } rows[] = {
        {"dopri5", "vanderpol", "var y = 2;y'' = (1 - y^2)*y' - y", 1e-8, 20},
        {"dopri5", "kepler", kepler, 1e-8, 20},
        {"dop853", "kepler", kepler, 1e-8, 20},
        {"dop853", "henon-heiles", stars, 1e-8, 100},
        {"rodas5p", "vanderpol-1000",
         "var y1 = 2;var y2 = 0;param mu = 1000;y1' = y2;y2' = mu*(1 - y1^2)*y2 - y1", 1e-8, 2000},
        {"rodas5p", "robertson",
         "var A = 1;var B = 0;var C = 0;A' = -0.04*A + 1e4*B*C;B' = 0.04*A - 1e4*B*C - 3e7*B^2;C' "
         "= 3e7*B^2",
         1e-8, 1e8},
        {"radau5", "robertson",
         "var A = 1;var B = 0;var C = 0;A' = -0.04*A + 1e4*B*C;B' = 0.04*A - 1e4*B*C - 3e7*B^2;C' "
         "= 3e7*B^2",
         1e-8, 1e8},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        struct typed typed = {.method = bench_method(rows[i].method)};
        type(&typed, rows[i].lines);
        const bool stiff = strcmp(rows[i].preset, "vanderpol-1000") == 0;
        const struct scene built_in =
            stiff ? bench_scene("vanderpol", "mu", 1000) : bench_scene(rows[i].preset, NULL, 0);
        const struct scene *const scene[] = {&typed.scene, &built_in};
        struct system system[2];
        struct solver solver[2];
        struct arm arm[2];
        for (int k = 0; k < 2; k++) {
            struct error error = {0};
            const struct run_settings settings = {.tol = rows[i].tol};
            if (!scene_bind(scene[k], &system[k], &error) ||
                !solver_init(&solver[k], &system[k], typed.method, &settings, rows[i].span))
                bench_die(rows[i].preset, error.text);
            arm[k] = (struct arm)ARM(run_solve, &solver[k]);
        }
        contest(arm, 2);
        char what[64];
        snprintf(what, sizeof what, "%s, %s, tol 1e-8", rows[i].method, rows[i].preset);
        table_row(what, &arm[0], "built-in", &arm[1], 2);
        solver_free(&solver[0]);
        solver_free(&solver[1]);
        typed_destroy(typed.models);
    }
}

/* ---- from Enter to the first step ---- */

static double run_ready(void *self)
{
    const char *lines = self;
    struct typed typed;
    struct system system;
    struct error error = {0};
    type(&typed, lines);
    if (!scene_bind(&typed.scene, &system, &error))
        bench_die(lines, error.text);
    const double ns = (double)(clock_ns() - typed.entered);
    typed_destroy(typed.models);
    return ns * 1e-3;
}

static void ready(void)
{
    struct buffer chain = {0};
    buffer_format(&chain, "var x1 = 1;param k = 1;param mass = 2");
    for (int i = 1; i < 20; i++)
        buffer_format(&chain, ";var x%d = 0", i + 1);
    add_ring(&chain, ";x%1$d'' = k/mass*(x%2$d - 2*x%1$d + x%3$d)", 20);
    struct arm arm[] = {ARM(run_ready, (void *)(uintptr_t)drag), ARM(run_ready, chain.data)};
    contest(arm, 2);
    table_note(
        "ready to step after the last line's Enter: drag %.0f us (goal 50), 20 masses %.0f us",
        arm[0].minimum, arm[1].minimum);
    buffer_free(&chain);
}

void bench_typed(void)
{
    double *row = calloc(4 * STEPS, sizeof *row);
    if (!row)
        bench_die("rows", "out of memory");
    table_begin("Scenes as typed, recorded", "ns a step");
    against_hand(row);
    against_general();
    chains(row);
    table_begin("Scenes as typed, a solve", "us a solve");
    against_built_in();
    ready();
    free(row);
}
