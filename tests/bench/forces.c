/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces that were typed, as programs, in RK4 against the same loop with the force written in C. */
#include "modules/lanes/lanes.h"
#include <hooke/scene/formula.h>

#include "bench/bench.h"

#include <stdlib.h>
#include <string.h>

enum { STEPS = 20000, Y = 0, V = 1, T = 2, NAMES = 6 };

static const double known[NAMES] = {[3] = 75, [4] = 0.3, [5] = 2};
static const bool bound[NAMES] = {[3] = true, [4] = true, [5] = true};
static volatile double sink;

static bool find(const void *context, struct text name, int *slot)
{
    static const char *const names[NAMES] = {"y", "v", "t", "k", "c", "w"};
    (void)context;
    for (*slot = 0; *slot < NAMES; ++*slot)
        if (text_is(name, names[*slot]))
            return true;
    return false;
}

struct typed {
    const char *text;
    struct program *program;
    double *frame, *input; /* in lanes apart */
    double k, c, w;
    bool driven; /* depends on time */
    /* one sample: y + v at the end */
    double (*made)(double y, double v, double t, double h, const struct typed *typed);
};

/* From the text to what can be evaluated: what happens after Enter. */
static struct program *ready(const char *text, bool native)
{
    struct arena arena = {0};
    struct error error = {0};
    size_t used;
    const struct expr_scope scope = {.find = find};
    const struct expr *expr = expr_compile(text_of(text), &scope, &arena, &used, &error);
    struct equations *equations = equations_create(NAMES, &error);
    if (!expr || !equations || !equations_add(equations, expr, &error))
        bench_die(text, error.text);
    struct program *program = program_create(equations, 0, 1, bound, known, native, &error);
    if (!program)
        bench_die(text, error.text);
    equations_destroy(equations);
    arena_reset(&arena);
    return program;
}

static double program_force(const struct typed *typed, double y, double v, double t)
{
    return program_code(typed->program)(typed->program, y, v, t, NULL, NULL, NULL, typed->frame)
        .first;
}

static inline double plain_force(const struct typed *f, double y, double v, double t)
{
    (void)t;
    return -f->k * y - f->c * v * fabs(v);
}

static inline double driven_force(const struct typed *f, double y, double v, double t)
{
    return -f->k * y - f->c * v * fabs(v) + cos(f->w * t);
}

/* A step of RK4 of y'' = force, in named scalars. */
#define LOOP(name, force)                                                                          \
    static double name(double y, double v, double t0, double h, const struct typed *given)         \
    {                                                                                              \
        const struct typed f = *given;                                                             \
        for (int i = 0; i < STEPS; i++) {                                                          \
            const double t = t0 + i * h, v1 = v, a1 = force(&f, y, v1, t);                         \
            const double v2 = v + h / 2 * a1, a2 = force(&f, y + h / 2 * v1, v2, t + h / 2);       \
            const double v3 = v + h / 2 * a2, a3 = force(&f, y + h / 2 * v2, v3, t + h / 2);       \
            const double v4 = v + h * a3, a4 = force(&f, y + h * v3, v4, t + h);                   \
            y += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);                                              \
            v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);                                              \
        }                                                                                          \
        return y + v;                                                                              \
    }

LOOP(plain_loop, plain_force)
LOOP(driven_loop, driven_force)
LOOP(program_loop, program_force)

static double run_steps(void *self)
{
    const struct typed *typed = self;
    const int64_t begin = clock_ns();
    sink = typed->made(1, 0, 0, 1e-3, typed);
    return (double)(clock_ns() - begin) / STEPS;
}

static double run_ready(void *self)
{
    enum { TIMES = 20 };
    const struct typed *typed = self;
    const int64_t begin = clock_ns();
    for (int i = 0; i < TIMES; i++)
        program_destroy(ready(typed->text, true));
    return (double)(clock_ns() - begin) / TIMES;
}

/* ---- many trajectories at once ---- */

/* A step of RK4 for all lanes; the states of the stages are where the program reads them. */
#if defined(__x86_64__) && !defined(__clang__)
__attribute__((target_clones("default", "avx2", "avx512f")))
#endif
static void
lanes_step(const struct typed *f, double *restrict y, double *restrict v, double t, double h)
{
    enum { W = PROGRAM_LANES };
    static const double at[] = {0.5, 0.5, 1}, weight[] = {2, 2, 1};
    double force[W], sum_y[W], sum_v[W], *restrict in = f->input;
    for (int i = 0; i < W; i++) {
        in[Y * W + i] = y[i];
        in[V * W + i] = sum_y[i] = v[i];
        in[T * W + i] = t;
    }
    program_eval_lanes(f->program, sum_v, f->frame);
    memcpy(force, sum_v, sizeof force);
    for (int stage = 0; stage < 3; stage++) {
        const double step = at[stage] * h, fraction = weight[stage];
        for (int i = 0; i < W; i++) {
            in[Y * W + i] = y[i] + step * in[V * W + i];
            in[V * W + i] = v[i] + step * force[i];
            sum_y[i] += fraction * in[V * W + i];
        }
        for (int i = 0; f->driven && i < W; i++)
            in[T * W + i] = t + step;
        program_eval_lanes(f->program, force, f->frame);
        for (int i = 0; i < W; i++)
            sum_v[i] += fraction * force[i];
    }
    for (int i = 0; i < W; i++) {
        y[i] += h / 6 * sum_y[i];
        v[i] += h / 6 * sum_v[i];
    }
}

static double run_lanes(void *self)
{
    enum { TIMES = 500 };
    double y[PROGRAM_LANES], v[PROGRAM_LANES] = {0};
    for (int i = 0; i < PROGRAM_LANES; i++)
        y[i] = 1 + 0.01 * i;
    const int64_t begin = clock_ns();
    for (int step = 0; step < TIMES; step++)
        lanes_step(self, y, v, 1e-3 * step, 1e-3);
    sink = y[0] + v[0];
    return (double)(clock_ns() - begin) / TIMES / PROGRAM_LANES;
}

static void contest_of(const char *text,
                       double (*by_hand)(double, double, double, double, const struct typed *),
                       double goal)
{
    struct typed form[3];
    for (int i = 0; i < 3; i++) {
        form[i] =
            (struct typed){.text = text, .program = ready(text, i == 0), .made = program_loop};
        form[i].driven = program_depends(form[i].program, 0, 1, T);
        const struct program *program = form[i].program;
        const size_t capacity = i == 2 ? program_frame_lanes(program) : program_frame(program);
        form[i].frame = aligned_alloc(64, (capacity + 7) / 8 * 64);
        form[i].input = aligned_alloc(64, (size_t)NAMES * PROGRAM_LANES * sizeof(double));
        if (!form[i].frame || !form[i].input)
            bench_die(text, "out of memory");
        if (i == 2)
            program_prepare_lanes(program, form[i].input, NULL, form[i].frame);
        else
            program_prepare(program, form[i].frame);
    }
    struct typed hand = {.k = known[3], .c = known[4], .w = known[5], .made = by_hand};
    struct arm arm[] = {{.run = run_steps, .self = &form[0]},
                        {.run = run_steps, .self = &form[1]},
                        {.run = run_lanes, .self = &form[2]},
                        {.run = run_steps, .self = &hand},
                        {.run = run_ready, .self = &form[0]}};
    contest(arm, COUNT_OF(arm));
    if (program_native(form[0].program))
        table_row(text, &arm[0], "C by hand", &arm[3], goal);
    else
        table_absent("machine code", "not on this system");
    table_row("  without machine code", &arm[1], "C by hand", &arm[3], NAN);
    table_row("  64 trajectories at once, each", &arm[2], "C by hand, one", &arm[3], NAN);
    table_note("ready %.1f us after Enter (goal 50); 64 at once: %.2f ns a trajectory-step (goal "
               "without cosine 3)",
               1e-3 * arm[4].minimum, arm[2].minimum);
    for (int i = 0; i < 3; i++) {
        program_destroy(form[i].program);
        free(form[i].frame);
        free(form[i].input);
    }
}

void bench_forces(void)
{
    table_begin("Forces as typed, RK4", "ns a step");
    contest_of("-k*y - c*v*abs(v)", plain_loop, 1.8);
    contest_of("-k*y - c*v*abs(v) + cos(w*t)", driven_loop, 2.3);
    bench_typed();
}
