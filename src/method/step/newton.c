/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Newton's iteration for the stages of implicit methods, to rounding or, in adaptive steps, to the
 * tolerance. newton_body.h has the parts that kernels compile, too.
 */
#include "method/step/newton_body.h"

enum { ADAPTIVE_ITERATIONS = 7 }; /* most iterations of an adaptive step */

/* Limits of newton_follow() (the first and the shortest part of h, the number of parts), and the
 * largest number of stages of a method. */
static const double FIRST_PART = 0.25, PART_MIN = 1e-5;
enum { PARTS_MOST = 100, STAGES_MOST = 3 };

/* Rate of convergence up to which an adaptive step keeps the Jacobian of the one before. */
static const double JACOBIAN_KEEP_RATE = 1e-3;

/* Returns the part of an adaptive step's tolerance that the iteration may leave; small for small
 * tolerances, since the errors of many steps add up. */
static double remaining_fraction(double tol)
{
    return fmax(10 * DBL_EPSILON / tol, fmin(0.03, sqrt(tol)));
}

const struct implicit_tableau newton_euler = NEWTON_EULER;

struct newton newton_of(const struct implicit_tableau *tableau, newton_residual_function *residual,
                        const struct system *system)
{
    return (struct newton){tableau, residual, step_slope, step_jacobian, system};
}

void newton_stages(const struct newton *equations, struct step *step, int n, double t, double h,
                   const double *y, const double *z, double *slope, double *residual)
{
    newton_residual(equations, step, n, t, h, y, z, slope, residual);
}

size_t newton_capacity(int stages, int n)
{
    return 2 + (size_t)(3 * stages + n) * (size_t)n + 3 * LU_ROOM(n);
}

void newton_forget(double *work)
{
    work[0] = 0;
    work[1] = 1;
}

/* Multiplies x [n] by the inverse of real - h J, by the factors of the last solution if they are
 * for this h. */
bool newton_filter(const struct implicit_tableau *tableau, struct step *step, double t, double h,
                   const double *y, double *x, double *work)
{
    struct workspace workspace = workspace_of(tableau->stages, step->system->n, work);
    const struct newton equations = newton_of(tableau, newton_stages, step->system);
    if (*workspace.h != h && !newton_factor(&equations, step, step->system->n, t, h, y, &workspace))
        return false;
    lu_solve(step->system->n, workspace.real, x);
    step->cost.solves++;
    return true;
}

/* Solves the stage equations of an adaptive step of length h at time t by simplified Newton
 * iterations. z [stages * n] is in and out: the first guess, then the solution; y is the state and
 * weight [n] scales the norm of increments. Stops when the remaining error, estimated from the rate
 * at which increments shrink, is at most `enough`, in that norm. The rate is measured in this
 * solve, because the convergence of earlier steps proves nothing about it; *workspace->rate of
 * earlier steps only ages. The estimate is cautious, since slowly shrinking parts may hide behind
 * faster ones, as across a kink. Returns STEP_NO_SOLUTION if the iteration diverges or is too slow.
 */
static enum step_status iterate_to_tolerance(const struct newton *equations, struct step *step,
                                             double t, double h, const double *y, double *z,
                                             const double *weight, double enough,
                                             struct workspace *workspace)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int n = step->system->n, stages = tableau->stages;
    double last = 0, left = 1; /* left is the remaining part of an increment */
    /* the old rate grows with age, so that factors are not kept for ever without a test */
    *workspace->rate = sqrt(*workspace->rate);
    for (int iteration = 0; iteration < ADAPTIVE_ITERATIONS; iteration++) {
        equations->residual(equations, step, n, t, h, y, z, workspace->slope, workspace->residual);
        newton_increment(tableau, step, n, workspace, workspace->residual);
        double size = newton_size(stages, n, weight, workspace->residual);
        if (!isfinite(size))
            return STEP_NONFINITE;
        for (int i = 0; i < stages * n; i++)
            z[i] += workspace->residual[i];
        if (last > 0) {
            double rate = *workspace->rate = size / last;
            if (rate >= 1)
                return STEP_NO_SOLUTION;
            left = rate / (1 - rate);
            double end = left * size; /* error that the last iteration will leave */
            for (int later = iteration + 1; later < ADAPTIVE_ITERATIONS; later++)
                end *= rate;
            if (end > enough)
                return STEP_NO_SOLUTION;
            left = sqrt(left * sqrt(left)); /* a cautious estimate */
        }
        if (left * size <= enough)
            return STEP_OK;
        last = size;
    }
    return STEP_NO_SOLUTION;
}

/* Sets now [n] to the weights of increments, smaller than weight where the solution y + z is larger
 * than its size so far, as in the first steps of a motion that starts from nothing. */
static void increments_weigh(int stages, int n, const double *y, const double *z,
                             const double *weight, double *now)
{
    for (int i = 0; i < n; i++) {
        now[i] = weight[i];
        for (int s = 0; s < stages; s++)
            now[i] = fmin(now[i], 1 / fabs(y[i] + z[s * n + i]));
    }
}

/* Finds the solution z [stages * n] near the given z by Newton's iteration with a new Jacobian each
 * time; y is the state at t and weight [n] scales the increments. Returns false unless each
 * increment is at most CONTRACTION_MAX of the one before, so that z stays with the solution it was
 * near to. */
static bool iterate_contracting(const struct newton *equations, struct step *step, int n, double t,
                                double h, const double *y, double *z, const double *weight,
                                struct workspace *workspace)
{
    const struct implicit_tableau *tableau = equations->tableau;
    const int stages = tableau->stages;
    double last = HUGE_VAL, now[LIMIT_VARIABLES];
    for (int iteration = 0; iteration < ITERATIONS; iteration++) {
        if (!newton_renew(equations, step, n, t, h, y, z, workspace) ||
            !newton_positive(tableau, n, workspace))
            return false;
        equations->residual(equations, step, n, t, h, y, z, workspace->slope, workspace->residual);
        newton_increment(tableau, step, n, workspace, workspace->residual);
        for (int i = 0; i < stages * n; i++)
            z[i] += workspace->residual[i];
        increments_weigh(stages, n, y, z, weight, now);
        const double size = newton_size(stages, n, now, workspace->residual);
        if (!isfinite(size) || (size > CONTRACTION_MAX * last && size > INCREMENT_STALL_RELATIVE))
            return false;
        if (size <= DBL_EPSILON / 2 || (size >= last && size <= INCREMENT_STALL_RELATIVE))
            return true;
        last = size;
    }
    return last <= INCREMENT_STALL_RELATIVE;
}

/* Follows the solution from h = 0 in parts of h that grow after each success and shrink after a
 * failure. Returns false, with z unchanged, if it does not reach h. */
bool newton_follow(const struct newton *equations, struct step *step, int n, double t, double h,
                   const double *y, double *z, const double *weight, double *work)
{
    const int count = equations->tableau->stages * n;
    struct workspace workspace = workspace_of(equations->tableau->stages, n, work);
    double solution[STAGES_MOST * LIMIT_VARIABLES] = {0}, next[STAGES_MOST * LIMIT_VARIABLES];
    double done = 0, part = FIRST_PART; /* parts of h */
    for (int i = 0; i < PARTS_MOST && done < 1 && part >= PART_MIN; i++) {
        const double next_fraction = fmin(1, done + part);
        memcpy(next, solution, (size_t)count * sizeof *next);
        if (iterate_contracting(equations, step, n, t, next_fraction * h, y, next, weight,
                                &workspace)) {
            memcpy(solution, next, (size_t)count * sizeof *solution);
            done = next_fraction;
            part *= 2;
        } else {
            part /= 4;
        }
    }
    if (done < 1)
        return false;
    memcpy(z, solution, (size_t)count * sizeof *z);
    return true;
}

/* Solves the equations for the increments z, to the tolerance in adaptive steps, else to rounding.
 * Factors of earlier steps are used if the system is linear or convergence was fast. */
enum step_status newton_solve(const struct newton *equations, struct step *step, double t, double h,
                              const double *y, double *z, double *work)
{
    const struct system *system = step->system;
    const bool adaptive = step->tol > 0 && !system->linear;
    struct workspace workspace = workspace_of(equations->tableau->stages, system->n, work);
    double weight[LIMIT_VARIABLES] = {0};
    newton_weights(step_scale(step), system->n, y, weight);
    bool reused = *workspace.h == h &&
                  (system->linear || (adaptive && *workspace.rate <= JACOBIAN_KEEP_RATE));
    if (!reused && !newton_factor(equations, step, system->n, t, h, y, &workspace))
        return STEP_NO_SOLUTION;
    return adaptive
               ? iterate_to_tolerance(equations, step, t, h, y, z, weight,
                                      remaining_fraction(step->tol) * step->tol, &workspace)
               : newton_to_rounding(equations, step, system->n, t, h, y, z, weight, &workspace);
}

/* ---- one stage ---- */

/* Solves a stage of the oscillator in closed form. */
static enum step_status solve_oscillator(struct step *step, double t, double h, const double *y,
                                         double *z, double *sum)
{
    const struct oscillator *o = &step->system->oscillator;
    double force;
    system_force(step->system, t, y, &force);
    return oscillator_stage(o, o->quadratic != 0, force, step, h, y, z, sum);
}

/* Solves z = h f(t, y + z): in closed form for the oscillator, by motion_stage() in fixed steps of
 * one coordinate, else by newton_solve(). */
enum step_status newton_stage(struct step *step, double t, double h, const double *y, double *z,
                              double *sum, double *work)
{
    const struct system *system = step->system;
    if (system->order == 2 && system->n == 2 && system->oscillator.whole)
        return solve_oscillator(step, t, h, y, z, sum);
    if (system->order == 2 && system->n == 2 && !system->linear && step->tol == 0) {
        newton_forget(work); /* motion_stage() leaves no factors */
        return motion_stage(step_slope, step_jacobian, system, step, t, h, y, z, sum, work);
    }
    const struct newton equations = newton_of(&newton_euler, newton_stages, system);
    memset(z, 0, (size_t)system->n * sizeof *z);
    enum step_status status = newton_solve(&equations, step, t, h, y, z, work);
    for (int i = 0; i < system->n; i++)
        sum[i] = y[i] + z[i];
    return status;
}

size_t newton_work(const struct method *method, int n)
{
    (void)method;
    return 3 * (size_t)n + newton_capacity(1, n);
}

enum step_status implicit_euler_solve(struct step *step, double t, double h, const double *y,
                                      double *z, double *work)
{
    newton_forget(work + step->system->n);
    return newton_stage(step, t, h, y, work, z, work + step->system->n);
}
