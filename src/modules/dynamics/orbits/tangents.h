/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A motion with tangent vectors, which are kept orthonormal while their growth is recorded: what
 * Lyapunov exponents are computed from. tangents_init(), then tangents_advance() in turn, then
 * tangents_free(). */
#pragma once

#include "modules/dynamics/orbits/field.h"

struct cancel;

#define TANGENT_TOL 1e-12 /* relative tolerance of the integration */

/* Reasons why tangents_advance() has ended. */
enum tangents_end {
    TANGENTS_OK,
    TANGENTS_LEAVE, /* the motion has left every bound */
    TANGENTS_JUMP,  /* the equations jump, so that tangents are unknown */
    TANGENTS_STALL, /* no step is possible any more */
    TANGENTS_CANCELLED
};

/* State of a motion of n variables with `count` tangents. */
struct tangents {
    struct vector_field field;
    struct variation variation;
    int n, count;
    double y[LIMIT_VARIABLES]; /* state [n], tangents [count][n], integral of the divergence */
    struct step step;
    struct controller controller;
    /* logarithm of the growth in each direction, and integral of the divergence, since the caller
     * has set them to 0 */
    double growth[FIELD_VARIABLES];
    double divergence;
    double elapsed;   /* [s] time since the start */
    double condition; /* largest condition number of the tangents so far */
    int64_t steps;
    const struct method *method;
};

/* Begins at the scene's start. `scene` must outlive the tangents. Returns false with `error` filled
 * if the scene is refused. */
bool tangents_init(struct tangents *tangents, const struct scene *scene, int count,
                   const struct cancel *cancel, struct error *error);
void tangents_free(struct tangents *tangents);
/* Advances by `span` [s] from time t [s]. The tangents are orthonormal at the end. */
enum tangents_end tangents_advance(struct tangents *tangents, double t, double span);
/* Reduces angles of the state to one turn. */
void tangents_unwind(struct tangents *tangents);
/* Returns the number of evaluations of the right-hand side so far. */
int64_t tangents_evals(const struct tangents *tangents);
/* Makes the vectors column [count][n] orthonormal by the Gram-Schmidt process, applied twice.
 * diagonal [count] becomes the lengths that they had after their projections were removed. */
void tangents_orthonormalise(int n, int count, double *column, double *diagonal);
