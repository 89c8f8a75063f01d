/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The step of a sensor, and what it leaves open. */
#include "analysis/internal.h"

#include <math.h>

/* Returns true if nearly all differences of neighbours are multiples of a step. */
static bool has_steps(const struct samples *x, double quantum)
{
    size_t others = 0;
    for (size_t i = 1; i < x->n && 100 * others <= x->n; i++) {
        const double multiple = (x->y[i] - x->y[i - 1]) / quantum;
        others += fabs(multiple - nearbyint(multiple)) > 0.01;
    }
    return 100 * others <= x->n;
}

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

/* Returns true if nearly all samples read the same as those `lag` later. */
static bool readings_repeat(const struct samples *x, size_t lag, double quantum)
{
    static const double repeat_share = 0.8;
    size_t same = 0;
    for (size_t i = 0; i + lag < x->n; i++)
        same += fabs(x->y[i + lag] - x->y[i]) < 0.01 * quantum;
    return lag < x->n && (double)same >= repeat_share * (double)(x->n - lag);
}

double quantum_pace(const struct motion *m)
{
    const double samples = m->overview.period / m->samples.dt,
                 amplitude = hypot(m->harmonic.a, m->harmonic.b), steps = amplitude / m->quantum;
    if (!(m->quantum > 0) || !(samples >= 2) || !(steps > 0) ||
        !readings_repeat(&m->samples, (size_t)nearbyint(samples), m->quantum))
        return 0;
    /* The samples of one period are all that is known of the phase; or its edges are, each to a
     * step of time. */
    const double of_values = sqrt(2 / samples) / sqrt(12) / steps,
                 of_edges = TWO_PI / samples / sqrt(12) / sqrt(4 * steps);
    return sqrt(2) * fmin(of_values, of_edges) / (TWO_PI * m->overview.periods);
}
