/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Trajectories in the plane of a portrait, and separatrices, which leave saddles along their
 * eigenvectors. These begin at an offset of 1e-6 of the box; their error across the eigenvector, of
 * second order, shrinks on the way. */
#include <hooke/base/numeric.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/portrait/portrait.h"

#define START_OFFSET_FRACTION 1e-6 /* offset of the start as a part of the box */
#define POINT_STRIDE_FRACTION 0.02 /* distance between points as a part of the box */
/* An equilibrium is reached within this part of the box. */
#define EQUILIBRIUM_REACHED_FRACTION 1e-3
#define SEPARATRIX_POINTS_MAX 1500 /* largest number of points of a separatrix */
#define FRAME_MARGIN_FRACTION 1e-9 /* rounding of the frame as a part of the box */

/* A trajectory that is being followed across the plane. */
struct plane_walk {
    struct portrait_work *work;
    double y[LIMIT_VARIABLES], rate[LIMIT_VARIABLES], t; /* state, its rates, time [s] */
    double width[2];                                     /* width and height of the box, SI */
    bool wraps[2];   /* true for an angle whose range is one turn */
    int sign;        /* direction of time: 1 or -1 */
    double rate_max; /* [1/s] rate that limits the steps, or 0 for no limit */
    struct polyline *line;
    struct separatrix *separatrix; /* NULL for a trajectory */
};

/* Returns the index of the variable across (k = 0) or up (1). */
static int variable_of(const struct plane_walk *w, int k)
{
    return w->work->request->variable[k];
}

/* Computes the rates at the present state. */
static void rate_here(struct plane_walk *w)
{
    system_derivative(&w->work->field.system, w->t, w->y, w->rate);
}

/* Returns the time [s], negative backwards, to the next point: about POINT_STRIDE_FRACTION of the
 * box. */
static double walk_stride(const struct plane_walk *w)
{
    double speed = 0;
    for (int k = 0; k < 2; k++)
        speed = fmax(speed, fabs(w->rate[variable_of(w, k)]) / w->width[k]);
    const double calm = w->rate_max > 0 ? 0.5 / w->rate_max : HUGE_VAL;
    return w->sign * fmin(speed > 0 ? POINT_STRIDE_FRACTION / speed : HUGE_VAL, calm);
}

/* Moves plotted variables that are angles and have left their range back into it by whole turns.
 * Returns true if one has moved, so that the line needs a gap there. */
static bool plane_angle_wrap(struct plane_walk *w)
{
    bool turned = false;
    for (int k = 0; k < 2; k++) {
        const double *range = w->work->request->box[k];
        double *y = &w->y[variable_of(w, k)];
        while (w->wraps[k] && (*y > range[1] || *y < range[0])) {
            *y += *y > range[1] ? -w->width[k] : w->width[k];
            turned = true;
        }
    }
    return turned;
}

/* Returns true if the state is outside of the box. */
static bool is_outside(const struct plane_walk *w)
{
    for (int k = 0; k < 2; k++) {
        const double *range = w->work->request->box[k], y = w->y[variable_of(w, k)];
        if (!(y >= range[0] - FRAME_MARGIN_FRACTION * w->width[k] &&
              y <= range[1] + FRAME_MARGIN_FRACTION * w->width[k]))
            return true;
    }
    return false;
}

/* Returns the distance in the plane from a state, as a fraction of the box; for angles the shorter
 * way around. */
static double plane_distance(const struct plane_walk *w, const double *state)
{
    double far = 0;
    for (int k = 0; k < 2; k++) {
        double difference = w->y[variable_of(w, k)] - state[variable_of(w, k)];
        if (w->wraps[k])
            difference = remainder(difference, w->width[k]);
        far = fmax(far, fabs(difference) / w->width[k]);
    }
    return far;
}

/* Returns the index of the equilibrium that the trajectory has reached, other than `except`, or
 * -1. */
static int reached_equilibrium(const struct plane_walk *w, int except)
{
    const struct equilibria *found = &w->work->portrait->found;
    for (int e = 0; e < found->count; e++)
        if (e != except &&
            plane_distance(w, found->solution[e].state) < EQUILIBRIUM_REACHED_FRACTION)
            return e;
    return -1;
}

/* ---- crossings ---- */

/* Records the crossing at which variable k has this value, between the previous state and the one
 * `span` later. */
static void record_crossing(struct plane_walk *w, const double *previous, double span, int k,
                            double value)
{
    struct separatrix *s = w->separatrix;
    struct field_plane plane = {.normal = {0}};
    double point[LIMIT_VARIABLES];
    plane.origin[variable_of(w, k)] = value;
    plane.normal[variable_of(w, k)] = 1;
    const double when = field_crossing(&w->work->field, w->t, previous, span, w->y, &plane, point);
    if (isfinite(when) && s->crossings < CROSSINGS_MAX)
        s->crossing[s->crossings++] =
            (struct portrait_crossing){k, value, point[variable_of(w, !k)]};
}

/* Records crossings with the lines variable = value through all equilibria, and through 0, between
 * the previous state and the present one, `span` [s] later. Values that are the same but for
 * rounding count once; a walk that begins on such a line does not cross it there. */
static void look_for_crossings(struct plane_walk *w, const double *previous, double span)
{
    const struct equilibria *found = &w->work->portrait->found;
    for (int k = 0; k < 2; k++) {
        double seen[64];
        int count = 0;
        for (int e = -1; e < found->count && count < 64; e++) { /* and 0 */
            const double value = e < 0 ? 0 : found->solution[e].state[variable_of(w, k)];
            const double a = previous[variable_of(w, k)] - value,
                         b = w->y[variable_of(w, k)] - value;
            bool known = false;
            for (int i = 0; i < count; i++)
                known = known || fabs(seen[i] - value) <= 1e-9 * w->width[k];
            seen[count++] = value;
            if (!known && ((a < 0) != (b < 0)) &&
                fabs(a) > 10 * START_OFFSET_FRACTION * w->width[k])
                record_crossing(w, previous, span, k, value);
        }
    }
}

/* ---- trajectories ---- */

/* Outcome of one step of a trajectory: goes on, has left the box, has reached an equilibrium, out
 * of memory. */
enum walk_end { WALK_ON, WALK_FRAME, WALK_REST, WALK_MEMORY };

/* Follows the trajectory for `span` [s], negative if backwards, and appends the point there, after
 * a gap if an angle has passed the end of its range. Equilibrium number `except` (-1 for none),
 * which the walk has not left yet, does not end it. Returns whether and why the walk ends. */
static enum walk_end walk_advance(struct plane_walk *w, double span, int except)
{
    double previous[LIMIT_VARIABLES];
    memcpy(previous, w->y, sizeof previous);
    if (!field_flow(&w->work->field, w->t, previous, span, w->y, NULL))
        return WALK_FRAME;
    if (w->separatrix)
        look_for_crossings(w, previous, span);
    if (!polyline_put(w->line, w->y[variable_of(w, 0)], w->y[variable_of(w, 1)]))
        return WALK_MEMORY;
    w->t += span;
    if (plane_angle_wrap(w) &&
        (!polyline_gap(w->line) ||
         !polyline_put(w->line, w->y[variable_of(w, 0)], w->y[variable_of(w, 1)])))
        return WALK_MEMORY;
    if (is_outside(w))
        return WALK_FRAME;
    const int target = reached_equilibrium(w, except);
    if (w->separatrix)
        w->separatrix->target = target;
    return target >= 0 ? WALK_REST : WALK_ON;
}

/* Sets up a trajectory, whose state, line and direction the caller sets. */
static void begin_plane_walk(struct plane_walk *w, struct portrait_work *work)
{
    *w = (struct plane_walk){.work = work, .sign = 1, .t = work->request->t};
    for (int k = 0; k < 2; k++) {
        const double *range = work->request->box[k], turn = work->field.turn[variable_of(w, k)];
        w->width[k] = range[1] - range[0];
        w->wraps[k] = turn > 0 && fabs(w->width[k] - turn) <= 1e-6 * turn;
    }
}

/* Follows the separatrix of equilibrium e that starts along the eigenvector of eigenvalue number
 * `value`; `side` is 1 or -1 for its two directions. Stable ones are followed backwards in time.
 * Adds the line and a description to the portrait, with where it ends: at the frame, at an
 * equilibrium, or "goes on". Returns false if out of memory. */
static bool follow_separatrix(struct portrait_work *work, int e, int value, int side)
{
    struct portrait *portrait = work->portrait;
    const struct solution *equilibrium = &portrait->found.solution[e];
    struct separatrix *more =
        realloc(portrait->separatrix, ((size_t)portrait->separatrices + 1) * sizeof *more);
    if (!more)
        return false;
    portrait->separatrix = more;
    struct separatrix *s = &more[portrait->separatrices++];
    *s = (struct separatrix){e, equilibrium->value[value].re < 0, side, "goes on", -1, 0, {{0}}};
    struct plane_walk w;
    begin_plane_walk(&w, work);
    w.sign = s->stable ? -1 : 1;
    w.rate_max = fabs(equilibrium->value[value].re);
    w.separatrix = s;
    w.line = &portrait->line[s->stable ? PORTRAIT_SEPARATRIX : PORTRAIT_SEPARATRIX_UNSTABLE];
    double size = 0;
    for (int k = 0; k < 2; k++)
        size = fmax(size, fabs(portrait->found.form[e].re[value][variable_of(&w, k)]) / w.width[k]);
    for (int i = 0; i < work->field.n; i++)
        w.y[i] = equilibrium->state[i] + side * START_OFFSET_FRACTION / (size > 0 ? size : 1) *
                                             portrait->found.form[e].re[value][i];
    if (!polyline_put(w.line, equilibrium->state[variable_of(&w, 0)],
                      equilibrium->state[variable_of(&w, 1)]))
        return false;
    if (plane_angle_wrap(&w) &&
        (!polyline_gap(w.line) ||
         !polyline_put(w.line, w.y[variable_of(&w, 0)], w.y[variable_of(&w, 1)])))
        return false;
    enum walk_end end = WALK_ON;
    bool away = false;
    for (int i = 0;
         i < SEPARATRIX_POINTS_MAX && end == WALK_ON && !cancelled(work->request->cancel); i++) {
        rate_here(&w);
        end = walk_advance(&w, walk_stride(&w), away ? -1 : e);
        away = away || plane_distance(&w, equilibrium->state) > 10 * EQUILIBRIUM_REACHED_FRACTION;
    }
    s->end = "goes on";
    if (end == WALK_FRAME || end == WALK_REST)
        s->end = end == WALK_FRAME ? "frame" : "equilibrium";
    return end != WALK_MEMORY && polyline_gap(w.line);
}

/* Only real eigenvalues of saddles that are the only growing or the only decaying one have a
 * separatrix; it has two sides. Returns false if out of memory. */
bool portrait_separatrices(struct portrait_work *work)
{
    const struct equilibria *found = &work->portrait->found;
    for (int e = 0; e < found->count; e++) {
        const struct solution *s = &found->solution[e];
        if (found->form[e].type != EQUILIBRIUM_SADDLE)
            continue;
        int growing = 0, decaying = 0;
        for (int k = 0; k < s->values; k++) {
            growing += s->value[k].re > 0;
            decaying += s->value[k].re < 0;
        }
        for (int k = 0; k < s->values; k++)
            for (int side = 1; side >= -1; side -= 2)
                if (s->value[k].im == 0 && s->value[k].re != 0 &&
                    (s->value[k].re > 0 ? growing : decaying) == 1 &&
                    !cancelled(work->request->cancel) && !follow_separatrix(work, e, k, side))
                    return false;
    }
    return true;
}

/* Appends the trajectory from the state `start` for `span` [s], negative if backwards, to *line,
 * with a gap behind. A scene that cannot be followed gives no line, which is no error. Returns
 * false if out of memory. */
bool portrait_trajectory(const struct portrait_request *request, const double *start, double span,
                         struct polyline *line)
{
    struct portrait none = {.cancelled = false};
    struct portrait_work work = {.request = request, .portrait = &none};
    struct plane_walk w;
    struct error ignored;
    if (!field_init(&work.field, request->scene, NULL, 0, &ignored))
        return true;
    work.field.cancel = request->cancel;
    work.field.tol = 1e-9;
    begin_plane_walk(&w, &work);
    memcpy(w.y, start, (size_t)work.field.n * sizeof *start);
    w.sign = span < 0 ? -1 : 1;
    w.line = line;
    plane_angle_wrap(&w);
    bool fine = polyline_put(line, w.y[variable_of(&w, 0)], w.y[variable_of(&w, 1)]);
    enum walk_end end = WALK_ON;
    for (double gone = 0; fine && end == WALK_ON && gone < fabs(span) &&
                          line->n < 20 * SEPARATRIX_POINTS_MAX && !cancelled(request->cancel);) {
        rate_here(&w);
        double step = walk_stride(&w);
        if (!(fabs(step) < fabs(span) - gone))
            step = w.sign * (fabs(span) - gone);
        gone += fabs(step);
        end = walk_advance(&w, step, -1);
        fine = end != WALK_MEMORY;
    }
    field_free(&work.field);
    return fine && polyline_gap(line);
}
