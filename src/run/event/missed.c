/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What happens in so short a time that no step of a run has seen it. */
#include "run/private.h"

#include <math.h>

#define WAYS 256 /* along which it is looked for in a run */
#define BURSTS 16

/* The first row from `first` on whose time is beyond t, in the direction of the run. */
static size_t row_beyond(const struct trace *trace, size_t first, double t)
{
    size_t row = trace_row_at(trace, t);
    while (row < trace_count(trace) && trace_time(trace, row) == t)
        row++;
    return row > first ? row : first;
}

/* A recorded state inside, of those from row `first` on. */
static bool is_seen(const struct trace *trace, size_t first, const struct burst *burst)
{
    const double low = fmin(burst->from, burst->to), high = fmax(burst->from, burst->to);
    const size_t row = row_beyond(trace, first, burst->from);
    return row < trace_count(trace) && trace_time(trace, row) > low &&
           trace_time(trace, row) < high;
}

/*
 * Is it there along the steps, too? A way over several of them crosses a switch at another time
 * than the step that ended there.
 */
static bool is_on_steps(const struct run *run, size_t first, const struct burst *found,
                        struct burst *there)
{
    const struct trace *trace = run->trace;
    const size_t beyond = row_beyond(trace, first, found->from);
    const size_t end = row_beyond(trace, first, found->to);
    struct burst burst[BURSTS];
    int count = 0;
    for (size_t i = beyond > first ? beyond - 1 : first; i <= end && i + 1 < trace_count(trace);
         i++) {
        const double t[2] = {trace_time(trace, i), trace_time(trace, i + 1)};
        if (t[0] != t[1])
            count = system_bursts(&run->system, t, trace_state(trace, i), trace_state(trace, i + 1),
                                  true, burst, count, BURSTS);
    }
    for (int i = 0; i < count; i++)
        if (!is_seen(trace, first, &burst[i])) {
            *there = burst[i];
            return true;
        }
    return false;
}

struct burst_search {
    const struct run *run;
    size_t first; /* row */
    bool steps;   /* each way is one */
    struct burst burst[BURSTS];
    int count;
};

/* Is one of them missed? The others go, but for one that may go on after `open`. */
static bool look_through(struct burst_search *search, double open, struct burst *missed)
{
    const struct trace *trace = search->run->trace;
    const size_t first = search->first;
    int left = 0;
    for (int i = 0; i < search->count; i++) {
        const struct burst burst = search->burst[i];
        struct burst there = burst;
        if (burst.to == open) {
            search->burst[left++] = burst;
        } else if ((first == 0 || burst.from != trace_time(trace, first)) &&
                   (search->steps ? !is_seen(trace, first, &burst)
                                  : is_on_steps(search->run, first, &burst, &there))) {
            *missed = there;
            return true;
        }
    }
    search->count = left;
    return false;
}

bool run_missed_burst(struct run *run, struct burst *missed)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const size_t rows = trace_count(trace);
    if (run->system.autonomous || rows < 2 || trace_decimated(trace) ||
        run->settings.record.rule > RECORD_ALL || stop_is_failure(run->stop))
        return false;
    /* From one way before the new rows on: a burst around the first of them is one burst. */
    const size_t all = rows - 1, length = all > WAYS ? all / WAYS : 1;
    const size_t first = p->searched > length ? p->searched - length : 0, steps = all - first;
    const size_t even = (steps * WAYS + all - 1) / all, ways = steps < even ? steps : even;
    struct burst_search search = {.run = run, .first = first, .steps = ways == steps};
    p->searched = all;
    for (size_t k = 0; k < ways; k++) {
        const size_t from = first + k * steps / ways, to = first + (k + 1) * steps / ways;
        const double t[2] = {trace_time(trace, from), trace_time(trace, to)};
        if (t[0] == t[1])
            continue;
        search.count =
            system_bursts(&run->system, t, trace_state(trace, from), trace_state(trace, to), true,
                          search.burst, search.count, BURSTS);
        if (look_through(&search, t[1], missed))
            return true;
    }
    return look_through(&search, NAN, missed);
}
