/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Variational equations S' = (df/dy) S + df/dp: the derivatives of a scene's motion by its
 * parameters. */
#pragma once

#include "modules/solving/compute/solve.h"

#define VARIATION_DIRECTIONS 24 /* largest number of directions */

/* A term that a parameter changes: its coefficients at p + delta and p - delta. */
struct term_change {
    const struct term_row *row;
    bool is_present[2];
    double c[2][TERM_VALUES];
};

struct parameter_change { /* one parameter */
    double apart;         /* 2 delta */
    struct term_change change[TERM_MAX];
    int changes;
    double start[LIMIT_VARIABLES], t0; /* derivatives of the start */
    bool starts;                       /* some of these are not 0 */
};

/* Finds the terms that a parameter changes. Returns false if the scene has no motion on both
 * sides of the value. */
bool direction_find(const struct scene *scene, int index, struct parameter_change *direction);

struct variation {
    struct system base; /* the scene */
    /* base and its derivatives by each direction: n (1 + directions) variables of first order */
    struct system whole;
    int directions;
    struct parameter_change direction[VARIATION_DIRECTIONS];
    /* 1 or -1 if the base is frozen on the branch of dry friction on which the velocity has this
     * sign, else 0 */
    double dry;
    bool trace; /* the last variable of the whole is the integral of the trace of df/dy */
};

/* n (1 + count) <= LIMIT_VARIABLES. The variation must stay where it is: its system points to it.
 */
bool variation_bind(struct variation *variation, const struct scene *scene, const int *index,
                    int count);

/* Derivatives by the state at the start, in units of size [n]: n (1 + n) <= LIMIT_VARIABLES. */
void variation_of_start(struct variation *variation, const struct system *base, const double *size);
/* The same by the first `count` of its variables only. */
void variation_of_tangents(struct variation *variation, const struct system *base,
                           const double *size, int count);
/* Adds the derivative by one parameter of the scene, with a fixed initial state. Fails as
 * variation_bind(). */
bool variation_add_parameter(struct variation *variation, const struct scene *scene, int index);
/* Adds, after these, the integral of the trace of df/dy from 0, which is the logarithm of the
 * determinant of the derivatives by the initial state (Liouville). Returns false if there are
 * too many variables. */
bool variation_add_trace(struct variation *variation);
