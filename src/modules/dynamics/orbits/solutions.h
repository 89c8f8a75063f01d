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
    const struct curve_problem *problem; /* of the one that it is */
    struct curve_work *work;
};

/* For a solution as a guess, at the field's present parameter; u [problem->n + 1] are its unknowns.
 * psize: unit of the parameter. */
bool solutions_begin(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct solution *guess, const struct cancel *cancel,
                     double *u, struct error *error);
void solutions_end(struct solution_curve *path);
/* Onto the curve at the guess's parameter; the tangent goes to growing (1) or falling (-1) ones. */
bool solutions_correct_at(struct solution_curve *path, const double *u, int sign,
                          struct curve_place *point);
/* What the point is; looks at it again, which costs one orbit. `extremes`: along an orbit. */
bool solutions_at(struct solution_curve *path, const struct curve_place *point, bool extremes,
                  struct solution *solution);
/* The same of the point that has just been corrected, multipliers as before the last correction. */
bool solutions_seen(struct solution_curve *path, const struct curve_place *point,
                    struct solution *solution);
/* What has changed its kind there, if that is a special point: not so neutral saddles. */
enum special solutions_special(const struct solution_curve *path, int test,
                               const struct solution *solution);

/* How the unknowns u of a special point, which solutions_begin() has found, go on along its branch,
 * [problem->n + 1]. */
bool solutions_along(struct solution_curve *path, const struct branch_point *special, double *u,
                     double *direction);
/*
 * Where the branch that leaves a special point begins: a solution of the other branch as the guess,
 * and the direction [problem->n + 1] in which it goes away. side: 1 or -1, of a crossing.
 */
bool solutions_leave(struct solution_curve *path, const struct scene *scene, int param,
                     double psize, const struct branch_point *point, int side,
                     const struct cancel *cancel, struct curve_place *first, struct error *error);

/* ---- the search for a periodic orbit (orbit.c), and along families of them (family.c) ---- */

struct orbit_search {
    const struct orbit_request *request;
    struct vector_field field;
    double state[DYNAMICS_VARIABLES], t;
    double extent; /* of the motion over the last span, in units of size */
    double first;  /* the same of the first span */
    int tries;
    struct found_orbit *found;
    bool any; /* *found is one, if not the wanted */
};

/* From this guess; across: a direction [1/SI] of the states and of the logarithm of the period in
 * which nothing moves, or NULL if there is none. False: there is none, or it is a rest. */
bool orbit_close(struct orbit_search *s, const double *state, double period, int multiple,
                 const double *normal, struct found_orbit *orbit);
/* Largest of the ranges of the variables along it, in units of size. */
double orbit_extent(const struct vector_field *field, const struct solution *solution);
/*
 * From an orbit of a family, *found, along it to the one with the period wanted [s], which *found
 * becomes. False: it has none, with its range of periods, or cancelled.
 */
bool orbit_of_period(struct orbit_search *s, double wanted, struct error *error);
