/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * All equilibria in a box: branch and prune. A box without a zero of every derivative's bounds is
 * thrown away; the Krawczyk operator proves one zero, or none, or makes the box smaller; else it is
 * cut in two (Neumaier 1990, Interval Methods for Systems of Equations, chapter 5). What is left at
 * the smallest size is said.
 */
#include <hooke/base/numeric.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/typed.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/compare/verify.h"
#include "study/dynamics/forms.h"
#include "study/dynamics/krawczyk.h"
#include "study/dynamics/solutions.h"

#define TELLS 64        /* boxes after which it is told how far it is */
#define BOXES 200000    /* looked at */
#define SMALLEST 1e-9   /* of the range: not cut any more */
#define INFLATED 1e-7   /* of the range */
#define SAME 1e-7       /* of the range: two that are nearer are one */
#define DOUBTFUL 8      /* that are not proven, and listed */
#define DOUBTS 200      /* places: no more are looked at */
#define PLACE 1e-3      /* of the range: doubts that are nearer are about one place */
#define STARTS 100      /* of Newton's method, where bounds have not decided */
#define CORRECTIONS 100 /* of zeros that are not simple, too */
#define BEYOND 1e-6     /* of the range: what lies on the edge is inside */

struct box_search {
    struct vector_field field;
    struct system bounded; /* the same as equations that have bounds */
    bool conservative;
    struct typed_models *models; /* whose they are; NULL: the scene's */
    const struct equilibria_request *request;
    struct equilibria *found;
    int n, boxes, capacity, doubts;
    double unsure[FIELD_VARIABLES]; /* where the first doubt is, */
    bool elsewhere;                 /* and not all of them */
    struct interval (*stack)[FIELD_VARIABLES];
    int depth, room;
    double width[FIELD_VARIABLES]; /* of the range */
    double turn[FIELD_VARIABLES];  /* of an angle whose range is one turn; 0: of no other */
};

static double middle(struct interval a)
{
    return a.lo + (a.hi - a.lo) / 2;
}

static bool push(struct box_search *s, const struct interval *box)
{
    if (s->depth == s->room) {
        const int room = s->room > 0 ? 2 * s->room : 256;
        void *more = realloc(s->stack, (size_t)room * sizeof *s->stack);
        if (!more)
            return false;
        s->stack = more;
        s->room = room;
    }
    memcpy(s->stack[s->depth++], box, sizeof s->stack[0]);
    return true;
}

/* ---- what is found ---- */

/* Newton from the middle of a box with one zero; the mean field of a drive by its bounds. */
static void correct(struct box_search *s, double *y)
{
    const int n = s->n;
    for (int k = 0; k < CORRECTIONS; k++) {
        struct interval at[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES],
                        by[FIELD_VARIABLES * FIELD_VARIABLES];
        double a[FIELD_VARIABLES * FIELD_VARIABLES], f[FIELD_VARIABLES], most = 0;
        for (int i = 0; i < n; i++)
            at[i].lo = at[i].hi = y[i];
        system_bounds(&s->bounded, at, rate, by);
        for (int i = 0; i < n * n; i++)
            a[i] = middle(by[i]);
        for (int i = 0; i < n; i++)
            f[i] = -middle(rate[i]);
        if (!matrix_solve(n, a, f))
            return;
        for (int i = 0; i < n; i++) {
            y[i] += f[i];
            most = fmax(most, fabs(f[i]) / s->width[i]);
        }
        if (most < 1e-16)
            return;
    }
}

/* An angle and the same a turn on are one. */
static double apart(const struct box_search *s, int i, double a, double b)
{
    return s->turn[i] > 0 ? fabs(remainder(a - b, s->turn[i])) : fabs(a - b);
}

/* NULL: not found yet */
static struct solution *known(const struct box_search *s, const double *y)
{
    for (int k = 0; k < s->found->count; k++) {
        double most = 0;
        for (int i = 0; i < s->n; i++)
            most = fmax(most, apart(s, i, s->found->of[k].state[i], y[i]) / s->width[i]);
        if (most < SAME)
            return &s->found->of[k];
    }
    return NULL;
}

/* Is every derivative 0 there, but for rounding of its parts? */
static bool rests(struct box_search *s, const double *y)
{
    struct interval at[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES],
                    by[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int i = 0; i < s->n; i++)
        at[i].lo = at[i].hi = y[i];
    system_bounds(&s->bounded, at, rate, by);
    bool zero = true;
    for (int i = 0; i < s->n; i++)
        zero = zero && rate[i].lo <= 0 && rate[i].hi >= 0;
    return zero;
}

/* Newton's method may have gone far. */
static bool is_in_box(const struct box_search *s, const double *y)
{
    bool inside = true;
    for (int i = 0; i < s->n; i++)
        inside = inside && y[i] >= s->request->box[i][0] - BEYOND * s->width[i] &&
                 y[i] <= s->request->box[i][1] + BEYOND * s->width[i];
    return inside;
}

static bool keep(struct box_search *s, const struct interval *box, bool proven)
{
    double y[FIELD_VARIABLES];
    for (int i = 0; i < s->n; i++)
        y[i] = middle(box[i]);
    correct(s, y);
    for (int i = 0; i < s->n; i++)
        if (fabs(y[i]) < 1e-14 * s->width[i])
            y[i] = 0;
    for (int i = 0; i < s->n; i++) /* of both ends of a turn, the upper one */
        if (s->turn[i] > 0 && y[i] < s->request->box[i][0] + SAME * s->width[i])
            y[i] += s->turn[i];
    struct solution *same = known(s, y);
    if (same)
        same->multiple = same->multiple && !proven;
    if (same || (!proven && (!is_in_box(s, y) || !rests(s, y))))
        return true;
    if (s->found->count == s->capacity) {
        const int capacity = s->capacity > 0 ? 2 * s->capacity : 16;
        struct solution *more = realloc(s->found->of, (size_t)capacity * sizeof *more);
        if (!more)
            return false;
        s->found->of = more;
        s->capacity = capacity;
    }
    struct solution *solution = &s->found->of[s->found->count++];
    /* until all are found this says which are not proven */
    *solution = (struct solution){.kind = SOLUTION_EQUILIBRIUM, .n = s->n, .multiple = !proven};
    memcpy(solution->state, y, (size_t)s->n * sizeof *y);
    return true;
}

static void doubt(struct box_search *s, const struct interval *box)
{
    struct equilibria *found = s->found;
    if (found->complete)
        for (int i = 0; i < s->n; i++)
            s->unsure[i] = middle(box[i]);
    for (int i = 0; i < s->n; i++)
        s->elsewhere =
            s->elsewhere || apart(s, i, middle(box[i]), s->unsure[i]) > PLACE * s->width[i];
    found->complete = false;
    s->doubts++;
}

/* Where they lie on a curve, or the equations are flat, single ones of them say nothing. */
static void leave_doubtful_out(struct box_search *s)
{
    struct equilibria *found = s->found;
    int doubtful = 0, kept = 0;
    for (int k = 0; k < found->count; k++)
        doubtful += found->of[k].multiple;
    const bool listed = doubtful <= DOUBTFUL && s->doubts <= DOUBTS;
    for (int k = 0; k < found->count; k++)
        if (listed || !found->of[k].multiple)
            found->of[kept++] = found->of[k];
    if (kept < found->count)
        snprintf(found->reason, sizeof found->reason,
                 "bounds do not decide at many places, which are left out");
    found->count = kept;
}

/* ---- the search ---- */

/* Is there one zero near the middle of a box that has become too small for its bounds to say more?
 * (epsilon inflation, Rump 1983) */
static bool one_nearby(struct box_search *s, const struct interval *box)
{
    double y[FIELD_VARIABLES];
    struct interval wide[FIELD_VARIABLES], rate[FIELD_VARIABLES],
        by[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int i = 0; i < s->n; i++)
        y[i] = middle(box[i]);
    correct(s, y);
    for (int i = 0; i < s->n; i++) {
        const double by_most = INFLATED * s->width[i];
        wide[i] = (struct interval){y[i] - by_most, y[i] + by_most};
        if (!(box[i].lo >= wide[i].lo && box[i].hi <= wide[i].hi))
            return false;
    }
    system_bounds(&s->bounded, wide, rate, by);
    return krawczyk(&s->bounded, wide, by) == ONE;
}

static bool cut(struct box_search *s, const struct interval *box)
{
    int widest = 0;
    double most = 0;
    for (int i = 0; i < s->n; i++) {
        const double wide = (box[i].hi - box[i].lo) / s->width[i];
        if (wide > most) {
            most = wide;
            widest = i;
        }
    }
    if (most < SMALLEST) {
        const bool one = one_nearby(s, box);
        if (!one)
            doubt(s, box);
        return keep(s, box, one);
    }
    struct interval half[FIELD_VARIABLES];
    /* not in the middle, where zeros like to be */
    const double at = box[widest].lo + 0.4837 * (box[widest].hi - box[widest].lo);
    memcpy(half, box, sizeof half);
    half[widest].hi = at;
    if (!push(s, half))
        return false;
    half[widest] = (struct interval){at, box[widest].hi};
    return push(s, half);
}

static bool look(struct box_search *s, struct interval *box)
{
    struct interval rate[FIELD_VARIABLES], by[FIELD_VARIABLES * FIELD_VARIABLES];
    for (;;) {
        s->boxes++;
        system_bounds(&s->bounded, box, rate, by);
        for (int i = 0; i < s->n; i++)
            if (rate[i].lo > 0 || rate[i].hi < 0 || rate[i].lo != rate[i].lo)
                return true;
        switch (krawczyk(&s->bounded, box, by)) {
        case NONE:
            return true;
        case ONE:
            return keep(s, box, true);
        case SMALLER:
            continue;
        case UNKNOWN:
            return cut(s, box);
        }
    }
}

/* The part of the box that is done with. */
static void tell(const struct box_search *s)
{
    double left = 0;
    for (int k = 0; k < s->depth; k++) {
        double part = 1;
        for (int i = 0; i < s->n; i++)
            part *= (s->stack[k][i].hi - s->stack[k][i].lo) / s->width[i];
        left += part;
    }
    if (s->request->progress)
        s->request->progress(s->request->context, fmin(fmax(1 - left, 0), 1));
}

static bool search(struct box_search *s)
{
    while (s->depth > 0) {
        struct interval box[FIELD_VARIABLES];
        memcpy(box, s->stack[--s->depth], sizeof box);
        if (s->doubts > DOUBTS)
            return true;
        if (s->boxes >= BOXES || cancelled(s->request->cancel)) {
            s->found->complete = false;
            snprintf(s->found->reason, sizeof s->found->reason,
                     cancelled(s->request->cancel) ? "cancelled" : "after %d boxes", s->boxes);
            return true;
        }
        if (!look(s, box))
            return false;
        if (s->boxes % TELLS == 0)
            tell(s);
    }
    return true;
}

static int in_order(const void *a, const void *b)
{
    const struct solution *x = a, *y = b;
    for (int i = 0; i < x->n; i++)
        if (x->state[i] != y->state[i])
            return x->state[i] < y->state[i] ? -1 : 1;
    return 0;
}

/* Where bounds have not decided: zeros that Newton's method finds, and that are proven then. */
static bool search_more(struct box_search *s)
{
    uint64_t seed = 7;
    leave_doubtful_out(s);
    for (int k = 0; k < STARTS && !s->found->complete && !cancelled(s->request->cancel); k++) {
        double y[FIELD_VARIABLES];
        struct interval at[FIELD_VARIABLES];
        bool inside = true;
        for (int i = 0; i < s->n; i++)
            y[i] = s->request->box[i][0] + s->width[i] * random_fraction(&seed);
        if (!deflated_newton(&s->bounded, s->width, s->found->of, s->found->count, y))
            continue;
        for (int i = 0; i < s->n; i++) {
            at[i] = (struct interval){y[i], y[i]};
            inside = inside && y[i] >= s->request->box[i][0] && y[i] <= s->request->box[i][1];
        }
        if (inside && one_nearby(s, at) && !keep(s, at, true))
            return false;
    }
    return true;
}

/* The equations as a whole are nothing, or not the same again after a time. */
static bool no_bounds(const struct box_search *s, struct error *error)
{
    if (s->field.system.autonomous)
        return error_set(error, ERROR_COMMAND,
                         "nothing moves anywhere: every state is an equilibrium");
    error_set(error, ERROR_COMMAND,
              "the equations depend on time, but not with one period: "
              "nothing rests, not even in the mean");
    return error_hint(error, "a parameter in place of t, as in param tau = 0, holds the time");
}

static bool begin(struct box_search *s, struct error *error)
{
    const struct equilibria_request *request = s->request;
    struct interval box[FIELD_VARIABLES], rate[FIELD_VARIABLES];
    if (!field_init(&s->field, request->scene, NULL, 0, error) ||
        !scene_with_bounds(request->scene, &s->field.system, &s->models, &s->bounded, error))
        return false;
    struct system energetic; /* potentials are found by scene_bind() */
    if (!scene_bind(request->scene, &energetic, error))
        return false;
    s->conservative = energetic.conservative;
    s->n = s->field.n;
    for (int i = 0; i < s->n; i++) {
        const double turn = s->field.turn[i];
        s->width[i] = request->box[i][1] - request->box[i][0];
        s->turn[i] = turn > 0 && fabs(s->width[i] - turn) <= BEYOND * turn ? turn : 0;
        box[i] = (struct interval){request->box[i][0] - BEYOND * s->width[i],
                                   request->box[i][1] + BEYOND * s->width[i]};
    }
    s->found->forced = !s->field.system.autonomous;
    if (!system_bounds(&s->bounded, box, rate, NULL))
        return no_bounds(s, error);
    return push(s, box) || error_memory(error);
}

/* Why there may be more, where it is not said yet. */
static void give_reason(struct box_search *s)
{
    struct equilibria *found = s->found;
    struct buffer text = {0};
    if (found->complete || (found->reason[0] && !s->field.system.dry))
        return;
    if (s->field.system.dry) {
        buffer_put(&text, TEXT("dry friction holds it at rest all over a stretch"));
    } else {
        buffer_put(&text, TEXT("bounds do not decide how many there are near "));
        for (int i = 0; i < s->n; i++) {
            const struct variable variable = system_variable(&s->field.system, i);
            buffer_format(&text, "%s%s = ", i ? ", " : "", variable.name);
            const bool zero = fabs(s->unsure[i]) < SAME * s->width[i];
            buffer_quantity(&text, zero ? 0 : s->unsure[i], variable.quantity, 4);
        }
        buffer_put(&text, s->elsewhere ? TEXT(" and elsewhere") : TEXT(""));
    }
    snprintf(found->reason, sizeof found->reason, "%.*s", (int)text.len, text.len ? text.data : "");
    buffer_free(&text);
}

/* All of them, in order, and what they are. Where bounds have not decided eigenvalues do not. */
static bool finish(struct box_search *s)
{
    struct equilibria *found = s->found;
    found->form = calloc((size_t)found->count + 1, sizeof *found->form);
    if (!found->form)
        return false;
    if (found->count > 0)
        qsort(found->of, (size_t)found->count, sizeof *found->of, in_order);
    for (int k = 0; k < found->count; k++)
        if (!equilibrium_form(&s->field, &s->bounded, s->conservative, &found->of[k],
                              &found->form[k]))
            return false;
    for (int k = 0; k < found->count; k++)
        if (found->of[k].multiple) {
            found->form[k].type = EQUILIBRIUM_DEGENERATE;
            found->form[k].index = found->of[k].multiple = 0;
        }
    give_reason(s);
    return true;
}

bool equilibria_find(const struct equilibria_request *request, struct equilibria *found,
                     struct error *error)
{
    const int64_t since = clock_ns();
    struct box_search s = {.request = request, .found = found};
    *found = (struct equilibria){.complete = true};
    const bool fine =
        begin(&s, error) && ((search(&s) && search_more(&s) && finish(&s)) || error_memory(error));
    free(s.stack);
    field_free(&s.field);
    typed_destroy(s.models);
    found->boxes = s.boxes;
    found->seconds = clock_seconds(since);
    if (!fine)
        equilibria_free(found);
    return fine;
}

void equilibria_free(struct equilibria *found)
{
    free(found->of);
    free(found->form);
    *found = (struct equilibria){.count = 0};
}
