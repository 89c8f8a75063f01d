/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Newton's iteration for the stages of implicit methods, and the closed form for the oscillator.
 * Source: Hairer, Wanner 1996, Solving ODEs II, IV.8 (transformed systems, stopping); Hairer, McLachlan, Razakarivony
 * 2008, BIT 48:231 (to rounding).
 */
#include "newton.h"

#include <float.h>

#include "lu.h"

/* Halvings of an increment that does not bring the equations nearer to 0, and iterations before giving up. */
enum { HALVINGS = 8, ITERATIONS = 30, ADAPTIVE_ITERATIONS = 7 };

static const double STANDSTILL = 1e-10; /* an increment this small (relative) that shrinks no more is rounding */
static const double SLOW = 0.1;         /* increments that shrink by less than this want a new Jacobian */
static const double FAST = 1e-3;        /* increments that shrink by this in an adaptive step: keep the Jacobian */

/* Of the tolerance of an adaptive step, what the iteration may leave; in finer steps errors of many add up. */
static double share(double tol)
{
    return fmax(10 * DBL_EPSILON / tol, fmin(0.03, sqrt(tol)));
}

static const double one[] = {1}, now[] = {0};
static const struct implicit_tableau euler = {
    .stages = 1, .c = now, .a = one, .b = one, .d = one, .real = 1, .left = one, .right = one};
const struct newton newton_euler = {&euler, newton_stages};

/* What newton_room() holds. */
struct room {
    double *h;    /* of the factors, 0: there are none */
    double *rate; /* by which increments shrank in the last solution */
    double *slope, *rest, *move, *jacobian, *real, *complex;
};

size_t newton_room(int stages, int n)
{
    return 2 + (size_t)(3 * stages + n) * (size_t)n + 3 * LU_ROOM(n);
}

static struct room room_of(int stages, int n, double *work)
{
    struct room room = {.h = work, .rate = work + 1, .slope = work + 2};
    room.rest = room.slope + stages * n;
    room.move = room.rest + stages * n;
    room.jacobian = room.move + stages * n;
    room.real = room.jacobian + n * n;
    room.complex = room.real + LU_ROOM(n);
    return room;
}

void newton_forget(double *work)
{
    work[0] = 0;
    work[1] = 1;
}

/* The factors of real - h J and alpha + i beta - h J, with J at t and y. */
static bool factor(const struct implicit_tableau *tableau, struct step *step, double t, double h, const double *y,
                   struct room *room)
{
    int n = step->system->n;
    double *re = room->complex, *im = re + LU_ROOM(n);
    system_jacobian(step->system, t, y, room->jacobian);
    step->cost.jacobians++;
    *room->h = 0;
    for (int i = 0; i < n * n; i++) {
        double hj = h * room->jacobian[i], unit = i % (n + 1) == 0;
        room->real[i] = tableau->real * unit - hj;
        re[i] = tableau->alpha * unit - hj;
        im[i] = tableau->beta * unit;
    }
    if ((tableau->real != 0 && !lu_factor(n, room->real)) || (tableau->beta != 0 && !lu_factor_complex(n, re)))
        return false;
    *room->h = h;
    return true;
}

#define INSTANCE static inline __attribute__((always_inline)) /* for `stages` known to the compiler */

/* x_i = sum_j m_ij x_j for each component of x [stages][n] */
INSTANCE void mix_stages(int stages, int n, const double *m, double *x)
{
    for (int i = 0; i < n; i++) {
        double old[3];
        for (int s = 0; s < stages; s++)
            old[s] = x[s * n + i];
        for (int s = 0; s < stages; s++) {
            double sum = -0.0;
            for (int j = 0; j < stages; j++)
                sum += m[s * stages + j] * old[j];
            x[s * n + i] = sum;
        }
    }
}

static void mix(int stages, int n, const double *m, double *x)
{
    stages == 1 ? mix_stages(1, n, m, x) : stages == 2 ? mix_stages(2, n, m, x) : mix_stages(3, n, m, x);
}

/* x [stages][n] becomes (1 - h a J)^-1 x. */
static void solve(const struct implicit_tableau *tableau, struct step *step, const struct room *room, double *x)
{
    int n = step->system->n, pair = tableau->real != 0;
    mix(tableau->stages, n, tableau->left, x);
    if (pair)
        lu_solve(n, room->real, x);
    if (tableau->beta != 0)
        lu_solve_complex(n, room->complex, x + pair * n, x + (pair + 1) * n);
    mix(tableau->stages, n, tableau->right, x);
    step->cost.solves++;
}

bool newton_filter(const struct implicit_tableau *tableau, struct step *step, double t, double h, const double *y,
                   double *x, double *work)
{
    struct room room = room_of(tableau->stages, step->system->n, work);
    if (*room.h != h && !factor(tableau, step, t, h, y, &room))
        return false;
    lu_solve(step->system->n, room.real, x);
    step->cost.solves++;
    return true;
}

void newton_stages(const struct implicit_tableau *tableau, struct step *step, double t, double h, const double *y,
                   const double *z, double *slope, double *rest)
{
    int n = step->system->n, stages = tableau->stages;
    double sum[LIMIT_VARIABLES];
    for (int s = 0; s < stages; s++) {
        for (int i = 0; i < n; i++)
            sum[i] = y[i] + z[s * n + i];
        system_derivative(step->system, t + tableau->c[s] * h, sum, slope + s * n);
    }
    step->cost.evals += stages;
    memcpy(rest, slope, (size_t)(stages * n) * sizeof *rest);
    mix(stages, n, tableau->a, rest);
    for (int i = 0; i < stages * n; i++)
        rest[i] = h * rest[i] - z[i];
}

/* Largest of x [stages][n], each component by its weight; NaN if one is. */
static double size_of(int stages, int n, const double *weight, const double *x)
{
    double largest = 0;
    for (int s = 0; s < stages; s++)
        for (int i = 0; i < n; i++) {
            double size = fabs(x[s * n + i]) * weight[i];
            if (!(size <= largest))
                largest = size;
            if (isnan(size))
                return size;
        }
    return largest;
}

/* A new Jacobian, at the middle stage of where the iteration has come to. */
static bool renew(const struct implicit_tableau *tableau, struct step *step, double t, double h, const double *y,
                  const double *z, struct room *room)
{
    int n = step->system->n, middle = tableau->stages / 2;
    double sum[LIMIT_VARIABLES];
    for (int i = 0; i < n; i++)
        sum[i] = y[i] + z[middle * n + i];
    return factor(tableau, step, t + tableau->c[middle] * h, h, sum, room);
}

/* Half of the last increment is taken back. */
static void halve(int count, double *z, double *move)
{
    for (int i = 0; i < count; i++) {
        move[i] /= 2;
        z[i] -= move[i];
    }
}

/*
 * Until increments stop decreasing: a tolerance would bias the rounding. An increment that does not bring the equations
 * nearer to 0 is halved.
 */
static enum step_status iterate(const struct newton *equations, struct step *step, double t, double h, const double *y,
                                double *z, const double *weight, struct room *room)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int n = step->system->n, stages = tableau->stages;
    double last = HUGE_VAL, off = HUGE_VAL;
    for (int iteration = 0, halvings = 0; iteration < ITERATIONS;) {
        equations->rest(tableau, step, t, h, y, z, room->slope, room->rest);
        double rest = size_of(stages, n, weight, room->rest);
        if (iteration == 0 && !isfinite(rest))
            return STEP_NONFINITE;
        if (!(rest < off) && last > STANDSTILL) {
            if (++halvings > HALVINGS)
                return STEP_NO_SOLUTION;
            halve(stages * n, z, room->move);
            continue;
        }
        memcpy(room->move, room->rest, (size_t)(stages * n) * sizeof *z);
        solve(tableau, step, room, room->move);
        double size = size_of(stages, n, weight, room->move);
        for (int i = 0; i < stages * n; i++)
            z[i] += room->move[i];
        if (step->system->linear || size <= DBL_EPSILON / 2 || (size >= last && size <= STANDSTILL))
            return STEP_OK;
        if (size > SLOW * last && !renew(tableau, step, t, h, y, z, room))
            return STEP_NO_SOLUTION;
        last = size;
        off = rest;
        halvings = 0;
        iteration++;
    }
    return last <= STANDSTILL ? STEP_OK : STEP_NO_SOLUTION;
}

/*
 * Until what is left, by the rate at which increments shrink, is `enough`. The rate is the one of this solution: a
 * single increment is accepted only if it is itself that small, because what earlier steps needed says nothing about
 * this one (Hairer and Wanner carry a rate over, but let it age). Parts that shrink slowly may still hide behind
 * faster ones, as across a kink: hence the caution.
 */
static enum step_status approach(const struct newton *equations, struct step *step, double t, double h, const double *y,
                                 double *z, const double *weight, double enough, struct room *room)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int n = step->system->n, stages = tableau->stages;
    double last = 0, left = 1; /* left: of an increment */
    *room->rate = sqrt(*room->rate); /* it ages, so that factors are not kept for ever without being seen to be good */
    for (int iteration = 0; iteration < ADAPTIVE_ITERATIONS; iteration++) {
        equations->rest(tableau, step, t, h, y, z, room->slope, room->rest);
        solve(tableau, step, room, room->rest);
        double size = size_of(stages, n, weight, room->rest);
        if (!isfinite(size))
            return STEP_NONFINITE;
        for (int i = 0; i < stages * n; i++)
            z[i] += room->rest[i];
        if (last > 0) {
            double rate = *room->rate = size / last;
            if (rate >= 1)
                return STEP_NO_SOLUTION;
            left = rate / (1 - rate);
            double end = left * size; /* what the last iteration will leave */
            for (int rest = iteration + 1; rest < ADAPTIVE_ITERATIONS; rest++)
                end *= rate;
            if (end > enough)
                return STEP_NO_SOLUTION;
            left = sqrt(left * sqrt(left)); /* with caution */
        }
        if (left * size <= enough)
            return STEP_OK;
        last = size;
    }
    return STEP_NO_SOLUTION;
}

enum step_status newton_solve(const struct newton *equations, struct step *step, double t, double h, const double *y,
                              double *z, double *work)
{
    const struct system *system = step->system;
    const bool adaptive = step->tol > 0 && !system->linear;
    struct room room = room_of(equations->tableau->stages, system->n, work);
    double weight[LIMIT_VARIABLES];
    for (int i = 0; i < system->n; i++) {
        double size = fabs(y[i]);
        weight[i] = 1 / (size > system->scale[i] ? size : system->scale[i]);
    }
    bool kept = *room.h == h && (system->linear || (adaptive && *room.rate <= FAST));
    if (!kept && !factor(equations->tableau, step, t, h, y, &room))
        return STEP_NO_SOLUTION;
    return adaptive ? approach(equations, step, t, h, y, z, weight, share(step->tol) * step->tol, &room)
                    : iterate(equations, step, t, h, y, z, weight, &room);
}

/* ---- one stage ---- */

/*
 * q' = q + h v', v' = v + h (F(q) - stiffness h v' - damping v' - quadratic |v'| v'): a scalar equation in v', because
 * the force that does not depend on velocity is linear in q.
 */
static enum step_status solve_oscillator(struct step *step, double t, double h, const double *y, double *z, double *sum)
{
    const struct oscillator *o = &step->system->oscillator;
    double force;
    system_force(step->system, t, y, &force);
    step->cost.evals++;
    step->cost.solves++;
    double a = 1 + o->damping * h + o->stiffness * h * h, r = y[1] + h * force;
    if (!isfinite(a) || !isfinite(r))
        return STEP_NONFINITE;
    double v = drag_root(a, o->quadratic * h, r);
    /* Where it is small, the increment by the force: the rounding of a would shift v in the same way at every step. */
    bool small = fabs(a - 1 + o->quadratic * h * fabs(v)) < 1;
    z[0] = h * v;
    z[1] = small ? h * (force - (o->stiffness * h + o->damping + o->quadratic * fabs(v)) * v) : v - y[1];
    sum[0] = y[0] + z[0];
    sum[1] = small ? y[1] + z[1] : v;
    return isfinite(v) ? STEP_OK : STEP_NO_SOLUTION;
}

enum step_status newton_stage(struct step *step, double t, double h, const double *y, double *z, double *sum,
                              double *work)
{
    const struct system *system = step->system;
    if (system->order == 2 && system->n == 2 && system->oscillator.whole)
        return solve_oscillator(step, t, h, y, z, sum);
    memset(z, 0, (size_t)system->n * sizeof *z);
    enum step_status status = newton_solve(&newton_euler, step, t, h, y, z, work);
    for (int i = 0; i < system->n; i++)
        sum[i] = y[i] + z[i];
    return status;
}

size_t newton_work(const struct method *method, int n)
{
    (void)method;
    return 3 * (size_t)n + newton_room(1, n);
}

enum step_status implicit_euler_solve(struct step *step, double t, double h, const double *y, double *z, double *work)
{
    newton_forget(work + step->system->n);
    return newton_stage(step, t, h, y, work, z, work + step->system->n);
}
