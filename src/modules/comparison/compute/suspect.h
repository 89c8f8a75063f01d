/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A reference is suspect where the finest runs of two methods agree with each other far better than
 * with it, and do not pass over what it has found. It is computed again then in shorter steps; what
 * stays is said.
 */
#pragma once

#include "modules/comparison/compute/errors.h"

/* The finest run of one choice. */
struct witness {
    const struct method *method; /* NULL as long as none has reached the end */
    double *grid;                /* [STUDY_TIMES * n] */
    double moved; /* [amplitudes] distance from the run before it, or NAN if there was none */
    double step;  /* [s] in the mean */
};

struct witnesses {
    struct witness *one; /* [count], one for each choice */
    double *grid;
    size_t size; /* [double] of one grid */
    int count;
};

/* Returns false if out of memory */
bool witnesses_init(struct witnesses *witnesses, const struct system *system, int max);
void witnesses_free(struct witnesses *witnesses);
/* A finer run of choice i has arrived, in so many steps. */
void witness_explain(struct witnesses *witnesses, int i, const struct reference *reference,
                     const struct method *method, int64_t steps, const double *grid);
/* Sets the reference's against and apart; *step [s]: steps that see what they have seen. */
bool reference_suspect(struct reference *reference, const struct witnesses *witnesses,
                       double *step);
