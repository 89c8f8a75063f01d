/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One step of any splitting (drifts and kicks in turn), with three ways in which drag enters it:
 *
 * explicit  each kick uses the drag at the velocity it starts from.
 * implicit  each kick uses the drag at the velocity it ends with; in a symmetric step those
 *           before the middle at the velocity they start from, one in the middle at the mean of
 *           both. So the step stays symmetric: for Verlet this is the central difference scheme.
 * exact     Verlet has the exact flow of the drag over h/2 at both ends, around all drifts
 *           and kicks; the others solve v' = F - gamma v exactly in each kick, the force F
 *           standing still.
 *
 * Orders above 2 are kept only with exact linear drag: their conditions hold for any two flows, and
 * a kick that contains the drag is a flow. (Compositions of Verlet with the drag at its ends keep
 * their order too, but with zeta = 0.5 to 1 they have 3 to 200 times the error of this, and smaller
 * stable steps.)
 *
 * With compensated sums drifts and kicks are added by step_add(). A factor of the velocity (drag)
 * leaves the low part unchanged, since that changes by less than the rounding of the product.
 *
 * Source: Hairer, Lubich, Wanner 2006, Geometric Numerical Integration, II.5.
 */
#include "method/step/split_body.h"

/* The work array holds one state, the force of the last kick [n/2], and one state of low parts. */
size_t split_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)n + (size_t)n / 2 + (size_t)n;
}

/* Returns the size of the most negative kick, or 0 if there is none. */
static double backward_kick(const struct splitting *splitting)
{
    double min = 0;
    for (int i = splitting->kick_first ? 0 : 1; i < splitting->count; i += 2)
        min = fmin(min, splitting_weight(splitting, i));
    return -min;
}

/* Returns true unless a backward kick over w multiplies the velocity, and all errors with it, by
 * more than e, since the factor is exp(gamma w); then sets an error. */
bool split_fits(const struct method *method, const struct system *system, enum drag drag, double h,
                struct error *error)
{
    double gamma = system->oscillator.damping, back = backward_kick(method->splitting);
    double exponent = fabs(gamma * back * h);
    if (!system->velocity || drag != DRAG_EXACT || exponent <= 1)
        return true;
    error_set(
        error, ERROR_COMMAND,
        "%s takes a backward substep of %.3g h, in which damping multiplies the velocity by e^%.3g",
        method->row.name, back, exponent);
    return error_hint(error,
                      "use dt <= %.3g s, for which that factor is at most e, or use verlet, which "
                      "has no backward substep",
                      1 / fabs(gamma * back));
}

/* Returns true if dry friction acts; it is always the last of the forces. */
static bool has_dry(const struct system *system)
{
    return system->terms > 0 && system->term[system->terms - 1].row->flags & TERM_DRY;
}

/* Returns true if the splitting works with the drag of the system in this variant; otherwise sets
 * an error that names one that does. */
static bool applies_with_drag(const struct method *method, const struct system *system,
                              enum drag drag, struct error *error)
{
    const char *name = method->row.name;
    double quadratic = system->oscillator.quadratic;
    if (drag == DRAG_EXPLICIT)
        return true;
    if (system->steps_across_kinks && has_dry(system)) {
        error_set(
            error, ERROR_COMMAND,
            "%s cannot step across the jump of dry friction, but 'set turning off' demands it",
            name);
        return error_hint(error, "'set turning on' ends the steps at the jump");
    }
    if (!system->oscillator.drag_whole) {
        error_set(error, ERROR_COMMAND,
                  "%s works with linear and quadratic drag, not with this velocity-dependent force",
                  name);
        return method->drags & 1u << DRAG_EXPLICIT
                   ? error_hint(error, "use %s drag=explicit (first order) or rk4", name)
                   : error_hint(error, "use rk4");
    }
    if (quadratic != 0 && method->order > 2) {
        error_set(
            error, ERROR_COMMAND,
            "%s has backward substeps, in which quadratic drag can diverge and reduces order %d",
            name, method->order);
        return error_hint(error, "with quadratic drag use verlet or rk4");
    }
    if (quadratic != 0 && drag == DRAG_EXACT && !(method->flags & METHOD_SYMMETRIC)) {
        error_set(error, ERROR_COMMAND, "%s drag=exact works with linear drag only", name);
        return error_hint(error, "with quadratic drag use %s drag=implicit or verlet", name);
    }
    return true;
}

/* Returns true if the splitting can step the system with this drag variant, else false with the
 * error set. */
bool split_applies(const struct method *method, const struct system *system, enum drag drag,
                   struct error *error)
{
    return !system->velocity || applies_with_drag(method, system, drag, error);
}

/* Computes the forces that do not depend on velocity, for a force_function. */
static void split_force(const void *system, double t, const double *y, double *a)
{
    system_force(system, t, y, a);
}

/* Computes the forces that depend on velocity, for a force_function. */
static void split_drag_force(const void *system, double t, const double *y, double *a)
{
    system_drag(system, t, y, a);
}

/* Takes a step with forces that are called, for any system. */
enum step_status split_step(const struct method *method, struct step *step)
{
    const struct system *system = step->system;
    const int n = system->n, d = n / 2;
    double *z = step->work, *pull = z + n, *low = step->low ? pull + d : NULL;
    const struct split_forces forces = {split_force, split_drag_force, system, &system->oscillator};
    struct split_way way;
    split_choose(&way, method, system->velocity ? step->drag : DRAG_DEFAULT);
    memcpy(z, step->y, (size_t)n * sizeof *z);
    if (low)
        memcpy(low, step->low, (size_t)n * sizeof *low);
    const struct drag_flow half = way.drag_at_ends
                                      ? oscillator_drag_flow(&system->oscillator, step->h / 2)
                                      : (struct drag_flow){0};
    split_stages(&way, n, &forces, &half, NULL, step->t, step->h, z, pull, low,
                 split_known(&way, step));
    step->cost.evals += way.kicks - split_known(&way, step);
    enum step_status status = step_finish(step, z);
    if (low && status == STEP_OK)
        memcpy(step->low, low, (size_t)n * sizeof *low);
    return status;
}
