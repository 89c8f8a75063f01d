/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Followers: adaptive solutions beside a run, which start from one of its rows and keep a state of
 * their own. follower_begin(), follower_go() to each time at which the state is wanted,
 * follower_end(). */
#include <hooke/base/cancel.h>
#include "run/error/follower.h"

#include <math.h>
#include <stdlib.h>

/* Returns evaluations and Jacobians together, the unit in which work is limited. */
static double work_of(const struct cost *cost)
{
    return (double)(cost->evals + cost->jacobians);
}

double follower_work(const struct follower *follower)
{
    return work_of(&follower->step.cost);
}

double run_evaluations(const struct run *run)
{
    return work_of(&run->cost);
}

/* Starts a solution of its own at a row of the run, with memory of its own. */
bool follower_begin(struct follower *follower, const struct run *run, size_t row,
                    const struct method *method, const struct system *system, double tol)
{
    const int n = run->system.n;
    double *work = method ? calloc(method_work_size(method, n) + 1, sizeof *work) : NULL;
    follower->step = (struct step){
        .system = system, .y = follower->y, .work = work, .t = trace_time(run->trace, row)};
    follower->controller = (struct controller){.tol = tol};
    if (!work)
        return false;
    copy_state(follower->y, trace_state(run->trace, row), n);
    method_choose_kernels(method, &follower->step, true);
    if (!method_begin(method, &follower->step)) {
        free(work);
        return false;
    }
    follower->method = method;
    return true;
}

void follower_end(struct follower *follower)
{
    if (!follower->method)
        return;
    method_end(follower->method, &follower->step);
    free(follower->step.work);
    follower->method = NULL;
}

/* Makes adaptive steps to time t, as long as its work is at most max_work. */
enum follower_end follower_go(struct follower *follower, double t, double max_work,
                              const struct cancel *cancel)
{
    while (follower->step.t != t) {
        if (follower_work(follower) > max_work || cancelled(cancel))
            return FOLLOWER_SPENT;
        if (method_adapt(follower->method, &follower->step, &follower->controller, t) != STEP_OK)
            return FOLLOWER_FAILED;
    }
    return FOLLOWER_ARRIVED;
}

void follower_state_changed(struct follower *follower)
{
    follower->step.warm = follower->step.again = false;
}

/* Raises size [n] to the largest magnitudes in rows at even distances, and in the last row. */
void run_sizes_add(const struct run *run, size_t first, size_t end, double *size)
{
    enum { ROWS_LOOKED = 512 };
    const size_t stride = 1 + (end - first) / ROWS_LOOKED;
    for (size_t row = first; row < end;
         row = row + stride < end || row + 1 == end ? row + stride : end - 1) {
        const double *y = trace_state(run->trace, row);
        for (int i = 0; i < run->system.n; i++)
            size[i] = fabs(y[i]) > size[i] ? fabs(y[i]) : size[i]; /* fmax() is a call */
    }
}
