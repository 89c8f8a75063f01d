/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Branch and prune: zeros of a vector field in a box, each with its proof, and what is left. */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/equilibria/boxes.h"
#include "modules/dynamics/orbits/forms.h"

/* The search ends when this many zeros are found: they may lie ever closer. */
enum { ZEROS_MAX = 5000 };

/* A zero lies in `tight`, and `unique` has no other. */
struct zero_proof {
    struct interval unique[FIELD_VARIABLES], tight[FIELD_VARIABLES];
};

struct zero_search {
    const struct equilibria_request *request;
    struct system bounded; /* equations that have bounds */
    int n;
    double width[FIELD_VARIABLES]; /* width of the range */
    double turn[FIELD_VARIABLES];  /* turn of an angle whose range is one full turn, else 0 */
    struct equilibria *found;      /* each solution is appended as it is proven */
    struct zero_proof *proof;      /* [capacity] belongs to found->solution */
    int capacity;
    struct box_queue waiting, singular;
    struct box_queue undecided; /* boxes that the search could not decide */
    int boxes;                  /* number of boxes examined */
    double done;                /* fraction of the volume that is done */
};

/* Searches all boxes that wait; false if out of memory. */
bool zeros_search(struct zero_search *search);

/* Looks for a zero by Newton's method from y [n] and keeps it if it is proven and in the range;
 * false if out of memory. */
bool zeros_prove_from(struct zero_search *search, const double *y);

/* Drops undecided boxes in which the only zero is one that is proven, unless there are so many that
 * it would take seconds. */
void zeros_drop_decided(struct zero_search *search);

/* Appends a solution, for which proof may be NULL; false if out of memory. */
bool zeros_append(struct zero_search *search, const double *y, const struct zero_proof *proof);

/* Moves y [n] to the zero that Newton's method finds; the last step is taken as it is where the
 * Jacobian is singular. */
void zeros_correct(const struct zero_search *search, double *y);

/* Returns true if y [n] lies in the range or on its edge, but for rounding. */
bool zeros_in_range(const struct zero_search *search, const double *y);

/* Returns true if all bounds [n] are finite. */
bool zeros_are_bounded(int n, const struct interval *bounds);
