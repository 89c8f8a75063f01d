/* SPDX-License-Identifier: GPL-3.0-or-later */
/* State of the lanes, shared by the files of src/modules/lanes/compute. Each number of a trajectory
 * is an array [LANE_COUNT], so that loops over lanes become vector instructions; forces are
 * programs, also those of built-in terms. The operations are those of one trajectory in the same
 * order, which gives the same bits. */
#pragma once

#include "method/step/split_body.h"
#include "method/step/weights.h"
#include "modules/lanes/compute/vector.h"
#include "modules/lanes/lanes.h"

/* Sums of forces: all, those without velocity, and the drag. */
enum lane_sum { SUM_ALL, SUM_FORCE, SUM_DRAG, LANE_SUMS };

/* A program that computes a part of the forces. */
struct lane_part {
    const struct program *program;
    double *frame;
    unsigned sums; /* bits 1 << enum lane_sum of the sums that it belongs to */
};

/* Programs of built-in terms: one for each sum, and one for the derivatives of all. They are kept
 * while systems have the same terms. */
struct built_in_programs {
    const struct term_row *row[TERM_MAX];
    /* number of terms; number of the first program name that has their coefficients */
    int terms, first;
    struct program *sum[LANE_SUMS], *slopes;
};

/* Time of a stage. */
struct lane_time {
    const double *t; /* [LANE_COUNT] time of each lane, or NULL if `all` holds for every lane */
    double all;
};

/* Adaptive steps: the members of struct controller for each lane. Lanes whose next step is shorter
 * than these parts [of t; s], or whose state is larger than lane_farthest, are stepped alone or
 * fail. */
static const double lane_shortest_of_time = 1e-12, lane_shortest = 1e-300, lane_farthest = 1e100;

/* Controllers of adaptive lanes. */
struct lane_control {
    /* [s] end, and the fraction of the time since the start below which a step is too short */
    double t_end, creep;
    /* constants of the controller: aim, exponents of the errors and the ratio, and of a rejected
     * step */
    double aims, by_error, by_previous, by_ratio, elementary;
    double tol[LANE_COUNT], accepted[LANE_COUNT]; /* accepted is 1/(n largest_estimate()^2) */
    double t[LANE_COUNT], t_low[LANE_COUNT], h[LANE_COUNT], last[LANE_COUNT], previous[LANE_COUNT],
        sampled[LANE_COUNT], elapsed[LANE_COUNT];
    /* lanes that have not arrived, whose last attempt was rejected, that have failed, that need a
     * step alone */
    lane_mask running[LANE_COUNT], rejected[LANE_COUNT], failed[LANE_COUNT], alone[LANE_COUNT];
    int64_t steps[LANE_COUNT];
};

/* Key of stored cosines: a drive that is the same in all lanes depends on the method, c1, c2, t0
 * and h. */
struct driven_by {
    const struct method *method; /* method, or NULL if lanes have their own drives */
    double number[4];
};

/* Cosines of the drive at the stages of coming steps; an index counts the stages of all these
 * steps. */
enum { DRIVE_VALUES = 1 << 15, DRIVE_ROWS = 64 };
/* Stored cosines of the drive. */
struct lane_drive {
    bool own;
    int rows, places;
    const double *c1, *c2; /* [LANE_COUNT] coefficients; NULL if there is no drive */
    struct driven_by driver;
    int64_t begin, end; /* [step] range for which they are known */
    /* [steps][places] those of the next steps, if they are the same in all lanes */
    const double *next;
    const double
        *value_rows[DRIVE_ROWS]; /* [steps][places] rows of values, where lanes have their own */
    double time[LANE_COUNT], value[DRIVE_VALUES]; /* time and rows of values */
};

/* State of LANE_COUNT trajectories. */
struct lanes {
    const struct method *method;
    enum drag drag;
    struct split_way way; /* order of substeps of a splitting */
    double t0, h;
    int64_t step; /* number of steps taken */
    /* variables; accelerations (or derivatives of first order); typed values; all values of the
     * programs */
    int n, rows, typed_values, values;
    /* forces depend on the time; turning points are located */
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
    /* evaluations in addition to those of regular steps; for implicit and adaptive methods all of
     * them */
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
    double *pull, *drags; /* [rows] forces of splittings: without and with drag */
    double *spare;        /* [n] one part of a force */
    double *half;         /* [3] flow of exact drag over h/2 (keep, min, pull) */
    double *frozen;       /* [weights][2] exact drag in each kick (lost, pull) */
    /* [n] adaptive steps: excess of the sizes, smallest sizes, sizes by atol, and the resulting
     * scale */
    double *excess, *min, *given, *scale;
    double *work; /* scratch memory of a lane that is stepped alone */
    double *memory;
    size_t size, used; /* size of `memory` and used part */
};

/* ---- forces (forces.c) ---- */

/* Describes the forces of such systems, and makes programs of built-in ones. Returns false if out
 * of memory. */
bool lanes_describe_forces(struct lanes *lanes, const struct system *system);
/* Frees the programs. */
void lanes_destroy_programs(struct built_in_programs *programs);
/* Copies the values of the programs' names, which are stored behind the state, to one lane. */
void lanes_set_values(struct lanes *lanes, int lane, const struct system *system);
/* Prepares the programs for what lanes share, before the first step and when all lanes are set. */
void lanes_prepare_forces(struct lanes *lanes);
/* Computes force [rows][LANE_COUNT]: a sum of forces at lanes->state. */
void lanes_force(struct lanes *lanes, enum lane_sum sum, struct lane_time stage_time,
                 double *force);
/* Computes the derivatives slope [n][LANE_COUNT] at lanes->state. */
void lanes_slope(struct lanes *lanes, struct lane_time stage_time, double *slope);
/* Returns the time t + c h of the present step; own is an array [LANE_COUNT] for lanes with their
 * own times. */
struct lane_time lanes_time(const struct lanes *lanes, double c, double *own);
/* Advances a time by `part` of the step; own is the array that lanes_time() has filled. */
void lanes_time_add(const struct lanes *lanes, double part, struct lane_time *stage_time,
                    double *own);

/* ---- steps ---- */

/* Computes z = y + sum_j weight_j k_j, each [n][LANE_COUNT]; h [LANE_COUNT] multiplies the weights,
 * or is NULL. */
void lanes_combine(const struct weights *sum, const double *h, int n, const double *k,
                   const double *y, double *z);
/* Makes steps as lanes_march() does, by a kernel for the shape of the forces. Returns false if
 * there is none. */
bool lanes_march_shape(struct lanes *lanes, int64_t count, double *row);
/* Make steps as lanes_march() does, for each family of methods. */
void lanes_march_rk(struct lanes *lanes, int64_t count, double *row);
void lanes_march_split(struct lanes *lanes, int64_t count, double *row);
void lanes_march_implicit(struct lanes *lanes, int64_t count, double *row);

/* Returns true if a velocity changes its sign from v0 to v1. */
static inline bool lane_turns(double v0, double v1)
{
    return (v0 < 0 && v1 > 0) || (v0 > 0 && v1 < 0);
}

/* Copies numbers [count] of one lane out of arrays [count][LANE_COUNT]. */
static inline void lane_get(int count, const double *source, int lane, double *target)
{
    for (int i = 0; i < count; i++)
        target[i] = source[i * LANE_COUNT + lane];
}

/* Copies numbers [count] of one lane into arrays [count][LANE_COUNT]. */
static inline void lane_put(int count, const double *source, int lane, double *target)
{
    for (int i = 0; i < count; i++)
        target[i * LANE_COUNT + lane] = source[i];
}
