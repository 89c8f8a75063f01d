/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events that are watched in a run, and bounds of their functions inside of the step just taken. */
#pragma once

#include "run/private.h"

#include <math.h>

/* ---- path.c ---- */

enum { PATH_PIECES_MAX = 64 };

/*
 * Describes the step just taken by polynomials of theta, the share of the step, on `pieces` parts
 * of equal length: y = sum c_k (theta - middle of the part)^k, up to `error`. One part is exact for
 * methods with a dense output of their own; long steps of others take more.
 */
struct step_path {
    struct inside inside;
    double end_t;
    bool known;    /* the polynomials were made for this step */
    bool resolved; /* they, if they were made, show how the step bends */
    int degree, pieces;
    double end[LIMIT_VARIABLES];
    struct path_piece {
        double c[DENSE_DEGREE + 1][LIMIT_VARIABLES], error[LIMIT_VARIABLES];
    } piece[PATH_PIECES_MAX];
};

void path_begin(struct step_path *path, const struct inside *inside);
void path_make(struct step_path *path);
double path_time(const struct step_path *path, double theta);
/* Computes the state by the method itself; at both ends it is the state that was computed. */
void path_state(const struct step_path *path, double theta, double *y);
struct jet path_jet(const struct step_path *path, int variable, double a, double b);
/* all variables, by the polynomial */
void path_estimate(const struct step_path *path, double theta, double *y);
/* Bounds the polynomial through values at even fractions of the interval from a to b, the first one
 * at a, and estimates its error. */
struct jet path_fit(const double *value, int degree, double a, double b);

/* ---- watch.c ---- */

/* A formula in the columns of the watch; what does not move is a number in it. */
struct watched {
    const struct event *event;
    const struct expr *left, *right;
    double value; /* value at the present state, if `known` */
    bool known;
    bool departs; /* the value is 0 here but for rounding */
    int sign;     /* last sign that was not 0 */
    int budget;
    double touched; /* [s] when it last touched 0; NAN if it never did */
    double passed;  /* [s] when it last was an event of either kind; NAN means never */
};

struct event_crossing {
    double theta, t;
    int event, direction; /* 1 rising with time, 0 touching */
};

struct event_watch {
    struct arena arena;
    struct moving *column;
    double *value;   /* [columns] */
    struct jet *jet; /* [columns] */
    int columns, capacity;
    bool failed;
    struct run *run;
    const struct expr_scope *scope;
    struct watched event[LIMIT_EVENTS + 1];
    /* The signs of the events after a step, and where the run was then. */
    struct {
        const struct event *event;
        int sign;
    } left[LIMIT_EVENTS + 1];
    int64_t left_step;
    double left_t;
    /* number of events, with the condition, if there is one, as the last; `stop_event` is its
     * index, else -1 */
    int events;
    int stop_event;
    struct event condition;
    bool or_equal;
    struct step_path path;
    double size[LIMIT_VARIABLES]; /* largest value of each variable in the run, */
    bool sized;                   /* if known */
    struct event_crossing *found; /* crossings in the step just taken, in order */
    double *state;                /* [count][n] */
    size_t count, found_capacity;
};

/* Begins to watch the events of a run at its present state. Returns false if out of memory. */
bool events_watch_begin(struct event_watch *watch, struct run *run,
                        const struct run_target *target);
void events_watch_destroy(struct event_watch *watch);
double events_watch_value(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y);
struct jet events_watch_bounds(struct event_watch *watch, const struct watched *watched, double a,
                               double b);
/* Returns true if the event's function may be 0 at a state that is known up to the fraction `error`
 * of each variable's size. */
bool events_watch_is_zero(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y, double error);
/* Half the width of the bounds of its value there. */
double events_watch_error(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y, double error);

/* Returns how many intervals a search for bursts (missed.c) may look at along `ways` segments, in a
 * run of `evals` evaluations. */
int64_t run_burst_looks(const struct system *system, size_t ways, int64_t evals);
