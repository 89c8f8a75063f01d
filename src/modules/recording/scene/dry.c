/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A curve with dry friction, turning point by turning point. Between two of them friction is a
 * constant force and the motion is smooth. At one, where v = 0, the force jumps, and with it the
 * derivatives by the parameters: a parameter moves the time of the turn by dt = -S_v/a, during
 * which the acceleration is that of the other side, so that S_v becomes S_v a_after/a_before, and
 * S_y is unchanged (saltation matrix I + (f_after - f_before) n^T/(n^T f_before) with n = (0, 1):
 * Filippov 1988; Leine & Nijmeijer 2004, Dynamics and Bifurcations of Non-Smooth Mechanical
 * Systems, ch. 7). If the body sticks, a_after is 0. */
#include <hooke/base/cancel.h>
#include <hooke/scene/typed.h>
#include "modules/recording/scene/curve.h"

#include <math.h>
#include <string.h>

/* Turning points within a step of the mesh, which was chosen to have at most one. */
#define TURNS_MAX 64
/* Parts of a step in which the last moment before a turn, or the release, is searched for. */
#define STEP_LOOKS 32
/* Bisections of a time, and corrections of the step to a turning point. */
#define HALVINGS_MAX 60
#define CORRECTIONS_MAX 3
/* Relative rounding of the time of a turning point. */
#define TURN_KNOWN_RELATIVE 1e-13

/* State of an integration with dry friction. */
struct dry_walk {
    const struct scene_curve *c;
    const struct sampling *sampling;
    struct system own; /* the scene's system, with the friction not frozen */
    struct step *step;
    int branch; /* sign of the velocity, or 0 at rest */
    size_t i;   /* the next sample */
};

/* Sets *frozen to the system with the friction of one branch, the sign of the velocity. */
static void freeze_branch(const struct dry_walk *w, int branch, struct system *frozen)
{
    const double side = branch > 0;
    system_freeze(&w->own, &side, frozen);
}

/* Continues on a branch (0 at rest): freezes the friction of the curve's systems. */
static void go_on_branch(struct dry_walk *w, int branch)
{
    w->branch = branch;
    w->step->warm = false;
    if (branch == 0)
        return;
    freeze_branch(w, branch, &w->c->variation->base);
    w->c->variation->dry = branch;
}

/* Computes the accelerations at y[0] and v = 0 on the lower (a[0]) and on the upper branch
 * (a[1]). */
static void accelerations(const struct dry_walk *w, double t, const double *y, double a[2])
{
    const double rest_state[2] = {y[0], 0};
    for (int side = 0; side < 2; side++) {
        struct system frozen;
        double rate[LIMIT_VARIABLES];
        freeze_branch(w, side ? 1 : -1, &frozen);
        system_derivative(&frozen, t, rest_state, rate);
        a[side] = rate[1];
    }
}

/* Returns the branch on which the motion continues from v = 0, or 0 if it sticks. */
static int next_branch(const double a[2])
{
    if (a[1] > 0)
        return 1;
    return a[0] < 0 ? -1 : 0;
}

/* Passes a turning point: multiplies the derivatives of the velocity by the ratio of the
 * accelerations after and before it (their saltation), and chooses the next branch. */
static void dry_walk_turn(struct dry_walk *w)
{
    struct step *step = w->step;
    double a[2];
    accelerations(w, step->t, step->y, a);
    const double old_acceleration = a[w->branch > 0];
    const int next = next_branch(a);
    const double new_acceleration = next == 0 ? 0 : a[next > 0];
    const double factor = old_acceleration != 0 ? new_acceleration / old_acceleration : 1;
    step->y[1] = 0;
    for (int k = 3; k < step->system->n; k += 2)
        step->y[k] *= factor;
    go_on_branch(w, next);
}

/* ---- at rest ---- */

/* Returns the first time [s] up to `end` at which the forces on the resting body exceed the
 * friction, or `end`. STEP_LOOKS times are tried, then bisected. */
static double release_time(const struct dry_walk *w, double end)
{
    const double t_begin = w->step->t;
    double a[2];
    for (int k = 1; k <= STEP_LOOKS; k++) {
        double free = t_begin + (end - t_begin) * k / STEP_LOOKS,
               stuck = t_begin + (end - t_begin) * (k - 1) / STEP_LOOKS;
        accelerations(w, free, w->step->y, a);
        if (next_branch(a) == 0)
            continue;
        for (int j = 0; j < HALVINGS_MAX; j++) {
            const double middle = 0.5 * (stuck + free);
            accelerations(w, middle, w->step->y, a);
            *(next_branch(a) != 0 ? &free : &stuck) = middle;
        }
        return free;
    }
    return end;
}

/* Stores the samples from number w->i on up to t_end, while the body rests: the value and its
 * derivatives by the parameters are those of the present state or, for a curve of the rate, 0.
 * Advances w->i. */
static void put_resting(struct dry_walk *w, double t_end)
{
    const struct sampling *s = w->sampling;
    const int variable = w->c->variable;
    for (; w->i < s->n && s->t[w->i] <= t_end; w->i++) {
        s->value[w->i] = (w->c->rate ? 0 : w->step->y[variable]) + s->offset;
        for (int j = 0; j < w->c->frees && s->derivative; j++)
            s->derivative[w->i * s->columns + (size_t)j] =
                w->c->rate ? 0 : w->step->y[2 * (j + 1) + variable];
        if (w->c->offset && s->derivative)
            s->derivative[w->i * s->columns + (size_t)w->c->frees] = 1;
    }
}

/* Lets the resting body rest until the forces exceed the friction, or until time `end` [s]: stores
 * the samples of that time, moves the walk to its end, and chooses the branch (direction of motion
 * or rest) on which it continues. */
static void dry_walk_rest(struct dry_walk *w, double end)
{
    double a[2];
    const double t_release = release_time(w, end);
    put_resting(w, t_release);
    w->step->t = t_release;
    accelerations(w, t_release, w->step->y, a);
    go_on_branch(w, next_branch(a));
}

/* ---- in motion ---- */

/* State at the start of a step, from which it can be repeated. */
struct dry_state {
    double t, y[LIMIT_VARIABLES], low[LIMIT_VARIABLES];
};

/* Repeats a step from a saved state with another length. Returns false if it fails. */
static bool step_again(struct dry_walk *w, const struct dry_state *saved, double h)
{
    struct step *step = w->step;
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    memcpy(step->y, saved->y, size);
    memcpy(step->low, saved->low, size);
    step->t = saved->t;
    step->h = h;
    step->warm = false;
    return method_step(w->c->method, step) == STEP_OK;
}

/* Returns the fraction of the latest step at which the velocity leaves the sign of its branch for
 * good, by bisection of its polynomial. */
static double turning_fraction(const struct dry_walk *w)
{
    struct dense_polynomial v;
    double theta_low = 0, theta_high = 1;
    method_polynomial(w->c->method, w->step, 1, &v);
    for (int k = STEP_LOOKS - 1; k > 0 && theta_low == 0; k--) {
        const double theta = (double)k / STEP_LOOKS;
        theta_low = w->branch * dense_polynomial_at(&v, theta) > 0 ? theta : 0;
        theta_high = theta_low == 0 ? theta : theta_high;
    }
    for (int j = 0; j < HALVINGS_MAX; j++) {
        const double middle = 0.5 * (theta_low + theta_high);
        *(w->branch * dense_polynomial_at(&v, middle) > 0 ? &theta_low : &theta_high) = middle;
    }
    return theta_high;
}

/* Moves the body up to the time `end` or to its next turning point, whichever is first, and stores
 * the samples. Newton steps refine the turning point. Returns false if a step fails. */
static bool dry_walk_move(struct dry_walk *w, double end)
{
    struct step *step = w->step;
    struct dry_state saved = {.t = step->t};
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    memcpy(saved.y, step->y, size);
    memcpy(saved.low, step->low, size);
    step->h = end - step->t;
    if (method_step(w->c->method, step) != STEP_OK)
        return false;
    const bool turns = w->branch * step->y[1] < 0;
    double h = turns ? turning_fraction(w) * step->h : step->h;
    for (int k = 0; k < CORRECTIONS_MAX && turns; k++) {
        double rate[LIMIT_VARIABLES];
        if (!step_again(w, &saved, h))
            return false;
        system_derivative(&w->c->variation->base, saved.t + h, step->y, rate);
        const double correction = rate[1] != 0 ? -step->y[1] / rate[1] : 0;
        if (!(fabs(correction) > TURN_KNOWN_RELATIVE * (fabs(saved.t) + h)) ||
            !(h + correction > 0))
            break;
        h += correction;
    }
    step->t = turns ? saved.t + h : end;
    scene_curve_inside(w->c, step, w->sampling, saved.t, &w->i);
    if (turns)
        dry_walk_turn(w);
    return true;
}

/* Integrates a scene with dry friction along the mesh and stores the samples: alternates between
 * motion and rest within each step. Returns false if a step fails, if there are too many turning
 * points, or if cancelled. */
bool scene_dry_march(const struct scene_curve *c, const struct system *system,
                     const struct sampling *s)
{
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES] = {0}, a[2];
    struct step step = {.system = system, .t = system->t0, .y = y, .low = low, .work = c->work};
    struct dry_walk w = {.c = c, .sampling = s, .own = c->variation->base, .step = &step};
    memcpy(y, system->start, (size_t)system->n * sizeof *y);
    if (!scene_curve_first(c, system, s, &w.i))
        return false;
    accelerations(&w, step.t, y, a);
    int branch = next_branch(a);
    if (y[1] > 0 || y[1] < 0)
        branch = y[1] > 0 ? 1 : -1;
    go_on_branch(&w, branch);
    for (size_t k = 0; w.i < s->n; k++) {
        if (k == c->points || ((k & 63) == 0 && cancelled(c->cancel)))
            return false;
        for (int turns = 0; step.t < c->mesh[k]; turns++) {
            if (turns == TURNS_MAX)
                return false;
            if (w.branch == 0)
                dry_walk_rest(&w, c->mesh[k]);
            else if (!dry_walk_move(&w, c->mesh[k]))
                return false;
        }
    }
    return true;
}
