/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps: one or two quantities are varied and a trajectory is computed and measured for each
 * value. Fill in a struct sweep_request (axes by sweep_axis_find(), measures by
 * sweep_measure_find()), call study_sweep(), then sweep_free(). */
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

/* The target of an axis: a parameter, a derived quantity such as omega0, the step, or the
 * tolerance. */
enum sweep_role { SWEEP_PARAM, SWEEP_DERIVED, SWEEP_DT, SWEEP_TOL };

/* One axis of a sweep: `count` values from begin to end, evenly or in equal ratios (`log`). */
struct sweep_axis {
    char name[LIMIT_NAME + 1]; /* name that the user types */
    enum sweep_role target;    /* kind of the varied quantity */
    int index;                 /* index of the parameter or the derived quantity */
    enum quantity quantity;
    double begin, end; /* SI */
    int count;
    bool log;
};

/* Finds what `name` varies in the scene and fills in name, target, index and quantity of the axis.
 * Returns false if it cannot be swept. */
bool sweep_axis_find(const struct scene *scene, struct text name, struct sweep_axis *axis);
/* Returns value number i of the axis, in SI units. */
double sweep_axis_value(const struct sweep_axis *axis, int i);

/* Kinds of measures. */
enum sweep_kind {
    /* The following are watched during the run, for one column (see struct sweep_measure). */
    SWEEP_AMPLITUDE, /* half the peak-to-peak value in the window, the last third of the duration */
    SWEEP_PERIOD,    /* [s] mean time between maxima in the window */
    SWEEP_MEAN,      /* mean over the window */
    SWEEP_MAX,       /* maximum of the whole run */
    SWEEP_MIN,       /* minimum of the whole run */
    SWEEP_ERROR,     /* error as in struct run_errors */
    SWEEP_ENERGY_ERROR, /* largest error of the energy balance */
    SWEEP_STEPS,        /* number of steps */
    SWEEP_EVALS,        /* number of force evaluations */
    SWEEP_REACHED,      /* [s] end of the run, which is earlier if it diverges */
    /* Result of measure->attractor for the point's start; depends on neither method nor
     * duration. */
    SWEEP_ATTRACTOR,
    SWEEP_VARIABLE,   /* a state variable at the end */
    SWEEP_OBSERVED,   /* a typed quantity at the end */
    SWEEP_OBSERVABLE, /* an observable at the end */
    SWEEP_FORMULA     /* an expression */
};

/* Slots of names in expressions of a sweep: the sweep's own from 0 on, then the scene's parameters
 * and its derived quantities. All other names are replaced by numbers when the expression is
 * compiled. */
enum { SWEEP_SLOT_PARAM = 1 << 20, SWEEP_SLOT_DERIVED = 1 << 21 };

#define SWEEP_COLUMNS 16 /* largest number of columns in an expression */

/* A column computed by an expression. Slot i of the expression is the quantity of the run with slot
 * column[i] of run_scope(). */
struct sweep_expression {
    const struct expr *expr;
    enum quantity quantity;
    int columns, column[SWEEP_COLUMNS];
    bool works; /* needs the work of drag and drive since the start */
};

/* A measure computed by an expression of others. Slot i of the expression is measure i of the
 * request, slot SWEEP_MEASURES + i the square root of that. */
struct sweep_formula {
    const char *text; /* as it was typed */
    const struct expr *expr;
    enum quantity quantity;
};

/* A quantity that is measured of each point. */
struct sweep_measure {
    enum sweep_kind kind;
    /* Column that is watched or measured: one of the last four kinds of enum sweep_kind. */
    enum sweep_kind column;
    int variable;                              /* index for SWEEP_VARIABLE and SWEEP_OBSERVED */
    const struct observable *observable;       /* SWEEP_OBSERVABLE */
    const struct sweep_expression *expression; /* column SWEEP_FORMULA */
    const struct sweep_formula *formula;       /* kind SWEEP_FORMULA */
    char name[LIMIT_SYMBOL + 16];              /* such as "max(z)" */
    find_attractor *attractor; /* function that finds attractors, for SWEEP_ATTRACTOR */
};

/* Returns true if the measure is watched during the run, not taken at its end. */
static inline bool sweep_watches(const struct sweep_measure *measure)
{
    return measure->kind <= SWEEP_MIN;
}

/* names of the kinds before SWEEP_VARIABLE, indexed by enum sweep_kind */
extern const struct catalog sweep_measure_catalog;

/* Finds a measure by its name: a row of that catalog, a state variable, a typed quantity or an
 * observable, or as in max(z) what is watched of another column than the first variable. Returns
 * false with an error, which suggests names, if there is none. */
bool sweep_measure_find(const struct model *model, struct text name, struct sweep_measure *measure,
                        struct error *error);
/* Returns true if the measure is a function of state and time, so that it can be taken at an
 * event. */
bool sweep_at_section(const struct sweep_measure *measure);
/* Returns the name of the measure as users type it. */
const char *sweep_measure_name(const struct sweep_measure *measure);
/* Returns the quantity of the measure's values. */
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
    /* the sweep has a section; `strobe` measures after each period of the drive, not at `event` */
    bool wanted, strobe;
    const char *text; /* as it was typed after `at` */
    /* Its slots are those of run_scope(), then those of the scene. The sweep sets its scope for
     * each point. */
    struct event event;
    int64_t skip,
        keep; /* numbers of events left out and kept, together at most LIMIT_EVENT_RECORDS */
};

/* Numbers of events that are left out and kept unless they are given. */
#define SWEEP_SKIP_USUAL 100
#define SWEEP_KEEP_USUAL 100

#define SWEEP_MEASURES 16 /* largest number of measures of a sweep */

/* Input of study_sweep(). Pointers are the caller's. */
struct sweep_request {
    const struct scene *scene;
    const struct method *method;
    /* its recording rule is replaced, as the sweep decides what is recorded */
    struct run_settings settings;
    double duration; /* [s] */
    struct sweep_axis axis[2];
    int axes;
    struct sweep_measure measure[SWEEP_MEASURES];
    int measures;
    /* Results that are wanted, if some of them are formulas: shown [columns]. Those that are not
     * formulas are measure[place]. If columns is 0, the measures themselves are wanted. */
    struct sweep_measure shown[SWEEP_MEASURES];
    int place[SWEEP_MEASURES], columns;
    struct sweep_section section; /* if wanted, all measures satisfy sweep_at_section() */
    int64_t shard, shards;        /* number of the shard to compute, from 1 to `shards` */
    /* If count > 0, only these points are computed, numbered in the whole sweep. */
    int64_t first, count;
    int threads;                  /* number of threads, or 0 for the number of processors */
    const struct sweep *previous; /* points that are finished there are copied; may be NULL */
    const struct cancel *cancel;
    /* Called ten times a second from the calling thread with the finished fraction; may be NULL. */
    void (*progress)(void *context, double fraction);
    void *context; /* passed to progress() */
};

/* Status of a point without a run; other points have that of enum stop. */
enum sweep_status { SWEEP_MISSING = -1, SWEEP_REFUSED = -2 };

/* Result of study_sweep(). Release with sweep_free(). */
struct sweep {
    struct sweep_axis axis[2];
    /* Each point has `measures` values. At a section these are the number of events after which its
     * states repeat (NAN if not within half of those kept), then for each event the time [s] and
     * the measured quantities. */
    int axes, measures;
    /* number of points of all shards, number of the first one in this result, and how many it
     * has */
    int64_t total, first, count;
    double *value; /* [count][measures] NAN if undefined or not reached; freed by sweep_free() */
    signed char *status; /* [count] enum stop or enum sweep_status */
    /* Numbers of points. `failed` ones ended early, such as by divergence; `side_by_side` ones ran
     * in lanes. */
    int64_t finished, refused, failed, side_by_side;
    char reason[600]; /* reason of the first refused point */
    double steps;     /* steps of all points */
    double seconds;   /* [s] computing time */
    int threads;
};

/* Returns the number of points of a cell: shards begin and end with cells. The last cell of `total`
 * points may have fewer. */
int64_t sweep_cell(int64_t total);
/* Sets axes, total, first and count of the sweep to the points that the request asks for: its
 * shard, or its `first` and `count`. The sweep has no results yet. */
void study_sweep_stretch(const struct sweep_request *request, struct sweep *sweep);
/* Returns the number of points, at least 1, that fill the lanes of all threads when computed at
 * once. */
int64_t study_sweep_batch(const struct sweep_request *request);
/* Estimates the number of steps and the computing time [s] of all points. Both are NAN if they
 * cannot be predicted. */
void study_sweep_predict(const struct sweep_request *request, double *steps, double *seconds);
/* Computes the sweep. Returns false with an error if it is refused as a whole, if every point is
 * refused, if out of memory, or if cancelled; finished points are kept. sweep_free() must be called
 * in any case. */
bool study_sweep(const struct sweep_request *request, struct sweep *sweep, struct error *error);
/* Frees values and statuses. */
void sweep_free(struct sweep *sweep);
/* Returns the number on the axis of point i of the sweep. */
int64_t sweep_number(const struct sweep *sweep, int axis, int64_t i);
/* Returns the word for a status: "missing", "refused", or the name of the stop. */
const char *sweep_status_name(int status);

/* ---- attractors that the numbers of SWEEP_ATTRACTOR denote ---- */

#define SWEEP_ATTRACTORS 16 /* largest number of attractors that are listed */

/* An attractor that points of a sweep end in. */
struct sweep_attractor {
    double number;        /* as the measure returns it */
    int64_t count, first; /* number of points, and index of the first one */
    bool known;           /* it was found again at that point, so that `basin` describes it */
    struct basin basin;
};

/* Lists the attractors that occur among the values of a measure, by ascending number, and finds
 * each once more to describe it. Returns how many there are, at most SWEEP_ATTRACTORS. */
int sweep_attractors(const struct sweep_request *request, const struct sweep *sweep, int measure,
                     struct sweep_attractor found[SWEEP_ATTRACTORS]);
