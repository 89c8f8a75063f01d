/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Switches of a system: those of typed equations (typed/switch.c), then that of dry friction, whose
 * argument is the velocity. A system is frozen on one branch of each switch, so that it is smooth;
 * guards tell where a branch ends. On a branch dry friction is a constant force: an oscillator
 * stays one, about a centre that is shifted (Rayleigh 1877, The Theory of Sound; den Hartog 1931,
 * Trans. ASME 53:107). */
#include <math.h>
#include <string.h>

#include "scene/model/model.h"
#include "scene/typed/typed.h"

/* ---- dry friction on a branch: c[0] [m/s^2] and c[1] [N] with its sign ---- */

TERM_BIND(side)
{
    return true; /* never called: the row takes the place of that of a bound term */
}
TERM_ADD(side)
{
    a[0] -= c[0];
}
TERM_POTENTIAL(side)
{
    return c[1] * y[0];
}

static const struct term_row side_row = {
    .row = {"friction", "m/s^2", "dry friction while the body moves in one direction",
            "Coulomb 1785", NULL},
    .flags = TERM_LINEAR | TERM_CONSERVATIVE,
    .bind = side_bind,
    .add = side_add,
    .potential = side_potential,
};

/* Returns the number of switches of typed equations. */
static int typed_count(const struct system *system)
{
    return system->switches - system->dry;
}

/* Returns true if switch i is that of dry friction. */
static bool is_dry(const struct system *system, int i)
{
    return system->dry && i == system->switches - 1;
}

/* ---- branches and arguments ---- */

double switch_branch(enum switch_kind kind, double argument)
{
    return kind == SWITCH_WHOLE ? floor(argument) : argument > 0;
}

enum switch_kind switch_kind_of(const struct system *system, int i)
{
    return is_dry(system, i) ? SWITCH_SIGN : typed_switch_kind(system, i);
}

/* The velocity is the argument of dry friction. */
void switch_arguments(const struct system *system, double t, const double *y, double *argument)
{
    if (typed_count(system) > 0)
        typed_arguments(system, t, y, argument);
    if (system->dry)
        argument[system->switches - 1] = y[1];
}

/* Returns the branch of switch i on which the system is frozen. */
static double frozen_branch(const struct system *frozen, int i)
{
    if (!is_dry(frozen, i))
        return typed_branch(frozen, i);
    for (int k = 0; k < frozen->terms; k++)
        if (frozen->term[k].row == &side_row)
            return frozen->term[k].c[0] > 0;
    return 0;
}

/* Replaces dry friction in `frozen` by the force that it exerts at velocities above 0 (branch 1) or
 * below 0 (branch 0), without its jump at 0. */
static void freeze_dry(double branch, struct system *frozen)
{
    const double sign = branch > 0 ? 1 : -1;
    for (int i = 0; i < frozen->terms; i++) {
        struct bound_term *term = &frozen->term[i];
        if (!(term->row->flags & TERM_DRY))
            continue;
        term->row = &side_row;
        term->c[0] *= sign;
        term->c[1] *= sign;
    }
    frozen->oscillator.gravity += sign * frozen->oscillator.friction;
    frozen->oscillator.friction = 0;
    system_sum_up(frozen);
}

/* ---- freezing and guards, for methods ---- */

/* Computes the branches of all switches at a state. */
void system_branches(const struct system *system, double t, const double *y, double *branch)
{
    const int typed = typed_count(system);
    double argument[LIMIT_SWITCHES];
    if (typed > 0)
        typed_unfrozen_arguments(system, t, y, argument);
    for (int i = 0; i < typed; i++)
        branch[i] = switch_branch(typed_switch_kind(system, i), argument[i]);
    if (system->dry)
        branch[typed] = y[1] > 0;
}

/* Copies the system without what is not read, and puts its terms on these branches. */
void system_freeze(const struct system *system, const double *branch, struct system *frozen)
{
    const size_t terms = offsetof(struct system, term), typed = offsetof(struct system, typed);
    const size_t rest = offsetof(struct system, linear);
    memcpy(frozen, system, terms);
    memcpy((char *)frozen + rest, (const char *)system + rest, sizeof *system - rest);
    frozen->sliding = NULL;
    frozen->pieces = false;
    if (typed_count(system) > 0) {
        typed_branches_take(system, branch, typed_count(system), frozen);
    } else {
        memcpy(frozen->term, system->term, (size_t)system->terms * sizeof *system->term);
        memcpy((char *)frozen + typed, (const char *)system + typed, rest - typed);
    }
    if (system->dry)
        freeze_dry(branch[system->switches - 1], frozen);
    frozen->kinks = false;
}

/* Computes guards, which are above 0 on the frozen branches: the arguments, or products of
 * distances. */
void system_guards(const struct system *frozen, double t, const double *y, double *guard)
{
    const struct system *side = frozen->sliding ? &frozen->sliding->side[0] : frozen;
    switch_arguments(side, t, y, guard);
    for (int i = 0; i < frozen->switches; i++) {
        const double branch = frozen_branch(side, i);
        if (switch_kind_of(side, i) == SWITCH_SIGN)
            guard[i] = branch > 0 ? guard[i] : -guard[i];
        else
            guard[i] = (guard[i] - branch) * (branch + 1 - guard[i]);
    }
    if (frozen->sliding)
        sliding_guards(frozen->sliding, t, y, guard);
}

/* Returns the branch to which switch i of the frozen system changes where its guard passes 0, at
 * time t and state y: the one to which sliding motion leaves, the other sign, or the neighbouring
 * integer for steps such as floor. */
double system_next_branch(const struct system *frozen, int i, double t, const double *y)
{
    const double leaves = frozen->sliding ? sliding_leaves(frozen->sliding, i, t, y) : NAN;
    if (!isnan(leaves))
        return leaves;
    const struct system *side = frozen->sliding ? &frozen->sliding->side[0] : frozen;
    const double branch = frozen_branch(side, i);
    double argument[LIMIT_SWITCHES];
    switch_arguments(side, t, y, argument);
    if (switch_kind_of(side, i) == SWITCH_SIGN)
        return branch == 0;
    return branch + (argument[i] > branch + 0.5 ? 1 : -1);
}

/* Returns the lower one of the two branches that meet at the switch where the argument is. */
double system_lower_branch(const struct system *frozen, int i, double t, const double *y)
{
    const struct system *side = frozen->sliding ? &frozen->sliding->side[0] : frozen;
    double argument[LIMIT_SWITCHES];
    switch_arguments(side, t, y, argument);
    return switch_kind_of(side, i) == SWITCH_SIGN ? 0 : round(argument[i]) - 1;
}

/* Returns true if the argument of switch i changes with the variable. */
bool system_switch_sees(const struct system *system, int i, double t, const double *y, int variable)
{
    struct system frozen;
    double branch[LIMIT_SWITCHES], shifted[LIMIT_VARIABLES], a[LIMIT_SWITCHES], b[LIMIT_SWITCHES];
    system_branches(system, t, y, branch);
    system_freeze(system, branch, &frozen);
    memcpy(shifted, y, (size_t)system->n * sizeof *y);
    switch_arguments(&frozen, t, shifted, a);
    shifted[variable] += 1e-3 * fmax(system->scale[variable], fabs(y[variable]));
    switch_arguments(&frozen, t, shifted, b);
    return a[i] != b[i];
}

void system_end_at_switch(const struct system *frozen, int i, double *y)
{
    if (is_dry(frozen, i))
        y[1] = 0;
}

/* ---- sticking ---- */

bool sliding_rests(const struct sliding *sliding)
{
    return sliding->count == 1 && is_dry(&sliding->side[0], sliding->switch_index[0]);
}

/* Removes all forces of a system, in which dry friction holds the body: nothing moves. */
void sliding_freeze_rest(struct system *frozen)
{
    frozen->terms = 0;
    frozen->typed.row = NULL;
    frozen->oscillator = (struct oscillator){.whole = frozen->order == 2, .drag_whole = true};
    system_sum_up(frozen);
    frozen->kinks = false;
}
