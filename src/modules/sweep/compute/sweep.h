/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One or two quantities varied, a trajectory each. */
#pragma once

#include <hooke/figure.h>
#include <hooke/run.h>
#include <hooke/run/attractor.h>

struct cancel;
struct catalog;

/* ---- sweep: one or two quantities varied, a trajectory each ----
 *
 * Points are numbered 0 … total - 1, the last axis fastest. What is measured of a point does not
 * depend on the others, on threads or on shards: shard i of n is a stretch of the numbers, and
 * stretches put together are the whole. They begin and end with cells, so many points each.
 */

enum sweep_role { SWEEP_PARAM, SWEEP_DERIVED, SWEEP_DT, SWEEP_TOL };

struct sweep_axis {
    char name[LIMIT_NAME + 1];
    enum sweep_role target;
    int index; /* index of the parameter or the derived quantity */
    enum quantity quantity;
    double begin, end; /* SI */
    int count;
    bool log;
};

/* Finds what `name` varies in the scene. Returns false if it cannot be swept. */
bool sweep_axis_find(const struct scene *scene, struct text name, struct sweep_axis *axis);
double sweep_axis_value(const struct sweep_axis *axis, int i);

enum sweep_kind {
    /* The following are watched during the run, for a column. */
    SWEEP_AMPLITUDE, /* half the peak-to-peak value in the last third of the duration */
    SWEEP_PERIOD,    /* mean time between maxima in this window */
    SWEEP_MEAN,      /* mean over this window */
    SWEEP_MAX,       /* maximum of the whole run */
    SWEEP_MIN,
    SWEEP_ERROR,        /* error as in struct run_errors */
    SWEEP_ENERGY_ERROR, /* largest error of the energy balance */
    SWEEP_STEPS,
    SWEEP_EVALS,
    SWEEP_REACHED, /* [s] end of the run, which is earlier if it diverges */
    /* Result of measure->attractor for the point's start; depends on neither method nor
     * duration. */
    SWEEP_ATTRACTOR,
    SWEEP_VARIABLE,
    SWEEP_OBSERVED, /* a typed quantity */
    SWEEP_OBSERVABLE,
    SWEEP_FORMULA /* an expression */
};

/* Slots of names in expressions of a sweep: its own from 0 on, then the scene's parameters and its
 * derived quantities. What else an expression knows is a number in it. */
enum { SWEEP_SLOT_PARAM = 1 << 20, SWEEP_SLOT_DERIVED = 1 << 21 };

#define SWEEP_COLUMNS 16

/* A column by an expression; slot i is column [i], a slot of the run's scope (run_scope). */
struct sweep_expression {
    const struct expr *expr;
    enum quantity quantity;
    int columns, column[SWEEP_COLUMNS];
    bool works; /* needs the work done on the way */
};

/* A measure by an expression of others; slot i is measure i of the request, slot
 * SWEEP_MEASURES + i the root of that. */
struct sweep_formula {
    const char *text; /* as it was typed */
    const struct expr *expr;
    enum quantity quantity;
};

/* Quantity measured at the end of a run, unless its kind says otherwise. */
struct sweep_measure {
    enum sweep_kind kind;
    /* Column that is watched: one of the last four kinds, or the first variable. */
    enum sweep_kind column;
    int variable;                              /* index for SWEEP_VARIABLE and SWEEP_OBSERVED */
    const struct observable *observable;       /* SWEEP_OBSERVABLE */
    const struct sweep_expression *expression; /* column SWEEP_FORMULA */
    const struct sweep_formula *formula;       /* kind SWEEP_FORMULA */
    char name[LIMIT_SYMBOL + 16];              /* such as "max(z)" */
    find_attractor *attractor;                 /* used by SWEEP_ATTRACTOR */
};

static inline bool sweep_watches(const struct sweep_measure *measure)
{
    return measure->kind <= SWEEP_MIN;
}

/* struct row at the place of the kind: those with names of their own */
extern const struct catalog sweep_measure_catalog;

/* A row of that catalog, a state variable, a typed quantity, an observable; max(z) for what is
 * watched of another column than the first. */
bool sweep_measure_find(const struct model *model, struct text name, struct sweep_measure *measure,
                        struct error *error);
/* Returns true if it can be measured at an event, as a function of state and time. */
bool sweep_at_section(const struct sweep_measure *measure);
const char *sweep_measure_name(const struct sweep_measure *measure);
enum quantity sweep_measure_quantity(const struct sweep_measure *measure,
                                     const struct model *model);

/* ---- at a section ----
 *
 * Instead of over the duration a point is measured where an event happens (Poincare 1899), or after
 * each whole period of the drive: `keep` times, the first `skip` are left out. What is kept over a
 * parameter is an orbit diagram (Feigenbaum 1978; Moon and Holmes 1979 of a drive). A point at
 * which no event comes for a whole duration ends there.
 */

struct sweep_section {
    bool wanted, strobe; /* `strobe` measures at each period of the drive, not at `event` */
    const char *text;    /* text as typed */
    /* Its slots are those of the run's scope (run_scope), then those of the scene. The sweep sets
     * its scope. */
    struct event event;
    int64_t skip, keep; /* numbers of events, together at most LIMIT_EVENT_RECORDS */
};

#define SWEEP_SKIP_USUAL 100
#define SWEEP_KEEP_USUAL 100

#define SWEEP_MEASURES 16

struct sweep_request {
    const struct scene *scene;
    const struct method *method;
    struct run_settings settings; /* The sweep decides what is recorded. */
    double duration;              /* [s] */
    struct sweep_axis axis[2];
    int axes;
    struct sweep_measure measure[SWEEP_MEASURES];
    int measures;
    /* Results that are asked for, if some of them are formulas: shown [columns]; those that are not
     * formulas are measure[place]. With columns 0 the measures are shown. */
    struct sweep_measure shown[SWEEP_MEASURES];
    int place[SWEEP_MEASURES], columns;
    struct sweep_section section; /* The measures are then columns, see sweep_at_section(). */
    int64_t shard, shards;        /* number of the shard, 1 to `shards` */
    /* If count > 0, only these points, numbered in the whole sweep. */
    int64_t first, count;
    int threads;                  /* number of threads, or 0 for the number of processors */
    const struct sweep *previous; /* points finished there are taken over; may be NULL */
    const struct cancel *cancel;
    /* Called ten times a second from the calling thread; may be NULL. */
    void (*progress)(void *context, double fraction);
    void *context;
};

/* Status of a point, beside enum stop. */
enum sweep_status { SWEEP_MISSING = -1, SWEEP_REFUSED = -2 };

struct sweep {
    struct sweep_axis axis[2];
    /* Each point has `measures` values. At a section these are the number of events after which its
     * states repeat (NAN if not within half of those kept), then for each event the time [s] and
     * the quantities measured. */
    int axes, measures;
    /* Points of all shards, number of the first one here, number here. */
    int64_t total, first, count;
    double *value; /* [count][measures] NAN if undefined or not reached; freed by sweep_free() */
    signed char *status; /* [count] enum stop or sweep_status */
    /* Numbers of points; `failed` ones ended early, such as by divergence; `side_by_side` ones ran
     * in lanes. */
    int64_t finished, refused, failed, side_by_side;
    char reason[600]; /* reason of the first refused point */
    double steps;     /* steps of all points */
    double seconds;
    int threads;
};

/* So many points are a cell; the last one of `total` may have fewer. */
int64_t sweep_cell(int64_t total);
/* Sets total, first and count to the points of the shard, or of the request's `first` and `count`.
 * The sweep has no results yet. */
void study_sweep_stretch(const struct sweep_request *request, struct sweep *sweep);
/* So many points [> 0] at a time fill the lanes of all threads, each with a task of their own. */
int64_t study_sweep_batch(const struct sweep_request *request);
/* Estimates the steps and the computing time [s]; NAN if they cannot be predicted. */
void study_sweep_predict(const struct sweep_request *request, double *steps, double *seconds);
/* Computes the sweep. Returns false with `error` filled if it is refused as a whole or cancelled,
 * when finished points are kept. sweep_free() must be called in any case. */
bool study_sweep(const struct sweep_request *request, struct sweep *sweep, struct error *error);
void sweep_free(struct sweep *sweep);
/* place on the axis of point first + i */
int64_t sweep_number(const struct sweep *sweep, int axis, int64_t i);
const char *sweep_status_name(int status);

/* ---- what the numbers of SWEEP_ATTRACTOR stand for ---- */

#define SWEEP_ATTRACTORS 16

struct sweep_attractor {
    double number;
    int64_t count, first; /* points, and the place of the first; as it is there: */
    bool known;           /* it was found once more */
    struct basin basin;
};

/* Finds the attractors that a measure has numbered. Returns their number. */
int sweep_attractors(const struct sweep_request *request, const struct sweep *sweep, int measure,
                     struct sweep_attractor found[SWEEP_ATTRACTORS]);
