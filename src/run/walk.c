/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Walking over the rows of a run: each becomes a sample, and the energy balance is carried along where it is needed. */
#include "private.h"

static void take_state(struct walk *walk, const double *y)
{
    double factor = walk->run->private_state->factor;
    for (int i = 0; i < walk->run->system.n; i++)
        walk->state[i] = y[i] * factor;
}

/* The sample for (step, t, y); walk->state holds y scaled, the balance is where it has to be. */
static void fill(struct walk *walk, int64_t step, double t, const double *y)
{
    const struct run *run = walk->run;
    const struct epoch *epoch = run_epoch(run, step);
    bool scaled = walk->needs & NEED_RATIO;
    double unit = scaled ? 1 : run->private_state->factor * run->private_state->factor;
    struct sample *sample = &walk->sample;
    sample->t = t;
    sample->y = scaled ? walk->state : y;
    sample->system = &epoch->system;
    sample->work = (walk->balance.work.high + walk->balance.work.low) / unit;
    sample->dissipated = -(walk->balance.drag.high + walk->balance.drag.low) / unit;
    if (walk->needs & NEED_EXACT)
        system_exact(&epoch->system, epoch->t, epoch->start, t, walk->exact, NULL);
}

void walk_begin(struct walk *walk, const struct run *run, unsigned needs)
{
    memset(walk, 0, sizeof *walk);
    walk->run = run;
    walk->needs = needs;
    walk->sample.run = run;
    walk->sample.exact = walk->exact;
    if (needs & NEED_WORK) {
        const double *y = trace_state(run->trace, 0);
        take_state(walk, y);
        walk->sample.initial = system_energy(&run_epoch(run, 0)->system, needs & NEED_RATIO ? walk->state : y);
    }
}

bool walk_next(struct walk *walk)
{
    const struct run *run = walk->run;
    size_t i = walk->next++;
    if (i >= trace_count(run->trace))
        return false;
    int64_t step = trace_step(run->trace, i);
    double t = trace_time(run->trace, i);
    const double *y = trace_state(run->trace, i);
    take_state(walk, y);
    if (i > 0 && walk->needs & NEED_WORK && run->plan.ledger)
        balance_extend(&walk->balance, run, i - 1, step, t, walk->state);
    fill(walk, step, t, y);
    return true;
}

/* On to recorded row `to`. */
static void carry(struct walk *walk, struct balance *balance, size_t to)
{
    const struct trace *trace = walk->run->trace;
    for (; balance->row < to; balance->row++) {
        take_state(walk, trace_state(trace, balance->row + 1));
        balance_extend(balance, walk->run, balance->row, trace_step(trace, balance->row + 1),
                       trace_time(trace, balance->row + 1), walk->state);
    }
}

void walk_present(struct walk *walk, const struct run *run, unsigned needs)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    walk_begin(walk, run, needs);
    if (needs & NEED_WORK && run->plan.ledger) {
        if (p->generation != trace->generation) {
            p->generation = trace->generation;
            p->settled = (struct balance){0};
        }
        size_t settled = trace_settled(trace);
        carry(walk, &p->settled, settled > 0 ? settled - 1 : 0); /* kept for the next call */
        walk->balance = p->settled;
        carry(walk, &walk->balance, trace->count - 1);
        take_state(walk, run->y);
        balance_extend(&walk->balance, run, trace->count - 1, run->steps, run->t, walk->state);
    }
    take_state(walk, run->y);
    fill(walk, run->steps, run->t, run->y);
}
