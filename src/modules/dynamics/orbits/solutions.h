/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One curve of equilibria or periodic orbits: from a solution to unknowns of a curve problem and
 * back, and the start of branches. solutions_begin(), solutions_correct_at(), solutions_at() for
 * each point, solutions_end(). */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/problem.h"

struct cancel;

/* A curve of solutions of one kind. */
struct solution_curve {
    struct vector_field field;
    enum solution_kind kind;
    union {
        struct equilibrium_curve equilibrium;
        struct orbit_curve orbit;
    };
    const struct curve_problem *problem; /* problem of `equilibrium` or of `orbit` */
    struct curve_work *work;             /* memory of the problem */
};

/* Prepares the curve for a solution as a guess, at the field's present parameter. Its unknowns are
 * written to u [problem->n + 1]. `psize` is the unit of the parameter. Returns false with `error`
 * filled if the curve cannot be set up. */
bool solutions_begin(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct solution *guess, const struct cancel *cancel,
                     double *u, struct error *error);
/* Frees what the curve holds. */
void solutions_end(struct solution_curve *path);
/* Corrects u onto the curve at its parameter. The tangent points to growing (1) or falling (-1)
 * values. Returns false if it does not converge. */
bool solutions_correct_at(struct solution_curve *path, const double *u, int sign,
                          struct curve_place *point);
/* Computes the solution at a point, which costs one orbit. `extremes` asks for extrema along an
 * orbit. Returns false if it cannot be computed. */
bool solutions_at(struct solution_curve *path, const struct curve_place *point, bool extremes,
                  struct solution *solution);
/* Computes the solution, with extrema, at the point that was corrected last. Multipliers are those
 * before the last correction, which saves flows. Returns false if it cannot be computed. */
bool solutions_seen(struct solution_curve *path, const struct curve_place *point,
                    struct solution *solution);
/* Returns the kind of special point at which the test is 0, or SPECIAL_NONE, as for neutral
 * saddles. */
enum special solutions_special(const struct solution_curve *path, int test,
                               const struct solution *solution);

/* Computes the direction [problem->n + 1] of the branch at a special point whose unknowns u
 * solutions_begin() has computed. For orbits u is recomputed. Returns false if a flow cannot be
 * followed. */
bool solutions_along(struct solution_curve *path, const struct branch_point *special, double *u,
                     double *direction);
/*
 * Finds the first place of the branch that leaves a special point: a solution on it and the
 * direction [problem->n + 1] away from the point. `side` is 1 or -1 at a crossing. Returns false
 * with `error` filled if none is found.
 */
bool solutions_leave(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct branch_point *point, int side,
                     const struct cancel *cancel, struct curve_place *first, struct error *error);

/* ---- the search for a periodic orbit (orbit.c), and along families of them (family.c) ---- */

/* State of orbit_find(). */
struct orbit_search {
    const struct orbit_request *request;
    struct vector_field field;
    double state[DYNAMICS_VARIABLES], t; /* present state and time of the motion */
    double extent; /* extent of the motion over the last span, in units of size */
    double first;  /* largest extent so far */
    int tries;     /* number of attempts to close an orbit */
    struct found_orbit *found;
    bool any; /* *found is an orbit, though perhaps not a stable one */
};

/* Closes an orbit from a guess. `normal` is a direction [1/SI] of the states and of the logarithm
 * of the period in which nothing moves, or NULL. Returns false if no orbit is found or if it is an
 * equilibrium. */
bool orbit_close(struct orbit_search *s, const double *state, double period, int multiple,
                 const double *normal, struct found_orbit *orbit);
/* Returns the largest range of a variable along the orbit, in units of its size. */
double orbit_extent(const struct vector_field *field, const struct solution *solution);
/*
 * Follows the family of orbits from *found to the one with the wanted period [s], which replaces
 * *found. Returns false with `error` filled if there is none, with the family's range of periods,
 * or if cancelled.
 */
bool orbit_of_period(struct orbit_search *s, double wanted, struct error *error);
