/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Period and amplitude, window by window. */
#include "modules/recording/series/internal.h"

#include <math.h>

/* Noise over amplitude below which a series is a simulation. */
#define SIMULATION_NOISE_RATIO 1e-4

/* Returns half the mean distance between successive extremes, each placed by a parabola, or NAN if
 * there are fewer than two. */
static double mean_swing(const struct series *s)
{
    double previous = NAN, sum = 0, count = 0;
    for (size_t i = 1; i + 1 < s->n; i++) {
        const double l = s->y[i - 1], m = s->y[i], r = s->y[i + 1];
        if ((m > l) != (m >= r) || m == l)
            continue;
        const double curvature = l - 2 * m + r, top = m - (l - r) * (l - r) / (8 * curvature);
        if (isfinite(previous)) {
            sum += 0.5 * fabs(top - previous);
            count++;
        }
        previous = top;
    }
    return count > 0 ? sum / count : NAN;
}

/* Reads period and amplitude of one window of that middle and width [s]. Returns false with the
 * error. */
static bool read_window(const struct series *part, double middle, double width, struct arena *arena,
                        struct period_reading *reading, struct error *error)
{
    struct period p;
    struct reading a;
    struct overview overview;
    if (!series_period(part, arena, &p, error) ||
        !series_amplitudes(part, arena, &middle, 1, width, &a, error))
        return false;
    series_overview(part, arena, &overview);
    *reading = (struct period_reading){
        .t = middle, .amplitude = a.amplitude, .period = p.period, .periods = p.periods};
    const double swing =
        overview.noise < SIMULATION_NOISE_RATIO * a.amplitude.value ? mean_swing(part) : NAN;
    if (isfinite(swing)) /* overtones count, which a fitted sine lacks */
        reading->amplitude.value = swing;
    return true;
}

/* Divides the series into `windows` equal windows and reads period and amplitude of each into
 * reading[]. Returns false with the error if one cannot be read. */
bool series_period_readings(const struct series *series, int windows, struct arena *arena,
                            struct period_reading *reading, struct error *error)
{
    const double t_begin = series->t[0], width = (series->t[series->n - 1] - t_begin) / windows;
    for (int i = 0; i < windows; i++) {
        const struct series part =
            series_window(*series, t_begin + i * width, t_begin + (i + 1) * width);
        if (part.n < 3)
            return error_set(error, ERROR_COMMAND, "fewer than 3 samples in one of %d windows",
                             windows);
        if (!read_window(&part, t_begin + (i + 0.5) * width, width, arena, &reading[i], error))
            return false;
        reading[i].t_begin = t_begin + i * width;
        reading[i].t_end = t_begin + (i + 1) * width;
    }
    return true;
}

struct measured measured_at_pace(struct measured time, double pace)
{
    if (pace > 0)
        time.uncertainty = hypot(time.uncertainty, pace * time.value);
    return time;
}
