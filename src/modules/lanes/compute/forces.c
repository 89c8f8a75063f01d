/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces in lanes: programs of typed expressions and of the built-in terms' texts, evaluated for
 * all lanes at once. */
#include "modules/lanes/compute/state.h"

#include "scene/model/forces.h"

#include <hooke/base/numeric.h>
#include <hooke/scene/typed.h>

/* ---- which programs ---- */

void lanes_destroy_programs(struct built_in_programs *programs)
{
    for (int i = 0; i < LANE_SUMS; i++)
        program_destroy(programs->sum[i]);
    program_destroy(programs->slopes);
    *programs = (struct built_in_programs){.terms = 0};
}

/* Returns true if the programs were made of these terms, with values from name `first` on. */
static bool is_known(const struct built_in_programs *programs, const struct system *system,
                     int first)
{
    bool known = programs->terms == system->terms && programs->first == first;
    for (int i = 0; known && i < system->terms; i++)
        known = programs->row[i] == system->term[i].row;
    return known;
}

/* Returns true if the system has a built-in term whose flags under `mask` are `wanted`. */
static bool has_built_in(const struct system *system, unsigned mask, unsigned wanted)
{
    for (int i = 0; i < system->terms; i++)
        if (system->term[i].row->bind && (system->term[i].row->flags & mask) == wanted)
            return true;
    return false;
}

/* Flags that choose the terms of each sum: all, those without velocity, those with velocity. */
static const unsigned sum_mask[LANE_SUMS] = {0, TERM_VELOCITY, TERM_VELOCITY},
                      sum_wanted[LANE_SUMS] = {0, 0, TERM_VELOCITY};

/* Makes the programs of the built-in terms, unless those of the previous systems are the same.
 * Returns false if out of memory. */
static bool make_programs(struct built_in_programs *programs, const struct system *system,
                          int first)
{
    struct error error;
    if (is_known(programs, system, first))
        return true;
    lanes_destroy_programs(programs);
    for (int i = 0; i < LANE_SUMS; i++)
        if (has_built_in(system, sum_mask[i], sum_wanted[i]) &&
            !(programs->sum[i] =
                  terms_program(system, sum_mask[i], sum_wanted[i], first, false, &error)))
            return false;
    if (programs->sum[SUM_ALL] &&
        !(programs->slopes = terms_program(system, 0, 0, first, true, &error)))
        return false;
    for (int i = 0; i < system->terms; i++)
        programs->row[i] = system->term[i].row;
    programs->terms = system->terms;
    programs->first = first;
    return true;
}

/* Adds a program to the list lanes->part of programs whose results are added up to the force; NULL
 * is ignored. `sums` has the bit 1 << s for each sum s of enum lane_sum to which the program
 * contributes. */
static void add_part(struct lanes *lanes, const struct program *program, unsigned sums)
{
    if (program)
        lanes->part[lanes->parts++] = (struct lane_part){.program = program, .sums = sums};
}

/* Lists the programs that compute the system's forces in lanes->part: one program of all forces if
 * the system has one and the method needs no separate sums (`whole` is NULL for splittings), else
 * those of the built-in terms, one for each sum, and one for each typed term, which belongs to
 * SUM_ALL and to SUM_DRAG or SUM_FORCE. lanes->slopes.program computes all derivatives at once, or
 * is NULL. `ignored` receives numbers of values that are known already. Returns false if out of
 * memory. */
bool lanes_describe_forces(struct lanes *lanes, const struct system *system)
{
    const struct bound_term *const whole = lanes->method->splitting ? NULL : system_whole(system);
    int ignored;
    lanes->parts = lanes->typed_values = 0;
    lanes->slopes.program = NULL;
    if (system->typed.row)
        term_program(&system->typed, &lanes->typed_values);
    lanes->values = lanes->typed_values;
    if (whole) {
        add_part(lanes, term_program(whole, &ignored), 1 << SUM_ALL);
        return true;
    }
    if (has_built_in(system, 0, 0)) {
        const int first = 1 + lanes->n + lanes->typed_values;
        lanes->values += TERM_COEFFICIENTS * system->terms;
        if (!make_programs(&lanes->built_in, system, first))
            return false;
        for (int i = 0; i < LANE_SUMS; i++)
            add_part(lanes, lanes->built_in.sum[i], 1u << i);
        lanes->slopes.program = lanes->built_in.slopes;
    }
    for (int i = 0; i < system->terms; i++)
        add_part(lanes, term_program(&system->term[i], &ignored),
                 1 << SUM_ALL |
                     1 << (system->term[i].row->flags & TERM_VELOCITY ? SUM_DRAG : SUM_FORCE));
    return true;
}

/* ---- values ---- */

/* Copies a system's values of typed names and coefficients of built-in terms to one lane. */
void lanes_set_values(struct lanes *lanes, int lane, const struct system *system)
{
    double *value = lanes->state + lanes->n * LANE_COUNT;
    lane_put(lanes->typed_values, system->typed.c + 1, lane, value);
    value += lanes->typed_values * LANE_COUNT;
    for (int i = 0; lanes->values > lanes->typed_values && i < system->terms; i++)
        lane_put(TERM_COEFFICIENTS, system->term[i].c, lane,
                 value + i * TERM_COEFFICIENTS * LANE_COUNT);
}

/* Returns true if a number is the same in all lanes. */
static bool is_alike(const double *value)
{
    bool alike = true;
    for (int lane = 1; lane < LANE_COUNT; lane++)
        alike &= value[lane] == value[0];
    return alike;
}

/* Prepares the programs of the forces and of their slopes (program_prepare_lanes()): values other
 * than time and state are fixed, and some are the same in all lanes, so that expressions of these
 * are computed once. */
void lanes_prepare_forces(struct lanes *lanes)
{
    /* The time is the same in all lanes unless they have their own. */
    unsigned char known[1 + LIMIT_VARIABLES + TERM_VALUES + TERM_MAX * TERM_COEFFICIENTS] = {
        lanes->own ? 0 : LANES_ALIKE};
    for (int i = 1 + lanes->n; i < 1 + lanes->n + lanes->values; i++)
        known[i] = LANES_FIXED | (is_alike(lanes->input + i * LANE_COUNT) ? LANES_ALIKE : 0);
    for (struct lane_part *part = lanes->part; part < lanes->part + lanes->parts; part++)
        program_prepare_lanes(part->program, lanes->input, known, part->frame);
    if (lanes->slopes.program)
        program_prepare_lanes(lanes->slopes.program, lanes->input, known, lanes->slopes.frame);
}

/* ---- sums ---- */

/* Computes the sum of the forces that belong to `sum`, at lanes->state and the time of the stage.
 */
CLONES void lanes_force(struct lanes *lanes, enum lane_sum sum, struct lane_time stage_time,
                        double *force)
{
    const int count = lanes->rows * LANE_COUNT;
    bool first = true;
    if (lanes->timed && stage_time.t)
        memcpy(lanes->input, stage_time.t, LANE_COUNT * sizeof *stage_time.t);
    for (int lane = 0; lanes->timed && !stage_time.t && lane < LANE_COUNT; lane++)
        lanes->input[lane] = stage_time.all;
    for (const struct lane_part *part = lanes->part; part < lanes->part + lanes->parts; part++) {
        if (!(part->sums >> sum & 1))
            continue;
        program_eval_lanes(part->program, first ? force : lanes->spare, part->frame);
        for (int l = 0; !first && l < count; l++)
            force[l] += lanes->spare[l];
        first = false;
    }
    for (int l = 0; first && l < count; l++)
        force[l] = -0.0;
}

/* Computes the derivatives of the state: velocities, then accelerations; for first order the forces
 * alone. */
void lanes_slope(struct lanes *lanes, struct lane_time stage_time, double *slope)
{
    const int positions = lanes->n - lanes->rows;
    memcpy(slope, lanes->state + (lanes->n - positions) * LANE_COUNT,
           (size_t)positions * LANE_COUNT * sizeof *slope);
    lanes_force(lanes, SUM_ALL, stage_time, slope + positions * LANE_COUNT);
}

/* Returns t + c h of the present step, as one number or, where lanes have their own times, in the
 * array own [LANE_COUNT]. */
CLONES struct lane_time lanes_time(const struct lanes *lanes, double c, double *own)
{
    const double step = (double)lanes->step;
    if (!lanes->own)
        return (struct lane_time){.all = (lanes->t0 + step * lanes->h) + c * lanes->h};
    for (int lane = 0; lane < LANE_COUNT; lane++)
        own[lane] = (lanes->own_t0[lane] + step * lanes->own_h[lane]) + c * lanes->own_h[lane];
    return (struct lane_time){.t = own};
}

/* Advances a time by `part` of the step. */
CLONES void lanes_time_add(const struct lanes *lanes, double part, struct lane_time *stage_time,
                           double *own)
{
    stage_time->all += part * lanes->h;
    for (int lane = 0; lane < LANE_COUNT && stage_time->t; lane++)
        own[lane] += part * lanes->own_h[lane];
}
