/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds a periodic orbit from a state near it (orbit_find): the motion is followed until it nearly
 * returns, returns are tried from the earliest on, and Newton's method closes the orbit
 * (close.c). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/catalog.h>
#include <hooke/base/numeric.h>

#include "modules/dynamics/orbits/solutions.h"

#define RETURNS_MAX 48            /* largest number of returns in a span */
#define RETURN_NEAR_FRACTION 0.02 /* a return within this part of the extent is tried */
#define RETURN_FAR_FRACTION 0.2   /* the same later, if there was none as near */
#define REST_SIZES 1e-7           /* the motion rests if its extent, in sizes, is below this */
#define SETTLING_SPANS_MAX 40     /* number of spans for which the motion may settle */
#define SETTLING_PERIODS_MAX 240  /* the same in periods of the drive */
#define SUBHARMONIC_MAX 16        /* largest multiple of the drive's period */
#define RETURN_TRIES_MAX 6        /* largest number of returns of one span that are tried */
#define ALL_TRIES 24              /* largest number of tries at all: the motion may be chaotic */
/* The search ends after this number of evaluations, which take about a second. */
#define SEARCH_EVALUATIONS_MAX 6000000

/* ---- the smallest period ---- */

/* Returns true if the orbit closes after the period divided by `parts`, too. */
static bool closes_after(struct orbit_search *s, const struct solution *orbit, int parts)
{
    double end[FIELD_VARIABLES];
    return field_flow(&s->field, s->field.system.t0, orbit->state, orbit->period / parts, end,
                      NULL) &&
           field_distance(&s->field, orbit->state, end) < 1e-5 * orbit_extent(&s->field, orbit);
}

/* Closes the orbit, then divides its period by 2, 3, 5 and 7 as long as it closes after that time,
 * too. Returns false if no orbit is found. */
static bool close_smallest(struct orbit_search *s, const double *state, double period, int multiple,
                           struct found_orbit *orbit)
{
    static const int parts[] = {2, 3, 5, 7};
    if (!orbit_close(s, state, period, multiple, NULL, orbit))
        return false;
    for (size_t k = 0; k < COUNT_OF(parts);) {
        struct found_orbit part = *orbit;
        const int divisor = parts[k];
        if ((multiple == 0 || orbit->solution.multiple % divisor == 0) &&
            closes_after(s, &orbit->solution, divisor) &&
            orbit_close(s, orbit->solution.state, orbit->solution.period / divisor,
                        orbit->solution.multiple / divisor, NULL, &part) &&
            part.solution.period < 0.75 * orbit->solution.period)
            *orbit = part;
        else
            k++;
    }
    return true;
}

/* Reports progress of unknown extent. */
static void orbit_progress_report(const struct orbit_search *s)
{
    if (s->request->progress)
        s->request->progress(s->request->context, 0);
}

/* Tries to close an orbit near `state` with this period, which is `multiple` periods of the drive
 * (0 without a drive). The first orbit found is stored in *s->found, and a wanted one replaces it:
 * a stable one, or any if the motion need not settle. Returns true if the orbit is wanted. */
static bool try_orbit(struct orbit_search *s, const double *state, double period, int multiple)
{
    struct found_orbit orbit = {.samples = 0};
    s->tries++;
    orbit_progress_report(s);
    if (!close_smallest(s, state, period, multiple, &orbit))
        return false;
    const bool wanted = solution_stable(&orbit.solution) || !s->request->settles;
    if (wanted || !s->any)
        *s->found = orbit;
    s->any = true;
    return wanted;
}

/* ---- returns of the motion ---- */

/* Times [s] at which the motion passes near its start, and how near, as a fraction of its
 * extent. */
struct returns {
    int count;
    double time[RETURNS_MAX], distance[RETURNS_MAX];
};

/* Follows the motion over `span` [s] and stores in *found when it crosses the plane through its
 * start in the same direction, and how far from the start. Sets s->extent, the size of the motion,
 * and end [n], the state after that time. Returns false if the motion cannot be followed. */
static bool find_returns(struct orbit_search *s, double span, struct returns *found, double *end)
{
    const int n = s->field.n;
    double grid[FIELD_TIMES * FIELD_VARIABLES], point[FIELD_VARIABLES];
    struct field_plane plane;
    const double h = span / (FIELD_TIMES - 1);
    field_plane_across(&s->field, s->state, &plane);
    if (!field_follow(&s->field, s->t, s->state, span, grid))
        return false;
    found->count = 0;
    s->extent = 0;
    for (int i = 0; i < n; i++) {
        double top = grid[i], bottom = grid[i];
        for (int k = 1; k < FIELD_TIMES; k++) {
            top = fmax(top, grid[k * n + i]);
            bottom = fmin(bottom, grid[k * n + i]);
        }
        const double range =
            s->field.turn[i] > 0 ? fmin(top - bottom, s->field.turn[i]) : top - bottom;
        s->extent = fmax(s->extent, range / s->field.size[i]);
    }
    for (int k = 2; k < FIELD_TIMES && found->count < RETURNS_MAX; k++) {
        const double *a = grid + (k - 1) * n;
        if (!(field_side(&s->field, &plane, a) < 0 && field_side(&s->field, &plane, a + n) >= 0))
            continue;
        const double delay =
            field_crossing(&s->field, s->t + (k - 1) * h, a, h, a + n, &plane, point);
        if (!isfinite(delay))
            continue;
        found->time[found->count] = (k - 1) * h + delay;
        found->distance[found->count++] = field_distance(&s->field, s->state, point) / s->extent;
    }
    memcpy(end, grid + (FIELD_TIMES - 1) * n, (size_t)n * sizeof *end);
    return true;
}

/* Returns true if the search has used up its evaluations or tries. */
static bool is_search_spent(const struct orbit_search *s)
{
    return s->field.evals > SEARCH_EVALUATIONS_MAX || s->tries >= ALL_TRIES;
}

/* Tries to close an orbit from each return that is at most distance_max (a fraction of the motion's
 * extent) from the start and not far behind the nearest one, the earliest first. Returns true if a
 * wanted orbit was found (try_orbit()) or if cancelled. */
static bool try_returns(struct orbit_search *s, const struct returns *r, double distance_max)
{
    double best = HUGE_VAL;
    int tried = 0;
    for (int k = 0; k < r->count; k++)
        best = fmin(best, r->distance[k]);
    for (int k = 0; k < r->count && tried < RETURN_TRIES_MAX && !is_search_spent(s); k++)
        if (r->distance[k] <= distance_max &&
            (r->distance[k] <= 1e3 * best || r->distance[k] <= RETURN_NEAR_FRACTION)) {
            tried++;
            if (cancelled(s->request->cancel) || try_orbit(s, s->state, r->time[k], 0))
                return true;
        }
    return false;
}

/* Ends a search that has found no wanted orbit. Returns true if there is another one at least, else
 * sets *error: `why`, or that it was cancelled. */
static bool end_search(struct orbit_search *s, const char *why, struct error *error)
{
    if (cancelled(s->request->cancel))
        return error_set(error, ERROR_CANCELLED, "cancelled");
    s->found->given_up = s->request->settles && s->any && is_search_spent(s) &&
                         !solution_stable(&s->found->solution);
    if (s->any)
        return true;
    error_set(error, ERROR_COMMAND, "%s%s", why,
              is_search_spent(s) ? " within the time searched; it may be chaotic" : "");
    return error_hint(error, "give a guess: orbit period=T and variables, as in %s=1",
                      system_variable(&s->field.system, 0).name);
}

/* Finds an orbit of an autonomous scene. The span is doubled or divided by 4 until the motion
 * returns to its start a few times in it; then orbits are closed from these returns. If none closes
 * to a stable orbit the motion is followed for another span, at most SETTLING_SPANS_MAX times
 * (`waits`), so that it settles; in the second half of these, returns from farther away are tried,
 * too. Returns true if s->found is an orbit, else false with an error. */
static bool find_autonomous(struct orbit_search *s, struct error *error)
{
    static const char none[] = "the motion does not return to an earlier state";
    const int n = s->field.n;
    double span = s->request->span, end[FIELD_VARIABLES];
    for (int waits = 0, spans = 0; spans < 3 * SETTLING_SPANS_MAX; spans++) {
        struct returns found;
        orbit_progress_report(s);
        if (cancelled(s->request->cancel) || !find_returns(s, span, &found, end))
            return end_search(s, spans > 0 ? none : "the motion from there ends before it returns",
                              error);
        if (s->extent < REST_SIZES)
            return end_search(s, "the motion comes to rest at an equilibrium", error);
        s->first = fmax(s->first, s->extent);
        if (found.count == 0 && span < 1e6 * s->request->span && spans < SETTLING_SPANS_MAX) {
            span *= 2;
            continue;
        }
        if (found.count >= RETURNS_MAX && spans < SETTLING_SPANS_MAX) {
            span /= 4;
            continue;
        }
        if (try_returns(s, &found,
                        waits < SETTLING_SPANS_MAX / 2 ? RETURN_NEAR_FRACTION
                                                       : RETURN_FAR_FRACTION))
            return end_search(s, none, error) || s->any; /* an orbit counts even if cancelled */
        if (waits++ == SETTLING_SPANS_MAX || !s->request->settles || is_search_spent(s))
            break;
        memcpy(s->state, end, (size_t)n * sizeof *end);
    }
    return end_search(s, s->extent < s->first / 2 ? "the motion dies away" : none, error);
}

/* Finds an orbit near a guess of the period; in a family the member that has this period. */
static bool find_of_period(struct orbit_search *s, double period, struct error *error)
{
    static const char none[] = "no periodic orbit was found near this guess";
    const struct orbit_request *wanted = s->request;
    struct orbit_request motion = *wanted;
    struct error ignored;
    motion.period = 0;
    if (!try_orbit(s, s->state, period, 0) && !s->any) {
        s->request = &motion; /* Find the orbit on which it moves, which may be one of a family. */
        const bool family = find_autonomous(s, &ignored) && s->found->family;
        s->request = wanted;
        s->any = family;
        if (!family)
            return end_search(s, none, error);
    }
    return !s->found->family || orbit_of_period(s, period, error);
}

/* ---- with a drive ---- */

/* Finds the response to a drive with this period [s]: the motion settles until its states at
 * multiples of the period recur. */
static bool find_driven(struct orbit_search *s, double drive, struct error *error)
{
    const double t0 = s->field.system.t0;
    double history[SUBHARMONIC_MAX + 1][FIELD_VARIABLES];
    if (s->request->period > 0) {
        const double ratio = s->request->period / drive;
        if (!(fabs(ratio - rint(ratio)) < 0.02 && ratio > 0.5 && ratio < 1000))
            return error_set(error, ERROR_COMMAND,
                             "the period is one of the drive's %.9g s, or a multiple of it", drive);
        return try_orbit(s, s->state, s->request->period, (int)lrint(ratio)) ||
               end_search(s, "no response of that period was found near this guess", error);
    }
    /* Continue to the time at which the drive is as at the start. */
    const double turns = ceil((s->t - t0) / drive - 1e-9), remaining = t0 + turns * drive - s->t;
    if (remaining > 1e-9 * drive &&
        !field_flow(&s->field, s->t, s->state, remaining, s->state, NULL))
        return end_search(s, "the motion from there ends", error);
    struct returns ignored;
    if (!find_returns(s, drive, &ignored, history[0]))
        return end_search(s, "the motion from there ends", error);
    const double extent = fmax(s->extent, REST_SIZES);
    memcpy(history[0], s->state, sizeof history[0]);
    for (int k = 1; k <= SETTLING_PERIODS_MAX && s->request->settles; k++) {
        double *now = history[k % (SUBHARMONIC_MAX + 1)], best = HUGE_VAL,
               distance[SUBHARMONIC_MAX + 1];
        orbit_progress_report(s);
        if (cancelled(s->request->cancel) ||
            !field_flow(&s->field, t0, history[(k - 1) % (SUBHARMONIC_MAX + 1)], drive, now, NULL))
            return end_search(s, "the motion from there ends", error);
        memcpy(s->state, now, sizeof s->state);
        for (int q = 1; q <= SUBHARMONIC_MAX && q <= k; q++) {
            distance[q] =
                field_distance(&s->field, s->state, history[(k - q) % (SUBHARMONIC_MAX + 1)]);
            best = fmin(best, distance[q]);
        }
        if (is_search_spent(s))
            break;
        if (best > 1e-4 * extent)
            continue;
        for (int q = 1; q <= SUBHARMONIC_MAX && q <= k; q++)
            if (distance[q] < RETURN_NEAR_FRACTION * extent && try_orbit(s, now, q * drive, q))
                return true;
        if (best < 1e-9 * extent)
            break;
    }
    for (int q = 1; q <= 3; q++)
        if (!s->any && try_orbit(s, s->state, q * drive, q))
            return true;
    return end_search(s, "no response with the period of the drive, or a few of these, was found",
                      error);
}

/* ---- the orbit itself ---- */

#define SAMPLES_MOST 4096 /* largest number of samples of an orbit */
/* Longer gaps between samples, relative to the extent, are divided. */
#define SAMPLE_GAP_FRACTION 0.03
#define SUBDIVISIONS_MAX 3 /* times that a gap is divided, by FIELD_TIMES - 1 each */

/* Appends a sample and extends the extrema of the orbit by it. */
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

/* Returns true if two states differ by more than a share of the range of some variable. */
static bool is_far(const struct solution *s, const double *a, const double *b, double share)
{
    bool far = false;
    for (int i = 0; i < s->n; i++)
        far = far || fabs(a[i] - b[i]) > share * (s->top[i] - s->bottom[i]);
    return far;
}

/* Samples the motion from `start` over `span` [s], and again more densely between states that are
 * far apart. `depth` is the number of such subdivisions. Returns false if the motion cannot be
 * followed. */
static bool sample_orbit(struct vector_field *field, struct found_orbit *orbit, double t,
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
        if (depth < SUBDIVISIONS_MAX && is_far(s, a, b, SAMPLE_GAP_FRACTION) &&
            !sample_orbit(field, orbit, t + (k - 1) * h, a, h, depth + 1))
            return false;
        if (depth > 0 && k + 1 < FIELD_TIMES && !is_far(s, last, b, SAMPLE_GAP_FRACTION / 2))
            continue;
        if (depth == 0 || k + 1 < FIELD_TIMES) /* its end is the caller's */
            put_sample(orbit, s->n, t + k * h, b);
        memcpy(last, b, (size_t)s->n * sizeof *last);
    }
    return true;
}

/* Returns the smallest distance of the orbit from the requested state as a part of its extent. */
static double distance_from_request(const struct orbit_search *s, const struct found_orbit *orbit)
{
    const int n = s->field.n;
    double nearest = HUGE_VAL;
    for (int k = 0; k + 1 < orbit->samples; k++) {
        const double *a = orbit->sample + k * (n + 1) + 1, *b = a + n + 1;
        double nearest_point[FIELD_VARIABLES], sum = 0;
        field_nearest_on_line(&s->field, s->request->state, a, b, nearest_point);
        for (int i = 0; i < n; i++)
            sum += pow(field_apart(&s->field, i, nearest_point, s->request->state), 2);
        nearest = fmin(nearest, sum);
    }
    return sqrt(nearest) / orbit_extent(&s->field, &orbit->solution);
}

/* Returns the energy [J] that the drive puts in over a period; without a drive, that which the
 * forces put in while their power is positive. */
static double energy_per_period(const struct system *system, const struct found_orbit *orbit)
{
    const int n = system->n;
    double sum = 0, last = 0, t_last = 0;
    for (int k = 0; k < orbit->samples; k++) {
        const double *row = orbit->sample + k * (n + 1), t = system->t0 + row[0];
        const double power = system->autonomous ? fmax(system_power(system, t, row + 1), 0)
                                                : system_power(system, t, row + 1) -
                                                      system_dissipation(system, t, row + 1);
        sum += k > 0 ? (row[0] - t_last) * (power + last) / 2 : 0;
        last = power;
        t_last = row[0];
    }
    return sum;
}

/* Completes *s->found: samples, distance from the requested state, energy. An orbit on which the
 * equations jump has no multipliers. Returns false with *error if out of memory. */
static bool complete_orbit(struct orbit_search *s, struct error *error)
{
    struct found_orbit *orbit = s->found;
    const int n = s->field.n;
    struct system system;
    orbit->sample = malloc((size_t)(SAMPLES_MOST * (n + 1)) * sizeof *orbit->sample);
    if (!orbit->sample)
        return error_memory(error);
    put_sample(orbit, n, 0, orbit->solution.state);
    if (!sample_orbit(&s->field, orbit, 0, orbit->solution.state, orbit->solution.period, 0))
        orbit->samples = 1;
    orbit->away = orbit->samples > 1 ? distance_from_request(s, orbit) : NAN;
    if (field_jumps(&s->field, s->field.system.t0, orbit->solution.state, orbit->solution.period)) {
        orbit->solution.values = 0;
        orbit->solution.trivial = orbit->error = NAN;
        orbit->family = false;
    }
    orbit->energy_in = NAN;
    if (scene_bind(s->request->scene, &system, error) && system.order == 2 && system.energy)
        orbit->energy_in = energy_per_period(&system, orbit);
    return true;
}

/* Returns the index of a parameter that the shooting equations can be differentiated by: not 0, and
 * not the start time. */
static int differentiable_parameter(const struct scene *scene)
{
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        if (strcmp(param_at(scene, i)->row.name, "t0") != 0 && scene->value[i] != 0)
            return i;
    return 0;
}

/* Finds a closed orbit: the response if there is a periodic drive, else one near the guessed
 * request->period, else whatever the motion returns to. *found receives the orbit with its cost.
 * Returns false with *error if there is none, if forces depend on time but not periodically, or if
 * cancelled. */
bool orbit_find(const struct orbit_request *request, struct found_orbit *found, struct error *error)
{
    const int64_t start_time = clock_ns();
    const int param = differentiable_parameter(request->scene);
    struct orbit_search s = {.request = request, .found = found, .t = request->t};
    *found = (struct found_orbit){.samples = 0};
    if (!field_init(&s.field, request->scene, &param, 1, error))
        return false;
    s.field.cancel = request->cancel;
    memcpy(s.state, request->state, sizeof s.state);
    for (int i = 0; i < s.field.n; i++)
        s.field.size[i] = fmax(s.field.size[i], fabs(s.state[i]));
    const double drive = field_drive(&s.field);
    bool fine;
    if (isnan(drive))
        fine = error_set(error, ERROR_COMMAND, "forces depend on time, but not periodically");
    else if (drive > 0)
        fine = find_driven(&s, drive, error);
    else if (request->period > 0)
        fine = find_of_period(&s, request->period, error);
    else
        fine = find_autonomous(&s, error);
    fine = fine && complete_orbit(&s, error);
    if (fine && cancelled(request->cancel))
        fine = error_set(error, ERROR_CANCELLED, "cancelled");
    found->evals = s.field.evals;
    found->seconds = clock_seconds(start_time);
    field_free(&s.field);
    return fine;
}

void orbit_free(struct found_orbit *orbit)
{
    free(orbit->sample);
    *orbit = (struct found_orbit){.samples = 0};
}
