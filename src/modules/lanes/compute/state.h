/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Many trajectories at once: what steps in lanes work on. Each number of a trajectory is an array
 * [LANE_COUNT], so that loops over lanes become vector instructions; forces are programs, those of
 * built-in terms, too. The operations are those of one trajectory in their order: the same bits.
 */
#pragma once

#include "method/step/split_body.h"
#include "method/step/weights.h"
#include "modules/lanes/compute/vector.h"
#include "modules/lanes/lanes.h"

/* Subset of the forces that is summed up. */
enum lane_sum { SUM_ALL, SUM_FORCE, SUM_DRAG, LANE_SUMS };

struct lane_part {
    const struct program *program;
    double *frame;
    unsigned sums; /* bits 1 << enum lane_sum of those that it belongs to */
};

/* Programs of built-in terms: of each sum and of the derivatives of all. They stay while systems
 * have the same terms. */
struct built_in_programs {
    const struct term_row *row[TERM_MAX];
    int terms, first;
    struct program *sum[LANE_SUMS], *slopes;
};

/* A time. */
struct lane_time {
    const double *t; /* [LANE_COUNT] time of each lane, or NULL if `all` holds for every lane */
    double all;
};

/*
 * Steps whose size follows the error: what struct controller has, for each lane. Lanes whose next
 * step is so short, of the time or at all [s], or whose state is so far out, are not for lanes.
 */
static const double lane_shortest_of_time = 1e-12, lane_shortest = 1e-300, lane_farthest = 1e100;

struct lane_control {
    double t_end, creep;
    /* largest_estimate() and the filter of the method */
    double aims, by_error, by_previous, by_ratio, elementary;
    double tol[LANE_COUNT], accepted[LANE_COUNT]; /* the latter: 1/(n largest_estimate()^2) */
    double t[LANE_COUNT], t_low[LANE_COUNT], h[LANE_COUNT], last[LANE_COUNT], previous[LANE_COUNT],
        sampled[LANE_COUNT], elapsed[LANE_COUNT];
    lane_mask running[LANE_COUNT], rejected[LANE_COUNT], failed[LANE_COUNT], alone[LANE_COUNT];
    int64_t steps[LANE_COUNT];
};

/* A drive that is the same in all lanes follows from the method, c1, c2, t0 and h. */
struct driven_by {
    const struct method *method; /* method, or NULL if lanes have their own drives */
    double number[4];
};

/* Cosines of drives at the places of steps. */
enum { DRIVE_VALUES = 1 << 15, DRIVE_ROWS = 64 };
struct lane_drive {
    bool own;
    int rows, places;
    const double *c1, *c2; /* [LANE_COUNT] coefficients; NULL if there is no drive */
    struct driven_by driver;
    int64_t begin, end; /* steps of which it is known */
    const double *next; /* [steps][places] of the next ones, the same in all lanes; */
    const double
        *value_rows[DRIVE_ROWS]; /* [steps][places] rows of values, where lanes have their own */
    double time[LANE_COUNT], value[DRIVE_VALUES]; /* the time of the last row */
};

struct lanes {
    const struct method *method;
    enum drag drag;
    struct split_way way; /* order of substeps of a splitting */
    double t0, h;
    int64_t step; /* taken */
    int n, rows, typed_values, values;
    bool timed, turns;
    bool adapts;          /* lanes_control() was called */
    bool ready;           /* the common properties of the lanes are known */
    bool closed, dragged; /* implicit stages are solved in closed form, with quadratic drag */
    /* Initial time and step of each lane; `own` is true if they differ. */
    bool own;
    double own_t0[LANE_COUNT], own_h[LANE_COUNT];
    double damping[LANE_COUNT], stiffness[LANE_COUNT], quadratic[LANE_COUNT];
    const struct system *system[LANE_COUNT];
    step_function *scalar;
    /* evaluations in addition to those of the steps; for implicit and adaptive ones, all */
    int64_t evals[LANE_COUNT];
    struct lane_part part[TERM_MAX];
    int parts;
    struct lane_part slopes;
    struct built_in_programs built_in;
    /* weights of the stages from the second on; [0] are those of the step */
    struct weights weights[WEIGHT_STAGES];
    struct lane_control control;
    struct lane_drive drive;
    /* Arrays of [LANE_COUNT] each, within `memory`: */
    double *input; /* t, the state [n] of the stage, values [values]: names of the programs */
    double *state; /* the state within `input` */
    double *y;     /* [n] the state at the start of the step */
    double *k;     /* [stages][n] its slopes */
    double *pull, *drags; /* [rows] splittings: forces */
    double *spare;        /* [n] */
    double *half;         /* [3] exact drag: its flow over h/2 (keep, least, pull) */
    double *frozen;       /* [weights][2] in each kick (lost, pull) */
    /* [n] adaptive steps: excess of the sizes, the least ones, those that were given, their scale
     */
    double *excess, *min, *given, *scale;
    double *work; /* scratch memory of a lane that is stepped alone */
    double *memory;
    size_t size, used; /* size of `memory` and used part */
};

/* ---- forces (forces.c) ---- */

/* Describes the forces of such systems, and makes programs of built-in ones. Returns false if out
 * of memory. */
bool lanes_describe_forces(struct lanes *lanes, const struct system *system);
void lanes_destroy_programs(struct built_in_programs *programs);
/* Values of the programs' names behind the state. */
void lanes_set_values(struct lanes *lanes, int lane, const struct system *system);
/* Prepares the programs for what lanes share, before the first step and when all lanes are set. */
void lanes_prepare_forces(struct lanes *lanes);
/* Computes force [rows][LANE_COUNT]: a sum of forces at lanes->state. */
void lanes_force(struct lanes *lanes, enum lane_sum sum, struct lane_time stage_time,
                 double *force);
/* Computes slope [n][LANE_COUNT]. */
void lanes_slope(struct lanes *lanes, struct lane_time stage_time, double *slope);
/* Returns the time of this part of the present step; own: [LANE_COUNT], where lanes have theirs. */
struct lane_time lanes_time(const struct lanes *lanes, double c, double *own);
/* Advances the time by this part of the step; `own` is the same array as above. */
void lanes_time_add(const struct lanes *lanes, double part, struct lane_time *stage_time,
                    double *own);

/* ---- steps ---- */

/* z = y + sum_j weight_j k_j, each [n]; h: NULL, or what weights are multiplied by [LANE_COUNT] */
void lanes_combine(const struct weights *sum, const double *h, int n, const double *k,
                   const double *y, double *z);
/* As lanes_march(), of oscillators whose forces and steps the compiler knows; returns false if it
 * does not. */
bool lanes_march_shape(struct lanes *lanes, int64_t count, double *row);
/* As lanes_march(), of the families of methods. */
void lanes_march_rk(struct lanes *lanes, int64_t count, double *row);
void lanes_march_split(struct lanes *lanes, int64_t count, double *row);
void lanes_march_implicit(struct lanes *lanes, int64_t count, double *row);

static inline bool lane_turns(double v0, double v1)
{
    return (v0 < 0 && v1 > 0) || (v0 > 0 && v1 < 0);
}

/* Copies numbers [count][LANE_COUNT] of one lane from or to an array of its own. */
static inline void lane_get(int count, const double *source, int lane, double *target)
{
    for (int i = 0; i < count; i++)
        target[i] = source[i * LANE_COUNT + lane];
}

static inline void lane_put(int count, const double *source, int lane, double *target)
{
    for (int i = 0; i < count; i++)
        target[i * LANE_COUNT + lane] = source[i];
}
