/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * One step of any splitting, with the three ways in which drag can enter it:
 *
 * explicit  each kick uses the drag at the velocity it starts from.
 * implicit  each kick uses the drag at the velocity it ends with; in a symmetric step those before the middle at the
 *           velocity they start from, one in the middle at the mean of both. So the step stays symmetric: for Verlet
 *           this is the central difference scheme.
 * exact     Verlet has the exact flow of the drag over h/2 at both ends, around all drifts and kicks; the others solve
 *           v' = F - gamma v exactly in each kick, the force F standing still.
 *
 * Orders above 2 survive only exact linear drag: their conditions hold for any two flows, and a kick that contains the
 * drag is one. (Compositions of Verlet with the drag at its ends keep their order too, but with zeta = 0.5 to 1 they
 * have 3 to 200 times the error of this, and smaller stable steps.)
 *
 * With compensated sums drifts and kicks are added by step_add(). What multiplies the velocity (drag) leaves its low
 * part as it is: that changes by less than the product's rounding.
 *
 * Source: Hairer, Lubich, Wanner 2006, Geometric Numerical Integration, II.5.
 */
#include "step.h"

/* work: one state, the force of the last kick [n/2], one state of low parts */
size_t split_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)n + (size_t)n / 2 + (size_t)n;
}

/* The size of the most negative kick, 0: there is none. */
static double backward_kick(const struct splitting *splitting)
{
    double least = 0;
    for (int i = splitting->kick_first ? 0 : 1; i < splitting->count; i += 2)
        least = fmin(least, splitting_weight(splitting, i));
    return -least;
}

/* A backward kick over w multiplies the velocity by exp(gamma w), and all errors with it. */
bool split_fits(const struct method *method, const struct system *system, enum drag drag, double h, struct error *error)
{
    double gamma = system->oscillator.damping, back = backward_kick(method->splitting);
    double exponent = fabs(gamma * back * h);
    if (!system->velocity || drag != DRAG_EXACT || exponent <= 1)
        return true;
    error_set(error, ERROR_COMMAND,
              "%s kicks back over %.3g h, and damping run backwards for that long multiplies the velocity by e^%.3g",
              method->row.name, back, exponent);
    return error_hint(error, "use dt <= %.3g s, where it is e, or verlet", 1 / fabs(gamma * back));
}

static bool applies_with_drag(const struct method *method, const struct system *system, enum drag drag,
                              struct error *error)
{
    const char *name = method->row.name;
    double quadratic = system->oscillator.quadratic;
    if (drag == DRAG_EXPLICIT)
        return true;
    if (!system->oscillator.drag_whole) {
        error_set(error, ERROR_COMMAND, "%s knows linear and quadratic drag, not this velocity-dependent force", name);
        return method->drags & 1u << DRAG_EXPLICIT
                   ? error_hint(error, "use %s drag=explicit (first order) or rk4", name)
                   : error_hint(error, "use rk4");
    }
    if (quadratic != 0 && method->order > 2) {
        error_set(error, ERROR_COMMAND,
                  "%s steps back and forth: quadratic drag run backwards has a pole, and is too rough for order %d",
                  name, method->order);
        return error_hint(error, "with quadratic drag use verlet or rk4");
    }
    if (quadratic != 0 && drag == DRAG_EXACT && !(method->flags & METHOD_SYMMETRIC)) {
        error_set(error, ERROR_COMMAND, "%s drag=exact is for linear drag", name);
        return error_hint(error, "with quadratic drag use %s drag=implicit or verlet", name);
    }
    return true;
}

bool split_applies(const struct method *method, const struct system *system, enum drag drag, struct error *error)
{
    return !system->velocity || applies_with_drag(method, system, drag, error);
}

static void add(double *z, double *low, int i, double increment)
{
    step_add(&z[i], low ? &low[i] : NULL, increment);
}

/* v' = v + w F, and the ways in which drag can enter: z' has the new velocity, everything else stands still. */
typedef void kick_function(const struct system *system, double t, double w, const double *force, double *z,
                           double *low);

static void kick_without(const struct system *system, double t, double w, const double *force, double *z, double *low)
{
    (void)t;
    int d = system->n / 2;
    for (int i = 0; i < d; i++)
        add(z, low, d + i, w * force[i]);
}

/* v' = v + w (F + drag at v) */
static void kick_from_start(const struct system *system, double t, double w, const double *force, double *z,
                            double *low)
{
    int d = system->n / 2;
    double drag[LIMIT_VARIABLES];
    system_drag(system, t, z, drag);
    for (int i = 0; i < d; i++)
        add(z, low, d + i, w * (force[i] + drag[i]));
}

/* v' = v + w (F + drag at v') */
static void kick_from_end(const struct system *system, double t, double w, const double *force, double *z, double *low)
{
    (void)t, (void)low;
    const struct oscillator *o = &system->oscillator;
    int d = system->n / 2;
    for (int i = 0; i < d; i++)
        z[d + i] = drag_root(1 + o->damping * w, o->quadratic * w, z[d + i] + w * force[i]);
}

/* v' = v + w (F + drag at (v + v')/2): half a kick from the end, then half a kick from there */
static void kick_from_middle(const struct system *system, double t, double w, const double *force, double *z,
                             double *low)
{
    int d = system->n / 2;
    double v[LIMIT_VARIABLES];
    memcpy(v, z + d, (size_t)d * sizeof *v);
    kick_from_end(system, t, w / 2, force, z, low);
    for (int i = 0; i < d; i++)
        z[d + i] = 2 * z[d + i] - v[i];
}

/* v' = E v + F (1 - E)/gamma, E = exp(-gamma w) */
static void kick_frozen(const struct system *system, double t, double w, const double *force, double *z, double *low)
{
    (void)t;
    int d = system->n / 2;
    double gamma = system->oscillator.damping, lost = -expm1(-gamma * w); /* 1 - E */
    double pull = gamma != 0 ? lost / gamma : w;
    for (int i = 0; i < d; i++)
        add(z, low, d + i, force[i] * pull - z[d + i] * lost);
}

/*
 * side: of the step's middle, < 0 before, 0 in it, > 0 after; a step without symmetry is all "after".
 * around: the drag's own flow stands at the step's ends.
 */
static kick_function *kick_for(enum drag drag, bool around, int side)
{
    switch (drag) {
    case DRAG_EXPLICIT:
        return kick_from_start;
    case DRAG_IMPLICIT:
        return side < 0 ? kick_from_start : side == 0 ? kick_from_middle : kick_from_end;
    case DRAG_EXACT:
        return around ? kick_without : kick_frozen;
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
    double t = step->t, *z = step->work, *force = z + n, *low = step->low ? force + d : NULL;
    bool symmetric = method->flags & METHOD_SYMMETRIC;
    enum drag drag = system->velocity ? step->drag : DRAG_DEFAULT; /* DRAG_DEFAULT: there is none */
    bool around = drag == DRAG_EXACT && symmetric && method->order <= 2;
    /* A step that begins and ends with a kick begins where the last one left the force. */
    bool known = step->warm && splitting->kick_first && count % 2 == 1;

    memcpy(z, step->y, (size_t)n * sizeof *z);
    if (low)
        memcpy(low, step->low, (size_t)n * sizeof *low);
    if (around)
        drag_flow(system, step->h / 2, z);
    for (int i = 0; i < count; i++) {
        double w = splitting_weight(splitting, i) * step->h;
        bool kick = (i % 2 == 0) == splitting->kick_first;
        if (kick && !known) {
            system_force(system, t, z, force);
            step->cost.evals++;
        }
        known = kick;
        if (kick) {
            kick_for(drag, around, symmetric ? 2 * i + 1 - count : 1)(system, t, w, force, z, low);
        } else {
            for (int j = 0; j < d; j++)
                add(z, low, j, w * z[d + j]);
            t += w;
        }
    }
    if (around)
        drag_flow(system, step->h / 2, z);
    enum step_status status = step_finish(step, z);
    if (low && status == STEP_OK)
        memcpy(step->low, low, (size_t)n * sizeof *low);
    return status;
}
