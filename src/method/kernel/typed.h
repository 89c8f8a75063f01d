/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Forces for kernels that call them: programs of typed scenes and built-in terms as functions of
 * the same type. known_take() prepares them once per march; then *_slope, *_force and *_drag below
 * evaluate them. A force of one coordinate takes and returns its values in registers.
 */
#pragma once

#include <hooke/scene/formula.h>
#include "method/control/march_body.h"

enum { FRAME = 512 }; /* [double] memory of all programs of a scene */

/* A term of a sum of forces: a program, or a built-in term. */
struct typed_addend {
    program_function *run; /* program, or NULL for a built-in term */
    const struct program *program;
    const struct bound_term *term;
    double *frame; /* memory of the program */
};

/* A sum of terms. */
struct typed_sum {
    struct typed_addend part[TERM_MAX];
    int parts;
    struct typed_addend all; /* the only part, or a function that adds all parts */
};

/* All forces, those that do not depend on velocity, and those that do. */
struct typed_forces {
    struct typed_sum whole, force, drag;
    double frame[FRAME];
};

/* Prepares the forces of a system. Returns false if its programs need more than FRAME, or if it is
 * neither typed nor an equation of motion of one or two coordinates. */
bool known_take(struct typed_forces *known, const struct system *system);

/* Returns true if the sum has one part, which is a program. */
bool sum_is_one(const struct typed_sum *sum);

/* Evaluates the part into output [rows], for n state variables y. */
INLINE void part_evaluate(const struct typed_addend *part, int n, int rows, double t,
                          const double *y, double *output)
{
    const struct leading leading =
        part->run(part->program, t, y[0], n > 1 ? y[1] : 0, n > 2 ? y : NULL, part->term->c + 1,
                  rows > 2 ? output : NULL, part->frame);
    output[0] = leading.first;
    if (rows > 1)
        output[1] = leading.second;
}

/* Evaluates the sum of all parts into output [rows]. */
INLINE void one_evaluate(const struct typed_sum *sum, int n, int rows, double t, const double *y,
                         double *output)
{
    part_evaluate(&sum->all, n, rows, t, y, output);
}

/* Shapes by the number of variables: equations of motion, and systems of first order. */
#define TYPED_MOTIONS(S) S(typed_line, 2) S(typed_plane, 4)
#define TYPED_FLOWS(S) S(typed_two, 2) S(typed_three, 3) S(typed_one, 1)

#define KNOWN(known) ((const struct typed_forces *)(known))
#define MOTION_FUNCTIONS(name, n)                                                                  \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)           \
    {                                                                                              \
        copy_numbers((n) / 2, y + (n) / 2, dydt);                                                  \
        one_evaluate(&KNOWN(known)->whole, n, (n) / 2, t, y, dydt + (n) / 2);                      \
    }
#define FLOW_FUNCTIONS(name, n)                                                                    \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)           \
    {                                                                                              \
        one_evaluate(&KNOWN(known)->whole, n, n, t, y, dydt);                                      \
    }
#define SPLIT_FUNCTIONS(name, n)                                                                   \
    INLINE void name##_force(const void *known, double t, const double *y, double *a)              \
    {                                                                                              \
        one_evaluate(&KNOWN(known)->force, n, (n) / 2, t, y, a);                                   \
    }                                                                                              \
    INLINE void name##_drag(const void *known, double t, const double *y, double *a)               \
    {                                                                                              \
        one_evaluate(&KNOWN(known)->drag, n, (n) / 2, t, y, a);                                    \
    }
TYPED_MOTIONS(MOTION_FUNCTIONS)
TYPED_FLOWS(FLOW_FUNCTIONS)

#define TYPED_PLACE(name, n) PLACE_##name,
/* Numbers of these shapes (PLACE_name). */
enum { TYPED_MOTIONS(TYPED_PLACE) TYPED_FLOWS(TYPED_PLACE) TYPED_COUNT };

/* Returns the number PLACE_name of the shape that a system has, or -1 if it has none. splits asks
 * for force and drag as separate programs. */
int typed_shape(const struct system *system, bool splits);
