/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes reference solutions: the closed form where one is known, otherwise integrations by
 * methods of different kinds, of which the two that agree best are chosen. Their distance is the
 * accuracy. */
#include "modules/comparison/compute/reference.h"
#include <hooke/base/cancel.h>

#include <stdlib.h>
#include <string.h>

/* Candidates in the order in which they are tried; methods that do not exist or do not apply are
 * skipped. `tol` is the tolerance of an adaptive method, ten times as large in each further try; 0
 * means fixed steps, which are halved until the result stops changing. */
static const struct candidate {
    const char *name;
    enum solver_kind kind;
    double tol;
} candidates[] = {
    {"dop853", KIND_EXPLICIT, 1e-14},        {"odex", KIND_EXPLICIT, 1e-14},
    {"kahan-li8", KIND_SPLITTING, 0},        {"radau5", KIND_IMPLICIT, 1e-13},
    {"rodas5p", KIND_ROSENBROCK, 1e-13},     {"gauss6", KIND_IMPLICIT, 0},
    {"blanes-moan6", KIND_SPLITTING, 0},     {"tsit5", KIND_EXPLICIT, 1e-14},
    {"dopri5", KIND_EXPLICIT, 1e-14},        {"gauss4", KIND_IMPLICIT, 0},
    {"implicit-midpoint", KIND_IMPLICIT, 0},
};

#define REFERENCE_AGREEMENT 1e-12 /* the search ends when two solutions agree to this */
#define REFERENCE_ROUNDING 1e-13  /* a smaller change on halving the step is taken for rounding */
/* A distance this many times as large as all before it shows a jump. */
#define JUMP_FACTOR 1e4
/* Growth from rounding to REFERENCE_MEANING within this many grid times may be a jump or not. */
#define JUMP_FREE_TIMES 3
#define REFERENCE_MEANING 1e-3 /* distance of two solutions above which both are meaningless */
/* largest cost of one solution (evaluations, Jacobians, solves), divided by n */
#define COST_MAX 40e6
#define COST_ALL 80e6         /* the same for all solutions together, some seconds */
#define TOLERANCE_TRIES 3     /* number of tolerances that are tried */
#define TRIES_BURST 8         /* the same for forces with bursts */
#define VOLUME_SHRINK_MIN 1e4 /* shrinking of volumes, as e to this, from which damping is fast */
/* Parts of a grid interval at which steps of all solutions but the first end: no step is longer
 * than a thousandth of the span. */
#define SPAN_PARTS 4
/* The same for laws that depend on time and may have pulses: at most an 8000th of the span. */
#define PARTS_IN_TIME 32

/* Returns the memory of the solution of that kind, or with KIND_COUNT that to work with. */
static double *solution_memory(const struct reference_search *search, enum solver_kind kind)
{
    return search->grid + (size_t)kind * search->size;
}

/* Sets the amplitudes to the largest |y_i| on the grid, or to the natural size of a variable that
 * does not move except by rounding. */
static void set_amplitudes(struct reference *reference, const struct system *system,
                           const double *grid)
{
    for (int i = 0; i < system->n; i++) {
        double max = 0;
        for (int k = 0; k < STUDY_TIMES; k++)
            max = fmax(max, fabs(grid[k * system->n + i]));
        /* A motion far below its natural size is rounding, unless that is at its own floor. */
        const bool moves = max > 1e-18 * system->scale[i] || (max > 0 && system->scale[i] < 1e-280);
        reference->amplitude[i] = moves ? max : system->scale[i];
    }
}

/* Returns the largest distance of two solutions over the grid, in amplitudes; NAN if a state has
 * NAN. */
static double largest_distance(const struct reference_search *search, const double *a,
                               const double *b)
{
    const int n = search->system->n;
    double max = 0;
    for (int k = 0; k < STUDY_TIMES; k++) {
        const double distance = grid_distance(search->reference, a + k * n, b + k * n);
        if (!(distance <= max))
            max = distance;
    }
    return max;
}

/* Solves adaptively into `grid`, with tolerances that grow tenfold from try to try until the end is
 * reached. Bursts get more tries, as the clock has few digits inside a short one. Returns true if
 * the end was reached. */
static bool solve_adaptive(struct reference_search *search, struct solver *s, bool explicit,
                           double *grid)
{
    const int64_t max = s->max;
    for (int try = 0; try < (search->bursts > 0 ? TRIES_BURST : TOLERANCE_TRIES);
         try++, s->tol *= 10) {
        s->max = search->bursts > 0 ? max / TRIES_BURST : max;
        const enum stop stop = reference_walk(search, s, 0, grid);
        const bool bursts = search->bursts > 0;
        search->stiff |= stop == STOP_FULL && explicit && !bursts;
        if (stop == STOP_END || stop == STOP_CANCELLED || (stop == STOP_FULL && !bursts))
            return stop == STOP_END;
    }
    return false;
}

/* Solves with fixed steps into `grid`, halved until the result stops changing, changes more than
 * before (by rounding), or exceeds the cost. Returns true if the last change was below
 * REFERENCE_MEANING. */
static bool solve_fixed(struct reference_search *search, struct solver *s, double *grid)
{
    /* `moved` is the change by the last halving */
    double *finer = solution_memory(search, KIND_COUNT), moved = HUGE_VAL;
    bool have = false;
    for (int64_t steps = search->parts; steps <= 1 << 20; steps *= 2) {
        if (reference_walk(search, s, steps, finer) != STOP_END) {
            if (have || solver_cost(s) > s->max || cancelled(search->cancel))
                break;
            continue;
        }
        set_amplitudes(search->reference, search->system, finer);
        const double change = have ? largest_distance(search, finer, grid) : HUGE_VAL;
        if (change < 1e-8 && change > moved)
            break;
        memcpy(grid, finer, search->size * sizeof *grid);
        have = true;
        moved = change;
        if (change < REFERENCE_ROUNDING || solver_cost(s) > s->max / 2)
            break;
    }
    return have && moved < REFERENCE_MEANING;
}

/* Solves with a candidate, unless a method of its kind has solved already or it does not apply.
 * Returns true, and notes the method, if it reached the end; sets search->failed if out of
 * memory. */
static bool try_candidate(struct reference_search *search, const struct candidate *candidate)
{
    const struct method *method = method_by_name(text_of(candidate->name));
    struct error ignored;
    struct run_settings settings = {.dt = fabs(search->reference->span), .tol = candidate->tol};
    if (search->method[candidate->kind] || (search->stiff && candidate->kind == KIND_EXPLICIT) ||
        !method || !method_applies(method, search->system, &settings.drag, &ignored))
        return false;
    struct solver s;
    if (!solver_init(&s, search->system, method, &settings, search->reference->span)) {
        search->failed = true;
        return false;
    }
    s.max = (int64_t)(COST_MAX / search->system->n);
    double *grid = solution_memory(search, candidate->kind);
    const bool ok = s.tol > 0 ? solve_adaptive(search, &s, candidate->kind == KIND_EXPLICIT, grid)
                              : solve_fixed(search, &s, grid);
    solver_free(&s);
    if (ok)
        search->method[candidate->kind] = method;
    return ok;
}

/* Sets `meaning` to the time up to which two solutions agree, and `sudden` if they separate by a
 * jump: growing rounding takes time from one power of ten to the next; a jump has another
 * reason. */
static void set_meaning(const struct reference_search *search, const double *a, const double *b)
{
    struct reference *reference = search->reference;
    const int n = search->system->n;
    double previous_distance = 0;
    reference->meaning = reference->span;
    reference->sudden = false;
    for (int k = 1; k < STUDY_TIMES; k++) {
        const double distance = grid_distance(reference, a + k * n, b + k * n);
        if (!(distance < REFERENCE_MEANING)) {
            reference->meaning = reference->span * (k - 1) / (STUDY_TIMES - 1);
            reference->sudden =
                k > JUMP_FREE_TIMES &&
                !(distance < JUMP_FACTOR * fmax(previous_distance, REFERENCE_ROUNDING));
            return;
        }
        previous_distance = fmax(previous_distance, distance);
    }
}

/* Compares the new solution of this kind of solver with those of the other kinds. If two agree
 * better than any pair before, that pair becomes the reference, and their distance its accuracy. */
static void compare_solution(struct reference_search *search, enum solver_kind kind)
{
    struct reference *reference = search->reference;
    const double *grid = solution_memory(search, kind);
    for (enum solver_kind other = 0; other < KIND_COUNT; other++) {
        if (other == kind || !search->method[other])
            continue;
        const double *other_solution = solution_memory(search, other);
        set_amplitudes(reference, search->system, other_solution);
        const double agreement = largest_distance(search, grid, other_solution);
        if (reference->method[1] && !(agreement < reference->accuracy))
            continue;
        reference->accuracy = agreement;
        reference->method[0] = search->method[other];
        reference->method[1] = search->method[kind];
        memcpy(reference->y, other_solution, search->size * sizeof *other_solution);
        set_meaning(search, grid, other_solution);
    }
}

/* Fills in the reference from the closed form of the scene. Its accuracy is what rounding of the
 * parameters changes. */
static void take_closed_form(const struct system *system, struct reference *reference)
{
    const int n = system->n;
    double floor[LIMIT_VARIABLES], max[LIMIT_VARIABLES] = {0};
    reference->exact = true;
    for (int k = 0; k < STUDY_TIMES; k++) {
        const double t = system->t0 + reference->span * k / (STUDY_TIMES - 1);
        system_exact(system, system->t0, system->start, t, reference->y + k * n, floor);
        for (int i = 0; i < reference->scored; i++)
            max[i] = fmax(max[i], floor[i]);
    }
    set_amplitudes(reference, system, reference->y);
    for (int i = 0; i < reference->scored; i++)
        reference->accuracy = fmax(reference->accuracy, max[i] / reference->amplitude[i]);
}

/* Returns true if volumes of the state space shrink at the start so fast that the span is many
 * decay times long. Explicit methods then choose their steps for stability alone, so that they are
 * tried last. */
static bool shrinks_fast(const struct system *system, double span)
{
    double trace = 0, *jacobian = system_new_jacobian(system, system->t0, system->start);
    for (int i = 0; jacobian && i < system->n; i++)
        trace += jacobian[i * system->n + i];
    free(jacobian);
    return -trace * span > VOLUME_SHRINK_MIN;
}

/* Tries the candidates of explicit kind, of the others, or both, until two solutions agree. All
 * solutions but the first take steps of a bounded size, so that a pulse that long steps miss is
 * seen by one of them. */
static void search_kinds(struct reference_search *search, bool explicit_ones, bool others)
{
    struct reference *reference = search->reference;
    for (size_t i = 0; i < COUNT_OF(candidates) && !cancelled(search->cancel) && !search->failed;
         i++) {
        const bool explicit = candidates[i].kind == KIND_EXPLICIT;
        if ((explicit ? !explicit_ones : !others) || (search->bursts > 0 && candidates[i].tol == 0))
            continue; /* steps of one size, short enough for a burst, would be too many */
        if (search->left > 0 && try_candidate(search, &candidates[i])) {
            compare_solution(search, candidates[i].kind);
            const int parts = search->system->autonomous ? SPAN_PARTS : PARTS_IN_TIME;
            search->parts = search->parts > parts ? search->parts : parts;
            reference->bound = fabs(reference->span) / (STUDY_TIMES - 1) / search->parts;
        }
        if (reference->method[1] && reference->accuracy <= REFERENCE_AGREEMENT)
            break;
    }
}

/* Sets the error of a search that found no reference. Returns false. */
static bool reference_fail(const struct reference_search *search, struct error *error)
{
    if (search->failed)
        return error_memory(error);
    if (cancelled(search->cancel))
        return error_set(error, ERROR_CANCELLED,
                         "stopped while the reference solution was computed");
    if (search->left <= 0)
        return error_set(error, ERROR_NUMERICAL,
                         "errors cannot be measured, because no two methods of different kinds "
                         "reach the end of this scene within %.0e evaluations; use a shorter "
                         "duration",
                         COST_ALL / search->system->n);
    return error_set(error, ERROR_NUMERICAL,
                     "errors cannot be measured, because no two methods of different kinds reach "
                     "the end of this scene");
}

bool study_reference(const struct system *system, double span, const struct cancel *cancel,
                     struct reference *reference, struct error *error)
{
    return study_reference_again(system, span, fabs(span), cancel, reference, error);
}

/* Computes the reference of several methods again with shorter steps, at most `step` [s]. */
bool study_reference_again(const struct system *system, double span, double step,
                           const struct cancel *cancel, struct reference *reference,
                           struct error *error)
{
    /* number of steps in a grid interval that makes none longer than `step` */
    const double min = ceil(fmin(fabs(span) / (STUDY_TIMES - 1) / step, 1 << 16));
    const size_t size = (size_t)STUDY_TIMES * (size_t)system->n;
    *reference =
        (struct reference){.span = span, .meaning = span, .singular = {.t = NAN}, .n = system->n};
    reference->scored = system->order == 2 ? system->n / 2 : system->n;
    reference->y = calloc(size, sizeof *reference->y);
    if (!reference->y)
        return error_memory(error);
    if (system_has_exact(system)) {
        take_closed_form(system, reference);
        return true;
    }
    if (!reference_exists(system, reference, cancel, error))
        return false;
    struct system smooth =
        *system; /* the reference keeps its order, whatever is compared with it */
    system_turn_at_kinks(&smooth);
    struct reference_search search = {
        .system = &smooth, .reference = reference, .cancel = cancel, .size = size};
    search.parts = (int)fmax(min, 1);
    search.left = (int64_t)(COST_ALL / system->n);
    search.grid = calloc((KIND_COUNT + 1) * size, sizeof *search.grid);
    search.burst = calloc(BURSTS_MAX, sizeof *search.burst);
    search.node = calloc(BURST_NODES_MAX, sizeof *search.node);
    if (!search.grid || !search.burst || !search.node) {
        free(search.grid);
        free(search.burst);
        free(search.node);
        reference_free(reference);
        return error_memory(error);
    }
    const bool late = shrinks_fast(&smooth, span);
    search_kinds(&search, !late, true);
    if (late && !(reference->method[1] && reference->accuracy <= REFERENCE_AGREEMENT))
        search_kinds(&search, true, false);
    reference->shortest = search.bursts > 0 ? HUGE_VAL : 0;
    for (int i = 0; i < search.bursts; i++)
        reference->shortest =
            fmin(reference->shortest, fabs(search.burst[i].t_end - search.burst[i].t_begin));
    free(search.grid);
    free(search.burst);
    free(search.node);
    if (cancelled(cancel) || search.failed || !reference->method[1]) {
        reference_free(reference);
        return reference_fail(&search, error);
    }
    return true;
}
