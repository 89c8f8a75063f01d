/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period of a smooth series without noise, such as a run with fixed steps, in one pass over its
 * rows. All crossings of the centre of a damped or growing oscillation are half a period apart. A
 * level that is off by d shifts each crossing by d over the slope there, so that least squares
 * finds the centre together with the period. */
#include "modules/recording/period/cycle.h"

#include <float.h>
#include <math.h>

enum {
    /* Fewer rows are left to other methods. */
    ROWS_MIN = 64,
    PLACES = 512,      /* positions at which the noise is measured */
    CROSSINGS_MIN = 6, /* fewer do not show that they are equally spaced */
    CENTRE_PASSES = 6, /* Newton's method for the centre */
    INTERPOLATED = 6,  /* samples of the polynomial at a crossing */
    ROOT_PASSES = 4,   /* Newton's method for a crossing */
};

/* Steps between rows must be even to this part of a step. */
static const double even_tolerance = 1e-9;
/* Noise relative to the amplitude up to which interpolation is better than averaging. */
static const double noise_max = 1e-6;
/* Lobes (the parts between crossings) smaller than this share of the largest one are left out; if
 * the motion dies out within a few cycles, only those smaller than the second share. */
static const double lobe_min = 0.05, lobe_min_damped = 1e-6;
/* No crossing may be farther off the line than this part of the period. */
static const double off_line_max = 1e-6;
/* Largest change of the differences of ln(height) between lobes, as rows miss the tops; with more,
 * the wave repeats only after several of these periods. */
static const double height_uneven_max = 0.02;
/* Smallest number of rows of a lobe. */
static const size_t lobe_rows_min = 10;

/* A crossing of the level. */
struct smooth_crossing {
    size_t row;   /* first row beyond the level */
    double place; /* [rows] interpolated position */
    double slope; /* [y per row] */
};

/* The series, its level and the crossings found so far. */
struct smooth_wave {
    const double *y;
    size_t n;
    double low, high, level;
    struct smooth_crossing *crossing; /* [count] */
    double *height; /* [count] ln of the largest distance from the level after each */
    size_t count, capacity;
};

/* Returns true if all times lie on the even grid with step dt. */
static bool is_even(const struct series *s, double dt)
{
    const double tolerance = even_tolerance * dt + 4e-16 * fabs(s->t[s->n - 1]);
    double deviation_max = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double here = fabs(s->t[i] - (s->t[0] + (double)i * dt));
        deviation_max = here > deviation_max ? here : deviation_max;
    }
    return deviation_max <= tolerance;
}

/* Sets the extremes. Returns false if a value is not finite or if all are equal. */
static bool find_extremes(struct smooth_wave *w)
{
    double low = w->y[0], high = low, sum = 0;
    for (size_t i = 0; i < w->n; i++) {
        const double y = w->y[i];
        low = y < low ? y : low;
        high = y > high ? y : high;
        sum += y - y; /* not 0 where y is not finite */
    }
    w->low = low;
    w->high = high;
    return sum == 0 && high > low;
}

/* Returns the noise: the median size of sixth differences at positions all along the series, as
 * samples_noise(). */
static double noise_at_places(const struct smooth_wave *w)
{
    double size[PLACES];
    const size_t last = w->n - 7, places = last < PLACES ? last : PLACES;
    for (size_t k = 0; k < places; k++) {
        const double *y = w->y + last * k / places;
        size[k] = fabs((y[0] + y[6]) - 6 * (y[1] + y[5]) + 15 * (y[2] + y[4]) - 20 * y[3]);
    }
    return MAD_TO_SIGMA * values_quantile(size, places, 0.5) / sqrt(924.0);
}

/* Returns the root, near x, of the quintic through the six values d at 0 to 5 (Newton's form), and
 * sets its slope there. d is overwritten. */
static double quintic_root(double d[INTERPOLATED], double x, double *slope)
{
    for (int k = 1; k < INTERPOLATED; k++)
        for (int i = INTERPOLATED - 1; i >= k; i--)
            d[i] = (d[i] - d[i - 1]) / k;
    for (int pass = 0; pass < ROOT_PASSES; pass++) {
        double value = d[INTERPOLATED - 1];
        *slope = 0;
        for (int i = INTERPOLATED - 2; i >= 0; i--) {
            *slope = *slope * (x - i) + value;
            value = value * (x - i) + d[i];
        }
        x -= value / *slope;
    }
    return x;
}

/* Places a crossing by the six rows around it, taken every `step` rows. Returns false if the root
 * is not near it. */
static bool place_crossing(const struct smooth_wave *w, size_t step, struct smooth_crossing *c)
{
    const size_t half = INTERPOLATED / 2 * step, previous = c->row - 1,
                 last = w->n - 1 - (INTERPOLATED - 1) * step;
    const size_t window_begin = previous + step < half ? 0 : previous + step - half;
    const size_t first = window_begin < last ? window_begin : last;
    double d[INTERPOLATED];
    for (size_t i = 0; i < INTERPOLATED; i++)
        d[i] = w->y[first + i * step] - w->level;
    const double y_next = w->y[c->row] - w->level, y_previous = w->y[previous] - w->level,
                 part = y_previous / (y_previous - y_next);
    const double begin = (double)previous - (double)first,
                 x = quintic_root(d, (begin + part) / (double)step, &c->slope) * (double)step;
    c->place = (double)first + x;
    return x >= begin - 0.5 && x <= begin + 1.5 && c->slope * (y_next - y_previous) > 0;
}

/* Finds the crossings of w->level between lobes that are higher than share_min of half the range.
 * Returns false if there are too few, or if lobes have too few rows. */
static bool find_crossings(struct smooth_wave *w, double share_min)
{
    const double height_min = share_min * 0.5 * (w->high - w->low);
    size_t crossed = 0;
    int side = 0;
    w->count = 0;
    for (size_t i = 0; i < w->n; i++) {
        const double deviation = w->y[i] - w->level;
        if (i > 0 && (deviation > 0) != (w->y[i - 1] - w->level > 0))
            crossed = i;
        const int now = level_side(deviation, height_min);
        if (now == 0 || now == side)
            continue;
        if (side != 0) {
            if (w->count == w->capacity ||
                (w->count > 0 && crossed < w->crossing[w->count - 1].row + lobe_rows_min))
                return false;
            w->crossing[w->count].row = crossed;
            w->height[w->count++] = 0;
        }
        side = now;
    }
    return w->count >= CROSSINGS_MIN;
}

/* Computes the logarithms of the heights of the lobes. Returns true if they change evenly. */
static bool heights_are_even(const struct smooth_wave *w)
{
    for (size_t k = 0; k + 1 < w->count; k++) {
        double top = 0;
        for (size_t i = w->crossing[k].row; i < w->crossing[k + 1].row; i++)
            top = fmax(top, fabs(w->y[i] - w->level));
        w->height[k] = log(top);
    }
    for (size_t k = 0; k + 5 < w->count; k++)
        if (fabs(w->height[k] - 2 * w->height[k + 2] + w->height[k + 4]) > height_uneven_max)
            return false;
    return true;
}

/* Moves a crossing to the level after that changed a little. Returns false if the level is not
 * crossed nearby. */
static bool follow_level(const struct smooth_wave *w, struct smooth_crossing *c)
{
    for (size_t i = 0; i < lobe_rows_min; i++) {
        const bool here = w->y[c->row] > w->level, was_above = w->y[c->row - 1] > w->level;
        if (here != was_above)
            return true;
        const bool rises = w->y[c->row] > w->y[c->row - 1];
        if (here == rises && c->row > 1)
            c->row--;
        else if (here != rises && c->row + 1 < w->n)
            c->row++;
    }
    return false;
}

/* Places all crossings of the level, by rows `step` apart. If a lobe does not reach it, only the
 * crossings on the side with more cycles are kept. Returns false if these are too few. */
static bool place_all(struct smooth_wave *w, size_t step)
{
    const size_t all = w->count;
    size_t kept = 0;
    for (size_t k = 0; k < all; k++) {
        struct smooth_crossing c = w->crossing[k];
        if (follow_level(w, &c) && place_crossing(w, step, &c))
            w->crossing[kept++] = c;
        else if (2 * k < all)
            kept = 0;
        else
            break;
    }
    w->count = kept;
    return kept >= CROSSINGS_MIN;
}

/* The line place = constant + k half + shift/slope through the crossings k, by least squares of the
 * values there. */
struct crossing_line {
    double half, shift;       /* [rows] half a period; error of the level, in the unit of y */
    double half_sigma;        /* [rows] from the scatter about the line */
    double half_sigma_of_one; /* [rows] for values with an uncertainty of 1 */
    double distance_max;      /* [rows] largest distance of a crossing from the line */
};

/* Fits the line through the crossings against their numbers, with a shift for a level off the
 * centre, into *line. Returns false if they do not determine it. */
static bool fit_crossings(const struct smooth_wave *w, struct crossing_line *line)
{
    const double middle = 0.5 * (double)(w->count - 1), origin = w->crossing[0].place,
                 guess = (w->crossing[w->count - 1].place - origin) / (double)(w->count - 1);
    double a[3 * 3] = {0}, b[3] = {0}, scale = 0, square = 0;
    for (size_t k = 0; k < w->count; k++)
        scale = fmax(scale, fabs(w->crossing[k].slope));
    for (size_t k = 0; k < w->count; k++) {
        const struct smooth_crossing *c = &w->crossing[k];
        const double s = c->slope / scale, x[3] = {s, s * ((double)k - middle) / middle, 1},
                     deviation = s * (c->place - origin - guess * (double)k);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j <= i; j++)
                a[3 * i + j] += x[i] * x[j];
            b[i] += x[i] * deviation;
        }
    }
    /* inverse becomes the diagonal element of the inverse for the slope. */
    double l[3 * 3] = {0}, unit[3] = {0, 1, 0};
    if (!matrix_cholesky(3, 3, a, 1e-10, l))
        return false;
    cholesky_forward(3, 3, l, b);
    cholesky_backward(3, 3, l, b);
    cholesky_forward(3, 3, l, unit);
    const double inverse = unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2];
    line->distance_max = 0;
    for (size_t k = 0; k < w->count; k++) {
        const struct smooth_crossing *c = &w->crossing[k];
        const double s = c->slope / scale, deviation = c->place - origin - guess * (double)k -
                                                       b[0] - b[1] * ((double)k - middle) / middle -
                                                       b[2] / s;
        square += s * s * deviation * deviation;
        line->distance_max = fmax(line->distance_max, fabs(deviation));
    }
    line->half = guess + b[1] / middle;
    line->half_sigma_of_one = sqrt(inverse) / middle / scale;
    line->half_sigma = sqrt(square / (double)(w->count - 3) * inverse) / middle;
    line->shift = b[2] * scale;
    return line->half > 0;
}

/* Finds the level at which the crossings are equally spaced (w->level, in and out), and the line
 * through them. Returns false if there is none. */
static bool find_centre(struct smooth_wave *w, struct crossing_line *line)
{
    double moved = HUGE_VAL;
    for (int pass = 0; pass < CENTRE_PASSES; pass++) {
        if (!place_all(w, 1) || !fit_crossings(w, line))
            return false;
        if (!(fabs(line->shift) < 0.5 * moved))
            return true; /* only rounding is left */
        moved = fabs(line->shift);
        w->level -= line->shift;
        if (!(w->level > w->low) || !(w->level < w->high))
            return false;
    }
    return true;
}

/* Finds centre and line, starting from `level`, and tests whether crossings and heights are
 * even. */
static bool find_line(struct smooth_wave *w, double level, double share_min,
                      struct crossing_line *line)
{
    w->level = level;
    return find_crossings(w, share_min) && find_centre(w, line) && find_crossings(w, share_min) &&
           find_centre(w, line) && line->distance_max <= off_line_max * 2 * line->half &&
           heights_are_even(w);
}

/* Returns the middle between the extremes of the first or the last eighth of the rows. */
static double level_at_end(const struct smooth_wave *w, bool last)
{
    const size_t n = w->n / 8;
    struct smooth_wave end = {.y = last ? w->y + w->n - n : w->y, .n = n};
    find_extremes(&end);
    return end.low + 0.5 * (end.high - end.low);
}

/* Finds the line of a motion that dies out, or grows from nothing, within a few cycles. */
static bool find_damped_line(struct smooth_wave *w, struct crossing_line *line)
{
    return find_line(w, level_at_end(w, true), lobe_min_damped, line) ||
           find_line(w, level_at_end(w, false), lobe_min_damped, line);
}

/* Returns the uncertainty [rows] of half a period by interpolation. With every second row,
 * interpolation of the fifth degree puts each crossing 2^6 times as far off. */
static double interpolation_sigma(struct smooth_wave *w, const struct crossing_line *line)
{
    double square = 0;
    for (size_t k = 0; k < w->count; k++) {
        struct smooth_crossing coarse = w->crossing[k];
        if (place_crossing(w, 2, &coarse)) {
            const double deviation = coarse.slope * (coarse.place - w->crossing[k].place);
            square += deviation * deviation;
        }
    }
    return sqrt(square / (double)w->count) / 63 * line->half_sigma_of_one;
}

/* Reads the period of an evenly sampled series with hardly any noise, from a line through the
 * crossings of its centre. Returns false if the series is not of this kind. */
bool smooth_period(const struct series *series, struct arena *arena, struct period *period)
{
    struct smooth_wave w = {.y = series->y, .n = series->n};
    struct crossing_line line;
    if (series->n < ROWS_MIN || !find_extremes(&w))
        return false;
    const double dt = (series->t[w.n - 1] - series->t[0]) / (double)(w.n - 1);
    if (!(dt > 0) || !(noise_at_places(&w) <= noise_max * 0.5 * (w.high - w.low)) ||
        !is_even(series, dt))
        return false;
    w.capacity = w.n / lobe_rows_min + 2;
    w.crossing = arena_array(arena, w.capacity, sizeof *w.crossing);
    w.height = arena_array(arena, w.capacity, sizeof *w.height);
    if (!w.crossing || !w.height)
        return false;
    if (!find_line(&w, w.low + 0.5 * (w.high - w.low), lobe_min, &line) &&
        !find_damped_line(&w, &line))
        return false;
    const size_t first = w.crossing[0].slope > 0 ? 0 : 1, cycles = (w.count - 1 - first) / 2;
    const double t0 = series->t[0], begin = w.crossing[first].place,
                 end = w.crossing[first + 2 * cycles].place;
    const double sigma =
        fmax(hypot(line.half_sigma, interpolation_sigma(&w, &line)), DBL_EPSILON * line.half);
    *period = (struct period){.period = {2 * line.half * dt, 2 * sigma * dt},
                              .first = t0 + dt * begin,
                              .last = t0 + dt * end,
                              .periods = (double)cycles,
                              .level = w.level,
                              .how = "up-crossings"};
    return true;
}
