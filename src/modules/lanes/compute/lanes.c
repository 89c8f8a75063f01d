/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Interface of the lanes (lanes.h): which systems fit, memory, initialization of each lane, and the
 * choice of the function that steps. */
#include "modules/lanes/compute/state.h"

#include "scene/model/forces.h"

#include <hooke/scene/typed.h>

#include <stdlib.h>

enum { ROOM_MAX = 1 << 18 /* [double] lanes that need more memory are not used */ };

/* ---- memory ---- */

/* Sets *where to the next `count` doubles of the memory, aligned to 64 bytes, or only counts them
 * if there is no memory yet. */
static void lanes_take_memory(struct lanes *lanes, double **where, size_t count)
{
    *where = lanes->memory ? lanes->memory + lanes->used : NULL;
    lanes->used += (count + 7) / 8 * 8; /* aligned */
}

static int stages_of(const struct method *method)
{
    if (method->tableau)
        return method->tableau->stages;
    return method->implicit ? method->implicit->stages : 0;
}

/* Divides the memory among the arrays that the method needs; without memory only lanes->used is
 * computed. */
static void divide_memory(struct lanes *lanes)
{
    const size_t n = (size_t)lanes->n, line = LANE_COUNT;
    const struct method *method = lanes->method;
    lanes->used = 0;
    lanes_take_memory(lanes, &lanes->input, (1 + n + (size_t)lanes->values) * line);
    lanes_take_memory(lanes, &lanes->spare, n * line);
    lanes->state = lanes->memory ? lanes->input + line : NULL;
    if (method->splitting) {
        const size_t weights =
            lanes->way.drag == DRAG_EXACT ? (size_t)lanes->way.splitting->count : 0;
        lanes_take_memory(lanes, &lanes->pull, n / 2 * line);
        lanes_take_memory(lanes, &lanes->drags, n / 2 * line);
        lanes_take_memory(lanes, &lanes->half, 3 * line);
        lanes_take_memory(lanes, &lanes->frozen, weights * 2 * line);
    } else {
        lanes_take_memory(lanes, &lanes->y, n * line);
        lanes_take_memory(lanes, &lanes->k, (size_t)(stages_of(method) + 1) * n * line);
        lanes_take_memory(lanes, &lanes->excess, n * line);
        lanes_take_memory(lanes, &lanes->min, n * line);
        lanes_take_memory(lanes, &lanes->given, n * line);
        lanes_take_memory(lanes, &lanes->scale, n * line);
        lanes_take_memory(lanes, &lanes->work, method_work_size(method, lanes->n));
    }
    for (int i = 0; i < lanes->parts; i++)
        lanes_take_memory(lanes, &lanes->part[i].frame,
                          program_frame_lanes(lanes->part[i].program));
    if (lanes->slopes.program)
        lanes_take_memory(lanes, &lanes->slopes.frame, program_frame_lanes(lanes->slopes.program));
}

/* Notes what all lanes have in common: method, drag, dimensions, kinds of forces. Returns false if
 * out of memory. */
static bool describe_lanes(struct lanes *lanes, const struct method *method,
                           const struct system *system, enum drag drag, double h)
{
    lanes->method = method;
    lanes->drag = drag;
    lanes->n = system->n;
    lanes->rows = system->order == 2 ? system->n / 2 : system->n;
    lanes->t0 = system->t0;
    lanes->h = h;
    lanes->timed = !system->autonomous;
    lanes->turns = method_turns(method, system);
    lanes->closed = system->oscillator.whole;
    lanes->dragged = system->oscillator.quadratic != 0;
    if (method->splitting)
        split_choose(&lanes->way, method, system->velocity ? drag : DRAG_DEFAULT);
    return lanes_describe_forces(lanes, system);
}

/* Returns true if lanes of such systems, with the programs of typed expressions, need at most
 * ROOM_MAX numbers. */
static bool has_room(const struct method *method, const struct system *system)
{
    size_t numbers = (size_t)((stages_of(method) + 10) * system->n + TERM_VALUES) * LANE_COUNT;
    int ignored;
    for (int i = 0; i < system->terms; i++) {
        const struct program *program = term_program(&system->term[i], &ignored);
        numbers += program ? program_frame_lanes(program) : 0;
    }
    return numbers <= ROOM_MAX;
}

/* Returns true if systems of this kind can be stepped in lanes by the method with step h. */
bool lanes_fit(const struct method *method, const struct system *system, enum drag drag, double h)
{
    const bool splits =
        method->splitting && (!system->velocity || drag == DRAG_EXPLICIT || drag == DRAG_EXACT);
    const bool solves = method->implicit && method->implicit->diagonal != 0 &&
                        !system->model->typed && (system->oscillator.whole || !system->linear);
    /* || Excluded are negative steps, other methods, quadratic damping that drives, and switches.
     */
    if (!(h > 0) || !(method->tableau || splits || solves) || system->oscillator.quadratic < 0 ||
        (method->tableau && method->tableau->stages > WEIGHT_STAGES) ||
        method_meets_switches(method, system))
        return false;
    if (!terms_have_text(system) && (!system->model->typed || typed_base(system->model)))
        return false;
    return !system->model->typed || has_room(method, system);
}

bool lanes_alike(const struct system *a, const struct system *b)
{
    bool alike = a->model == b->model && a->terms == b->terms;
    for (int i = 0; alike && i < a->terms; i++) /* typed terms must have the same programs */
        alike = a->term[i].row == b->term[i].row;
    return alike;
}

struct lanes *lanes_create(void)
{
    return calloc(1, sizeof(struct lanes));
}

/* Frees the lanes; NULL is allowed. */
void lanes_destroy(struct lanes *lanes)
{
    if (lanes) {
        lanes_destroy_programs(&lanes->built_in);
        free(lanes->memory);
    }
    free(lanes);
}

/* Prepares lanes for systems like this one; memory is kept if it is large enough. Returns false if
 * out of memory. */
bool lanes_begin(struct lanes *lanes, const struct method *method, enum drag drag,
                 const struct system *like, double h)
{
    if (!describe_lanes(lanes, method, like, drag, h))
        return false;
    divide_memory(lanes);
    if (lanes->used > lanes->size) {
        free(lanes->memory);
        lanes->size = lanes->used;
        lanes->memory = aligned_alloc(64, lanes->size * sizeof *lanes->memory);
        if (!lanes->memory) {
            lanes->size = 0;
            return false;
        }
    }
    divide_memory(lanes);
    lanes->step = 0;
    lanes->ready = lanes->own = lanes->adapts = false;
    lanes->scalar = lanes->turns ? method_step_kernel(method, like) : NULL;
    return true;
}

/* ---- each lane ---- */

/* Stores the factors of one lane's exact drag: its flow over h/2, and its part in each kick. */
static void set_drag(struct lanes *lanes, int lane, const struct oscillator *oscillator, double h)
{
    const struct split_way *way = &lanes->way;
    const struct drag_flow half = oscillator_drag_flow(oscillator, h / 2);
    const double flow[] = {half.keep, half.min, half.pull};
    lane_put(3, flow, lane, lanes->half);
    for (int i = 0; i < way->splitting->count; i++) {
        const struct frozen frozen =
            frozen_over(oscillator, splitting_weight(way->splitting, i) * h);
        const double kick[] = {frozen.lost, frozen.pull};
        lane_put(2, kick, lane, lanes->frozen + 2 * i * LANE_COUNT);
    }
}

void lanes_set(struct lanes *lanes, int lane, const struct system *system)
{
    lanes_set_step(lanes, lane, system, lanes->h);
}

/* Starts a lane at the system's initial state with steps of h [s]. lanes->own becomes true if its
 * h or initial time differs from those of lanes_begin(), because times are then computed lane by
 * lane. Exact drag has coefficients that depend on h. */
void lanes_set_step(struct lanes *lanes, int lane, const struct system *system, double h)
{
    lane_put(lanes->n, system->start, lane, lanes->state);
    lanes_set_values(lanes, lane, system);
    lanes->system[lane] = system;
    lanes->evals[lane] = 0;
    lanes->own_t0[lane] = system->t0;
    lanes->own_h[lane] = h;
    lanes->own |= system->t0 != lanes->t0 || h != lanes->h;
    lanes->damping[lane] = system->oscillator.damping;
    lanes->stiffness[lane] = system->oscillator.stiffness;
    lanes->quadratic[lane] = system->oscillator.quadratic;
    if (lanes->method->splitting && lanes->way.drag == DRAG_EXACT)
        set_drag(lanes, lane, &system->oscillator, h);
}

/* Prepares the first step, when all lanes are set. */
static void lanes_prepare_steps(struct lanes *lanes)
{
    const struct method *method = lanes->method;
    double own[LANE_COUNT];
    lanes->own |= lanes->adapts;
    lanes_prepare_forces(lanes);
    lanes->ready = true;
    if (method->splitting)
        return;
    const size_t numbers = (size_t)lanes->n * LANE_COUNT;
    memcpy(lanes->y, lanes->state, numbers * sizeof *lanes->y);
    memset(lanes->k, 0, (size_t)stages_of(method) * numbers * sizeof *lanes->k);
    if (!method->tableau)
        return;
    stages_take(lanes->weights, method->tableau, lanes->own ? 1 : lanes->h);
    if (!lanes->adapts)
        lanes_slope(lanes, lanes_time(lanes, 0, own), lanes->k);
}

/* Makes `count` steps in all lanes, by a kernel for the forces if there is one, else by the family
 * of the method. row receives values after each step, or is NULL. */
void lanes_march(struct lanes *lanes, int64_t count, double *row)
{
    const struct method *method = lanes->method;
    if (!lanes->ready)
        lanes_prepare_steps(lanes);
    if (lanes_march_shape(lanes, count, row))
        return;
    if (method->tableau)
        lanes_march_rk(lanes, count, row);
    else if (method->splitting)
        lanes_march_split(lanes, count, row);
    else
        lanes_march_implicit(lanes, count, row);
}

void lanes_state(const struct lanes *lanes, int lane, double *y)
{
    lane_get(lanes->n, lanes->adapts ? lanes->y : lanes->state, lane, y);
}

/* Returns the evaluations of steps with `each` of them; if `again`, one of each step is also the
 * first of the next. */
static int64_t steps_evals(int64_t steps, int each, bool again)
{
    return steps * (each - again) + (again && steps > 0);
}

/* Returns the number of evaluations of the force in a lane. */
int64_t lanes_evals(const struct lanes *lanes, int lane)
{
    const struct tableau *tableau = lanes->method->tableau;
    if (lanes->method->splitting)
        return steps_evals(lanes->step, lanes->way.kicks, lanes->way.continues);
    return (tableau ? steps_evals(lanes->step, tableau->stages, tableau->fsal) : 0) +
           lanes->evals[lane];
}

/* Returns true if a step reuses an evaluation of the previous one. */
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
