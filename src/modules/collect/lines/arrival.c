/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes when samples were taken from the arrivals of their lines. A device that sends at an even
 * rate is heard late, and in bursts where USB packs its lines: the samples lie on a straight line
 * below the arrivals. Its slope is the median of slopes between distant lines (Theil 1950, Sen
 * 1968), then least squares; lost lines are steps of the smallest delays by whole intervals. */
#include "modules/collect/lines.h"

#include <hooke/base/numeric.h>

#include <math.h>
#include <string.h>

enum {
    APART_MAX = 4096,  /* lines between the ends of a slope */
    SLOPES_MAX = 4096, /* slopes that the median is of */
    /* lines in a block, of which at least one is assumed to arrive without delay */
    BLOCK = 32,
    AHEAD = 16,     /* blocks within which a delay must have ended */
    BLOCKS_MIN = 8, /* least number of blocks in which steps are looked for */
    PASSES = 3      /* passes over the line and the steps */
};
#define STEP_MIN 0.7  /* [interval] least step of the delays that is a lost line */
#define AT_ONCE 0.1   /* [interval] between lines of one packet */
#define STEP_SIGMAS 8 /* steps must exceed the usual differences by this factor */
/* A line that is later by this many robust standard deviations was delayed. */
#define LATE_LINE_SIGMAS 6
#define ARRIVAL_ROUNDING_SECONDS 1e-9 /* [s] of rounding */
/* If means of blocks scatter by more than this fraction of the scatter of single lines, no straight
 * line describes the arrivals. */
#define BLOCK_SCATTER_MAX 0.5

/* Straight line of arrivals: line number x arrives at intercept + interval x [s]. */
struct arrival_line {
    double intercept, interval;
};

/* Returns the median of the slopes [s per line] between lines that are far apart. place [n] holds
 * the number of each line, lost lines included. */
static double median_slope(const struct arrivals *a, const double *place, double *scratch)
{
    const size_t apart = a->n / 4 < APART_MAX ? a->n / 4 + 1 : APART_MAX, count = a->n - apart,
                 stride = count / SLOPES_MAX + 1;
    size_t n = 0;
    for (size_t i = 0; i < count; i += stride)
        scratch[n++] = (a->arrival[i + apart] - a->arrival[i]) / (place[i + apart] - place[i]);
    return values_quantile(scratch, n, 0.5);
}

/* Returns by how much [s] line i arrives after the straight line. */
static double line_delay(const struct arrivals *a, const double *place, struct arrival_line line,
                         size_t i)
{
    return a->arrival[i] - line.intercept - line.interval * place[i];
}

/* Fits a line by least squares through the arrivals within `limit` [s] of the given line. */
static void least_squares(const struct arrivals *a, const double *place, double limit,
                          struct arrival_line *line)
{
    double x = 0, y = 0, xx = 0, xy = 0, n = 0;
    for (size_t i = 0; i < a->n; i++)
        if (fabs(line_delay(a, place, *line, i)) <= limit) {
            n++;
            x += (place[i] - x) / n;
            y += (a->arrival[i] - y) / n;
        }
    for (size_t i = 0; i < a->n; i++)
        if (fabs(line_delay(a, place, *line, i)) <= limit) {
            xx += (place[i] - x) * (place[i] - x);
            xy += (place[i] - x) * (a->arrival[i] - y);
        }
    line->interval = xx > 0 ? xy / xx : NAN;
    line->intercept = y - line->interval * x;
}

/* Returns the number of lines in a block, smaller if there are few lines. */
static size_t block_size(const struct arrivals *a)
{
    const size_t most = a->n / (2 * BLOCKS_MIN);
    if (most > BLOCK)
        return BLOCK;
    return most > 0 ? most : 1;
}

/* Returns the smallest delay [s] in a block. */
static double smallest_delay(const struct arrivals *a, const double *place,
                             struct arrival_line line, size_t block)
{
    double least = HUGE_VAL;
    const size_t each = block_size(a);
    for (size_t i = block * each; i < (block + 1) * each && i < a->n; i++)
        least = fmin(least, line_delay(a, place, line, i));
    return least;
}

/* Returns true if lines arrive in groups. Then the smallest of their delays may change by one
 * interval. */
static bool arrive_in_groups(const struct arrivals *a, struct arrival_line line)
{
    size_t at_once = 0;
    for (size_t i = 1; i < a->n; i++)
        at_once += a->arrival[i] - a->arrival[i - 1] < AT_ONCE * line.interval;
    return 2 * at_once > a->n;
}

/* Returns true if the collection was paused at this line or a neighbour. */
static bool is_near_pause(const struct arrivals *a, size_t line)
{
    return a->pause && (a->pause[line] || (line > 0 && a->pause[line - 1]) ||
                        (line + 1 < a->n && a->pause[line + 1]));
}

/* Finds lost lines from the arrival times: where the smallest delay per block of lines rises by
 * whole intervals and stays there. place [n] is in and out: the number of each line in a complete
 * sequence, which is raised behind each loss. scratch [n] is work space. Adds losses that are not
 * due to pauses to *lost. Returns the total number of lost lines, those in pauses included. */
static size_t find_lost(const struct arrivals *a, struct arrival_line line, double *place,
                        double *scratch, size_t *lost)
{
    const size_t each = block_size(a), blocks = a->n / each;
    size_t moved = 0, n = 0;
    if (a->counted || blocks < BLOCKS_MIN)
        return 0;
    for (size_t k = 1; k < blocks; k++)
        scratch[n++] =
            fabs(smallest_delay(a, place, line, k) - smallest_delay(a, place, line, k - 1));
    const double least = arrive_in_groups(a, line) ? 1 + STEP_MIN : STEP_MIN;
    const double usual = STEP_SIGMAS * MAD_TO_SIGMA * values_quantile(scratch, n, 0.5);
    double previous = smallest_delay(a, place, line, 0), lost_time = 0;
    memset(scratch, 0, each * sizeof *scratch);
    for (size_t k = 1; k < blocks; k++) {
        const double now = smallest_delay(a, place, line, k) - lost_time, step = now - previous;
        const bool steps = step > usual && step > least * line.interval;
        /* smallest rise in the blocks that follow: lines that were only delayed arrive in time
         * again */
        double remaining_rise = k + 1 < blocks || !steps ? HUGE_VAL : step;
        for (size_t j = k + 1; steps && j < blocks && j <= k + AHEAD; j++)
            remaining_rise =
                fmin(remaining_rise, smallest_delay(a, place, line, j) - lost_time - previous);
        const double whole = nearbyint(remaining_rise / line.interval);
        if (!steps || whole < 1) {
            previous = steps ? previous : fmin(now, previous + usual);
            for (size_t i = k * each; i < (k + 1) * each; i++)
                scratch[i] = lost_time / line.interval;
            continue;
        }
        size_t first = k * each;
        /* the step begins after the last line that came without delay */
        const double half = previous + lost_time + 0.5 * whole * line.interval;
        while (line_delay(a, place, line, first) < half && first + 1 < (k + 1) * each)
            first++;
        while (first > (k - 1) * each && line_delay(a, place, line, first - 1) > half)
            first--;
        lost_time += whole * line.interval;
        moved += (size_t)whole;
        *lost += is_near_pause(a, first) ? 0 : (size_t)whole;
        for (size_t i = k * each; i < first; i++)
            scratch[i] = lost_time / line.interval - whole;
        for (size_t i = first; i < (k + 1) * each; i++)
            scratch[i] = lost_time / line.interval;
    }
    for (size_t i = 0; i < a->n; i++)
        place[i] += nearbyint(scratch[i < blocks * each ? i : blocks * each - 1]);
    return moved;
}

/* Returns the robust standard deviation [s] of the delays, or of means of `each` successive ones.
 */
static double delay_scatter(const struct arrivals *a, const double *place, struct arrival_line line,
                            size_t each, double *scratch)
{
    size_t n = 0;
    for (size_t i = 0; i + each <= a->n; i += each) {
        double mean = 0;
        for (size_t k = i; k < i + each; k++)
            mean += line_delay(a, place, line, k) / (double)each;
        scratch[n++] = mean;
    }
    const double middle = values_quantile(scratch, n, 0.5);
    for (size_t i = 0; i < n; i++)
        scratch[i] = fabs(scratch[i] - middle);
    return MAD_TO_SIGMA * values_quantile(scratch, n, 0.5);
}

/* Computes the times of samples: a straight line through the arrivals if one describes them, else
 * the arrivals themselves. */
bool arrival_times(const struct arrivals *a, struct arena *arena, struct collected *collected,
                   double *t)
{
    const size_t n = a->n;
    double *place = arena_array(arena, n + 1, sizeof *place),
           *scratch = arena_array(arena, n + SLOPES_MAX + 1, sizeof *scratch);
    collected->clock = CLOCK_UNEVEN;
    collected->rate = (struct measured){NAN, NAN};
    if (!place || !scratch)
        return false;
    memcpy(t, a->arrival, n * sizeof *t);
    if (n < 3)
        return true;
    memcpy(place, a->order, n * sizeof *place);
    struct arrival_line line = {a->arrival[0], median_slope(a, place, scratch)};
    if (!a->counted)
        collected->lost = 0;
    /* Lost lines change the slope, and the slope decides which lines are lost. */
    for (int pass = 0; pass < PASSES && line.interval > 0; pass++) {
        const size_t more = find_lost(a, line, place, scratch, &collected->lost);
        line.interval = median_slope(a, place, scratch);
        if (more == 0)
            break;
    }
    for (size_t i = 0; i < n; i++)
        scratch[i] = line_delay(a, place, line, i);
    line.intercept += values_quantile(scratch, n, 0.5);
    least_squares(a, place,
                  LATE_LINE_SIGMAS * delay_scatter(a, place, line, 1, scratch) +
                      ARRIVAL_ROUNDING_SECONDS,
                  &line);
    if (!(line.interval > 0))
        return true;
    const size_t each = n / (4 * BLOCKS_MIN) > 0 ? n / (4 * BLOCKS_MIN) : 1, blocks = n / each;
    collected->jitter = delay_scatter(a, place, line, 1, scratch);
    const double means = delay_scatter(a, place, line, each, scratch);
    for (size_t i = 0; i < n; i++)
        collected->largest = fmax(collected->largest, fabs(line_delay(a, place, line, i)));
    if (each > 1 && means > BLOCK_SCATTER_MAX * collected->jitter &&
        collected->jitter > 0.5 * line.interval) {
        collected->lost = a->counted ? collected->lost : 0;
        return true;
    }
    collected->clock = CLOCK_ARRIVAL;
    collected->lost_known |= n >= 2 * BLOCKS_MIN && !arrive_in_groups(a, line);
    const double spread = fmax(means, collected->jitter / sqrt((double)each)),
                 of_interval = spread * sqrt(12 / (double)blocks) / (place[n - 1] - place[0]);
    collected->rate =
        (struct measured){1 / line.interval, of_interval / (line.interval * line.interval)};
    for (size_t i = 0; i < n; i++)
        t[i] = line.intercept + line.interval * place[i];
    return true;
}
