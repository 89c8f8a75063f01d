/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels for scenes of any number of variables, typed ones and built-in ones with typed lines:
 * steps of any explicit Runge-Kutta method and of any splitting, with sums over the state in
 * vectors.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3") /* vectors */
#endif
#define UNROLL _Pragma("GCC unroll 8")
#include <hooke/base/limit.h>
/* Largest number of variables, for march_body.h. */
enum { MOST = LIMIT_VARIABLES };
#include "method/kernel/typed.h"
#include "method/step/step_body.h"

/* Returns n, and tells the compiler that it is at least 1. */
static inline int system_variables(const struct system *system)
{
    if (system->n < 1)
        __builtin_unreachable();
    return system->n;
}

/* Forces of a scene, prepared once per march and not at each evaluation. */
struct whole {
    const struct system *system;
    /* number of variables whose slopes are other variables; -1 if forces are not one program */
    int positions;
    bool force; /* one program has all forces that do not depend on velocity */
    struct typed_forces known;
};

/* Prepares the forces of the system. */
static void prepare_forces(struct whole *whole, const struct system *system)
{
    const int n = system->n, rows = system->order == 2 ? n / 2 : n;
    whole->system = system;
    const bool taken = n > 2 && known_take(&whole->known, system);
    whole->positions = taken && sum_is_one(&whole->known.whole) ? n - rows : -1;
    whole->force = taken && sum_is_one(&whole->known.force);
}

/* Computes dydt [n], for a slope_function; context is a struct whole. */
static void prepared_slope(const void *context, double t, const double *y, double *dydt)
{
    const struct whole *whole = context;
    const int n = whole->system->n, positions = whole->positions;
    if (positions < 0) {
        system_derivative(whole->system, t, y, dydt);
        return;
    }
    memcpy(dydt, y + n - positions, (size_t)positions * sizeof *y);
    one_evaluate(&whole->known.whole, n, n - positions, t, y, dydt + positions);
}

/* Computes the forces that do not depend on velocity, for a force_function. */
static void prepared_force(const void *context, double t, const double *y, double *a)
{
    const struct whole *whole = context;
    const int n = whole->system->n;
    if (whole->force)
        one_evaluate(&whole->known.force, n, n / 2, t, y, a);
    else
        system_force(whole->system, t, y, a);
}

/* Computes the forces that depend on velocity, for a force_function. */
static void prepared_drag(const void *context, double t, const double *y, double *a)
{
    const struct whole *whole = context;
    system_drag(whole->system, t, y, a);
}

/* ---- sums over the state ---- */

/* Number of variables that are summed up together in registers; arrays are padded to whole
 * blocks. */
enum { BLOCK = 8 };

static int stride_of(int n)
{
    return (n + BLOCK - 1) / BLOCK * BLOCK;
}

/*
 * Defines a combine_function in vectors of `width` numbers. Each width has its own function, since
 * a type that is wider than the registers of the machine would live in memory.
 */
#define COMBINE(name, width, target)                                                               \
    typedef double name##_vector __attribute__((vector_size(8 * (width)), aligned(8), may_alias)); \
    target static void name(int n, int stride, const struct weights *weights, const double *k,     \
                            const double *y, double *z)                                            \
    {                                                                                              \
        const int count = weights->count;                                                          \
        for (int i = 0; i < n; i += BLOCK) {                                                       \
            name##_vector sum[BLOCK / (width)];                                                    \
            UNROLL for (int b = 0; b < BLOCK / (width); b++) sum[b] = -(name##_vector){0};         \
            for (int j = 0; j < count; j++) {                                                      \
                const double weight = weights->weight[j];                                          \
                const name##_vector *slope =                                                       \
                    (const name##_vector *)(const void *)(k + weights->stage[j] * stride + i);     \
                UNROLL for (int b = 0; b < BLOCK / (width); b++) sum[b] += weight * slope[b];      \
            }                                                                                      \
            const name##_vector *source = (const name##_vector *)(const void *)(y + i);            \
            name##_vector *result = (name##_vector *)(void *)(z + i);                              \
            UNROLL for (int b = 0; b < BLOCK / (width); b++) result[b] = source[b] + sum[b];       \
        }                                                                                          \
    }
COMBINE(combine_pairs, 2, )
#if defined(__x86_64__)
COMBINE(combine_fours, 4, __attribute__((target("avx2"))))
#endif

/* Returns the combine_function with the widest vectors that the processor has. */
static combine_function *combine_blocks(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        return combine_fours;
#endif
    return combine_pairs;
}

/* March of an explicit Runge-Kutta method. */
static int64_t any_rk(const struct method *method, const struct march *march)
{
    const struct system *system = march->step->system;
    struct whole whole;
    prepare_forces(&whole, system);
    return picked_march(method, system_variables(system), stride_of(system->n), combine_blocks(),
                        prepared_slope, &whole, march);
}

/* Single step of an explicit Runge-Kutta method. */
static enum step_status any_step(const struct method *method, struct step *step)
{
    const struct system *system = step->system;
    return picked_step(method, system_variables(system), stride_of(system->n), combine_blocks(),
                       step_slope, system, step);
}

/* March of a splitting. */
static int64_t any_split(const struct method *method, const struct march *march)
{
    const struct system *system = march->step->system;
    const enum drag drag = system->velocity ? march->step->drag : DRAG_DEFAULT;
    struct whole whole;
    prepare_forces(&whole, system);
    return split_march(method, system->n, drag, prepared_force, prepared_drag, &whole, march);
}

march_function *any_kernel(const struct method *method)
{
    if (method->splitting)
        return any_split;
    return method->step == rk_step ? any_rk : NULL;
}

step_function *any_step_kernel(const struct method *method)
{
    return method->step == rk_step ? any_step : NULL;
}
