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
    int index; /* of the parameter or the derived quantity */
    enum quantity quantity;
    double begin, end; /* SI */
    int count;
    bool log;
};

/* By name, of a scene; false: nothing that can be swept. */
bool sweep_axis_find(const struct scene *scene, struct text name, struct sweep_axis *axis);
double sweep_axis_value(const struct sweep_axis *axis, int i);

enum sweep_kind {
    /* Watched on the way, of a column: */
    SWEEP_AMPLITUDE, /* half its swing in the last third of the duration */
    SWEEP_PERIOD,    /* mean time between its maxima there */
    SWEEP_MEAN,      /* over that time */
    SWEEP_MAX,       /* from the start on */
    SWEEP_MIN,
    SWEEP_ERROR,        /* as struct run_errors has it */
    SWEEP_ENERGY_ERROR, /* largest, as the ledger has it */
    SWEEP_STEPS,
    SWEEP_EVALS,
    SWEEP_REACHED,   /* [s] time reached: of what diverges, when */
    SWEEP_ATTRACTOR, /* by measure->attractor: of the point's start, whatever the method and
                        duration */
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

/* At the end, unless it says otherwise. */
struct sweep_measure {
    enum sweep_kind kind;
    enum sweep_kind column; /* what is watched: one of the last four, else the first variable */
    int variable;           /* SWEEP_VARIABLE, SWEEP_OBSERVED: which one */
    const struct observable *observable;       /* SWEEP_OBSERVABLE */
    const struct sweep_expression *expression; /* column SWEEP_FORMULA */
    const struct sweep_formula *formula;       /* kind SWEEP_FORMULA */
    char name[LIMIT_SYMBOL + 16];              /* max(z) */
    find_attractor *attractor;                 /* of SWEEP_ATTRACTOR */
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
    bool wanted, strobe; /* strobe: each period of the drive; else: */
    const char *text;    /* as it was typed */
    /* In slots of the run's scope (run_scope), then those of the scene; its scope is up to the
     * sweep. */
    struct event event;
    int64_t skip, keep; /* together at most LIMIT_EVENT_RECORDS */
};

#define SWEEP_SKIP_USUAL 100
#define SWEEP_KEEP_USUAL 100

#define SWEEP_MEASURES 16

struct sweep_request {
    const struct scene *scene;
    const struct method *method;
    struct run_settings settings; /* what is recorded is up to the sweep */
    double duration;              /* [s] */
    struct sweep_axis axis[2];
    int axes;
    struct sweep_measure measure[SWEEP_MEASURES];
    int measures;
    /* What is wanted of them, where some of it is a formula: shown [columns], the others are
     * measure [place]. 0: the measures. */
    struct sweep_measure shown[SWEEP_MEASURES];
    int place[SWEEP_MEASURES], columns;
    struct sweep_section section; /* then the measures are columns, see sweep_at_section() */
    int64_t shard, shards;        /* 1 … shards */
    int64_t first, count;         /* count > 0: only these points, as numbers of the whole sweep */
    int threads;                  /* 0: as many as there are processors */
    const struct sweep *previous; /* what is finished there is taken; NULL */
    const struct cancel *cancel;
    /* from the calling thread, ten times a second; NULL */
    void (*progress)(void *context, double fraction);
    void *context;
};

enum sweep_status { SWEEP_MISSING = -1, SWEEP_REFUSED = -2 }; /* of a point, else enum stop */

struct sweep {
    struct sweep_axis axis[2];
    /* of a section so many for each point: after how many events its states come again (NAN: not
     * within half of those that were kept), then keep times the time [s] and what was measured */
    int axes, measures;
    int64_t total, first, count; /* points of all shards, number of the first here, how many here */
    double
        *value; /* [count][measures] NAN: not defined, or did not get there; owned: sweep_free() */
    signed char *status;                             /* [count] enum stop or sweep_status */
    int64_t finished, refused, failed, side_by_side; /* failed: diverged and the like; in lanes */
    char reason[600];                                /* of the first refused point */
    double steps;                                    /* of all */
    double seconds;
    int threads;
};

/* So many points are a cell; the last one of `total` may have fewer. */
int64_t sweep_cell(int64_t total);
/* Which points the shard has, or `first` and `count`: total, first and count, no results yet. */
void study_sweep_stretch(const struct sweep_request *request, struct sweep *sweep);
/* So many points [> 0] at a time fill the lanes of all threads, each with a task of their own. */
int64_t study_sweep_batch(const struct sweep_request *request);
/* Steps and computing time [s] that it will take, roughly; NAN: not known before. */
void study_sweep_predict(const struct sweep_request *request, double *steps, double *seconds);
/* False: refused as a whole, or cancelled; then what is finished is kept. sweep_free() in every
 * case. */
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

/* Of that measure, by number; returns how many. */
int sweep_attractors(const struct sweep_request *request, const struct sweep *sweep, int measure,
                     struct sweep_attractor found[SWEEP_ATTRACTORS]);
