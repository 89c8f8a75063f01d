/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events that are watched in a run: their formulas, values, and bounds of these inside of the step
 * just taken. watch.c compiles and evaluates formulas, path.c describes the step, event.c finds the
 * events in it, records.c keeps them. "The condition" is that of `run until`, watched as one more
 * event. */
#pragma once

#include "run/private.h"

#include <math.h>

/* ---- path.c ---- */

enum { PATH_PIECES_MAX = 64 };

/*
 * Describes the step just taken by polynomials of theta, the fraction of the step, on `pieces`
 * parts of equal length: y = sum c_k (theta - middle of the part)^k, up to `error`. One part is
 * exact for methods with a dense output of their own; long steps of others take more. path_begin()
 * for each step; path_make() makes the polynomials when bounds are needed first.
 */
struct step_path {
    struct inside inside;
    double end_t;  /* [s] time of its end */
    bool known;    /* the polynomials were made for this step */
    bool resolved; /* false if they were made, but may not show how the step bends */
    int degree, pieces;
    double end[LIMIT_VARIABLES]; /* state at its end */
    struct path_piece {
        double c[DENSE_DEGREE + 1][LIMIT_VARIABLES], error[LIMIT_VARIABLES];
    } piece[PATH_PIECES_MAX];
};

/* Begins with a new step, whose end is the run's present state. */
void path_begin(struct step_path *path, const struct inside *inside);
/* Makes the polynomials, unless they are known. */
void path_make(struct step_path *path);
/* Returns the time [s] at the fraction theta of the step. */
double path_time(const struct step_path *path, double theta);
/* Computes the state by the method itself, as inside_state(); at both ends it is the state that was
 * computed. */
void path_state(const struct step_path *path, double theta, double *y);
/* Returns bounds of a variable, and of its derivatives by theta, for theta from a to b, after
 * path_make(). */
struct jet path_jet(const struct step_path *path, int variable, double a, double b);
/* Computes the state by the polynomials, which is faster, after path_make(). */
void path_estimate(const struct step_path *path, double theta, double *y);
/* Returns bounds of the polynomial through value [degree + 1] at even distances from a to b, and of
 * its derivatives, widened by an estimate of its error. */
struct jet path_fit(const double *value, int degree, double a, double b);

/* ---- watch.c ---- */

/* An event with its formula compiled: the value is left - right, or left, and its names are columns
 * of the watch; names whose values do not change in a run are numbers in it. */
struct watched {
    const struct event *event;
    const struct expr *left, *right; /* `right` is NULL if there is none */
    double value;                    /* value at the end of the last step, if `known` */
    bool known;
    bool departs; /* the value there is 0 but for rounding, so its sign is found in the next step */
    int sign;     /* last sign that was not 0 */
    int budget;   /* bounds that may be computed in the next step */
    double touched; /* [s] when it last touched 0; NAN if it never did */
    double passed;  /* [s] when it last was an event of either kind; NAN means never */
};

/* An event found in the step just taken. */
struct event_crossing {
    double theta, t; /* fraction of the step, time [s] */
    int event;       /* index in event_watch.event */
    int direction;   /* 1 rising with time, -1 falling, 0 touching */
};

/* Everything that is watched in one call of run_advance(), and what was found in its last step. */
struct event_watch {
    struct arena arena;    /* memory of formulas and columns */
    struct moving *column; /* [columns] what the formulas read: time, a variable, or another slot */
    double *value;         /* [columns] their values, for events_watch_value() */
    struct jet *jet;       /* [columns] their bounds, for events_watch_bounds() */
    int columns, capacity;
    bool failed; /* memory ran out */
    struct run *run;
    const struct expr_scope *scope; /* names of the formula that is being compiled */
    struct watched event[LIMIT_EVENTS + 1];
    /* The signs of the events after the last step of the call before, and the step and time of the
     * run then: an event whose value is 0 there continues with that sign. */
    struct {
        const struct event *event;
        int sign;
    } left[LIMIT_EVENTS + 1];
    int64_t left_step;
    double left_t;
    int events;                   /* number of events, the condition included, which is the last */
    int stop_event;               /* index of the condition; -1 if there is none */
    struct event condition;       /* the condition as an event */
    bool or_equal;                /* the condition has <= or >= */
    struct step_path path;        /* the step just taken */
    double size[LIMIT_VARIABLES]; /* largest magnitude of each variable in the run, if `sized` */
    bool sized;
    struct event_crossing *found; /* [count] events in the step just taken, in order of time */
    double *state;                /* [count][n] states there */
    size_t count, found_capacity;
};

/* Begins to watch the events of the target, and its condition, at the run's present state: compiles
 * their formulas. Returns false if out of memory. */
bool events_watch_begin(struct event_watch *watch, struct run *run,
                        const struct run_target *target);
/* Frees the watch, which may be NULL. */
void events_watch_destroy(struct event_watch *watch);
/* Returns the value of an event's function at the state y [n] at t [s]. */
double events_watch_value(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y);
/* Returns bounds of the event's function, and of its derivatives by theta, for the fractions a to b
 * of the step just taken. */
struct jet events_watch_bounds(struct event_watch *watch, const struct watched *watched, double a,
                               double b);
/* Returns true if the event's function may be 0 at a state that is known up to the fraction `error`
 * of each variable's size. */
bool events_watch_is_zero(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y, double error);
/* Returns how far the function may be off at such a state: half the width of its bounds. */
double events_watch_error(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y, double error);

/* Returns how many intervals run_missed_burst() may examine along `ways` segments of the recorded
 * states, in a run of `evals` evaluations. */
int64_t run_burst_looks(const struct system *system, size_t ways, int64_t evals);
