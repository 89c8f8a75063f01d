/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A motion with tangents that are kept orthonormal. */
#pragma once

#include "modules/dynamics/orbits/field.h"

struct cancel;

#define TANGENT_TOL 1e-12

enum tangents_end {
    TANGENTS_OK,
    TANGENTS_LEAVE, /* The motion has left every bound. */
    TANGENTS_JUMP,  /* The equations jump, and tangents with them. */
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

/* Begins at the scene's start. `scene` must outlive the tangents. Returns false with `error` filled
 * if the scene is refused. */
bool tangents_init(struct tangents *tangents, const struct scene *scene, int count,
                   const struct cancel *cancel, struct error *error);
void tangents_free(struct tangents *tangents);
/* Advances by `span` from t [s]. The tangents are orthonormal at the end. */
enum tangents_end tangents_advance(struct tangents *tangents, double t, double span);
/* y in its first turn */
void tangents_unwind(struct tangents *tangents);
int64_t tangents_evals(const struct tangents *tangents);
/* Makes the columns [count][n] orthonormal by Gram and Schmidt, twice. diagonal [count] becomes
 * their lengths. */
void tangents_orthonormalise(int n, int count, double *column, double *diagonal);
