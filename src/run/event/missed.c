/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run_missed_burst(): search for bursts, changes of a force so short that no step of a run has met
 * them. Typed equations tell where they may be; a step over such a time is then compared with
 * accurate solutions with and without the burst. */
#include <hooke/base/cancel.h>
#include <hooke/run/unresolved.h>
#include <hooke/scene/bursts.h>

#include "run/event/watch.h"

#include <float.h>
#include <math.h>

/* Largest number of segments of a run, straight ways between recorded states, that are searched. */
#define MISSED_SEGMENTS_MAX 256
#define SEGMENT_BURSTS_MAX 16 /* largest number of bursts that are kept of them */
/* Parts in which a step is solved again, so that the solution meets each burst. */
#define BURST_SUBSTEPS 4
#define SOLVE_TOL 1e-9 /* tolerance of that solution */
/* A burst shorter than this, in units of the last place of t, is a point, like a singularity. */
#define BURST_MIN_ULPS 1000
/* A step has missed a burst if it is this many times farther from the solution with it than from
 * the one without; a step across a jump is about equally far from either. */
#define BURST_DISTANCE_RATIO 4
/* Smaller values of a variable count as this part of its natural size. */
#define SIZE_MIN 1e-6
/* A look examines one interval of a segment, which takes the time of 200 evaluations. */
enum {
    LOOKS_MIN = 1024,      /* looks of a search in any case, */
    LOOKS_A_WAY = 8,       /* more for each segment and variable, */
    EVALS_A_LOOK = 5000,   /* and one more per that many evaluations of the run */
    LOOKS_ONE_WAY = 128,   /* looks along one segment that are always allowed */
    LOOKS_A_SOLUTION = 256 /* price, in looks, of solving a step again */
};
/* Distance from a burst, as a part of its length, at which rates are those without it. */
#define BURST_MARGIN 1e-3

/* Returns the first row from `first` on whose time is after t, in the direction of the run. */
static size_t row_beyond(const struct trace *trace, size_t first, double t)
{
    size_t row = trace_row_at(trace, t);
    while (row < trace_count(trace) && trace_time(trace, row) == t)
        row++;
    return row > first ? row : first;
}

/* Returns true if a row after `first` was recorded inside of the burst, so that steps have met
 * it. */
static bool is_seen(const struct trace *trace, size_t first, const struct burst *burst)
{
    const double low = fmin(burst->t_begin, burst->t_end),
                 high = fmax(burst->t_begin, burst->t_end);
    const size_t row = row_beyond(trace, first, burst->t_begin);
    return row < trace_count(trace) && trace_time(trace, row) > low &&
           trace_time(trace, row) < high;
}

/* ---- deciding whether a step has met a burst ---- */

/* Solves the equations from y at t to `end` in BURST_SUBSTEPS parts, into y. Returns false if that
 * fails. */
static bool solve_pieces(const struct run *run, double t, double *y, double end)
{
    const struct system *system = &run->system;
    for (int i = 1; i <= BURST_SUBSTEPS; i++) {
        const double next = i < BURST_SUBSTEPS ? t + (end - t) * i / BURST_SUBSTEPS : end,
                     piece_begin = t + (end - t) * (i - 1) / BURST_SUBSTEPS;
        if (piece_begin != next &&
            !run_solve_cheaply(system, piece_begin, y, next, SOLVE_TOL, y, run->cancel))
            return false;
    }
    return true;
}

/* Returns the largest distance of the state after row i from y [n], in the sizes of the
 * variables. */
static double distance_of_step(const struct run *run, size_t i, const double *y)
{
    const double *y_begin = trace_state(run->trace, i), *y_end = trace_state(run->trace, i + 1);
    double max = 0;
    for (int k = 0; k < run->system.n; k++) {
        const double size =
            fmax(run->system.scale[k] * SIZE_MIN, fmax(fabs(y_begin[k]), fabs(y_end[k])));
        max = fmax(max, fabs(y_end[k] - y[k]) / size);
    }
    return max;
}

/* Returns the variable in which two states differ most, in natural sizes. */
static int most_different(const struct system *system, const double *a, const double *b)
{
    int most = 0;
    for (int k = 1; k < system->n; k++)
        if (fabs(a[k] - b[k]) / system->scale[k] > fabs(a[most] - b[most]) / system->scale[most])
            most = k;
    return most;
}

/* Decides whether the step from row i missed the burst, a short change of the rates. The solution
 * through the burst is compared with one that keeps the rates from just before it: a step that met
 * the burst, or ended at its switch, is nearer to the first, one that missed it to the second.
 * Returns true also if this cannot be decided, but false for singularities and for bursts too short
 * to resolve. */
static bool step_passed_over(const struct run *run, size_t i, const struct burst *burst)
{
    const int n = run->system.n;
    const double t = trace_time(run->trace, i), end = trace_time(run->trace, i + 1),
                 length = burst->t_end - burst->t_begin;
    double y_solved[LIMIT_VARIABLES], y_extrapolated[LIMIT_VARIABLES], slope[LIMIT_VARIABLES],
        end_slope[LIMIT_VARIABLES];
    system_derivative(&run->system, burst->t_begin + length / 2, trace_state(run->trace, i), slope);
    for (int k = 0; k < n; k++)
        if (!isfinite(slope[k]))
            return false;
    if (fabs(length) < BURST_MIN_ULPS * DBL_EPSILON * fabs(burst->t_begin))
        return false;
    copy_state(y_solved, trace_state(run->trace, i), n);
    if (!solve_pieces(run, t, y_solved, burst->t_begin))
        return true;
    copy_state(y_extrapolated, y_solved, n);
    const double slope_time = burst->t_begin - length * BURST_MARGIN;
    system_derivative(&run->system, (slope_time - t) * length > 0 ? slope_time : t, y_extrapolated,
                      slope);
    for (int k = 0; k < n; k++)
        y_extrapolated[k] += length * slope[k];
    if (!solve_pieces(run, burst->t_begin, y_solved, burst->t_end) ||
        !solve_pieces(run, burst->t_end, y_solved, end) ||
        !solve_pieces(run, burst->t_end, y_extrapolated, end))
        return true;
    if (!(distance_of_step(run, i, y_solved) >
          BURST_DISTANCE_RATIO * distance_of_step(run, i, y_extrapolated)))
        return false;
    /* A jump after which the rates differ is no burst: the next steps meet its consequences. */
    const int k = most_different(&run->system, y_solved, y_extrapolated);
    system_derivative(&run->system, burst->t_end + length * BURST_MARGIN, y_solved, end_slope);
    return fabs(end_slope[k] - slope[k]) <=
           fabs(y_solved[k] - y_extrapolated[k]) / fabs(length) / 2;
}

/* Tests whether one of the run's steps missed the burst *found, which was found along a segment of
 * several steps from row `first`. It must be found along that step, too, since the segment may
 * cross a switch at another time than the step that ended there. Returns true, and sets *there to
 * the burst (all bursts within a step are united), if so. *allowed is the remaining work; the
 * result is false when it is used up. */
static bool is_missed_by_step(const struct run *run, size_t first, const struct burst *found,
                              int64_t *allowed, struct burst *there)
{
    const struct trace *trace = run->trace;
    const size_t next_row = row_beyond(trace, first, found->t_begin);
    const size_t end = row_beyond(trace, first, found->t_end);
    for (size_t i = next_row > first ? next_row - 1 : first; i <= end && i + 1 < trace_count(trace);
         i++) {
        const double t[2] = {trace_time(trace, i), trace_time(trace, i + 1)};
        struct burst burst[SEGMENT_BURSTS_MAX];
        if (cancelled(run->cancel) || *allowed <= 0)
            return false;
        if (t[0] == t[1])
            continue;
        const int count =
            bursts_within(&run->system, t, trace_state(trace, i), trace_state(trace, i + 1), true,
                          allowed, burst, 0, SEGMENT_BURSTS_MAX);
        if (count == 0)
            continue;
        *there = burst[0];
        for (int k = 1; k < count; k++) {
            const bool forward = t[1] > t[0];
            there->t_begin = forward ? fmin(there->t_begin, burst[k].t_begin)
                                     : fmax(there->t_begin, burst[k].t_begin);
            there->t_end =
                forward ? fmax(there->t_end, burst[k].t_end) : fmin(there->t_end, burst[k].t_end);
        }
        if (is_seen(trace, first, there))
            continue;
        *allowed -= LOOKS_A_SOLUTION;
        if (step_passed_over(run, i, there))
            return true;
    }
    return false;
}

/* State of a search over the segments of a run. */
struct burst_search {
    const struct run *run;
    size_t first;          /* row at which it begins */
    int64_t allowed;       /* looks that are left along segments, */
    int64_t allowed_steps; /* and along single steps where something was found */
    struct burst burst[SEGMENT_BURSTS_MAX];
    int count; /* bursts found along segments and not yet examined */
};

/* Examines the bursts found so far, and removes them, except one that ends at time `open` [s],
 * because the next segment may continue it. Returns true, with *missed, if one of them was
 * missed. */
static bool bursts_examine(struct burst_search *search, double open, struct burst *missed)
{
    const struct trace *trace = search->run->trace;
    const size_t first = search->first;
    int left = 0;
    for (int i = 0; i < search->count; i++) {
        const struct burst burst = search->burst[i];
        struct burst there = burst;
        if (burst.t_end == open) {
            search->burst[left++] = burst;
        } else if ((first == 0 || burst.t_begin != trace_time(trace, first)) &&
                   is_missed_by_step(search->run, first, &burst, &search->allowed_steps, &there)) {
            *missed = there;
            return true;
        }
    }
    search->count = left;
    return false;
}

/* Searches the segment from y_begin to y_end at the times t, with its share of the looks that are
 * left for `ways` segments. */
static void segment_search(struct burst_search *search, const double t[2], const double *y_begin,
                           const double *y_end, size_t ways)
{
    const int64_t part = search->allowed / (int64_t)ways * LOOKS_A_WAY,
                  given = part > LOOKS_ONE_WAY ? part : LOOKS_ONE_WAY;
    const int64_t allowed = given < search->allowed ? given : search->allowed;
    int64_t left = allowed;
    search->count = bursts_within(&search->run->system, t, y_begin, y_end, true, &left,
                                  search->burst, search->count, SEGMENT_BURSTS_MAX);
    search->allowed -= allowed - left;
}

int64_t run_burst_looks(const struct system *system, size_t ways, int64_t evals)
{
    return LOOKS_MIN + LOOKS_A_WAY * (int64_t)ways * system->n + evals / EVALS_A_LOOK;
}

/* Searches the segments that are new since the last call, as long as looks are left. */
bool run_missed_burst(struct run *run, struct burst *missed)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const size_t rows = trace_count(trace);
    if (run->system.autonomous || (!run->plan.adaptive && !run_force_may_pulse(&run->system)) ||
        rows < 2 || trace_decimated(trace) || run->settings.record.rule > RECORD_ALL ||
        stop_is_failure(run->stop))
        return false;
    /* Start one segment before the new rows: a burst around the first of them is one burst. */
    const size_t all = rows - 1, length = all > MISSED_SEGMENTS_MAX ? all / MISSED_SEGMENTS_MAX : 1;
    const size_t first = p->searched > length ? p->searched - length : 0, steps = all - first;
    const size_t even = (steps * MISSED_SEGMENTS_MAX + all - 1) / all,
                 ways = steps < even ? steps : even;
    const int64_t allowed = run_burst_looks(&run->system, ways, run->cost.evals);
    struct burst_search search = {.run = run,
                                  .first = first,
                                  .allowed = allowed,
                                  .allowed_steps = allowed + LOOKS_A_SOLUTION * SEGMENT_BURSTS_MAX};
    p->searched = all;
    for (size_t k = 0; k < ways && search.allowed > 0 && !cancelled(run->cancel); k++) {
        const size_t row_begin = first + k * steps / ways, row_end = first + (k + 1) * steps / ways;
        const double t[2] = {trace_time(trace, row_begin), trace_time(trace, row_end)};
        if (t[0] == t[1])
            continue;
        segment_search(&search, t, trace_state(trace, row_begin), trace_state(trace, row_end),
                       ways - k);
        if (bursts_examine(&search, t[1], missed))
            return true;
    }
    return bursts_examine(&search, NAN, missed);
}
