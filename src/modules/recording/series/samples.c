/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A series prepared for analysis: means of neighbours, spikes, gaps, and the sensor's
 * resolution. */
#include <hooke/base/cancel.h>
#include "modules/recording/series/internal.h"
#include "modules/recording/fit/curve_problem.h"

#include <math.h>
#include <string.h>

/* Largest share of samples that may be spikes; more are the oscillation itself. */
#define SPIKES_MAX 0.2

/* Makes in *means, in the arena, the means of groups of `each` successive samples, of those in use.
 * Returns false if out of memory. */
bool samples_average(const struct samples *x, size_t each, struct arena *arena,
                     struct series *means)
{
    const size_t n = x->n / each;
    double *t = arena_array(arena, n + 1, sizeof *t), *y = arena_array(arena, n + 1, sizeof *y);
    *means = (struct series){.t = t, .y = y, .cancel = x->cancel};
    if (!t || !y)
        return false;
    for (size_t k = 0; k < n && !cancelled_at(x->cancel, k); k++) {
        double count = 0, time = 0, value = 0;
        for (size_t i = k * each; i < (k + 1) * each; i++)
            if (!x->use || x->use[i]) {
                count++;
                time += x->t[i];
                value += x->y[i];
            }
        if (count > 0) {
            t[means->n] = time / count;
            y[means->n++] = value / count;
        }
    }
    return true;
}

/* Sums differences from the first value, which avoids cancellation. */
double values_variance(const double *y, size_t n)
{
    double sum = 0, square = 0;
    for (size_t i = 0; i < n; i++) {
        const double deviation = y[i] - y[0];
        sum += deviation;
        square += deviation * deviation;
    }
    return (square - sum * sum / (double)n) / (double)n;
}

/* Returns the variance of the means of pairs of neighbours. */
static double variance_of_pairs(const double *y, size_t pairs)
{
    double sum = 0, square = 0;
    for (size_t i = 0; i < pairs; i++) {
        const double deviation = 0.5 * (y[2 * i] - y[0] + (y[2 * i + 1] - y[0]));
        sum += deviation;
        square += deviation * deviation;
    }
    return (square - sum * sum / (double)pairs) / (double)pairs;
}

/* Copies values, replacing those that are not in use by the latest one in use. */
static void fill_unused(const double *y, const unsigned char *use, size_t n, double *filled)
{
    size_t last = 0;
    while (last + 1 < n && !use[last])
        last++;
    for (size_t i = 0; i < n; i++) {
        last = use[i] ? i : last;
        filled[i] = y[last];
    }
}

/* Makes *thin by averaging pairs of neighbours repeatedly, as long as the variance lost is that of
 * white noise and at most the share lost_share_max of all. `use` [n] masks samples, NULL means all.
 * *thin is the series itself if it cannot be thinned. Returns false if out of memory. */
bool series_thin(const struct series *series, const unsigned char *use, double lost_share_max,
                 struct arena *arena, struct series *thin)
{
    enum { ROWS_MIN = 4096, ROWS_MIN_OF_HINTS = 1024, NOISE_ROWS = 4096 };
    static const double white_share_max = 0.5, white_share_exact = 1e-8, white_tolerance = 1.1;
    *thin = *series;
    const size_t rows_min = lost_share_max == THIN_FOR_HINTS ? ROWS_MIN_OF_HINTS : ROWS_MIN;
    if (series->n < 2 * rows_min)
        return true;
    const size_t rows = series->n;
    double scratch[NOISE_ROWS], left = 1, *t = arena_array(arena, rows / 2, sizeof *t),
                                *y = arena_array(arena, use ? rows : rows / 2, sizeof *y);
    if (!t || !y)
        return false;
    if (use) {
        fill_unused(series->y, use, rows, y);
        thin->y = y;
    }
    const size_t part = rows < NOISE_ROWS ? rows : NOISE_ROWS;
    const struct samples middle = {.y = thin->y + (rows - part) / 2, .n = part};
    const double all = values_variance(thin->y, rows), noise = samples_noise(&middle, scratch),
                 white = noise * noise,
                 lost_max = white > white_share_exact * all ? lost_share_max : THIN_KEEPS_LINES;
    /* Averages pairs as long as the variance lost is that of white noise and the permitted
     * share. */
    for (size_t n = rows / 2; n >= rows_min && white < white_share_max * all; n /= 2) {
        left *= 0.5;
        if (all - variance_of_pairs(thin->y, n) >
            white_tolerance * white * (1 - left) + lost_max * all)
            break;
        for (size_t i = 0; i < n; i++) {
            t[i] = 0.5 * (thin->t[2 * i] + thin->t[2 * i + 1]);
            y[i] = 0.5 * (thin->y[2 * i] + thin->y[2 * i + 1]);
        }
        thin->t = t;
        thin->y = y;
        thin->n = n;
    }
    if (thin->n == rows)
        thin->y = series->y;
    return true;
}

/* Shares the arrays; only the beginning, the number and t0 change. */
struct samples samples_part(const struct samples *samples, size_t begin, size_t end)
{
    struct samples part = *samples;
    part.t += begin;
    part.y += begin;
    part.use += begin;
    part.n = end - begin;
    part.t0 += (double)begin * samples->dt;
    return part;
}

/* Returns the part with the most samples between two gaps: steps longer than an eighth of the
 * period [s] and than six mean steps. */
struct series series_longest_stretch(const struct series *series, double period)
{
    if (series->n < 2)
        return *series;
    static const double gap_periods = 0.125, gap_steps = 6;
    const double step = (series->t[series->n - 1] - series->t[0]) / (double)(series->n - 1),
                 gap = fmax(gap_periods * period, gap_steps * step);
    struct series longest = *series;
    size_t begin = 0;
    longest.n = 0;
    for (size_t i = 1; i <= series->n; i++) {
        if (i < series->n && series->t[i] - series->t[i - 1] <= gap)
            continue;
        if (i - begin > longest.n) {
            longest.t = series->t + begin;
            longest.y = series->y + begin;
            longest.n = i - begin;
        }
        begin = i;
    }
    return longest;
}

/* Returns the mean over time of the series, with the rms deviation from it as its uncertainty; both
 * are integrated by trapezoids. */
struct measured series_mean(const struct series *s)
{
    double area = 0, square = 0;
    for (size_t i = 1; i < s->n; i++) {
        const double dt = s->t[i] - s->t[i - 1];
        area += 0.5 * dt * (s->y[i] + s->y[i - 1]);
    }
    const double span = s->t[s->n - 1] - s->t[0], mean = area / span;
    for (size_t i = 1; i < s->n; i++) {
        const double a = s->y[i] - mean, b = s->y[i - 1] - mean;
        square += 0.5 * (s->t[i] - s->t[i - 1]) * (a * a + b * b);
    }
    return (struct measured){mean, sqrt(square / span)};
}

/* Returns true if the flagged stretches come at even intervals and have similar heights above
 * `middle`: they are pulses of the motion, not values that a sensor missed. Stretches that all read
 * one value come from a sensor, however often they occur. scratch [n] is work space. */
static bool spikes_recur(const struct samples *x, double middle, double *scratch)
{
    enum { SPIKES = 512, RECUR_MIN = 5 };
    static const double alike = 0.15, alike_share = 0.7;
    const size_t max = x->n / 2 < SPIKES ? x->n / 2 : SPIKES;
    double *height = scratch, *interval = scratch + max, value = NAN;
    size_t count = 0, last = 0, even = 0, equal = 0;
    bool differs = false;
    double tallest = 0;
    for (size_t i = 0; i < x->n; i++)
        tallest = x->use[i] ? tallest : fmax(tallest, fabs(x->y[i] - middle));
    for (size_t i = 0; i < x->n && count < max; i++) {
        double highest = 0;
        size_t top = i;
        for (; i < x->n && !x->use[i]; i++) {
            const double here = fabs(x->y[i] - middle);
            differs = differs || (isfinite(value) && x->y[i] != value);
            value = x->y[i];
            if (here > highest) {
                highest = here;
                top = i;
            }
        }
        if (!(highest > 0.5 * tallest)) /* noise */
            continue;
        interval[count] = (double)(top - last);
        height[count++] = highest;
        last = top;
    }
    if (!differs || count < RECUR_MIN)
        return false;
    const double spacing = values_quantile(interval + 1, count - 1, 0.5),
                 high = values_quantile(height, count, 0.5);
    for (size_t k = 0; k < count; k++) {
        even += k > 0 && fabs(interval[k] / spacing - 1) < alike;
        equal += fabs(height[k] / high - 1) < 2 * alike;
    }
    return (double)even >= alike_share * (double)(count - 1) &&
           (double)equal >= alike_share * (double)count;
}

/* Returns true if two neighbouring values differ by more than `jump`. */
static bool has_jump(const double *y, size_t n, double jump)
{
    bool found = false;
    for (size_t i = 1; i < n && !found; i++)
        found = fabs(y[i] - y[i - 1]) > jump;
    return found;
}

/* Clears samples->use for spikes, such as missed echoes: values that leave the middle by more than
 * two thirds of the robust range (15 to 85 %) in one sample and come back as fast within six
 * samples. An oscillation with at least six samples a period never does so. This coarse test only
 * protects the spectrum, since local fits decide later. Each direction of time is searched, as a
 * bad first sample is only seen backwards. If many are found, they are the oscillation itself, with
 * few samples a period, or its pulses, and all samples are used again. scratch [n] is work space.
 */
void samples_flag_spikes(struct samples *samples, double *scratch)
{
    enum { LONGEST = 6 };
    if (samples->n < 16 || samples->resampled) {
        return;
    }
    size_t n = samples->n, stride = n / 2048 + 1, count = 0, flagged = 0;
    for (size_t i = 0; i < n; i += stride) {
        scratch[count++] = samples->y[i];
    }
    double high = values_quantile(scratch, count, 0.85),
           low = values_quantile(scratch, count, 0.15), jump = 0.67 * (high - low);
    double middle = 0.5 * (high + low);
    if (!(jump > 0) || !has_jump(samples->y, n, jump)) {
        return;
    }
    for (int backwards = 0; backwards < 2; backwards++) {
        const double *y = samples->y + (backwards ? n - 1 : 0);
        unsigned char *use = samples->use + (backwards ? n - 1 : 0);
        ptrdiff_t step = backwards ? -1 : 1;
        for (size_t i = 1; i < n; i++) {
            double previous = y[(ptrdiff_t)(i - 1) * step], here = y[(ptrdiff_t)i * step],
                   away = here - previous;
            if (fabs(away) <= jump || fabs(here - middle) <= fabs(previous - middle)) {
                continue;
            }
            size_t back = i + 1;
            while (back < n && back <= i + LONGEST &&
                   copysign(1, away) *
                           (y[(ptrdiff_t)(back - 1) * step] - y[(ptrdiff_t)back * step]) <=
                       jump) {
                back++;
            }
            if (back <= i + LONGEST) {
                for (; i < back; i++) {
                    use[(ptrdiff_t)i * step] = 0;
                    flagged++;
                }
            }
        }
    }
    if ((double)flagged > SPIKES_MAX * (double)n || spikes_recur(samples, middle, scratch)) {
        memset(samples->use, 1, n);
    }
}

/* ---- the step of a sensor, and what it leaves open ---- */

/* Returns true if nearly all differences of neighbours are multiples of the step `quantum`. */
static bool has_steps(const struct samples *x, double quantum)
{
    size_t others = 0;
    for (size_t i = 1; i < x->n && 100 * others <= x->n; i++) {
        const double multiple = (x->y[i] - x->y[i - 1]) / quantum;
        others += fabs(multiple - nearbyint(multiple)) > 0.01;
    }
    return 100 * others <= x->n;
}

/* Returns the step of the sensor's readings: the smallest difference of neighbours, or a fraction
 * of it, if the others are multiples; 0 if there is none. */
double samples_quantum(const struct samples *x)
{
    static const int parts_max = 5; /* a fast motion may take no single step of the sensor */
    const double rounding = 1e-12 * fmax(fabs(x->y[0]), fabs(x->y[x->n - 1]));
    double smallest = HUGE_VAL;
    for (size_t i = 1; i < x->n && !cancelled_at(x->cancel, i); i++) {
        double step = fabs(x->y[i] - x->y[i - 1]);
        smallest = step > rounding && step < smallest ? step : smallest;
    }
    for (int parts = 1; parts <= parts_max && isfinite(smallest); parts++)
        if (has_steps(x, smallest / parts))
            return smallest / parts;
    return 0;
}

/* Returns true if nearly all samples read the same as those `lag` samples later, to a hundredth of
 * the step. */
static bool readings_repeat(const struct samples *x, size_t lag, double quantum)
{
    static const double repeat_share = 0.8;
    size_t same = 0;
    for (size_t i = 0; i + lag < x->n; i++)
        same += fabs(x->y[i + lag] - x->y[i]) < 0.01 * quantum;
    return lag < x->n && (double)same >= repeat_share * (double)(x->n - lag);
}

/* Returns the relative uncertainty of the period due to the sensor's step, if the readings repeat
 * in each period; 0 otherwise. */
double quantum_pace(const struct motion *m)
{
    const double samples = m->overview.period / m->samples.dt,
                 amplitude = hypot(m->harmonic.a, m->harmonic.b), steps = amplitude / m->quantum;
    if (!(m->quantum > 0) || !(samples >= 2) || !(steps > 0) ||
        !readings_repeat(&m->samples, (size_t)nearbyint(samples), m->quantum))
        return 0;
    /* The phase is known only from the samples of one period, each to a step of the value; or from
     * the edges between steps, each to a step of time. The better one counts. */
    const double of_values = sqrt(2 / samples) / sqrt(12) / steps,
                 of_edges = TWO_PI / samples / sqrt(12) / sqrt(4 * steps);
    return sqrt(2) * fmin(of_values, of_edges) / (TWO_PI * m->overview.periods);
}

/* ---- for fits ---- */

bool enough_samples(const struct series *series, int parameters, struct error *error)
{
    return series->n > (size_t)parameters ||
           error_set(error, ERROR_COMMAND, "%zu samples cannot determine %d parameters", series->n,
                     parameters);
}

/* Sets *part to every k-th sample of a series, so that at most CURVE_MANY remain; shares its memory
 * if that is all. Returns false if out of memory. */
bool curve_part(const struct series *series, struct arena *arena, struct series *part)
{
    const size_t stride = series->n / CURVE_MANY + 1, n = series->n / stride;
    *part = *series;
    if (stride == 1)
        return true;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    for (size_t i = 0; i < n && t && y; i++) {
        t[i] = series->t[i * stride];
        y[i] = series->y[i * stride];
    }
    part->t = t;
    part->y = y;
    part->n = n;
    return t && y;
}
