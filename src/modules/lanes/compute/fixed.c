/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps in lanes, of explicit Runge-Kutta methods and splittings: rk_body.h and split_body.h
 * on every lane. States of stages are stored where the programs read them, and slopes are written
 * where the sums read them. If the method locates turning points, the step of a lane whose velocity
 * changes its sign is repeated for this lane alone, in pieces. */
#define UNROLL _Pragma("GCC unroll 16")
#include "modules/lanes/compute/state.h"

#include <hooke/base/numeric.h>

/* ---- explicit Runge-Kutta ---- */

/* Computes z = y + sum_j weight_j k_j over all lanes; with h, the steps [LANE_COUNT] of the lanes,
 * weights are multiplied by it. */
CLONES void lanes_combine(const struct weights *sum, const double *h, int n, const double *k,
                          const double *y, double *z)
{
    /* vectors summed at the same time, to hide the latency of additions */
    enum { AT_ONCE = 4 };
    const four *source = (const four *)(const void *)y;
    four *target = (four *)(void *)z;
    const int size = n * LANE_COUNT / 4;
    for (int q = 0; q < size; q += AT_ONCE) {
        const four *const own = (const four *)(const void *)h + q % (LANE_COUNT / 4);
        four total[AT_ONCE];
        const four *slope = (const four *)(const void *)k + sum->stage[0] * size + q;
        UNROLL for (int p = 0; p < AT_ONCE; p++) total[p] =
            (h ? own[p] * sum->weight[0] : sum->weight[0] - (four){0}) * slope[p];
        for (int j = 1; j < sum->count; j++) {
            const double weight = sum->weight[j];
            slope = (const four *)(const void *)k + sum->stage[j] * size + q;
            UNROLL for (int p = 0; p < AT_ONCE; p++) total[p] +=
                (h ? own[p] * weight : weight - (four){0}) * slope[p];
        }
        UNROLL for (int p = 0; p < AT_ONCE; p++) target[q + p] = source[q + p] + total[p];
    }
}

/* Returns true if the sign bit of any lane's velocity differs between v0 and v1. */
static bool any_turns(const double *v0, const double *v1)
{
    uint64_t any = 0;
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        uint64_t a, b;
        memcpy(&a, v0 + lane, sizeof a);
        memcpy(&b, v1 + lane, sizeof b);
        any |= a ^ b;
    }
    return any >> 63;
}

/* Repeats the step of one lane from its start by method_turning_step(), and writes the new state to
 * z; NAN if it fails. */
static void turn_lane(struct lanes *lanes, int lane, double *z)
{
    const struct method *method = lanes->method;
    const int n = lanes->n, last = (method->tableau->stages - 1) * n;
    double y[LIMIT_VARIABLES];
    struct step step = {.system = lanes->system[lane],
                        .drag = lanes->drag,
                        .t = lanes->own_t0[lane] + (double)lanes->step * lanes->own_h[lane],
                        .h = lanes->own_h[lane],
                        .y = y,
                        .work = lanes->work,
                        .kernel = lanes->scalar,
                        .warm = method->tableau->fsal};
    lane_get(n, lanes->y, lane, y);
    lane_get(n, lanes->k, lane, lanes->work + last);
    const bool good = method_turning_step(method, &step) == STEP_OK;
    for (int i = 0; i < n && !good; i++)
        y[i] = NAN;
    lanes->evals[lane] += step.cost.evals - (method->tableau->stages - method->tableau->fsal);
    lane_put(n, y, lane, z);
    lane_put(n, lanes->work + last, lane, lanes->k + last * LANE_COUNT);
}

/* Writes the first variable of every lane and its derivative to row [2][LANE_COUNT]. */
static void write_row(struct lanes *lanes, double *row)
{
    const size_t size = LANE_COUNT * sizeof *row;
    double own[LANE_COUNT];
    memcpy(row, lanes->state, size);
    if (lanes->rows < lanes->n) {
        memcpy(row + LANE_COUNT, lanes->state + lanes->rows * LANE_COUNT, size);
    } else if (!lanes->method->tableau->fsal || !lanes->timed) {
        memcpy(row + LANE_COUNT, lanes->k, size);
        /* the last slope belongs to t + h, which is rounded differently from the time of the next
         * step
         */
    } else {
        double *slope = lanes->k + lanes->method->tableau->stages * lanes->n * LANE_COUNT;
        lanes_slope(lanes, lanes_time(lanes, 0, own), slope);
        memcpy(row + LANE_COUNT, slope, size);
    }
}

/* Makes `count` steps of an explicit Runge-Kutta method (see lanes_march()). */
void lanes_march_rk(struct lanes *lanes, int64_t count, double *row)
{
    const struct tableau *tableau = lanes->method->tableau;
    const int n = lanes->n, stages = tableau->stages, v = n / 2 * LANE_COUNT;
    const size_t size = (size_t)n * LANE_COUNT * sizeof(double);
    const double *const h = lanes->own ? lanes->own_h : NULL;
    double own[LANE_COUNT], *z = lanes->state, *y = lanes->y, *k = lanes->k;
    for (int64_t i = 0; i < count; i++) {
        for (int s = 1; s < stages; s++) {
            lanes_combine(&lanes->weights[s], h, n, k, y, z);
            lanes_slope(lanes, lanes_time(lanes, tableau->c[s], own), k + s * n * LANE_COUNT);
        }
        if (!tableau->fsal)
            lanes_combine(&lanes->weights[0], h, n, k, y, z);
        if (lanes->turns && any_turns(y + v, z + v))
            for (int lane = 0; lane < LANE_COUNT; lane++)
                if (lane_turns(y[v + lane], z[v + lane]))
                    turn_lane(lanes, lane, z);
        lanes->step++;
        memcpy(y, z, size);
        if (tableau->fsal)
            memcpy(k, k + (stages - 1) * n * LANE_COUNT, size);
        else
            lanes_slope(lanes, lanes_time(lanes, 0, own), k);
        if (row)
            write_row(lanes, row + i * 2 * LANE_COUNT);
    }
}

/* ---- splittings ---- */

/* Applies the exact flow of the drag over half a step to all velocities v (drag_flow_apply()). */
static void lanes_drag_flow(const struct lanes *lanes, double *v)
{
    for (int i = 0; i < lanes->rows; i++, v += LANE_COUNT)
        for (int lane = 0; lane < LANE_COUNT; lane++) {
            const struct drag_flow half = {lanes->half[lane], lanes->half[LANE_COUNT + lane],
                                           lanes->half[2 * LANE_COUNT + lane]};
            v[lane] = drag_flow_apply(&half, v[lane]);
        }
}

/* Adds w y to x, each [rows][LANE_COUNT] and w [LANE_COUNT]. */
static inline void add_times(int rows, const double *restrict w, const double *restrict y,
                             double *restrict x)
{
    for (int i = 0; i < rows; i++, x += LANE_COUNT, y += LANE_COUNT)
        for (int lane = 0; lane < LANE_COUNT; lane++)
            x[lane] += w[lane] * y[lane];
}

/* Changes the velocities v [rows][LANE_COUNT] by a kick: the accelerations lanes->pull times the
 * lengths w [LANE_COUNT] [s] of the kick, with drag as in split_kick(). `index` is the number of
 * the kick in the splitting, which selects its coefficients of exact drag; stage_time is the time
 * of explicit drag. */
CLONES static void lanes_kick(struct lanes *lanes, int index, struct lane_time stage_time,
                              const double *w, double *v)
{
    const int count = lanes->rows * LANE_COUNT;
    double *pull = lanes->pull;
    if (lanes->way.drag == DRAG_EXPLICIT) {
        lanes_force(lanes, SUM_DRAG, stage_time, lanes->drags);
        for (int l = 0; l < count; l++)
            lanes->drags[l] += pull[l]; /* the sum is the same in either order */
        add_times(lanes->rows, w, lanes->drags, v);
    } else if (lanes->way.drag == DRAG_EXACT && !lanes->way.drag_at_ends) {
        const double *lost = lanes->frozen + 2 * index * LANE_COUNT, *weight = lost + LANE_COUNT;
        for (int i = 0; i < lanes->rows; i++, v += LANE_COUNT, pull += LANE_COUNT)
            for (int lane = 0; lane < LANE_COUNT; lane++)
                v[lane] += pull[lane] * weight[lane] - v[lane] * lost[lane];
    } else {
        add_times(lanes->rows, w, pull, v);
    }
}

/* Moves the positions by the velocities over w [LANE_COUNT]. */
CLONES static void drift(const struct lanes *lanes, const double *w)
{
    add_times(lanes->rows, w, lanes->state + lanes->rows * LANE_COUNT, lanes->state);
}

/* Makes `count` steps of a splitting (see lanes_march()): kicks and drifts in turn. */
CLONES void lanes_march_split(struct lanes *lanes, int64_t count, double *row)
{
    const struct split_way *way = &lanes->way;
    const struct splitting *splitting = way->splitting;
    double *v = lanes->state + lanes->rows * LANE_COUNT;
    for (int64_t i = 0; i < count; i++) {
        double time[LANE_COUNT], w[LANE_COUNT];
        struct lane_time stage_time = lanes_time(lanes, 0, time);
        if (way->drag_at_ends)
            lanes_drag_flow(lanes, v);
        for (int index = 0; index < splitting->count; index++) {
            const double weight = splitting_weight(splitting, index);
            for (int lane = 0; lane < LANE_COUNT; lane++)
                w[lane] = weight * lanes->own_h[lane];
            if ((index % 2 == 0) == splitting->kick_first) {
                /* The last force of a step is the first of the next one. */
                if (!(index == 0 && way->continues && lanes->step > 0))
                    lanes_force(lanes, SUM_FORCE, stage_time, lanes->pull);
                lanes_kick(lanes, index, stage_time, w, v);
            } else {
                drift(lanes, w);
                lanes_time_add(lanes, weight, &stage_time, time);
            }
        }
        if (way->drag_at_ends)
            lanes_drag_flow(lanes, v);
        lanes->step++;
        if (row)
            write_row(lanes, row + i * 2 * LANE_COUNT);
    }
}

void lanes_row(struct lanes *lanes, double *row)
{
    lanes_march(lanes, 0, NULL);
    write_row(lanes, row);
}
