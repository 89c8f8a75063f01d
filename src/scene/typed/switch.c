/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Typed scenes on frozen branches: programs of the equations without their switches, and of the
 * arguments whose signs tell when a branch ends. The values of a frozen term are, from 1 on, the
 * mass, the parameters that are read, room for observed quantities, the branches, and retained
 * values. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/typed/typed.h"

/* Returns the index of the first branch among the values of a frozen term, counted from value 1. */
static int first_branch(const struct typed *typed)
{
    return typed_names(typed) - typed_mass_name(typed);
}

/* ---- making programs ---- */

/* State while frozen programs are made. */
struct switch_making {
    const struct typed *typed;
    struct equations *equations;
    const bool *bound;   /* [names] the name is a parameter that is 0 */
    const double *value; /* [names] all 0 */
    int values;          /* number of values of the term so far, without the first */
    struct error *error;
};

/* Makes a program of `count` outputs from `first` on; one for `steps` retains values and has
 * machine code. Returns NULL with an error. */
static struct program *switch_program_make(struct switch_making *m, int first, int count,
                                           bool steps)
{
    const struct steady_names steady = {1 + m->typed->model.n, m->values,
                                        steps ? TERM_VALUES - 1 - m->values : 0};
    struct program *program = program_create_keeping(m->equations, first, count, m->bound, m->value,
                                                     &steady, steps, m->error);
    m->values += program ? program->keeps : 0;
    return program;
}

/* Adds the sums of all groups [rows] as outputs. Returns false with an error. */
static bool add_rows(struct switch_making *m)
{
    static const struct op zero = {.kind = OP_NUMBER, .number = 0};
    const struct expr nothing = {.op = (struct op *)(uintptr_t)&zero, .count = 1};
    const struct typed *typed = m->typed;
    struct arena arena = {0};
    bool fine = true;
    for (int i = 0; fine && i < typed_rows(typed); i++) {
        const struct expr *whole = NULL;
        for (int g = 0; fine && g < GROUPS; g++) {
            const struct expr *more = typed->group[g] ? typed->group[g][i] : NULL;
            if (more)
                whole = whole ? typed_join(&arena, whole, more, OP_ADD, m->error) : more;
            fine = !more || whole;
        }
        fine = fine && equations_add(m->equations, whole ? whole : &nothing, m->error);
    }
    arena_reset(&arena);
    return fine;
}

/* Makes the programs of the switches' arguments, of the equations with the branches as values
 * (frozen), and of the Jacobian of these; none if the equations have no switches. The equations are
 * outputs 0 to rows - 1 of m->equations; equations_freeze() appends the arguments and the frozen
 * equations. Returns false with an error. */
static bool make_programs(struct switch_making *m, struct typed_part *part)
{
    const struct typed *typed = m->typed;
    const int n = typed->model.n, rows = typed_rows(typed);
    struct switches *found = &part->switches;
    int state[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        state[i] = 1 + i;
    found->name = typed_names(typed);
    found->moving = 1 + n;
    for (int i = 0; i < typed->observes; i++)
        if (!equations_let(m->equations, typed_first_observed(typed) + i, typed->observe[i],
                           m->error))
            return false;
    if (!add_rows(m) || !equations_freeze(m->equations, 0, rows, found, m->error))
        return false;
    if (found->count == 0)
        return true;
    const int first = rows + found->count;
    part->argument = switch_program_make(m, rows, found->count, false);
    part->frozen.add = switch_program_make(m, first, rows, true);
    if (!part->argument || !part->frozen.add ||
        !equations_derive(m->equations, first, rows, state, n, m->error))
        return false;
    part->frozen.jacobian = switch_program_make(m, first + rows, rows * n, true);
    return part->frozen.jacobian;
}

/* Returns true if an expression of the scene contains a switch. */
static bool any_switches(const struct typed *typed)
{
    bool any = false;
    for (int g = 0; g < GROUPS; g++)
        for (int i = 0; typed->group[g] && i < typed_rows(typed); i++)
            any = any || expr_switches(typed->group[g][i]);
    for (int i = 0; i < typed->observes; i++) /* observables, which equations may read */
        any = any || expr_switches(typed->observe[i]);
    return any;
}

/* Sets the branches of a frozen term, and its retained values, which depend on them. */
static void take_branches(const struct typed_part *part, const double *branch, int count, double *c)
{
    memcpy(c + 1 + first_branch(part->frozen.typed), branch, (size_t)count * sizeof *branch);
    program_keep(part->frozen.add, c + 1);
    program_keep(part->frozen.jacobian, c + 1);
}

#define NEXT_BRANCH_TRIALS 3

/* Returns what typed_turns_only() says of the part. Decides by evaluation at arbitrary numbers: the
 * argument has to be the velocity, and the force at rest the same on both branches. */
static bool turns_only(const struct typed_part *part)
{
    const struct typed *typed = part->frozen.typed;
    double c[TERM_VALUES] = {0}, value[2], speed[1], force[2][2];
    const struct typed_term *term = &part->frozen;
    if (part->switches.count != 1 || part->switches.kind[0] != SWITCH_SIGN ||
        typed->model.order != 2 || typed->model.n != 2)
        return false;
    memcpy(c, &term, sizeof term);
    for (int k = 0; k < NEXT_BRANCH_TRIALS; k++) {
        const double t = 0.37 + k, q[2] = {0.83 - k, 0.61 + 0.29 * k}, still[2] = {q[0], 0};
        for (int i = 0; i <= typed->reads; i++)
            c[1 + i] = 0.71 + 0.13 * (i + k);
        typed_evaluate(part->argument, c, t, q, speed);
        typed_evaluate(part->argument, c, t, still, value);
        if (fabs(speed[0]) != q[1] || value[0] != 0)
            return false;
        for (int side = 0; side < 2; side++) {
            take_branches(part, (const double[]){side}, 1, c);
            typed_evaluate(part->frozen.add, c, t, still, force[side]);
        }
        if (force[0][0] != force[1][0])
            return false;
    }
    return true;
}

/* Makes programs with names for the branches, if the scene has switches and values have room. */
bool typed_freeze(const struct typed *typed, uint64_t zeros, struct typed_part *part,
                  struct error *error)
{
    const int names = typed_names(typed) + LIMIT_TYPED_SWITCHES;
    if (!any_switches(typed))
        return true;
    bool *bound = calloc((size_t)names, sizeof *bound);
    double *value = calloc((size_t)names, sizeof *value);
    struct switch_making m = {typed, NULL, bound, value, first_branch(typed) + LIMIT_TYPED_SWITCHES,
                              error};
    bool fine = bound && value;
    if (!fine)
        error_memory(error);
    else if (m.values < TERM_VALUES) /* else there is no room for branches */
        fine = (m.equations = equations_create(names, error)) != NULL;
    for (int i = 0; fine && i < typed->reads; i++)
        bound[typed_first_read(typed) + i] = zeros >> i & 1;
    part->frozen.typed = typed;
    part->frozen.part = part;
    part->frozen.row = (struct term_row){.row = {"equations", "", "on frozen branches", "", NULL},
                                         .add = typed_add_force,
                                         .jacobian = typed_add_jacobian};
    fine = fine && (!m.equations || make_programs(&m, part));
    part->turns_only = fine && turns_only(part);
    equations_destroy(m.equations);
    free(bound);
    free(value);
    return fine;
}

/* ---- frozen systems ---- */

/* Returns the part that a bound system uses. */
static const struct typed_part *part_of(const struct system *system)
{
    return typed_term_of(system->typed.c)->part;
}

/* Sets the values c of a frozen term to the mass and the parameters of a bound term; branches are
 * 0. */
static void frozen_values(const struct typed_part *part, const double *bound, double *c)
{
    const struct typed_term *term = &part->frozen;
    memset(c, 0, TERM_VALUES * sizeof *c);
    memcpy(c, &term, sizeof term);
    memcpy(c + 1, bound + 1, (size_t)(1 + term->typed->reads) * sizeof *c);
}

bool typed_turns_only(const struct system *system)
{
    return system->kinks && part_of(system)->turns_only;
}

/* Returns the number of switches at which steps end; none for an oscillator. */
int typed_switches(struct system *system)
{
    const struct typed_part *part = part_of(system);
    const int count = system->oscillator.whole ? 0 : part->switches.count;
    system->extended = count > 0 && part->switches.extended;
    return count;
}

/* Sets the arguments of all switches, and their branches in the values c of a frozen term. An
 * argument may depend on the branches of earlier switches, so that it is repeated until none
 * changes. */
static void find_branches(const struct typed_part *part, double t, const double *y, double *c,
                          double *argument)
{
    bool settled = false;
    for (int k = 0; k < part->switches.count && !settled; k++) {
        settled = true;
        typed_evaluate(part->argument, c, t, y, argument);
        for (int i = 0; i < part->switches.count; i++) {
            double *branch = &c[1 + first_branch(part->frozen.typed) + i];
            const double now = switch_branch(part->switches.kind[i], argument[i]);
            settled = settled && *branch == now;
            *branch = now;
        }
    }
}

/* Finds the branches at the state, too, on which later arguments depend. */
void typed_unfrozen_arguments(const struct system *system, double t, const double *y,
                              double *argument)
{
    const struct typed_part *part = part_of(system);
    double c[TERM_VALUES];
    frozen_values(part, system->typed.c, c);
    find_branches(part, t, y, c, argument);
}

void typed_branches_at(const struct typed_part *part, const double *bound, const double *y,
                       double *branch)
{
    double c[TERM_VALUES], argument[LIMIT_TYPED_SWITCHES];
    frozen_values(part, bound, c);
    find_branches(part, 0, y, c, argument);
    memcpy(branch, c + 1 + first_branch(part->frozen.typed),
           (size_t)part->switches.count * sizeof *branch);
}

/* Replaces the typed terms by one frozen term; built-in ones stay. */
void typed_branches_take(const struct system *system, const double *branch, int count,
                         struct system *frozen)
{
    const struct typed_part *part = part_of(system);
    frozen->linear = frozen->oscillator.whole = frozen->oscillator.drag_whole = false;
    frozen->typed.row = &part->frozen.row;
    frozen_values(part, system->typed.c, frozen->typed.c);
    take_branches(part, branch, count, frozen->typed.c);
    frozen->terms = 0;
    for (int i = 0; i < system->terms; i++) /* terms of the built-in scene */
        if (system->term[i].row->bind)
            frozen->term[frozen->terms++] = system->term[i];
    frozen->term[frozen->terms++] = frozen->typed;
    if (typed_base(system->model))
        frozen->typed.row = NULL;
}

enum switch_kind typed_switch_kind(const struct system *system, int i)
{
    return part_of(system)->switches.kind[i];
}

void typed_arguments(const struct system *system, double t, const double *y, double *argument)
{
    typed_evaluate(part_of(system)->argument, system->typed.c, t, y, argument);
}

double typed_branch(const struct system *frozen, int i)
{
    return frozen->typed.c[1 + first_branch(part_of(frozen)->frozen.typed) + i];
}
