/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What callers use of lanes: which systems go in them, their steps, the drive at the times of
 * these. */
#define UNROLL
#include <hooke/base/elementary.h>

#include "method/kernel/lane/state.h"
#include "method/kernel/lanes.h"
#include "method/step/irk_body.h"
#include "method/step/split_body.h"

#include <assert.h>
#include <stdlib.h>

#define LANE_CASE(shape)                                                                           \
    case 0u TERMS_OF_##shape(FORCE_AT):                                                            \
        return LANE_##shape;

/* ---- the drive ---- */

static int times(const struct method *method)
{
    assert(method->tableau || method->implicit || method->splitting); /* others have no lanes */
    return method->tableau    ? method->tableau->stages
           : method->implicit ? method->implicit->stages
                              : method->splitting->count;
}

/* [times] Times of the step as the bodies compute them; where nobody looks at the drive, NAN. */
static void step_times(const struct lanes *lanes, double t, double *time)
{
    const struct method *method = lanes->method;
    const double *const c = method->tableau    ? method->tableau->c
                            : method->implicit ? method->implicit->c
                                               : NULL;
    for (int place = 0; place < times(method); place++) {
        time[place] = t;
        if (c) {
            time[place] = t + c[place] * lanes->h;
        } else if ((place % 2 == 0) != method->splitting->kick_first) {
            time[place] = (double)NAN;
            t += splitting_weight(method->splitting, place) * lanes->h;
        }
    }
}

static void table_step(const struct lanes *lanes, double t, double *value)
{
    step_times(lanes, t, value);
    for (int place = 0; place < times(lanes->method); place++)
        if (value[place] == value[place])
            value[place] = fixed_cos(lanes->omega[0] * value[place] + lanes->phase[0]);
}

static bool driven_alike(const struct lanes *lanes)
{
    bool alike = true;
    for (int lane = 1; lane < LANES; lane++)
        alike &= lanes->omega[lane] == lanes->omega[0] && lanes->phase[lane] == lanes->phase[0];
    return alike;
}

/* Values for march->count steps from march->first on, as many as there is room for. */
static void table_steps(struct lanes *lanes, struct lane_march *march)
{
    const int64_t max = TABLE_ROOM / march->times;
    const bool same = lanes->table.method == lanes->method &&
                      lanes->table.omega == lanes->omega[0] &&
                      lanes->table.phase == lanes->phase[0] && lanes->table.t0 == lanes->t0 &&
                      lanes->table.h == lanes->h;
    const int64_t behind = march->first - lanes->table.from;
    if (!same || behind < 0 || behind > lanes->table.count || behind == max) {
        lanes->table.method = lanes->method;
        lanes->table.omega = lanes->omega[0];
        lanes->table.phase = lanes->phase[0];
        lanes->table.t0 = lanes->t0;
        lanes->table.h = lanes->h;
        lanes->table.from = march->first;
        lanes->table.count = 0;
    }
    const int64_t from = lanes->table.from, end = march->first + march->count;
    while (lanes->table.count < max && from + lanes->table.count < end) {
        const int64_t i = lanes->table.count++;
        table_step(lanes, lanes->t0 + (double)(from + i) * lanes->h,
                   lanes->table.value + i * march->times);
    }
    const int64_t there = from + lanes->table.count - march->first;
    march->count = march->count < there ? march->count : there;
    march->cosine = lanes->table.value + (march->first - from) * march->times;
}

/* Each lane's own: as many steps as there are rows for. */
static void own_steps(struct lanes *lanes, const struct lane_width *width, struct lane_march *march)
{
    const int most = DRIVE_ROWS / march->times;
    double at = (double)NAN, time[STAGES_MAX > WEIGHTS_MAX ? STAGES_MAX : WEIGHTS_MAX];
    int rows = 0;
    march->count = march->count < most ? march->count : most;
    for (int64_t i = 0; i < march->count; i++) {
        step_times(lanes, lanes->t0 + (double)(march->first + i) * lanes->h, time);
        for (int place = 0; place < march->times; place++) {
            if (time[place] == time[place] && time[place] != at) {
                at = time[place];
                width->drives(lanes, at, lanes->table.value + rows++ * LANES);
            }
            lanes->row_of[i * march->times + place] = rows - 1;
        }
    }
    lanes->table.method = NULL; /* it holds something else now */
    march->cosine = lanes->table.value;
    march->row_of = lanes->row_of;
}

/* The same where each lane has its own times, too. */
static void own_times(struct lanes *lanes, const struct lane_width *width, struct lane_march *march)
{
    const struct method *method = lanes->method;
    const int most = DRIVE_ROWS / march->times;
    const double *const c = method->tableau    ? method->tableau->c
                            : method->implicit ? method->implicit->c
                                               : NULL;
    double t[LANES], at[LANES];
    int rows = 0;
    march->count = march->count < most ? march->count : most;
    for (int64_t i = 0; i < march->count; i++) {
        for (int lane = 0; lane < LANES; lane++)
            t[lane] = lanes->own_t0[lane] + (double)(march->first + i) * lanes->own_h[lane];
        for (int place = 0; place < march->times; place++) {
            const bool looks = c ? place == 0 || c[place] != c[place - 1]
                                 : (place % 2 == 0) == method->splitting->kick_first;
            const double w = c ? c[place] : looks ? 0 : splitting_weight(method->splitting, place);
            for (int lane = 0; lane < LANES; lane++)
                at[lane] = t[lane] + w * lanes->own_h[lane];
            if (looks)
                width->own_drives(lanes, at, lanes->table.value + rows++ * LANES);
            if (!c)
                memcpy(t, at, sizeof t);
            lanes->row_of[i * march->times + place] = rows - 1;
        }
    }
    lanes->table.method = NULL;
    march->cosine = lanes->table.value;
    march->row_of = lanes->row_of;
}

static void find_ranges(struct lanes *lanes)
{
    for (int lane = 0; lane < LANES; lane++) {
        struct lane_range *range = &lanes->range[lane / LANE_GROUP];
        const double omega = lanes->omega[lane], phase = lanes->phase[lane];
        if (lane % LANE_GROUP == 0)
            *range = (struct lane_range){{omega, omega}, {phase, phase}};
        range->omega[0] = omega < range->omega[0] ? omega : range->omega[0];
        range->omega[1] = omega > range->omega[1] ? omega : range->omega[1];
        range->phase[0] = phase < range->phase[0] ? phase : range->phase[0];
        range->phase[1] = phase > range->phase[1] ? phase : range->phase[1];
    }
}

/* ---- what callers use ---- */

struct lanes *lanes_create(void)
{
    struct lanes *lanes = aligned_alloc(64, (sizeof *lanes + 63) / 64 * 64);
    if (lanes) {
        memset(lanes, 0, sizeof *lanes);
        lanes->most = LANE_WIDEST;
    }
    return lanes;
}

void lanes_narrow(struct lanes *lanes, int most)
{
    lanes->most = most;
}

void lanes_destroy(struct lanes *lanes)
{
    if (lanes)
        typed_lanes_destroy(lanes->typed);
    free(lanes);
}

int lane_shape_of(const struct system *system)
{
    switch (forces_of(system)) {
        LANE_SHAPES(LANE_CASE)
    default:
        return -1;
    }
}

bool lanes_fit(const struct method *method, const struct system *system, enum drag drag, double h)
{
    const bool splits =
        method->splitting && (!system->velocity || drag == DRAG_EXPLICIT || drag == DRAG_EXACT);
    const bool solves = method->implicit && method->implicit->diagonal != 0;
    if (!(h > 0) || !(method->tableau || splits || solves) || system->oscillator.quadratic < 0 ||
        method_meets_switches(method, system))
        return false;
    if (system->model->typed)
        return !solves && typed_lanes_fit(method, system, drag);
    return lane_shape_of(system) >= 0 && (splits || method_work_size(method, N) <= WORK_MOST);
}

bool lanes_alike(const struct system *a, const struct system *b)
{
    bool alike = a->model == b->model && a->terms == b->terms;
    for (int i = 0; alike && i < a->terms; i++) /* typed: those of the same programs */
        alike = a->term[i].row == b->term[i].row;
    return alike;
}

bool lanes_begin(struct lanes *lanes, const struct method *method, enum drag drag,
                 const struct system *like, double h)
{
    lanes->method = method;
    lanes->drag = drag;
    lanes->shape = like->model->typed ? -1 : lane_shape_of(like);
    lanes->t0 = like->t0;
    lanes->h = h;
    lanes->step = 0;
    lanes->divides = lanes->turns = lanes->driven = lanes->own = false;
    memset(lanes->more, 0, sizeof lanes->more);
    memset(lanes->carried, 0, sizeof lanes->carried);
    memset(lanes->omega, 0, sizeof lanes->omega);
    memset(lanes->phase, 0, sizeof lanes->phase);
    return lanes->shape >= 0 || typed_lanes_begin(&lanes->typed, method, drag, like, h);
}

void lanes_set(struct lanes *lanes, int lane, const struct system *system)
{
    lanes_set_step(lanes, lane, system, lanes->h);
}

void lanes_set_step(struct lanes *lanes, int lane, const struct system *system, double h)
{
    const struct method *method = lanes->method;
    if (lanes->shape < 0) {
        typed_lanes_set(lanes->typed, lane, system, h);
        return;
    }
    lanes->own_t0[lane] = system->t0;
    lanes->own_h[lane] = h;
    lanes->own |= system->t0 != lanes->t0 || h != lanes->h;
    for (int i = 0; i < system->terms; i++)
        for (int j = 0; j < LANE_COEFFICIENTS; j++)
            lanes->c[i][j][lane] = system->term[i].c[j];
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->flags & TERM_TIME) { /* the drive: c0 cos(c1 t + c2) */
            lanes->driven = true;
            lanes->omega[lane] = system->term[i].c[1];
            lanes->phase[lane] = system->term[i].c[2];
        }
    lanes->y[0][lane] = system->start[0];
    lanes->y[1][lane] = system->start[1];
    lanes->system[lane] = system;
    lanes->damping[lane] = system->oscillator.damping;
    lanes->stiffness[lane] = system->oscillator.stiffness;
    lanes->quadratic[lane] = system->oscillator.quadratic;
    for (int i = 0; i < 2; i++)
        lanes->scale[i][lane] = system->scale[i];
    if (lane == 0 && method_turns(method, system)) {
        lanes->turns = true;
        lanes->scalar = method_step_kernel(method, system);
    }
    if (!method->splitting || !system->velocity || lanes->drag != DRAG_EXACT)
        return;
    struct split_way way;
    split_choose(&way, method, lanes->drag);
    const struct drag_flow half = oscillator_drag_flow(&system->oscillator, h / 2);
    lanes->keep[lane] = half.keep;
    lanes->min[lane] = half.min;
    lanes->pull[lane] = half.pull;
    lanes->divides |= half.min != 1 || half.pull != 0;
    for (int i = 0; !way.around && i < way.splitting->count; i++) {
        const struct frozen frozen =
            frozen_over(&system->oscillator, splitting_weight(way.splitting, i) * h);
        lanes->frozen[i].lost[lane] = frozen.lost;
        lanes->frozen[i].pull[lane] = frozen.pull;
    }
}

static void march_prepare(const struct lanes *lanes, struct lane_march *march)
{
    const struct tableau *tableau = lanes->method->tableau;
    const struct splitting *splitting = lanes->method->splitting;
    const struct implicit_tableau *implicit = lanes->method->implicit;
    const double h = lanes->own ? 1 : lanes->h; /* kernels know the lanes' own */
    march->times = times(lanes->method);
    march->accurate = implicit && stiffly_accurate(implicit);
    march->chain = tableau    ? tableau->stages == 4 && !tableau->fsal
                   : implicit ? implicit->stages == 1
                              : splitting->count == 2 && !splitting->kick_first;
    for (int i = 0; splitting && i < splitting->count; i++)
        march->weight[i] = splitting_weight(splitting, i) * h;
    if (!tableau)
        return;
    weights_take(&march->weights[0], tableau->b, tableau->stages, h);
    march->chain = march->chain && march->weights[0].count == 4;
    for (int s = 1; s < tableau->stages; s++) {
        weights_take(&march->weights[s], tableau_row(tableau, s), s, h);
        march->chain =
            march->chain && march->weights[s].count == 1 && march->weights[s].stage[0] == s - 1;
    }
}

void lanes_march(struct lanes *lanes, int64_t count, double *row)
{
    if (lanes->shape < 0) {
        typed_lanes_march(lanes->typed, count, row);
        return;
    }
    const struct lane_width width = lanes_width(lanes->most);
    const struct method *method = lanes->method;
    lane_kernel *const kernel = width.kernels[lanes->shape][method->implicit    ? LANE_IMPLICIT
                                                            : method->splitting ? LANE_SPLIT
                                                                                : LANE_EXPLICIT];
    struct lane_march march;
    march_prepare(lanes, &march);
    march.drive = !lanes->driven                       ? DRIVE_NONE
                  : !lanes->own && driven_alike(lanes) ? DRIVE_ALIKE
                                                       : DRIVE_OWN;
    if (march.drive == DRIVE_OWN && lanes->step == 0)
        find_ranges(lanes);
    while (count > 0) {
        march.first = lanes->step;
        march.count = count;
        march.row = row;
        if (march.drive == DRIVE_ALIKE)
            table_steps(lanes, &march);
        else if (march.drive == DRIVE_OWN)
            (lanes->own ? own_times : own_steps)(lanes, &width, &march);
        kernel(lanes, &march);
        lanes->step += march.count;
        count -= march.count;
        row = row ? row + march.count * 2 * LANES : NULL;
    }
}

void lanes_row(struct lanes *lanes, double *row)
{
    if (lanes->shape < 0)
        typed_lanes_row(lanes->typed, row);
    else
        memcpy(row, lanes->y, sizeof lanes->y);
}

void lanes_state(const struct lanes *lanes, int lane, double *y)
{
    if (lanes->shape < 0) {
        typed_lanes_state(lanes->typed, lane, y);
        return;
    }
    y[0] = lanes->y[0][lane];
    y[1] = lanes->y[1][lane];
}

int64_t lanes_evals(const struct lanes *lanes, int lane)
{
    if (lanes->shape < 0)
        return typed_lanes_evals(lanes->typed, lane);
    const struct tableau *tableau = lanes->method->tableau;
    if (tableau)
        return lane_evals(lanes->step, tableau->stages, tableau->fsal) + lanes->more[lane];
    if (lanes->method->implicit)
        return lanes->more[lane];
    struct split_way way;
    split_choose(&way, lanes->method, lanes->drag);
    return lane_evals(lanes->step, way.kicks, way.continues);
}

bool lanes_carry(const struct method *method, enum drag drag)
{
    struct split_way way;
    if (method->tableau)
        return method->tableau->fsal;
    if (method->implicit)
        return method->implicit->fsal;
    split_choose(&way, method, drag);
    return way.continues;
}
