/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The oscillator with dry friction and no drive: between turning points a damped oscillation about
 * a centre that is shifted by phi = friction / w2 against the motion (den Hartog 1931, Trans. ASME
 * 53:107). All half swings last pi / omega, and with rho = exp(-gamma pi / (2 omega)) the distances
 * from the middle at turning points follow
 *
 *   A_(n+1) = rho A_n - (1 + rho) phi,   A_n = rho^n A_0 - (1 + rho) phi (rho^n - 1)/(rho - 1),
 *
 * until one is at most phi: there the body stays. So any time is reached at once, before the start
 * as well as after it; from rest there is no way back. With roots that are real a body turns at
 * most once.
 */
#include "scene/model/exact.h"

#include <float.h>
#include <math.h>

typedef long double real; /* as in exact.c */

#define PI 3.14159265358979323846264338327950288L

/* Returns true for an oscillator with dry friction, without drive and quadratic drag. */
bool dry_has_exact(const struct system *system)
{
    const struct oscillator *o = &system->oscillator;
    bool fine =
        system->order == 2 && system->n == 2 && o->whole && o->friction > 0 && o->drive == 0;
    for (int i = 0; fine && i < system->terms; i++)
        fine = system->term[i].row->flags & (TERM_LINEAR | TERM_DRY);
    return fine && o->quadratic == 0;
}

/* Computes the state y after `time` from `start` on the branch of dry friction for motion in the
 * direction `side` (1 or -1). */
static void dry_motion_advance(const struct oscillator *o, double side, const double *start,
                               real time, double *y)
{
    struct oscillator branch = *o;
    branch.gravity += side * o->friction;
    branch.friction = 0;
    oscillator_exact(&branch, 0, start, (double)time, y, NULL);
}

/* Returns the angular frequency [1/s] of the swings, or, if the roots are real, minus half their
 * distance. */
static real frequency(const struct oscillator *o)
{
    const real s = (real)o->damping / 2, discriminant = fmal(-s, s, (real)o->stiffness);
    return discriminant > 0 ? sqrtl(discriminant) : -sqrtl(-discriminant);
}

/* Returns the time from the start until the body under dry friction stops or, for forward = -1, the
 * negative time since it last was at rest. It solves |v0| cos(omega t) = (pull / omega) sin(omega
 * t); omega = 0 is the limit, and omega < 0 stands for hyperbolic functions with -omega. Returns
 * infinity with the sign of forward if there is no such time. */
static real turning_time(const struct oscillator *o, real omega, const double *start, real forward)
{
    const real speed = fabsl((real)start[1]), side = start[1] > 0 ? 1 : -1;
    const real force =
        (real)o->stiffness * (real)start[0] + (real)o->gravity + side * (real)o->friction;
    const real pull = side * (force + (real)o->damping * (real)start[1] / 2);
    if (omega > 0)
        return (atan2l(speed * omega, pull) - (forward < 0 ? PI : 0)) / omega;
    const real deceleration = forward * pull, ratio = speed * -omega / deceleration;
    if (!(deceleration > 0) || !(ratio < 1))
        return forward * HUGE_VALL;
    return forward * (omega < 0 ? atanhl(ratio) / -omega : speed / deceleration);
}

/* Returns A_n, the distance from the middle at turning point n, where `first` is A_0. */
static real amplitude(const struct oscillator *o, real omega, real first, real n)
{
    const real log_rho = -(real)o->damping * PI / (2 * omega),
               phi = (real)o->friction / (real)o->stiffness;
    const real sum = log_rho != 0 ? expm1l(n * log_rho) / expm1l(log_rho) : n;
    return expl(n * log_rho) * first - (1 + expl(log_rho)) * phi * sum;
}

/* Returns the first n up to `max` at which the body stays, or max + 1 if it does not. Bisection is
 * possible because A_n falls up to there, or grows for ever. */
static real sticking(const struct oscillator *o, real omega, real first, real max)
{
    const real phi = (real)o->friction / (real)o->stiffness;
    if (!(max >= 1) || amplitude(o, omega, first, max) > phi)
        return max + 1;
    real lower = 0, upper = max;
    while (upper - lower > 1) {
        const real middle = floorl((lower + upper) / 2);
        if (amplitude(o, omega, first, middle) > phi)
            lower = middle;
        else
            upper = middle;
    }
    return upper;
}

/* Sets y to rest at q. */
static void resting_state_set(double q, double *y)
{
    y[0] = q;
    y[1] = 0;
}

/* Computes the state y after `time` from rest at q, where the force is larger than friction: whole
 * half swings by A_n, and the last one by its branch. */
static void swing(const struct oscillator *o, real omega, double q, real time, double *y)
{
    const double force = -(o->stiffness * q + o->gravity), away = force > 0 ? 1 : -1;
    const double start[2] = {q, 0};
    if (!(omega > 0)) {
        dry_motion_advance(o, time < 0 ? -away : away, start, time, y);
        return;
    }
    const real middle = -(real)o->gravity / (real)o->stiffness, half = PI / omega,
               first = fabsl((real)q - middle);
    const real whole = floorl(fabsl(time) / half),
               stuck = time > 0 ? sticking(o, omega, first, whole) : whole + 1;
    const real n = time > 0 ? fminl(whole, stuck) : -whole;
    const bool is_right = (real)q > middle, is_odd = fmodl(fabsl(n), 2) == 1;
    const real side = is_right == is_odd ? -1 : 1; /* that on which turning point n is */
    const double turning_state[2] = {(double)(middle + side * amplitude(o, omega, first, n)), 0};
    const real direction = time > 0 ? -side : side;
    if (stuck <= whole)
        resting_state_set(turning_state[0], y);
    else
        dry_motion_advance(o, (double)direction, n == 0 ? start : turning_state, time - n * half,
                           y);
}

/* Moves to the first turning point, and swings or sticks from there. */
void dry_exact(const struct system *system, double t0, const double *start, double t, double *y,
               double *floor)
{
    const struct oscillator *o = &system->oscillator;
    const real omega = frequency(o), time = (real)t - (real)t0, forward = time < 0 ? -1 : 1;
    const real turn = start[1] != 0 ? turning_time(o, omega, start, forward) : 0;
    const double first[2] = {start[0], start[1]};
    if (start[1] != 0 && fabsl(turn) >= fabsl(time)) {
        dry_motion_advance(o, start[1] > 0 ? 1 : -1, first, time, y);
    } else {
        double turning_state[2] = {first[0], 0};
        if (start[1] != 0)
            dry_motion_advance(o, start[1] > 0 ? 1 : -1, first, turn, turning_state);
        if (fabs(o->stiffness * turning_state[0] + o->gravity) <= o->friction &&
            (forward > 0 || start[1] == 0))
            resting_state_set(turning_state[0], y);
        else
            swing(o, omega, turning_state[0], time - turn, y);
    }
    if (!floor)
        return;
    /* An ulp of the coefficients moves the amplitude by ulps, and the phase by ulps of itself. */
    const double fast = hypot(sqrt(fabs(o->stiffness)), o->damping), eps = DBL_EPSILON;
    const double rate = fast > 0 ? fast : 1, size = fmax(fabs(y[0]), fabs(y[1]) / rate);
    const double began = fmax(fabs(first[0]), fabs(first[1]) / rate);
    floor[0] = eps * (4 * began + rate * fabs((double)time) * (y[1] != 0 ? size : 0));
    floor[1] = rate * floor[0];
}
