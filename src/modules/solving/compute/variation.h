/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Variational equations S' = (df/dy) S + df/dp: derivatives of a scene's motion by its parameters
 * and by its initial state. Begin with variation_bind(), variation_of_start() or
 * variation_of_tangents(), add directions, then integrate variation.whole. */
#pragma once

#include "modules/solving/compute/solve.h"

#define VARIATION_DIRECTIONS 24 /* largest number of directions */

/* A force term that a parameter p changes: whether it exists, and its coefficients, at p + delta
 * and at p - delta. */
struct term_change {
    const struct term_row *row;
    bool is_present[2];       /* [0] at p + delta, [1] at p - delta */
    double c[2][TERM_VALUES]; /* coefficients there, 0 where it is not present */
};

/* Changes of the scene by one parameter p. */
struct parameter_change { /* one parameter */
    double apart;         /* distance 2 delta of the two values */
    struct term_change change[TERM_MAX];
    int changes;
    double start[LIMIT_VARIABLES], t0; /* derivatives of the initial state and of its time */
    bool starts;                       /* some of these derivatives are not 0 */
};

/* Finds what a parameter changes. Returns false if the scene cannot be bound around its value, or
 * if out of memory. */
bool direction_find(const struct scene *scene, int index, struct parameter_change *direction);

/* A scene and its derivatives as one system. */
struct variation {
    struct system base; /* the scene */
    /* base and its derivatives by each direction, n (1 + directions) variables of first order */
    struct system whole;
    int directions;
    struct parameter_change direction[VARIATION_DIRECTIONS];
    /* sign of the velocity, 1 or -1, for which dry friction is kept fixed, or 0 */
    double dry;
    bool trace; /* the last variable is the integral of the trace of df/dy */
};

/* Binds the scene with its derivatives by `count` parameters, for n (1 + count) <= LIMIT_VARIABLES.
 * The variation must not be moved, since its system points to it. Returns false if the scene or a
 * direction cannot be bound. */
bool variation_bind(struct variation *variation, const struct scene *scene, const int *index,
                    int count);

/* Prepares derivatives by the initial state, in units of size [n], for n (1 + n) <=
 * LIMIT_VARIABLES. */
void variation_of_start(struct variation *variation, const struct system *base, const double *size);
/* Does the same for the first `count` variables only. */
void variation_of_tangents(struct variation *variation, const struct system *base,
                           const double *size, int count);
/* Adds the derivative by one parameter, with a fixed initial state. Returns false if there are too
 * many variables or the direction cannot be bound. */
bool variation_add_parameter(struct variation *variation, const struct scene *scene, int index);
/* Adds, after these, the integral of the trace of df/dy from 0, which is the logarithm of the
 * determinant of the derivatives by the initial state (Liouville). Returns false if there are
 * too many variables. */
bool variation_add_trace(struct variation *variation);
