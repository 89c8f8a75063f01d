/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels of implicit Runge-Kutta methods whose stages are solved one by one: irk_body.h compiled
 * for each row and the shapes of two variables. Linear forces with quadratic drag are solved in
 * closed form, the others by Newton's iteration with matrices of known size.
 */
#define UNROLL
#include "method/kernel/kernel.h"

#include "method/step/irk_body.h"
#include "method/step/newton_body.h"

/* [double] newton_capacity() for one stage of N variables. */
enum { WORK_SIZE = 2 + (3 + N) * N + 3 * N * (N + 1) };

/* ---- stages ---- */

/* Data of the stage functions: a system with its forces prepared. */
struct shape_known {
    struct shape_forces forces;
    struct oscillator oscillator;
    const struct system *system;
};

#define KNOWN_SLOPE(shape)                                                                         \
    INLINE void shape##_known_slope(const void *known, double t, const double *y, double *dydt)    \
    {                                                                                              \
        shape##_slope(&((const struct shape_known *)known)->forces, t, y, dydt);                   \
    }
CLOSED_SHAPES(KNOWN_SLOPE)
MOTION_SHAPES(KNOWN_SLOPE)

#define HAS_KINK(i, name) | (name##_flags & TERM_KINK)
/* Defines the stage_function of a shape that is solved in closed form. */
#define CLOSED_STAGE(shape)                                                                        \
    INLINE enum step_status shape##_stage(const void *known, struct step *step, double t,          \
                                          double h, const double *y, double *z, double *sum,       \
                                          double *work)                                            \
    {                                                                                              \
        const struct shape_known *constants = known;                                               \
        double force;                                                                              \
        (void)work;                                                                                \
        shape##_force(&constants->forces, t, y, &force);                                           \
        return oscillator_stage(&constants->oscillator, (0 TERMS_OF_##shape(HAS_KINK)) != 0,       \
                                force, step, h, y, z, sum);                                        \
    }
CLOSED_SHAPES(CLOSED_STAGE)

#define drive_slopes(c, t, y, jac) ((void)0)
#define TERM_SLOPES(i, name) name##_jacobian(constants->forces.c[i], t, y, jac + N);
/* Defines Jacobian and stage_function of a shape that is solved by iteration. */
#define NEWTON_STAGE(shape)                                                                        \
    INLINE void shape##_known_jacobian(const void *known, double t, const double *y, double *jac)  \
    {                                                                                              \
        const struct shape_known *constants = known;                                               \
        jac[0] = jac[2] = jac[3] = 0;                                                              \
        jac[1] = 1;                                                                                \
        TERMS_OF_##shape(TERM_SLOPES)                                                              \
    }                                                                                              \
    INLINE enum step_status shape##_stage(const void *known, struct step *step, double t,          \
                                          double h, const double *y, double *z, double *sum,       \
                                          double *work)                                            \
    {                                                                                              \
        return motion_stage(shape##_known_slope, shape##_known_jacobian, known, step, t, h, y, z,  \
                            sum, work);                                                            \
    }
MOTION_SHAPES(NEWTON_STAGE)

/* ---- steps ---- */

/* Sets y [2] to the new state: sum if the method is stiffly accurate (`accurate`, its last stage is
 * the new state), else y + z. Returns false with y unchanged if the result is not finite. */
INLINE bool state_update(bool accurate, const double *z, const double *sum, double *y)
{
    double next[N];
    for (int i = 0; i < N; i++)
        next[i] = accurate ? sum[i] : y[i] + z[i];
    if (!isfinite(next[0]) || !isfinite(next[1]))
        return false;
    copy_numbers(N, next, y);
    return true;
}

/* Takes the steps of a march until one has no solution. Returns the number of steps taken; state
 * and cost are those after the last of them. */
INLINE int64_t diagonal_march(const struct method *method, stage_function *stage,
                              slope_function *slope, const struct shape_known *known,
                              const struct march *march)
{
    const struct implicit_tableau *tableau = method->implicit;
    const int stages = tableau->stages;
    const bool accurate = stiffly_accurate(tableau);
    struct step *const step = march->step;
    double k[IMPLICIT_STAGES * N] = {0}, y[N], z[N] = {0}, sum[N] = {0}, base[N], work[WORK_SIZE],
                               last[N] = {0};
    double *const reused = step->work + (stages - 1) * N, *const newest = k + (stages - 1) * N;
    struct step own = {.system = step->system, .h = step->h, .y = y};
    struct cost cost = {0};
    bool warm = step->warm;
    copy_numbers(N, step->y, y);
    if (tableau->fsal && warm)
        copy_numbers(N, reused, newest);
    int64_t i = 0;
    for (double *row = march->row; i < march->count; i++, row += N) {
        own.cost = (struct cost){0};
        if (tableau->fsal)
            copy_numbers(N, newest, last);
        own.t = march->origin + (double)(march->first + i) * own.h;
        bool good = diagonal_stages(tableau, N, stage, slope, known, &own, warm, k, z, sum, base,
                                    work) == STEP_OK;
        if (good && !accurate)
            diagonal_increment(tableau, N, own.h, k, z);
        if (!good || !state_update(accurate, z, sum, y)) {
            copy_numbers(N, last, newest);
            break;
        }
        warm = true;
        cost.evals += own.cost.evals;
        cost.jacobians += own.cost.jacobians;
        cost.solves += own.cost.solves;
        copy_numbers(N, y, row);
    }
    if (tableau->fsal)
        copy_numbers(N, newest, reused);
    newton_forget(step->work + (stages + 3) * N);
    copy_numbers(N, y, step->y);
    step->warm = warm;
    step->cost.evals += cost.evals;
    step->cost.jacobians += cost.jacobians;
    step->cost.solves += cost.solves;
    return i;
}

/* ---- the table ---- */

/* Kernel for any row, whose weights are read from memory: solving a stage takes longer than that.
 */
#define ANY_KERNEL(shape)                                                                          \
    static int64_t shape##_irk(const struct method *method, const struct march *march)             \
    {                                                                                              \
        const struct system *system = march->step->system;                                         \
        struct shape_known known = {.oscillator = system->oscillator, .system = system};           \
        forces_take(&known.forces, system, SHAPE_TERMS);                                           \
        return diagonal_march(method, shape##_stage, shape##_known_slope, &known, march);          \
    }
CLOSED_SHAPES(ANY_KERNEL)
MOTION_SHAPES(ANY_KERNEL)

/* Kernels with constant weights, for METHOD_UNROLLED rows. */
#define IRK_ROW JOIN(irk_, __LINE__)
#define IRK_NAME(shape) JOIN(shape##_irk_, __LINE__)
#define IRK_KERNEL(shape)                                                                          \
    static int64_t IRK_NAME(shape)(const struct method *method, const struct march *march)         \
    {                                                                                              \
        const struct system *system = march->step->system;                                         \
        struct shape_known known = {.oscillator = system->oscillator, .system = system};           \
        if (!(IRK_ROW.flags & METHOD_UNROLLED))                                                    \
            return shape##_irk(method, march);                                                     \
        forces_take(&known.forces, system, SHAPE_TERMS);                                           \
        return diagonal_march(&IRK_ROW, shape##_stage, shape##_known_slope, &known, march);        \
    }
#define IMPLICIT_RUNGE_KUTTA(id, ...)                                                              \
    static const struct method IRK_ROW = {__VA_ARGS__};                                            \
    CLOSED_SHAPES(IRK_KERNEL)
#include "method/rows/irk.def"
#undef IMPLICIT_RUNGE_KUTTA

#define ANY_ENTRY(shape) [SHAPE_##shape] = shape##_irk,
#define IRK_ENTRY(shape) [SHAPE_##shape] = IRK_NAME(shape),

/* Returns the kernel for method and shape, with constant weights if there is one, or NULL. */
march_function *implicit_kernel(const struct method *method, const struct system *system)
{
    static march_function *const any[SHAPE_COUNT] = {CLOSED_SHAPES(ANY_ENTRY)
                                                         MOTION_SHAPES(ANY_ENTRY)};
    static march_function *const unrolled[][SHAPE_COUNT] = {
        {NULL},
#define IMPLICIT_RUNGE_KUTTA(...) {CLOSED_SHAPES(IRK_ENTRY)},
#include "method/rows/irk.def"
    };
    const int shape = shape_of(system);
    if (shape < 0 || !method->implicit || method->implicit->diagonal == 0)
        return NULL;
    march_function *const own = unrolled[method->index][shape];
    return method->flags & METHOD_UNROLLED && own ? own : any[shape];
}
