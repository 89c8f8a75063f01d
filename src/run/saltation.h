/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Effect of a run's events and jumps on another solution of the same equations, which meets the
 * events at slightly other times. The run adds a response at each event and jump; the second
 * solution of opinion.c reads them. At a change, it calls saltation_enter(), then saltation_jump(),
 * then saltation_leave(). */
#pragma once

#include <hooke/run.h>

/* Kind of a response; other values are the index of the variable that jumped. */
enum {
    RESPONSE_MOMENT = -1, /* an event stopped the run; its time depends on the state */
    RESPONSE_MISS = -2    /* an event nearly happened; another solution may meet it */
};

/* An event or a jump of the run. The derivatives that belong to it, in struct responses, are those
 * of the event's function, or for a jump those of the new value of the variable. */
struct response {
    int64_t step; /* step index of the state after it */
    double t;     /* [s] */
    /* value of the variable after the jump, or second derivative of the event's function along the
     * motion (RESPONSE_MOMENT), or the function where it was nearest to 0 (RESPONSE_MISS) */
    double value;
    int variable;
};

/* All responses of a run, in order of time. */
struct responses {
    struct response *response; /* [count] */
    /* [count][2 n + 1] derivatives by the variables and by time, NAN where they are not known; then
     * the state to which they belong */
    double *slope;
    size_t count, capacity;
};

/* Adds the response of an event, given by its index in the watch, that stopped the run at its
 * present state. Returns false if out of memory; so do the next two. */
bool responses_add_moment(struct run *run, int event);
/* Adds that of an event which nearly happened at the fraction theta of the last step. */
bool responses_add_miss(struct run *run, int event, double theta);
/* Adds that of a variable which has just jumped from previous_value; only adaptive runs have it. */
bool responses_add_jump(struct run *run, int variable, double previous_value);
/* Returns true if the run is at an event whose time depends on the state, so that another solution
 * meets it at another time. */
bool responses_moment_moves(const struct run *run);
/* Removes the responses after the present step. */
void responses_truncate(struct run *run);
void responses_free(struct responses *all);

/* Progress of another solution across the events and jumps of a run; all 0 and `lost` NAN at the
 * start. */
struct saltation {
    bool begun;      /* t and moved are valid */
    double t, moved; /* [s] last change, and by how much later this solution meets it */
    size_t next;     /* index of the first response that is not before t */
    size_t miss;     /* index of the first response not examined for misses */
    double reach[LIMIT_VARIABLES]; /* largest distances of its variables from the run so far */
    /* [s] time of an event that may or may not happen, depending on the errors; from there on the
     * solution says nothing. NAN if there is none so far. */
    double lost;
};

/* Enters the distance of the solution y [n] from the run's state at the same time into
 * saltation->reach. */
void saltation_note(struct saltation *saltation, int n, const double *run_state, const double *y);
/* Returns the next response to an event that nearly happened up to the state after `step`, or NULL.
 */
const struct response *saltation_next_miss(const struct run *run, struct saltation *saltation,
                                           int64_t step);
/* Passes that response, at which the solution is y [n]. Returns false, and sets saltation->lost, if
 * the solution may have met the event. */
bool saltation_pass_miss(const struct run *run, struct saltation *saltation, const double *y);

/* Moves the solution y [n] from the run's time t of an event to the time at which this solution
 * meets it. Returns false, and sets saltation->lost, if that time is not known. */
bool saltation_enter(const struct run *run, struct saltation *saltation,
                     const struct system *system, double t, double *y);
/* Lets y jump as the run did to the state after `step`. Returns false if the derivatives of the
 * jump are not known. */
bool saltation_jump(const struct run *run, const struct saltation *saltation, int64_t step,
                    double *y);
/* Moves y back to the run's time t, by the system that is in force after the change. */
void saltation_leave(const struct saltation *saltation, const struct system *system, double *y);
