/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energy balance from state to state: the energy after each step minus that at the start and
 * the work since, in sums that keep what rounding takes. balance_block() takes many steps,
 * balance_extend() a part of a step. */
#include "run/energy/work.h"

#include <math.h>

double system_energy(const struct system *system, const double *y)
{
    return system_kinetic(system, y) + system_potential(system, y);
}

/* ---- sums ---- */

/* Adds x; the rounding error of the sum is added to `low` (Knuth, The Art of Computer Programming
 * 2, 1997, 4.2.2). */
static inline void sum_add(struct compensated_sum *sum, double x)
{
    const double total = sum->high + x, part = total - sum->high;
    sum->low += (sum->high - (total - part)) + (x - part);
    sum->high = total;
}

typedef double two __attribute__((vector_size(16)));

/* Adds the work of steps `begin` to `end` to both sums of the tally, as sum_add() does, and notes
 * the totals after each step. */
static void add_work(struct energy_tally *tally, struct work_done *done, int begin, int end)
{
    two high = {tally->work.high, tally->drag.high}, low = {tally->work.low, tally->drag.low};
    for (int k = begin; k < end; k++) {
        const two x = {done->work[k], done->drag[k]}, total = high + x, part = total - high;
        low += (high - (total - part)) + (x - part);
        high = total;
        const two all = high + low;
        done->all_work[k] = all[0];
        done->all_drag[k] = all[1];
    }
    tally->work = (struct compensated_sum){high[0], low[0]};
    tally->drag = (struct compensated_sum){high[1], low[1]};
}

/* Notes unchanged totals after each step, in which no work was done. */
static void unchanged_work_note(const struct energy_tally *tally, struct work_done *done, int begin,
                                int end)
{
    const double work = tally->work.high + tally->work.low,
                 drag = tally->drag.high + tally->drag.low;
    for (int k = begin; k < end; k++) {
        done->all_work[k] = work;
        done->all_drag[k] = drag;
    }
}

/* Returns the largest one of x [4] and `min`. */
static inline double largest_of_four(const double *x, double min)
{
    const double a = x[0] > x[1] ? x[0] : x[1];
    const double b = x[2] > x[3] ? x[2] : x[3];
    const double max = a > b ? a : b;
    return max > min ? max : min;
}

/* Raises tally->max to the largest |E - E0 - work| after these steps. Uses comparisons, which are
 * false for NaN, since fmax() would be a call. */
static inline void note_lacks(struct energy_tally *tally, double initial,
                              const struct work_done *done, int begin, int end)
{
    double max = tally->max;
    for (int k = begin; k < end; k++) {
        const double lack = fabs(done->energy[k] - initial - done->all_work[k]);
        max = lack > max ? lack : max;
    }
    tally->max = max;
}

/* Does the same in vectors. */
CLONES static void note_many_lacks(struct energy_tally *tally, double initial,
                                   const struct work_done *done, int begin, int end)
{
    int k = begin;
    double first[VECTOR_LANES];
    four max = {0};
    for (; k + VECTOR_LANES <= end; k += VECTOR_LANES) {
        const four missing = *(const four *)(const void *)(done->energy + k) - initial -
                             *(const four *)(const void *)(done->all_work + k);
        const four lack = (four)((four_bits)missing & INT64_MAX);
        four_raise(&max, &lack);
    }
    memcpy(first, &max, sizeof first);
    tally->max = largest_of_four(first, tally->max);
    note_lacks(tally, initial, done, k, end);
}

/* Updates the largest error after steps `begin` to `end`, and, if the initial energy is 0, the
 * largest energy, which is the unit of errors then. */
static void note_extremes(struct energy_tally *tally, double initial, const struct work_done *done,
                          int begin, int end)
{
    if (end - begin >= 4 * VECTOR_LANES)
        note_many_lacks(tally, initial, done, begin, end);
    else
        note_lacks(tally, initial, done, begin, end);
    for (int k = begin; k < end && initial == 0; k++) {
        const double size = fabs(done->energy[k]);
        tally->scale = size > tally->scale ? size : tally->scale;
    }
}

/* ---- from state to state ---- */

/* Starts the balance at the first state of the run. */
void balance_begin(const struct run *run, struct balance *balance)
{
    const int n = run->system.n;
    const double factor = run->private_state->factor;
    const double *start = trace_state(run->trace, 0);
    double y[LIMIT_VARIABLES];
    *balance = (struct balance){.t = run->system.t0};
    copy_state(balance->y, start, n);
    for (int i = 0; i < n; i++)
        y[i] = start[i] * factor;
    balance->initial = system_energy(&run_epoch(run, 0)->system, y);
    balance->tally.scale = fabs(balance->initial);
}

/* Returns the first kick after this step, or NULL if there is none. */
static const struct kick *next_kick(const struct run_private *p, int64_t step)
{
    size_t low = 0, high = p->kicks;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (p->kick[middle].step <= step)
            low = middle + 1;
        else
            high = middle;
    }
    return low < p->kicks ? &p->kick[low] : NULL;
}

/* Returns the energy of a state of the run, scaled by the run's factor. */
double balance_energy(const struct run *run, const struct system *system, const double *state)
{
    double y[LIMIT_VARIABLES];
    for (int i = 0; i < run->system.n; i++)
        y[i] = state[i] * run->private_state->factor;
    return system_energy(system, y);
}

/* Adds the change of energy by a change of the scene, if the epoch begins at the balance's step; it
 * counts as work. */
static void epoch_change_add(const struct run *run, struct balance *balance,
                             const struct epoch *epoch)
{
    if (epoch > run->private_state->epoch && epoch->first == balance->step)
        sum_add(&balance->tally.work, balance_energy(run, &epoch->system, balance->y) -
                                          balance_energy(run, &epoch[-1].system, balance->y));
}

static int64_t min_steps(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* Sets the times of work->count steps after the balance's, and reduces the count to those of one
 * grid; if another grid begins there, to the one step that leads to it. times [2] is memory for
 * that. */
static void grid_steps_set(const struct run *run, const struct balance *balance, struct work *work,
                           double *times)
{
    const struct trace *trace = run->trace;
    const struct time_grid *grid = trace_grid_of(trace, balance->step + 1);
    if (grid->first > balance->step) {
        work->count = 1;
        times[0] = balance->t;
        times[1] = grid->origin;
        work->t = times;
        return;
    }
    const int64_t index = balance->step - grid->first;
    int64_t count = min_steps(work->count, WORK_BLOCK - (index & (WORK_BLOCK - 1)));
    if (grid + 1 < trace->grid + trace->grids)
        count = min_steps(count, grid[1].first - 1 - balance->step);
    work->count = (int)count;
    work->origin = grid->origin;
    work->h = grid->h;
    work->index = index;
}

/* Computes in *done the work of the next steps of the balance, at most `max`, up to the next kick,
 * change of scene or grid. row has the states after these steps, `stride` numbers each; `time` has
 * their times in the same stride, or is NULL for fixed steps. A kick is a block of one step.
 * Returns the number of steps. The balance itself is unchanged. */
static int block_done(const struct run *run, struct balance *balance, const struct epoch *epoch,
                      const double *row, const double *time, size_t stride, int64_t max,
                      struct work_done *done)
{
    const struct run_private *p = run->private_state;
    const struct kick *kick = next_kick(p, balance->step);
    double times[WORK_BLOCK + 1];
    if (kick && kick->step == balance->step + 1) {
        done->energy[0] = balance_energy(run, &epoch->system, row);
        done->work[0] = kick->energy;
        done->drag[0] = 0;
        return 1;
    }
    int64_t count = min_steps(max, WORK_BLOCK);
    if (kick)
        count = min_steps(count, kick->step - 1 - balance->step);
    if (epoch + 1 < p->epoch + p->epochs)
        count = min_steps(count, epoch[1].first - balance->step);
    struct work work = {.system = &epoch->system,
                        .factor = p->factor,
                        .count = (int)count,
                        .initial_state = balance->y,
                        .row = row,
                        .stride = stride,
                        .turns = &run->private_state->turns};
    if (time) {
        times[0] = balance->t;
        for (int k = 0; k < work.count; k++)
            times[k + 1] = time[(size_t)k * stride];
        work.t = times;
    } else {
        grid_steps_set(run, balance, &work, times);
    }
    work_between(&work, done);
    if (!epoch->system.conservative)
        work_check(run, balance, &work, done);
    return work.count;
}

/* Adds steps `begin` to `end` of the work done to the balance; `still` means that no work is done
 * at all. */
static void tally_steps(struct balance *balance, bool still, struct work_done *done, int begin,
                        int end)
{
    if (still)
        unchanged_work_note(&balance->tally, done, begin, end);
    else
        add_work(&balance->tally, done, begin, end);
    note_extremes(&balance->tally, balance->initial, done, begin, end);
}

/* Adds all steps of the work done to the balance, and sets the marks of rows of the trace among
 * them. */
static void tally_marking(const struct run *run, struct balance *balance, bool still,
                          struct work_done *done, int count)
{
    struct trace *trace = run->trace;
    int begin = 0;
    /* Only the last row can be among steps that come one by one. */
    const size_t last = trace->count - 1;
    const bool is_search = last > 0 && trace_step(trace, last - 1) > balance->step;
    for (size_t i = is_search ? trace_row_from(trace, balance->step + 1) : last; i <= last; i++) {
        if (trace_step(trace, i) <= balance->step)
            continue;
        const int64_t end = trace_step(trace, i) - balance->step;
        if (end > count)
            break;
        if (trace_mark(trace, i).scale >= 0) /* inside of the step */
            continue;
        tally_steps(balance, still, done, begin, (int)end);
        begin = (int)end;
        trace_set_mark(trace, i, &balance->tally);
    }
    tally_steps(balance, still, done, begin, count);
}

/* Adds the next steps, up to `max` or to a change of scene, state or grid. Returns their number. */
int balance_block(const struct run *run, struct balance *balance, const double *row,
                  const double *time, size_t stride, int64_t max, struct work_done *done,
                  bool marking)
{
    const struct epoch *epoch = run_epoch(run, balance->step + 1);
    epoch_change_add(run, balance, epoch);
    const int count = block_done(run, balance, epoch, row, time, stride, max, done);
    const struct kick *kick = next_kick(run->private_state, balance->step);
    const bool kicked = kick && kick->step == balance->step + 1,
               still = epoch->system.conservative && !kicked;
    if (marking)
        tally_marking(run, balance, still, done, count);
    else
        tally_steps(balance, still, done, 0, count);
    balance->step += count;
    const size_t last = (size_t)(count - 1) * stride;
    balance->t =
        time ? time[last] : grid_time(trace_grid_of(run->trace, balance->step), balance->step);
    copy_state(balance->y, row + last, run->system.n);
    return count;
}

/* Adds a part of a step, to the state y at t, as if it were a step. */
void balance_extend(const struct run *run, struct balance *balance, double t, const double *y)
{
    const struct epoch *epoch = run_epoch(run, balance->step + 1);
    const double times[] = {balance->t, t};
    struct work_done done = {.energy = {0}};
    struct work work = {.system = &epoch->system,
                        .factor = run->private_state->factor,
                        .count = 1,
                        .initial_state = balance->y,
                        .row = y,
                        .stride = (size_t)run->system.n,
                        .t = times,
                        .turns = &run->private_state->turns};
    epoch_change_add(run, balance, epoch);
    work_between(&work, &done);
    if (!epoch->system.conservative && t != balance->t)
        work_check(run, balance, &work, &done);
    tally_steps(balance, epoch->system.conservative || t == balance->t, &done, 0, 1);
    balance->step++;
    balance->t = t;
    copy_state(balance->y, y, run->system.n);
}

/* ---- growth by the method ---- */

/* Growth of the energy from which a run counts as unstable. */
static const double unstable_growth = 100;

bool run_is_unstable(const struct run *run)
{
    const struct oscillator *o = &run->system.oscillator;
    if (!(run->plan.growth > 1) || o->damping < 0 || o->stiffness < 0 ||
        stop_is_failure(run->stop) || !run->system.energy)
        return false;
    return balance_energy(run, &run_epoch(run, run->steps)->system, run->y) >
           unstable_growth * run->private_state->balance.initial;
}

const char *run_status(const struct run *run)
{
    return run_is_unstable(run) ? "unstable" : stop_name(run->stop);
}
