/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the files of this folder share: a job is one sweep, divided into tasks;
 * each thread has a worker, which computes points alone (point.c, section.c) or several side by
 * side in lanes (lanes.c, lanes_adaptive.c, section_lanes.c). */
#pragma once

#include "modules/lanes/lanes.h"
#include "modules/sweep/compute/sweep.h"

#include <stdatomic.h>

/* ---- watching a trajectory step by step (watch.c) ---- */

/* Extremes and means of a column of a run. The calls are watch_begin(), watch_turn() at each change
 * of sign of the velocity, watch_open() where the window begins, watch_end(), then watch_value().
 * An extreme is placed by a line through the velocities at both ends of a step, and its value is
 * that of the cubic through both ends. */
struct extremes {
    double top, bottom; /* largest and smallest value so far */
    bool open;          /* the window has begun; the following are from then on */
    double low, high;   /* extremes */
    double first, last; /* [s] times of the first and the last maximum */
    int64_t maxima;     /* number of maxima */
    double area, span;  /* integral of the value over time, and the time [s] */
};

/* Starts watching at the value y. */
void watch_begin(struct extremes *watch, double y);
/* Begins the window at the value y. */
void watch_open(struct extremes *watch, double y);
/* Takes note of an extreme between two states (time, value, velocity) whose velocities have
 * different signs. */
void watch_turn(struct extremes *watch, double t0, double y0, double v0, double t1, double y1,
                double v1);
/* Returns the integral of the cubic through both ends of a step of h [s]. */
static inline double watch_area(double h, double y0, double v0, double y1, double v1)
{
    return h * ((y0 + y1) / 2 + h * (v0 - v1) / 12);
}
/* Takes note of the last value y. */
void watch_end(struct extremes *watch, double y);
/* Returns what was measured; kind is one of those up to SWEEP_MIN. NAN if the window has not begun
 * or, for a period, has fewer than two maxima. */
double watch_value(const struct extremes *watch, enum sweep_kind kind);
/* Returns the time derivative of a state variable. */
double watch_speed(const struct system *system, int variable, double t, const double *y);
/* Measures a recorded run of a scene, whose window begins at the time `opens` [s]. Returns NAN if
 * the column cannot be computed or if out of memory. */
double watch_run(const struct run *run, const struct sweep_measure *measure,
                 const struct scene *scene, double opens);

/* Returns true if two velocities have different signs. */
static inline bool watch_turns(double v0, double v1)
{
    return signbit(v0) != signbit(v1);
}

/* ---- one worker ---- */

enum {
    SWEEP_ROWS = 64, /* number of steps of lanes between two examinations of their states */
    SWEEP_REPLAYED = 1 << 13, /* number of steps of which states are stored to be replayed: 8 MiB */
    /* number of points that take less time alone than in lanes with adaptive steps, */
    SWEEP_FEW_ADAPTIVE = 10,
    SWEEP_FEW = 3 /* and with fixed steps, as most lanes would be empty */
};

/* A sweep that is being computed. All workers read it; only `computed` changes. */
struct sweep_job {
    const struct sweep_request *request;
    struct sweep *sweep;
    bool watches;  /* some measure is computed from rows during the run, not from the end */
    bool tops;     /* some is a maximum or minimum, for which all rows count, not only the window */
    bool means;    /* some measure is a mean */
    bool in_lanes; /* points can run in lanes, as far as that does not depend on the point */
    bool adapts;   /* steps are adaptive */
    /* runs are given the states of lanes and then measured, as measures need a whole run */
    bool replays;
    bool clocks;    /* dt or t0 is swept, so that points step at different times */
    double opens;   /* [s] begin of the window, after t0 */
    int64_t whole;  /* number of full steps, if not `clocks` */
    double rest;    /* [s] last, shorter step, or 0 */
    int64_t room;   /* number of steps of which states are stored for the replay */
    bool in_pieces; /* longer runs are replayed in portions of `room` steps */
    int lane_axis;  /* axis along which neighbouring points run in neighbouring lanes */
    int64_t width;  /* number of points of a task, along that axis */
    /* first line (number on the other axis) and block (of `width` points) with points of this
     * sweep */
    int64_t line, block;
    int64_t lines, blocks;       /* numbers of lines and blocks; there are lines * blocks tasks */
    struct sweep_worker *worker; /* [threads] */
    int64_t missing;             /* number of points to compute, */
    atomic_llong computed;       /* and of those that have been computed */
};

/* Fixed steps of a lane: `whole` ones of h [s] and a last one of `rest` [s]. */
struct lane_clock {
    double h, rest;
    int64_t whole, opening; /* the window is open after `opening` steps */
};

/* State of a lane after its whole steps, and the number of evaluations so far. */
struct lane_end {
    double y[LIMIT_VARIABLES];
    int64_t evals;
};

/* State of one thread. */
struct sweep_worker {
    struct sweep_job *job;
    struct scene scene; /* scene of the present point */
    struct run_settings settings;
    struct lanes *lanes; /* NULL if no lanes are used */
    /* [SWEEP_ROWS] rows of lanes: value and velocity, with adaptive steps after the time */
    double *row;
    double *replay; /* [LANE_COUNT][room][2] stored states, or NULL if nothing is replayed */
    struct run *run[LANE_COUNT]; /* run of each lane that is replayed in portions, or NULL */
    struct system *system;       /* [LANE_COUNT] scene of each lane, bound */
    struct extremes watch[LANE_COUNT];
    double tol[LANE_COUNT];                    /* tolerance of each lane */
    double area[LANE_COUNT], span[LANE_COUNT]; /* integrals and times for means */
    int64_t point[LANE_COUNT];                 /* index of each lane's point in the sweep */
    struct lane_clock clock[LANE_COUNT];
    struct lane_end end[LANE_COUNT];
    int used;     /* number of lanes that have a point */
    double *work; /* work memory of a single step */
    /* measures of the present point, from which formulas are computed */
    double part[SWEEP_MEASURES];
    struct section *section; /* NULL if points are measured over the duration */
    enum drag drag;          /* drag variant of the points in the lanes */
    double steps;            /* steps of all points so far */
    int64_t side_by_side;    /* number of points measured in lanes so far */
    int64_t refused;         /* index of the first refused point, or -1 if there is none */
    char reason[600];        /* reason for which that point was refused */
    bool failed;             /* true if out of memory */
};

/* Allocates the memory of a worker. Returns false if out of memory; nothing is to be freed then. */
bool sweep_worker_init(struct sweep_worker *worker, struct sweep_job *job);
/* Frees the memory of a worker. */
void sweep_worker_free(struct sweep_worker *worker);
/* Computes the missing points of the task at that line and block. Returns how many there were,
 * fewer if cancelled. */
int64_t sweep_task(struct sweep_worker *worker, int64_t line, int64_t block);
/* Sets *scene and *settings to those that all points share. */
void sweep_common(const struct sweep_request *request, struct scene *scene,
                  struct run_settings *settings);
/* Sets the swept quantities in `scene` and `settings` to those of point i. Both come from
 * sweep_common(), or from another point. Returns false with an error if a value is refused. */
bool sweep_point(const struct sweep_request *request, const struct sweep *sweep, int64_t i,
                 struct scene *scene, struct run_settings *settings, struct error *error);
/* Marks point i as refused and keeps the reason if it is the first such point. */
void sweep_refuse(struct sweep_worker *worker, int64_t i, const struct error *error);
/* Returns where the measures of point i are stored: in the sweep, or with formulas in
 * worker->part. */
double *sweep_values(struct sweep_worker *worker, int64_t i);

/* ---- expressions (formula.c) ---- */

/* Returns the value of a parameter or derived quantity by its slot, from SWEEP_SLOT_PARAM on. */
double sweep_scene_value(const struct scene *scene, int slot);
/* Evaluates the expression at all recorded rows into result. Returns false if out of memory or if a
 * column cannot be computed. */
bool expression_column(const struct run *run, const struct sweep_expression *expression,
                       const struct scene *scene, double *result);
/* Computes the wanted columns of point i from its measures in worker->part, if some are
 * formulas. */
void sweep_combine(struct sweep_worker *worker, int64_t i);
/* Returns the value of a measure that depends on time and state only, or NAN for other kinds. */
double sweep_measured(const struct sweep_measure *measure, const struct system *system, double t,
                      const double *y);
/* Computes and measures point i by a run of its own. */
void sweep_alone(struct sweep_worker *worker, int64_t i);
/* Creates the run of point i. Returns NULL if it is refused. */
struct run *sweep_run(struct sweep_worker *worker, int64_t i);
/* Advances the run to its end, measures it as point i and destroys it. `evals` replaces the run's
 * number of evaluations unless negative. */
void sweep_measure_run(struct sweep_worker *worker, int64_t i, struct run *run, int64_t evals);
/* Returns true if what is measured needs the states of the whole run. */
bool sweep_needs_trace(const struct sweep_job *job);

/* ---- in lanes (lanes.c) ---- */

/* Returns true if points like this system can run in lanes. */
bool sweep_lanes_fit(const struct sweep_job *job, const struct system *system, enum drag drag);
/* Adds point i to the lanes, and computes them if all are used. */
void sweep_gather(struct sweep_worker *worker, int64_t i);
/* Computes the points in the lanes. */
void sweep_flush(struct sweep_worker *worker);
/* The following measure runs that are given the states of lanes (replay.c). replay_begin() is
 * called when lanes begin, replay_keep() after each batch of `count` steps from step `first` on,
 * replay_lane() for each lane that has come to its end, then replay_end(). */
void replay_begin(struct sweep_worker *worker);
void replay_keep(struct sweep_worker *worker, int64_t first, int64_t count);
void replay_lane(struct sweep_worker *worker, int lane, int64_t evals);
void replay_end(struct sweep_worker *worker);
/* Computes the points in the lanes by adaptive steps (lanes_adaptive.c); lanes_begin() and
 * lanes_set_step() were called. */
void sweep_adapt(struct sweep_worker *worker);
/* Lanes are examined in groups of this size for velocities that change their sign. */
enum { TURN_GROUP = LANE_COUNT / 4 };
/* Returns a bit for each group of lanes in which a velocity changes its sign between two rows
 * [2][LANE_COUNT] of values and velocities. */
unsigned lanes_turning_groups(const double *previous, const double *row);
/* Returns the first lane >= `lane` whose group has its bit set, or LANE_COUNT if there is none. */
static inline int next_turning(unsigned groups, int lane)
{
    while (lane < LANE_COUNT && !(groups >> lane / TURN_GROUP & 1))
        lane = (lane / TURN_GROUP + 1) * TURN_GROUP;
    return lane;
}
/* Returns true if a state is so large, or not a number, that the point must run alone to stop at
 * the right step. */
bool lane_suspicious(const double *y, int n);
/* Stores the measures of a lane that has come to its end with state y, after so many steps and
 * evaluations. */
void sweep_measure_lane(struct sweep_worker *worker, int lane, const double *y, int64_t steps,
                        int64_t evals);

/* ---- at a section (section.c, section_lanes.c) ---- */

/* Allocates worker->section. Returns false if out of memory; section_free() frees what was
 * allocated. */
bool section_create(struct sweep_worker *worker);
/* Frees the memory; NULL is allowed. */
void section_free(struct section *section);
/* Computes point i at the section by a run of its own. */
void section_alone(struct sweep_worker *worker, int64_t i);
/* Computes the points in the lanes at the section; lanes_begin() was called. Those whose events are
 * not certain run alone. */
void section_march(struct sweep_worker *worker);
/* Returns the number of steps of a point at a strobe, or NAN at an event, where it is unknown. */
double section_steps(const struct sweep_request *request, const struct system *system);
