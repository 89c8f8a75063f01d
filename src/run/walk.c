/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walks over the rows of a run: each row becomes a sample, from which observables are computed. The
 * energy balance and the exact solution are carried along only if the samples need them. */
#include "run/private.h"

/* Sets walk->state to y times the factor with which energies stay in range. */
static void walk_state_scale(struct walk *walk, const double *y)
{
    double factor = walk->run->private_state->factor;
    for (int i = 0; i < walk->run->system.n; i++)
        walk->state[i] = y[i] * factor;
}

/* Sets walk->sample to that of the state y at t. The work and the work of drag are in units of
 * factor^2 J; walk->state is y scaled. */
static void walk_sample_fill(struct walk *walk, int64_t step, double t, const double *y,
                             double work, double drag)
{
    const struct run *run = walk->run;
    const struct epoch *epoch = run_epoch(run, step);
    bool scaled = walk->needs & NEED_RATIO;
    double energy_unit = scaled ? 1 : run->private_state->factor * run->private_state->factor;
    struct sample *sample = &walk->sample;
    sample->t = t;
    sample->y = scaled ? walk->state : y;
    sample->system = &epoch->system;
    sample->work = work / energy_unit;
    sample->dissipated = -drag / energy_unit;
    if (!(walk->needs & NEED_EXACT))
        return;
    if (walk->table)
        exact_table_at(walk->table, t, walk->exact);
    else
        system_exact(&epoch->system, epoch->t, epoch->start, t, walk->exact, NULL);
}

/* Makes a table of the exact solution for the epoch of `step`, if rows are at equal times: what the
 * solution does from row to row is computed once. A method that uses the exact solution itself is
 * compared with the very same function, without a table. */
static void exact_tabulate(struct walk *walk, int64_t step)
{
    const struct run *run = walk->run;
    const struct epoch *epoch = run_epoch(run, step);
    if (epoch == walk->epoch || run->plan.adaptive || run->method->flags & METHOD_EXACT)
        return;
    const struct trace *trace = run->trace;
    const double h = trace->interval > 0 ? trace->ahead * trace->interval
                                         : (double)trace->every * trace_grid_of(trace, step)->h;
    exact_table_free(walk->table);
    walk->table = trace_decimated(trace)
                      ? NULL
                      : exact_table_create(&epoch->system, epoch->t, epoch->start, h);
    walk->epoch = epoch;
}

/* Begins before the first row; the energy balance is requested if samples need it. */
void walk_begin(struct walk *walk, const struct run *run, unsigned needs)
{
    *walk = (struct walk){.run = run, .needs = needs};
    walk->sample.run = run;
    walk->sample.exact = walk->exact;
    if (needs & NEED_WORK) {
        if (run->plan.ledger)
            ledger_demand(run);
        const double *y = trace_state(run->trace, 0);
        walk_state_scale(walk, y);
        walk->sample.initial =
            system_energy(&run_epoch(run, 0)->system, needs & NEED_RATIO ? walk->state : y);
        balance_begin(run, &walk->balance);
        walk->done_begin = walk->done_end = 1;
    }
}

/* Returns the value of a compensated sum. */
static double compensated_value(struct compensated_sum sum)
{
    return sum.high + sum.low;
}

/* Computes the work at the recorded row i of a trace that has each step and no marks. The balance
 * advances by blocks of rows as the walk reaches them. */
static void work_from_rows(struct walk *walk, size_t i, double *work, double *drag)
{
    const struct run *run = walk->run;
    if (i == walk->done_end) {
        size_t count;
        const double *row = trace_rows(run->trace, i, run->trace->count, &count);
        const double *time = run->plan.adaptive ? row + run->system.n : NULL;
        walk->done_begin = i;
        walk->done_end += (size_t)balance_block(run, &walk->balance, row, time, run->trace->width,
                                                (int64_t)count, &walk->done, false);
    }
    *work = walk->done.all_work[i - walk->done_begin];
    *drag = walk->done.all_drag[i - walk->done_begin];
}

/* Sets the work, and that of drag, since the start up to row i, in units of factor^2 J; NAN if they
 * are not known. */
static void work_at_row(struct walk *walk, size_t i, double *work, double *drag)
{
    const struct run *run = walk->run;
    *work = *drag = 0;
    if (i == 0 || !run->plan.ledger)
        return;
    struct energy_tally tally;
    if (!ledger_known(run)) {
        *work = *drag = NAN;
        return;
    }
    if (!trace_marked(run->trace) && i < run->trace->count) {
        work_from_rows(walk, i, work, drag);
        return;
    }
    if (i < run->trace->count) {
        tally = trace_mark(run->trace, i);
    } else {
        struct balance present;
        balance_present(run, &present);
        tally = present.tally;
    }
    *work = compensated_value(tally.work);
    *drag = compensated_value(tally.drag);
}

void walk_leave(struct walk *walk)
{
    exact_table_free(walk->table);
    walk->table = NULL;
}

/* Makes the sample of the next row. Returns false after the last one. */
bool walk_next(struct walk *walk)
{
    const struct run *run = walk->run;
    size_t i = walk->next++;
    if (i >= trace_count(run->trace)) {
        walk_leave(walk);
        return false;
    }
    if (walk->needs & NEED_EXACT)
        exact_tabulate(walk, trace_step(run->trace, i));
    const double *y = trace_state(run->trace, i);
    double work = 0, drag = 0;
    walk_state_scale(walk, y);
    if (walk->needs & NEED_WORK)
        work_at_row(walk, i, &work, &drag);
    walk_sample_fill(walk, trace_step(run->trace, i), trace_time(run->trace, i), y, work, drag);
    return true;
}

/* Makes the sample of the present state. */
void walk_present(struct walk *walk, const struct run *run, unsigned needs)
{
    double work = 0, drag = 0;
    walk_begin(walk, run, needs);
    if (needs & NEED_WORK && run->plan.ledger) {
        struct balance present = {.tally = {.work = {NAN, 0}, .drag = {NAN, 0}}};
        if (ledger_demand(run))
            balance_present(run, &present);
        work = compensated_value(present.tally.work);
        drag = compensated_value(present.tally.drag);
    }
    walk_state_scale(walk, run->y);
    walk_sample_fill(walk, run->steps, run->t, run->y, work, drag);
}
