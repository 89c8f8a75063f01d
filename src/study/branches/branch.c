/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A branch, step by step, with its special points. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/branches/eigen.h"
#include "study/dynamics/solutions.h"
#include "study/branches/two_parameters.h"

#define FIRST 0.01 /* arclength of the first step, where the range is 1 */
#define LONGEST 0.05
#define SHORTEST 1e-7 /* of the longest */
#define TURN 0.94     /* cosine of the angle by which a step may turn: 20 degrees */
#define TOGETHER 1e-6 /* of the range: tests that become 0 there are of the same point */
#define SLOW 25       /* times the first period: the orbit nears one that takes for ever */
#define VERTICAL 1e-7 /* part of the parameter in a tangent that does not change it */
#define LEVEL 12      /* so many of these in a row */
#define STILL 1e-4    /* of a tangent: the parameter hardly changes any more */
#define POINTS 1000
#define DOUBLE 1e-6 /* of a frequency: an eigenvalue that is 0 */
#define TINY 1e-8   /* of the largest value so far: a test that is 0 */

struct branch_walk {
    const struct branch_request *request;
    struct solution_curve *path;
    struct branch *out; /* points of this direction are appended */
    double psize, largest[CURVE_TESTS], period;
    int capacity;
    double moved; /* relative, the parameter in the last step */
    int level;    /* places in a row at one value of the parameter */
    bool away;    /* from where it began */
    int start;    /* place of the parameter among the unknowns at the start */
    struct curve_place known[CURVE_TESTS]; /* the last place where that test was not 0 */
    bool any[CURVE_TESTS];
    struct curve_place before; /* the last place but one, if its phase is that of the last: */
    bool bends;
    char *end; /* [96] why it ends */
};

static struct branch_point *append(struct branch_walk *w)
{
    struct branch *b = w->out;
    if (b->count == w->capacity) {
        const int capacity = w->capacity > 0 ? 2 * w->capacity : 64;
        struct branch_point *more = realloc(b->point, (size_t)capacity * sizeof *more);
        if (!more)
            return NULL;
        b->point = more;
        w->capacity = capacity;
    }
    b->point[b->count] = (struct branch_point){.criticality = NAN, .accuracy = NAN};
    return &b->point[b->count++];
}

static bool record(struct branch_walk *w, const struct curve_place *at, enum special special,
                   const struct solution *solution)
{
    struct branch_point *point = append(w);
    if (!point)
        return false;
    point->solution = *solution;
    point->special = special;
    /* of an orbit its beginning and what holds for all of it: the rest follows */
    const int n = w->path->field.n, all = w->path->problem->n;
    memcpy(point->tangent, at->tangent, (size_t)n * sizeof *point->tangent);
    if (w->path->kind == SOLUTION_EQUILIBRIUM) {
        point->tangent[n] = at->tangent[all];
    } else {
        point->tangent[n] = w->path->kind == SOLUTION_ORBIT ? at->tangent[all - 1] : 0;
        point->tangent[n + 1] = at->tangent[all];
    }
    return true;
}

/* ---- special points between two places ---- */

struct found_special {
    struct curve_place at;
    struct solution solution;
    enum special special;
    double distance, near;
};

static bool zero(const struct branch_walk *w, const struct curve_place *p, int test)
{
    if (test > 0)
        return fabs(p->test[test]) <= TINY * w->largest[test];
    /* the parameter's part of the tangent, in both kinds of curves: rounding where it stands still
     */
    return fabs(p->test[test]) <= CURVE_LEVEL ||
           (fabs(p->test[test]) <= CURVE_STEEP && w->moved <= CURVE_LEVEL);
}

static void locate_all(struct branch_walk *w, const struct curve_place *to,
                       struct found_special *found, int *count)
{
    const struct curve_problem *problem = w->path->problem;
    for (int k = 0; k < problem->tests; k++) {
        w->largest[k] = fmax(w->largest[k], fabs(to->test[k]));
        if (zero(w, to, k) || !isfinite(to->test[k]))
            continue;
        const struct curve_place before = w->known[k];
        const bool changed = w->any[k] && signbit(before.test[k]) != signbit(to->test[k]);
        w->known[k] = *to;
        w->any[k] = true;
        struct found_special *f = &found[*count];
        if (!changed || !curve_locate(problem, &before, to, k, &f->at, &f->near) ||
            !solutions_at(w->path, &f->at, true, &f->solution))
            continue;
        f->special = solutions_special(w->path, k, &f->solution);
        f->distance = curve_distance(problem->n + 1, f->at.u, before.u);
        if (f->special != SPECIAL_NONE)
            ++*count;
    }
}

/* A branch that is followed through a crossing turns back there, or doubles; it is a crossing. */
static void leave_doubles_out(struct found_special *found, int *count, int n)
{
    for (int i = 0; i < *count; i++)
        for (int j = 0; j < *count; j++)
            if (i != j && found[i].special == SPECIAL_CROSSING &&
                (found[j].special == SPECIAL_FOLD || found[j].special == SPECIAL_TORUS) &&
                curve_distance(n, found[i].at.u, found[j].at.u) < TOGETHER) {
                found[j] = found[--*count];
                i = -1;
                break;
            }
}

static int by_distance(const void *a, const void *b)
{
    const struct found_special *x = a, *y = b;
    return (x->distance > y->distance) - (x->distance < y->distance);
}

/* NAN: a real eigenvalue is 0, too, and linear theory says nothing of one pair alone. */
static double criticality(struct branch_walk *w, const struct solution *s)
{
    double omega = 0, best = HUGE_VAL, error;
    for (int k = 0; k < s->values; k++)
        if (s->value[k].im > 0 && fabs(s->value[k].re) < best) {
            best = fabs(s->value[k].re);
            omega = s->value[k].im;
        }
    for (int k = 0; k < s->values; k++)
        if (hypot(s->value[k].re, s->value[k].im) < DOUBLE * omega)
            return NAN;
    const double first = lyapunov_coefficient(&w->path->field, s->state, omega, &error);
    return fabs(first) <= 4 * error ? 0 : first;
}

static bool record_specials(struct branch_walk *w, const struct curve_place *to)
{
    struct found_special found[CURVE_TESTS];
    int count = 0;
    const int n = w->path->problem->n;
    locate_all(w, to, found, &count);
    leave_doubles_out(found, &count, n + 1);
    qsort(found, (size_t)count, sizeof *found, by_distance);
    for (int i = 0; i < count; i++) {
        if (!record(w, &found[i].at, found[i].special, &found[i].solution))
            return false;
        struct branch_point *point = &w->out->point[w->out->count - 1];
        struct solution *s = &point->solution;
        point->accuracy = found[i].near / fmax(fabs(found[i].at.u[n]), 1e-3);
        if (point->special == SPECIAL_HOPF)
            point->criticality = criticality(w, s);
    }
    return true;
}

/* ---- the walk ---- */

static bool inside(const struct branch_walk *w, const struct curve_place *p)
{
    const double value = p->u[w->path->problem->n] * w->psize;
    return value >= w->request->from && value <= w->request->to;
}

/* The place between two where the parameter leaves its range. */
static bool step_to_edge(struct branch_walk *w, const struct curve_place *a,
                         const struct curve_place *b, struct curve_place *edge)
{
    const int n = w->path->problem->n;
    const double value = b->u[n] * w->psize,
                 bound = (value < w->request->from ? w->request->from : w->request->to) / w->psize;
    const double share = (bound - a->u[n]) / (b->u[n] - a->u[n]);
    double guess[CURVE_MAX];
    for (int i = 0; i <= n; i++)
        guess[i] = a->u[i] + share * (b->u[i] - a->u[i]);
    guess[n] = bound;
    double direction[CURVE_MAX] = {0};
    direction[n] = a->tangent[n] < 0 ? -1 : 1; /* tests know which way the tangent goes */
    if (!curve_correct(w->path->problem, guess, direction, true, edge))
        return false;
    edge->u[n] = bound;
    return true;
}

static bool good_step(const struct branch_walk *w, const struct curve_place *from,
                      const struct curve_place *to)
{
    double cosine = 0;
    for (int i = 0; i <= w->path->problem->n; i++)
        cosine += from->tangent[i] * to->tangent[i];
    return cosine >= TURN && to->corrections <= 5;
}

/* As long as the parameter changes by no more than `longest` of its range, and the state by three
 * times that of its size. */
static double longest_at(const struct branch_walk *w, const struct curve_place *at, double longest)
{
    const int n = w->path->problem->n;
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += at->tangent[i] * at->tangent[i];
    return fmin(longest / fabs(at->tangent[n]), 3 * longest * curve_unit(n, at->u) / sqrt(sum));
}

/* The next place, with as long a step as is safe; false: none can be found. */
static bool next_place(struct branch_walk *w, const struct curve_place *from, double *by,
                       double longest, struct curve_place *to)
{
    while (*by > SHORTEST * longest) {
        if (cancelled(w->request->cancel))
            return false;
        if (curve_step(w->path->problem, w->bends ? &w->before : NULL, from, *by, to) &&
            good_step(w, from, to))
            return true;
        *by /= 2;
    }
    return false;
}

static bool too_slow(struct branch_walk *w, const struct curve_place *at)
{
    if (w->path->kind != SOLUTION_ORBIT)
        return false;
    const double period = orbit_curve_period(&w->path->orbit, at->u);
    if (!(w->period > 0))
        w->period = period;
    return period > SLOW * w->period && fabs(at->tangent[w->path->problem->n]) < STILL;
}

/* Neither the parameter nor what differences do along the way changes: of conservative motion. */
static bool in_family(const struct branch_walk *w, const struct curve_place *at)
{
    const struct solution *s = &w->out->point[w->out->count - 1].solution;
    bool one = w->path->kind == SOLUTION_EQUILIBRIUM;
    for (int i = 0; i < s->values; i++)
        one = one || hypot(s->value[i].re - 1, s->value[i].im) < 1e-6;
    return one && fabs(at->tangent[w->path->problem->n]) < VERTICAL;
}

static void know(struct branch_walk *w, const struct curve_place *at)
{
    for (int k = 0; k < w->path->problem->tests; k++) {
        w->largest[k] = k == 0 ? 1 : fabs(at->test[k]); /* the first is part of a unit vector */
        w->known[k] = *at;
        w->any[k] = !zero(w, at, k) && at->test[k] != 0 && isfinite(at->test[k]);
    }
}

/* Orbits that differences grow along too much are cut into more segments. */
static bool cut(struct branch_walk *w, struct curve_place *at)
{
    if (w->path->kind == SOLUTION_EQUILIBRIUM || !orbit_curve_is_long(&w->path->orbit))
        return true;
    double u[CURVE_MAX], direction[CURVE_MAX];
    memcpy(u, at->u, sizeof u);
    memcpy(direction, at->tangent, sizeof direction);
    if (!orbit_curve_cut(&w->path->orbit, u, direction) ||
        !curve_correct(w->path->problem, u, direction, false, at))
        return false;
    know(w, at);
    w->bends = false;
    return true;
}

/* Not where a test is 0: its sign before would be lost. */
static void stretch(struct branch_walk *w, struct curve_place *at)
{
    bool any = w->path->kind == SOLUTION_ORBIT;
    for (int k = 0; k < w->path->problem->tests; k++)
        any = any && !(w->any[k] && zero(w, at, k));
    if (!any || !orbit_curve_stretch(&w->path->orbit, at->u, at->tangent))
        return;
    know(w, at);
    w->bends = false;
}

static void ends(struct branch_walk *w, const char *why)
{
    snprintf(w->end, 96, "%s", why);
}

/* As far as a period's beginning, its length and the parameter show it. */
static double apart(const struct branch_walk *w, const struct curve_place *a, int a_last,
                    const struct curve_place *b, int b_last)
{
    const double period = w->path->kind == SOLUTION_ORBIT ? a->u[a_last - 1] - b->u[b_last - 1] : 0;
    return hypot(hypot(a->u[a_last] - b->u[b_last], period),
                 curve_distance(w->path->field.n, a->u, b->u));
}

/* To where it began, after it has been elsewhere. */
static bool comes_back(struct branch_walk *w, const struct curve_place *at,
                       const struct curve_place *next, const struct curve_place *start)
{
    const int last = w->path->problem->n;
    const double far = apart(w, next, last, start, w->start), step = apart(w, next, last, at, last);
    w->away = w->away || far > 2 * step;
    return w->away && far < step / 2;
}

static bool end_there(struct branch_walk *w, const char *why)
{
    w->out->point[w->out->count - 1].special = SPECIAL_END;
    ends(w, why);
    return true;
}

/* Does the branch end with the point that has been recorded? */
static bool is_over(struct branch_walk *w, const struct curve_place *at,
                    const struct curve_place *next, const struct curve_place *start, bool leaves)
{
    const struct branch_request *r = w->request;
    double *value = &w->out->point[w->out->count - 1].solution.param[0];
    if (leaves) {
        *value = fabs(*value - r->from) < fabs(*value - r->to) ? r->from : r->to;
        return end_there(w, "the parameter's range");
    }
    w->level = in_family(w, next) ? w->level + 1 : 0;
    if (w->level == LEVEL)
        return end_there(w, "a family at one value of the parameter");
    if (too_slow(w, next))
        return end_there(w, "the period grows without bound");
    if (!comes_back(w, at, next, start))
        return false;
    w->out->closed = true;
    ends(w, "it closes");
    return true;
}

/* From `at`, which is recorded already, until it ends; false: no memory. */
static bool walk(struct branch_walk *w, struct curve_place at)
{
    const double longest = w->request->step > 0 ? w->request->step : LONGEST;
    const int max = w->request->max > 0 ? w->request->max : POINTS;
    const struct curve_place start = at;
    w->level = 0;
    w->bends = false;
    w->moved = 1;
    w->away = false;
    w->start = w->path->problem->n;
    double by = fmin(FIRST, longest);
    know(w, &at);
    ends(w, "as many points as were asked for");
    for (int i = 0; i < max; i++) {
        struct curve_place next;
        const double far = longest_at(w, &at, longest);
        by = fmin(by, far);
        if (!next_place(w, &at, &by, far, &next)) {
            ends(w, cancelled(w->request->cancel) ? "cancelled" : "no step leads on");
            return true;
        }
        const double upright =
            w->path->kind == SOLUTION_EQUILIBRIUM ? 1 : orbit_curve_upright(&w->path->orbit);
        if (upright < 0)
            return end_there(w, "it shrinks to an equilibrium");
        const bool leaves = !inside(w, &next);
        if (leaves && !step_to_edge(w, &at, &next, &next)) {
            ends(w, "the parameter's range");
            return true;
        }
        const int p = w->path->problem->n;
        w->moved = at.careful && next.careful
                       ? fabs(next.u[p] - at.u[p]) / fmax(fabs(at.u[p]), CURVE_LEVEL)
                       : 0;
        struct solution solution;
        if (!solutions_seen(w->path, &next, &solution)) {
            ends(w, "what is there cannot be told");
            return true;
        }
        if (!record_specials(w, &next) ||
            !record(w, &next, leaves ? SPECIAL_END : SPECIAL_NONE, &solution))
            return false;
        if (is_over(w, &at, &next, &start, leaves))
            return true;
        w->before = at;
        w->bends = w->path->kind == SOLUTION_EQUILIBRIUM || upright > TURN;
        if (!w->bends)
            orbit_curve_refer(&w->path->orbit, next.u, next.tangent);
        if (next.corrections <= 3)
            by = fmin(1.5 * by, far);
        at = next;
        stretch(w, &at);
        if (!cut(w, &at)) {
            ends(w, "differences grow along the orbit by too much");
            return true;
        }
    }
    return true;
}

static void reverse(struct branch *b)
{
    for (int i = 0; i < b->count / 2; i++) {
        const struct branch_point swap = b->point[i];
        b->point[i] = b->point[b->count - 1 - i];
        b->point[b->count - 1 - i] = swap;
    }
}

/* Side -1 goes against growing values of the parameter, so that the branch is in order. */
static bool begin(const struct branch_request *r, int side, double psize,
                  struct solution_curve *path, struct curve_place *first, struct error *error)
{
    if (r->leave)
        return solutions_leave(path, r->scene, r->param, psize, r->leave, side, r->cancel, first,
                               error);
    double u[CURVE_MAX];
    if (!solutions_begin(path, r->scene, r->param, psize, r->start, r->cancel, u, error))
        return false;
    if (solutions_correct_at(path, u, r->forward ? 1 : side, first))
        return true;
    solutions_end(path);
    return error_set(error, ERROR_COMMAND, "there is no such %s at the start",
                     r->start->kind == SOLUTION_EQUILIBRIUM ? "equilibrium" : "orbit");
}

bool branch_follow(const struct branch_request *r, struct branch *branch, struct error *error)
{
    if (r->second)
        return special_follow(r, branch, error);
    const int64_t since = clock_ns();
    const double psize = r->to - r->from;
    *branch = (struct branch){.count = 0};
    struct branch_walk w = {.request = r, .out = branch, .psize = psize};
    const bool crossing = r->leave && r->leave->special == SPECIAL_CROSSING;
    bool fine = true;
    for (int side = 0; fine && side < 2 && !branch->closed; side++) {
        struct solution_curve path;
        struct curve_place first;
        if (side == 1 && (r->forward || (r->leave && !crossing)))
            break;
        if (!begin(r, side == 0 ? -1 : 1, psize, &path, &first, error)) {
            fine = side == 1 && branch->count > 0;
            break;
        }
        branch->kind = path.kind;
        w.path = &path;
        w.end = branch->ends[side == 0 && !r->forward && (!r->leave || crossing) ? 0 : 1];
        w.period = 0;
        struct solution solution;
        fine = solutions_at(&path, &first, true, &solution) &&
               ((side == 1 && !crossing) || record(&w, &first, SPECIAL_NONE, &solution));
        fine = fine && walk(&w, first);
        if (side == 0 && !r->forward && (!r->leave || crossing))
            reverse(branch);
        branch->evals += path.field.evals;
        solutions_end(&path);
    }
    branch->cancelled = cancelled(r->cancel);
    branch->seconds = clock_seconds(since);
    if (fine || branch->count > 0)
        return true;
    if (!error->text[0])
        error_memory(error);
    branch_free(branch);
    return false;
}

void branch_free(struct branch *branch)
{
    free(branch->point);
    *branch = (struct branch){.count = 0};
}
