/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A walk along a branch in one direction, and the special points on its way. */
#pragma once

#include "modules/dynamics/orbits/solutions.h"

/* Share of the time for following; the rest is for runs that check labels. */
#define FOLLOWING_TIME_FRACTION 0.8

/* Ranges of the one or two parameters, which are the last unknowns, in their units. */
struct curve_ranges {
    int count;
    double low[2], high[2];
};

struct branch_walk {
    const struct branch_request *request;
    struct solution_curve *path;
    struct branch *branch; /* points of this direction are appended */
    struct curve_ranges ranges;
    double psize, largest[CURVE_TESTS], period;
    double moved; /* relative change of the parameter in the last step */
    int level;    /* number of successive places at one value of the parameter */
    bool away;    /* It has moved away from its start. */
    int start;    /* index of the parameter among the unknowns at the start */
    struct curve_place known[CURVE_TESTS]; /* the last place at which that test was not 0 */
    bool any[CURVE_TESTS];
    struct curve_place opposite; /* the first place on the other side of the start */
    int behinds;                 /* number of unknowns at `opposite`, or 0 if it is not set */
    int behind_grows;            /* number of values that grow there, or -1 if uncertain */
    /* the last place at which the number of growing values is certain */
    struct curve_place sure;
    double unit;        /* largest eigenvalue so far; 1 for multipliers */
    int sure_grows;     /* number that grow at `sure`, or -1 if there is no such place */
    int sure_point;     /* number of points at that time */
    int explained;      /* change of that number explained by special points since then */
    int fold_at;        /* index of the last fold of orbits, or 0 if there is none */
    bool fold_least;    /* The parameter is smallest there, not largest. */
    double fold_spread; /* relative distance of folds that cannot be told apart */
    /* The place before the last one; valid if `bends`, when both have the same phase. */
    struct curve_place previous;
    bool bends;
    char *end;   /* [96] reason of the end */
    double told; /* fraction reported as done */
    int side, sides;
};

bool ranges_contain(const struct curve_ranges *ranges, const struct curve_problem *problem,
                    const struct curve_place *place);
/* Moves a place beyond the ranges back to where the curve leaves them; false if that is not found.
 */
bool ranges_step_to_edge(const struct curve_ranges *ranges, const struct curve_problem *problem,
                         const struct curve_place *start, struct curve_place *edge_point);
/* Finds the next place, with as long a step as is safe, at most *step; before and resolves may be
 * NULL. Returns false if none is found, or cancelled. */
bool curve_next(const struct curve_problem *problem, const struct curve_place *previous,
                const struct curve_place *current, double *step, double longest,
                struct branch_walk *resolves, const struct cancel *cancel,
                struct curve_place *next);

#define SPECIALS_MOST 8    /* largest number of special points between two places */
#define SPECIALS_SAME 1e-6 /* Two of one kind within this part of the range are the same. */

struct found_special {
    struct curve_place point;
    struct solution solution;
    enum special special;
    double distance, uncertainty;
};

/* Appends a place of the curve with what it is; returns false if out of memory. */
bool branch_append(struct branch *branch, const struct solution_curve *path,
                   const struct curve_place *location, enum special special,
                   const struct solution *solution);
/* Records the special points between the last place and this one that lie in the parameter's range,
 * in their order. `seen` is the solution at `next`. Returns false if out of memory. */
bool walk_record_specials(struct branch_walk *walk, const struct curve_place *next,
                          const struct solution *seen);
/* Tests begin at the start. What is 0 there has the sign that it has behind it, if that is known.
 */
void walk_start(struct branch_walk *walk, const struct curve_place *point);
/* The same place in other unknowns: signs stay what they are. */
void walk_go_on(struct branch_walk *walk, const struct curve_place *point);

/* Returns the number of eigenvalues that pass at such a point. */
int special_passes(enum special special);
/* Moves what is nearly on an edge to the edge. Returns false if it is beyond. */
bool is_in_range(const struct branch_request *request, double *param);
/* Those between two places whose tests have different signs; how many values pass at them. */
int specials_by_signs(struct branch_walk *walk, const struct curve_place *a,
                      const struct curve_place *b, struct found_special *found, int *count);

/* Returns the sign of a test at a place: 0 where it is 0 but for rounding. */
int walk_sign(const struct branch_walk *walk, const struct curve_place *point, int test);
/* Finds what the zero of a test between two places is; false if it is none in the range. */
bool special_locate(struct branch_walk *walk, const struct curve_place *previous,
                    const struct curve_place *next, int test, struct found_special *found);
/* Appends a special point; false if out of memory. */
bool special_record(struct branch_walk *walk, const struct found_special *found);

/* ---- begin.c ---- */

#define BRANCH_JUMP "the equations jump along the orbit, so multipliers are unknown"

/* Finds the first place of a branch. Side -1 goes against growing values of the parameter, so that
 * the branch is in order. Returns false with the reason if there is none. */
bool branch_begin(const struct branch_request *request, int side, double psize,
                  struct solution_curve *path, struct curve_place *first, struct error *error);
/* Returns true if the start is an orbit of a family, which has many at one value. */
bool branch_starts_in_family(const struct branch_request *request);
bool branch_refuse_family(struct error *error);

/* ---- pairs.c ---- */

/* Returns false if a test changes its sign more than once between two places of equilibria, so that
 * a shorter step is wanted. */
bool step_is_resolved(struct branch_walk *walk, const struct curve_place *current,
                      const struct curve_place *next);
/*
 * Records pairs of special points that hide around the last place: of three places in a row a test
 * may be nearest to 0 at the middle one, `point`, which is point number `index`, and have passed 0
 * twice beside it. False if out of memory.
 */
bool walk_record_pairs(struct branch_walk *walk, const struct curve_place *previous,
                       const struct curve_place *point, int index, const struct curve_place *next);

/* ---- together.c ---- */

/* Returns the number of values that grow, or -1 if that of one is uncertain or there are none. */
int walk_grows(struct branch_walk *walk, const struct solution *solution);
/* Those since the last place of which that is known that the ones found do not explain. */
void specials_unseen(struct branch_walk *walk, const struct curve_place *next,
                     const struct solution *solution, struct found_special *found, int *count);
void specials_sure(struct branch_walk *walk, const struct curve_place *point, int grows);

/* ---- criticality.c ---- */

/*
 * Returns the first Lyapunov coefficient of an equilibrium with eigenvalues +- i omega (Kuznetsov
 * 2004, eq. 5.62, <q, q> = <p, q> = 1, in the scene's own units). < 0: the orbits that are born are
 * stable where everything else is. *error is the uncertainty from differences. Returns NAN if it is
 * not found.
 */
double lyapunov_coefficient(struct vector_field *field, const double *state, double omega,
                            double *error);

/* ---- curves of special points (two_parameters.c) ---- */

/* branch_follow() where there is a second parameter. */
bool special_follow(const struct branch_request *request, struct branch *branch,
                    struct error *error);
/* Its points in the opposite order. */
void branch_reverse(struct branch *branch);
