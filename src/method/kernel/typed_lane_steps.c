/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Typed scenes, many trajectories at once: explicit Runge-Kutta methods and splittings, the
 * operations of rk_body.h and split_body.h in their order on every lane, with programs for the
 * forces. The stages' states stand where the programs read them, and slopes are written where the
 * sums want them.
 *
 * Where the method turns, a lane whose velocity changes its sign has its step taken again alone, in
 * pieces.
 */
#define UNROLL _Pragma("GCC unroll 16")
#include "method/kernel/typed_lanes.h"

#include <hooke/base/numeric.h>
#include <hooke/scene/formula.h>

_Static_assert(LANES == PROGRAM_LANES, "they are the same lanes");

/* ---- forces ---- */

static inline void fill(double *lane, double value)
{
    for (int l = 0; l < LANES; l++)
        lane[l] = value;
}

/* A time. */
struct lane_time {
    const double *t; /* [LANES] each lane's own; NULL: the same in all lanes: */
    double all;
};

static inline double time_of(struct lane_time at, int lane)
{
    return at.t ? at.t[lane] : at.all;
}

/* Adds what a built-in term adds. */
static void add_built_in(struct typed_lanes *lanes, const struct lane_term *term,
                         struct lane_time at, double *out)
{
    const double *state = lanes->input + LANES;
    if (term->once) {
        double a = -0.0;
        term->row->add(lanes->system[0]->term[term->index].c, at.all, lanes->system[0]->start, &a);
        for (int lane = 0; lane < LANES; lane++)
            out[lane] += a;
    } else if (term->add && !(at.t && term->row->flags & TERM_TIME)) {
        term->add(term->c, at.all, state, out);
    } else {
        for (int lane = 0; lane < LANES; lane++) {
            double y[LIMIT_VARIABLES], a[LIMIT_VARIABLES];
            for (int i = 0; i < lanes->n; i++)
                y[i] = state[i * LANES + lane];
            for (int i = 0; i < lanes->rows; i++)
                a[i] = out[i * LANES + lane];
            term->row->add(lanes->system[lane]->term[term->index].c, time_of(at, lane), y, a);
            for (int i = 0; i < lanes->rows; i++)
                out[i * LANES + lane] = a[i];
        }
    }
}

/* out [rows]: the sum of the forces whose flags under `mask` are `wanted` */
INLINE void forces(struct typed_lanes *lanes, unsigned mask, unsigned wanted, struct lane_time at,
                   double *out)
{
    bool first = true;
    if (lanes->timed && at.t)
        memcpy(lanes->input, at.t, LANES * sizeof *at.t);
    else if (lanes->timed)
        fill(lanes->input, at.all);
    for (int i = 0; i < lanes->terms; i++) {
        const struct lane_term *term = &lanes->term[i];
        if ((term->row->flags & mask) != wanted)
            continue;
        if (term->program && first) {
            program_eval_lanes(term->program, out, term->frame);
        } else if (term->program) {
            program_eval_lanes(term->program, lanes->spare, term->frame);
            for (int l = 0; l < lanes->rows * LANES; l++)
                out[l] += lanes->spare[l];
        } else {
            for (int l = 0; first && l < lanes->rows * LANES; l++)
                out[l] = -0.0;
            add_built_in(lanes, term, at, out);
        }
        first = false;
    }
    for (int l = 0; first && l < lanes->rows * LANES; l++)
        out[l] = -0.0;
}

INLINE void slope(struct typed_lanes *lanes, struct lane_time at, double *out)
{
    const int positions = lanes->n - lanes->rows;
    memcpy(out, lanes->input + (1 + lanes->n - positions) * LANES,
           (size_t)positions * LANES * sizeof *out);
    forces(lanes, 0, 0, at, out + positions * LANES);
}

/* So much of a step after its beginning; own: [LANES], where lanes have their own. */
INLINE struct lane_time lane_time_of(const struct typed_lanes *lanes, double c, double *own)
{
    const double step = (double)lanes->step;
    if (!lanes->own)
        return (struct lane_time){.all = (lanes->t0 + step * lanes->h) + c * lanes->h};
    for (int lane = 0; lane < LANES; lane++)
        own[lane] = (lanes->own_t0[lane] + step * lanes->own_h[lane]) + c * lanes->own_h[lane];
    return (struct lane_time){.t = own};
}

static bool alike(const double *value, int count)
{
    bool all = true;
    for (int i = 0; i < count; i++)
        for (int lane = 1; lane < LANES; lane++)
            all &= value[i * LANES + lane] == value[i * LANES];
    return all;
}

/* Before the first step: in what do the lanes agree? */
static void begin(struct typed_lanes *lanes)
{
    unsigned char known[1 + LIMIT_VARIABLES + TERM_VALUES] = {lanes->own ? 0 : LANES_ALIKE}; /* t */
    double at[LANES];
    const double *value = lanes->input + (1 + lanes->n) * LANES;
    for (int i = 0; i < lanes->values; i++)
        known[1 + lanes->n + i] =
            alike(value + i * LANES, 1) ? LANES_FIXED | LANES_ALIKE : LANES_FIXED;
    for (int i = 0; i < lanes->terms; i++) {
        struct lane_term *term = &lanes->term[i];
        if (term->program)
            program_prepare_lanes(term->program, lanes->input, known, term->frame);
        else
            term->once = !lanes->own && !term->row->jacobian && lanes->rows == 1 &&
                         alike(term->c, TERM_COEFFICIENTS);
    }
    if (lanes->method->tableau) {
        memcpy(lanes->y, lanes->input + LANES, (size_t)lanes->n * LANES * sizeof *lanes->y);
        stages_take(lanes->weights, lanes->method->tableau, lanes->own ? 1 : lanes->h);
        slope(lanes, lane_time_of(lanes, 0, at), lanes->k);
    }
    lanes->ready = true;
}

/* ---- explicit Runge-Kutta ---- */

typedef double eight __attribute__((vector_size(64), aligned(64), may_alias));

/* z = y + sum_j share_j k_j, each [n]; h: NULL, or what the shares are of [LANES] */
INLINE void combine(const struct weights *sum, const double *h, int n, const double *k,
                    const double *y, double *z)
{
    enum { AT_ONCE = 4 };
    const eight *from = (const eight *)(const void *)y;
    eight *to = (eight *)(void *)z;
    const int size = n * LANES / 8;
    for (int q = 0; q < size; q += AT_ONCE) {
        const eight *const own = (const eight *)(const void *)h + q % (LANES / 8);
        eight total[AT_ONCE];
        const eight *slope = (const eight *)(const void *)k + sum->stage[0] * size + q;
        UNROLL for (int p = 0; p < AT_ONCE; p++) total[p] =
            (h ? own[p] * sum->weight[0] : sum->weight[0] - (eight){0}) * slope[p];
        for (int j = 1; j < sum->count; j++) {
            const double weight = sum->weight[j];
            slope = (const eight *)(const void *)k + sum->stage[j] * size + q;
            UNROLL for (int p = 0; p < AT_ONCE; p++) total[p] +=
                (h ? own[p] * weight : weight - (eight){0}) * slope[p];
        }
        UNROLL for (int p = 0; p < AT_ONCE; p++) to[q + p] = from[q + p] + total[p];
    }
}

/* Does a velocity change its sign? */
INLINE bool any_turns(const double *v0, const double *v1)
{
    uint64_t any = 0;
    for (int lane = 0; lane < LANES; lane++) {
        uint64_t a, b;
        memcpy(&a, v0 + lane, sizeof a);
        memcpy(&b, v1 + lane, sizeof b);
        any |= a ^ b;
    }
    return any >> 63;
}

/* z: the states after a step that is taken again by those that turned in it */
static __attribute__((noinline)) void turn(struct typed_lanes *lanes, double *z)
{
    const int n = lanes->n, v = n / 2 * LANES;
    double *last = lanes->k + (lanes->method->tableau->stages - 1) * n * LANES;
    for (int lane = 0; lane < LANES; lane++) {
        if (!lane_turns(lanes->y[v + lane], z[v + lane]))
            continue;
        double y[LIMIT_VARIABLES], slope[LIMIT_VARIABLES];
        for (int i = 0; i < n; i++) {
            y[i] = lanes->y[i * LANES + lane];
            slope[i] = lanes->k[i * LANES + lane];
        }
        struct step step = {.system = lanes->system[lane],
                            .t = lanes->own_t0[lane] + (double)lanes->step * lanes->own_h[lane],
                            .h = lanes->own_h[lane],
                            .y = y,
                            .work = lanes->work,
                            .kernel = lanes->scalar};
        lanes->extra[lane] += lane_turn(lanes->method, &step, slope);
        for (int i = 0; i < n; i++) {
            z[i * LANES + lane] = y[i];
            last[i * LANES + lane] = slope[i];
        }
    }
}

/* The first variable and how fast it changes. */
static void look(struct typed_lanes *lanes, double *row)
{
    const size_t size = LANES * sizeof *row;
    const double *state = lanes->input + LANES;
    memcpy(row, state, size);
    if (lanes->rows < lanes->n) {
        memcpy(row + LANES, state + lanes->rows * LANES, size);
    } else if (!lanes->method->tableau->fsal || !lanes->timed) {
        memcpy(row + LANES, lanes->k, size);
    } else { /* the last slope belongs to t + h, which rounds in another way than the time of the
                next step */
        double at[LANES];
        slope(lanes, lane_time_of(lanes, 0, at), lanes->spare);
        memcpy(row + LANES, lanes->spare, size);
    }
}

CLONES static void rk_march(struct typed_lanes *lanes, int64_t count, double *row)
{
    const struct tableau *tableau = lanes->method->tableau;
    const int n = lanes->n, stages = tableau->stages;
    const size_t size = (size_t)n * LANES * sizeof(double);
    const double *const h = lanes->own ? lanes->own_h : NULL;
    double at[LANES];
    double *z = lanes->input + LANES, *y = lanes->y, *k = lanes->k;
    for (int64_t i = 0; i < count; i++) {
        for (int s = 1; s < stages; s++) {
            combine(&lanes->weights[s], h, n, k, y, z);
            slope(lanes, lane_time_of(lanes, tableau->c[s], at), k + s * n * LANES);
        }
        if (!tableau->fsal)
            combine(&lanes->weights[0], h, n, k, y, z);
        if (lanes->turns && any_turns(y + n / 2 * LANES, z + n / 2 * LANES))
            turn(lanes, z);
        lanes->step++;
        memcpy(y, z, size);
        if (tableau->fsal)
            memcpy(k, k + (stages - 1) * n * LANES, size);
        else
            slope(lanes, lane_time_of(lanes, 0, at), k);
        if (row)
            look(lanes, row + i * 2 * LANES);
    }
}

/* ---- splittings ---- */

/* The drag's own flow over h/2 (drag_flow_apply()). */
static void flow(const struct typed_lanes *lanes, double *v)
{
    for (int i = 0; i < lanes->rows; i++, v += LANES)
        for (int lane = 0; lane < LANES; lane++) {
            const struct drag_flow half = {lanes->half[lane], lanes->half[LANES + lane],
                                           lanes->half[2 * LANES + lane]};
            v[lane] = drag_flow_apply(&half, v[lane]);
        }
}

/* As split_kick(). */
INLINE void kick(struct typed_lanes *lanes, int index, struct lane_time at, const double *w,
                 double *restrict v)
{
    const double *restrict pull = lanes->pull, *restrict drag = lanes->drag;
    const int count = lanes->rows * LANES;
    if (lanes->way.drag == DRAG_EXPLICIT) {
        forces(lanes, TERM_VELOCITY, TERM_VELOCITY, at, lanes->drag);
        for (int l = 0; l < count; l++)
            v[l] += w[l % LANES] * (pull[l] + drag[l]);
    } else if (lanes->way.drag == DRAG_EXACT && !lanes->way.around) {
        const double *lost = lanes->frozen + 2 * index * LANES, *weight = lost + LANES;
        for (int l = 0; l < count; l++)
            v[l] += pull[l] * weight[l % LANES] - v[l] * lost[l % LANES];
    } else {
        for (int l = 0; l < count; l++)
            v[l] += w[l % LANES] * pull[l];
    }
}

CLONES static void split_march(struct typed_lanes *lanes, int64_t count, double *row)
{
    const struct split_way *way = &lanes->way;
    const struct splitting *splitting = way->splitting;
    const int max = lanes->rows * LANES;
    double *restrict q = lanes->input + LANES, *restrict v = q + max;
    for (int64_t i = 0; i < count; i++) {
        double time[LANES], w[LANES];
        struct lane_time at = lane_time_of(lanes, 0, time);
        if (way->around)
            flow(lanes, v);
        for (int index = 0; index < splitting->count; index++) {
            const double weight = splitting_weight(splitting, index);
            for (int lane = 0; lane < LANES; lane++)
                w[lane] = weight * lanes->own_h[lane];
            if ((index % 2 == 0) == splitting->kick_first) {
                if (!(index == 0 && way->continues && lanes->step > 0))
                    forces(lanes, TERM_VELOCITY, 0, at, lanes->pull);
                kick(lanes, index, at, w, v);
            } else {
                for (int l = 0; l < max; l++)
                    q[l] += w[l % LANES] * v[l];
                at.all += weight * lanes->h;
                for (int lane = 0; lane < LANES && at.t; lane++)
                    time[lane] += w[lane];
            }
        }
        if (way->around)
            flow(lanes, v);
        lanes->step++;
        if (row)
            look(lanes, row + i * 2 * LANES);
    }
}

/* ---- what callers use ---- */

void typed_lanes_march(struct typed_lanes *lanes, int64_t count, double *row)
{
    if (!lanes->ready)
        begin(lanes);
    (lanes->method->tableau ? rk_march : split_march)(lanes, count, row);
}

void typed_lanes_row(struct typed_lanes *lanes, double *row)
{
    if (!lanes->ready)
        begin(lanes);
    look(lanes, row);
}
