/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One step of any splitting, with the three ways in which drag can enter it:
 *
 * explicit  each kick uses the drag at the velocity it starts from.
 * implicit  each kick uses the drag at the velocity it ends with; in a symmetric step those before the middle at the
 *           velocity they start from, one in the middle at the mean of both. So the step stays symmetric: for Verlet
 *           this is the central difference scheme.
 * exact     a symmetric step has the exact flow of the drag over h/2 at both ends, around all drifts and kicks; a step
 *           without symmetry solves v' = F - gamma v exactly in its kick, the force F standing still.
 *
 * Source: Hairer, Lubich, Wanner 2006, Geometric Numerical Integration, II.5.
 */
#include "step.h"

/* work: one state, then the force of the last kick [n/2] */
size_t split_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)n + (size_t)n / 2;
}

bool split_fits(const struct method *method, const struct system *system, enum drag drag, double h, struct error *error)
{
    (void)method, (void)system, (void)drag, (void)h, (void)error;
    return true;
}

bool split_applies(const struct method *method, const struct system *system, enum drag drag, struct error *error)
{
    const char *name = method->row.name;
    if (!system->velocity)
        return true;
    if (method->order > 2) {
        error_set(error, ERROR_COMMAND, "%s steps back and forth, and drag run backwards grows without bound", name);
        return error_hint(error, "with drag use verlet or rk4");
    }
    if (drag == DRAG_EXPLICIT)
        return true;
    if (!system->oscillator.whole) {
        error_set(error, ERROR_COMMAND, "%s knows linear and quadratic drag, not this velocity-dependent force", name);
        return error_hint(error, "use %s drag=explicit (first order) or rk4", name);
    }
    if (drag == DRAG_EXACT && !(method->flags & METHOD_SYMMETRIC) && system->oscillator.quadratic != 0) {
        error_set(error, ERROR_COMMAND, "%s drag=exact is for linear drag", name);
        return error_hint(error, "with quadratic drag use %s drag=implicit or verlet", name);
    }
    return true;
}

/* v' = v + w F, and the ways in which drag can enter: z' has the new velocity, everything else stands still. */
typedef void kick_function(const struct system *system, double t, double w, const double *force, double *z);

static void kick_without(const struct system *system, double t, double w, const double *force, double *z)
{
    (void)t;
    int d = system->n / 2;
    for (int i = 0; i < d; i++)
        z[d + i] += w * force[i];
}

/* v' = v + w (F + drag at v) */
static void kick_from_start(const struct system *system, double t, double w, const double *force, double *z)
{
    int d = system->n / 2;
    double drag[LIMIT_VARIABLES];
    system_drag(system, t, z, drag);
    for (int i = 0; i < d; i++)
        z[d + i] += w * (force[i] + drag[i]);
}

/* v' = v + w (F + drag at v') */
static void kick_from_end(const struct system *system, double t, double w, const double *force, double *z)
{
    (void)t;
    const struct oscillator *o = &system->oscillator;
    int d = system->n / 2;
    for (int i = 0; i < d; i++)
        z[d + i] = drag_root(1 + o->damping * w, o->quadratic * w, z[d + i] + w * force[i]);
}

/* v' = v + w (F + drag at (v + v')/2): half a kick from the end, then half a kick from there */
static void kick_from_middle(const struct system *system, double t, double w, const double *force, double *z)
{
    int d = system->n / 2;
    double v[LIMIT_VARIABLES];
    memcpy(v, z + d, (size_t)d * sizeof *v);
    kick_from_end(system, t, w / 2, force, z);
    for (int i = 0; i < d; i++)
        z[d + i] = 2 * z[d + i] - v[i];
}

/* v' = E v + F (1 - E)/gamma, E = exp(-gamma w) */
static void kick_frozen(const struct system *system, double t, double w, const double *force, double *z)
{
    (void)t;
    int d = system->n / 2;
    double gamma = system->oscillator.damping, lost = -expm1(-gamma * w); /* 1 - E */
    double pull = gamma != 0 ? lost / gamma : w;
    for (int i = 0; i < d; i++)
        z[d + i] += force[i] * pull - z[d + i] * lost;
}

/* side: of the step's middle, < 0 before, 0 in it, > 0 after; a step without symmetry is all "after". */
static kick_function *kick_for(enum drag drag, bool symmetric, int side)
{
    switch (drag) {
    case DRAG_EXPLICIT:
        return kick_from_start;
    case DRAG_IMPLICIT:
        return side < 0 ? kick_from_start : side == 0 ? kick_from_middle : kick_from_end;
    case DRAG_EXACT:
        return symmetric ? kick_without : kick_frozen;
    default:
        return kick_without;
    }
}

static void drag_flow(const struct system *system, double h, double *z)
{
    int d = system->n / 2;
    for (int i = d; i < system->n; i++)
        z[i] = oscillator_drag_flow(&system->oscillator, z[i], h);
}

enum step_status split_step(const struct method *method, struct step *step)
{
    const struct system *system = step->system;
    const struct splitting *splitting = method->splitting;
    int n = system->n, d = n / 2, count = splitting->count;
    double t = step->t, *z = step->work, *force = z + n;
    bool symmetric = method->flags & METHOD_SYMMETRIC;
    enum drag drag = system->velocity ? step->drag : DRAG_DEFAULT; /* DRAG_DEFAULT: there is none */
    bool around = drag == DRAG_EXACT && symmetric;
    /* A step that begins and ends with a kick begins where the last one left the force. */
    bool known = step->warm && splitting->kick_first && count % 2 == 1;

    memcpy(z, step->y, (size_t)n * sizeof *z);
    if (around)
        drag_flow(system, step->h / 2, z);
    for (int i = 0; i < count; i++) {
        double w = splitting->weight[i] * step->h;
        bool kick = (i % 2 == 0) == splitting->kick_first;
        if (kick && !known) {
            system_force(system, t, z, force);
            step->cost.evals++;
        }
        known = kick;
        if (kick) {
            kick_for(drag, symmetric, symmetric ? 2 * i + 1 - count : 1)(system, t, w, force, z);
        } else {
            for (int j = 0; j < d; j++)
                z[j] += w * z[d + j];
            t += w;
        }
    }
    if (around)
        drag_flow(system, step->h / 2, z);
    return step_finish(step, z);
}
