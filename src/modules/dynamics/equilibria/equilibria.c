/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds all equilibria in a box (equilibria_find): those that branch and prune proves (search.c),
 * those that Newton's method finds and proves where bounds do not decide, and what remains
 * undecided, with a reason. */
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/typed.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "modules/solving/compute/algebra.h"
#include "modules/dynamics/equilibria/search.h"
#include "modules/dynamics/orbits/forms.h"

enum { DOUBTFUL_LISTED_MAX = 8, UNDECIDED_LISTED_MAX = 200 };
enum { NEWTON_STARTS_MAX = 256, RANDOM_STARTS = 100 };
/* Undecided boxes at more values of a variable than this fill an interval, which is not named. */
enum { PLACES_MAX = 8 };

/* Zeros without a proof that are closer than this, relative to the range, are listed as one. */
static const double doubtful_apart_min = 1e-7;
/* Undecided boxes that are closer than this, relative to the range, are named as one place. */
static const double place_apart_min = 1e-3;
/* The searched box is larger than the range by this part on each side, to find zeros on the
 * edge. */
static const double search_margin = 1e-6;
/* Smallest size of a variable, relative to its range. */
static const double size_min = 0.1;

/* State of equilibria_find(). */
struct equilibria_search {
    struct zero_search zeros;
    struct vector_field field;
    bool conservative; /* energy is constant, so that centres are possible */
    struct typed_models
        *models; /* owner of the equations with bounds, or NULL if the scene has them */
};

/* ---- boxes that bounds do not decide ---- */

/* Returns true if every derivative is 0 at y [n] but for the rounding of y and of its parts, and
 * has finite slopes there. */
static bool is_rest_to_rounding(const struct zero_search *s, const double *y)
{
    struct interval point[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES],
                    jacobian[FIELD_VARIABLES * FIELD_VARIABLES];
    for (int i = 0; i < s->n; i++) {
        const double rounding = 4 * DBL_EPSILON * fabs(y[i]);
        point[i] = (struct interval){y[i] - rounding, y[i] + rounding};
    }
    system_bounds(&s->bounded, point, rate, jacobian);
    bool zero = true;
    for (int i = 0; i < s->n; i++)
        zero = zero && rate[i].lo <= 0 && rate[i].hi >= 0;
    return zero && zeros_are_bounded(s->n, rate) && zeros_are_bounded(s->n * s->n, jacobian);
}

/* Returns the decimal number of at most significant_digits_tried digits that is nearest to y: the
 * edges of domains often are such numbers. */
static double short_number(double y)
{
    enum { significant_digits_tried = 13 };
    char text[32];
    snprintf(text, sizeof text, "%.*e", significant_digits_tried - 1, y);
    return strtod(text, NULL);
}

/* Returns true if every rate at y [n] is at most `share` of what it is a hundredth of the range
 * away. */
static bool rests_beside(const struct zero_search *s, const double *y, double share)
{
    static const double away = 1e-2;
    double rate[FIELD_VARIABLES], size[FIELD_VARIABLES] = {0};
    for (int i = 0; i < 2 * s->n; i++) {
        double other[FIELD_VARIABLES];
        memcpy(other, y, (size_t)s->n * sizeof *y);
        other[i / 2] += (i % 2 ? away : -away) * s->width[i / 2];
        system_derivative(&s->bounded, s->bounded.t0, other, rate);
        for (int k = 0; k < s->n; k++)
            size[k] = isfinite(rate[k]) ? fmax(size[k], fabs(rate[k])) : size[k];
    }
    system_derivative(&s->bounded, s->bounded.t0, y, rate);
    bool rests = s->bounded.autonomous;
    for (int k = 0; k < s->n; k++)
        rests = rests && fabs(rate[k]) <= share * size[k];
    return rests;
}

/* Moves y [n], the middle of a smallest box in which bounds leave room for a zero, to a short
 * number where all derivatives are exactly 0, or to a side of the box where they go to 0: at the
 * edge of a domain, or where a slope is infinite, only one side may have values. */
static bool move_to_edge(const struct zero_search *s, const struct state_box *box, double *y)
{
    static const double small = 1e-3;
    struct interval bound[FIELD_VARIABLES];
    double candidate[FIELD_VARIABLES];
    for (int i = 0; i < s->n; i++)
        candidate[i] = fabs(y[i]) < doubtful_apart_min * s->width[i] ? 0 : short_number(y[i]);
    system_bounds(&s->bounded, box->side, bound, NULL);
    const bool is_edge = box->is_singular && zeros_are_bounded(s->n, bound);
    bool rests = rests_beside(s, candidate, 0);
    for (int i = 0; i < 2 * s->n && is_edge && !rests; i++) {
        memcpy(candidate, y, sizeof candidate);
        candidate[i / 2] = i % 2 ? box->side[i / 2].hi : box->side[i / 2].lo;
        rests = rests_beside(s, candidate, small);
    }
    if (rests)
        memcpy(y, candidate, (size_t)s->n * sizeof *y);
    return rests;
}

/* Sets each variable of the equilibrium y [n] that is negligible beside its natural range to
 * exactly 0, if the state is then still an equilibrium up to rounding. */
static void round_to_zero(const struct zero_search *s, double *y)
{
    for (int i = 0; i < s->n; i++) {
        const double value = y[i];
        if (fabs(value) >= doubtful_apart_min * s->width[i])
            continue;
        y[i] = 0;
        if (!is_rest_to_rounding(s, y))
            y[i] = value;
    }
}

/* Returns true if a solution that is as good as equal to y [n] is listed already. */
static bool is_listed(const struct zero_search *s, const double *y)
{
    for (int k = 0; k < s->found->count; k++) {
        double most = 0;
        for (int i = 0; i < s->n; i++) {
            const double difference = y[i] - s->found->solution[k].state[i];
            most =
                fmax(most, fabs(s->turn[i] > 0 ? remainder(difference, s->turn[i]) : difference) /
                               s->width[i]);
        }
        if (most < doubtful_apart_min)
            return true;
    }
    return false;
}

/* Computes the middle y [n] of an undecided box. */
static void undecided_middle(const struct zero_search *s, size_t box, double *y)
{
    for (int i = 0; i < s->n; i++)
        y[i] = interval_middle(s->undecided.box[s->undecided.first + box].side[i]);
}

/* Lists zeros that lie in undecided boxes but have no proof, if they are few; many of them lie on a
 * curve, or where the equations are flat, and are not listed. Returns false if out of memory. */
static bool list_doubtful(struct zero_search *s)
{
    const size_t count = box_queue_count(&s->undecided);
    const int proven = s->found->count;
    size_t smallest = 0;
    for (size_t b = 0; b < count; b++)
        smallest += s->undecided.box[s->undecided.first + b].is_smallest;
    bool few = smallest <= UNDECIDED_LISTED_MAX;
    for (size_t b = 0; b < count && few; b++) {
        double y[FIELD_VARIABLES];
        if (!s->undecided.box[s->undecided.first + b].is_smallest)
            continue;
        undecided_middle(s, b, y);
        const struct state_box *box = &s->undecided.box[s->undecided.first + b];
        if (!move_to_edge(s, box, y)) {
            zeros_correct(s, y);
            round_to_zero(s, y);
            if (!is_rest_to_rounding(s, y))
                continue;
        }
        if (!zeros_in_range(s, y) || is_listed(s, y))
            continue;
        few = s->found->count < proven + DOUBTFUL_LISTED_MAX;
        if (few && !zeros_append(s, y, NULL))
            return false;
    }
    s->found->count = few ? s->found->count : proven;
    return true;
}

/* Starts Newton's method from undecided boxes and from random states, and appends zeros that are
 * then proven. Returns false if out of memory. */
static bool search_by_newton(struct zero_search *s)
{
    uint64_t seed = 7;
    double y[FIELD_VARIABLES];
    const size_t count = box_queue_count(&s->undecided),
                 starts = count < NEWTON_STARTS_MAX ? count : NEWTON_STARTS_MAX;
    if (s->found->count >= ZEROS_MAX)
        return true;
    for (size_t k = 0; k < starts && !cancelled(s->request->cancel); k++) {
        undecided_middle(s, k * count / starts, y);
        if (!zeros_prove_from(s, y))
            return false;
    }
    for (int k = 0; k < RANDOM_STARTS && count > 0 && !cancelled(s->request->cancel); k++) {
        for (int i = 0; i < s->n; i++)
            y[i] = s->request->box[i][0] + s->width[i] * random_fraction(&seed);
        if (!zeros_prove_from(s, y))
            return false;
    }
    zeros_drop_decided(s);
    return true;
}

/* Sets *error for equations without bounds: nothing moves, or they depend on time without a period.
 * Returns false. */
static bool refuse_without_bounds(const struct equilibria_search *s, struct error *error)
{
    if (s->field.system.autonomous)
        return error_set(error, ERROR_COMMAND, "nothing ever moves: every state is an equilibrium");
    error_set(error, ERROR_COMMAND,
              "the equations depend on time but are not periodic, so there are no equilibria, "
              "nor equilibria of the mean over a period");
    return error_hint(error,
                      "to fix the time, use a parameter in place of t, as in: param tau = 0");
}

/* Sets up field, equations with bounds, and the first box. Returns false with *error. */
static bool begin_equilibria_search(struct equilibria_search *search, struct error *error)
{
    struct zero_search *s = &search->zeros;
    struct vector_field *field = &search->field;
    const struct equilibria_request *request = s->request;
    struct state_box box = {.is_singular = false};
    struct interval rate[FIELD_VARIABLES];
    if (!field_init(field, request->scene, NULL, 0, error) ||
        !scene_with_bounds(request->scene, &field->system, &search->models, &s->bounded, error))
        return false;
    struct system energetic; /* potentials are found by scene_bind() */
    if (!scene_bind(request->scene, &energetic, error))
        return false;
    search->conservative = energetic.conservative;
    s->n = field->n;
    for (int i = 0; i < s->n; i++) {
        const double turn = field->turn[i];
        s->width[i] = request->box[i][1] - request->box[i][0];
        /* symmetries are tested in all of the range, not where the scene's start happens to be */
        field->size[i] = fmax(field->size[i], size_min * s->width[i]);
        s->turn[i] = turn > 0 && fabs(s->width[i] - turn) <= search_margin * turn ? turn : 0;
        box.side[i] = (struct interval){request->box[i][0] - search_margin * s->width[i],
                                        request->box[i][1] + search_margin * s->width[i]};
    }
    s->found->forced = !field->system.autonomous;
    if (!system_bounds(&s->bounded, box.side, rate, NULL))
        return refuse_without_bounds(search, error);
    return box_queue_add(&s->waiting, &box) || error_memory(error);
}

/* ---- result ---- */

/* Writes to place [PLACES_MAX + 1] the values of variable i, SI, at which undecided boxes lie;
 * values closer than place_apart_min widths of the searched range count once. Returns their number;
 * PLACES_MAX + 1 means too many to name. */
static int places_of(const struct zero_search *s, int i, double *place)
{
    int places = 0;
    for (size_t b = s->undecided.first; b < s->undecided.end && places <= PLACES_MAX; b++) {
        const double y = interval_middle(s->undecided.box[b].side[i]);
        bool known = false;
        for (int k = 0; k < places; k++)
            known = known || fabs(y - place[k]) <= place_apart_min * s->width[i];
        if (!known)
            place[places++] = y;
    }
    return places;
}

/* Returns the longest side of undecided boxes in the direction of variable i. */
static double widest_side_of(const struct zero_search *s, int i)
{
    double widest = 0;
    for (size_t b = s->undecided.first; b < s->undecided.end; b++)
        widest = fmax(widest, s->undecided.box[b].side[i].hi - s->undecided.box[b].side[i].lo);
    return widest;
}

/* Appends the first place of undecided boxes: "x = 0, v = 1". Variables that take many values there
 * (more than PLACES_MAX) are left out, unless all do. The number of digits follows from the sides
 * of the boxes. "and elsewhere" is appended if a variable has several values. */
static void put_place(const struct equilibria_search *search, struct buffer *text)
{
    const struct zero_search *s = &search->zeros;
    double place[FIELD_VARIABLES][PLACES_MAX + 1] = {{0}};
    int places[FIELD_VARIABLES], named = 0, put = 0;
    bool elsewhere = false;
    for (int i = 0; i < s->n; i++) {
        places[i] = places_of(s, i, place[i]);
        named += places[i] <= PLACES_MAX;
    }
    for (int i = 0; i < s->n; i++) {
        if (named > 0 && places[i] > PLACES_MAX)
            continue;
        const struct variable variable = system_variable(&search->field.system, i);
        const double y = fabs(place[i][0]) < 1e-7 * s->width[i] ? 0 : place[i][0];
        buffer_format(text, "%s%s = ", put++ > 0 ? ", " : "", variable.name);
        const double side = widest_side_of(s, i);
        const int digits = (int)fmin(fmax(ceil(log10(fabs(y) / side)), 1), 4);
        buffer_quantity(text, y, variable.quantity, y == 0 ? 1 : digits);
        elsewhere = elsewhere || places[i] > 1;
    }
    buffer_put(text, elsewhere ? TEXT(" and elsewhere") : TEXT(""));
}

/* Returns true if the equations are unbounded in one of the boxes. */
static bool has_singular(const struct box_queue *boxes)
{
    bool singular = false;
    for (size_t b = boxes->first; b < boxes->end; b++)
        singular = singular || boxes->box[b].is_singular;
    return singular;
}

/* Stores the reason why there may be more equilibria. */
static void store_reason(struct equilibria_search *search)
{
    const struct zero_search *s = &search->zeros;
    struct equilibria *found = s->found;
    struct buffer text = {0};
    if (cancelled(s->request->cancel)) {
        buffer_put(&text, TEXT("cancelled"));
    } else if (search->field.system.dry) {
        buffer_put(&text, TEXT("dry friction holds it at rest over a whole range of positions"));
    } else if (found->count >= ZEROS_MAX) {
        buffer_format(&text, "the search ended after %d equilibria", found->count);
    } else if (has_singular(&s->undecided)) {
        buffer_put(&text, TEXT("a pole, a jump, a vertical slope or the edge of a domain near "));
        put_place(search, &text);
    } else if (box_queue_count(&s->undecided) > UNDECIDED_LISTED_MAX) {
        buffer_put(&text, TEXT("many places are left out because bounds do not decide there"));
    } else {
        buffer_put(&text, TEXT("bounds do not decide how many there are near "));
        put_place(search, &text);
    }
    snprintf(found->reason, sizeof found->reason, "%.*s", (int)text.len, text.len ? text.data : "");
    buffer_free(&text);
}

/* Compares two solutions for qsort(), by the first variable that differs. */
static int compare_states(const void *a, const void *b)
{
    const struct solution *x = a, *y = b;
    for (int i = 0; i < x->n; i++)
        if (x->state[i] != y->state[i])
            return x->state[i] < y->state[i] ? -1 : 1;
    return 0;
}

/* Sorts the equilibria and determines their types; those without a proof are degenerate. Returns
 * false if out of memory or if eigenvalues are not found. */
static bool classify_all(struct equilibria_search *search)
{
    struct equilibria *found = search->zeros.found;
    found->form = calloc((size_t)found->count + 1, sizeof *found->form);
    if (!found->form)
        return false;
    if (found->count > 0)
        qsort(found->solution, (size_t)found->count, sizeof *found->solution, compare_states);
    for (int k = 0; k < found->count; k++)
        if (!equilibrium_form(&search->field, &search->zeros.bounded, search->conservative,
                              &found->solution[k], &found->form[k]))
            return false;
    for (int k = 0; k < found->count; k++)
        if (found->solution[k].multiple) {
            found->form[k].type = EQUILIBRIUM_DEGENERATE;
            found->form[k].index = found->solution[k].multiple = 0;
        }
    return true;
}

/* Runs all stages of the search. Returns false if out of memory. */
static bool run_search(struct equilibria_search *search)
{
    struct zero_search *s = &search->zeros;
    if (!zeros_search(s))
        return false;
    zeros_drop_decided(s);
    if (!search_by_newton(s))
        return false;
    s->found->complete = box_queue_count(&s->undecided) == 0;
    if (!s->found->complete)
        store_reason(search);
    return list_doubtful(s) && classify_all(search);
}

/* Sets up the search, runs it, and frees all but the result. */
bool equilibria_find(const struct equilibria_request *request, struct equilibria *found,
                     struct error *error)
{
    const int64_t start_time = clock_ns();
    struct equilibria_search search = {.zeros = {.request = request, .found = found}};
    struct zero_search *s = &search.zeros;
    *found = (struct equilibria){.complete = false};
    const bool fine =
        begin_equilibria_search(&search, error) && (run_search(&search) || error_memory(error));
    free(s->waiting.box);
    free(s->singular.box);
    free(s->undecided.box);
    free(s->proof);
    field_free(&search.field);
    typed_destroy(search.models);
    found->boxes = s->boxes;
    found->seconds = clock_seconds(start_time);
    if (!fine)
        equilibria_free(found);
    return fine;
}

void equilibria_free(struct equilibria *found)
{
    free(found->solution);
    free(found->form);
    *found = (struct equilibria){.count = 0};
}
