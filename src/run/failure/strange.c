/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps that are far too long. A method continues even where a step is nonsense: one that
 * jumps across the end of the solution, one of a Rosenbrock method next to a stiff transient, one
 * that oscillates between both sides of 0. A step that looks strange by its slopes is compared with
 * the solution from where it began. */
#include <hooke/base/cancel.h>
#include "run/private.h"

#include <math.h>

/* Returns true if a variable changes in a step of h in another way than its slopes at both ends and
 * in the middle predict. Changes that are tiny beside its natural size are ignored, because a
 * variable that begins at 0 grows by any factor. */
static bool looks_strange(double h, double y, double slope, double middle_slope, double end,
                          double end_slope, double natural)
{
    static const double deviation_max = 0.1, negligible = 1e-6;
    const double size = fmax(fabs(y), fabs(end)), mean = (slope + end_slope) / 2,
                 slopes = fmax(fmax(fabs(slope), fabs(middle_slope)), fabs(end_slope));
    if (fmax(size, fabs(h) * slopes) < negligible * natural)
        return false;
    return !(fabs(end - y - h * mean) <= deviation_max * size) ||
           !(fabs(h * (middle_slope - mean)) <= deviation_max * size);
}

/* Returns true if the step from row i to the next looks strange; false also if it is not one whole
 * step. */
static bool step_looks_strange(const struct run *run, size_t i)
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
        if (looks_strange(t_end - t, y[k], slope[k], middle_slope[k], end[k], end_slope[k],
                          run->system.scale[k]))
            return true;
    return false;
}

/* ---- comparing ---- */

/* Returns the largest magnitude of a state in natural sizes. */
static double scaled_size(const struct system *system, const double *y)
{
    double max = 0;
    for (int k = 0; k < system->n; k++)
        max = fmax(max, fabs(y[k]) / system->scale[k]);
    return max;
}

/* Sets size [n], the units in which the errors of a step over h from row i are measured: the
 * largest of the values before the step, those of `solution` after it, a small part of the natural
 * sizes and, with a drive, values somewhat later, as the drive may only have begun to move what was
 * at rest. */
static void find_sizes(const struct run *run, size_t i, double h, const double *solution,
                       double *size)
{
    static const double size_min = 0.01, tol = 1e-7; /* fraction of natural sizes */
    enum { STEPS_AHEAD = 32 };
    const struct system *system = &run->system;
    const double *y = trace_state(run->trace, i), t = trace_time(run->trace, i);
    double later[LIMIT_VARIABLES] = {0};
    for (int k = 0; k < system->n; k++)
        size[k] = fmax(fmax(fabs(y[k]), fabs(solution[k])), size_min * system->scale[k]);
    for (int ahead = 2; !system->autonomous && ahead <= STEPS_AHEAD &&
                        run_solve_cheaply(system, t, y, t + ahead * h, tol, later, run->cancel);
         ahead *= 4)
        for (int k = 0; k < system->n; k++)
            size[k] = fmax(size[k], fabs(later[k]));
}

/* Compares the step from row i to the next with the solution from there, as far as that can be
 * followed. Sets run->unsound if the error is the worst so far and no digit is left. */
static void check_step(struct run *run, size_t i)
{
    /* Values that are not followed to the end must have grown by this factor, so that oscillations
     * do not count. */
    static const double tol = 1e-7, nothing_left = 0.9, grown = 8;
    const struct trace *trace = run->trace;
    const struct system *system = &run->system;
    const double *y = trace_state(trace, i), *end = trace_state(trace, i + 1);
    const double t = trace_time(trace, i), h = trace_time(trace, i + 1) - t;
    struct followed followed;
    run_follow_cheaply(system, t, y, t + h, tol, run->cancel, &followed);
    if (followed.t != t + h &&
        !(system->autonomous && scaled_size(system, followed.y) > grown * scaled_size(system, y)))
        return;
    double size[LIMIT_VARIABLES];
    find_sizes(run, i, h, followed.y, size);
    for (int k = 0; k < system->n; k++) {
        const double value = y[k] + (followed.t - t) / h * (end[k] - y[k]),
                     times = fabs(value - followed.y[k]) / size[k];
        if (times > nothing_left && times > run->unsound.times)
            run->unsound = (struct unsound_step){.times = times,
                                                 .t = followed.t,
                                                 .value = value,
                                                 .solution = followed.y[k],
                                                 .variable = k};
    }
}

/* Returns true, and stops the run, if the solution ends in the step from row i to the next, or soon
 * after it: a method may pass the end too early, or an earlier step stand out. */
static bool ends_near(struct run *run, size_t i)
{
    static const double steps_beyond = 64;
    const double t = trace_time(run->trace, i), h = trace_time(run->trace, i + 1) - t,
                 end = fabs(steps_beyond * h) < fabs(run->t - t) ? t + steps_beyond * h : run->t;
    struct followed followed;
    run_follow_from(run, i, end, run_follow_steps((double)run->cost.evals), &followed);
    /* Past an integrable singularity in t the solution goes on; steps count those (struct cost). */
    const bool goes_on = followed.finite && !run->system.autonomous;
    return !goes_on && run_end_singular(run, &followed);
}

/* ---- choosing rows to examine ---- */

/* Finds, in at most *count steps from row `block` on, the one in which a variable changes most
 * compared with the mean of its changes. Returns the row before that step, or `block` if no change
 * exceeds times_mean times the mean. Sets *count to the number of steps examined, at least 1, whose
 * rows follow each other in memory and fill whole vectors. */
CLONES static size_t row_that_stands_out(const struct trace *trace, size_t block, size_t *count)
{
    static const double times_mean = 2; /* the largest change of a sine is 1.6 times their mean */
    const size_t end = block + *count + 1 < trace->count ? block + *count + 1 : trace->count,
                 width = trace->width;
    const double *row = trace_rows(trace, block, end, count);
    double sum[LIMIT_VARIABLES + 1] = {0}, max[LIMIT_VARIABLES + 1] = {0};
    size_t values = (*count - 1) * width, found = values;
    values -= values % (VECTOR_LANES * width);
    for (size_t p = 0; p < VECTOR_LANES * width; p += VECTOR_LANES) {
        four all = {0}, largest = {0};
        for (size_t i = p; i < values; i += VECTOR_LANES * width) {
            const four change = *(const four *)(const void *)(row + i + width) -
                                *(const four *)(const void *)(row + i),
                       size = (four)((four_bits)change & INT64_MAX);
            all += size;
            four_raise(&largest, &size);
        }
        for (size_t lane = 0; lane < VECTOR_LANES; lane++) {
            sum[(p + lane) % width] += all[lane];
            max[(p + lane) % width] = fmax(max[(p + lane) % width], largest[lane]);
        }
    }
    *count = values > 0 ? values / width : 1;
    double most = times_mean / (double)*count;
    for (size_t k = 0; k < width; k++)
        if (max[k] > most * sum[k]) {
            most = max[k] / sum[k];
            found = k;
        }
    while (found < values && fabs(row[found + width] - row[found]) < max[found % width])
        found += width;
    return block + (found < values ? found / width : 0);
}

/* Returns how many rows are examined, so that this takes a small share of the run's work. */
size_t run_rows_looked_max(const struct system *system, const struct method *method, double evals,
                           double rows, bool *picks)
{
    /* A row takes what 12 evaluations do in a step: 2 % of a long run. Picking takes longer than
     * looking at some hundred where steps are cheap and rows are many. */
    static const double evals_a_row = 600, looked_min = 512, picked_min = 128, rows_many = 30000;
    const bool dear = method->flags & METHOD_IMPLICIT || method->rosenbrock;
    *picks = dear || system->model->typed || rows < rows_many;
    const bool few = *picks && rows > looked_min && !dear;
    return (size_t)fmax(evals / evals_a_row, few ? picked_min : looked_min);
}

/* Checks steps of new rows that look strange (step_looks_strange()) against a recomputed, more
 * accurate solution: the first 64 of the run, then the 128th, 256th, …. Stops the run if the
 * solution ends in or soon after one of them (ends_near(), called for the 1st, 2nd, 4th, … and the
 * last). Looks at only one of every `stride` steps of long runs. */
void run_find_strange_steps(struct run *run)
{
    enum { LOOK_EACH = 512, CHECKS_EACH = 64 }; /* all steps are checked up to that many */
    struct run_private *p = run->private_state;
    const size_t rows = trace_count(run->trace), start = run_own_start(run);
    if (p->looked >= rows) /* the run went back */
        p->looked = p->checks = 0;
    const size_t first = p->looked > start ? p->looked : start;
    bool picks;
    const size_t max = run_rows_looked_max(&run->system, run->method, (double)run->cost.evals,
                                           (double)(rows - first), &picks),
                 stride = 1 + (rows - first) / max;
    picks &= stride >= VECTOR_LANES;
    size_t strange = rows; /* last strange step for which ends_near() was not called; else rows */
    p->looked = rows - 1;
    for (size_t block = first, count = stride; block + 1 < rows; block += count, count = stride) {
        if (block % (stride * LOOK_EACH) < stride && cancelled(run->cancel)) {
            p->looked = block; /* the next call continues there */
            return;
        }
        const size_t i = picks ? row_that_stands_out(run->trace, block, &count) : block;
        if (!step_looks_strange(run, i))
            continue;
        const bool is_seldom = (p->checks & (p->checks + 1)) == 0; /* 0, 1, 3, 7, … before */
        if (++p->checks <= CHECKS_EACH || is_seldom)
            check_step(run, i);
        if (is_seldom && ends_near(run, i))
            return;
        strange = is_seldom ? rows : i;
    }
    if (strange < rows)
        ends_near(run, strange);
}

/* Compares the first two steps of an implicit method with the solution, if they are long. */
void run_check_first_steps(struct run *run)
{
    enum { FIRST_STEPS = 2 }; /* the first one of a multistep method is another method's */
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const struct system *system = &run->system;
    if (!trace || p->checks > 0 || !system->autonomous ||
        !(run->method->flags & METHOD_IMPLICIT || run->method->rosenbrock))
        return;
    const size_t first = run_own_start(run);
    for (size_t i = first; i < first + FIRST_STEPS && i + 1 < trace_count(trace); i++) {
        const double *y = trace_state(trace, i), t = trace_time(trace, i),
                     h = trace_time(trace, i + 1) - t;
        double slope[LIMIT_VARIABLES];
        if (trace_step(trace, i + 1) != trace_step(trace, i) + 1 || run->unsound.times > 0)
            return;
        p->checks++;
        system_derivative(system, t, y, slope);
        if (!(fabs(h) * scaled_size(system, slope) < scaled_size(system, y)))
            check_step(run, i);
    }
}
