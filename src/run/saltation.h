/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What events and jumps of a run do to another solution. */
#ifndef HOOKE_RUN_SALTATION_H
#define HOOKE_RUN_SALTATION_H

#include <hooke/run.h>

/*
 * How the moment of an event that stopped the run (variable < 0), or the new value of a variable,
 * answers to the state there: the derivatives of the event's function, or of the value.
 */
struct response {
    int64_t step;
    double t, value; /* [s]; of the variable after the jump */
    int variable;
};

struct responses {
    struct response *at;
    /* [count][2 n + 1] derivatives by the variables and by time, NAN where they are not known; then
     * the state to which they belong */
    double *slope;
    size_t count, capacity;
};

/* Add a response where the run is; false if out of memory. */
bool responses_add_moment(struct run *run, int event, double h); /* after a step over h */
bool responses_add_jump(struct run *run, int variable, double before);
/* The run stands at an event whose moment depends on the state: another solution has another. */
bool responses_moment_moves(const struct run *run);
void responses_truncate(struct run *run); /* after the present step */
void responses_free(struct responses *all);

/* Where another solution meets the jumps of a run. */
struct saltation {
    bool begun;
    double t, moved; /* [s] of the last jump, and by how much later this solution meets it */
    size_t next;     /* response */
};

/* Moves the solution y at t to its own moment of the event; false if that is not known. */
bool saltation_enter(const struct run *run, struct saltation *saltation,
                     const struct system *system, double t, double *y);
/* Lets it jump as the run did before the state after `step`; false if that is not known. */
bool saltation_jump(const struct run *run, const struct saltation *saltation, int64_t step,
                    double *y);
/* Moves it back to the time of the run, by the system that is in force then. */
void saltation_leave(const struct saltation *saltation, const struct system *system, double *y);

#endif
