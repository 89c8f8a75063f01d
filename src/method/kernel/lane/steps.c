/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Many trajectories at once: the same steps on LANES systems of one kind, in vectors as wide as the
 * machine has. The latency of one trajectory's sums, which is what a single one waits for, is
 * hidden by the others.
 *
 * Not target_clones: a vector type has its width from the instructions that its function may use,
 * and one that is wider than they are lives in memory. So the text is included for each width, and
 * the widest that runs here is taken.
 */
#define UNROLL _Pragma("GCC unroll 16")
#include <hooke/base/circle.h>
#include <hooke/base/elementary.h>

#include "method/kernel/lane/state.h"
#include "method/kernel/lanes.h"
#include "method/control/adapt_body.h"
#include "method/step/irk_body.h"
#include "method/step/newton_body.h"
#include "method/step/rosenbrock_body.h"

#include <float.h>

/* Of a step of `count` lanes from `first` on: those that turned in it take it again. */
typedef void lane_turner(struct lanes *lanes, int first, int count, int64_t number,
                         struct lane_step *step);

#define LANE_FLAG(i, name) | (name##_flags)
#define LANE_FLAGS(shape) (0 TERMS_OF_##shape(LANE_FLAG))

/* One after another. */
static __attribute__((noinline)) void lanes_turn(struct lanes *lanes, int first, int count,
                                                 int64_t number, struct lane_step *of)
{
    for (int i = 0; i < count; i++) {
        if (!lane_turns(of->before[1][i], of->after[1][i]))
            continue;
        double y[2] = {of->before[0][i], of->before[1][i]},
               slope[2] = {of->first[0][i], of->first[1][i]};
        double work[WORK_MOST];
        struct step step = {.system = lanes->system[first + i],
                            .drag = lanes->drag,
                            .t =
                                lanes->own_t0[first + i] + (double)number * lanes->own_h[first + i],
                            .h = lanes->own_h[first + i],
                            .y = y,
                            .work = work,
                            .kernel = lanes->scalar};
        lanes->more[first + i] += lane_turn(lanes->method, &step, slope);
        for (int j = 0; j < 2; j++) {
            of->after[j][i] = y[j];
            of->last[j][i] = slope[j];
        }
    }
}

/* Implicit steps of those lanes that are marked, one after another; evals: what they took. */
static __attribute__((noinline)) void lanes_alone(struct lanes *lanes, int first, int count,
                                                  int64_t number, const int64_t *alone,
                                                  int64_t *evals, struct lane_step *of)
{
    const struct implicit_tableau *tableau = lanes->method->implicit;
    for (int i = 0; i < count; i++) {
        if (!alone[i])
            continue;
        double y[2] = {of->before[0][i], of->before[1][i]}, work[WORK_MOST] = {0};
        double *const last = work + (tableau->stages - 1) * 2;
        struct step step = {.system = lanes->system[first + i],
                            .t =
                                lanes->own_t0[first + i] + (double)number * lanes->own_h[first + i],
                            .h = lanes->own_h[first + i],
                            .y = y,
                            .work = work,
                            .warm = number > 0};
        last[0] = of->first[0][i];
        last[1] = of->first[1][i];
        const bool good =
            isfinite(y[0]) && isfinite(y[1]) && method_step(lanes->method, &step) == STEP_OK;
        evals[i] = step.cost.evals;
        for (int j = 0; j < 2; j++) {
            of->after[j][i] = good ? y[j] : (double)NAN;
            of->last[j][i] = last[j];
        }
    }
}

/* ---- the widths ---- */

/* [doubles] Narrower ones, which are there for old processors only, take the forms for any method.
 */
#ifdef __x86_64__
#define WIDE_UNROLLED 4
#else
#define WIDE_UNROLLED 2
#endif

#define WIDE 2
#define TARGET
#define WITH(name) name##_2
#include "method/kernel/lane/steps.h"

#ifdef __x86_64__
#define WIDE 4
#define TARGET __attribute__((target("avx2")))
#define WITH(name) name##_4
#include "method/kernel/lane/steps.h"

#define WIDE 8
#define TARGET __attribute__((target("avx512f")))
#define WITH(name) name##_8
#include "method/kernel/lane/steps.h"
#endif

struct lane_width lanes_width(int most)
{
#ifdef __x86_64__
    if (most >= 8 && __builtin_cpu_supports("avx512f"))
        return (struct lane_width){kernels_8, rosenbrocks_8, drives_8, own_drives_8};
    if (most >= 4 && __builtin_cpu_supports("avx2"))
        return (struct lane_width){kernels_4, rosenbrocks_4, drives_4, own_drives_4};
#endif
    (void)most;
    return (struct lane_width){kernels_2, rosenbrocks_2, drives_2, own_drives_2};
}
