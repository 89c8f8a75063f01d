/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Follows a branch of equilibria or periodic orbits step by step, with its special points
 * (branch_follow). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "modules/dynamics/branches/walk.h"
#define FIRST_STEP_LENGTH 0.01 /* arclength of the first step, in units of the range */
#define STEP_LENGTH_MAX 0.05   /* longest step, in units of the range */
#define STEP_MIN_FRACTION 1e-7 /* shortest step as a part of the longest */
/* Shorter steps, relative to the longest, are not halved to separate pairs of special points. */
#define UNRESOLVED_STEP_FRACTION 1e-4
/* An obstacle that stops the shortest step is nearer than this part of the longest one. */
#define OBSTACLE_DISTANCE_FRACTION 0.01
#define STEP_TURN_COSINE_MIN 0.94 /* cosine of the angle by which a step may turn: 20 degrees */
#define PERIOD_GROWTH_MAX 25 /* times the first period: the orbit nears one that takes for ever */
#define DRIVE_PERIOD_GROWTH_MAX 100 /* the same of a drive that stops within the range */
/* Part of the parameter in a tangent that does not change it. */
#define VERTICAL_TANGENT_PARAM 1e-7
#define VERTICAL_STEPS_MAX 12 /* steps of this kind in a row that end the branch */
/* The parameter hardly changes along a tangent with a smaller part of it. */
#define NEARLY_VERTICAL_TANGENT_PARAM 1e-4
#define BRANCH_POINTS_DEFAULT 1000
/* An orbit below this part of its largest extent is nearly an equilibrium. */
#define SHRUNK_ORBIT_FRACTION 2e-3
#define ORBIT_PARAM_ROUNDING 1e-9        /* relative change that is rounding, along orbits */
#define EQUILIBRIUM_PARAM_ROUNDING 1e-13 /* the same on branches of equilibria */

/* ---- the walk ---- */

/* Returns true if a step turns little and has converged quickly. */
static bool is_good_step(const struct curve_problem *problem, const struct curve_place *current,
                         const struct curve_place *next)
{
    double cosine = 0;
    for (int i = 0; i <= problem->n; i++)
        cosine += current->tangent[i] * next->tangent[i];
    return cosine >= STEP_TURN_COSINE_MIN && next->corrections <= 5;
}

/* Returns the longest step at a place: the parameter changes by at most `longest` of its range, the
 * state by at most three times that part of its size. */
static double longest_step_at(const struct branch_walk *w, const struct curve_place *point,
                              double longest)
{
    const int n = w->path->problem->n;
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += point->tangent[i] * point->tangent[i];
    return fmin(longest / fabs(point->tangent[n]),
                3 * longest * curve_unit(n, point->u) / sqrt(sum));
}

/* Halves *step [length in the space of unknowns] until the step converges, turns little and, if
 * `resolves` is given, changes the sign of no test twice; that last condition is given up below
 * UNRESOLVED_STEP_FRACTION of `longest`. Returns false if *step becomes shorter than
 * STEP_MIN_FRACTION of `longest`, or if cancelled. `previous`, if given, lets the guess follow the
 * bend of the curve. */
bool curve_next(const struct curve_problem *problem, const struct curve_place *previous,
                const struct curve_place *current, double *step, double longest,
                struct branch_walk *resolves, const struct cancel *cancel, struct curve_place *next)
{
    for (; *step > STEP_MIN_FRACTION * longest; *step /= 2) {
        if (cancelled(cancel))
            return false;
        if (curve_step(problem, previous, current, *step, next) &&
            is_good_step(problem, current, next) &&
            (!resolves || *step < UNRESOLVED_STEP_FRACTION * longest ||
             step_is_resolved(resolves, current, next)))
            return true;
    }
    return false;
}

/* Returns true if the parameter changes the drive's period and its range contains 0, where the
 * drive may stop. */
static bool drive_stops(const struct branch_walk *w)
{
    return w->path->kind == SOLUTION_RESPONSE && !(w->path->orbit.drive > 0) &&
           w->request->low <= 0 && w->request->high >= 0;
}

/* Returns true if the period has grown so much that it seems to be unbounded. */
static bool is_period_unbounded(struct branch_walk *w, const struct curve_place *point)
{
    if (w->path->kind != SOLUTION_ORBIT && !drive_stops(w))
        return false;
    const double period = orbit_curve_period(&w->path->orbit, point->u);
    if (!(w->period > 0))
        w->period = period;
    if (w->path->kind == SOLUTION_RESPONSE)
        return period > DRIVE_PERIOD_GROWTH_MAX * w->period;
    return period > PERIOD_GROWTH_MAX * w->period &&
           fabs(point->tangent[w->path->problem->n]) < NEARLY_VERTICAL_TANGENT_PARAM;
}

/* Returns true if solutions change at a constant parameter, as in a family of orbits of
 * conservative motion. */
static bool is_family_step(const struct branch_walk *w, const struct curve_place *point)
{
    const struct solution *s = &w->branch->point[w->branch->count - 1].solution;
    bool one = w->path->kind == SOLUTION_EQUILIBRIUM;
    for (int i = 0; i < s->values; i++)
        one = one || hypot(s->value[i].re - 1, s->value[i].im) < 1e-6;
    return one && fabs(point->tangent[w->path->problem->n]) < VERTICAL_TANGENT_PARAM;
}

/* Cuts an orbit into more segments if differences grow too much along one, and corrects *point, now
 * with more unknowns; the walk goes on from there without its memory of the place before.
 * Equilibria need none of this. Returns false if that fails. */
static bool orbit_segments_refine(struct branch_walk *w, struct curve_place *point)
{
    if (w->path->kind == SOLUTION_EQUILIBRIUM || !orbit_curve_is_long(&w->path->orbit))
        return true;
    double u[CURVE_MAX], direction[CURVE_MAX];
    memcpy(u, point->u, sizeof u);
    memcpy(direction, point->tangent, sizeof direction);
    if (!orbit_curve_cut(&w->path->orbit, u, direction) ||
        !curve_correct(w->path->problem, u, direction, false, point))
        return false;
    walk_go_on(w, point);
    w->bends = false;
    return true;
}

/* Redistributes the time of an autonomous orbit over its segments, unless the parameter hardly
 * changes. */
static void stretch_orbit(struct branch_walk *w, struct curve_place *point)
{
    if (w->path->kind != SOLUTION_ORBIT ||
        fabs(point->tangent[w->path->problem->n]) < NEARLY_VERTICAL_TANGENT_PARAM ||
        !orbit_curve_stretch(&w->path->orbit, point->u, point->tangent))
        return;
    walk_go_on(w, point);
    w->bends = false;
}

/* Stores the reason of the end of the walk. */
static void branch_end_set(struct branch_walk *w, const char *why)
{
    snprintf(w->end, 96, "%s", why);
}

/* Returns the distance of two places by the first state, the period and the parameter, whose
 * indices are a_last and b_last: the numbers of segments may differ. */
static double place_distance(const struct branch_walk *w, const struct curve_place *a, int a_last,
                             const struct curve_place *b, int b_last)
{
    const double period = w->path->kind == SOLUTION_ORBIT ? a->u[a_last - 1] - b->u[b_last - 1] : 0;
    return hypot(hypot(a->u[a_last] - b->u[b_last], period),
                 curve_distance(w->path->field.n, a->u, b->u));
}

/* Returns true if a step ends near the start of the branch, or passes it, after the walk has been
 * elsewhere. A start half way along the step is nearer than half of it from neither end. */
static bool has_returned(struct branch_walk *w, const struct curve_place *point,
                         const struct curve_place *next, const struct curve_place *start)
{
    const int last = w->path->problem->n;
    /* The way along a step may be longer than its chord by this factor. */
    static const double detour = 1.1;
    const double far = place_distance(w, next, last, start, w->start),
                 step = place_distance(w, next, last, point, last),
                 last_distance = place_distance(w, point, last, start, w->start);
    w->away = w->away || far > 2 * step;
    return w->away && (far < step / 2 || last_distance + far < detour * step);
}

/* Returns the extent of the last orbit, in natural sizes, relative to the largest so far. */
static double relative_extent(const struct branch_walk *w)
{
    const struct branch *b = w->branch;
    double last = 0, largest = 0;
    for (int k = 0; k < b->count; k++) {
        const struct solution *s = &b->point[k].solution;
        last = 0;
        for (int i = 0; i < s->n; i++)
            last = fmax(last, (s->top[i] - s->bottom[i]) / w->path->field.size[i]);
        largest = fmax(largest, last);
    }
    return last / largest;
}

/* Ends the walk at its last point, which is labelled as an end. Returns true. */
static bool end_walk(struct branch_walk *w, const char *why)
{
    w->branch->point[w->branch->count - 1].special = SPECIAL_END;
    branch_end_set(w, why);
    return true;
}

/* Ends the walk at its last point, without a label. If cancelled, that point is labelled as an end,
 * so that the branch can be continued there, unless it is a special point. Returns true. */
static bool fail_walk(struct branch_walk *w, const char *why)
{
    const bool stopped = cancelled(w->request->cancel);
    struct branch_point *last = &w->branch->point[w->branch->count - 1];
    if (stopped && last->special == SPECIAL_NONE)
        last->special = SPECIAL_END;
    branch_end_set(w, stopped ? "cancelled" : why);
    return true;
}

/* If the parameter changes by rounding only, its turns are rounding, too, and not folds. */
static void forget_turns(struct branch_walk *w)
{
    struct branch_point *point = w->branch->point;
    const double there = point[w->branch->count - 1].solution.param[0];
    for (int i = w->branch->count - 1; i >= 0; i--) {
        if (fabs(point[i].solution.param[0] - there) > 1e-12 * w->psize)
            return;
        if (point[i].special == SPECIAL_FOLD || point[i].special == SPECIAL_CROSSING)
            point[i].special = SPECIAL_NONE;
    }
}

/* Unmarks folds near one end of a branch, the first point (direction 1) or the last (-1), from
 * which on the parameter is constant but for rounding, as near a homoclinic orbit. */
static void forget_last_turns(struct branch *b, int direction)
{
    const bool still = b->kind == SOLUTION_EQUILIBRIUM;
    const double rounding = still ? EQUILIBRIUM_PARAM_ROUNDING : ORBIT_PARAM_ROUNDING;
    const int first = direction > 0 ? 0 : b->count - 1;
    const double there = b->count > 0 ? b->point[first].solution.param[0] : 0;
    for (int i = first; i >= 0 && i < b->count; i += direction) {
        if (!(fabs(b->point[i].solution.param[0] - there) <= rounding * fabs(there)))
            return;
        if (b->point[i].special == SPECIAL_FOLD)
            b->point[i].special = SPECIAL_NONE;
    }
}

/* Unmarks special points that the last step of a closed branch has found again beyond its start. */
static void unmark_repeats(struct branch_walk *w)
{
    static const double same = 1e-6; /* largest distance, in natural sizes and parts of the range */
    struct branch *b = w->branch;
    const double psize = w->request->high - w->request->low;
    for (int i = 1; i < b->count; i++)
        for (int j = 0; j < i && b->point[i].special != SPECIAL_NONE; j++) {
            const struct solution *p = &b->point[i].solution, *q = &b->point[j].solution;
            double far = fabs(p->param[0] - q->param[0]) / psize;
            for (int k = 0; k < w->path->field.n; k++)
                far = fmax(far, fabs(p->state[k] - q->state[k]) / w->path->field.size[k]);
            if (b->point[i].special == b->point[j].special && far < same)
                b->point[i].special = SPECIAL_NONE;
        }
}

/* Returns true, with the reason stored, if the branch ends with the point that has been recorded:
 * at the edge of the range (`leaves`), in a family of orbits at one parameter value, where the
 * period grows without bound, or back at `start`. The step went from `point` to `next`. */
static bool is_over(struct branch_walk *w, const struct curve_place *point,
                    const struct curve_place *next, const struct curve_place *start, bool leaves)
{
    const struct branch_request *r = w->request;
    double *value = &w->branch->point[w->branch->count - 1].solution.param[0];
    if (leaves) {
        *value = fabs(*value - r->low) < fabs(*value - r->high) ? r->low : r->high;
        return end_walk(w, "end of the range");
    }
    w->level = is_family_step(w, next) ? w->level + 1 : 0;
    if (w->level == VERTICAL_STEPS_MAX) {
        forget_turns(w);
        return end_walk(w, "a family of orbits at one parameter value");
    }
    if (is_period_unbounded(w, next))
        return end_walk(w, "the period grows without bound");
    if (!has_returned(w, point, next, start))
        return false;
    w->branch->closed = true;
    unmark_repeats(w);
    branch_end_set(w, "the branch closes");
    return true;
}

/* Reports the fraction of the parameter's range, or of the number of points, that is done. */
static void branch_progress_report(struct branch_walk *w, const struct curve_place *point,
                                   const struct curve_place *start, int points, int max)
{
    const struct branch_request *r = w->request;
    const int p = w->path->problem->n;
    const double begin = start->u[p] * w->psize, change = point->u[p] * w->psize - begin,
                 ahead = change > 0 ? r->high - begin : begin - r->low;
    const double part = fmin(fmax(ahead > 0 ? fabs(change) / ahead : 0, 1.0 * points / max), 1);
    w->told = fmax(w->told, FOLLOWING_TIME_FRACTION * (w->side + part) / w->sides);
    if (r->progress)
        r->progress(r->context, w->told);
}

/* Returns true if the equations jump along the orbit. */
static bool orbit_jumps(struct branch_walk *w, const struct solution *s)
{
    struct vector_field *field = &w->path->field;
    return w->path->kind != SOLUTION_EQUILIBRIUM &&
           field_jumps(field, field->system.t0, s->state, s->period);
}

/* Returns true if the orbit meets a jump just beyond `point`, in the direction of its tangent, up
 * to OBSTACLE_DISTANCE_FRACTION of the `longest` step. Then a jump is why no further step was
 * possible, even if rounding let a correction get across it. */
static bool jumps_ahead(struct branch_walk *w, const struct curve_place *point, double longest)
{
    if (w->path->kind == SOLUTION_EQUILIBRIUM || w->path->field.system.switches == 0)
        return false;
    double distance = STEP_MIN_FRACTION * longest;
    while (distance < OBSTACLE_DISTANCE_FRACTION * longest) {
        struct curve_place ahead = *point;
        struct solution s;
        for (int i = 0; i <= w->path->problem->n; i++)
            ahead.u[i] += distance * point->tangent[i];
        if (!solutions_seen(w->path, &ahead, &s))
            return false;
        if (orbit_jumps(w, &s))
            return true;
        distance *= 2;
    }
    return false;
}

/* Ends the walk at a place from which no step leads on. */
static bool walk_stop(struct branch_walk *w, const struct curve_place *point, double longest)
{
    if (!cancelled(w->request->cancel) && jumps_ahead(w, point, longest))
        return end_walk(w, BRANCH_JUMP);
    return fail_walk(w, "no further step is possible");
}

/* Follows the branch from `point`, which is recorded already. Returns false if out of memory. */
static bool branch_walk_follow(struct branch_walk *w, struct curve_place point)
{
    const double longest = w->request->step > 0 ? w->request->step : STEP_LENGTH_MAX;
    const int max = w->request->max > 0 ? w->request->max : BRANCH_POINTS_DEFAULT;
    const struct curve_place start = point;
    w->level = 0;
    w->bends = false;
    w->moved = 1;
    w->away = false;
    w->start = w->path->problem->n;
    double step = fmin(FIRST_STEP_LENGTH, longest);
    walk_start(w, &point);
    branch_end_set(w, w->request->max > 0 ? "the requested number of points"
                                          : "1000 points (max=N allows more)");
    for (int i = 0; i < max; i++) {
        struct curve_place next;
        const double far = longest_step_at(w, &point, longest);
        branch_progress_report(w, &point, &start, i, max);
        step = fmin(step, far);
        if (!curve_next(w->path->problem, w->bends ? &w->previous : NULL, &point, &step, far, w,
                        w->request->cancel, &next))
            return walk_stop(w, &point, far);
        const double upright =
            w->path->kind == SOLUTION_EQUILIBRIUM ? 1 : orbit_curve_upright(&w->path->orbit);
        if (upright < 0) { /* The step has passed the equilibrium, or changed the phase. */
            step /= 2;
            if (step > STEP_MIN_FRACTION * far && relative_extent(w) > SHRUNK_ORBIT_FRACTION) {
                i--;
                continue;
            }
            return end_walk(w, relative_extent(w) > SHRUNK_ORBIT_FRACTION
                                   ? "no further step is possible"
                                   : "it shrinks to an equilibrium");
        }
        const bool leaves = !ranges_contain(&w->ranges, w->path->problem, &next);
        if (leaves) { /* special points before the edge are recorded first */
            struct solution reference;
            const bool seen = solutions_seen(w->path, &next, &reference);
            if (!walk_record_specials(w, &next, seen ? &reference : NULL))
                return false;
            if (!ranges_step_to_edge(&w->ranges, w->path->problem, &point, &next))
                return w->branch->point[w->branch->count - 1].special != SPECIAL_NONE ||
                               cancelled(w->request->cancel)
                           ? fail_walk(w, "end of the range")
                           : end_walk(w, "no step reaches the end of the range");
        }
        const int p = w->path->problem->n;
        if (i == 0) {
            w->opposite = next;
            w->behinds = p;
        }
        w->moved = point.careful && next.careful
                       ? fabs(next.u[p] - point.u[p]) / fmax(fabs(point.u[p]), CURVE_LEVEL)
                       : 0;
        struct solution solution;
        if (!solutions_seen(w->path, &next, &solution))
            return fail_walk(w, "the solution there is unknown");
        if (i == 0)
            w->behind_grows = walk_grows(w, &solution);
        const int index = w->branch->count - 1;
        if (!leaves && (!walk_record_specials(w, &next, &solution) ||
                        (w->bends && !walk_record_pairs(w, &w->previous, &point, index, &next))))
            return false;
        if (cancelled(w->request->cancel)) /* special points may be missing */
            return fail_walk(w, "");
        if (!branch_append(w->branch, w->path, &next, leaves ? SPECIAL_END : SPECIAL_NONE,
                           &solution))
            return false;
        if (is_over(w, &point, &next, &start, leaves))
            return true;
        if (orbit_jumps(w, &solution))
            return end_walk(w, BRANCH_JUMP);
        w->previous = point;
        w->bends = w->path->kind == SOLUTION_EQUILIBRIUM || upright > STEP_TURN_COSINE_MIN;
        if (!w->bends)
            orbit_curve_refer(&w->path->orbit, next.u, next.tangent);
        if (next.corrections <= 3)
            step = fmin(1.5 * step, far);
        point = next;
        stretch_orbit(w, &point);
        if (!orbit_segments_refine(w, &point))
            return fail_walk(w, "small differences grow too much along the orbit");
    }
    return true;
}

void branch_reverse(struct branch *b)
{
    for (int i = 0; i < b->count / 2; i++) {
        const struct branch_point swap = b->point[i];
        b->point[i] = b->point[b->count - 1 - i];
        b->point[b->count - 1 - i] = swap;
    }
}

/* Walks from the start in one or both directions; the points of the first are reversed, so that all
 * are in order. */
bool branch_follow(const struct branch_request *r, struct branch *branch, struct error *error)
{
    if (r->second)
        return special_follow(r, branch, error);
    const int64_t start_time = clock_ns();
    const double psize = r->high - r->low;
    *branch = (struct branch){.count = 0};
    struct solution_curve *path = malloc(sizeof *path); /* it is large, and the walk goes deep */
    if (!path)
        return error_memory(error);
    struct branch_walk w = {.request = r,
                            .branch = branch,
                            .psize = psize,
                            .ranges = {1, {r->low / psize}, {r->high / psize}}};
    const bool crossing = r->leave && r->leave->special == SPECIAL_CROSSING;
    bool fine = true;
    w.sides = r->forward || (r->leave && !crossing) ? 1 : 2;
    for (int side = 0; fine && side < 2 && !branch->closed; side++) {
        w.side = side;
        struct curve_place first;
        if (side == 1 && (r->forward || (r->leave && !crossing)))
            break;
        if (!branch_begin(r, side == 0 ? -1 : 1, psize, path, &first, error)) {
            fine = side == 1 && branch->count > 0;
            break;
        }
        branch->kind = path->kind;
        w.path = path;
        w.end = branch->ends[side == 0 && !r->forward && (!r->leave || crossing) ? 0 : 1];
        w.period = 0;
        struct solution solution;
        fine = solutions_at(path, &first, true, &solution) &&
               ((side == 1 && !crossing) ||
                branch_append(branch, path, &first, SPECIAL_NONE, &solution));
        fine = fine && branch_walk_follow(&w, first);
        if (side == 0 && !r->forward && (!r->leave || crossing))
            branch_reverse(branch);
        branch->evals += path->field.evals;
        solutions_end(path);
    }
    free(path);
    branch->cancelled = cancelled(r->cancel);
    branch->seconds = clock_seconds(start_time);
    for (int direction = -1; direction <= 1 && !branch->closed; direction += 2)
        forget_last_turns(branch, direction);
    /* A family leads away from the edge of the range at one value of the parameter. */
    const bool stays = branch->count == 1 && !branch->cancelled && branch_starts_in_family(r);
    if ((fine || branch->count > 0) && !stays)
        return true;
    if (cancelled(r->cancel))
        error_set(error, ERROR_CANCELLED, "cancelled");
    else if (stays)
        branch_refuse_family(error);
    else if (!error->text[0])
        error_memory(error);
    branch_free(branch);
    return false;
}

void branch_free(struct branch *branch)
{
    free(branch->point);
    *branch = (struct branch){.count = 0};
}
