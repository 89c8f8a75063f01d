/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sensors that see nothing send one number instead: 0, -1, 400, 8190, 65535. Such a sentinel is
 * repeated exactly, far from all other values, at times that are unrelated to the motion. Flat
 * tops, in contrast, lie close to the values before and after them, a rest is one long run, and the
 * next value of a sensor with coarse steps is one step away. */
#include "modules/recording/clean/clean.h"
#include "modules/recording/table/table.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <math.h>

enum {
    ROWS_MIN = 50,     /* fewer rows are not judged */
    REPEATED_MIN = 3,  /* times that the value occurs */
    RUNS_MIN = 2,      /* runs of consecutive rows with the value */
    DIFFERENT_MIN = 5, /* different other values; two levels are a signal */
    RUN_MEAN_MAX = 20, /* [rows] longer runs are a rest */
    KINDS_MAX = 3      /* different sentinels of one sensor */
};

static const double share_max = 0.45;    /* largest share of the rows */
static const double stray_share = 0.005; /* share of the other values that may be anywhere */
/* Share of the other values, on either side, that may be another sentinel. */
static const double outer_share = 0.15;
/* Distance from the others, relative to their range: from the first on the motion may not have led
 * up to the value, from the second on it certainly has not. */
static const double distance_min = 0.25, distance_sure = 1.0;
/* The same if all neighbours are farther from the value than the motion goes in a step. */
static const double distance_jump = 0.05;
/* Quantile of the steps between others, and the factor that bounds a step of the motion. */
static const double usual_step = 0.98, jump_factor = 1.3;
/* Share of the runs with such neighbours: for a value outside of the others, for one among them,
 * and for one among them that is far more frequent than any other. */
static const double jumps_outside = 0.8, jumps_inside = 0.4, jumps_frequent = 0.2;
static const double far_more_often = 10;
/* Share of the rows below which repeats of a value among the others are harmless. */
static const double inside_share = 0.02;
/* Share of equal intervals between runs from which on the value is part of a periodic signal,
 * unless neighbours of at least this mean rank, in a motion with steps of at least this part of its
 * range, show that it leaves the range of the sensor. */
static const double regular_share = 0.9, out_of_range_rank = 0.75, out_of_range_step = 0.3;
/* Mean rank of the neighbours among the others; 1 is nearest to the value. */
static const double neighbour_rank_max = 0.75;
/* Correlation of neighbours from which on the others are a motion, and not noise of a signal with
 * levels. */
static const double motion_correlation = 0.25;

/* State of the search: the values, and the candidate that is being judged. */
struct sentinel_search {
    const double *y; /* [n] NAN for missing values */
    double *present; /* [values] existing values, ascending */
    double *sorted;  /* [others] the same without the candidate */
    double *scratch; /* [n] work space */
    size_t n, values, others;
    double value; /* the candidate */
    const struct cancel *cancel;
};

/* Returns true if row i has a value other than the candidate. */
static bool is_other(const struct sentinel_search *s, size_t i)
{
    return !isnan(s->y[i]) && s->y[i] != s->value;
}

/* Sorts the existing values. Returns false if cancelled. */
static bool sort_present(struct sentinel_search *s)
{
    s->values = 0;
    for (size_t i = 0; i < s->n; i++)
        if (!isnan(s->y[i]))
            s->present[s->values++] = s->y[i];
    return sort_values(s->present, s->values, s->scratch, s->cancel);
}

/* Fills `sorted` with the values without the candidate. Returns the number of different ones. */
static size_t leave_out_candidate(struct sentinel_search *s)
{
    size_t different = 0;
    s->others = 0;
    for (size_t i = 0; i < s->values; i++)
        if (s->present[i] != s->value) {
            s->sorted[s->others++] = s->present[i];
            different += i == 0 || s->present[i] > s->present[i - 1];
        }
    return different;
}

/* Returns true if the candidate value occurs often enough to be a sensor's mark for a missing
 * signal: in several short runs, and in a limited share of all values. Missing values are
 * ignored. */
static bool is_scattered(const struct sentinel_search *s)
{
    size_t count = 0, runs = 0;
    bool inside = false;
    for (size_t i = 0; i < s->n; i++) {
        if (isnan(s->y[i]))
            continue;
        const bool here = s->y[i] == s->value;
        count += here;
        runs += here && !inside;
        inside = here;
    }
    return count >= REPEATED_MIN && runs >= RUNS_MIN && count <= RUN_MEAN_MAX * runs &&
           (double)count <= share_max * (double)(count + s->others);
}

/* Returns true if most rows with the candidate are in runs that are too long for a sensor that sees
 * nothing now and then, as before a trigger. */
static bool is_mostly_rest(const struct sentinel_search *s)
{
    size_t count = 0, resting = 0;
    for (size_t run_begin = 0, run_end; run_begin < s->n; run_begin = run_end) {
        for (run_end = run_begin; run_end < s->n && s->y[run_end] == s->value;)
            run_end++;
        count += run_end - run_begin;
        resting += run_end - run_begin > RUN_MEAN_MAX ? run_end - run_begin : 0;
        run_end += run_end == run_begin;
    }
    return 2 * resting > count;
}

/* Returns a bound of the step of the others from row to row, or NAN if there are too few. */
static double longest_step(const struct sentinel_search *s)
{
    size_t steps = 0;
    for (size_t i = 1; i < s->n; i++)
        if (is_other(s, i) && is_other(s, i - 1))
            s->scratch[steps++] = fabs(s->y[i] - s->y[i - 1]);
    return steps < ROWS_MIN ? NAN : jump_factor * values_quantile(s->scratch, steps, usual_step);
}

/* Returns the share of the candidate's runs that the motion could only reach and leave by a jump of
 * more than `longest`. If a signal is cut off, in contrast, neighbouring values approach the
 * limit. */
static double jump_share(const struct sentinel_search *s, double longest)
{
    double jumps = 0, runs = 0;
    for (size_t run_begin = 0, run_end; run_begin < s->n; run_begin = run_end) {
        for (run_end = run_begin; run_end < s->n && s->y[run_end] == s->value;)
            run_end++;
        const bool has_previous = run_begin > 0 && is_other(s, run_begin - 1),
                   has_next = run_end < s->n && is_other(s, run_end);
        if (run_end > run_begin && (has_previous || has_next)) {
            jumps += (!has_previous || fabs(s->y[run_begin - 1] - s->value) > longest) &&
                     (!has_next || fabs(s->y[run_end] - s->value) > longest);
            runs++;
        }
        run_end += run_end == run_begin;
    }
    return runs > 0 ? jumps / runs : 0;
}

/* Returns the mean rank, 0 to 1, of the values before and after runs of the candidate; 1 is nearest
 * to it. is_upper tells that the candidate is above the others. */
static double neighbour_rank(const struct sentinel_search *s, bool is_upper)
{
    double sum = 0, count = 0;
    for (size_t i = 0; i < s->n; i++) {
        const bool is_neighbour = is_other(s, i) && ((i > 0 && s->y[i - 1] == s->value) ||
                                                     (i + 1 < s->n && s->y[i + 1] == s->value));
        if (!is_neighbour)
            continue;
        const double lower_count = (double)first_from(s->sorted, s->others, s->y[i]);
        sum += lower_count / (double)s->others;
        count++;
    }
    const double mean = count > 0 ? sum / count : 1;
    return is_upper ? mean : 1 - mean;
}

/* Returns true if the samples other than the suspected sentinel value are correlated with their
 * neighbours, one or two rows away, and so belong to a motion. Extreme values are limited, so that
 * a second sentinel does not hide the correlation. */
static bool others_are_motion(const struct sentinel_search *s)
{
    const size_t outer = (size_t)(outer_share * (double)s->others);
    const double low = s->sorted[outer], high = s->sorted[s->others - 1 - outer];
    double mean = 0, square = 0, product[2] = {0, 0}, pairs[2] = {0, 0};
    for (size_t i = 0; i < s->others; i++)
        mean += fmin(fmax(s->sorted[i], low), high) / (double)s->others;
    for (size_t i = 0; i < s->n; i++) {
        if (!is_other(s, i))
            continue;
        const double y = fmin(fmax(s->y[i], low), high) - mean;
        square += y * y / (double)s->others;
        for (size_t k = 0; k < 2; k++)
            if (i > k && is_other(s, i - k - 1)) {
                product[k] += y * (fmin(fmax(s->y[i - k - 1], low), high) - mean);
                pairs[k]++;
            }
    }
    for (size_t k = 0; k < 2; k++)
        if (pairs[k] > 0 && fabs(product[k] / pairs[k]) > motion_correlation * square)
            return true;
    return false;
}

/* Returns true if nearly all runs of the candidate begin at equal distances, up to a row. */
static bool is_regular(const struct sentinel_search *s)
{
    size_t runs = 0, last = 0, alike = 0, previous = s->n;
    for (size_t i = 0; i < s->n; previous = i++) {
        if (s->y[i] != s->value || (previous < s->n && s->y[previous] == s->value))
            continue;
        if (runs > 0)
            s->scratch[runs - 1] = (double)(i - last);
        last = i;
        runs++;
    }
    if (runs < REPEATED_MIN)
        return false;
    const double median = values_quantile(s->scratch, runs - 1, 0.5);
    for (size_t k = 0; k + 1 < runs; k++)
        alike += fabs(s->scratch[k] - median) <= 1;
    return (double)alike >= regular_share * (double)(runs - 1);
}

/* Returns the number of occurrences of the most frequent of the others, and sets *value to it. */
static size_t most_frequent(const struct sentinel_search *s, double *value)
{
    size_t longest = 0;
    for (size_t run_begin = 0, run_end; run_begin < s->others; run_begin = run_end) {
        for (run_end = run_begin + 1;
             run_end < s->others && s->sorted[run_end] == s->sorted[run_begin];)
            run_end++;
        if (run_end - run_begin > longest) {
            longest = run_end - run_begin;
            *value = s->sorted[run_begin];
        }
    }
    return longest;
}

/* Judges a candidate among the others, or so close that noise may carry them there. jumps is its
 * jump_share(). */
static bool is_sentinel_inside(struct sentinel_search *s, double jumps)
{
    double next;
    size_t count = 0;
    for (size_t i = 0; i < s->n; i++)
        count += s->y[i] == s->value;
    const bool frequent = (double)count > far_more_often * (double)most_frequent(s, &next);
    return (double)count >= inside_share * (double)(count + s->others) &&
           jumps > (frequent ? jumps_frequent : jumps_inside) && !is_regular(s);
}

/* Returns true if the candidate is a sentinel. */
static bool is_sentinel(struct sentinel_search *s)
{
    if (leave_out_candidate(s) < DIFFERENT_MIN || !is_scattered(s) || !others_are_motion(s))
        return false;
    const size_t strays = (size_t)(stray_share * (double)s->others);
    const double high = s->sorted[s->others - 1 - strays], low = s->sorted[strays];
    const bool is_upper = s->value > high;
    const double distance = is_upper ? s->value - high : low - s->value, range = high - low,
                 longest = longest_step(s), jumps = jump_share(s, longest);
    if (distance <= distance_sure * range && is_mostly_rest(s))
        return false;
    if (distance <= distance_jump * range)
        return is_sentinel_inside(s, jumps);
    const double rank = neighbour_rank(s, is_upper);
    if (is_regular(s) && (rank < out_of_range_rank || longest > out_of_range_step * range))
        return false;
    return distance > distance_sure * range || jumps > jumps_outside ||
           (distance > distance_min * range && rank < neighbour_rank_max) ||
           is_sentinel_inside(s, jumps);
}

/* Searches a sentinel among the extremes and the most frequent of the other values. Returns false
 * if there is none; else it is the candidate in *s. */
static bool find_sentinel(struct sentinel_search *s)
{
    s->value = NAN;
    if (!sort_present(s) || leave_out_candidate(s) < DIFFERENT_MIN || s->others < ROWS_MIN)
        return false;
    double candidate[3] = {s->sorted[0], s->sorted[s->others - 1], NAN};
    most_frequent(s, &candidate[2]);
    for (size_t k = 0; k < COUNT_OF(candidate); k++) {
        s->value = candidate[k];
        if (is_sentinel(s))
            return true;
    }
    return false;
}

/* Removes up to KINDS_MAX sentinels (values that a sensor reports without a signal), one after the
 * other, by making them missing, with a warning each. Returns false if out of memory. */
bool recording_leave_out_sentinels(struct recording *recording)
{
    const struct column *column = &recording->column[recording->value];
    const size_t n = recording->rows;
    struct arena scratch = {0};
    struct sentinel_search s = {.y = recording->y,
                                .present = arena_array(&scratch, n + 1, sizeof(double)),
                                .sorted = arena_array(&scratch, n + 1, sizeof(double)),
                                .scratch = arena_array(&scratch, n + 1, sizeof(double)),
                                .n = n,
                                .cancel = recording->cancel};
    const bool memory = s.present && s.sorted && s.scratch;
    for (int kind = 0; kind < KINDS_MAX && memory && find_sentinel(&s); kind++) {
        size_t count = 0;
        double shown = NAN;
        for (size_t i = 0; i < n; i++)
            if (recording->y[i] == s.value) {
                shown = column->value[i];
                recording->y[i] = NAN;
                count++;
            }
        recording_warn(recording,
                       "%s: %zu of %zu values are left out: they are exactly %.6g%s%s, far from "
                       "the motion, as a sensor without a signal reports",
                       column->name, count, n, shown, column->unit[0] ? " " : "", column->unit);
    }
    arena_reset(&scratch);
    return memory;
}
