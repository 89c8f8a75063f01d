/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes in lanes: what they need to be stepped, which systems they take, their room. */
#include <hooke/scene/typed.h>
#include "method/kernel/typed_lanes.h"

#include <stdlib.h>

enum { ROOM_MAX = 1 << 18 /* [double] what is larger goes alone */ };

/* ---- room ---- */

static void take(struct typed_lanes *lanes, double **where, size_t count)
{
    *where = lanes->memory ? lanes->memory + lanes->used : NULL;
    lanes->used += (count + 7) / 8 * 8; /* aligned */
}

static void lay_out(struct typed_lanes *lanes)
{
    const size_t n = (size_t)lanes->n;
    const struct tableau *tableau = lanes->method->tableau;
    lanes->used = 0;
    take(lanes, &lanes->input, (1 + n + (size_t)lanes->values) * LANES);
    take(lanes, &lanes->spare, n * LANES);
    take(lanes, &lanes->own_h, LANES);
    if (tableau) {
        take(lanes, &lanes->y, n * LANES);
        take(lanes, &lanes->k, (size_t)tableau->stages * n * LANES);
        take(lanes, &lanes->work, method_work_size(lanes->method, lanes->n));
    } else {
        const size_t weights =
            lanes->way.drag == DRAG_EXACT ? (size_t)lanes->way.splitting->count : 0;
        take(lanes, &lanes->pull, n / 2 * LANES);
        take(lanes, &lanes->drag, n / 2 * LANES);
        take(lanes, &lanes->half, (size_t)3 * LANES);
        take(lanes, &lanes->frozen, weights * 2 * LANES);
    }
    for (int i = 0; i < lanes->terms; i++) {
        struct lane_term *term = &lanes->term[i];
        if (term->program)
            take(lanes, &term->frame, program_frame_lanes(term->program));
        else
            take(lanes, &term->c, (size_t)TERM_COEFFICIENTS * LANES);
    }
}

/* All but the room. The whole force at once, where there is such a program and the method wants
 * nothing else. */
static void describe(struct typed_lanes *lanes, const struct method *method,
                     const struct system *system, enum drag drag, double h)
{
    const bool whole = method->tableau && system->typed.row->add;
    lanes->method = method;
    lanes->n = system->n;
    lanes->rows = system->order == 2 ? system->n / 2 : system->n;
    lanes->t0 = system->t0;
    lanes->h = h;
    lanes->timed = !system->autonomous;
    lanes->turns = method_turns(method, system);
    lanes->terms = whole ? 1 : system->terms;
    term_program(&system->typed, &lanes->values);
    for (int i = 0; i < lanes->terms; i++) {
        const struct bound_term *bound = whole ? &system->typed : &system->term[i];
        int values;
        lanes->term[i] = (struct lane_term){
            .program = term_program(bound, &values), .row = bound->row, .index = i};
    }
    if (method->splitting)
        split_choose(&lanes->way, method, system->velocity ? drag : DRAG_DEFAULT);
}

bool typed_lanes_fit(const struct method *method, const struct system *system, enum drag drag)
{
    struct typed_lanes lanes = {0};
    if (method->tableau && method->tableau->stages > WEIGHT_STAGES)
        return false;
    describe(&lanes, method, system, drag, 0);
    lay_out(&lanes);
    return lanes.used <= ROOM_MAX;
}

void typed_lanes_destroy(struct typed_lanes *lanes)
{
    if (lanes)
        free(lanes->memory);
    free(lanes);
}

bool typed_lanes_begin(struct typed_lanes **made, const struct method *method, enum drag drag,
                       const struct system *like, double h)
{
    if (!*made && !(*made = calloc(1, sizeof **made)))
        return false;
    struct typed_lanes *lanes = *made;
    describe(lanes, method, like, drag, h);
    lay_out(lanes);
    if (lanes->used > lanes->size) {
        free(lanes->memory);
        lanes->size = lanes->used;
        lanes->memory = aligned_alloc(64, lanes->size * sizeof *lanes->memory);
        if (!lanes->memory) {
            lanes->size = 0;
            return false;
        }
    }
    lay_out(lanes);
    lanes->step = 0;
    lanes->ready = lanes->own = false;
    for (int i = 0; i < lanes->terms; i++)
        lanes->term[i].add = lanes->term[i].program ? NULL : lane_term(lanes->term[i].row);
    lanes->scalar = lanes->turns ? method_step_kernel(method, like) : NULL;
    return true;
}

/* ---- each lane ---- */

static void set_drag(struct typed_lanes *lanes, int lane, const struct oscillator *oscillator,
                     double h)
{
    const struct split_way *way = &lanes->way;
    const struct drag_flow half = oscillator_drag_flow(oscillator, h / 2);
    lanes->half[lane] = half.keep;
    lanes->half[LANES + lane] = half.min;
    lanes->half[2 * LANES + lane] = half.pull;
    for (int i = 0; i < way->splitting->count; i++) {
        const struct frozen frozen =
            frozen_over(oscillator, splitting_weight(way->splitting, i) * h);
        lanes->frozen[2 * i * LANES + lane] = frozen.lost;
        lanes->frozen[(2 * i + 1) * LANES + lane] = frozen.pull;
    }
}

void typed_lanes_set(struct typed_lanes *lanes, int lane, const struct system *system, double h)
{
    double *state = lanes->input + LANES, *value = state + lanes->n * LANES;
    for (int i = 0; i < lanes->n; i++)
        state[i * LANES + lane] = system->start[i];
    for (int i = 0; i < lanes->values; i++)
        value[i * LANES + lane] = system->typed.c[1 + i];
    for (int i = 0; i < lanes->terms; i++)
        for (int j = 0; j < TERM_COEFFICIENTS && !lanes->term[i].program; j++)
            lanes->term[i].c[j * LANES + lane] = system->term[i].c[j];
    lanes->system[lane] = system;
    lanes->extra[lane] = 0;
    lanes->own_t0[lane] = system->t0;
    lanes->own_h[lane] = h;
    lanes->own |= system->t0 != lanes->t0 || h != lanes->h;
    if (lanes->method->splitting && lanes->way.drag == DRAG_EXACT)
        set_drag(lanes, lane, &system->oscillator, h);
}

void typed_lanes_state(const struct typed_lanes *lanes, int lane, double *y)
{
    for (int i = 0; i < lanes->n; i++)
        y[i] = lanes->input[(1 + i) * LANES + lane];
}

int64_t typed_lanes_evals(const struct typed_lanes *lanes, int lane)
{
    const struct tableau *tableau = lanes->method->tableau;
    return tableau ? lane_evals(lanes->step, tableau->stages, tableau->fsal) + lanes->extra[lane]
                   : lane_evals(lanes->step, lanes->way.kicks, lanes->way.continues);
}
