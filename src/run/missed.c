/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What happens in so short a time that no step of a run has seen it. */
#include "private.h"

#include <math.h>

#define WAYS 256 /* along which it is looked for */
#define BURSTS 16

/* A recorded state inside. */
static bool is_seen(const struct run *run, const struct burst *burst)
{
    const double low = fmin(burst->from, burst->to), high = fmax(burst->from, burst->to);
    for (size_t i = 0; i < trace_count(run->trace); i++)
        if (trace_time(run->trace, i) > low && trace_time(run->trace, i) < high)
            return true;
    return false;
}

bool run_missed_burst(const struct run *run, struct burst *missed)
{
    const struct trace *trace = run->trace;
    const size_t rows = trace_count(trace);
    struct burst burst[BURSTS];
    int count = 0;
    if (run->system.autonomous || rows < 2 || trace_decimated(trace) || run->settings.record.rule > RECORD_ALL ||
        stop_is_failure(run->stop))
        return false;
    const size_t ways = rows - 1 < WAYS ? rows - 1 : WAYS;
    for (size_t k = 0; k < ways; k++) {
        const size_t from = k * (rows - 1) / ways, to = (k + 1) * (rows - 1) / ways;
        const double t[2] = {trace_time(trace, from), trace_time(trace, to)};
        if (t[0] != t[1])
            count =
                system_bursts(&run->system, t, trace_state(trace, from), trace_state(trace, to), burst, count, BURSTS);
    }
    for (int i = 0; i < count; i++)
        if (!is_seen(run, &burst[i])) {
            *missed = burst[i];
            return true;
        }
    return false;
}
