/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Seven methods on six scenes, by hooke's kernels and by loops as one would write them: each in a
 * function of its own, so that ranking.sh can read off what it costs.
 */
#include "modules/solving/compute/solve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 10000, N = 2 };
#define H 0.01
#define INLINE static inline __attribute__((always_inline))
#define APART static __attribute__((noinline))

#define METHODS(M, scene)                                                                          \
    M(scene, euler)                                                                                \
    M(scene, midpoint)                                                                             \
    M(scene, rk4)                                                                                  \
    M(scene, symplectic_euler)                                                                     \
    M(scene, verlet)                                                                               \
    M(scene, position_verlet)                                                                      \
    M(scene, implicit_midpoint)
#define SCENES(S) S(spring) S(damped) S(drag) S(duffing) S(driven) S(vanderpol)

/* ---- loops by hand ---- */

struct known {
    double k, gamma, c, b, mu, narrow, drive, omega, phase;
};

#define SCENE(scene, at_rest, moving, by_position, by_velocity)                                    \
    INLINE double scene##_rest(const struct known *f, double t, double y)                          \
    {                                                                                              \
        (void)f, (void)t, (void)y;                                                                 \
        return at_rest;                                                                            \
    }                                                                                              \
    INLINE double scene##_moving(const struct known *f, double y, double v)                        \
    {                                                                                              \
        (void)f, (void)y, (void)v;                                                                 \
        return moving;                                                                             \
    }                                                                                              \
    INLINE double scene##_slope(const struct known *f, double g, double y, double v)               \
    {                                                                                              \
        (void)f, (void)y, (void)v;                                                                 \
        return g * (by_position) + (by_velocity);                                                  \
    }
SCENE(spring, -f->k *y, 0, -f->k, 0)
SCENE(damped, -f->k *y, -f->gamma *v, -f->k, -f->gamma)
SCENE(drag, -f->k *y, -f->c *fabs(v) * v, -f->k, -2 * f->c * fabs(v))
SCENE(duffing, -f->k *y - f->b * y * y * y, 0, -f->k - 3 * f->b * y * y, 0)
SCENE(driven, -f->k *y + f->drive * cos(f->omega * t + f->phase), -f->gamma *v, -f->k, -f->gamma)
SCENE(vanderpol, -f->k *y, f->mu *(1 - y * f->narrow * (y * f->narrow)) * v,
      -f->k - 2 * f->mu * f->narrow * f->narrow * y * v,
      f->mu *(1 - y * f->narrow * (y * f->narrow)))

typedef double rest_force(const struct known *f, double t, double y);
typedef double moving_force(const struct known *f, double y, double v);
typedef double force_slope(const struct known *f, double g, double y, double v);

/* How splittings take it: by its own flow over h/2, or (OTHER) at the old velocity. */
enum drag_kind { NONE, LINEAR, QUADRATIC, OTHER };
static const enum drag_kind drag_of_spring = NONE, drag_of_damped = LINEAR,
                            drag_of_drag = QUADRATIC, drag_of_duffing = NONE,
                            drag_of_driven = LINEAR, drag_of_vanderpol = OTHER;

INLINE double half_flow(const struct known *f, enum drag_kind drag, double keep, double v)
{
    return drag == LINEAR ? keep * v : drag == QUADRATIC ? v / (1 + f->c * H / 2 * fabs(v)) : v;
}

#define ARGUMENTS                                                                                  \
    const struct known *given, enum drag_kind drag, rest_force *rest, moving_force *moving,        \
        force_slope *slope, double *state, double *row
#define BEGIN                                                                                      \
    const struct known known = *given, *const f = &known;                                          \
    double y = state[0], v = state[1];                                                             \
    const double keep = exp(-f->gamma * H / 2);                                                    \
    (void)keep, (void)drag, (void)slope, (void)moving;                                             \
    for (int i = 0; i < STEPS; i++, row += N) {                                                    \
        const double t = i * H;
#define END                                                                                        \
    row[0] = y;                                                                                    \
    row[1] = v;                                                                                    \
    }                                                                                              \
    state[0] = y;                                                                                  \
    state[1] = v;
#define FORCE(t, y, v) (rest(f, t, y) + moving(f, y, v))

INLINE void loop_euler(ARGUMENTS)
{
    BEGIN
    const double a = FORCE(t, y, v);
    y += H * v;
    v += H * a;
    END
}

INLINE void loop_midpoint(ARGUMENTS)
{
    BEGIN
    const double ym = y + H / 2 * v, vm = v + H / 2 * FORCE(t, y, v);
    y += H * vm;
    v += H * FORCE(t + H / 2, ym, vm);
    END
}

INLINE void loop_rk4(ARGUMENTS)
{
    BEGIN
    const double y1 = v, v1 = FORCE(t, y, v);
    const double y2 = v + H / 2 * v1, v2 = FORCE(t + H / 2, y + H / 2 * y1, y2);
    const double y3 = v + H / 2 * v2, v3 = FORCE(t + H / 2, y + H / 2 * y2, y3);
    const double y4 = v + H * v3, v4 = FORCE(t + H, y + H * y3, y4);
    y += H / 6 * (y1 + 2 * y2 + 2 * y3 + y4);
    v += H / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    END
}

INLINE void loop_symplectic_euler(ARGUMENTS)
{
    BEGIN
    y += H * v;
    v += H * FORCE(t + H, y, v);
    END
}

INLINE void loop_verlet(ARGUMENTS)
{
    double a = rest(given, 0, state[0]);
    BEGIN
    if (drag == OTHER) {
        v += H / 2 * (a + moving(f, y, v));
        y += H * v;
        a = rest(f, t + H, y);
        v += H / 2 * (a + moving(f, y, v));
    } else {
        v = half_flow(f, drag, keep, v) + H / 2 * a;
        y += H * v;
        a = rest(f, t + H, y);
        v = half_flow(f, drag, keep, v + H / 2 * a);
    }
    END
}

INLINE void loop_position_verlet(ARGUMENTS)
{
    BEGIN
    v = half_flow(f, drag, keep, v);
    y += H / 2 * v;
    v += H * (drag == OTHER ? FORCE(t + H / 2, y, v) : rest(f, t + H / 2, y));
    y += H / 2 * v;
    v = half_flow(f, drag, keep, v);
    END
}

/* Linear forces with quadratic drag in closed form, others by Newton's iteration on the velocity in
 * the middle. */
INLINE void loop_implicit_midpoint(ARGUMENTS)
{
    BEGIN
    const double g = H / 2;
    double u = v;
    if (f->b == 0 && f->mu == 0) {
        u = (v + g * rest(f, t + g, y)) / (1 + f->gamma * g + f->k * g * g);
        if (drag == QUADRATIC)
            u = 2 * u / (1 + sqrt(1 + 4 * f->c * g / (1 + f->k * g * g) * fabs(u)));
    } else {
        for (int turn = 0; turn < 30; turn++) {
            const double wrong = u - v - g * FORCE(t + g, y + g * u, u);
            const double move = wrong / (1 - g * slope(f, g, y + g * u, u));
            u -= move;
            if (fabs(move) <= 1e-16 * (1 + fabs(u)))
                break;
        }
    }
    y += H * u;
    v = 2 * u - v;
    END
}

#define LOOP(scene, method)                                                                        \
    APART void loop_##scene##_##method(const struct known *f, double *state, double *row)          \
    {                                                                                              \
        loop_##method(f, drag_of_##scene, scene##_rest, scene##_moving, scene##_slope, state,      \
                      row);                                                                        \
    }
#define LOOPS(scene) METHODS(LOOP, scene)
SCENES(LOOPS)

/* ---- the same by hooke ---- */

struct work {
    const struct method *method;
    march_function *kernel;
    struct march march;
};

#define KERNEL(scene, by)                                                                          \
    APART int64_t kernel_##scene##_##by(const struct work *work, enum step_status *status)         \
    {                                                                                              \
        return method_turning_march(work->method, work->kernel, &work->march, status);             \
    }
#define KERNELS(scene) METHODS(KERNEL, scene)
SCENES(KERNELS)

typedef void loop_function(const struct known *f, double *state, double *row);
typedef int64_t kernel_function(const struct work *work, enum step_status *status);

static const struct {
    const char *scene, *method;
    loop_function *loop;
    kernel_function *kernel;
} cases[] = {
#define CASE(scene, by) {#scene, #by, loop_##scene##_##by, kernel_##scene##_##by},
#define CASES(scene) METHODS(CASE, scene)
    SCENES(CASES)};

static void fail(const char *scene, const char *method, const char *what)
{
    fprintf(stderr, "%s, %s: %s\n", scene, method, what);
    exit(1);
}

int main(void)
{
    static double by_loop[STEPS * N], by_kernel[STEPS * N];
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const char *scene_name = cases[i].scene;
        char name[32];
        snprintf(name, sizeof name, "%s", cases[i].method);
        for (char *p = name; *p; p++)
            *p = *p == '_' ? '-' : *p;
        struct scene scene;
        struct system system;
        struct error error = {0};
        const struct method *method = method_by_name(text_of(name));
        scene_init(&scene, preset_by_name(text_of(scene_name)));
        enum drag drag = DRAG_DEFAULT;
        if (!method || !scene_bind(&scene, &system, &error))
            fail(scene_name, name, "unknown");
        if (!method_applies(method, &system, &drag, &error))
            drag = DRAG_EXPLICIT;
        double work[64], state[N] = {system.start[0], system.start[1]},
                         start[N] = {state[0], state[1]};
        struct step step = {.system = &system, .drag = drag, .h = H, .y = state, .work = work};
        const struct work own = {
            method, method_kernel(method, &system, drag), {&step, 0, 0, STEPS, by_kernel}};
        const struct oscillator *o = &system.oscillator;
        const struct known known = {
            .k = o->stiffness,
            .gamma = o->damping,
            .c = o->quadratic,
            .b = strcmp(scene_name, "duffing") == 0 ? system.term[1].c[0] : 0,
            .mu = strcmp(scene_name, "vanderpol") == 0 ? system.term[1].c[0] : 0,
            .narrow = strcmp(scene_name, "vanderpol") == 0 ? system.term[1].c[1] : 0,
            .drive = o->drive,
            .omega = o->omega,
            .phase = o->phase};
        enum step_status status;
        if (!own.kernel)
            fail(scene_name, name, "no kernel");
        if (method_work_size(method, N) > COUNT_OF(work) || cases[i].kernel(&own, &status) != STEPS)
            fail(scene_name, name, "did not arrive");
        cases[i].loop(&known, start, by_loop);
        /* Is it the same method? Turning points are approached in another way, hence not to
         * rounding. */
        const double *a = by_loop + 100 * N, *b = by_kernel + 100 * N;
        if (fabs(a[0] - b[0]) > 1e-6 * system.scale[0] ||
            fabs(a[1] - b[1]) > 1e-6 * system.scale[1])
            fail(scene_name, name, "the loop is another method");
    }
    return 0;
}
