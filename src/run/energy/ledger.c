/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The energy balance: what each step's energy differs by from that at the start and the work since.
 *
 * Where the trace has each step, nothing is done while the run advances: who asks pays for the
 * steps since somebody asked last. Where it leaves steps out they are taken while they are at hand,
 * and each row has a mark, the balance up to it. Either way each step is seen once, by the same
 * operations in the same order: the balance does not depend on what is recorded, nor on how a run
 * is cut into calls.
 */
#include "run/private.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

double system_energy(const struct system *system, const double *y)
{
    return system_kinetic(system, y) + system_potential(system, y);
}

/* ---- sums ---- */

/* Knuth, The Art of Computer Programming 2 (1997), 4.2.2: what rounding takes from the sum goes to
 * `low`. */
static inline void sum_add(struct sum *sum, double x)
{
    const double total = sum->high + x, part = total - sum->high;
    sum->low += (sum->high - (total - part)) + (x - part);
    sum->high = total;
}

typedef double two __attribute__((vector_size(16)));

/* Both sums at once; what they are after each step is noted. */
static void add_work(struct tally *tally, struct work_done *done, int from, int to)
{
    two high = {tally->work.high, tally->drag.high}, low = {tally->work.low, tally->drag.low};
    for (int k = from; k < to; k++) {
        const two x = {done->work[k], done->drag[k]}, total = high + x, part = total - high;
        low += (high - (total - part)) + (x - part);
        high = total;
        const two all = high + low;
        done->all_work[k] = all[0];
        done->all_drag[k] = all[1];
    }
    tally->work = (struct sum){high[0], low[0]};
    tally->drag = (struct sum){high[1], low[1]};
}

static void same_work(const struct tally *tally, struct work_done *done, int from, int to)
{
    const double work = tally->work.high + tally->work.low,
                 drag = tally->drag.high + tally->drag.low;
    for (int k = from; k < to; k++) {
        done->all_work[k] = work;
        done->all_drag[k] = drag;
    }
}

#define LARGER(x, y)                                                                               \
    ((four)(((four_bits)((x) > (y)) & (four_bits)(x)) | (~(four_bits)((x) > (y)) & (four_bits)(y))))

/* The largest of them in pairs; `min` at least. */
static inline double largest(const double *x, double min)
{
    const double a = x[0] > x[1] ? x[0] : x[1], b = x[2] > x[3] ? x[2] : x[3], max = a > b ? a : b;
    return max > min ? max : min;
}

/* By comparisons, which pass over numbers that are none: fmax() is a call. */
static inline void note_lacks(struct tally *tally, double initial, const struct work_done *done,
                              int from, int to)
{
    double max = tally->max;
    for (int k = from; k < to; k++) {
        const double lack = fabs(done->energy[k] - initial - done->all_work[k]);
        max = lack > max ? lack : max;
    }
    tally->max = max;
}

CLONES static void note_many_lacks(struct tally *tally, double initial,
                                   const struct work_done *done, int from, int to)
{
    int k = from;
    double first[FOUR];
    four max = {0};
    for (; k + FOUR <= to; k += FOUR) {
        const four missing = *(const four *)(const void *)(done->energy + k) - initial -
                             *(const four *)(const void *)(done->all_work + k);
        const four lack = (four)((four_bits)missing & INT64_MAX);
        max = LARGER(lack, max);
    }
    memcpy(first, &max, sizeof first);
    tally->max = largest(first, tally->max);
    note_lacks(tally, initial, done, k, to);
}

/* The largest energy is the unit where there was none at first. */
static void note_extremes(struct tally *tally, double initial, const struct work_done *done,
                          int from, int to)
{
    if (to - from >= 4 * FOUR)
        note_many_lacks(tally, initial, done, from, to);
    else
        note_lacks(tally, initial, done, from, to);
    for (int k = from; k < to && initial == 0; k++) {
        const double size = fabs(done->energy[k]);
        tally->scale = size > tally->scale ? size : tally->scale;
    }
}

/* ---- from state to state ---- */

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

/* The first kick after this step; NULL: none. */
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

static double energy_now(const struct run *run, const struct system *system, const double *state)
{
    double y[LIMIT_VARIABLES];
    for (int i = 0; i < run->system.n; i++)
        y[i] = state[i] * run->private_state->factor;
    return system_energy(system, y);
}

/* A change of the scene at the balance's step changes the energy of a state: that is work too. */
static void enter(const struct run *run, struct balance *balance, const struct epoch *epoch)
{
    if (epoch > run->private_state->epoch && epoch->first == balance->step)
        sum_add(&balance->tally.work, energy_now(run, &epoch->system, balance->y) -
                                          energy_now(run, &epoch[-1].system, balance->y));
}

static int64_t min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* The steps of one grid from the balance's on, or the one step to where another begins. times [2]
 */
static void on_grid(const struct run *run, const struct balance *balance, struct work *work,
                    double *times)
{
    const struct trace *trace = run->trace;
    const struct grid *grid = trace_grid_of(trace, balance->step + 1);
    if (grid->first > balance->step) {
        work->count = 1;
        times[0] = balance->t;
        times[1] = grid->origin;
        work->t = times;
        return;
    }
    const int64_t index = balance->step - grid->first;
    int64_t count = min(work->count, WORK_BLOCK - (index & (WORK_BLOCK - 1)));
    if (grid + 1 < trace->grid + trace->grids)
        count = min(count, grid[1].first - 1 - balance->step);
    work->count = (int)count;
    work->origin = grid->origin;
    work->h = grid->h;
    work->index = index;
}

/* What the steps up to the next change of anything do; the balance itself stays. */
static int block_done(const struct run *run, const struct balance *balance,
                      const struct epoch *epoch, const double *row, const double *time,
                      size_t stride, int64_t max, struct work_done *done)
{
    const struct run_private *p = run->private_state;
    const struct kick *kick = next_kick(p, balance->step);
    double times[WORK_BLOCK + 1];
    if (kick && kick->step == balance->step + 1) {
        done->energy[0] = energy_now(run, &epoch->system, row);
        done->work[0] = kick->energy;
        done->drag[0] = 0;
        return 1;
    }
    int64_t count = min(max, WORK_BLOCK);
    if (kick)
        count = min(count, kick->step - 1 - balance->step);
    if (epoch + 1 < p->epoch + p->epochs)
        count = min(count, epoch[1].first - balance->step);
    struct work work = {.system = &epoch->system,
                        .factor = p->factor,
                        .count = (int)count,
                        .before = balance->y,
                        .row = row,
                        .stride = stride,
                        .turns = &run->private_state->turns};
    if (time) {
        times[0] = balance->t;
        for (int k = 0; k < work.count; k++)
            times[k + 1] = time[(size_t)k * stride];
        work.t = times;
    } else {
        on_grid(run, balance, &work, times);
    }
    work_between(&work, done);
    return work.count;
}

#define ROUNDED 64   /* rounding units of the energy */
#define SUSPECT 1e-3 /* of the tolerance: such a share of the energy, missing after one step */
#define FINER                                                                                      \
    1e-3 /* times the run's tolerance: that of a solution that says what the work was,             \
          */
#define WORK_TOL 1e-12 /* or this */
#define WORK_MIN 1e-14

/*
 * A long step of a method that adapts may pass over what the quintic between its ends cannot show:
 * steps of an order above its own, v that settles at once, accelerations that are a small
 * difference of large forces. Where more is missing after one step than an error far below the
 * tolerance, the solution from where it began says what the work was.
 */
static void check_work(const struct run *run, const struct balance *balance,
                       const struct system *system, const double *row, const double *time,
                       size_t stride, int count, struct work_done *done)
{
    const double tol = fmax(fmin(WORK_TOL, FINER * run->settings.tol), WORK_MIN);
    const double suspect = fmax(SUSPECT * run->settings.tol, ROUNDED * DBL_EPSILON);
    double before = energy_now(run, system, balance->y), to[LIMIT_VARIABLES];
    for (int k = 0; k < count; before = done->energy[k++]) {
        const double missing = fabs(done->energy[k] - before - done->work[k]);
        const double *from = k ? row + (size_t)(k - 1) * stride : balance->y;
        const double t = k ? time[(size_t)(k - 1) * stride] : balance->t;
        if (missing <= suspect * fmax(fabs(balance->initial), fabs(done->energy[k])) ||
            (!run_solve(system, t, from, time[(size_t)k * stride], RUN_SOLVE_SMOOTH, tol, to) &&
             !run_solve(system, t, from, time[(size_t)k * stride], RUN_SOLVE_STIFF, tol, to)))
            continue;
        const double end = energy_now(run, system, to), work = end - energy_now(run, system, from);
        if (memcmp(&done->drag[k], &done->work[k], sizeof done->work[k]) == 0)
            done->drag[k] = work;
        done->work[k] = work;
    }
}

/* The first `count` of what was done go into the balance. `still`: no work at all. */
static void tally_up(struct balance *balance, bool still, struct work_done *done, int from, int to)
{
    if (still)
        same_work(&balance->tally, done, from, to);
    else
        add_work(&balance->tally, done, from, to);
    note_extremes(&balance->tally, balance->initial, done, from, to);
}

/* Rows of the trace among the steps after `first` get their marks on the way. */
static void tally_marking(const struct run *run, struct balance *balance, bool still,
                          struct work_done *done, int count)
{
    struct trace *trace = run->trace;
    int at = 0;
    for (size_t i = trace_row_from(trace, balance->step + 1); i < trace->count; i++) {
        const int64_t to = trace_step(trace, i) - balance->step;
        if (to > count)
            break;
        if (trace_mark(trace, i).scale >= 0) /* inside of the step */
            continue;
        tally_up(balance, still, done, at, (int)to);
        at = (int)to;
        trace_set_mark(trace, i, &balance->tally);
    }
    tally_up(balance, still, done, at, count);
}

static int take_block(const struct run *run, struct balance *balance, const double *row,
                      const double *time, size_t stride, int64_t max, struct work_done *done,
                      bool marking)
{
    const struct epoch *epoch = run_epoch(run, balance->step + 1);
    enter(run, balance, epoch);
    const int count = block_done(run, balance, epoch, row, time, stride, max, done);
    const struct kick *kick = next_kick(run->private_state, balance->step);
    const bool kicked = kick && kick->step == balance->step + 1,
               still = epoch->system.conservative && !kicked;
    if (time && !still && !kicked)
        check_work(run, balance, &epoch->system, row, time, stride, count, done);
    if (marking)
        tally_marking(run, balance, still, done, count);
    else
        tally_up(balance, still, done, 0, count);
    balance->step += count;
    const size_t last = (size_t)(count - 1) * stride;
    balance->t =
        time ? time[last] : grid_time(trace_grid_of(run->trace, balance->step), balance->step);
    copy_state(balance->y, row + last, run->system.n);
    return count;
}

int balance_block(const struct run *run, struct balance *balance, const double *row,
                  const double *time, size_t stride, int64_t count, struct work_done *done)
{
    return take_block(run, balance, row, time, stride, count, done, false);
}

/* ---- kept while the run advances ---- */

static const double *times_of(const struct run *run, const double *row)
{
    return run->plan.adaptive ? row + run->system.n : NULL;
}

/* From a trace that had each step, thinned but still with all rows: marks for those that stay. */
static void mark_staying(const struct run *run, struct balance *balance, size_t rows)
{
    struct work_done done;
    while (balance->step + 1 < (int64_t)rows) {
        size_t count;
        const double *row = trace_rows(run->trace, (size_t)balance->step + 1, rows, &count);
        take_block(run, balance, row, times_of(run, row), run->trace->width, (int64_t)count, &done,
                   true);
    }
}

static bool save(struct run_private *p, size_t index)
{
    if (index == p->save_room) {
        const size_t capacity = p->save_room ? 2 * p->save_room : 16;
        struct tally *saved = realloc(p->saved, capacity * sizeof *saved);
        if (!saved)
            return false; /* going back starts earlier then */
        p->saved = saved;
        p->save_room = capacity;
    }
    p->saved[index] = p->balance.tally;
    p->saves = index + 1;
    return true;
}

/* As far as rows are recorded, each once: what is known already stays. */
static void settle(const struct run *run)
{
    struct run_private *p = run->private_state;
    struct balance *balance = &p->balance;
    struct trace *trace = run->trace;
    struct work_done done;
    while (balance->step + 1 < (int64_t)trace->count) {
        size_t count;
        const double *row = trace_rows(trace, (size_t)balance->step + 1, trace->count, &count);
        const int64_t to_save = (int64_t)CHUNK_ROWS - (balance->step & (int64_t)(CHUNK_ROWS - 1));
        take_block(run, balance, row, times_of(run, row), trace->width,
                   min((int64_t)count, to_save), &done, false);
        if ((balance->step & (int64_t)(CHUNK_ROWS - 1)) == 0 &&
            p->saves == (size_t)(balance->step >> CHUNK_SHIFT) - 1)
            save(p, p->saves);
    }
}

bool ledger_ready(struct run *run, int64_t rows)
{
    struct trace *trace = run->trace;
    if (!trace->decimates || trace_marked(trace) || run->system.order != 2 ||
        run->settings.unbalanced || trace->count + (size_t)rows <= trace->cap)
        return true;
    const size_t all = trace->count;
    if (trace->bucket > 1 ||
        !trace_thin(trace)) /* buckets without marks: there was no memory for them */
        return false;
    struct balance *balance = &run->private_state->balance;
    const bool marked = trace_mark_rows(trace, run->plan.ledger);
    if (marked) {
        balance_begin(run, balance);
        trace_set_mark(trace, 0, &balance->tally);
        mark_staying(run, balance, all);
    }
    trace_thinned(trace);
    return marked;
}

void ledger_warm(struct run *run)
{
    if (run->settings.balanced && run->system.order == 2)
        settle(run);
}

void ledger_take(struct run *run, const double *row, int64_t count)
{
    struct work_done done;
    if (!trace_marked(run->trace))
        return;
    while (count > 0) {
        const int taken =
            take_block(run, &run->private_state->balance, row, run->plan.adaptive ? &run->t : NULL,
                       (size_t)run->system.n, count, &done, true);
        row += (size_t)taken * (size_t)run->system.n;
        count -= taken;
    }
}

/* A part of a step, from the balance to (t, y). */
static void extend(const struct run *run, struct balance *balance, double t, const double *y)
{
    const struct epoch *epoch = run_epoch(run, balance->step + 1);
    const double times[] = {balance->t, t};
    struct work_done done = {.energy = {0}};
    struct work work = {.system = &epoch->system,
                        .factor = run->private_state->factor,
                        .count = 1,
                        .before = balance->y,
                        .row = y,
                        .stride = (size_t)run->system.n,
                        .t = times,
                        .turns = &run->private_state->turns};
    enter(run, balance, epoch);
    work_between(&work, &done);
    tally_up(balance, epoch->system.conservative || t == balance->t, &done, 0, 1);
    balance->step++;
    balance->t = t;
    copy_state(balance->y, y, run->system.n);
}

void ledger_inside(struct run *run, double t, const double *y)
{
    if (!trace_marked(run->trace))
        return;
    struct balance inside = run->private_state->balance;
    extend(run, &inside, t, y);
    trace_set_mark(run->trace, run->trace->count - 1, &inside.tally);
}

void balance_present(const struct run *run, struct balance *balance)
{
    if (!trace_marked(run->trace))
        settle(run);
    *balance = run->private_state->balance;
    if (balance->step != run->steps)
        extend(run, balance, run->t, run->y);
}

void ledger_back(struct run *run)
{
    struct run_private *p = run->private_state;
    struct trace *trace = run->trace;
    if (run->system.order != 2 || !ledger_known(run))
        return;
    if (run->steps == 0) {
        p->saves = 0;
        balance_begin(run, &p->balance);
        if (trace_marked(trace))
            trace_set_mark(trace, 0, &p->balance.tally);
        return;
    }
    if (!trace_marked(trace) && p->balance.step <= run->steps)
        return;
    p->balance.step = run->steps;
    if (trace_marked(trace)) {
        p->balance.tally = trace_mark(trace, trace->count - 1);
        p->balance.t = run->plan.adaptive ? run->t : grid_time(trace_grid(trace), run->steps);
        copy_state(p->balance.y, run->y, run->system.n);
        return;
    }
    p->saves = p->saves < (size_t)(run->steps >> CHUNK_SHIFT) ? p->saves
                                                              : (size_t)(run->steps >> CHUNK_SHIFT);
    if (p->saves == 0) {
        balance_begin(run, &p->balance);
        return;
    }
    const size_t row = p->saves << CHUNK_SHIFT;
    p->balance.tally = p->saved[p->saves - 1];
    p->balance.step = (int64_t)row;
    p->balance.t = run->plan.adaptive
                       ? trace_time(trace, row)
                       : grid_time(trace_grid_of(trace, p->balance.step), p->balance.step);
    copy_state(p->balance.y, trace_state(trace, row), run->system.n);
}

static void rescale(struct tally *tally, double by)
{
    double *value[] = {&tally->work.high, &tally->work.low, &tally->drag.high,
                       &tally->drag.low,  &tally->max,      &tally->scale};
    for (size_t i = 0; i < COUNT_OF(value); i++)
        *value[i] *= by;
}

void ledger_rescale(struct run *run, double factor)
{
    struct run_private *p = run->private_state;
    const double by = (factor / p->factor) * (factor / p->factor);
    if (p->factor == factor)
        return;
    p->factor = factor;
    if (!trace_marked(run->trace)) {
        p->saves = 0;
        balance_begin(run, &p->balance);
        return;
    }
    rescale(&p->balance.tally, by);
    p->balance.initial *= by;
    for (size_t i = 0; i < run->trace->count; i++) {
        struct tally mark = trace_mark(run->trace, i);
        rescale(&mark, by);
        trace_set_mark(run->trace, i, &mark);
    }
}

/* ---- asking ---- */

void run_ledger(const struct run *run, struct ledger *ledger)
{
    *ledger = (struct ledger){NAN, NAN, NAN, NAN, NAN, NAN};
    if (!run->system.energy)
        return;
    const double unit = run->private_state->factor * run->private_state->factor;
    struct balance balance;
    if (!ledger_known(run)) {
        const double final = energy_now(run, &run_epoch(run, run->steps)->system, run->y);
        ledger->initial = run->private_state->balance.initial / unit;
        ledger->final = final / unit;
        ledger->factor = final / run->private_state->balance.initial;
        return;
    }
    balance_present(run, &balance);
    const struct tally *tally = &balance.tally;
    const double energy = energy_now(run, &run_epoch(run, run->steps)->system, balance.y),
                 work = tally->work.high + tally->work.low,
                 /* A total that is 0 all the time (x'' = -1/x from 1) is no unit: what moves is. */
        moving = system_kinetic(&run_epoch(run, run->steps)->system, balance.y),
                 scale = balance.initial != 0 ? fabs(balance.initial) : fmax(tally->scale, moving);
    ledger->initial = balance.initial / unit;
    ledger->final = energy / unit;
    ledger->factor = energy / balance.initial;
    ledger->work = work / unit;
    if (scale > 0) {
        ledger->error = (energy - balance.initial - work) / scale;
        ledger->error_max = tally->max / scale;
    }
}

#define PEAK 100       /* times the energy at both ends */
#define PEAK_STRIDE 16 /* rows: what fixed steps resolve lasts longer */

static double largest_energy(const struct run *run, size_t stride)
{
    double max = 0;
    for (size_t i = 0; i < trace_count(run->trace); i += stride)
        max = fmax(max, system_energy(&run_epoch(run, trace_step(run->trace, i))->system,
                                      trace_state(run->trace, i)));
    return max;
}

double run_energy_peak(const struct run *run, const struct ledger *ledger)
{
    const double ends = fmax(fabs(ledger->initial), fabs(ledger->final));
    if (run->system.conservative || !(fabs(ledger->initial) > 0))
        return NAN;
    /* A run of fixed steps may have many rows, and nearly always no such peak: a look at some
     * tells. */
    if (!run->plan.adaptive && !(largest_energy(run, PEAK_STRIDE) > PEAK / 10 * ends))
        return NAN;
    const double max = largest_energy(run, 1);
    return max > PEAK * ends && isfinite(max) ? max / fabs(ledger->initial) : NAN;
}

bool ledger_known(const struct run *run)
{
    const struct trace *trace = run->trace;
    return trace_marked(trace) || (trace->bucket == 1 && trace->every == 1 && trace->interval == 0);
}
