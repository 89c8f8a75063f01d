/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of a sweep share. */
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
    bool watches; /* something is watched on the way */
    bool tops;    /* from the start on */
    bool means;
    bool in_lanes; /* as far as that does not depend on the point */
    bool adapts;   /* the size of steps follows the error */
    bool replays;  /* measured of runs that are given the steps that the lanes took */
    bool clocks;   /* dt or t0 is swept: points have other steps, unless: */
    double opens;  /* [s] after t0: where the window begins */
    int64_t whole; /* in lanes: full steps, and the rest [s] */
    double rest;
    int64_t room;                /* steps of which states are kept to be replayed */
    bool in_pieces;              /* of longer runs, which go on by so many at a time */
    int lane_axis;               /* the axis along which lanes lie */
    int64_t width;               /* points of a block */
    int64_t line, block;         /* the first that hold points of this sweep */
    int64_t lines, blocks;       /* and how many; tasks: lines times blocks */
    struct sweep_worker *worker; /* one for each thread */
    int64_t missing;             /* points that are to be computed … */
    atomic_llong computed;       /* … and of these */
};

/* How a lane gets to its end by fixed steps: whole ones, and the rest [s]. */
struct lane_clock {
    double h, rest;
    int64_t whole, opening; /* after so many the window is open */
};

/* The state of a lane after its whole steps, and the evaluations that these took. */
struct lane_end {
    double y[LIMIT_VARIABLES];
    int64_t evals;
};

struct sweep_worker {
    struct sweep_job *job;
    struct scene scene; /* of the present point */
    struct run_settings settings;
    struct lanes *lanes; /* NULL: none are used */
    double *row;
    double *replay;              /* [LANE_COUNT][room][2]; NULL: nothing is replayed */
    struct run *run[LANE_COUNT]; /* in pieces: of each lane; NULL if there is none */
    struct system *system;       /* [LANE_COUNT] */
    struct extremes watch[LANE_COUNT];
    double tol[LANE_COUNT];
    double area[LANE_COUNT], span[LANE_COUNT]; /* what means are made of */
    int64_t point[LANE_COUNT];                 /* of each lane: place in the sweep */
    struct lane_clock clock[LANE_COUNT];
    struct lane_end end[LANE_COUNT];
    int used;
    double *work;                /* of a step alone */
    double part[SWEEP_MEASURES]; /* measures of a point, where columns are made of them */
    struct section *section;     /* NULL: points are measured over the duration */
    enum drag drag;
    double steps; /* of all points so far */
    int64_t side_by_side;
    int64_t refused; /* place of the first refused point, -1 if there is none */
    char reason[600];
    bool failed; /* no memory */
};

bool sweep_worker_init(struct sweep_worker *worker, struct sweep_job *job);
void sweep_worker_free(struct sweep_worker *worker);
/* Returns how many points were computed; those that are there are not. */
int64_t sweep_task(struct sweep_worker *worker, int64_t line, int64_t block);
/* What all points have in common. */
void sweep_common(const struct sweep_request *request, struct scene *scene,
                  struct run_settings *settings);
/* Makes that, or another point's, the scene and the settings of this point; false: refused, with
 * the reason. */
bool sweep_point(const struct sweep_request *request, const struct sweep *sweep, int64_t i,
                 struct scene *scene, struct run_settings *settings, struct error *error);
void sweep_refuse(struct sweep_worker *worker, int64_t i, const struct error *error);
/* [measures] results of point i */
double *sweep_values(struct sweep_worker *worker, int64_t i);

/* ---- expressions (formula.c) ---- */

/* Of a slot from SWEEP_SLOT_PARAM on. */
double sweep_scene_value(const struct scene *scene, int slot);
/* At all recorded rows; false: no memory, or it is not defined. */
bool expression_column(const struct run *run, const struct sweep_expression *expression,
                       const struct scene *scene, double *result);
/* Its measures become the columns of point i. */
void sweep_combine(struct sweep_worker *worker, int64_t i);
/* What depends on the state at the end only; of other kinds NAN. */
double sweep_measured(const struct sweep_measure *measure, const struct system *system, double t,
                      const double *y);
void sweep_alone(struct sweep_worker *worker, int64_t i); /* point i, as a run of its own */
/* The run of point i; NULL: refused. */
struct run *sweep_run(struct sweep_worker *worker, int64_t i);
/* Takes it to its end, measures it and destroys it. evals: what its steps take, < 0: as it says */
void sweep_measure_run(struct sweep_worker *worker, int64_t i, struct run *run, int64_t evals);
/* Returns true if what is measured needs the states of the whole run. */
bool sweep_needs_trace(const struct sweep_job *job);

/* ---- in lanes (sweep_lanes.c) ---- */

bool sweep_lanes_fit(const struct sweep_job *job, const struct system *system, enum drag drag);
void sweep_gather(struct sweep_worker *worker, int64_t i); /* point i goes with its neighbours */
void sweep_flush(struct sweep_worker *worker);             /* what has been gathered goes now */
/* replay.c: measured of runs that are given the states which the lanes have come to */
void replay_begin(struct sweep_worker *worker);
void replay_keep(struct sweep_worker *worker, int64_t first, int64_t count);
void replay_lane(struct sweep_worker *worker, int lane, int64_t evals); /* at its end */
void replay_end(struct sweep_worker *worker);
/* lanes_adaptive.c: the same after lanes_set(), where steps follow the error */
void sweep_adapt(struct sweep_worker *worker);
/* Lanes are looked at in groups of so many for velocities that change their sign. */
enum { TURN_GROUP = LANE_COUNT / 4 };
/* Returns a bit for each group in which one does from one row of y, v [LANE_COUNT] to the next. */
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
/* What is measured of a lane that has come to its end. */
void sweep_measure_lane(struct sweep_worker *worker, int lane, const double *y, int64_t steps,
                        int64_t evals);

/* ---- at a section (section.c, section_lanes.c) ---- */

/* Returns false if out of memory. */
bool section_create(struct sweep_worker *worker);
void section_free(struct section *section);
void section_alone(struct sweep_worker *worker, int64_t i);
/* What has been gathered, the lanes having begun. */
void section_march(struct sweep_worker *worker);
/* Steps that a point takes, by that of a run over the duration; NAN: not known before. */
double section_steps(const struct sweep_request *request, const struct system *system);
