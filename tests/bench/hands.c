/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The loops that hooke is measured against: one for each method and scene, compiled with hooke's
 * own flags. */
#include "bench/bench.h"

#include <string.h>

#define INLINE static inline __attribute__((always_inline))

typedef double plane __attribute__((vector_size(16)));

/* ---- forces ---- */

#define FORCE(scene, value)                                                                        \
    INLINE double scene##_force(const struct known *f, double t, double y, double v)               \
    {                                                                                              \
        (void)f, (void)t, (void)v;                                                                 \
        return value;                                                                              \
    }
FORCE(spring, -f->k *y)
FORCE(damped, -f->k *y - f->gamma * v)
FORCE(drag, -f->k *y - f->c * fabs(v) * v)
FORCE(duffing, -f->k *y - f->b * y * y * y)
FORCE(driven, -f->k *y - f->gamma * v + f->drive * cos(f->omega * t + f->phase))
FORCE(vanderpol, -f->k *y + f->mu * (1 - y * f->narrow * (y * f->narrow)) * v)
FORCE(pendulum, -f->k *sin(y))
/* Splittings have the drag in their flow. */
FORCE(still, -f->k *y)
FORCE(swung, -f->k *y + f->drive * cos(f->omega * t + f->phase))

INLINE plane kepler_force(const struct known *f, double t, plane y, plane v)
{
    (void)t, (void)v;
    const double square = y[0] * y[0] + y[1] * y[1];
    return -f->k / (square * sqrt(square)) * y;
}

/* ---- drag's own flow ---- */

INLINE double no_flow(const struct known *f, double h, double v)
{
    (void)f, (void)h;
    return v;
}

INLINE double linear_flow(const struct known *f, double h, double v)
{
    (void)h;
    return v * f->fade;
}

INLINE double quadratic_flow(const struct known *f, double h, double v)
{
    return v / (1 + f->c * h * fabs(v));
}

INLINE plane free_flow(const struct known *f, double h, plane v)
{
    (void)f, (void)h;
    return v;
}

#define REAL double
#include "bench/hand_methods.h"
#undef REAL
#undef LOOP_BEGIN
#undef LOOP_END
#undef STEP_END
#undef ARGUMENTS
#define REAL plane
#include "bench/hand_methods.h"
#undef REAL

/* ---- implicit midpoint: the velocity u in the middle solves u = v + h/2 a(t + h/2, y + h/2 u, u)
 * ---- */

typedef double middle_function(const struct known *f, double t, double h, double y, double v);

INLINE void implicit_midpoint(middle_function *middle, const struct known *given, double h,
                              int64_t first, int64_t count, double *state, double *row)
{
    const struct known known = *given;
    double y = state[0], v = state[1];
    for (int64_t i = 0; i < count; i++) {
        const double u = middle(&known, ((double)(first + i) + 0.5) * h, h / 2, y, v);
        y += h * u;
        v = 2 * u - v;
        *row++ = y;
        *row++ = v;
    }
    state[0] = y;
    state[1] = v;
}

#define CLOSED(scene, value)                                                                       \
    INLINE double scene##_middle(const struct known *f, double t, double h, double y, double v)    \
    {                                                                                              \
        (void)t;                                                                                   \
        return value;                                                                              \
    }
INLINE double root(double a, double c, double r)
{
    return 2 * r / (a + sqrt(a * a + 4 * c * fabs(r)));
}
CLOSED(spring, (v - h * f->k * y) / (1 + h * h * f->k))
CLOSED(damped, (v - h * f->k * y) / (1 + h * f->gamma + h * h * f->k))
CLOSED(drag, root(1 + h * h * f->k, h * f->c, v - h * f->k * y))
CLOSED(driven, (v - h * (f->k * y - f->drive * cos(f->omega * t + f->phase))) /
                   (1 + h * f->gamma + h * h * f->k))

/* Newton's iteration; slope: da/dq h + da/dv */
#define NEWTON(scene, slope)                                                                       \
    INLINE double scene##_middle(const struct known *f, double t, double h, double y, double v)    \
    {                                                                                              \
        double u = v;                                                                              \
        for (int turn = 0; turn < 10; turn++) {                                                    \
            const double q = y + h * u;                                                            \
            const double move = (u - v - h * scene##_force(f, t, q, u)) / (1 - h * (slope));       \
            u -= move;                                                                             \
            if (fabs(move) <= 1e-15 * (1 + fabs(u)))                                               \
                break;                                                                             \
        }                                                                                          \
        return u;                                                                                  \
    }
NEWTON(duffing, h *(-f->k - 3 * f->b * q * q))
NEWTON(vanderpol, h *(-f->k - 2 * f->mu * f->narrow * f->narrow * q * u) +
                      f->mu * (1 - q * f->narrow * (q * f->narrow)))
NEWTON(pendulum, h * -f->k * cos(q))

/* ---- the loops ---- */

#define LOOP(scene, method, real, force, flow, damped)                                             \
    static void scene##_##method(const struct known *f, double h, int64_t first, int64_t count,    \
                                 double *state, double *row)                                       \
    {                                                                                              \
        method##_##real(force, flow, damped, f, h, first, count, state, row);                      \
    }
#define MIDPOINT(scene)                                                                            \
    static void scene##_implicit_midpoint(const struct known *f, double h, int64_t first,          \
                                          int64_t count, double *state, double *row)               \
    {                                                                                              \
        implicit_midpoint(scene##_middle, f, h, first, count, state, row);                         \
    }
#define EXPLICIT(scene, real, flow)                                                                \
    LOOP(scene, euler, real, scene##_force, flow, false)                                           \
    LOOP(scene, symplectic_euler, real, scene##_force, flow, false)                                \
    LOOP(scene, rk4, real, scene##_force, flow, false)                                             \
    LOOP(scene, dopri5, real, scene##_force, flow, false)

#define FREE(scene, real, flow)                                                                    \
    EXPLICIT(scene, real, flow)                                                                    \
    LOOP(scene, verlet, real, scene##_force, flow, false)                                          \
    LOOP(scene, pefrl, real, scene##_force, flow, false)
FREE(spring, double, no_flow)
FREE(duffing, double, no_flow)
FREE(pendulum, double, no_flow)
FREE(kepler, plane, free_flow)
EXPLICIT(damped, double, linear_flow)
LOOP(damped, verlet, double, still_force, linear_flow, true)
LOOP(damped, pefrl, double, still_force, linear_flow, true)
EXPLICIT(driven, double, linear_flow)
LOOP(driven, verlet, double, swung_force, linear_flow, true)
LOOP(driven, pefrl, double, swung_force, linear_flow, true)
EXPLICIT(drag, double, quadratic_flow)
LOOP(drag, verlet, double, still_force, quadratic_flow, true)
EXPLICIT(vanderpol, double, no_flow)
MIDPOINT(spring)
MIDPOINT(damped)
MIDPOINT(drag)
MIDPOINT(driven)
MIDPOINT(duffing)
MIDPOINT(vanderpol)
MIDPOINT(pendulum)

#define ALWAYS(scene)                                                                              \
    {"euler", scene##_euler}, {"symplectic-euler", scene##_symplectic_euler},                      \
        {"rk4", scene##_rk4},                                                                      \
    {                                                                                              \
        "dopri5", scene##_dopri5                                                                   \
    }

/* clang-format off */
const struct hand_scene hand_scenes[] = {
    {"spring", "spring", 2, {.k = 75},
     {ALWAYS(spring), {"verlet", spring_verlet}, {"pefrl", spring_pefrl},
      {"implicit-midpoint", spring_implicit_midpoint}}},
    {"linear drag", "damped", 2, {.k = 75, .gamma = 0.25},
     {ALWAYS(damped), {"verlet", damped_verlet}, {"pefrl", damped_pefrl},
      {"implicit-midpoint", damped_implicit_midpoint}}},
    {"quadratic drag", "drag", 2, {.k = 75, .c = 0.585 * 1.204 * 1.131e-2 / 0.2},
     {ALWAYS(drag), {"verlet", drag_verlet}, {"implicit-midpoint", drag_implicit_midpoint}}},
    {"duffing", "duffing", 2, {.k = 1, .b = 1},
     {ALWAYS(duffing), {"verlet", duffing_verlet}, {"pefrl", duffing_pefrl},
      {"implicit-midpoint", duffing_implicit_midpoint}}},
    {"driven", "driven", 2, {.k = 75, .gamma = 0.3, .drive = 0.1, .omega = 8.2},
     {ALWAYS(driven), {"verlet", driven_verlet}, {"pefrl", driven_pefrl},
      {"implicit-midpoint", driven_implicit_midpoint}}},
    {"van der pol", "vanderpol", 2, {.k = 1, .mu = 1, .narrow = 1},
     {ALWAYS(vanderpol), {"implicit-midpoint", vanderpol_implicit_midpoint}}},
    {"pendulum", "pendulum", 2, {.k = 9.81},
     {ALWAYS(pendulum), {"verlet", pendulum_verlet}, {"pefrl", pendulum_pefrl},
      {"implicit-midpoint", pendulum_implicit_midpoint}}},
    {"kepler", "kepler", 4, {.k = 1},
     {ALWAYS(kepler), {"verlet", kepler_verlet}, {"pefrl", kepler_pefrl}}},
    {.name = NULL},
};
/* clang-format on */

const struct hand_scene *hand_scene(const char *name)
{
    for (const struct hand_scene *scene = hand_scenes; scene->name; scene++)
        if (strcmp(scene->name, name) == 0)
            return scene;
    bench_die(name, "no such scene by hand");
}

hand_loop *hand_find(const struct hand_scene *scene, const char *method)
{
    for (int i = 0; i < (int)COUNT_OF(scene->loop) && scene->loop[i].method; i++)
        if (strcmp(scene->loop[i].method, method) == 0)
            return scene->loop[i].loop;
    return NULL;
}
