/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Accepted steps of the Runge-Kutta methods that people solve with, their control in the same
 * function: method_adapt() again for each row and shape, so that nothing on the way from the stages
 * to the next step goes through memory.
 */
#if defined(__GNUC__) && !defined(__clang__)
/* Numbers that were stored one by one wait long where they are read in pairs. */
#pragma GCC optimize("no-tree-vectorize", "no-tree-loop-distribute-patterns")
#endif
#define UNROLL _Pragma("GCC unroll 32")
#include "method/kernel/kernel.h"
#include "method/control/adapt_body.h"
#include "method/control/rk_error.h"

/* ---- the attempts ---- */

/* Two coordinates: rk_body.h in pairs of numbers, of positions and of velocities; half the
 * instructions. */
typedef double pair __attribute__((vector_size(16)));
enum { PAIRED = 4, PAIRS = PAIRED / 2 };

INLINE void pairs_take(const double *x, pair *pairs)
{
    for (int q = 0; q < PAIRS; q++)
        pairs[q] = (pair){x[2 * q], x[2 * q + 1]};
}

INLINE void pairs_give(const pair *pairs, double *x)
{
    for (int q = 0; q < PAIRS; q++) {
        x[2 * q] = pairs[q][0];
        x[2 * q + 1] = pairs[q][1];
    }
}

INLINE void paired_stages(const struct tableau *tableau, slope_function *slope, const void *forces,
                          double t, double h, const pair *y, pair *k, pair *z, bool known)
{
    double at[PAIRED], dydt[PAIRED];
    UNROLL for (int s = 0; s < tableau->stages; s++)
    {
        const double *const w = tableau_row(tableau, s);
        if (s == 0 && known)
            continue;
        for (int q = 0; q < PAIRS; q++) {
            pair sum = {-0.0, -0.0};
            UNROLL for (int j = 0; j < s; j++) if (w[j] != 0) sum += h * w[j] * k[PAIRS * j + q];
            z[q] = s == 0 ? y[q] : y[q] + sum;
        }
        pairs_give(z, at);
        slope(forces, t + tableau->c[s] * h, at, dydt);
        pairs_take(dydt, k + PAIRS * s);
    }
}

INLINE void paired_difference(double h, const double *w, const double *u, int count, const pair *k,
                              double *error)
{
    pair pairs[PAIRS];
    for (int q = 0; q < PAIRS; q++) {
        pair sum = {-0.0, -0.0};
        UNROLL for (int j = 0; j < count; j++) if (w[j] != u[j]) sum +=
            (w[j] - u[j]) * k[PAIRS * j + q];
        pairs[q] = h * sum;
    }
    pairs_give(pairs, error);
}

struct attempt {
    double y[MOST], z[MOST], error[MOST];
    /* slopes, where they are in pairs; else they are in step->work */
    pair paired[STAGES_MAX * PAIRS];
};

INLINE void attempt_begin(int n, int stages, bool known, const struct step *step,
                          struct attempt *attempt)
{
    const double *const first = step->work + (known ? (stages - 1) * n : 0);
    copy_numbers(n, step->y, attempt->y);
    if (n == PAIRED)
        pairs_take(first, attempt->paired);
    else
        copy_numbers(n, first, step->work);
}

INLINE void attempt_stages(const struct tableau *tableau, int n, slope_function *slope,
                           const void *forces, double h, bool known, struct step *step,
                           struct attempt *attempt)
{
    pair y[PAIRS], z[PAIRS];
    step->cost.evals += tableau->stages - known;
    if (n != PAIRED) {
        rk_stages(tableau, n, slope, forces, step->t, h, attempt->y, step->work, attempt->z, NULL,
                  known);
        return;
    }
    pairs_take(attempt->y, y);
    paired_stages(tableau, slope, forces, step->t, h, y, attempt->paired, z, known);
    pairs_give(z, attempt->z);
}

/* In units of the tolerance, squared; NAN: the new state is not finite. */
INLINE double attempt_error(const struct tableau *tableau, int n, const double *scale, double h,
                            const struct step *step, struct attempt *attempt)
{
    double rough[PAIRED], square;
    if (n != PAIRED) {
        square =
            rk_estimate(tableau, n, scale, h, step->work, attempt->y, attempt->z, attempt->error);
    } else {
        const int stages = tableau->stages;
        paired_difference(h, tableau->b, tableau->b_hat, stages, attempt->paired, attempt->error);
        if (tableau->rough)
            paired_difference(h, tableau->b, tableau->rough, stages, attempt->paired, rough);
        square = rk_square(tableau, n, scale, attempt->y, attempt->z, rough, attempt->error);
    }
    for (int i = 0; i < n; i++)
        square = isfinite(attempt->z[i]) ? square : NAN;
    return square;
}

INLINE void attempt_keep(const struct tableau *tableau, int n, double h,
                         const struct attempt *attempt, struct step *step)
{
    step->warm = true;
    step->h = h;
    copy_numbers(n, attempt->z, step->y);
    if (n == PAIRED)
        memcpy(step->work, attempt->paired, (size_t)(tableau->stages * n) * sizeof *step->work);
    /* the interpolant's stages are not there */
    step->work[(tableau->stages + tableau->extra + 1) * n] = false;
    if (step->error)
        copy_numbers(n, attempt->error, step->error);
}

/* ---- accepted steps ---- */

/* No kinks, switches or compensated sums; the size of the first step is known. */
INLINE enum step_status controlled_step(const struct method *method, int n, slope_function *slope,
                                        const void *forces, struct step *step,
                                        struct controller *controller, double t_end)
{
    const struct tableau *tableau = method->tableau;
    const double t = step->t, span = t_end - t, aims = by_aim(method);
    const double max = largest_estimate(method, tolerance(controller)),
                 accepted = 1 / (n * max * max);
    struct attempt attempt;
    bool known = tableau->fsal && step->warm;
    if (n < 1)
        __builtin_unreachable();
    attempt_begin(n, tableau->stages, known, step, &attempt);
    face(controller, span);
    const double planned = controller->h;
    const bool rejected = controller->rejected;
    step->again = false;
    step->tol = 0;
    step->square = -1;
    for (int count = 0, failures = 0;; count++) {
        const bool last = fabs(controller->h) * STRETCH >= fabs(span);
        double h = controller->h;
        if (unlikely(last)) /* a branch: the first stage does not wait for it */
            h = span;
        attempt_stages(tableau, n, slope, forces, h, known, step, &attempt);
        known = true;
        if (count == 0) /* roots and quotients: the stages, which are waited for, come first */
            follow(n, step, controller);
        const double square =
            attempt_error(tableau, n, controller->scale, h, step, &attempt) * accepted;
        if (square <= 1) {
            plan_next(method, controller, h, square * aims, last);
            step->t = not_beyond(last ? t_end : advance_clock(controller, t, h), span, t_end);
            if (step->t == t_end)
                controller->t_low = 0;
            controller->rejected = false;
            attempt_keep(tableau, n, h, &attempt, step);
            return STEP_OK;
        }
        step->warm = false;
        step->cost.rejected++;
        controller->rejected = true;
        if (plan_again(method, controller, t, h, square * aims, &failures))
            continue;
        controller->h = planned;
        controller->rejected = rejected;
        step->h = h;
        return isfinite(square) ? STEP_STALLED : STEP_NONFINITE;
    }
}

/* ---- rows and shapes ---- */

/* Of all methods that are METHOD_CONTROLLED, and of those that are METHOD_UNROLLED, too: the rest
 * would be long. */
#define ALWAYS_SHAPES(S) S(spring) S(duffing) S(driven) S(pendulum) S(kepler)
#define OFTEN_SHAPES(S) S(damped) S(vanderpol)
#define SOLVED_SHAPES(S) ALWAYS_SHAPES(S) OFTEN_SHAPES(S)

INLINE bool solved(const struct method *method, int shape)
{
    bool always = false;
#define IS_IT(name) always = always || shape == SHAPE_##name;
    ALWAYS_SHAPES(IS_IT)
    return method->flags & METHOD_CONTROLLED && (always || method->flags & METHOD_UNROLLED);
}

#define RK_ROW JOIN(rk_, __LINE__)
#define NAME(shape) JOIN(shape##_controlled_, __LINE__)
#define CONTROLLED(shape)                                                                          \
    static enum step_status NAME(shape)(const struct method *method, struct step *step,            \
                                        struct controller *controller, double t_end)               \
    {                                                                                              \
        struct shape_forces forces;                                                                \
        (void)method;                                                                              \
        if (!solved(&RK_ROW, SHAPE_##shape))                                                       \
            return STEP_STALLED; /* not in use */                                                  \
        forces_take(&forces, step->system, 0 TERMS_OF_##shape(ONE_MORE));                          \
        return controlled_step(&RK_ROW, SIZE_##shape, shape##_slope, &forces, step, controller,    \
                               t_end);                                                             \
    }
#define RUNGE_KUTTA(...)                                                                           \
    static const struct method RK_ROW = {__VA_ARGS__};                                             \
    SOLVED_SHAPES(CONTROLLED)
#include "method/rows/rk.def"
#undef RUNGE_KUTTA

#define ENTRY(shape) [SHAPE_##shape] = NAME(shape),
controlled_function *method_controlled_kernel(const struct method *method,
                                              const struct system *system)
{
    static controlled_function *const steps[][SHAPE_COUNT] = {
        {NULL},
#define RUNGE_KUTTA(...) {SOLVED_SHAPES(ENTRY)},
#include "method/rows/rk.def"
    };
    const int shape = shape_of(system);
    return shape >= 0 && method->step == rk_step && solved(method, shape)
               ? steps[method->index][shape]
               : NULL;
}

void method_choose_kernels(const struct method *method, struct step *step, bool special)
{
    step->kernel = special ? method_step_kernel(method, step->system) : NULL;
    step->controlled = special ? method_controlled_kernel(method, step->system) : NULL;
}
