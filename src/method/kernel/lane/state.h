/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the kernels in lanes (steps.c) and those who call them (march.c) know of the lanes. */
#ifndef HOOKE_METHOD_KERNEL_LANE_STATE_H
#define HOOKE_METHOD_KERNEL_LANE_STATE_H

#include "method/kernel/kernel.h"

enum { LANE_COEFFICIENTS = 2, WORK_MOST = 64, ROSENBROCK_STAGES = 8 };

enum { TABLE_ROOM = 1 << 17 }; /* [double] a megabyte */
/* Lanes whose drives are looked at together; times at which they are known at once, so few that
 * they stay in a cache. */
enum { LANE_GROUP = 32, DRIVE_ROWS = 128 };

/* What a kernel knows of the drive: there is none; a value for all lanes; one for each. */
enum drive_known { DRIVE_NONE, DRIVE_ALIKE, DRIVE_OWN };

struct lane_range {
    double omega[2], phase[2]; /* least and largest */
};

/*
 * Steps whose size follows the error: what struct controller has, for each lane. Lanes whose next
 * step is so short (of the time, and at all), whose state is so far out, or whose steps creep are
 * not for lanes.
 */
#define LANE_SHORT 1e-12
#define LANE_SHORTEST 1e-300
#define LANE_FAR 1e100

struct lane_control {
    double t0, t_end, creep;
    /* largest_estimate() and the filter of the method */
    double aims, by_error, by_previous, by_ratio, elementary;
    double tol[LANES], accepted[LANES]; /* of each, and 1/(n largest_estimate()^2) */
    double t[LANES], t_low[LANES], h[LANES], last[LANES], previous[LANES];
    double sampled[LANES], elapsed[LANES], excess[2][LANES];
    double min[2][LANES], given[2][LANES]; /* sizes; those that follow from the scene's atol, 0 */
    int64_t running[LANES], rejected[LANES], failed[LANES], alone[LANES]; /* 0 or -1 */
    int64_t steps[LANES], evals[LANES];
};

struct lanes {
    const struct method *method;
    enum drag drag;
    int most;                  /* doubles in a vector */
    int shape;                 /* -1: typed */
    struct typed_lanes *typed; /* NULL: not yet used */
    double t0, h;
    int64_t step; /* taken */
    /* Each lane's start of time and step; `own`: they differ. */
    double own_t0[LANES], own_h[LANES];
    bool own;
    double c[SHAPE_TERMS][LANE_COEFFICIENTS][LANES];
    double y[2][LANES];
    /* the last stage's slope, or the last force: what the next step begins with */
    double carried[2][LANES];
    /* What implicit stages know of the forces; what increments are measured by */
    double damping[LANES], stiffness[LANES], quadratic[LANES], scale[2][LANES];
    /* The drag's flow over h/2; with a divisor other than 1? */
    double keep[LANES], min[LANES], pull[LANES];
    bool divides;
    /* Turning points: lanes are stepped across one at a time. */
    bool turns;
    const struct system *system[LANES];
    step_function *scalar;
    int64_t more[LANES]; /* evaluations that these took; of implicit methods, all */
    struct {
        double lost[LANES], pull[LANES];
    } frozen[WEIGHTS_MAX]; /* exact linear drag in each kick */
    struct lane_control control;
    double omega[LANES], phase[LANES];
    bool driven;
    struct lane_range range[LANES / LANE_GROUP];
    int row_of[DRIVE_ROWS]; /* of the drives where lanes have their own */
    /* The cosine of the drive at each place of each step, where it is the same in all lanes. It
     * outlives them: the next block may be driven alike. */
    struct {
        const struct method *method;
        double omega, phase, t0, h;
        int64_t from, count; /* steps */
        double value[TABLE_ROOM];
    } table;
};

/* A step of some lanes: the states before and after it, its first and its last slope. */
struct lane_step {
    double before[2][LANES], after[2][LANES], first[2][LANES], last[2][LANES];
};

struct lane_march {
    int64_t first, count;
    /* the commonest: four stages, each from the one before; a drift, then a kick; one stage */
    bool chain;
    bool accurate;                      /* implicit: the last stage is the new state */
    struct weights weights[STAGES_MAX]; /* of the stages from the second on; [0]: of the step */
    double weight[WEIGHTS_MAX];         /* of drifts and kicks, times h */
    enum drive_known drive;
    const double *cosine; /* [count][places], of own ones [row_of[count][places]][LANES] */
    const int *row_of;
    int times;
    double *row;
};

typedef void lane_kernel(struct lanes *lanes, const struct lane_march *march);

/* ---- shapes ---- */

#define LANE_OSCILLATORS(S) LINEAR_SHAPES(S) SHAPES(S)
#define LANE_MODELS(S) S(pendulum) S(driven_pendulum)
#define LANE_SHAPES(S) LANE_OSCILLATORS(S) LANE_MODELS(S)

/* Of these, those without a drive. */
#define AUTONOMOUS_SHAPES(S)                                                                       \
    S(spring) S(damped) S(drag) S(damped_drag) S(duffing) S(vanderpol) S(pendulum)

#define LANE_PLACE(shape) LANE_##shape,
enum { LANE_SHAPES(LANE_PLACE) LANE_SHAPE_COUNT };

/* ---- widths ---- */

enum { LANE_EXPLICIT, LANE_SPLIT, LANE_IMPLICIT, LANE_ADAPTIVE, LANE_FAMILIES };

struct lane_width {
    lane_kernel *const (*kernels)[LANE_FAMILIES]; /* of a shape and a family of methods */
    lane_kernel *const *rosenbrocks;              /* of a shape; NULL: it has a drive */
    void (*drives)(const struct lanes *lanes, double t, double *cosine);
    void (*own_drives)(const struct lanes *lanes, const double *t, double *cosine); /* t [LANES] */
};

/* -1: none of these */
int lane_shape_of(const struct system *system);
/* Of `count` lanes from `first` on those that are marked in control.alone take a step alone. */
void lanes_attempt_alone(struct lanes *lanes, int first, int count);

/* The widest that runs here, of at most so many doubles. */
struct lane_width lanes_width(int most);

#endif
