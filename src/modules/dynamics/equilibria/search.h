/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Branch and prune: finds the zeros of a vector field in a box, each with its proof, and the boxes
 * that remain undecided. Fill in a struct zero_search with one waiting box, call zeros_search(),
 * zeros_drop_decided() and, for what remains, zeros_prove_from(). */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/equilibria/boxes.h"
#include "modules/dynamics/orbits/forms.h"

/* The search ends when this many zeros are found, as they may lie ever closer to each other. */
enum { ZEROS_MAX = 5000 };

/* Proof of a zero: it lies in `tight`, and `unique` contains no other one. */
struct zero_proof {
    struct interval unique[FIELD_VARIABLES], tight[FIELD_VARIABLES];
};

/* State of a search. The owner frees the arrays. */
struct zero_search {
    const struct equilibria_request *request;
    struct system bounded; /* equations that have bounds */
    int n;
    double width[FIELD_VARIABLES]; /* width of the requested range of each variable */
    double turn[FIELD_VARIABLES];  /* turn of an angle whose range is one full turn, else 0 */
    struct equilibria *found;      /* each solution is appended as it is proven */
    struct zero_proof *proof;      /* [capacity] proofs of found->solution */
    int capacity;
    /* boxes to be examined, and boxes without bounds, which are cut when no others wait */
    struct box_queue waiting, singular;
    struct box_queue undecided; /* boxes that the search could not decide */
    int boxes;                  /* number of boxes examined */
    double done;                /* fraction of the volume that is done */
};

/* Examines all waiting boxes, up to a limit or Ctrl-C; the remaining ones become undecided. Returns
 * false if out of memory. */
bool zeros_search(struct zero_search *search);

/* Searches a zero by Newton's method from y [n], and appends it if it is proven, new and in the
 * range. Returns false if out of memory. */
bool zeros_prove_from(struct zero_search *search, const double *y);

/* Drops undecided boxes that lie where a proven zero is the only one, unless there are so many that
 * this would take seconds. */
void zeros_drop_decided(struct zero_search *search);

/* Appends a solution. proof is NULL if there is none, which solution->multiple = 1 records. Returns
 * false if out of memory. */
bool zeros_append(struct zero_search *search, const double *y, const struct zero_proof *proof);

/* Moves y [n] by Newton's method, until steps are rounding or the Jacobian is singular. */
void zeros_correct(const struct zero_search *search, double *y);

/* Returns true if y [n] lies in the requested range or, to rounding, on its edge. */
bool zeros_in_range(const struct zero_search *search, const double *y);

/* Returns true if all bounds [n] are finite. */
bool zeros_are_bounded(int n, const struct interval *bounds);
