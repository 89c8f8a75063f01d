/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the benchmarks share: contests between arms, tables of ratios, the hand-written competitors.
 */
#pragma once

#include <hooke/run.h>
#include <hooke/hooke.h>

#include "bench/problem.h"

/* ---- a contest: arms interleaved in random order, so that whatever disturbs the machine meets all
 * alike ---- */

#define ROUNDS 25

struct arm {
    double (*run)(void *self); /* one sample: ns a unit (step, solve, number); NAN: it cannot */
    void *self;
    double minimum, median;
};
#define ARM(function, what)                                                                        \
    {                                                                                              \
        .run = (function), .self = (what)                                                          \
    }

void contest(struct arm *arm, int count);
/* the larger median/minimum - 1 of both */
double arm_spread(const struct arm *a, const struct arm *b);

/* ---- tables: 98 columns ---- */

void table_begin(const char *title, const char *unit); /* unit: of the times */
/* ratio = hooke/other; goal NAN: none. A verdict on times that wander by more than 10 % has a ~. */
void table_row(const char *what, const struct arm *hooke, const char *other_name,
               const struct arm *other, double goal);
void table_absent(const char *other_name, const char *why);
/* A goal that is no ratio of times. */
void table_verdict(bool good, const char *format, ...) __attribute__((format(printf, 2, 3)));
void table_note(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* ---- scenes and methods by name; the benchmark ends where one is missing ---- */

const struct method *bench_method(const char *name);
/* setting NULL: none */
struct scene bench_scene(const char *preset, const char *setting, double value);
struct run *bench_run(const struct scene *scene, const struct method *method,
                      const struct run_settings *settings, double span);
void bench_die(const char *what, const char *why) __attribute__((noreturn));
void memory_cold(void); /* what is free goes back to the system */

/* ---- fixed steps by hand ---- */

/* The presets with their forces, each with a loop for every method that is written out for it. */
struct hand_scene {
    const char *name, *preset;
    int n;
    struct known known;
    struct {
        const char *method; /* NULL: end */
        hand_loop *loop;
    } loop[8];
};
extern const struct hand_scene hand_scenes[]; /* name NULL: end */
const struct hand_scene *hand_scene(const char *name);
hand_loop *hand_find(const struct hand_scene *scene, const char *method);
hand_loop *hand_chain(int n); /* rk4 of 4, 8, 16 or 32 oscillators in a ring */

/* ---- adaptive solves: hooke, by hand, and by libraries ---- */

solve_function hand_dop853_oscillator, hand_dop853_kepler, hand_rodas5p_vanderpol,
    hand_rodas5p_robertson;
solve_function gsl_rk8pd, gsl_msbdf, gsl_bsimp;
/* The problems that are solved at the same achieved error, and their scenes. */
struct problem bench_oscillator(double span, struct scene *scene);
struct problem bench_kepler(int orbits, struct scene *scene);
/* Sets *error to that of hooke's method at tol, and returns the tolerance at which the other solver
 * has it; NAN if it never has. */
double bench_tolerance(const struct problem *problem, const struct scene *scene, const char *method,
                       double tol, solve_function *other, double *error);
/* its rk4, with the scene's terms only */
hand_loop *gsl_loop(const char *method, const char *scene);

/* ---- topics ---- */

void bench_commands(void);
void bench_ranking(void);
void bench_fixed(void);
void bench_linear(void);
void bench_cost(void);
void bench_adaptive(void);
void bench_stiff(void);
void bench_text(void);
void bench_sweep(void);
void bench_forces(void);
void bench_typed(void);
