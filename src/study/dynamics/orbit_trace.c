/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An orbit that has been found as samples of one period, with its extrema and its energy. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/numeric.h>

#include "study/dynamics/solutions.h"

#define SAMPLES_MOST 4096
#define SHARE 0.03 /* of the extent: a longer way between samples is looked at again */
#define DEPTH 3

static void put_sample(struct found_orbit *orbit, int n, double t, const double *y)
{
    double *row = orbit->sample + orbit->samples * (n + 1);
    for (int i = 0; i < n; i++) {
        orbit->solution.top[i] = fmax(orbit->solution.top[i], y[i]);
        orbit->solution.bottom[i] = fmin(orbit->solution.bottom[i], y[i]);
    }
    if (orbit->samples == SAMPLES_MOST)
        return;
    row[0] = t;
    memcpy(row + 1, y, (size_t)n * sizeof *y);
    orbit->samples++;
}

static bool is_far(const struct solution *s, const double *a, const double *b, double share)
{
    bool far = false;
    for (int i = 0; i < s->n; i++)
        far = far || fabs(a[i] - b[i]) > share * (s->top[i] - s->bottom[i]);
    return far;
}

/* Rows after the start; of those that are closer in time only where it moves far. */
static bool sample(struct vector_field *field, struct found_orbit *orbit, double t,
                   const double *start, double span, int depth)
{
    const struct solution *s = &orbit->solution;
    double grid[FIELD_TIMES * FIELD_VARIABLES], last[FIELD_VARIABLES];
    const double h = span / (FIELD_TIMES - 1);
    if (!field_follow(field, field->system.t0 + t, start, span, grid))
        return false;
    memcpy(last, start, (size_t)s->n * sizeof *last);
    for (int k = 1; k < FIELD_TIMES; k++) {
        const double *a = grid + (k - 1) * s->n, *b = a + s->n;
        if (depth < DEPTH && is_far(s, a, b, SHARE) &&
            !sample(field, orbit, t + (k - 1) * h, a, h, depth + 1))
            return false;
        if (depth > 0 && k + 1 < FIELD_TIMES && !is_far(s, last, b, SHARE / 2))
            continue;
        if (depth == 0 || k + 1 < FIELD_TIMES) /* its end is the caller's */
            put_sample(orbit, s->n, t + k * h, b);
        memcpy(last, b, (size_t)s->n * sizeof *last);
    }
    return true;
}

/* [J] over a period: what a drive puts in; without one, what is put in where power is above 0. */
static double energy_of(const struct system *system, const struct found_orbit *orbit)
{
    const int n = system->n;
    double sum = 0, last = 0, at = 0;
    for (int k = 0; k < orbit->samples; k++) {
        const double *row = orbit->sample + k * (n + 1), t = system->t0 + row[0];
        const double power = system->autonomous ? fmax(system_power(system, t, row + 1), 0)
                                                : system_power(system, t, row + 1) -
                                                      system_dissipation(system, t, row + 1);
        sum += k > 0 ? (row[0] - at) * (power + last) / 2 : 0;
        last = power;
        at = row[0];
    }
    return sum;
}

bool orbit_trace(struct orbit_search *s, struct error *error)
{
    struct found_orbit *orbit = s->found;
    const int n = s->field.n;
    struct system system;
    orbit->sample = malloc((size_t)(SAMPLES_MOST * (n + 1)) * sizeof *orbit->sample);
    if (!orbit->sample)
        return error_memory(error);
    put_sample(orbit, n, 0, orbit->solution.state);
    if (!sample(&s->field, orbit, 0, orbit->solution.state, orbit->solution.period, 0))
        orbit->samples = 1;
    if (field_jumps(&s->field, s->field.system.t0, orbit->solution.state, orbit->solution.period)) {
        orbit->solution.values = 0;
        orbit->solution.trivial = orbit->error = NAN;
        orbit->family = false;
    }
    orbit->energy_in = NAN;
    if (scene_bind(s->request->scene, &system, error) && system.order == 2 && system.energy)
        orbit->energy_in = energy_of(&system, orbit);
    return true;
}

void orbit_free(struct found_orbit *orbit)
{
    free(orbit->sample);
    *orbit = (struct found_orbit){.samples = 0};
}
