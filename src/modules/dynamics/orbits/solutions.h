/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One curve of solutions of either kind, and where it begins. */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/problem.h"

struct cancel;

struct solution_curve {
    struct vector_field field;
    enum solution_kind kind;
    union {
        struct equilibrium_curve equilibrium;
        struct orbit_curve orbit;
    };
    const struct curve_problem *problem; /* problem of `equilibrium` or of `orbit` */
    struct curve_work *work;
};

/* Prepares the curve for a solution as a guess, at the field's present parameter. Its unknowns are
 * written to u [problem->n + 1]. `psize` is the unit of the parameter. Returns false with `error`
 * filled if the curve cannot be set up. */
bool solutions_begin(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct solution *guess, const struct cancel *cancel,
                     double *u, struct error *error);
void solutions_end(struct solution_curve *path);
/* Corrects u onto the curve at its parameter. The tangent points to growing (1) or falling (-1)
 * values. Returns false if it does not converge. */
bool solutions_correct_at(struct solution_curve *path, const double *u, int sign,
                          struct curve_place *point);
/* Computes the solution at a point, which costs one orbit. `extremes` asks for extrema along an
 * orbit. Returns false if it cannot be computed. */
bool solutions_at(struct solution_curve *path, const struct curve_place *point, bool extremes,
                  struct solution *solution);
/* The same of the point that has just been corrected, multipliers as before the last correction. */
bool solutions_seen(struct solution_curve *path, const struct curve_place *point,
                    struct solution *solution);
/* Returns the kind of special point at which the test is 0, or SPECIAL_NONE, as for neutral
 * saddles. */
enum special solutions_special(const struct solution_curve *path, int test,
                               const struct solution *solution);

/* Computes the direction [problem->n + 1] of the branch at a special point with unknowns u, which
 * solutions_begin() has found. Returns false if it has none. */
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

struct orbit_search {
    const struct orbit_request *request;
    struct vector_field field;
    double state[DYNAMICS_VARIABLES], t;
    double extent; /* extent of the motion over the last span, in units of size */
    double first;  /* extent over the first span */
    int tries;
    struct found_orbit *found;
    bool any; /* *found is an orbit, though not the wanted one. */
};

/* Closes an orbit from a guess. `normal` is a direction [1/SI] of the states and of the logarithm
 * of the period in which nothing moves, or NULL. Returns false if no orbit is found or if it is an
 * equilibrium. */
bool orbit_close(struct orbit_search *s, const double *state, double period, int multiple,
                 const double *normal, struct found_orbit *orbit);
/* Largest of the ranges of the variables along it, in units of size. */
double orbit_extent(const struct vector_field *field, const struct solution *solution);
/*
 * Follows the family of orbits from *found to the one with the wanted period [s], which replaces
 * *found. Returns false with `error` filled if there is none, with the family's range of periods,
 * or if cancelled.
 */
bool orbit_of_period(struct orbit_search *s, double wanted, struct error *error);
