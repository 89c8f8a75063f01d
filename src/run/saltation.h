/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Effect of a run's events and jumps on another solution. */
#pragma once

#include <hooke/run.h>

/* Subject of a response, if it is not the variable that jumped. */
enum { RESPONSE_MOMENT = -1, RESPONSE_MISS = -2 };

/*
 * Dependence on the state there: for an event that stopped the run, whose moment moves
 * (RESPONSE_MOMENT), and one that nearly happened (RESPONSE_MISS), the derivatives of the event's
 * function; for a jump of a variable those of its new value.
 */
struct response {
    int64_t step;
    double t; /* [s] */
    /* value of the variable after the jump; the function's second derivative along the motion; the
     * function where it was nearest to 0 */
    double value;
    int variable;
};

struct responses {
    struct response *response;
    /* [count][2 n + 1] derivatives by the variables and by time, NAN where they are not known; then
     * the state to which they belong */
    double *slope;
    size_t count, capacity;
};

/* Add a response; false if out of memory. */
/* The event is in the step just taken, at the present state of the run. */
bool responses_add_moment(struct run *run, int event);
/* The event was nearly met at the fraction theta of the step. */
bool responses_add_miss(struct run *run, int event, double theta);
bool responses_add_jump(struct run *run, int variable, double previous_value);
/* The run stands at an event whose moment depends on the state: another solution has another. */
bool responses_moment_moves(const struct run *run);
void responses_truncate(struct run *run); /* removes those after the present step */
void responses_free(struct responses *all);

/* State of another solution that meets the jumps of a run. */
struct saltation {
    bool begun;
    double t, moved; /* [s] of the last jump, and by how much later this solution meets it */
    size_t next;     /* response */
    size_t miss;     /* response from which on misses were not yet looked at */
    double reach[LIMIT_VARIABLES]; /* largest distances from the run so far */
    /* [s] time of an event that depends on the errors; NAN if there is none so far */
    double lost;
};

/* Takes note of the distance of a solution y from the run's state `own`. */
void saltation_note(struct saltation *saltation, int n, const double *own, const double *y);
/* Returns the next response to an event that nearly happened up to the state after `step`, or NULL.
 */
const struct response *saltation_next_miss(const struct run *run, struct saltation *saltation,
                                           int64_t step);
/* Goes on beyond that response. Returns false if the solution y there may have met the event. */
bool saltation_pass_miss(const struct run *run, struct saltation *saltation, const double *y);

/* Moves the solution y at t to its own moment of the event; false if that is not known. */
bool saltation_enter(const struct run *run, struct saltation *saltation,
                     const struct system *system, double t, double *y);
/* Lets it jump as the run did before the state after `step`; false if that is not known. */
bool saltation_jump(const struct run *run, const struct saltation *saltation, int64_t step,
                    double *y);
/* Moves it back to the time of the run, by the system that is in force then. */
void saltation_leave(const struct saltation *saltation, const struct system *system, double *y);
