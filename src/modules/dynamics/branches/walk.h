/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A walk along a branch in one direction, and the special points on its way: shared by the files of
 * this folder. branch_follow() in branch.c calls branch_begin(), walk_start(), then for each step
 * curve_next(), walk_record_specials(), walk_record_pairs() and branch_append(). */
#pragma once

#include "modules/dynamics/orbits/solutions.h"

/* Share of the time for following; the rest is for runs that check labels. */
#define FOLLOWING_TIME_FRACTION 0.8

/* Ranges of the one or two parameters, in their units; these are the last unknowns of the curve. */
struct curve_ranges {
    int count;
    double low[2], high[2];
};

/* State of a walk. */
struct branch_walk {
    const struct branch_request *request;
    struct solution_curve *path;
    struct branch *branch; /* points of this direction are appended */
    struct curve_ranges ranges;
    /* unit of the parameter, largest value of each test so far, period of the first orbit [s] */
    double psize, largest[CURVE_TESTS], period;
    double moved; /* relative change of the parameter in the last step, or 0 if unknown */
    int level;    /* number of successive places at one value of the parameter */
    bool away;    /* the walk has moved away from its start */
    int start;    /* index of the parameter among the unknowns at the start */
    struct curve_place known[CURVE_TESTS]; /* the last place at which that test was not 0 */
    bool any[CURVE_TESTS];                 /* true if there is such a place */
    struct curve_place opposite;           /* the first place on the other side of the start */
    int behinds;      /* number of unknowns at `opposite`, or 0 if it is not set */
    int behind_grows; /* number of values that grow there, or -1 if uncertain */
    /* the last place at which the number of growing values is certain */
    struct curve_place sure;
    double unit;        /* largest eigenvalue so far; 1 for multipliers */
    int sure_grows;     /* number that grow at `sure`, or -1 if there is no such place */
    int sure_point;     /* number of points at that time */
    int explained;      /* change of that number explained by special points since then */
    int fold_at;        /* index of the last fold of orbits, or 0 if there is none */
    bool fold_least;    /* the parameter is smallest there, not largest */
    double fold_spread; /* relative distance of folds that cannot be told apart */
    /* The place before the last one; valid if `bends`, when both have the same phase. */
    struct curve_place previous;
    bool bends;
    char *end;       /* [96] reason of the end */
    double told;     /* fraction reported as done */
    int side, sides; /* number of this direction, and of directions */
};

/* Returns true if the parameters of a place are in their ranges. */
bool ranges_contain(const struct curve_ranges *ranges, const struct curve_problem *problem,
                    const struct curve_place *place);
/* Moves *edge_point, beyond the ranges, back to where the curve from `start` leaves them. Returns
 * false if that place is not found. */
bool ranges_step_to_edge(const struct curve_ranges *ranges, const struct curve_problem *problem,
                         const struct curve_place *start, struct curve_place *edge_point);
/* Finds the next place, halving *step until the step succeeds and turns little. `longest` is the
 * longest step. `previous` may be NULL. `resolves`, unless NULL, is the walk whose tests must not
 * change their signs twice within the step. Returns false if no step is found or if cancelled. */
bool curve_next(const struct curve_problem *problem, const struct curve_place *previous,
                const struct curve_place *current, double *step, double longest,
                struct branch_walk *resolves, const struct cancel *cancel,
                struct curve_place *next);

#define SPECIALS_MOST 8    /* largest number of special points between two places */
#define SPECIALS_SAME 1e-6 /* Two of one kind within this part of the range are the same. */

/* A special point that has been located but not recorded yet. */
struct found_special {
    struct curve_place point;
    struct solution solution;
    enum special special;
    double distance, uncertainty; /* arclength from the previous place; of the location */
};

/* Appends a place of the curve to a branch, with its kind of special point and its solution.
 * Returns false if out of memory. */
bool branch_append(struct branch *branch, const struct solution_curve *path,
                   const struct curve_place *location, enum special special,
                   const struct solution *solution);
/* Records the special points between the last place and `next` that lie in the parameter's range,
 * in their order. `seen` is the solution at `next`, or NULL if unknown. Returns false if out of
 * memory. */
bool walk_record_specials(struct branch_walk *walk, const struct curve_place *next,
                          const struct solution *seen);
/* Initializes the signs of the tests at the start of a walk. A test that is 0 there takes its sign
 * from the other side of the start, if a walk has been there. */
void walk_start(struct branch_walk *walk, const struct curve_place *point);
/* Continues the walk from the same place in other unknowns: the signs of the tests are kept. */
void walk_go_on(struct branch_walk *walk, const struct curve_place *point);

/* Returns the number of eigenvalues or multipliers that become unstable or stable at such a
 * point. */
int special_passes(enum special special);
/* Moves a parameter that is beyond an edge of its range by rounding to the edge. Returns false if
 * it is farther beyond. */
bool is_in_range(const struct branch_request *request, double *param);
/* Appends to found [*count] the special points between two places at which tests have different
 * signs. Returns the number of eigenvalues that pass at them. */
int specials_by_signs(struct branch_walk *walk, const struct curve_place *a,
                      const struct curve_place *b, struct found_special *found, int *count);

/* Returns the sign of a test at a place: 0 where it is 0 but for rounding. */
int walk_sign(const struct branch_walk *walk, const struct curve_place *point, int test);
/* Locates the zero of a test between two places and determines its kind. Returns false if it is no
 * special point in the range. */
bool special_locate(struct branch_walk *walk, const struct curve_place *previous,
                    const struct curve_place *next, int test, struct found_special *found);
/* Appends a special point to the branch. Returns false if out of memory. */
bool special_record(struct branch_walk *walk, const struct found_special *found);

/* ---- begin.c ---- */

#define BRANCH_JUMP "the equations jump along the orbit, so multipliers are unknown"

/* Finds the first place of a branch. Side -1 goes against growing values of the parameter, so that
 * the branch is in order. Returns false with the reason if there is none. */
bool branch_begin(const struct branch_request *request, int side, double psize,
                  struct solution_curve *path, struct curve_place *first, struct error *error);
/* Returns true if the start is an orbit of a family, which has many at one value. */
bool branch_starts_in_family(const struct branch_request *request);
/* Sets *error to why an orbit of a family cannot be followed. Returns false. */
bool branch_refuse_family(struct error *error);

/* ---- pairs.c ---- */

/* Returns false if a test changes its sign more than once between two places of equilibria, so that
 * a shorter step is wanted. */
bool step_is_resolved(struct branch_walk *walk, const struct curve_place *current,
                      const struct curve_place *next);
/* Records pairs of special points near `point`, number `index` of the branch and the middle of
 * three successive places: a test that is nearest to 0 there, with one sign at all three, may have
 * passed 0 twice beside it. Returns false if out of memory. */
bool walk_record_pairs(struct branch_walk *walk, const struct curve_place *previous,
                       const struct curve_place *point, int index, const struct curve_place *next);

/* ---- together.c ---- */

/* Returns the number of eigenvalues or multipliers that grow, or -1 if one is too near to the
 * border or none are known. */
int walk_grows(struct branch_walk *walk, const struct solution *solution);
/* Finds special points, since the last place at which that number is known, that `found` [*count]
 * does not explain, and puts them into it. */
void specials_unseen(struct branch_walk *walk, const struct curve_place *next,
                     const struct solution *solution, struct found_special *found, int *count);
/* Notes a place at which that number is known (or -1). */
void specials_sure(struct branch_walk *walk, const struct curve_place *point, int grows);

/* ---- criticality.c ---- */

/* Returns the first Lyapunov coefficient of an equilibrium with eigenvalues +- i omega (Kuznetsov
 * 2004, eq. 5.62, <q, q> = <p, q> = 1, in SI units). If it is negative, the orbits that are born
 * are stable unless other eigenvalues grow. Sets *error to the uncertainty from differences.
 * Returns NAN if it is not found. */
double lyapunov_coefficient(struct vector_field *field, const double *state, double omega,
                            double *error);

/* ---- curves of special points (two_parameters.c) ---- */

/* Follows a curve of special points if the request has a second parameter; called by
 * branch_follow(), same contract. */
bool special_follow(const struct branch_request *request, struct branch *branch,
                    struct error *error);
/* Reverses the order of the points of a branch. */
void branch_reverse(struct branch *branch);
