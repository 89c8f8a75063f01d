/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checks of the work that the quintic between two states gives. It is wrong where a force jumps,
 * where the velocity settles within a step, where the acceleration is a small difference of large
 * forces, and where the method is of a higher order. For such steps the equations are solved again
 * from the beginning of the step, and the work is the change of energy of that solution. */
#include <hooke/base/cancel.h>
#include "run/energy/work.h"

#include <float.h>
#include <math.h>

/* Share of the energy, in rounding units, below which a difference after one step means nothing. */
static const double energy_rounding_units = 64;
/* The same share for adaptive runs, as a part of their tolerance. */
static const double missing_tolerance_fraction = 1e-3;
/* Tolerance of the solution, as a part of the run's own, and its largest and smallest value. */
static const double solution_tolerance_fraction = 1e-3;
static const double solution_tolerance_max = 1e-12, solution_tolerance_min = 1e-14;
/* Share of the difference after a step that may come from the quadrature. */
static const double quadrature_error_fraction = 0.05;
/* Largest number of steps of a run that are solved again, unless that is less than one in
 * SOLVED_PART of all so far: more would take far longer than the run itself. The work in further
 * ones is unknown. */
enum { SOLVED_STEPS_MAX = 4000, SOLVED_PART = 10 };

/* Returns the state after k steps of the block, in the run's own units. */
static const double *state_after(const struct work *work, int k)
{
    return k == 0 ? work->initial_state : work->row + (size_t)(k - 1) * work->stride;
}

/* Returns the energy after k steps of the block, in units of factor^2 J. */
static double energy_after(const struct run *run, const struct work *work,
                           const struct work_done *done, int k)
{
    return k == 0 ? balance_energy(run, work->system, work->initial_state) : done->energy[k - 1];
}

/* Returns |E - E before - work| of step k. */
static double missing_after(const struct run *run, const struct work *work,
                            const struct work_done *done, int k)
{
    return fabs(done->energy[k] - energy_after(run, work, done, k) - done->work[k]);
}

/* Returns true if the error of the work of step k, the integral of the power along a quintic
 * polynomial, is a small fraction of `missing`, the energy by which that step is out of balance. */
static bool quadrature_converges(const struct work *work, const struct work_done *done, int k,
                                 double missing)
{
    double y[2][LIMIT_VARIABLES];
    const double t = work_time(work, k), h = work_time(work, k + 1) - t;
    for (int i = 0; i < work->system->n; i++) {
        y[0][i] = state_after(work, k)[i] * work->factor;
        y[1][i] = state_after(work, k + 1)[i] * work->factor;
    }
    return work_converges(work->system, t, h, y[0], y[1], done->work[k],
                          quadrature_error_fraction * missing);
}

/* Sets the work of step k to the change of energy along an accurate solution that begins at the
 * same state, as long as few steps of the balance have been solved (`allowed`). If no solution is
 * found, the work becomes NAN unless the quadrature converges. If drag did all the work
 * (`all_drag`), its share is set, too. */
static void solve_step(const struct run *run, struct balance *balance, const struct work *work,
                       struct work_done *done, int k)
{
    struct system turning = *work->system;
    const struct system *const system = &turning;
    const double t = work_time(work, k), end = work_time(work, k + 1);
    const double tol =
        fmax(fmin(solution_tolerance_max, run->plan.adaptive
                                              ? solution_tolerance_fraction * run->settings.tol
                                              : solution_tolerance_max),
             solution_tolerance_min);
    const bool all_drag = memcmp(&done->drag[k], &done->work[k], sizeof done->work[k]) == 0,
               allowed = balance->solved < SOLVED_STEPS_MAX ||
                         balance->solved < balance->step / SOLVED_PART;
    const double *y_begin = state_after(work, k);
    double y_end[LIMIT_VARIABLES];
    /* Ctrl-C is ignored if rows have marks: these are computed once, and stay. */
    const struct cancel *cancel = trace_marked(run->trace) ? NULL : run->cancel;
    balance->solved++;
    system_turn_at_kinks(&turning);
    if (allowed && run_solve_cheaply(system, t, y_begin, end, tol, y_end, cancel))
        done->work[k] = balance_energy(run, system, y_end) - energy_after(run, work, done, k);
    else if ((done->any_jumps && done->jumps[k]) ||
             !quadrature_converges(work, done, k, missing_after(run, work, done, k)))
        done->work[k] = NAN;
    if (all_drag)
        done->drag[k] = done->work[k];
}

/* Returns true if the energy after one of the steps from `begin` on differs by more than `share` of
 * it from that before the step and the work, in a loop that vectorises. */
CLONES static bool is_any_missing(const struct work_done *done, double initial, double share,
                                  int begin, int count)
{
    const double size = fabs(initial);
    int64_t any = 0;
    for (int k = begin; k < count; k++) {
        const double energy = fabs(done->energy[k]);
        any |= fabs(done->energy[k] - done->energy[k - 1] - done->work[k]) >
               share * (energy > size ? energy : size);
    }
    return any != 0;
}

/* Computes the work of those steps of a block again, by solve_step(), in which the force jumps, or
 * the energy differs from that before plus the work by more than rounding and the tolerance; fixed
 * steps only if the quadrature of the work is inaccurate. */
void work_check(const struct run *run, struct balance *balance, const struct work *work,
                struct work_done *done)
{
    const double share =
        fmax(run->plan.adaptive ? missing_tolerance_fraction * run->settings.tol : 0,
             energy_rounding_units * DBL_EPSILON);
    if (isnan(balance->tally.work.high)) /* nothing is known from there on */
        return;
    /* The steps after the first are checked together, because most blocks have nothing to solve. */
    const bool any = done->any_jumps || (run->plan.adaptive ? is_any_missing(done, balance->initial,
                                                                             share, 1, work->count)
                                                            : done->any_coarse);
    for (int k = 0; k < (any ? work->count : 1); k++) {
        const double missing = missing_after(run, work, done, k),
                     floor = share * fmax(fabs(balance->initial), fabs(done->energy[k]));
        if ((done->any_jumps && done->jumps[k]) ||
            (missing > floor &&
             (run->plan.adaptive || (done->any_coarse && done->coarse[k] &&
                                     !quadrature_converges(work, done, k, missing)))))
            solve_step(run, balance, work, done, k);
    }
}
