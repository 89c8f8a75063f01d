/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What stepping typed scenes in lanes works on: made by typed_lanes.c, stepped by
 * kernel_typed_lanes.c. */
#ifndef HOOKE_METHOD_KERNEL_TYPED_LANES_H
#define HOOKE_METHOD_KERNEL_TYPED_LANES_H

#include "method/kernel/lanes.h"

#include "method/step/split_body.h"

/* A force in lanes: a program, or a built-in one below what was typed. */
struct lane_term {
    const struct program *program; /* NULL: built in */
    double *frame;
    const struct term_row *row;
    int index; /* among the system's terms */
    /* Built in: */
    lane_term_function *add; /* NULL: lane by lane */
    double *c;               /* [TERM_COEFFICIENTS] */
    bool once;               /* a function of time only, the same one in all lanes */
};

struct typed_lanes {
    const struct method *method;
    struct split_way way; /* of a splitting */
    double t0, h;
    int64_t step; /* taken */
    int n, rows, values;
    bool timed, turns;
    bool own; /* lanes step by clocks of their own: */
    double own_t0[LANES];
    bool ready; /* the first slope is there, and what the lanes have in common is known */
    const struct system *system[LANES];
    step_function *scalar;
    int64_t extra[LANES]; /* evaluations for turning points */
    struct lane_term term[TERM_MAX];
    int terms;
    struct weights weights[WEIGHT_STAGES]; /* of the stages from the second on; [0]: of the step */
    /* Of [LANES] each, in the room: */
    double *input; /* t, the state [n] of the stage, values [values]: the names of the programs */
    double *own_h;
    double *y;           /* [n] Runge-Kutta: the state at the start of the step */
    double *k;           /* [stages][n] its slopes */
    double *pull, *drag; /* [n/2] splittings: forces */
    double *spare;       /* [n] */
    double *half;        /* [3] exact drag: its flow over h/2 (keep, least, pull) */
    double *frozen;      /* [weights][2] in each kick (lost, pull) */
    double *work;        /* of a step alone */
    double *memory;
    size_t size, used; /* of the room */
};

#endif
