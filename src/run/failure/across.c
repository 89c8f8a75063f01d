/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps that got across the end of a solution, and go on where there is none. */
#include "run/private.h"

#include <math.h>

/* of the accurate method, where a step looks strange */
#define STEPS_FIRST 2000
/* evaluations of a run for each row that is looked at, which takes what 12 take in a step */
#define EVALS_A_ROW 600
#define ROWS_LOOKED_MIN 512
/* of those that are picked among more where steps take less than a look does */
#define ROWS_PICKED_MIN 128
/* rows of a run from which picking takes longer than ROWS_LOOKED_MIN looks */
#define ROWS_TO_PICK_FROM 30000
#define LOOK_SHARE 16   /* rows for each step of the accurate method where a step looks strange */
#define CHANGE_MIN 0.1  /* of y in a step: less is passed over */
#define STEEPER 8       /* times: the slope after a step that grows without bound */
#define OFF 0.1         /* of y: what a step and the mean of its slopes, or these, may differ by */
#define STEPS_BEYOND 16 /* where a step looks strange: a method may pass too early, or soon */
#define LOOK_EACH 512   /* rows between two looks at the flag of Ctrl-C */

/*
 * Does what happened to a variable in a step of h look as if a singularity lay there? Where it
 * passed through infinity it changed against its slope at both ends, or far less than these want,
 * or its sign and that of its slope; where it did not yet, it has grown, and its slope far more.
 */
static bool looks_across(double h, double y, double slope, double middle_slope, double end,
                         double end_slope)
{
    const double change = end - y, size = fmax(fabs(y), fabs(end)),
                 wanted = slope * end_slope > 0 ? h * slope : 0;
    const double min = fmin(fabs(h * slope), fabs(h * end_slope));
    if (!(fabs(change - h * (slope + end_slope) / 2) <= OFF * size) ||
        !(fabs(h * (middle_slope - (slope + end_slope) / 2)) <=
          OFF * size)) /* which a trapezoid does not see */
        return true;
    if (change * wanted < 0 && fabs(change) > CHANGE_MIN * size)
        return true;
    if (wanted != 0 && min > size && fabs(change) < CHANGE_MIN * min)
        return true;
    return fabs(change) > CHANGE_MIN * size &&
           ((y * end < 0 && slope * end_slope < 0) ||
            (fabs(end) > 2 * fabs(y) && fabs(end_slope) > STEEPER * fabs(slope)));
}

/* Returns true if a variable, and what its slopes make of it in a step of h, is next to nothing
 * beside its natural size: what begins at 0 grows by any factor. */
static bool is_negligible(double size, double h, double y, double slope, double middle_slope,
                          double end, double end_slope)
{
    static const double negligible = 1e-6;
    const double slopes = fmax(fmax(fabs(slope), fabs(middle_slope)), fabs(end_slope));
    return fmax(fmax(fabs(y), fabs(end)), fabs(h) * slopes) < negligible * size;
}

/* Rows i and i + 1. */
static bool row_across(const struct run *run, size_t i)
{
    const struct trace *trace = run->trace;
    const double *y = trace_state(trace, i), *end = trace_state(trace, i + 1);
    const double t = trace_time(trace, i), t_end = trace_time(trace, i + 1);
    double slope[LIMIT_VARIABLES], end_slope[LIMIT_VARIABLES], middle[LIMIT_VARIABLES],
        middle_slope[LIMIT_VARIABLES];
    if (trace_step(trace, i + 1) != trace_step(trace, i) + 1 || t_end == t)
        return false;
    system_derivative(&run->system, t, y, slope);
    system_derivative(&run->system, t_end, end, end_slope);
    for (int k = 0; k < run->system.n; k++)
        middle[k] = hermite(0.5, t_end - t, y[k], slope[k], end[k], end_slope[k]);
    system_derivative(&run->system, t + (t_end - t) / 2, middle, middle_slope);
    for (int k = 0; k < run->system.n; k++)
        if (!is_negligible(run->system.scale[k], t_end - t, y[k], slope[k], middle_slope[k], end[k],
                           end_slope[k]) &&
            looks_across(t_end - t, y[k], slope[k], middle_slope[k], end[k], end_slope[k]))
            return true;
    return false;
}

/* Returns true if a variable changes far more in the step across time t than in those beside it: a
 * stage next to an infinite slope has made the step. Rows are searched from i on. */
static bool step_stands_out(const struct run *run, size_t i, double t)
{
    static const double stands_out = 30;
    const struct trace *trace = run->trace;
    const size_t rows = trace_count(trace);
    while (i + 1 < rows && fabs(trace_time(trace, i + 1) - t) < fabs(trace_time(trace, i) - t))
        i++;
    /* the row nearest to t: the step before or behind it goes across */
    const size_t first = i > 1 ? i - 2 : 0, last = i + 2 < rows ? i + 2 : rows - 1;
    for (int k = 0; k < run->system.n && last - first > 2; k++) {
        double largest[3] = {0, 0, 0}; /* the two steps that meet at t may both be made by it */
        for (size_t row = first; row < last; row++) {
            double change = fabs(trace_state(trace, row + 1)[k] - trace_state(trace, row)[k]);
            for (int j = 0; j < 3; j++) {
                const double larger = fmax(largest[j], change);
                change = fmin(largest[j], change);
                largest[j] = larger;
            }
        }
        if (largest[0] > stands_out * largest[2])
            return true;
    }
    return false;
}

/* Whether the solution ends before `end`, next to the strange step from row i. */
static bool ended_across(struct run *run, size_t i, double end)
{
    const struct singularity found = run_singular_before(run, trace_time(run->trace, i), end,
                                                         STEPS_FIRST + (int64_t)i / LOOK_SHARE);
    /* Past an integrable singularity in t the solution goes on, and so do steps that keep off it.
     */
    const bool goes_on =
        found.finite && !run->system.autonomous && !step_stands_out(run, i, found.t);
    return !goes_on && run_end_singular(run, found);
}

static size_t min_size(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* The changes of each variable from row to row; of fewer than four variables in several lanes. */
struct changes {
    double max[LIMIT_VARIABLES], sum[LIMIT_VARIABLES];
};

#define FOUR_AT(x) (*(const four *)(const void *)(x))

/* Adds the changes from each of `count` rows, whose n numbers are `width` apart, to that behind it;
 * behind the first is `next`. */
CLONES static void changes_add(struct changes *changes, const double *row, const double *next,
                               size_t n, size_t width, size_t count)
{
    size_t k = 0;
    for (; k + FOUR <= n; k += FOUR) {
        four sum = FOUR_AT(changes->sum + k), max = FOUR_AT(changes->max + k);
        for (size_t i = k; i < count * width; i += width) {
            const four moved = FOUR_AT(next + i) - FOUR_AT(row + i),
                       change = (four)((four_bits)moved & INT64_MAX);
            sum += change;
            max = LARGER(change, max);
        }
        memcpy(changes->sum + k, &sum, sizeof sum);
        memcpy(changes->max + k, &max, sizeof max);
    }
    for (; k < n; k++)
        for (size_t i = k; i < count * width; i += width) {
            const double change = fabs(next[i] - row[i]);
            changes->sum[k] += change;
            changes->max[k] = change > changes->max[k] ? change : changes->max[k];
        }
}

/* Adds the changes within some rows. */
static void changes_add_rows(struct changes *changes, const double *row, size_t n, size_t width,
                             size_t rows)
{
    size_t done = 0;
    if (FOUR % n == 0 && width == n) {
        const size_t fours = (rows - 1) * width / FOUR;
        changes_add(changes, row, row + width, FOUR, FOUR, fours);
        done = fours * FOUR / width;
    }
    row += done * width;
    changes_add(changes, row, row + width, n, width, rows - 1 - done);
}

/* Returns the row before the change of a variable that stands out most among the changes in a block
 * of rows, which takes a small part of what dear steps do. */
static size_t largest_change(const struct trace *trace, size_t block, size_t count)
{
    const size_t n = (size_t)trace->n;
    double most = 0;
    size_t variable = 0;
    const size_t end = block + count < trace_count(trace) ? block + count : trace_count(trace) - 1;
    struct changes changes;
    const double *row = trace_state(trace, block);
    for (size_t k = 0; k < n || k < FOUR; k++)
        changes.max[k] = changes.sum[k] = 0;
    for (size_t i = block; i < end;) {
        size_t rows = 1;
        const double *next = i + 1 < trace->count
                                 ? trace_rows(trace, i + 1, min_size(end + 1, trace->count), &rows)
                                 : trace_state(trace, i + 1);
        changes_add(&changes, row, next, n, trace->width, 1);
        changes_add_rows(&changes, next, n, trace->width, rows);
        row = next + (rows - 1) * trace->width;
        i += rows;
    }
    for (size_t k = n; k < FOUR; k++) {
        changes.max[k % n] = fmax(changes.max[k % n], changes.max[k]);
        changes.sum[k % n] += changes.sum[k];
    }
    for (size_t k = 0; k < n; k++)
        if (changes.max[k] > most * changes.sum[k]) {
            most = changes.max[k] / changes.sum[k];
            variable = k;
        }
    double y = trace_state(trace, block)[variable];
    for (size_t i = block; i < end && most > 0; i++) {
        const double next = trace_state(trace, i + 1)[variable];
        if (fabs(next - y) == changes.max[variable])
            return i;
        y = next;
    }
    return block;
}

static bool has_dear_steps(const struct method *method)
{
    return method->flags & METHOD_IMPLICIT || method->rosenbrock;
}

bool run_picks_rows(const struct system *system, const struct method *method, double rows)
{
    return has_dear_steps(method) || system->model->typed || rows < ROWS_TO_PICK_FROM;
}

size_t run_rows_looked_max(const struct method *method, double evals, double rows, bool picks)
{
    const bool few = picks && rows > ROWS_LOOKED_MIN && !has_dear_steps(method);
    return (size_t)fmax(evals / EVALS_A_ROW, few ? ROWS_PICKED_MIN : ROWS_LOOKED_MIN);
}

/* Looks at the rows since the last call: at so few that it takes 2 % of the evaluations of a long
 * run, those of the largest changes where the run is short or its steps are dear. */
bool run_went_across(struct run *run)
{
    struct run_private *p = run->private_state;
    const size_t rows = trace_count(run->trace), first = run_own_start(run);
    if (p->looked >= rows) /* it went back */
        p->looked = p->across = p->unchecked = p->checks = 0;
    size_t i = p->looked > first ? p->looked : first, passed = rows;
    const double new_rows = (double)(rows - i), evals = (double)run->cost.evals;
    const bool picks = run_picks_rows(&run->system, run->method, new_rows);
    const size_t by = 1 + (rows - i) / run_rows_looked_max(run->method, evals, new_rows, picks);
    p->looked = rows - 1;
    for (size_t block = i; block + 1 < rows; block += by) {
        if (block % (by * LOOK_EACH) < by && cancelled(run->cancel)) {
            p->looked = block; /* the rest next time */
            return false;
        }
        i = by > 1 && picks ? largest_change(run->trace, block, by) : block;
        if ((i < p->across && i < p->unchecked && passed < rows) || !row_across(run, i))
            continue;
        if (i >= p->unchecked)
            run_check_step(run, i);
        if (i < p->across) {
            passed = i;
            continue;
        }
        p->across = 2 * i + 1; /* the next look goes as far as all before together */
        passed = rows;
        const double t = trace_time(run->trace, i + 1);
        const double beyond = t + STEPS_BEYOND * (t - trace_time(run->trace, i));
        if (ended_across(run, i, fabs(run->t - t) < fabs(beyond - t) ? run->t : beyond))
            return true;
    }
    return passed < rows && ended_across(run, passed, run->t);
}
