/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Detects a doubtful reference by the finest runs of the methods that are compared, called
 * witnesses. It is doubtful if two of them agree with each other far better than with it, in steps
 * short enough to see the bursts that it has found. The caller then computes it again in shorter
 * steps; if the disagreement remains, it is reported. */
#pragma once

#include "modules/comparison/compute/errors.h"

/* The finest run of one method of the study. */
struct witness {
    const struct method *method; /* NULL until a run has reached the end */
    double *grid;                /* [STUDY_TIMES * n] its states */
    double moved; /* [amplitudes] distance from the next coarser run, or NAN if there was none */
    double step;  /* [s] mean step */
};

/* The finest runs of all methods. */
struct witnesses {
    struct witness *one; /* [count] */
    double *grid;
    size_t size; /* number of values in one grid */
    int count;
};

/* Allocates room for `max` methods. Returns false if out of memory; nothing is to be freed then. */
bool witnesses_init(struct witnesses *witnesses, const struct system *system, int max);
/* Frees the memory and zeroes the structure. */
void witnesses_free(struct witnesses *witnesses);
/* Stores a run of method i that reached the end in `steps` steps and is finer than the one stored
 * before, which it replaces. `grid` is copied. */
void witness_store(struct witnesses *witnesses, int i, const struct reference *reference,
                   const struct method *method, int64_t steps, const double *grid);
/* Returns true if two witnesses contradict the reference, whose dissenting_method and apart are set
 * accordingly. *step [s] is then the shorter of their mean steps, in which it should be computed
 * again. */
bool reference_suspect(struct reference *reference, const struct witnesses *witnesses,
                       double *step);
