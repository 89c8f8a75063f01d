/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the turning points of a curve, and from these its crossings, its period and the change of
 * its amplitude. */
#include "modules/words/internal.h"

#include <hooke/base/numeric.h>

#include <string.h>

/* A movement below this fraction of the one before is not a turning point. */
#define TURN_MIN 0.05
/* Largest deviation of a regular period from the median, as a fraction of it. */
#define PERIOD_DEVIATION_MAX 0.25
#define PERIOD_DEVIATION_SIGMAS 5.0 /* the same in robust standard deviations */
#define REGULAR_SHARE_MIN 0.75      /* fraction of periods that have to be regular */
/* Least fraction of the time that crossings have to span; less is a spike or a transient. */
#define CROSSINGS_SHARE_MIN 0.4
#define LINE_DEVIATION_MAX 0.05 /* largest deviation of a logarithm from its line */
/* Largest deviation of the change by the fitted slope from the change of the ends, as a fraction of
 * it. */
#define END_DEVIATION_MAX 0.25
/* Largest movement of the middle between turning points, as a fraction of the swing. */
#define MIDDLE_JUMP_MAX 0.1
/* An interval without samples that is longer, in half periods, leaves turning points and crossings
 * unknown. */
#define HOLE_HALF_PERIODS 0.5

/* A turning point. */
struct turn {
    double x, y;
    size_t index; /* index of the point */
};

/* Returns the vertex of the parabola through point i and its neighbours, or the point itself if it
 * is noisy or at an end. */
static struct turn refined_turn(const struct points *p, size_t i)
{
    const struct turn plain = {p->x[i], p->y[i], i};
    if (i == 0 || i + 1 >= p->n || p->noise > 0)
        return plain;
    const double a = p->x[i - 1] - plain.x, b = p->x[i + 1] - plain.x;
    const double fa = (p->y[i - 1] - plain.y) / a, fb = (p->y[i + 1] - plain.y) / b;
    const double curvature = (fb - fa) / (b - a), slope = fa - curvature * a;
    const double dx = -slope / (2 * curvature);
    if (!(dx >= a && dx <= b))
        return plain;
    return (struct turn){plain.x + dx, plain.y + dx * (slope + curvature * dx), i};
}

/* Finds turning points: extremes from which the curve goes back by more than `least`, and by more
 * than TURN_MIN of the larger of the present and the previous rise or fall (`swing`). Returns their
 * number; `turn` receives them unless it is NULL. `way` is 1 while the curve rises, -1 while it
 * falls, 0 before the first turn. */
static size_t find_turns(const struct points *p, double least, struct turn *turn)
{
    size_t count = 0, high = 0, low = 0;
    int way = 0;
    double swing = 0;
    for (size_t i = 1; points_go_on(p, i); i++) {
        const double y = p->y[i];
        high = y > p->y[high] ? i : high;
        low = y < p->y[low] ? i : low;
        const double now = p->y[high] - p->y[low], back = fmax(least, TURN_MIN * fmax(swing, now));
        const bool falls = way >= 0 && p->y[high] - y > back,
                   rises = way <= 0 && y - p->y[low] > back;
        if (!falls && !rises)
            continue;
        const size_t row = falls ? high : low;
        if (way != 0 || fabs(p->y[row] - p->y[0]) > back) {
            if (turn)
                turn[count] = refined_turn(p, row);
            count++;
        }
        swing = now;
        way = falls ? -1 : 1;
        high = low = i;
    }
    return count;
}

/* Returns the middle around turning point i, a mean of it and its neighbours that has the same
 * place in each period of a growing or decaying motion. */
static double turn_middle(const struct turn *turn, size_t count, size_t i)
{
    if (count < 3)
        return 0.5 * (turn[0].y + turn[count - 1].y);
    if (i < 1)
        i = 1;
    else
        i = i + 2 > count ? count - 2 : i;
    return 0.25 * (turn[i - 1].y + 2 * turn[i].y + turn[i + 1].y);
}

/* Returns true if the middle rarely jumps, as it does for a motion between two wells. */
static bool keeps_middle(const struct turn *turn, size_t count)
{
    size_t jumps = 0;
    for (size_t i = 0; i + 1 < count; i++)
        jumps += fabs(turn_middle(turn, count, i + 1) - turn_middle(turn, count, i)) >
                 MIDDLE_JUMP_MAX * fabs(turn[i + 1].y - turn[i].y);
    return (double)jumps <= (1 - REGULAR_SHARE_MIN) * (double)count;
}

/* Returns the x between points search_first and search_last where the curve crosses the level, or
 * NAN if it ends on the side on which it began. Noise crosses several times: the result is the mean
 * of the first and the last crossing. */
static double find_crossing(const struct points *p, size_t search_first, size_t search_last,
                            double level)
{
    size_t first = 0, last = 0;
    for (size_t i = search_first + 1; i <= search_last; i++)
        if ((p->y[i] >= level) != (p->y[i - 1] >= level)) {
            first = first ? first : i;
            last = i;
        }
    if (first == 0 || (p->y[first - 1] >= level) == (p->y[last] >= level))
        return NAN;
    double sum = 0;
    for (int end = 0; end < 2; end++) {
        const struct curve_point a = point_at(p, (end ? last : first) - 1);
        const struct curve_point b = point_at(p, end ? last : first);
        sum += 0.5 * (a.x + (b.x - a.x) * (level - a.y) / (b.y - a.y));
    }
    return sum;
}

/* Returns true if two neighbouring samples around or between x_begin and x_end are farther apart
 * than `least`. Both limits can be equal. */
static bool has_hole(const struct points *p, double x_begin, double x_end, double least)
{
    size_t low = 0, high = p->n;
    if (!(least < HUGE_VAL))
        return false;
    while (high - low > 1) {
        const size_t i = low + (high - low) / 2;
        *(p->x[i] <= x_begin ? &low : &high) = i;
    }
    for (size_t i = low + 1; i < p->n && p->x[i - 1] < x_end; i++)
        if (p->x[i] - p->x[i - 1] > least)
            return true;
    return false;
}

/* Finds the longest gap between measured samples and stores its ends in reading->hole. Sets *least
 * to the length above which turning points and crossings in a gap are unknown: HOLE_HALF_PERIODS
 * times the median distance of crossings, or HUGE_VAL if there are too few. Returns false if out of
 * memory. */
static bool find_holes(const struct points *p, const double *x_crossing, size_t crossings,
                       struct arena *arena, double *least, struct curve_reading *reading)
{
    double *apart = arena_array(arena, crossings + 1, sizeof *apart), longest = 0;
    *least = HUGE_VAL;
    if (!apart || !p->measured || crossings < 3)
        return apart;
    for (size_t i = 0; i + 1 < crossings; i++)
        apart[i] = x_crossing[i + 1] - x_crossing[i];
    *least = HOLE_HALF_PERIODS * values_quantile(apart, crossings - 1, 0.5);
    for (size_t i = 1; i < p->n; i++)
        if (p->x[i] - p->x[i - 1] > fmax(*least, longest)) {
            longest = p->x[i] - p->x[i - 1];
            reading->hole[0] = p->x[i - 1];
            reading->hole[1] = p->x[i];
        }
    return true;
}

/* Sets reading->period, periods and spread from the crossings x_crossing [crossings] in ascending
 * order, of which every second has the same direction, if most intervals are equal; otherwise
 * leaves them unchanged. Intervals with a hole in the data longer than `least` are not counted.
 * Returns false if out of memory. */
static bool read_period(const struct points *p, const double *x_crossing, size_t crossings,
                        double least, struct arena *arena, struct curve_reading *reading)
{
    const size_t most = crossings < 3 ? 0 : crossings - 2;
    const double extent = p->x[p->n - 1] - p->x[0];
    double *length = arena_array(arena, most + 1, sizeof *length),
           *deviation = arena_array(arena, most + 1, sizeof *deviation), sum = 0, square = 0;
    size_t used = 0, count = 0;
    if (!length || !deviation)
        return false;
    for (size_t i = 0; i < most; i++)
        if (!has_hole(p, x_crossing[i], x_crossing[i + 2], least))
            length[count++] = x_crossing[i + 2] - x_crossing[i];
    if (count == 0)
        return true;
    const double median = values_quantile(length, count, 0.5);
    for (size_t i = 0; i < count; i++)
        deviation[i] = fabs(length[i] - median);
    const double sigma = MAD_TO_SIGMA * values_quantile(deviation, count, 0.5),
                 far = fmin(PERIOD_DEVIATION_MAX * median,
                            fmax(PERIOD_DEVIATION_SIGMAS * sigma, TURN_ROUNDING * median));
    for (size_t i = 0; i < count; i++)
        if (fabs(length[i] - median) <= far) {
            sum += length[i];
            used++;
        }
    if (used == 0 || (double)used < REGULAR_SHARE_MIN * (double)count ||
        x_crossing[crossings - 1] - x_crossing[0] < CROSSINGS_SHARE_MIN * extent)
        return true;
    reading->period = sum / (double)used;
    reading->periods = (used + 1) / 2;
    for (size_t i = 0; i < count; i++)
        if (fabs(length[i] - median) <= far)
            square += (length[i] - reading->period) * (length[i] - reading->period);
    reading->spread = used > 1 ? sqrt(square / (double)(used - 1)) : NAN;
    return true;
}

/* Returns true if no samples are missing between two successive turning points and beside them. */
static bool is_whole(const struct points *p, const struct turn *turn, double least)
{
    const size_t first = turn[0].index, last = turn[1].index;
    const double x_begin = p->x[first ? first - 1 : 0];
    const double x_end = p->x[last + 1 < p->n ? last + 1 : last];
    return !has_hole(p, x_begin, x_end, least);
}

/* Sets the first and the last amplitude and level, and the growth rate of the amplitude if its
 * logarithm is a line over x (least squares). Pairs of turning points with a gap longer than
 * `least` between them are left out. */
static void read_amplitudes(const struct points *p, const struct turn *turn, size_t count,
                            double least, struct curve_reading *reading)
{
    const size_t swings = count - 1;
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, far = 0;
    for (size_t i = 0; i < swings; i++) {
        const double amplitude = 0.5 * fabs(turn[i + 1].y - turn[i].y),
                     x = 0.5 * (turn[i].x + turn[i + 1].x) - turn[0].x;
        if (!is_whole(p, &turn[i], least))
            continue;
        if (isnan(reading->amplitude[0]))
            reading->amplitude[0] = amplitude;
        reading->amplitude[1] = amplitude;
        n++;
        sx += x;
        sy += log(amplitude);
        sxx += x * x;
        sxy += x * log(amplitude);
    }
    reading->level[0] = turn_middle(turn, count, 0);
    reading->level[1] = turn_middle(turn, count, count - 1);
    if (n < 2)
        return;
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx),
                 intercept = (sy - slope * sx) / n;
    for (size_t i = 0; i < swings; i++) {
        const double x = 0.5 * (turn[i].x + turn[i + 1].x) - turn[0].x;
        if (is_whole(p, &turn[i], least))
            far =
                fmax(far, fabs(log(0.5 * fabs(turn[i + 1].y - turn[i].y)) - intercept - slope * x));
    }
    /* the line must also agree with the amplitudes at both ends */
    const double change = log(reading->amplitude[1] / reading->amplitude[0]),
                 told = slope * (0.5 * (turn[count - 2].x + turn[count - 1].x) -
                                 0.5 * (turn[0].x + turn[1].x));
    if (far < LINE_DEVIATION_MAX && fabs(told - change) < END_DEVIATION_MAX * fabs(change))
        reading->growth = slope;
}

/* Counts the turning points of a curve and, if `timed` (x is time), finds its crossings of the
 * middle between them, its period and amplitudes. Returns false if out of memory. */
bool read_turns(const struct points *points, bool timed, struct arena *arena,
                struct curve_reading *reading)
{
    const double least =
        fmax(TURN_SIGMAS * points->noise, TURN_ROUNDING * (reading->high.y - reading->low.y));
    size_t count = find_turns(points, least, NULL);
    struct turn *turn = arena_array(arena, count + 1, sizeof *turn);
    double *x_crossing = arena_array(arena, count + 2, sizeof *x_crossing);
    size_t crossings = 0;
    if (!turn || !x_crossing)
        return false;
    find_turns(points, least, turn);
    /* a ripple at the start is known as such only by the larger swings that follow */
    while (count > 2 && fabs(turn[1].y - turn[0].y) < TURN_MIN * fabs(turn[2].y - turn[1].y)) {
        memmove(turn, turn + 1, (count - 1) * sizeof *turn);
        count--;
    }
    reading->turns = count;
    if (count < 2 || !timed)
        return true;
    for (size_t i = 0; i <= count; i++) {
        const size_t first = i ? turn[i - 1].index : 0;
        const size_t last = i < count ? turn[i].index : points->n - 1;
        double level;
        if (i == 0)
            level = turn_middle(turn, count, 0);
        else
            level = i == count
                        ? turn_middle(turn, count, count - 1)
                        : 0.5 * (turn_middle(turn, count, i - 1) + turn_middle(turn, count, i));
        const double x = find_crossing(points, first, last, level);
        if (isfinite(x))
            x_crossing[crossings++] = x;
    }
    double hole;
    if (!find_holes(points, x_crossing, crossings, arena, &hole, reading))
        return false;
    for (size_t i = 0; i < crossings; i++)
        reading->crossings += !has_hole(points, x_crossing[i], x_crossing[i], hole);
    read_amplitudes(points, turn, count, hole, reading);
    return !keeps_middle(turn, count) ||
           read_period(points, x_crossing, crossings, hole, arena, reading);
}
