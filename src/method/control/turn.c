/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Turning points in steps of fixed size. A force such as |v| v has a kink at v = 0, and a step
 * across it loses its order. It is taken again up to the turning point, which is found by steps of
 * the method. Scenes without kinks are passed on to method_step() and method_march().
 */
#include <hooke/scene/typed.h>
#include "method/control/switch.h"

/* A kink within this part (times the root of the tolerance) of a step's end needs no segment of its
 * own, because its error goes with the square of the distance. */
#define NEAR_TOLERATED 0.1

/* Returns true if steps of fixed size are divided at switches. */
bool method_meets_switches(const struct method *method, const struct system *system)
{
    /* typed equations on a branch are one force, with neither a potential nor drag of its own */
    return system->pieces &&
           (system->switches == system->dry ||
            (!(method->flags & METHOD_POTENTIAL) && !(method->splitting && system->velocity)));
}

/* Returns true for methods above order 2 that can change their step, in scenes with kinks. */
bool method_turns(const struct method *method, const struct system *system)
{
    return system->kinks && !system->steps_across_kinks && !method_meets_switches(method, system) &&
           method->order > 2 && !method->splitting && !method->growth &&
           !(method->flags & (METHOD_MULTISTEP | METHOD_EXTERNAL));
}

/* Returns true if the two numbers have opposite signs. */
static bool signs_differ(double first, double second)
{
    return (first < 0 && second > 0) || (first > 0 && second < 0);
}

/* Time since the start of the step, velocity and acceleration there. */
struct near_turn {
    double x, v, a;
};

/* Evaluates velocity and acceleration of state y at time t, which is x after the start of the
 * step. */
static struct near_turn near_turn(struct step *step, double t, double x, const double *y)
{
    double a[1];
    system_acceleration(step->system, t, y, a);
    step->cost.evals++;
    return (struct near_turn){x, y[1], a[0]};
}

/* Returns the time at which v = 0 between two points, by cubic Hermite interpolation of the time as
 * a function of the velocity, or the middle if that is not between them. */
static double turning_time(const struct near_turn *p, const struct near_turn *q)
{
    const double rise = q->v - p->v, u = -p->v / rise, r = 1 - u;
    const double x =
        p->x + (q->x - p->x) * (u * u * (3 - 2 * u)) + rise * u * r * (r / p->a - u / q->a);
    return (x - p->x) * (q->x - x) > 0 ? x : p->x + (q->x - p->x) / 2;
}

/* Ends the step just taken at the turning point in it, if the velocity has changed its sign. The
 * step began at time t in state y_begin, with the low parts `low` of compensated sums (or NULL); it
 * is repeated up to better and better estimates of the turning time, until the velocity is 0 within
 * the tolerance. Sets *turned, and step->h to the length of the step. Returns the status of the
 * method's step. */
enum step_status turn_step(const struct method *method, struct step *step, double t,
                           const double *y_begin, const double *low, bool *turned)
{
    *turned = false;
    if (!signs_differ(y_begin[1], step->y[1]))
        return STEP_OK;
    const size_t size = (size_t)step->system->n * sizeof *y_begin;
    const double tolerance = fmax(TURN_NEAR, NEAR_TOLERATED * sqrt(step->tol)) * fabs(step->h);
    struct near_turn first = near_turn(step, t, 0, y_begin),
                     last = near_turn(step, t + step->h, step->h, step->y);
    double x = turning_time(&first, &last);
    if (fabs(x) <= tolerance || fabs(step->h - x) <= tolerance)
        return STEP_OK;
    *turned = true;
    for (int i = 0; i < TURN_TRIES; i++) {
        memcpy(step->y, y_begin, size);
        if (step->low)
            memcpy(step->low, low, size);
        step->t = t;
        step->h = x;
        step->warm = false;
        step->again = true;
        enum step_status status = method_step(method, step);
        if (status != STEP_OK)
            return status;
        const struct near_turn here = near_turn(step, t + x, x, step->y);
        if (fabs(here.v) <= tolerance * fabs(here.a))
            break;
        *((here.v < 0) == (first.v < 0) ? &first : &last) = here;
        x = turning_time(&first, &last);
    }
    return STEP_OK;
}

/* Takes one step of length step->h, split into segments at turning points (where the velocity
 * changes sign) for methods and systems that need it, else undivided; at most TURN_PIECES segments.
 * Systems with switches are left to switched_step(). Returns the status; on failure time and state
 * are those from before the step. */
enum step_status method_turning_step(const struct method *method, struct step *step)
{
    if (method_meets_switches(method, step->system))
        return switched_step(method, step);
    if (!method_turns(method, step->system))
        return method_step(method, step);
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    const double t = step->t, h = step->h;
    double start[2], start_low[2], y_begin[2], low[2], rest = h;
    memcpy(start, step->y, size);
    if (step->low)
        memcpy(start_low, step->low, size);
    for (int pieces = 1;; pieces++) {
        bool turned = false;
        const double t_begin = step->t;
        memcpy(y_begin, step->y, size);
        if (step->low)
            memcpy(low, step->low, size);
        step->h = rest;
        enum step_status status = method_step(method, step);
        if (status == STEP_OK && pieces < TURN_PIECES)
            status = turn_step(method, step, t_begin, y_begin, low, &turned);
        rest -= step->h;
        step->h = h;
        if (status != STEP_OK) {
            memcpy(step->y, start, size);
            if (step->low)
                memcpy(step->low, start_low, size);
            step->t = t;
            return status;
        }
        if (!turned)
            break;
        step->cost.turns++;
    }
    step->t = t + h;
    return STEP_OK;
}

/* ---- many steps, of which a kernel takes those between the turning points ---- */

/* Variables of these scenes; bounds of the number of steps tried at once; doubles of work. */
enum { N = 2, AT_ONCE_LEAST = 8, AT_ONCE_MOST = 512, WORK_MOST = 64 };

/* Returns how many of the steps to these rows come before the first that crosses zero velocity; v
 * is the velocity before the first row. */
static int64_t steps_before_turn(const double *row, int64_t count, double v)
{
    int64_t i = 0;
    while (i < count && !signs_differ(v, row[N * i + 1])) {
        v = row[N * i++ + 1];
        /* One comparison a row is enough while the sign stays. */
        if (v > 0)
            while (i < count && row[N * i + 1] > 0)
                i++;
        else if (v < 0)
            while (i < count && row[N * i + 1] < 0)
                i++;
    }
    return i;
}

/* Takes up to march->count steps by the kernel and discards those from the first turning point on,
 * as if they had not been taken. Returns the number of the others. */
static int64_t march_straight(const struct method *method, march_function *kernel,
                              const struct march *march)
{
    struct step *step = march->step;
    const size_t size = method_work_size(method, N) * sizeof *step->work;
    const struct step was = *step;
    double y[N], work[WORK_MOST];
    memcpy(y, step->y, sizeof y);
    memcpy(work, step->work, size);
    const int64_t taken = kernel(method, march);
    struct march good = *march;
    good.count = steps_before_turn(march->row, taken, y[1]);
    if (good.count == taken)
        return taken;
    *step = was;
    memcpy(step->y, y, sizeof y);
    memcpy(step->work, work, size);
    if (good.count > 0)
        kernel(method, &good);
    return good.count;
}

/* Does the same as march_straight() on the branch of dry friction that holds at the start. */
static int64_t march_on_branch(const struct method *method, march_function *kernel,
                               const struct march *march)
{
    struct step *step = march->step;
    const struct system *whole = step->system;
    struct system frozen;
    double branch[LIMIT_SWITCHES];
    system_branches(whole, step->t, step->y, branch);
    system_freeze(whole, branch, &frozen);
    step->system = &frozen;
    const int64_t taken = march_straight(method, kernel, march);
    step->system = whole;
    return taken;
}

/* Fills all remaining rows with the same state if a body sticks and nothing depends on time.
 * Returns true if it did. */
static bool march_at_rest(const struct march *march, const double *previous, int64_t done)
{
    const struct step *step = march->step;
    if (!step->system->dry || !step->system->autonomous ||
        memcmp(previous, step->y, N * sizeof *previous) != 0)
        return false;
    for (; done < march->count; done++)
        memcpy(march->row + done * N, step->y, N * sizeof *step->y);
    return true;
}

/* Returns how many steps to try at once: up to the zero of a parabola through the velocities of the
 * last three rows before `row`, which for an oscillation comes early; 0 next to a turning point.
 * While the speed still grows, that zero is too far ahead to be relied on, and the number grows
 * from `last` instead. */
static int64_t steps_to_try(const double *row, int64_t last, bool branches)
{
    const double v = row[-1], rise = v - row[-1 - N], bend = rise - (row[-1 - N] - row[-1 - 2 * N]),
                 slope = rise + bend / 2, square = slope * slope - 2 * bend * v;
    const bool slows = v * slope < 0;
    const double left = -2 * v / (slope + copysign(sqrt(fmax(square, 0)), slope));
    const double grown = (double)(last < AT_ONCE_LEAST ? AT_ONCE_LEAST : 2 * last);
    double max = grown < AT_ONCE_MOST ? grown : AT_ONCE_MOST;
    /* a wrong try costs more if the force jumps at the turn, as stages are on both sides of it */
    if (branches)
        max = fabs(v / rise) < 2 * AT_ONCE_LEAST ? 0 : fmin(max, fabs(v / rise) / 2);
    else if (slows && square >= 0)
        max = fmin(max, left);
    return max >= 1 ? (int64_t)max : 0;
}

/* Takes the march->count steps of a march in a scene with turning points or switches: many at once
 * by the kernel (NULL if there is none) between them, single ones next to them. The states are
 * stored in march->row. Returns the number of steps taken, and *status tells why the march ended
 * early. */
int64_t method_turning_march(const struct method *method, march_function *kernel,
                             const struct march *march, enum step_status *status)
{
    struct step *step = march->step;
    const struct system *whole = step->system;
    if (method_meets_switches(method, whole) && whole->switches > whole->dry)
        return switched_march(method, march, status);
    if (!method_turns(method, whole) && !method_meets_switches(method, whole))
        return method_march(method, kernel, march, status);
    const bool fast = kernel && method_work_size(method, N) <= WORK_MOST;
    int64_t done = 0, batch = 0;
    *status = STEP_OK;
    while (done < march->count) {
        struct march part = *march;
        part.first += done;
        part.row += done * N;
        const bool can_try = fast && done > 2 && step->y[1] != 0 && !whole->extended;
        batch = can_try ? steps_to_try(part.row, batch, whole->pieces) : 0;
        if (batch > 0) {
            part.count = march->count - done;
            if (part.count > batch)
                part.count = batch;
            const int64_t straight = whole->pieces ? march_on_branch(method, kernel, &part)
                                                   : march_straight(method, kernel, &part);
            done += straight;
            if (straight > 0)
                continue;
        }
        double previous[N];
        memcpy(previous, step->y, sizeof previous);
        step->t = march->origin + (double)(march->first + done) * step->h;
        *status = method_turning_step(method, step);
        if (*status != STEP_OK)
            return done;
        memcpy(march->row + done++ * N, step->y, N * sizeof *step->y);
        if (march_at_rest(march, previous, done))
            return march->count;
    }
    return done;
}
