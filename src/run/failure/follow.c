/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Accurate solutions beside a run, and where they end, as x = 1/(t* - t) of x' = x^2 does at t*. On
 * the way to such a time steps shrink in proportion to t* - t until they make no progress, and the
 * speed |y'| grows like a power of 1/(t* - t) (Goriely, Hyde 2000, J. Differ. Equ. 161:422). */
#include <hooke/base/cancel.h>
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <math.h>
#include <stdlib.h>

/* ---- steps that shrink ---- */

/* Powers of ten of the step that are kept, and more than DECADES_SEEN are needed for a power. */
enum { DECADES_MAX = 32, DECADES_SEEN = 3 };

/* The steps h [s], each shorter than the one before by a factor of ten or more, and the speeds at
 * them, since steps were last longer. */
struct shrinking {
    double h[DECADES_MAX], speed[DECADES_MAX];
    int count;
};

/* Returns |y'| [1/s] in natural sizes of the variables. */
static double scaled_speed(const struct system *system, double t, const double *y)
{
    double f[LIMIT_VARIABLES], sum = 0;
    system_derivative(system, t, y, f);
    for (int i = 0; i < system->n; i++)
        sum += f[i] / system->scale[i] * (f[i] / system->scale[i]);
    return sqrt(sum);
}

/* Enters the step h from the state y at t: drops shorter ones that came before it, because steps
 * did not shrink there, and adds it if it is at most a tenth of the last one kept. */
static void shrinking_add(struct shrinking *s, double h, const struct system *system, double t,
                          const double *y)
{
    while (s->count > 0 && h > s->h[s->count - 1])
        s->count--;
    if (s->count == DECADES_MAX || (s->count > 0 && 10 * h > s->h[s->count - 1]))
        return;
    s->h[s->count] = h;
    s->speed[s->count++] = scaled_speed(system, t, y);
}

/* Returns the q of |y'| ~ (t* - t)^-q over the steps that shrink, NAN if these cover too few
 * decades. The first third of them, far from t*, and the last quarter, which rounding spoils, are
 * left out. */
static double shrinking_power(const struct shrinking *s)
{
    const int first = s->count / 3, last = s->count - 1 - s->count / 4;
    return s->count <= DECADES_SEEN
               ? NAN
               : fixed_log(s->speed[last] / s->speed[first]) / fixed_log(s->h[first] / s->h[last]);
}

/* ---- following ---- */

/* Method, accuracy and limits with which a solution is followed. */
struct pursuit {
    const char *method_name;
    double tol;
    int64_t steps_max;
    /* Steps shorter than this part of the way so far count as no progress. */
    double creep;
};

/* Returns the system with natural sizes at most those of the state y [n], from which it is
 * followed: the sizes may have been taken from a solution on its way to infinity. */
static struct system with_start_scale(const struct system *system, const double *y)
{
    struct system scaled = *system;
    double size = 0;
    for (int i = 0; i < system->n; i++)
        size = fmax(size, fabs(y[i]) / system->scale[i]);
    for (int i = 0; i < system->n && size > 0 && size < 1; i++)
        scaled.scale[i] *= size;
    return scaled;
}

/* Returns true if a solution has come near the largest state that a run may have. */
static bool is_large(const struct system *system, const double *y)
{
    static const double share = 1e-30;
    bool large = false;
    for (int i = 0; i < system->n; i++)
        large = large || !(fabs(y[i]) <= share * run_bound(system, i));
    return large;
}

/* Follows a solution from y [n] at t to `end`, as `pursuit` says, and fills *followed: the solution
 * ends if steps make no more progress and the speed has grown as it does before a singularity. */
static void solution_pursue(const struct system *system, double t, const double *y, double end,
                            const struct pursuit *pursuit, const struct cancel *cancel,
                            struct followed *followed)
{
    static const double power_min = 0.3, finite_max = 0.95; /* |y'| may be integrated up to there */
    const struct method *method = method_find(pursuit->method_name);
    double *work = method ? malloc((method_work_size(method, system->n) + 1) * sizeof *work) : NULL;
    struct step step = {.system = system, .y = followed->y, .work = work, .t = t};
    struct controller controller = {.tol = pursuit->tol};
    struct shrinking shrinking = {.count = 0};
    bool progresses = work, stopped = !work;
    copy_state(followed->y, y, system->n);
    for (int64_t steps = 0; progresses && step.t != end && !is_large(system, followed->y);
         steps++) {
        if ((stopped = steps == pursuit->steps_max || cancelled(cancel)))
            break;
        const double previous_t = step.t;
        double previous_y[LIMIT_VARIABLES];
        copy_state(previous_y, followed->y, system->n);
        progresses = method_adapt(method, &step, &controller, end) == STEP_OK &&
                     fabs(step.t - previous_t) >= pursuit->creep * fabs(step.t - t);
        if (step.t != previous_t)
            shrinking_add(&shrinking, fabs(step.t - previous_t), system, previous_t, previous_y);
    }
    free(work);
    const double power = shrinking_power(&shrinking);
    followed->t = step.t;
    followed->finite = power < finite_max;
    followed->fate = SOLUTION_UNKNOWN;
    if (stopped)
        return;
    if (!progresses)
        followed->fate = power > power_min ? SOLUTION_ENDS : SOLUTION_UNKNOWN;
    else
        followed->fate = step.t == end ? SOLUTION_GOES_ON : SOLUTION_GROWS;
}

void run_follow(const struct system *system, double t, const double *y, double end,
                int64_t steps_max, const struct cancel *cancel, struct followed *followed)
{
    const struct system scaled = with_start_scale(system, y);
    const struct pursuit accurate = {"dop853", 1e-11, steps_max, 1e-11};
    solution_pursue(&scaled, t, y, end, &accurate, cancel, followed);
}

/* Tries a method for smooth equations, and then one for stiff ones. */
void run_follow_cheaply(const struct system *system, double t, const double *y, double end,
                        double tol, const struct cancel *cancel, struct followed *followed)
{
    /* radau5 is for stiff equations; its linear systems take far longer in many variables. */
    const struct pursuit smooth = {"dop853", tol, 32, 0}, stiff = {"radau5", tol, 2000, 0};
    solution_pursue(system, t, y, end, &smooth, cancel, followed);
    if (followed->t != end)
        solution_pursue(system, t, y, end, &stiff, cancel, followed);
}

/* Follows the solution in at most 100 steps of low accuracy. */
bool run_seems_to_end(const struct system *system, double t, const double *y, double end,
                      const struct cancel *cancel)
{
    const struct pursuit brief = {"dop853", 1e-7, 100, 1e-5};
    struct followed followed;
    solution_pursue(system, t, y, end, &brief, cancel, &followed);
    return followed.fate == SOLUTION_ENDS;
}

/* Sets y_end to the solution at `end`. Returns false if it was not reached. */
bool run_solve_cheaply(const struct system *system, double t, const double *y, double end,
                       double tol, double *y_end, const struct cancel *cancel)
{
    struct followed followed;
    run_follow_cheaply(system, t, y, end, tol, cancel, &followed);
    if (followed.t == end)
        copy_state(y_end, followed.y, system->n);
    return followed.t == end;
}

bool run_is_never_singular(const struct system *system)
{
    return system->linear && (system->autonomous || system->oscillator.whole);
}

/* Follows the solution to `end`; t is NAN if it does not end before. */
struct singularity system_singularity(const struct system *system, double t, const double *y,
                                      double end, const struct cancel *cancel)
{
    struct followed followed = {.fate = SOLUTION_UNKNOWN};
    if (!run_is_never_singular(system))
        run_follow(system, t, y, end, FOLLOW_STEPS_MAX, cancel, &followed);
    return (struct singularity){.t = followed.fate == SOLUTION_ENDS ? followed.t : NAN,
                                .finite = followed.finite};
}

const char *singularity_text(const struct singularity *singularity)
{
    return singularity->finite ? "gets an infinite slope" : "goes to infinity";
}
