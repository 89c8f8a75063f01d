/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What happens in so short a time that no step of a run has seen it. */
#include "run/private.h"

#include <math.h>

#define WAYS 256 /* along which it is looked for in a run */
#define BURSTS 16

/* A recorded state inside, of those from row `first` on. */
static bool is_seen(const struct trace *trace, size_t first, const struct burst *burst)
{
    const double low = fmin(burst->from, burst->to), high = fmax(burst->from, burst->to);
    for (size_t i = first; i < trace_count(trace); i++)
        if (trace_time(trace, i) > low && trace_time(trace, i) < high)
            return true;
    return false;
}

bool run_missed_burst(struct run *run, struct burst *missed)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const size_t rows = trace_count(trace);
    struct burst burst[BURSTS];
    int count = 0;
    if (run->system.autonomous || rows < 2 || trace_decimated(trace) || run->settings.record.rule > RECORD_ALL ||
        stop_is_failure(run->stop))
        return false;
    /* From one way before the new rows on: a burst around the first of them is one burst. */
    const size_t all = rows - 1, length = all > WAYS ? all / WAYS : 1;
    const size_t first = p->searched > length ? p->searched - length : 0, steps = all - first;
    const size_t even = (steps * WAYS + all - 1) / all, ways = steps < even ? steps : even;
    p->searched = all;
    for (size_t k = 0; k < ways; k++) {
        const size_t from = first + k * steps / ways, to = first + (k + 1) * steps / ways;
        const double t[2] = {trace_time(trace, from), trace_time(trace, to)};
        if (t[0] != t[1])
            count = system_bursts(&run->system, t, trace_state(trace, from), trace_state(trace, to), true, burst, count,
                                  BURSTS);
    }
    for (int i = 0; i < count; i++)
        if ((first == 0 || burst[i].from != trace_time(trace, first)) && !is_seen(trace, first, &burst[i])) {
            *missed = burst[i];
            return true;
        }
    return false;
}
