/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A motion with tangents that are kept orthonormal. */
#pragma once

#include "modules/dynamics/orbits/field.h"

struct cancel;

#define TANGENT_TOL 1e-12

enum tangents_end {
    TANGENTS_OK,
    TANGENTS_LEAVE, /* beyond every bound */
    TANGENTS_JUMP,  /* of the equations: tangents are not continuous there */
    TANGENTS_STALL,
    TANGENTS_CANCELLED
};

struct tangents {
    struct vector_field field;
    struct variation variation;
    int n, count;
    double y[LIMIT_VARIABLES]; /* state, tangents in units of sizes, integral of the divergence */
    struct step step;
    struct controller controller;
    double growth[FIELD_VARIABLES]; /* logarithms, of what is gone through since they were 0 */
    double divergence;              /* the same: its integral */
    double elapsed;                 /* [s] since the start */
    double condition;               /* largest so far */
    int64_t steps;
    const struct method *method;
};

/* From the scene's start; it must stay where it is. */
bool tangents_init(struct tangents *tangents, const struct scene *scene, int count,
                   const struct cancel *cancel, struct error *error);
void tangents_free(struct tangents *tangents);
/* From t [s] for so long; at the end the tangents are orthonormal. */
enum tangents_end tangents_advance(struct tangents *tangents, double t, double span);
/* y in its first turn */
void tangents_unwind(struct tangents *tangents);
int64_t tangents_evals(const struct tangents *tangents);
/* Gram and Schmidt, twice: columns [count][n] become orthonormal, diagonal [count] their lengths.
 */
void tangents_orthonormalise(int n, int count, double *column, double *diagonal);
