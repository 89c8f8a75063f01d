/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Speed as ratios, measured in one run: a recorded run of each method against a hand-written loop for exactly that
 * method and scene, compiled with the same flags; what a left-out thing costs; numbers in and out. Nothing here is a
 * test.
 */
#include <hooke/hooke.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEPS 200000
#define ROUNDS 15

struct scene_case {
    const char *name;
    double gamma, C;
};

struct hand {
    const char *method;
    void (*loop)(double k, double gamma, double c, double h, double *y, double *v); /* y, v [STEPS + 1] */
};

static double force(double k, double gamma, double c, double y, double v)
{
    return -k * y - gamma * v - c * fabs(v) * v;
}

static void hand_euler(double k, double gamma, double c, double h, double *y, double *v)
{
    for (int i = 0; i < STEPS; i++) {
        y[i + 1] = y[i] + h * v[i];
        v[i + 1] = v[i] + h * force(k, gamma, c, y[i], v[i]);
    }
}

static void hand_symplectic(double k, double gamma, double c, double h, double *y, double *v)
{
    for (int i = 0; i < STEPS; i++) {
        y[i + 1] = y[i] + h * v[i];
        v[i + 1] = v[i] + h * force(k, gamma, c, y[i + 1], v[i]);
    }
}

static void hand_rk4(double k, double gamma, double c, double h, double *y, double *v)
{
    for (int i = 0; i < STEPS; i++) {
        double y1 = v[i];
        double v1 = force(k, gamma, c, y[i], v[i]);
        double y2 = v[i] + h / 2 * v1;
        double v2 = force(k, gamma, c, y[i] + h / 2 * y1, v[i] + h / 2 * v1);
        double y3 = v[i] + h / 2 * v2;
        double v3 = force(k, gamma, c, y[i] + h / 2 * y2, v[i] + h / 2 * v2);
        double y4 = v[i] + h * v3;
        double v4 = force(k, gamma, c, y[i] + h * y3, v[i] + h * v3);
        y[i + 1] = y[i] + h / 6 * (y1 + 2 * y2 + 2 * y3 + y4);
        v[i + 1] = v[i] + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    }
}

static const struct hand hands[] = {{"euler", hand_euler}, {"symplectic-euler", hand_symplectic}, {"rk4", hand_rk4}};
static const struct scene_case cases[] = {{"spring", 0, 0}, {"linear drag", 0.25, 0}, {"quadratic drag", 0, 1.0}};

static double least(double a, double b)
{
    return a < b ? a : b;
}

/* ns a step of a recorded run. */
static double run_ns(const struct scene *scene, const struct method *method)
{
    struct run_settings settings = {.dt = 0.01};
    struct error error = {0};
    struct run *run = run_create(scene, method, &settings, STEPS * 0.01, &error);
    if (!run) {
        fprintf(stderr, "%s: %s\n", method->row.name, error.text);
        exit(1);
    }
    struct run_target target = {.t = HUGE_VAL, .steps = STEPS};
    int64_t begin = clock_ns();
    while (run_advance(run, &target, 0, NULL)) {
    }
    double ns = (double)(clock_ns() - begin) / (double)run->steps;
    run_destroy(run);
    return ns;
}

static void bench_steps(void)
{
    double *y = calloc(STEPS + 1, sizeof *y);
    double *v = calloc(STEPS + 1, sizeof *v);
    if (!y || !v) {
        exit(1);
    }
    printf("fixed step, recording y and v; minimum of %d rounds, interleaved\n", ROUNDS);
    printf("%-18s %-16s %10s %10s %8s\n", "method", "scene", "hooke ns", "hand ns", "ratio");
    for (size_t m = 0; m < COUNT_OF(hands); m++) {
        const struct method *method = (const void *)catalog_find(&method_catalog, text_of(hands[m].method));
        for (size_t s = 0; s < COUNT_OF(cases); s++) {
            struct scene scene;
            struct error error = {0};
            scene_init(&scene, NULL);
            scene_set(&scene, param_index("gamma"), (struct measured){cases[s].gamma, 0}, &error);
            scene_set(&scene, param_index("C"), (struct measured){cases[s].C, 0}, &error);
            struct system system;
            scene_bind(&scene, &system, &error);
            double mine = HUGE_VAL;
            double hand = HUGE_VAL;
            for (int round = 0; round < ROUNDS; round++) {
                mine = least(mine, run_ns(&scene, method));
                y[0] = system.start[0] + 1e-300 * y[STEPS];
                v[0] = system.start[1];
                int64_t begin = clock_ns();
                hands[m].loop(system.oscillator.stiffness, system.oscillator.damping, system.oscillator.quadratic, 0.01,
                              y, v);
                hand = least(hand, (double)(clock_ns() - begin) / STEPS);
            }
            printf("%-18s %-16s %10.2f %10.2f %8.2f\n", hands[m].method, cases[s].name, mine, hand, mine / hand);
        }
    }
    free(y);
    free(v);
}

/* A term whose coefficient is zero is not in the system: the same time as a scene that never had it. */
static void bench_left_out(void)
{
    struct scene plain;
    struct scene zeroed;
    struct error error = {0};
    scene_init(&plain, NULL);
    scene_init(&zeroed, NULL);
    scene_set(&zeroed, param_index("gamma"), (struct measured){0, 0}, &error);
    scene_set(&zeroed, param_index("F0"), (struct measured){0, 0}, &error);
    scene_set(&zeroed, param_index("g"), (struct measured){0, 0}, &error);
    const struct method *rk4 = (const void *)catalog_find(&method_catalog, TEXT("rk4"));
    double without = HUGE_VAL;
    double with = HUGE_VAL;
    for (int round = 0; round < ROUNDS; round++) {
        without = least(without, run_ns(&plain, rk4));
        with = least(with, run_ns(&zeroed, rk4));
    }
    printf("\nterms with zero coefficients: %.2f ns a step, without them %.2f: ratio %.3f\n", with, without,
           with / without);
}

static void bench_numbers(void)
{
    enum { NUMBERS = 300000 };
    struct buffer text = {0};
    double best_out = HUGE_VAL;
    double best_in = HUGE_VAL;
    volatile double sink = 0;
    for (int round = 0; round < 5; round++) {
        buffer_clear(&text);
        int64_t begin = clock_ns();
        for (int i = 0; i < NUMBERS; i++) {
            buffer_real(&text, i / 3.0);
            buffer_char(&text, '\n');
        }
        best_out = least(best_out, (double)(clock_ns() - begin) / NUMBERS);
        buffer_clear(&text);
        for (int i = 0; i < NUMBERS; i++) {
            buffer_format(&text, "%.3f\n", 20 + i * 1e-3);
        }
        struct text rest = buffer_text(&text);
        begin = clock_ns();
        while (rest.len > 0) {
            double value;
            size_t used;
            if (real_scan(rest, '.', &value, &used) != REAL_OK) {
                exit(1);
            }
            sink = value;
            rest = (struct text){rest.at + used + 1, rest.len - used - 1};
        }
        best_in = least(best_in, (double)(clock_ns() - begin) / NUMBERS);
    }
    (void)sink;
    buffer_free(&text);
    printf("numbers out (17 digits needed): %.1f M/s; numbers in (3 decimals): %.1f M/s\n", 1e3 / best_out,
           1e3 / best_in);
}

int main(void)
{
    bench_steps();
    bench_left_out();
    bench_numbers();
    return 0;
}
