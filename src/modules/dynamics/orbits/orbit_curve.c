/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The curve problem of periodic orbits by multiple shooting: unknowns are the states at the
 * beginning of each segment and the period, unless the drive gives it. The start of an autonomous
 * orbit lies in the plane across the reference orbit (Seydel 2010, Practical Bifurcation and
 * Stability Analysis, 7.3). */
#include <hooke/base/numeric.h>
#include "modules/dynamics/orbits/problem.h"

#include <math.h>
#include <string.h>

#define FINE_TOL 1e-13             /* tolerance of flows relative to the sizes */
#define WALK_TOL 1e-8              /* the same for a step along the curve */
#define NEW_SEGMENT_GROWTH_MAX 1e2 /* growth of differences in a new segment, at most */
/* Differences that grow and decay within a period are resolved by these. */
#define SEGMENTS_MIN 5
#define TRIVIAL_MULTIPLIER_ERROR_MAX 1e-2
#define SEGMENT_GROWTH_MAX 3e3 /* Segments in which differences grow more are halved. */
/* Time is redistributed only if this shortens the way that states move in a step to this part. */
#define STRETCH_MIN_FRACTION 0.5
/* Part of the period by which it may shrink without redistributing the time. */
#define SHRINK_ROOM_FRACTION 0.25

/* Converts a state from unknowns to SI units. */
static void state_of(const struct vector_field *field, const double *u, double *y)
{
    for (int i = 0; i < field->n; i++)
        y[i] = u[i] * field->size[i];
}

double orbit_curve_period(const struct orbit_curve *c, const double *u)
{
    if (!c->forced)
        return u[c->segments * c->field->n] * c->tsize;
    return c->multiple * (c->drive > 0 ? c->drive : field_drive(c->field));
}

/* Returns the time [s] from the start of the orbit to the beginning of segment i. */
static double segment_start(const struct orbit_curve *c, int i, double period)
{
    return c->fixed[i] + period * c->share[i];
}

/* Returns the length [s] of segment i. */
static double segment_span(const struct orbit_curve *c, int i, double period)
{
    return segment_start(c, i + 1, period) - segment_start(c, i, period);
}

/* Computes the rate in units of size at a time. */
static void rate_of(struct vector_field *field, double t, const double *y, double *rate)
{
    field->evals++;
    system_derivative(&field->system, t, y, rate);
    for (int i = 0; i < field->n; i++)
        rate[i] /= field->size[i];
}

/* The flow over one segment: time, start and end [SI], derivatives. */
struct shot {
    double t, span, start[FIELD_VARIABLES], end[FIELD_VARIABLES];
    struct flow_slopes slopes;
    double first[FIELD_VARIABLES], last[FIELD_VARIABLES]; /* rates at both ends */
};

/* Computes the flow over segment i. Returns false if it cannot be followed. */
static bool shoot_segment(const struct orbit_curve *c, const double *u, int i, double period,
                          struct shot *s)
{
    struct vector_field *field = c->field;
    s->span = segment_span(c, i, period);
    s->t = field->system.t0 + segment_start(c, i, period);
    state_of(field, u + i * field->n, s->start);
    if (!(s->span > 0) || !field_flow(field, s->t, s->start, s->span, s->end, &s->slopes))
        return false;
    rate_of(field, s->t, s->start, s->first);
    rate_of(field, s->t + s->span, s->end, s->last);
    return true;
}

/* Corrects the derivative by the parameter where it changes the drive's period: both ends of the
 * segment move in time. */
static void add_drive(const struct orbit_curve *c, int i, double rate, struct shot *s)
{
    const int n = c->field->n;
    const double rate_begin = rate * c->share[i], rate_end = rate * c->share[i + 1];
    for (int k = 0; k < n; k++) {
        s->slopes.by_parameter[0][k] += rate_end * s->last[k];
        for (int l = 0; l < n; l++)
            s->slopes.by_parameter[0][k] -=
                rate_begin * s->slopes.by_start[k * n + l] * s->first[l];
    }
}

/* Sets the n equations of segment i of a closed orbit in f, and their derivatives in jacobian, at
 * the unknowns u: the end of segment i, integrated in *s, must equal the start of the next one.
 * Behind the last segment this is the first one, with angles changed by their turns in a period. */
static void put_rows(const struct orbit_curve *c, const double *u, int i, const struct shot *s,
                     double *f, double *jacobian)
{
    const int n = c->field->n, all = c->problem.n + 1, next = (i + 1) % c->segments;
    for (int k = 0; k < n; k++) {
        const struct vector_field *field = c->field;
        const int row = i * n + k;
        const double turned = next == 0 ? c->winding[k] * field->turn[k] : 0;
        f[row] = (s->end[k] - turned) / field->size[k] - u[next * n + k];
        for (int l = 0; l < n; l++)
            jacobian[row * all + i * n + l] += s->slopes.by_start[k * n + l];
        jacobian[row * all + next * n + k] -= 1;
        if (!c->forced)
            jacobian[row * all + c->segments * n] =
                s->last[k] * c->tsize * (c->share[i + 1] - c->share[i]);
        jacobian[row * all + all - 1] = s->slopes.by_parameter[0][k] * c->psize;
    }
}

/* Adds the equation that fixes the phase of an autonomous orbit. */
static void put_phase(const struct orbit_curve *c, const double *u, double *f, double *jacobian)
{
    const int n = c->field->n, row = c->segments * n, all = c->problem.n + 1;
    f[row] = 0;
    for (int k = 0; k < n; k++) {
        f[row] += c->normal[k] * (u[k] - c->reference[k]);
        jacobian[row * all + k] = c->normal[k];
    }
}

/* Computes the shooting equations f of a periodic orbit and their derivatives, jacobian, at the
 * unknowns u; context is the struct orbit_curve, in which the maps of the segments are stored.
 * Returns false if a segment cannot be followed or if cancelled. */
static bool residual(void *context, const double *u, double *f, double *jacobian)
{
    struct orbit_curve *c = context;
    struct vector_field *field = c->field;
    const int n = field->n, all = c->problem.n + 1;
    double p = u[all - 1] * c->psize;
    if (cancelled(field->cancel) || !field_set(field, &p))
        return false;
    const double period = orbit_curve_period(c, u),
                 drive_rate =
                     c->forced && !(c->drive > 0) ? c->multiple * field_drive_by(field, 0) : 0;
    if (!(period > 0) || !isfinite(period))
        return false;
    memset(jacobian, 0, (size_t)(c->problem.n * all) * sizeof *jacobian);
    c->log_determinant = 0;
    for (int i = 0; i < c->segments; i++) {
        struct shot s;
        if (!shoot_segment(c, u, i, period, &s))
            return false;
        memcpy(c->map + i * n * n, s.slopes.by_start, (size_t)(n * n) * sizeof *c->map);
        memcpy(c->rate + i * n, s.first, (size_t)n * sizeof *c->rate);
        c->growth[i] = 0;
        for (int k = 0; k < n * n; k++)
            c->growth[i] = fmax(c->growth[i], fabs(s.slopes.by_start[k]));
        c->log_determinant += s.slopes.log_determinant;
        add_drive(c, i, drive_rate, &s);
        put_rows(c, u, i, &s, f, jacobian);
    }
    if (!c->forced)
        put_phase(c, u, f, jacobian);
    return true;
}

/* Passes the maps of the segments, and their rates unless there is a drive, to
 * orbit_multipliers(). */
bool orbit_curve_multipliers(const struct orbit_curve *c, struct multipliers *multipliers)
{
    const struct orbit_maps maps = {.n = c->field->n,
                                    .segments = c->segments,
                                    .map = c->map,
                                    .rate = c->forced ? NULL : c->rate,
                                    .log_determinant = c->log_determinant};
    return orbit_multipliers(&maps, c->field->tol, multipliers);
}

/* Multiplies the maps of the segments. */
void orbit_curve_map(const struct orbit_curve *c, double *map)
{
    const int n = c->field->n;
    double product[FIELD_VARIABLES * FIELD_VARIABLES];
    memcpy(map, c->map, (size_t)(n * n) * sizeof *map);
    for (int i = 1; i < c->segments; i++) {
        matrix_multiply(n, c->map + i * n * n, map, product);
        memcpy(map, product, (size_t)(n * n) * sizeof *map);
    }
}

/* Computes the rates [segments][n] at the beginnings of the segments, in units of size. */
static void segment_rates(const struct orbit_curve *c, const double *u, double *rate)
{
    const int n = c->field->n;
    double y[FIELD_VARIABLES];
    const double period = orbit_curve_period(c, u);
    for (int i = 0; i < c->segments; i++) {
        state_of(c->field, u + i * n, y);
        rate_of(c->field, c->field->system.t0 + segment_start(c, i, period), y, rate + i * n);
    }
}

/* Computes the tests for folds, branch points, period doublings and Neimark-Sacker points. */
static void orbit_curve_test(void *context, const double *u, const double *jacobian,
                             const double *tangent, double *value)
{
    const struct orbit_curve *c = context;
    const int n = c->problem.n;
    double *bordered = c->problem.work->matrix;
    struct multipliers multipliers;
    (void)u;
    memcpy(bordered, jacobian, (size_t)(n * (n + 1)) * sizeof *bordered);
    memcpy(bordered + n * (n + 1), tangent, (size_t)(n + 1) * sizeof *bordered);
    /* Multipliers may have any sign if even the direction of motion is not preserved. */
    const bool known = orbit_curve_multipliers(c, &multipliers) &&
                       !(multipliers.trivial > TRIVIAL_MULTIPLIER_ERROR_MAX);
    value[ORBIT_FOLD] = tangent[n];
    value[ORBIT_CROSSING] = matrix_determinant(n + 1, bordered);
    value[ORBIT_DOUBLING] = known ? multipliers_doubling(&multipliers) : NAN;
    value[ORBIT_TORUS] = known ? multipliers_torus(&multipliers) : NAN;
}

/* Chooses the tolerance of the flows. */
static void orbit_curve_aim(void *context, bool fine)
{
    struct orbit_curve *c = context;
    c->field->tol = fine ? FINE_TOL : WALK_TOL;
}

/* Changes the tangent so that it leads to orbits of the present phase: all segments are shifted by
 * the same time. */
static void shift_tangent_phase(const struct orbit_curve *c, const double *u, double *tangent)
{
    const int n = c->field->n;
    double rate[CURVE_MAX] = {0}, normal_part = 0, normal_rate = 0;
    segment_rates(c, u, rate);
    for (int k = 0; k < n; k++) {
        normal_part += c->normal[k] * tangent[k];
        normal_rate += c->normal[k] * rate[k];
    }
    for (int i = 0; i < c->segments * n; i++)
        tangent[i] -= normal_part / normal_rate * rate[i];
    vector_normalise(c->problem.n + 1, tangent);
}

/* Returns by how much the period [s] may shrink before a segment of these shares has no length. */
static double shrink_room(const struct orbit_curve *c, double period, const double *share)
{
    double room = HUGE_VAL;
    for (int i = 0; i < c->segments; i++)
        room = fmin(room, segment_span(c, i, period) / fmax(share[i + 1] - share[i], 0));
    return room;
}

/* Computes shares in a change of the period, as share[i + 1] - share[i] for segment i: the slower
 * the motion at both of its ends, the larger. */
static void slow_shares(const struct orbit_curve *c, double period, const double *rate,
                        double *share)
{
    const int n = c->field->n, m = c->segments;
    share[0] = 0;
    for (int i = 0; i < m; i++) {
        const double speed =
            fmax(vector_length(n, rate + i * n), vector_length(n, rate + (i + 1) % m * n));
        share[i + 1] = share[i] + segment_span(c, i, period) / (speed * speed);
    }
    for (int i = 0; i < m; i++)
        share[i] /= share[m];
    share[m] = 1;
}

/* Compares the movement of states with and without shares that follow the speed of the motion. */
bool orbit_curve_stretch(struct orbit_curve *c, const double *u, double *direction)
{
    const int n = c->field->n, m = c->segments;
    const double period = orbit_curve_period(c, u);
    double rate[CURVE_MAX], share[CURVE_MAX], moved[CURVE_MAX];
    if (c->forced)
        return false;
    const double room = direction[m * n] < 0 ? SHRINK_ROOM_FRACTION * period : 0;
    segment_rates(c, u, rate);
    slow_shares(c, period, rate, share);
    if (!(shrink_room(c, period, share) > room))
        for (int i = 0; i < m; i++)
            share[i] = segment_start(c, i, period) / period;
    for (int i = 0; i < m; i++) {
        const double shift = (share[i] - c->share[i]) * direction[m * n] * c->tsize;
        for (int k = i * n; k < (i + 1) * n; k++)
            moved[k] = direction[k] + shift * rate[k];
    }
    if (!(vector_length(m * n, moved) < STRETCH_MIN_FRACTION * vector_length(m * n, direction)) &&
        shrink_room(c, period, c->share) > room)
        return false;
    for (int i = 1; i < m; i++) {
        c->fixed[i] = segment_start(c, i, period) - share[i] * period;
        c->share[i] = share[i];
    }
    memcpy(direction, moved, (size_t)(m * n) * sizeof *moved);
    vector_normalise(c->problem.n + 1, direction);
    return true;
}

/* Makes the orbit u the reference that fixes the phase of orbits to come: stores its state and the
 * direction of motion there (c->normal, of length 1). Converts `tangent`, unless NULL, to orbits of
 * that phase; orbits of driven scenes have their phase from the drive. */
void orbit_curve_refer(struct orbit_curve *c, const double *u, double *tangent)
{
    double y[FIELD_VARIABLES];
    memcpy(c->reference, u, sizeof c->reference);
    state_of(c->field, u, y);
    rate_of(c->field, c->field->system.t0, y, c->normal);
    vector_normalise(c->field->n, c->normal);
    if (tangent && !c->forced)
        shift_tangent_phase(c, u, tangent);
}

double orbit_curve_upright(const struct orbit_curve *c)
{
    const int n = c->field->n;
    double cosine = 0;
    for (int i = 0; i < n; i++)
        cosine += c->normal[i] * c->rate[i];
    return c->forced ? 1 : cosine / vector_length(n, c->rate);
}

/* Follows the motion from segment to segment, and counts the turns of angles. */
bool orbit_curve_unknowns(struct orbit_curve *c, const double *state, double period, double *u)
{
    struct vector_field *field = c->field;
    const int n = field->n;
    double y[FIELD_VARIABLES], end[FIELD_VARIABLES];
    memcpy(y, state, (size_t)n * sizeof *y);
    for (int i = 0; i < c->segments; i++) {
        for (int k = 0; k < n; k++)
            u[i * n + k] = y[k] / field->size[k];
        if (!field_flow(field, field->system.t0 + segment_start(c, i, period), y,
                        segment_span(c, i, period), end, NULL))
            return false;
        memcpy(y, end, sizeof y);
    }
    for (int k = 0; k < n; k++)
        c->winding[k] = field->turn[k] > 0 ? (int)lrint((y[k] - state[k]) / field->turn[k]) : 0;
    if (!c->forced)
        u[c->segments * n] = period / c->tsize;
    u[c->problem.n] = field->scene.value[field->param[0]] / c->psize;
    return true;
}

/* Finds when the segment begins, and follows the motion from its unknowns. */
bool orbit_curve_follow(const struct orbit_curve *c, const double *u, int segment, double *t,
                        double *span, double *grid)
{
    double y[FIELD_VARIABLES];
    const double period = orbit_curve_period(c, u);
    state_of(c->field, u + segment * c->field->n, y);
    *t = c->field->system.t0 + segment_start(c, segment, period);
    *span = segment_span(c, segment, period);
    return field_follow(c->field, *t, y, *span, grid);
}

/* Returns true if differences grow too much in segment i. */
static bool is_long(const struct orbit_curve *c, int i)
{
    return c->growth[i] > SEGMENT_GROWTH_MAX;
}

bool orbit_curve_is_long(const struct orbit_curve *c)
{
    bool any = false;
    for (int i = 0; i < c->segments; i++)
        any = any || is_long(c, i);
    return any && c->problem.n + 1 + c->field->n <= CURVE_MAX;
}

/* Computes the unknowns after the segments marked in `halved` are cut into two. Returns false if a
 * flow cannot be followed. */
static bool cut_unknowns(struct orbit_curve *c, const bool *halved, const double *u, double *cut)
{
    struct vector_field *field = c->field;
    const int n = field->n, m = c->segments, rest = !c->forced;
    double p = u[m * n + rest] * c->psize;
    if (!field_set(field, &p))
        return false;
    const double period = orbit_curve_period(c, u);
    int next = 0;
    for (int i = 0; i < m; i++) {
        double y[FIELD_VARIABLES], end[FIELD_VARIABLES];
        memcpy(cut + next++ * n, u + i * n, (size_t)n * sizeof *cut);
        if (!halved[i])
            continue;
        state_of(field, u + i * n, y);
        if (!field_flow(field, field->system.t0 + segment_start(c, i, period), y,
                        segment_span(c, i, period) / 2, end, NULL))
            return false;
        for (int k = 0; k < n; k++)
            cut[next * n + k] = end[k] / field->size[k];
        next++;
    }
    memcpy(cut + next * n, u + m * n, (size_t)(rest + 1) * sizeof *cut);
    return true;
}

/* Cuts the segments marked in `halved` into two. */
static void cut_shares(struct orbit_curve *c, const bool *halved)
{
    double share[CURVE_MAX], fixed[CURVE_MAX];
    int next = 0;
    for (int i = 0; i < c->segments; i++) {
        fixed[next] = c->fixed[i];
        share[next++] = c->share[i];
        if (!halved[i])
            continue;
        fixed[next] = (c->fixed[i] + c->fixed[i + 1]) / 2;
        share[next++] = (c->share[i] + c->share[i + 1]) / 2;
    }
    fixed[next] = 0;
    share[next] = 1;
    memcpy(c->fixed, fixed, sizeof fixed);
    memcpy(c->share, share, sizeof share);
    c->problem.n += (next - c->segments) * c->field->n;
    c->segments = next;
}

#define DIFFERENCE_STEP_UNITS 1e-6 /* step of a difference, in the unknowns' units */

/* Converts the direction by cutting a second orbit, displaced along it. */
bool orbit_curve_cut(struct orbit_curve *c, double *u, double *direction)
{
    double aside[CURVE_MAX], cut[2][CURVE_MAX];
    bool halved[CURVE_MAX] = {false};
    for (int i = 0, n = c->problem.n; i < c->segments; i++) {
        halved[i] = is_long(c, i) && n + 1 + c->field->n <= CURVE_MAX;
        n += halved[i] ? c->field->n : 0;
    }
    for (int i = 0; i <= c->problem.n; i++)
        aside[i] = u[i] + DIFFERENCE_STEP_UNITS * direction[i];
    if (!cut_unknowns(c, halved, u, cut[0]) || !cut_unknowns(c, halved, aside, cut[1]))
        return false;
    cut_shares(c, halved);
    memcpy(u, cut[0], sizeof cut[0]);
    for (int i = 0; i <= c->problem.n; i++)
        direction[i] = cut[1][i] - cut[0][i];
    vector_normalise(c->problem.n + 1, direction);
    return true;
}

/* Returns the number of segments, from the growth of small differences over a period, or 0 if the
 * flow cannot be followed. */
static int segments_for(struct vector_field *field, const double *state, double period)
{
    double end[FIELD_VARIABLES], size = 0;
    struct flow_slopes slopes;
    if (!field_flow(field, field->system.t0, state, period, end, &slopes))
        return 0;
    for (int i = 0; i < field->n * field->n; i++)
        size = fmax(size, fabs(slopes.by_start[i]));
    const int most = (CURVE_MAX - 2) / field->n,
              wanted = SEGMENTS_MIN + (int)(log(fmax(size, 1)) / log(NEW_SEGMENT_GROWTH_MAX));
    return wanted < most ? wanted : most;
}

/* Chooses the number of segments from the growth of differences, all of equal length at first. */
bool orbit_curve_init(struct orbit_curve *c, struct vector_field *field, double psize,
                      const double *state, double period, int multiple)
{
    const double drive = field_drive(field);
    *c = (struct orbit_curve){
        .field = field, .forced = drive != 0, .multiple = multiple, .psize = psize};
    field->unit[0] = psize;
    if (c->forced)
        period = multiple * drive;
    if (!(period > 0) || !isfinite(period))
        return false;
    /* a drive that does not depend on the parameter keeps its period even where its strength is
     * 0 */
    c->drive = c->forced && field_drive_by(field, 0) == 0 ? drive : 0;
    c->tsize = period;
    c->segments = segments_for(field, state, period);
    if (c->segments == 0)
        return false;
    for (int i = 0; i <= c->segments; i++)
        c->share[i] = (double)i / c->segments;
    c->problem = (struct curve_problem){.context = c,
                                        .n = c->segments * field->n + !c->forced,
                                        .residual = residual,
                                        .test = orbit_curve_test,
                                        .tests = 4,
                                        .aim = orbit_curve_aim,
                                        .singular = 1u << ORBIT_CROSSING};
    return true;
}
