/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Attractors: learned where a motion repeats (walk_learn), and recognized when another motion comes
 * near (walker_check). */
#include "modules/dynamics/basins/basins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hooke/base/numeric.h>

#include "modules/solving/compute/algebra.h"

/* Distance from the centre, in sizes, beyond which a motion escapes. */
#define ESCAPE_SIZES 1e6
#define RECURRENCE_SIZES 1e-8     /* distance, in sizes, within which a state has recurred */
#define RECURRENCES_MIN 3         /* successive recurrences, in periods, of a motion that repeats */
#define ATTRACTOR_NEAR_SIZES 1e-3 /* distance, in sizes, within which a motion is near one */
#define NEAR_CHECKS_MIN 3         /* successive looks near an attractor after which it is reached */
/* Two attractors found are the same within this distance, in sizes. */
#define ATTRACTORS_SAME_SIZES 1e-5
/* Number of successive checks in the cells of an irregular attractor after which it is reached. */
#define CLOUD_CHECKS_INSIDE 24
#define CLOUD_CHECKS 6000        /* number of checks from which the visited cells are collected */
#define ORBIT_TURN_STEPS 1000    /* largest number of steps of a turn around an orbit */
#define ORBIT_TURN_CHECKS_MAX 50 /* longest turn, in times between checks */
/* An orbit whose multipliers are within this distance of 1 attracts nothing. */
#define MULTIPLIER_NEUTRAL_MARGIN 1e-7
#define ORBIT_CLOSED_SIZES 1e-6 /* distance, in sizes, within which an orbit has closed */

/* ---- distances ---- */

/* Returns the distance, in sizes, of y from the states or the line of an attractor. */
static double attractor_distance(const struct basin_walk *walk, const struct attractor *a,
                                 const double *y)
{
    double least = HUGE_VAL, nearest[FIELD_VARIABLES];
    for (int k = 0; k < a->points; k++) {
        const double *vertex = a->point + k * walk->n;
        const bool is_line = a->basin.kind == BASIN_ORBIT && k + 1 < a->points;
        if (is_line)
            field_nearest_on_line(&walk->field, y, vertex, vertex + walk->n, nearest);
        least = fmin(least, field_distance(&walk->field, y, is_line ? nearest : vertex));
    }
    return least;
}

/* ---- a grid of cells over state space, for up to three variables ---- */

/* Returns the number of cells along one variable, or 0 for more than three variables. */
static int cells_of(int n)
{
    static const int cells[] = {[1] = 128, [2] = 128, [3] = 48};
    return n < (int)COUNT_OF(cells) ? cells[n] : 0;
}

/* Returns the index of the cell of y, shifted by cell_shift [n] cells unless that is NULL, or -1 if
 * it is outside of the grid. */
static long cell_at(const struct basin_walk *walk, const double *y, const int *cell_shift)
{
    const int cells = cells_of(walk->n);
    long cell_index = 0;
    for (int i = 0; i < walk->n; i++) {
        /* the grid covers twice the range of the starts */
        const double share = (y[i] - walk->centre[i]) / walk->field.size[i] / 4 + 0.5;
        const int place =
            (int)floor(fmin(fmax(share * cells, -2), cells + 2)) + (cell_shift ? cell_shift[i] : 0);
        if (place < 0 || place >= cells)
            return -1;
        cell_index = cell_index * cells + place;
    }
    return cell_index;
}

/* Marks the cell of y and its neighbours. */
static void mark_cells(const struct basin_walk *walk, unsigned char *cell, const double *y)
{
    int cell_shift[3] = {-1, -1, -1};
    for (int k = 0; k < 27; k++) {
        cell_shift[0] = k % 3 - 1, cell_shift[1] = k / 3 % 3 - 1, cell_shift[2] = k / 9 - 1;
        const long cell_index = cell_at(walk, y, cell_shift);
        if (cell_index >= 0)
            cell[cell_index] = 1;
    }
}

/* ---- one motion ---- */

void walker_start(const struct basin_walk *walk, struct walker *walker, const double *y)
{
    *walker = (struct walker){.attractor = -1};
    memcpy(walker->y, y, (size_t)walk->n * sizeof *y);
}

/* Returns true if y is near a stable attractor, or in a cell of an irregular one. */
static bool is_near(const struct basin_walk *walk, const struct attractor *a, const double *y)
{
    if (!a->cell)
        return a->basin.stable && attractor_distance(walk, a, y) < ATTRACTOR_NEAR_SIZES;
    const long cell_index = cell_at(walk, y, NULL);
    return cell_index >= 0 && a->cell[cell_index];
}

/* Counts the successive checks, this one included, at which the walker is near the same attractor
 * (w->attractor, w->near_count). Returns its index once there are enough of them, else
 * BASIN_MISSING. An attractor that is known by cells (a cloud) needs CLOUD_CHECKS_INSIDE of
 * them. */
static int approached_attractor(const struct basin_walk *walk, struct walker *w)
{
    const bool stays = w->attractor >= 0 && is_near(walk, &walk->attractor[w->attractor], w->y);
    w->near_count = stays ? w->near_count + 1 : 0;
    for (int k = 0; k < walk->attractors && !stays; k++)
        if (is_near(walk, &walk->attractor[k], w->y)) {
            w->attractor = k;
            w->near_count = 1;
            break;
        }
    if (w->near_count == 0)
        return BASIN_MISSING;
    const bool is_cloud = walk->attractor[w->attractor].cell;
    const int checks_min = is_cloud ? CLOUD_CHECKS_INSIDE : NEAR_CHECKS_MIN;
    return w->near_count >= checks_min ? w->attractor : BASIN_MISSING;
}

/* Compares the state with those of earlier checks, the latest first. Returns true if the walker has
 * repeatedly been where it was w->period checks before: RECURRENCES_MIN times in each phase of that
 * period. Sets w->recurrences and w->period. */
static bool has_repeated(const struct basin_walk *walk, struct walker *w)
{
    for (int q = 1; q < WALK_PAST && q < w->checks; q++) {
        if (field_distance(&walk->field, w->y, w->past[(w->checks - q) % WALK_PAST]) >=
            RECURRENCE_SIZES)
            continue;
        w->recurrences = q == w->period ? w->recurrences + 1 : 1;
        w->period = q;
        return w->recurrences >= RECURRENCES_MIN * q;
    }
    w->recurrences = 0;
    return false;
}

/* Angles are reduced to one turn, then escape, nearness to known attractors and recurrence are
 * tested, in this order. A motion that repeats is undecided here: the caller may learn its
 * attractor (walk_learn). */
int walker_check(const struct basin_walk *walk, struct walker *w)
{
    for (int i = 0; i < walk->n; i++) {
        const double turn = walk->field.turn[i];
        if (turn > 0 && fabs(w->y[i]) > turn)
            w->y[i] = remainder(w->y[i], turn);
        if (!(fabs(w->y[i] - walk->centre[i]) < ESCAPE_SIZES * walk->field.size[i]))
            return BASIN_ESCAPES;
    }
    w->checks++;
    w->found = false;
    const int fate = approached_attractor(walk, w);
    if (fate >= 0)
        return fate;
    w->found = has_repeated(walk, w);
    memcpy(w->past[w->checks % WALK_PAST], w->y, sizeof w->past[0]);
    if (w->found)
        return BASIN_UNDECIDED;
    return w->checks >= WALK_CHECKS_MAX ? BASIN_UNDECIDED : BASIN_MISSING;
}

/* ---- new attractors ---- */

/* Returns true if an autonomous motion rests at y. */
static bool is_equilibrium(struct basin_walk *walk, const double *y)
{
    double rate[FIELD_VARIABLES], most = 0;
    field_rate(&walk->field, y, rate);
    for (int i = 0; i < walk->n; i++)
        most = fmax(most, fabs(rate[i]) / walk->field.size[i]);
    return !walk->forced && most * walk->strobe < 1e-5;
}

/* Sets basin->growth to the largest real part of an eigenvalue [1/s] of an equilibrium, or the
 * largest magnitude of a multiplier of an orbit or response, or NAN if unknown. The multiplier
 * along an orbit, which is 1 (the one closest to 1), does not count. Sets basin->stable, which is
 * true if differences decay or if that is unknown. */
static void find_growth(struct basin_walk *walk, struct basin *basin)
{
    struct flow_slopes *slopes = malloc(sizeof *slopes);
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], end[FIELD_VARIABLES];
    struct eigenvalue value[FIELD_VARIABLES];
    const int n = walk->n;
    bool known = slopes;
    basin->growth = NAN;
    if (basin->kind == BASIN_EQUILIBRIUM) {
        field_jacobian(&walk->field, basin->state, jacobian);
        known = matrix_eigenvalues(n, jacobian, value);
    } else if (known) {
        known = field_flow(&walk->field, walk->field.system.t0, basin->state, basin->period, end,
                           slopes) &&
                matrix_eigenvalues(n, slopes->by_start, value);
    }
    int trivial = -1;
    for (int i = 0; known && i < n && basin->kind == BASIN_ORBIT; i++)
        if (trivial < 0 ||
            hypot(value[i].re - 1, value[i].im) < hypot(value[trivial].re - 1, value[trivial].im))
            trivial = i;
    for (int i = 0; known && i < n; i++) {
        const double size =
            basin->kind == BASIN_EQUILIBRIUM ? value[i].re : hypot(value[i].re, value[i].im);
        if (i != trivial)
            basin->growth = isnan(basin->growth) ? size : fmax(basin->growth, size);
    }
    const double most = basin->kind == BASIN_EQUILIBRIUM ? 0 : 1;
    basin->stable =
        !known || isnan(basin->growth) || basin->growth < most * (1 - MULTIPLIER_NEUTRAL_MARGIN);
    free(slopes);
}

/* Adds an attractor and takes over its memory. Returns its index, or BASIN_UNDECIDED if there is no
 * room, no memory, or if it is an orbit of a family, which attracts nothing. */
static int add_attractor(struct basin_walk *walk, struct attractor *a)
{
    if (walk->attractors == BASINS_MOST || !(a->point || a->cell)) {
        free(a->point);
        free(a->cell);
        return BASIN_UNDECIDED;
    }
    if (a->basin.kind != BASIN_IRREGULAR)
        find_growth(walk, &a->basin);
    if (a->basin.kind == BASIN_ORBIT && !a->basin.stable) { /* one of a family */
        free(a->point);
        return BASIN_UNDECIDED;
    }
    walk->attractor[walk->attractors] = *a;
    return walk->attractors++;
}

/* Returns the index of the known attractor within `tolerance` (in sizes) of y, or BASIN_MISSING. */
static int find_known(const struct basin_walk *walk, const double *y, double tolerance)
{
    for (int k = 0; k < walk->attractors; k++)
        if (!walk->attractor[k].cell &&
            attractor_distance(walk, &walk->attractor[k], y) < tolerance)
            return k;
    return BASIN_MISSING;
}

/* Moves y [n] to the nearby equilibrium that the motion approaches, by at most three steps of
 * Newton's method. It stops if a step would be longer than ATTRACTORS_SAME_SIZES natural sizes,
 * which may lead elsewhere, or if the Jacobian is singular. */
static void settle_state(struct basin_walk *walk, double *y)
{
    double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], correction[FIELD_VARIABLES];
    for (int pass = 0; pass < 3; pass++) {
        bool small = true;
        field_rate(&walk->field, y, correction);
        field_jacobian(&walk->field, y, jacobian);
        if (!matrix_solve(walk->n, jacobian, correction))
            return;
        for (int i = 0; i < walk->n; i++)
            small = small && fabs(correction[i]) < ATTRACTORS_SAME_SIZES * walk->field.size[i];
        for (int i = 0; small && i < walk->n; i++)
            y[i] -= correction[i];
    }
}

/* Learns the attractor of a motion that repeats at checks: an equilibrium, or with a drive the
 * response to it, with one point for each check of its period, the latest first. Returns the index
 * of the attractor, also if it is known already, or BASIN_UNDECIDED if there is no room for one
 * more. */
static int learn_points(struct basin_walk *walk, const struct walker *w)
{
    const int known = find_known(walk, w->y, ATTRACTORS_SAME_SIZES);
    if (known >= 0)
        return known;
    const int n = walk->n;
    struct attractor a = {.points = 1, .basin = {.kind = BASIN_EQUILIBRIUM}};
    if (walk->forced) {
        a.points = a.basin.multiple = w->period;
        a.basin.kind = BASIN_RESPONSE;
        a.basin.period = w->period * walk->strobe;
    }
    memcpy(a.basin.state, w->y, (size_t)n * sizeof *w->y);
    if (!walk->forced)
        settle_state(walk, a.basin.state);
    a.point = malloc((size_t)(a.points * n) * sizeof *a.point);
    for (int k = 0; a.point && k < a.points; k++)
        memcpy(a.point + k * n, w->past[(w->checks + WALK_PAST - k) % WALK_PAST],
               (size_t)n * sizeof *w->y);
    return add_attractor(walk, &a);
}

/* Returns the period of the closed orbit through `start`: the time until the motion crosses the
 * plane across its start again, in the same direction and near the start. Returns 0 if it does not
 * within ORBIT_TURN_STEPS steps of the integration, or cannot be followed. Sets *closure_error to
 * the distance from the start, in natural sizes, at the last such crossing, and leaves it unchanged
 * if there is none. */
static double orbit_period(struct basin_walk *walk, const double *start, double *closure_error)
{
    struct field_plane plane;
    double y[2][FIELD_VARIABLES], end[FIELD_VARIABLES], far = 0, previous_side = 0;
    const double h = walk->strobe / (ORBIT_TURN_STEPS / ORBIT_TURN_CHECKS_MAX),
                 t0 = walk->field.system.t0;
    field_plane_across(&walk->field, start, &plane);
    memcpy(y[0], start, sizeof y[0]);
    for (int k = 0; k < ORBIT_TURN_STEPS; k++) {
        double *now = y[(k + 1) % 2];
        if (!field_flow(&walk->field, t0, y[k % 2], h, now, NULL))
            return 0;
        const double gone = field_distance(&walk->field, now, start),
                     side = field_side(&walk->field, &plane, now);
        far = fmax(far, gone);
        if (previous_side < 0 && side >= 0 && gone < far / 2) {
            const double when = field_crossing(&walk->field, t0, y[k % 2], h, now, &plane, end);
            *closure_error = field_distance(&walk->field, end, start);
            if (!isfinite(when) || *closure_error < far / 20)
                return isfinite(when) ? k * h + when : 0;
        }
        previous_side = side;
    }
    return 0;
}

/* Tests whether the state of walker w lies on a closed orbit, and adds that to the attractors
 * unless it is known. Returns the attractor's index, BASIN_MISSING if the motion does not close, or
 * what add_attractor() returns on failure. */
static int learn_orbit(struct basin_walk *walk, struct walker *w)
{
    const int n = walk->n;
    const double tol = walk->field.tol;
    double closure_error = HUGE_VAL;
    walk->field.tol = 1e-10;
    const double period =
        walk->forced || is_equilibrium(walk, w->y) ? 0 : orbit_period(walk, w->y, &closure_error);
    walk->field.tol = tol;
    if (!(period > 0) || closure_error > ORBIT_CLOSED_SIZES)
        return BASIN_MISSING;
    const int known = find_known(walk, w->y, ATTRACTOR_NEAR_SIZES);
    if (known >= 0)
        return known;
    struct attractor a = {.points = FIELD_TIMES, .basin = {.kind = BASIN_ORBIT, .period = period}};
    memcpy(a.basin.state, w->y, (size_t)n * sizeof *w->y);
    a.point = malloc((size_t)(a.points * n) * sizeof *a.point);
    if (a.point && !field_follow(&walk->field, walk->field.system.t0, w->y, period, a.point)) {
        free(a.point);
        return BASIN_MISSING;
    }
    return add_attractor(walk, &a);
}

/* Returns true if the spread of a motion falls from each third of it to the next in every variable:
 * it is still on its way. spread [3][n]: highest less lowest value. */
static bool spread_shrinks(int n, double (*spread)[FIELD_VARIABLES])
{
    static const double shrinking = 0.98;
    for (int i = 0; i < n; i++)
        if (!(spread[1][i] < shrinking * spread[0][i] && spread[2][i] < shrinking * spread[1][i]))
            return false;
    return true;
}

/* Follows a motion for CLOUD_CHECKS checks and, if it remains irregular, adds an attractor that
 * consists of the cells it visits. Returns the index of that attractor, the fate of the motion if
 * it comes to a known attractor or escapes, or BASIN_UNDECIDED if the visited region still shrinks,
 * if out of memory or if cancelled. */
static int learn_region(struct basin_walk *walk, struct walker *w)
{
    const int cells = cells_of(walk->n);
    size_t size = 1;
    for (int i = 0; i < walk->n; i++)
        size *= (size_t)cells;
    struct stepper *stepper = cells > 0 ? stepper_create(walk) : NULL;
    struct attractor a = {
        .cell = stepper ? calloc(size, 1) : NULL,
        .basin = {.kind = BASIN_IRREGULAR, .period = NAN, .growth = NAN, .stable = true}};
    int fate = BASIN_MISSING;
    double spread[3][FIELD_VARIABLES] = {{0}}, low[FIELD_VARIABLES], high[FIELD_VARIABLES];
    for (int k = 0; a.cell && k < CLOUD_CHECKS && fate == BASIN_MISSING; k++) {
        stepper_advance(stepper, w, 1);
        w->checks = 0; /* no limit on the number of looks */
        fate = cancelled(walk->field.cancel) ? BASIN_UNDECIDED : walker_check(walk, w);
        mark_cells(walk, a.cell, w->y);
        for (int i = 0; i < walk->n; i++) {
            const bool begins = k % (CLOUD_CHECKS / 3) == 0;
            low[i] = begins ? w->y[i] : fmin(low[i], w->y[i]);
            high[i] = begins ? w->y[i] : fmax(high[i], w->y[i]);
            spread[k / (CLOUD_CHECKS / 3)][i] = high[i] - low[i];
        }
    }
    if (fate == BASIN_MISSING && spread_shrinks(walk->n, spread))
        fate = BASIN_UNDECIDED;
    stepper_free(stepper);
    memcpy(a.basin.state, w->y, (size_t)walk->n * sizeof *w->y);
    if (fate == BASIN_MISSING && a.cell)
        return add_attractor(walk, &a);
    free(a.cell);
    return fate == BASIN_MISSING ? BASIN_UNDECIDED : fate;
}

/* Tries a recurring state, then a closed orbit, then, after WALK_CHECKS_MAX checks, an irregular
 * region. */
int walk_learn(struct basin_walk *walk, struct walker *w)
{
    if (w->found && (walk->forced || is_equilibrium(walk, w->y)))
        return learn_points(walk, w);
    const int orbit = learn_orbit(walk, w);
    if (orbit != BASIN_MISSING || w->checks < WALK_CHECKS_MAX)
        return orbit;
    return learn_region(walk, w);
}
