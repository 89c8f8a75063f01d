/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Work between states one step apart: the integral of the power of drag and drive along the quintic
 * through position, velocity and acceleration at both ends, by Lobatto's rule with four points
 * (Abramowitz and Stegun 1964, 25.4.32). Its ends are states of the neighbours too, so a step costs
 * one acceleration and three powers. Both are of order 6.
 *
 * At Lobatto's inner points s = (1 -+ 1/sqrt 5)/2 the quintic Hermite polynomial of q0, v0, a0, q1,
 * v1, a1 is
 *
 *   q = (q0 + q1)/2 + 0.12 h (v0 - v1) + 0.01 h^2 (a0 + a1)
 *       -+ (0.82 (q1 - q0) - 0.16 h (v0 + v1) - 0.01 h^2 (a0 - a1)) / sqrt 5
 *   v = 1.2 (q1 - q0)/h - 0.1 (v0 + v1) +- (0.7 (v0 - v1) + 0.1 h (a0 + a1)) / sqrt 5
 *
 * Here it goes step by step through the system's functions; work_terms.c does the commonest scenes
 * by blocks of steps.
 */
#include <hooke/scene/typed.h>
#include "run/energy/work.h"

#include <math.h>
#include <string.h>

/* Returns the length [s] of step k. */
static double step_length(const struct work *work, int k)
{
    return work->t ? work->t[k + 1] - work->t[k] : work->h;
}

/* ---- powers ---- */

/* Power of all forces without a potential, and the part of drag, in units of factor^2 W. */
struct power {
    double all, drag;
};

/* Returns true if drag is the only term that does work. */
static bool drags_only(const struct system *system)
{
    for (int i = 0; i < system->terms; i++)
        if (term_has_power(system->term[i].row) &&
            (system->term[i].row->flags & (TERM_TIME | TERM_VELOCITY)) != TERM_VELOCITY)
            return false;
    return true;
}

/* Returns the powers at a state; `drags` is drags_only(). */
static struct power power_at(const struct system *system, bool drags, double t, const double *y)
{
    const double all = system_power(system, t, y);
    return (struct power){all, drags ? all : system_dissipation(system, t, y)};
}

/* ---- steps across a turning point, where drag has a kink: in two parts ---- */

/* Computes position and velocity at the fraction s of the step. */
static void quintic_at(const struct quintic *p, double s, double *q, double *v)
{
    const double r = 1 - s, rs = r * s, rise = s * s * s * (10 + s * (6 * s - 15)), h = p->h;
    *q = p->q0 + rise * (p->q1 - p->q0) +
         rs * h * (r * r * (1 + 3 * s) * p->v0 - s * s * (1 + 3 * r) * p->v1) +
         rs * rs / 2 * h * h * (r * p->a0 + s * p->a1);
    *v = 30 * rs * rs * (p->q1 - p->q0) / h + r * r * (1 + s * (2 - 15 * s)) * p->v0 +
         s * s * (1 + r * (2 - 15 * r)) * p->v1 +
         rs / 2 * h * (r * (2 - 5 * s) * p->a0 - s * (2 - 5 * r) * p->a1);
}

/* Tolerance of the steps in which a body turns under dry friction. */
#define TURN_TOLERANCE 1e-11
#define TURN_STEPS_MAX 64 /* Largest number of such steps. */
#define STEP_MEMORY 64    /* number of doubles for the memory of a step */
/* Accuracy of the turning point, as a fraction of the step: the power near it, which grows with the
 * square or cube of the velocity, is negligible. Also the fraction of the velocity at which forces
 * on both sides of it are compared. */
#define NEAR_REST 1e-9
/* A change of the acceleration between both sides of the turning point that is above this share of
 * it counts as a jump. */
static const double jump_min = 1e-6;

/* Returns the velocity of the quintic `context` at the fraction s of the step. */
static double velocity_at(void *context, double s)
{
    double q, v;
    quintic_at(context, s, &q, &v);
    return v;
}

/* Returns the fraction of the step at which the velocity, whose signs at the ends differ, is 0. */
static double turning_point(struct quintic p)
{
    const double v0 = p.v0, v1 = p.v1;
    return root_between(velocity_at, &p, 0, v0, 1, v1, NEAR_REST);
}

/* Adds to *work and *drag the work of all forces and of drag between the fractions s_begin and
 * s_end of the step at time t, whose motion is the quintic *p, by Lobatto's rule with four points.
 * `drags` tells that drag is the only force that does work. */
static void quintic_work_add(const struct system *system, bool drags, const struct quintic *p,
                             double t, double s_begin, double s_end, double *work, double *drag)
{
    const double node[] = {0, LOBATTO_INNER, 1 - LOBATTO_INNER, 1},
                 weight[] = {1. / 12, 5. / 12, 5. / 12, 1. / 12};
    for (int i = 0; i < 4; i++) {
        const double s = s_begin + node[i] * (s_end - s_begin),
                     weighted = weight[i] * (s_end - s_begin) * p->h;
        double y[2];
        quintic_at(p, s, &y[0], &y[1]);
        const struct power power = power_at(system, drags, t + s * p->h, y);
        *work += weighted * power.all;
        *drag += weighted * power.drag;
    }
}

/* Computes *work and *drag, the work of all forces and of drag over the step of *p at time t, under
 * dry friction. Since the force jumps where the body turns, the step is solved again by dopri5,
 * whose steps end at such points, and the work of each part is added. Returns false if that fails.
 */
static bool dry_step_work(const struct system *system, const struct quintic *p, double t,
                          double *work, double *drag)
{
    const struct method *method = method_find("dopri5");
    double y[2] = {p->q0, p->v0}, memory[STEP_MEMORY];
    struct step step = {.system = system, .y = y, .work = memory, .t = t};
    struct controller controller = {.tol = TURN_TOLERANCE, .h = p->h};
    const bool drags = drags_only(system),
               there = method && method_work_size(method, 2) <= STEP_MEMORY;
    *work = *drag = 0;
    for (int i = 0; there && i < TURN_STEPS_MAX && step.t != t + p->h; i++) {
        struct sliding sliding = {0};
        struct system frozen;
        const double t_begin = step.t, q0 = y[0], v0 = y[1];
        double a[2];
        if (method_adapt(method, &step, &controller, t + p->h) != STEP_OK)
            return false;
        const struct system *smooth = method_adapted(system, &controller, &sliding, &frozen);
        system_acceleration(smooth, t_begin, (const double[]){q0, v0}, &a[0]);
        system_acceleration(smooth, step.t, y, &a[1]);
        sliding_free(&sliding);
        const struct quintic part = {step.t - t_begin, q0, v0, a[0], y[0], y[1], a[1]};
        if (part.h != 0)
            quintic_work_add(system, drags, &part, t_begin, 0, 1, work, drag);
    }
    return there && step.t == t + p->h;
}

/* Computes the work of a step with a turning point: up to there and from there on, or by
 * dry_step_work(). */
static void turning_step_work(const struct system *system, const struct quintic *p, double t,
                              double *work, double *drag)
{
    if (system->dry && dry_step_work(system, p, t, work, drag))
        return;
    if (p->v0 * p->v1 >= 0) {
        *work = *drag = 0;
        quintic_work_add(system, drags_only(system), p, t, 0, 1, work, drag);
        return;
    }
    const double s = turning_point(*p);
    const bool drags = drags_only(system);
    *work = *drag = 0;
    quintic_work_add(system, drags, p, t, 0, s, work, drag);
    quintic_work_add(system, drags, p, t, s, 1, work, drag);
}

/* ---- any system ---- */

/* Computes the states first and second [n] at both inner points of Lobatto's rule in a step from y0
 * to y1, with the accelerations a0 and a1 [half]. */
static void inner_states(int half, double h, const double *y0, const double *a0, const double *y1,
                         const double *a1, double *first, double *second)
{
    for (int i = 0; i < half; i++) {
        const double v0 = y0[i + half], v1 = y1[i + half], rise = y1[i] - y0[i];
        const double q = (y0[i] + y1[i]) / 2 + h * (0.12 * (v0 - v1) + 0.01 * h * (a0[i] + a1[i]));
        const double dq =
            (0.82 * rise - h * (0.16 * (v0 + v1) + 0.01 * h * (a0[i] - a1[i]))) / SQRT_5;
        const double v = 1.2 * (rise / h) - 0.1 * (v0 + v1);
        const double dv = (0.7 * (v0 - v1) + 0.1 * h * (a0[i] + a1[i])) / SQRT_5;
        first[i] = q - dq;
        second[i] = q + dq;
        first[i + half] = v + dv;
        second[i + half] = v - dv;
    }
}

/* Returns true if a switch of the equations (other than that of dry friction) changes its branch
 * between four points of a step, given by times t and states y, so that quadrature over the step is
 * not accurate. */
static bool switches_differ(const struct system *system, const double t[4], double *const y[4])
{
    double first[LIMIT_SWITCHES], branch[LIMIT_SWITCHES];
    const int switches = system->switches - system->dry;
    if (switches <= 0)
        return false;
    system_branches(system, t[0], y[0], first);
    for (int i = 1; i < 4; i++) {
        system_branches(system, t[i], y[i], branch);
        if (memcmp(first, branch, (size_t)switches * sizeof *first) != 0)
            return true;
    }
    return false;
}

/* Returns true if, in a step in which the velocity changes its sign, the force jumps at v = 0 or
 * another switch changes its branch. A force like |v| v has only a kink there. */
static bool force_jumps_at_turn(const struct system *system, const struct quintic *p, double t)
{
    const double s = p->v0 * p->v1 < 0 ? turning_point(*p) : fabs(p->v0) > fabs(p->v1),
                 still = fmax(fabs(p->v0), fabs(p->v1)) * NEAR_REST, turn = t + s * p->h;
    double q, v, branch[4][LIMIT_SWITCHES], a[2];
    quintic_at(p, s, &q, &v);
    const double incoming[] = {q, copysign(still, p->v0)}, outgoing[] = {q, copysign(still, p->v1)};
    const size_t bytes = (size_t)system->switches * sizeof(double);
    system_branches(system, t, (const double[]){p->q0, p->v0}, branch[0]);
    system_branches(system, turn, incoming, branch[1]);
    system_branches(system, turn, outgoing, branch[2]);
    system_branches(system, t + p->h, (const double[]){p->q1, p->v1}, branch[3]);
    if (memcmp(branch[0], branch[1], bytes) != 0 || memcmp(branch[2], branch[3], bytes) != 0)
        return true;
    system_acceleration(system, turn, incoming, &a[0]);
    system_acceleration(system, turn, outgoing, &a[1]);
    return fabs(a[1] - a[0]) > jump_min * (fabs(p->a0) + fabs(p->a1));
}

bool work_turn(const struct system *system, const struct quintic *p, double t, double *work,
               double *drag)
{
    turning_step_work(system, p, t, work, drag);
    return !system->dry && force_jumps_at_turn(system, p, t);
}

/* Sets y [n] to the state after k steps, times work->factor. */
static void scaled_state(const struct work *work, int k, double *y)
{
    const double *state = k == 0 ? work->initial_state : work->row + (size_t)(k - 1) * work->stride;
    for (int i = 0; i < work->system->n; i++)
        y[i] = state[i] * work->factor;
}

/* Computes the energy after each step and the work of each step, for any system, by Lobatto
 * quadrature in done->energy, work and drag; done->jumps and coarse mark steps over which it is not
 * accurate. State, acceleration and power at the end of a step are kept for the next one, in two
 * sets that alternate. */
static void work_of_any(const struct work *work, struct work_done *done)
{
    const struct system *system = work->system;
    double y[2][LIMIT_VARIABLES] = {{0}}, a[2][LIMIT_VARIABLES] = {{0}};
    double first[LIMIT_VARIABLES], second[LIMIT_VARIABLES];
    struct power p[2] = {{0}};
    const bool drags = drags_only(system);
    scaled_state(work, 0, y[0]);
    if (!system->conservative) {
        system_acceleration(system, work_time(work, 0), y[0], a[0]);
        p[0] = power_at(system, drags, work_time(work, 0), y[0]);
    }
    for (int k = 0; k < work->count; k++) {
        const int previous = k & 1, current = previous ^ 1;
        scaled_state(work, k + 1, y[current]);
        done->energy[k] = system_energy(system, y[current]);
        done->work[k] = done->drag[k] = 0;
        done->jumps[k] = done->coarse[k] = false;
        if (system->conservative)
            continue;
        const double t = work_time(work, k), h = step_length(work, k);
        system_acceleration(system, work_time(work, k + 1), y[current], a[current]);
        p[current] = power_at(system, drags, work_time(work, k + 1), y[current]);
        if (h == 0)
            continue;
        if (work_turns(system, y[previous][1], y[current][1])) {
            const struct quintic quintic = {h,
                                            y[previous][0],
                                            y[previous][1],
                                            a[previous][0],
                                            y[current][0],
                                            y[current][1],
                                            a[current][0]};
            done->jumps[k] = work_turn(system, &quintic, t, &done->work[k], &done->drag[k]);
            done->any_jumps |= done->jumps[k];
            continue;
        }
        inner_states(system->n / 2, h, y[previous], a[previous], y[current], a[current], first,
                     second);
        for (int i = 0, half = system->n / 2; i < half; i++)
            done->coarse[k] |= work_coarse(h, y[previous][i + half], y[current][i + half],
                                           a[previous][i], a[current][i]) != 0;
        done->any_coarse |= done->coarse[k];
        const double times[] = {t, t + LOBATTO_INNER * h, t + (1 - LOBATTO_INNER) * h,
                                work_time(work, k + 1)};
        done->jumps[k] =
            switches_differ(system, times, (double *[]){y[previous], first, second, y[current]});
        done->any_jumps |= done->jumps[k];
        const struct power b = power_at(system, drags, t + LOBATTO_INNER * h, first),
                           c = power_at(system, drags, t + (1 - LOBATTO_INNER) * h, second);
        done->work[k] = h * ((p[previous].all + p[current].all) + 5 * (b.all + c.all)) / 12;
        done->drag[k] = h * ((p[previous].drag + p[current].drag) + 5 * (b.drag + c.drag)) / 12;
    }
}

/* Returns the second derivative of the quintic at the fraction s of the step. */
static double quintic_acceleration(const struct quintic *p, double s)
{
    const double r = 1 - s, rs = r * s;
    const double bend =
        5 * (r - s) * (p->q1 - p->q0) / p->h - (3 - 5 * s) * p->v0 + (3 - 5 * r) * p->v1;
    return 12 * rs * bend / p->h + r * (1 - 8 * s + 10 * s * s) * p->a0 +
           s * (1 - 8 * r + 10 * r * r) * p->a1;
}

/* Returns true if the work of a step from y0 to y1, by Lobatto's rule, is accurate to `allowed`:
 * the rule on both halves of the step gives the same, and the acceleration of the quintic between
 * the states agrees with the force. */
bool work_converges(const struct system *system, double t, double h, const double *y0,
                    const double *y1, double work, double allowed)
{
    static const double point[] = {LOBATTO_INNER / 2, (1 - LOBATTO_INNER) / 2, 0.5,
                                   (1 + LOBATTO_INNER) / 2, 1 - LOBATTO_INNER / 2};
    const int half = system->n / 2;
    double a0[LIMIT_VARIABLES], a1[LIMIT_VARIABLES], a[LIMIT_VARIABLES], y[LIMIT_VARIABLES];
    double speed = 0, defect = 0, largest = 0;
    system_acceleration(system, t, y0, a0);
    system_acceleration(system, t + h, y1, a1);
    double halves = system_power(system, t, y0) + system_power(system, t + h, y1);
    for (int k = 0; k < 5; k++) {
        double wanted[LIMIT_VARIABLES];
        for (int i = 0; i < half; i++) {
            const struct quintic p = {h, y0[i], y0[i + half], a0[i], y1[i], y1[i + half], a1[i]};
            quintic_at(&p, point[k], &y[i], &y[i + half]);
            wanted[i] = quintic_acceleration(&p, point[k]);
            speed = fmax(speed, fabs(y[i + half]));
        }
        const double power = system_power(system, t + point[k] * h, y);
        halves += (k == 2 ? 2 : 5) * power;
        largest = fmax(largest, fabs(power));
        system_acceleration(system, t + point[k] * h, y, a);
        for (int i = 0; i < half; i++)
            defect = fmax(defect, fabs(a[i] - wanted[i]));
    }
    /* An acceleration that is off by d makes the velocity, which is right at both ends, off by
     * d h/8 between them, and the power of drag by twice that share of it. */
    return fabs(halves * h / 24 - work) <= allowed &&
           0.25 * largest * defect * h * h <= allowed * speed;
}

void work_between(const struct work *work, struct work_done *done)
{
    done->any_jumps = done->any_coarse = false;
    if (!work_of_terms(work, done))
        work_of_any(work, done);
}
