/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The energy balance of a run: its error, the energy after a step minus that at the start and the
 * work since, is known for each step, whatever is recorded. If the trace has each step, the balance
 * is computed from its rows when it is requested. If it leaves steps out, each row gets a mark, the
 * balance up to it: the run's steps are repeated when the balance is requested, or the marks are
 * kept while the run advances if its steps cannot be repeated. Either way each step is processed
 * once, by the same operations in the same order, so that the result depends neither on what is
 * recorded nor on how a run is cut into calls. */
#include <hooke/base/cancel.h>
#include <hooke/scene/typed.h>

#include "run/energy/work.h"

#include <math.h>
#include <stdlib.h>

/* Returns the time of the first row if rows have times, else NULL. */
static const double *times_of(const struct run *run, const double *row)
{
    return run->plan.adaptive ? row + run->system.n : NULL;
}

/* Saves the present tally as entry `index`, so that the balance can go back to there. Returns false
 * if out of memory; then going back starts from an earlier one. */
static bool tally_save(struct run_private *p, size_t index)
{
    if (index == p->save_capacity) {
        const size_t capacity = p->save_capacity ? 2 * p->save_capacity : 16;
        struct energy_tally *saved = realloc(p->saved, capacity * sizeof *saved);
        if (!saved)
            return false;
        p->saved = saved;
        p->save_capacity = capacity;
    }
    p->saved[index] = p->balance.tally;
    p->saves = index + 1;
    return true;
}

/* Extends the balance over the recorded rows that are new, of a trace that has each step. Returns
 * false if Ctrl-C came before the last one. */
static bool balance_add_rows(const struct run *run)
{
    struct run_private *p = run->private_state;
    struct balance *balance = &p->balance;
    struct trace *trace = run->trace;
    struct work_done done;
    while (balance->step + 1 < (int64_t)trace->count) {
        size_t count;
        const double *row = trace_rows(trace, (size_t)balance->step + 1, trace->count, &count);
        const int64_t to_save = (int64_t)CHUNK_ROWS - (balance->step & (int64_t)(CHUNK_ROWS - 1));
        const struct balance saved = *balance;
        balance_block(run, balance, row, times_of(run, row), trace->width,
                      (int64_t)count < to_save ? (int64_t)count : to_save, &done, false);
        if (balance->solved > saved.solved && cancelled(run->cancel)) {
            *balance = saved; /* a step may not have been solved to its end */
            return false;
        }
        if ((balance->step & (int64_t)(CHUNK_ROWS - 1)) == 0 &&
            p->saves == (size_t)(balance->step >> CHUNK_SHIFT) - 1)
            tally_save(p, p->saves);
    }
    return true;
}

/* ---- repeating the steps ---- */

/* Returns true if the states of the run can be computed again from its scene, its grids and its
 * number of steps. */
static bool is_repeatable(const struct run *run)
{
    const struct run_private *p = run->private_state;
    return !run->settings.compensated && run->trace->interval == 0 && p->epochs == 1 &&
           p->kicks == 0 && !p->is_unrepeatable && !(run->method->flags & METHOD_EXTERNAL);
}

bool ledger_waits(const struct run *run)
{
    return run->settings.unbalanced || (is_repeatable(run) && !trace_marked(run->trace) &&
                                        run->private_state->balance.step == 0);
}

/* Advances the run `again` as the run has been advanced, over the same grids; ledger_take() enters
 * its steps into the balance of the run. Returns false if that does not lead to the run's present
 * state. */
static bool repeat_steps(const struct run *run, struct run *again)
{
    const struct trace *trace = run->trace;
    again->private_state->original = run;
    for (size_t i = 1; trace->grid && i <= trace->grids; i++) {
        const struct time_grid *next = i < trace->grids ? &trace->grid[i] : NULL;
        const double end = next ? next->origin : run->t;
        const int64_t end_step = next ? next->first : run->steps;
        const struct run_target target = {.t = run->plan.adaptive ? trace->grid[i - 1].origin : end,
                                          .steps = end_step - again->steps};
        if (target.steps > 0)
            run_advance(again, &target, 0, run->cancel);
    }
    return again->steps == run->steps &&
           memcmp(again->y, run->y, (size_t)run->system.n * sizeof *run->y) == 0;
}

/* Repeats the steps in a second run if rows lack marks. Returns ledger_known(). */
bool ledger_demand(const struct run *run)
{
    struct run_settings settings = run->settings;
    struct run_private *p = run->private_state;
    struct error ignored;
    if (ledger_known(run) || settings.unbalanced || run->system.order != 2 || !is_repeatable(run) ||
        cancelled(run->cancel)) /* even making room for the marks takes a while */
        return ledger_known(run);
    settings.record = (struct recording_rule){.rule = RECORD_EVERY, .every = INT64_MAX};
    settings.unbalanced = true;
    struct run *again = run_create(&run->scene, run->method, &settings, HUGE_VAL, &ignored);
    bool known = again && trace_mark_rows(run->trace, run->plan.ledger);
    if (known) {
        balance_begin(run, &p->balance);
        trace_set_mark(run->trace, 0, &p->balance.tally);
        known = repeat_steps(run, again);
        p->is_unrepeatable = !known && again->stop != STOP_CANCELLED;
    }
    if (!known) {
        trace_forget_marks(run->trace);
        balance_begin(run, &p->balance);
    }
    run_destroy(again);
    return known;
}

void ledger_will_not_repeat(struct run *run)
{
    ledger_demand(run);
    run->private_state->is_unrepeatable = true;
}

/* ---- while the run advances ---- */

/*
 * Thinning of a full trace that has each step. It is done in parts, between which the program looks
 * at keys and at Ctrl-C: choose the rows that stay, make room for their marks, compute the marks,
 * move the rows. Until the last part the trace shows each step, and the members here are those that
 * struct trace will have; thinning_exchange() swaps them while a part is done.
 */
struct thinning {
    int64_t bucket;
    size_t count, mark_width;
    struct balance balance; /* balance at the last mark that was computed */
};

static const int64_t part_ns = 5000000; /* length of a part */

/* Swaps the members of the trace that thinning changes with those in *other. */
static void thinning_exchange(struct trace *trace, struct thinning *other)
{
    const struct thinning was = {trace->bucket, trace->count, trace->mark_width, {.step = 0}};
    trace->bucket = other->bucket;
    trace->count = other->count;
    trace->mark_width = other->mark_width;
    other->bucket = was.bucket;
    other->count = was.count;
    other->mark_width = was.mark_width;
}

bool ledger_is_due(const struct run *run)
{
    const struct trace *trace = run->trace;
    return trace->decimates && !trace_marked(trace) && run->system.order == 2 &&
           trace->bucket == 1 && trace->count >= trace->cap && !ledger_waits(run);
}

/* Computes marks of rows that stay, for part_ns; the trace has each of `rows` rows still. Returns
 * false if Ctrl-C left a mark that is wrong. */
static bool staying_rows_mark(const struct run *run, struct balance *balance, size_t rows)
{
    const int64_t begin = clock_ns();
    struct work_done done;
    while (balance->step + 1 < (int64_t)rows && clock_ns() - begin < part_ns) {
        size_t count;
        const int solved = balance->solved;
        const double *row = trace_rows(run->trace, (size_t)balance->step + 1, rows, &count);
        balance_block(run, balance, row, times_of(run, row), run->trace->width, (int64_t)count,
                      &done, true);
        if (balance->solved > solved && cancelled(run->cancel))
            return false;
    }
    return true;
}

void ledger_forget_thinning(struct run_private *p)
{
    free(p->thinning);
    p->thinning = NULL;
}

/* Does the first part of the thinning, which chooses the rows that stay. Returns false if out of
 * memory. */
static bool thinning_begin(struct run_private *p, struct trace *trace)
{
    p->thinning = malloc(sizeof *p->thinning);
    if (!p->thinning)
        return false;
    *p->thinning = (struct thinning){.bucket = 1, .count = trace->count};
    const bool thinned = trace_thin(trace);
    if (thinned)
        thinning_exchange(trace, p->thinning);
    else
        ledger_forget_thinning(p);
    return thinned;
}

/* Does one part of the thinning: chooses rows, makes room for marks, computes some, or moves
 * rows. */
bool ledger_thin(struct run *run)
{
    struct run_private *p = run->private_state;
    struct trace *trace = run->trace;
    const size_t all = trace->count;
    if (!p->thinning)
        return thinning_begin(p, trace);
    struct balance *balance = &p->thinning->balance;
    bool fine = true, right = true;
    thinning_exchange(trace, p->thinning);
    if (trace_marked(trace)) {
        right = staying_rows_mark(run, balance, all);
    } else if ((fine = trace_mark_rows(trace, run->plan.ledger))) {
        balance_begin(run, balance);
        trace_set_mark(trace, 0, &balance->tally);
    }
    const bool done = fine && right && balance->step + 1 >= (int64_t)all;
    if (done) {
        p->balance = *balance;
        trace_thinned(trace);
    } else {
        thinning_exchange(trace, p->thinning);
    }
    if (done || !fine || !right)
        ledger_forget_thinning(p);
    return fine;
}

bool ledger_is_asked(const struct run *run)
{
    const int64_t known = run->private_state->balance.step;
    return !trace_marked(run->trace) && known > 0 && known == run->steps;
}

void ledger_follow(const struct run *run)
{
    balance_add_rows(run);
}

bool ledger_ready(struct run *run)
{
    const struct cancel *cancel = run->cancel;
    bool fine = true;
    run->cancel = NULL;
    while (fine && ledger_is_due(run))
        fine = ledger_thin(run);
    run->cancel = cancel;
    return fine;
}

void ledger_take(struct run *run, const double *row, const double *time, size_t stride,
                 int64_t count)
{
    struct work_done done;
    const struct run *owner = run->private_state->original ? run->private_state->original : run;
    if (!trace_marked(owner->trace))
        return;
    while (count > 0) {
        const int taken = balance_block(owner, &owner->private_state->balance, row, time, stride,
                                        count, &done, true);
        row += (size_t)taken * stride;
        time = time ? time + (size_t)taken * stride : NULL;
        count -= taken;
    }
}

void ledger_inside(struct run *run, double t, const double *y)
{
    if (!trace_marked(run->trace))
        return;
    struct balance inside = run->private_state->balance;
    balance_extend(run, &inside, t, y);
    trace_set_mark(run->trace, run->trace->count - 1, &inside.tally);
}

bool balance_present(const struct run *run, struct balance *balance)
{
    if (!trace_marked(run->trace) && !balance_add_rows(run)) {
        *balance = (struct balance){.tally = {.work = {NAN, 0}, .drag = {NAN, 0}}};
        return false;
    }
    *balance = run->private_state->balance;
    if (balance->step != run->steps)
        balance_extend(run, balance, run->t, run->y);
    return true;
}

/* Takes the energy balance back to the run's present step after steps were undone: to the mark of
 * that row in the trace if rows have marks, else to the last saved balance before it, from which
 * the balance is computed again. */
void ledger_back(struct run *run)
{
    struct run_private *p = run->private_state;
    struct trace *trace = run->trace;
    ledger_forget_thinning(p);
    if (run->system.order != 2)
        return;
    if (run->steps == 0) {
        p->saves = 0;
        balance_begin(run, &p->balance);
        if (trace_marked(trace))
            trace_set_mark(trace, 0, &p->balance.tally);
        return;
    }
    if (!ledger_known(run) || (!trace_marked(trace) && p->balance.step <= run->steps))
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

/* Multiplies all sums of a tally by a factor. */
static void tally_scale(struct energy_tally *tally, double factor)
{
    double *value[] = {&tally->work.high, &tally->work.low, &tally->drag.high,
                       &tally->drag.low,  &tally->max,      &tally->scale};
    for (size_t i = 0; i < COUNT_OF(value); i++)
        *value[i] *= factor;
}

void ledger_rescale(struct run *run, double factor)
{
    struct run_private *p = run->private_state;
    const double ratio = (factor / p->factor) * (factor / p->factor);
    if (p->factor == factor)
        return;
    p->factor = factor;
    if (!trace_marked(run->trace)) {
        p->saves = 0;
        balance_begin(run, &p->balance);
        return;
    }
    tally_scale(&p->balance.tally, ratio);
    p->balance.initial *= ratio;
    for (size_t i = 0; i < run->trace->count; i++) {
        struct energy_tally mark = trace_mark(run->trace, i);
        tally_scale(&mark, ratio);
        trace_set_mark(run->trace, i, &mark);
    }
}

/* ---- results ---- */

/* Fills only the energies at the start and at present; work and errors become NAN. */
static void energies_alone(const struct run *run, struct ledger *ledger)
{
    const double unit = run->private_state->factor * run->private_state->factor,
                 initial = run->private_state->balance.initial,
                 final = balance_energy(run, &run_epoch(run, run->steps)->system, run->y);
    *ledger = (struct ledger){.initial = initial / unit,
                              .final = final / unit,
                              .work = NAN,
                              .error = NAN,
                              .error_max = NAN,
                              .factor = final / initial};
}

/* Fills *ledger with the balance of all steps, or with energies alone if it is not known. */
void run_ledger(const struct run *run, struct ledger *ledger)
{
    *ledger = (struct ledger){NAN, NAN, NAN, NAN, NAN, NAN};
    if (!run->system.energy)
        return;
    const double unit = run->private_state->factor * run->private_state->factor;
    struct balance balance;
    if (!ledger_demand(run) || !balance_present(run, &balance)) {
        energies_alone(run, ledger);
        return;
    }
    const struct energy_tally *tally = &balance.tally;
    const double
        energy = balance_energy(run, &run_epoch(run, run->steps)->system, balance.y),
        work = tally->work.high + tally->work.low,
        /* An energy that is always 0 (x'' = -1/x from 1) is no unit; the kinetic one is. */
        moving = system_kinetic(&run_epoch(run, run->steps)->system, balance.y),
        scale = balance.initial != 0 ? fabs(balance.initial) : fmax(tally->scale, moving);
    ledger->initial = balance.initial / unit;
    ledger->final = energy / unit;
    ledger->factor = energy / balance.initial;
    ledger->work = work / unit;
    if (scale > 0) {
        ledger->error = (energy - balance.initial - work) / scale;
        /* The largest so far skips what is unknown, so that it is unknown from there on. */
        ledger->error_max = isnan(work) && isfinite(energy) ? NAN : tally->max / scale;
    }
}

/* Largest number of steps for which the summary of a run shows the balance without being asked. The
 * work in long adaptive steps is found by solving the equations again, which takes longer. */
#define BRIEF_STEPS 4096
#define BRIEF_ADAPTIVE 256

bool ledger_is_brief(const struct plan *plan, int64_t steps)
{
    return steps <= (plan->adaptive && plan->ledger ? BRIEF_ADAPTIVE : BRIEF_STEPS);
}

bool ledger_is_sampled(const struct system *system, const struct plan *plan)
{
    return !plan->ledger && !typed_potential_is_integrated(system);
}

/* Returns the largest relative error of the energy in one row of each of LEDGER_SAMPLE equal parts
 * of a run without work. The row within each part is pseudo-random, so that no period of the motion
 * hides the error. */
static double sampled_error(const struct run *run, const struct ledger *ledger)
{
    const double unit = run->private_state->factor * run->private_state->factor;
    const uint64_t rows = trace_count(run->trace),
                   parts = rows < LEDGER_SAMPLE ? rows : LEDGER_SAMPLE;
    double max = fabs(ledger->final - ledger->initial), scale = fabs(ledger->final);
    uint64_t random = 1;
    for (uint64_t k = 0; k < parts; k++) {
        const uint64_t begin = rows * k / parts, count = rows * (k + 1) / parts - begin;
        random = random * 6364136223846793005u + 1442695040888963407u;
        const size_t row = (size_t)(begin + (random >> 32) % count);
        const double energy =
            balance_energy(run, &run->system, trace_state(run->trace, row)) / unit;
        max = fmax(max, fabs(energy - ledger->initial));
        scale = fmax(scale, fabs(energy));
    }
    return max / (ledger->initial != 0 ? fabs(ledger->initial) : scale);
}

void run_ledger_brief(const struct run *run, struct ledger *ledger)
{
    /* The decision depends on all steps, not on those that the balance still lacks: their number
     * depends on the clock. */
    if (!run->system.energy || trace_marked(run->trace) ||
        ledger_is_brief(&run->plan, run->steps)) {
        run_ledger(run, ledger);
        return;
    }
    energies_alone(run, ledger);
    if (ledger_is_sampled(&run->system, &run->plan))
        ledger->error_max = sampled_error(run, ledger);
}

/* An energy above this many times that at both ends counts as a peak. */
#define ENERGY_PEAK_FACTOR 100
/* Rows from one that is examined to the next; a peak that fixed steps resolve is wider. */
#define PEAK_STRIDE 16

/* Returns the largest energy [J] of every stride-th row. */
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
    /* Passing over all rows of a run of fixed steps takes long, and most have no peak. One that the
     * steps resolve raises some PEAK_STRIDE-th row to a tenth of its height. */
    if (!run->plan.adaptive && !(largest_energy(run, PEAK_STRIDE) > ENERGY_PEAK_FACTOR / 10 * ends))
        return NAN;
    const double max = largest_energy(run, 1);
    return max > ENERGY_PEAK_FACTOR * ends && isfinite(max) ? max / fabs(ledger->initial) : NAN;
}

bool ledger_known(const struct run *run)
{
    const struct trace *trace = run->trace;
    return trace_marked(trace) || (trace->bucket == 1 && trace->every == 1 && trace->interval == 0);
}
