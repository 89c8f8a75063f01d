/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Accepted adaptive steps of frequently used Runge-Kutta methods (METHOD_CONTROLLED), stages and
 * step-size control in one function: method_adapt() compiled for each row and shape of scene, so
 * that nothing between the stages and the next step goes through memory.
 */
#if defined(__GNUC__) && !defined(__clang__)
/* Reading a pair of numbers that were stored one by one is slow. */
#pragma GCC optimize("no-tree-vectorize", "no-tree-loop-distribute-patterns")
#endif
#define UNROLL _Pragma("GCC unroll 32")
#include "method/kernel/kernel.h"
#include "method/control/adapt_body.h"
#include "method/control/rk_error.h"

/* Distance, relative to the time, within which a step has reached the end but for rounding. */
#define NEAR_END (8 * DBL_EPSILON)

/* ---- the attempts ---- */

/* Scenes of two coordinates use vectors of two numbers, which halves the instructions. */
typedef double pair __attribute__((vector_size(16)));
/* Number of variables of such scenes, and of their pairs. */
enum { PAIRED = 4, PAIRS = PAIRED / 2 };

/* Copies four numbers into pairs. */
INLINE void pairs_take(const double *x, pair *pairs)
{
    for (int q = 0; q < PAIRS; q++)
        pairs[q] = (pair){x[2 * q], x[2 * q + 1]};
}

/* Copies pairs into four numbers. */
INLINE void pairs_give(const pair *pairs, double *x)
{
    for (int q = 0; q < PAIRS; q++) {
        x[2 * q] = pairs[q][0];
        x[2 * q + 1] = pairs[q][1];
    }
}

/* Does the same as rk_stages() in pairs, without low parts. */
INLINE void paired_stages(const struct tableau *tableau, slope_function *slope, const void *forces,
                          double t, double h, const pair *y, pair *k, pair *z, bool known)
{
    double state[PAIRED], dydt[PAIRED];
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
        pairs_give(z, state);
        slope(forces, t + tableau->c[s] * h, state, dydt);
        pairs_take(dydt, k + PAIRS * s);
    }
}

/* Does the same as rk_difference() in pairs. */
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

/* The step that is being attempted; a local copy, which compilers can keep in registers. */
struct attempt {
    double y[MOST], z[MOST], error[MOST];
    double k[STAGES_MAX * MOST]; /* slopes of the stages, unless they are in pairs */
    pair paired[STAGES_MAX * PAIRS];
    double t, h; /* [s] time at which it begins, or at which it has ended, and its size */
    int64_t evals, rejected; /* counted over all steps of a call */
};

/* Copies the state and, if `known`, the first slope from the step's memory. */
INLINE void attempt_begin(int n, int stages, bool known, const struct step *step,
                          struct attempt *attempt)
{
    const double *const first = step->work + (known ? (stages - 1) * n : 0);
    copy_numbers(n, step->y, attempt->y);
    if (n == PAIRED)
        pairs_take(first, attempt->paired);
    else
        copy_numbers(n, first, attempt->k);
}

/* Begins the next attempt where this one ends; for methods whose last slope is the next first one
 * (FSAL) that slope is kept. */
INLINE void attempt_next(int n, int stages, struct attempt *attempt)
{
    copy_numbers(n, attempt->z, attempt->y);
    if (n == PAIRED)
        for (int q = 0; q < PAIRS; q++)
            attempt->paired[q] = attempt->paired[PAIRS * (stages - 1) + q];
    else
        copy_numbers(n, attempt->k + (stages - 1) * n, attempt->k);
}

/* Computes stages and new state of an attempt from t over h. */
INLINE void attempt_stages(const struct tableau *tableau, int n, slope_function *slope,
                           const void *forces, double t, double h, bool known,
                           struct attempt *attempt)
{
    pair y[PAIRS], z[PAIRS];
    if (n != PAIRED) {
        rk_stages(tableau, n, slope, forces, t, h, attempt->y, attempt->k, attempt->z, NULL, known);
        return;
    }
    pairs_take(attempt->y, y);
    paired_stages(tableau, slope, forces, t, h, y, attempt->paired, z, known);
    pairs_give(z, attempt->z);
}

/* Returns the squared error in units of the tolerance, or NAN if the new state is not finite. */
INLINE double attempt_error(const struct tableau *tableau, int n, const double *scale, double h,
                            struct attempt *attempt)
{
    double rough[PAIRED], square;
    if (n != PAIRED) {
        square =
            rk_estimate(tableau, n, scale, h, attempt->k, attempt->y, attempt->z, attempt->error);
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

/* Writes the last attempt to *step as if it had been the only one; if it failed, the state before
 * it. */
INLINE void attempt_keep(const struct tableau *tableau, int n, bool good,
                         const struct attempt *attempt, struct step *step)
{
    step->again = false;
    step->tol = 0;
    step->square = -1;
    step->warm = good;
    step->h = attempt->h;
    step->t = attempt->t;
    step->cost.evals += attempt->evals;
    step->cost.rejected += attempt->rejected;
    copy_numbers(n, good ? attempt->z : attempt->y, step->y);
    memcpy(step->work, n == PAIRED ? (const void *)attempt->paired : attempt->k,
           (size_t)(tableau->stages * n) * sizeof *step->work);
    /* the interpolant's stages are not there */
    step->work[(tableau->stages + tableau->extra + 1) * n] = false;
    if (step->error && good)
        copy_numbers(n, attempt->error, step->error);
}

/* ---- accepted steps ---- */

/* Copies the controller for n variables, except for its tolerance and its switches. */
INLINE void control_copy(int n, const struct controller *source, struct controller *target)
{
    copy_numbers(n, source->scale, target->scale);
    copy_numbers(n, source->excess, target->excess);
    target->elapsed = source->elapsed;
    target->sampled = source->sampled;
    target->sampling = source->sampling;
    target->h = source->h;
    target->t_low = source->t_low;
    target->last = source->last;
    target->previous = source->previous;
    target->rejected = source->rejected;
}

/* Attempts steps towards t_end until one is accepted. known means that the first slope is in
 * *attempt; accepted is the factor that makes the square of the largest accepted error 1. Returns
 * STEP_OK, or the reason why no step was accepted. */
INLINE enum step_status accept_step(const struct method *method, int n, slope_function *slope,
                                    const void *forces, const struct system *system,
                                    struct controller *controller, double t_end, double accepted,
                                    bool known, struct attempt *attempt)
{
    const struct tableau *tableau = method->tableau;
    const double t = attempt->t, span = t_end - t, aims = aim_factor(method);
    controller_orient(controller, span);
    const double planned = controller->h;
    const bool rejected = controller->rejected;
    for (int count = 0, failures = 0;; count++) {
        const bool last = fabs(controller->h) * LAST_STEP_STRETCH >= fabs(span);
        double h = controller->h;
        if (unlikely(last)) /* as a branch, since the first stage does not wait for branches */
            h = span;
        attempt->h = h;
        attempt_stages(tableau, n, slope, forces, t, h, known, attempt);
        attempt->evals += tableau->stages - known;
        known = true;
        if (count == 0) /* slow roots and quotients come after the stages, which are waited for */
            update_sizes(n, system, t, attempt->y, controller);
        const double square = attempt_error(tableau, n, controller->scale, h, attempt) * accepted;
        if (square <= 1) {
            plan_next(method, controller, h, square * aims, last);
            attempt->t = limit_to_end(last ? t_end : advance_clock(controller, t, h), span, t_end);
            if (attempt->t == t_end)
                controller->t_low = 0;
            controller->rejected = false;
            return STEP_OK;
        }
        attempt->rejected++;
        controller->rejected = true;
        failures += !isfinite(square * aims);
        controller->h = next_attempt(method, t, h, square * aims, failures);
        if (controller->h != 0)
            continue;
        controller->h = planned;
        controller->rejected = rejected;
        return isfinite(square) ? STEP_STALLED : STEP_NONFINITE;
    }
}

/* Does the work of method_adapt_many(), for systems without kinks, switches and compensated sums
 * whose first step has a size. */
INLINE int64_t controlled_steps(const struct method *method, int n, slope_function *slope,
                                const void *forces, struct step *step,
                                struct controller *controller, double t_end, int64_t count,
                                double *row, enum step_status *status)
{
    const struct tableau *tableau = method->tableau;
    const double max = largest_estimate(method, controller_tolerance(controller)),
                 accepted = 1 / (n * max * max);
    struct controller control;
    struct attempt attempt;
    bool known = tableau->fsal && step->warm;
    int64_t taken = 0;
    if (n < 1)
        __builtin_unreachable();
    attempt.t = step->t;
    attempt.evals = attempt.rejected = 0;
    control.tol = controller->tol;
    control_copy(n, controller, &control);
    attempt_begin(n, tableau->stages, known, step, &attempt);
    for (;;) {
        *status = accept_step(method, n, slope, forces, step->system, &control, t_end, accepted,
                              known, &attempt);
        if (*status != STEP_OK)
            break;
        if (row) {
            copy_numbers(n, attempt.z, row);
            row[n] = attempt.t;
            row += n + 1;
        }
        if (++taken == count || fabs(t_end - attempt.t) <= NEAR_END * fabs(attempt.t))
            break;
        attempt_next(n, tableau->stages, &attempt);
        known = tableau->fsal;
    }
    control_copy(n, &control, controller);
    attempt_keep(tableau, n, *status == STEP_OK, &attempt, step);
    return taken;
}

/* ---- rows and shapes ---- */

/* Shapes with kernels for all METHOD_CONTROLLED methods (ALWAYS), and for METHOD_UNROLLED ones only
 * (OFTEN), since more would make the program long. */
#define ALWAYS_SHAPES(S) S(spring) S(duffing) S(driven) S(pendulum) S(kepler)
#define OFTEN_SHAPES(S) S(damped) S(vanderpol)
#define SOLVED_SHAPES(S) ALWAYS_SHAPES(S) OFTEN_SHAPES(S)

/* Returns true if this file has a kernel for the method and shape. */
INLINE bool has_controlled_kernel(const struct method *method, int shape)
{
    bool always = false;
#define IS_IT(name) always = always || shape == SHAPE_##name;
    ALWAYS_SHAPES(IS_IT)
    return method->flags & METHOD_CONTROLLED && (always || method->flags & METHOD_UNROLLED);
}

/* Names of rows and kernels, made unique by the line at which a row ends. */
#define RK_ROW JOIN(rk_, __LINE__)
#define NAME(shape) JOIN(shape##_controlled_, __LINE__)
/* Defines the kernel of RK_ROW for one shape. */
#define CONTROLLED(shape)                                                                          \
    static int64_t NAME(shape)(struct step * step, struct controller * controller, double t_end,   \
                               int64_t count, double *row, enum step_status *status)               \
    {                                                                                              \
        struct shape_forces forces;                                                                \
        if (!has_controlled_kernel(&RK_ROW, SHAPE_##shape))                                        \
            return 0; /* not in use */                                                             \
        forces_take(&forces, step->system, 0 TERMS_OF_##shape(ONE_MORE));                          \
        return controlled_steps(&RK_ROW, SIZE_##shape, shape##_slope, &forces, step, controller,   \
                                t_end, count, row, status);                                        \
    }
#define RUNGE_KUTTA(id, ...)                                                                       \
    static const struct method RK_ROW = {__VA_ARGS__};                                             \
    SOLVED_SHAPES(CONTROLLED)
#include "method/rows/rk.def"
#undef RUNGE_KUTTA

#define ENTRY(shape) [SHAPE_##shape] = NAME(shape),
/* Returns the kernel for method and shape of the system, or NULL. */
controlled_function *method_controlled_kernel(const struct method *method,
                                              const struct system *system)
{
    static controlled_function *const steps[][SHAPE_COUNT] = {
        {NULL},
#define RUNGE_KUTTA(...) {SOLVED_SHAPES(ENTRY)},
#include "method/rows/rk.def"
    };
    const int shape = shape_of(system);
    return shape >= 0 && method->step == rk_step && has_controlled_kernel(method, shape)
               ? steps[method->index][shape]
               : NULL;
}

void method_choose_kernels(const struct method *method, struct step *step, bool special)
{
    step->kernel = special ? method_step_kernel(method, step->system) : NULL;
    step->controlled = special ? method_controlled_kernel(method, step->system) : NULL;
}
