/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the files of a sweep share. */
#pragma once

#include "modules/lanes/lanes.h"
#include "modules/sweep/compute/sweep.h"

#include <stdatomic.h>

/* ---- watching a trajectory go by (sweep_watch.c) ----
 *
 * Extremes of a column are where its velocity changes sign: placed by a line through the
 * velocities, their value by the cubic through both ends.
 */
struct extremes {
    double top, bottom; /* largest and smallest value so far */
    bool open;          /* the window has begun; from then on: */
    double low, high;   /* extremes */
    double first, last; /* [s] maxima */
    int64_t maxima;
    double area, span; /* integral, and over how long [s] */
};

void watch_begin(struct extremes *watch, double y);
void watch_open(struct extremes *watch, double y);
/* The velocity changed its sign between two states. */
void watch_turn(struct extremes *watch, double t0, double y0, double v0, double t1, double y1,
                double v1);
/* The integral of the cubic through both ends of a step. */
static inline double watch_area(double h, double y0, double v0, double y1, double v1)
{
    return h * ((y0 + y1) / 2 + h * (v0 - v1) / 12);
}
void watch_end(struct extremes *watch, double y);
double watch_value(const struct extremes *watch, enum sweep_kind kind);
double watch_speed(const struct system *system, int variable, double t, const double *y);
/* A recorded run of a scene; the window opens at that time. */
double watch_run(const struct run *run, const struct sweep_measure *measure,
                 const struct scene *scene, double opens);

static inline bool watch_turns(double v0, double v1)
{
    return signbit(v0) != signbit(v1);
}

/* ---- one worker ---- */

enum {
    SWEEP_ROWS = 64,          /* steps between looks at what the lanes do */
    SWEEP_REPLAYED = 1 << 13, /* steps of which lanes keep the states to be replayed: 8 MiB */
    SWEEP_FEW_ADAPTIVE = 10,
    SWEEP_FEW =
        3 /* so many points take less time alone than in lanes, most of which would stand empty */
};

struct sweep_job {
    const struct sweep_request *request;
    struct sweep *sweep;
    bool watches; /* Some quantity is watched during the run. */
    bool tops;    /* It is watched from the start, not only in the window. */
    bool means;
    bool in_lanes;         /* possible in lanes, as far as that does not depend on the point */
    bool adapts;           /* the size of steps follows the error */
    bool replays;          /* Runs are measured after receiving the steps of lanes. */
    bool clocks;           /* dt or t0 is swept, so that points have steps of their own */
    double opens;          /* [s] begin of the window, after t0 */
    int64_t whole;         /* number of full steps, unless `clocks` */
    double rest;           /* [s] last, shorter step */
    int64_t room;          /* steps of which states are stored for the replay */
    bool in_pieces;        /* Longer runs are replayed in portions of `room` steps. */
    int lane_axis;         /* axis along which lanes lie */
    int64_t width;         /* number of points in a block */
    int64_t line, block;   /* first line and block with points of this sweep */
    int64_t lines, blocks; /* their numbers; there are lines times blocks tasks */
    struct sweep_worker *worker; /* one for each thread */
    int64_t missing;             /* number of points to compute, */
    atomic_llong computed;       /* and of those that have been computed */
};

/* Fixed steps of a lane: full ones of h, and the rest [s]. */
struct lane_clock {
    double h, rest;
    int64_t whole, opening; /* The window is open after `opening` steps. */
};

/* The state of a lane after its whole steps, and the evaluations that these took. */
struct lane_end {
    double y[LIMIT_VARIABLES];
    int64_t evals;
};

struct sweep_worker {
    struct sweep_job *job;
    struct scene scene; /* scene of the present point */
    struct run_settings settings;
    struct lanes *lanes; /* NULL if no lanes are used */
    double *row;
    double *replay;              /* [LANE_COUNT][room][2] NULL if nothing is replayed */
    struct run *run[LANE_COUNT]; /* run of each lane if replayed in portions, or NULL */
    struct system *system;       /* [LANE_COUNT] */
    struct extremes watch[LANE_COUNT];
    double tol[LANE_COUNT];
    double area[LANE_COUNT], span[LANE_COUNT]; /* integral and time for means */
    int64_t point[LANE_COUNT];                 /* index of each lane's point in the sweep */
    struct lane_clock clock[LANE_COUNT];
    struct lane_end end[LANE_COUNT];
    int used;
    double *work;                /* memory of a single step */
    double part[SWEEP_MEASURES]; /* measures of a point, from which columns are computed */
    struct section *section;     /* NULL if points are measured over the duration */
    enum drag drag;
    double steps; /* steps of all points so far */
    int64_t side_by_side;
    int64_t refused; /* index of the first refused point, or -1 if there is none */
    char reason[600];
    bool failed; /* memory is out */
};

bool sweep_worker_init(struct sweep_worker *worker, struct sweep_job *job);
void sweep_worker_free(struct sweep_worker *worker);
/* Returns how many points were computed; those that are there are not. */
int64_t sweep_task(struct sweep_worker *worker, int64_t line, int64_t block);
/* Sets the scene and the settings that all points share. */
void sweep_common(const struct sweep_request *request, struct scene *scene,
                  struct run_settings *settings);
/* Changes `scene` and `settings` from those of sweep_common() or of another point to those of point
 * i. Returns false with `error` filled if the point is refused. */
bool sweep_point(const struct sweep_request *request, const struct sweep *sweep, int64_t i,
                 struct scene *scene, struct run_settings *settings, struct error *error);
void sweep_refuse(struct sweep_worker *worker, int64_t i, const struct error *error);
/* [measures] results of point i */
double *sweep_values(struct sweep_worker *worker, int64_t i);

/* ---- expressions (formula.c) ---- */

/* Returns the value of a slot from SWEEP_SLOT_PARAM on. */
double sweep_scene_value(const struct scene *scene, int slot);
/* Evaluates the expression at all recorded rows. Returns false if out of memory or if it is
 * undefined. */
bool expression_column(const struct run *run, const struct sweep_expression *expression,
                       const struct scene *scene, double *result);
/* Its measures become the columns of point i. */
void sweep_combine(struct sweep_worker *worker, int64_t i);
/* Returns a measure that depends on the state at the end only, or NAN for other kinds. */
double sweep_measured(const struct sweep_measure *measure, const struct system *system, double t,
                      const double *y);
/* Computes point i by a run of its own. */
void sweep_alone(struct sweep_worker *worker, int64_t i);
/* Creates the run of point i. Returns NULL if it is refused. */
struct run *sweep_run(struct sweep_worker *worker, int64_t i);
/* Takes the run to its end, measures it and destroys it. `evals` is the number of evaluations of
 * its steps; if negative, the run's own count. */
void sweep_measure_run(struct sweep_worker *worker, int64_t i, struct run *run, int64_t evals);
/* Returns true if what is measured needs the states of the whole run. */
bool sweep_needs_trace(const struct sweep_job *job);

/* ---- in lanes (sweep_lanes.c) ---- */

bool sweep_lanes_fit(const struct sweep_job *job, const struct system *system, enum drag drag);
void sweep_gather(struct sweep_worker *worker, int64_t i); /* Adds point i to the lanes. */
void sweep_flush(struct sweep_worker *worker);             /* Computes the points in the lanes. */
/* The following measure runs that are given the states of lanes (replay.c); replay_lane() is called
 * at the end of a lane. */
void replay_begin(struct sweep_worker *worker);
void replay_keep(struct sweep_worker *worker, int64_t first, int64_t count);
void replay_lane(struct sweep_worker *worker, int lane, int64_t evals);
void replay_end(struct sweep_worker *worker);
/* Continues after lanes_set() with steps that follow the error (lanes_adaptive.c). */
void sweep_adapt(struct sweep_worker *worker);
/* Lanes are examined in groups of this size for velocities that change their sign. */
enum { TURN_GROUP = LANE_COUNT / 4 };
/* Returns a bit for each group with a velocity that changes its sign between two rows of y, v
 * [LANE_COUNT]. */
unsigned lanes_turning_groups(const double *previous, const double *row);
/* Returns the first lane from that one on whose group has its bit, or one past the last. */
static inline int next_turning(unsigned groups, int lane)
{
    while (lane < LANE_COUNT && !(groups >> lane / TURN_GROUP & 1))
        lane = (lane / TURN_GROUP + 1) * TURN_GROUP;
    return lane;
}
/* So far out that it goes alone. */
bool lane_suspicious(const double *y, int n);
/* Measures a lane that has come to its end. */
void sweep_measure_lane(struct sweep_worker *worker, int lane, const double *y, int64_t steps,
                        int64_t evals);

/* ---- at a section (section.c, section_lanes.c) ---- */

/* Returns false if out of memory. */
bool section_create(struct sweep_worker *worker);
void section_free(struct section *section);
void section_alone(struct sweep_worker *worker, int64_t i);
/* Advances the points in the lanes, which have begun. */
void section_march(struct sweep_worker *worker);
/* Returns the number of steps of a point, from those of a run over the duration; NAN if unknown. */
double section_steps(const struct sweep_request *request, const struct system *system);
