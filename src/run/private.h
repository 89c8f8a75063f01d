/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the files of this layer. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/base/numeric.h>
#include <hooke/run.h>
#include <string.h>

#include "run/failure/failure.h"
#include "run/saltation.h"
#include "run/trace.h"

struct cancel;

/* Once or twice a step: most scenes have two variables, for which a call costs more than the copy.
 */
static inline void copy_state(double *target, const double *source, int n)
{
    if (n == 2) {
        target[0] = source[0];
        target[1] = source[1];
    } else {
        memcpy(target, source, (size_t)n * sizeof *target);
    }
}

/* ---- runs ---- */

#define MEMORY_DEFAULT ((size_t)1 << 30) /* [byte] budget of a trace */

/* The scene in force from a step on: one at the start, one more for each run_rebind(). */
struct epoch {
    int64_t first; /* step index of its start */
    double t;      /* [s] */
    /* Start of the exact solution: its own value at the end of the epoch before. */
    double start[LIMIT_VARIABLES];
    struct system system;
    struct plan plan;
    enum drag drag;
    double value[PARAM_MAX]; /* values of the scene's parameters in SI */
};

/* The energy balance up to a state of the run. */
struct balance {
    int64_t step;
    double t;                  /* [s] of the grid where steps are fixed */
    double y[LIMIT_VARIABLES]; /* [n] the state there */
    double initial;            /* energy at the start, in units of factor^2 J */
    int solved;                /* steps whose work was found by solving the equations anew */
    struct energy_tally tally;
};

/* ---- work between states one step apart (work.c) ---- */

#define WORK_BLOCK 128 /* steps at once: a power of 2 */

/* Multiples of an angle, for the drive at even times. */
struct turns {
    double omega, h;
    double cosine[WORK_BLOCK + 1], sine[WORK_BLOCK + 1];
};

/* `count` steps under one system, from the state `initial_state`; row k is the state after step k.
 */
struct work {
    const struct system *system;
    double factor; /* Scale factor of all states. */
    int count;
    const double *initial_state, *row;
    size_t stride; /* numbers from one row to the next */
    /* Times [count + 1] of the states; NULL if they are at origin + (index + k) h, in one block of
     * the index. */
    const double *t;
    double origin, h; /* [s] */
    int64_t index;
    struct turns *turns;
};

struct work_done { /* Results in units of factor^2 J. */
    /* work in each step; drag is the part of it that drag did */
    double work[WORK_BLOCK], drag[WORK_BLOCK];
    double energy[WORK_BLOCK]; /* energy after each step */
    /* The force jumps inside the step or at one of its ends, so that the quintic does not hold; the
     * acceleration changes so much that it may not. Neither is set where none of them is true. */
    bool jumps[WORK_BLOCK], coarse[WORK_BLOCK];
    bool any_jumps, any_coarse;
    /* totals since the start, set by balance_block() */
    double all_work[WORK_BLOCK], all_drag[WORK_BLOCK];
};

void work_between(const struct work *work, struct work_done *done);

/* The state was changed from outside in that step. */
struct kick {
    int64_t step;
    double t;      /* [s] */
    double energy; /* [J] that it brought */
};

/* Records of events, in order of time. */
struct event_records {
    struct event_record *record;
    double *state; /* [count][n] */
    size_t count, capacity;
};

struct run_private {
    struct step step;
    double *work; /* memory of the method */
    double *side; /* another one, where states inside of a step need steps of their own; NULL */
    /* [n] the gap (inside.c) from a step without memory to the one taken, */
    double *gap;
    bool gap_known;         /* known for this step */
    double *previous_state; /* [n] state before the step */
    double *low_before;  /* [n] and what rounding had taken from it; used where step.low is there */
    double *bound;       /* [n] magnitudes that count as diverged */
    struct epoch *epoch; /* one epoch or more */
    size_t epochs, epoch_capacity;
    int64_t batch, look;    /* steps between looks at the clock; the next one of run_creeps() */
    size_t looked, checks;  /* rows that run_diagnose() has seen, and strange steps among them */
    size_t searched;        /* the last row that run_missed_burst() has seen */
    double probed;          /* [s] as far as run_force_unresolved() has looked for pulses */
    march_function *kernel; /* NULL if this method and system have none */
    struct propagator *propagator; /* NULL if it does not exist yet or is of no use */
    /* States [CHUNK_ROWS][n] that do not go into the trace unchanged; NULL until they are
     * needed. */
    double *scratch;
    double *work_before; /* The method's memory before many steps; NULL if none were taken. */
    const double *given; /* [n] each, of the steps from given_first to given_end: run_give() */
    int64_t given_first, given_end;
    double factor;              /* power of two on states before their energies are compared */
    const struct run *original; /* Run whose steps are taken again, for its balance; or NULL. */
    /* Conditions or events may have ended a step early, or adaptive steps began anew. */
    bool is_unrepeatable;
    /* balance up to the last step if rows have marks, else as far as it was asked for */
    struct balance balance;
    struct thinning *thinning; /* see ledger.c; NULL if none has begun */
    struct energy_tally
        *saved; /* [saves] at each CHUNK_ROWS steps up to there, where rows have no marks */
    size_t saves, save_capacity;
    struct turns turns;
    struct event_records event_records;
    struct second *second;                      /* see opinion.c; NULL if nobody asked for it */
    struct event_watch *watch;                  /* see watch.h; NULL if there are no events */
    struct event_doubt doubt[LIMIT_EVENTS + 1]; /* the last is that of the condition */
    struct kick *kick;
    size_t kicks, kick_capacity;
    struct responses responses;
    enum solution_fate fate; /* set by run_diagnose() */
    double sunk;             /* run_opinion_sunk() */
    /* evaluations and Jacobians of the solutions that regrowth_look() followed */
    double regrowth_work;
};

/* The state is no longer what the compensated sums know about. */
static inline void forget_rounding(struct run_private *p, int n)
{
    if (p->step.low)
        memset(p->step.low, 0, (size_t)n * sizeof *p->step.low);
}

/* Target and grid of one call of run_advance(). */
struct segment {
    const struct run_target *target;
    struct time_grid grid;
    int64_t last;            /* fixed step: index where the whole steps end */
    double rest;             /* [s] partial step after it; 0 if there is none */
    bool exact;              /* the whole steps end at the target */
    int64_t limit;           /* step index to stop at */
    bool rows_between_steps; /* rows at even times are between the steps */
    bool armed;              /* the condition was false since it was last true */
};

/* ---- rows at even times, if trace->interval is set (even.c) ---- */

/* The next row is the first beyond t on the way that h goes. */
void trace_aim(struct trace *trace, double t, double h);
/* Returns true if steps of the present grid end where rows are due, and sets which: every
 * trace->every, from trace->next on. */
bool trace_in_step(struct trace *trace);
/* As trace_record_many() there. */
int64_t trace_record_even(struct trace *trace, int64_t step, const double *row, int64_t count);
/*
 * Records rows of the step just taken from p->before at t over h, the run being at its end. Returns
 * STOP_FULL also if out of memory, and STOP_DIVERGED if a state inside of the step is out of
 * bounds, though that at its end is not.
 */
enum stop even_record(struct run *run, bool cold, double t, double h);
void even_drop(struct trace *trace, double t); /* the rows beyond t */
/* Returns true if the last row is the present state. */
bool even_present(const struct trace *trace, double row_time);

/* ---- event.c, inside.c ---- */

/* The state in the step just taken from p->before over h, at its share theta; the run still is at
 * its end. */
struct inside {
    struct run *run;
    /* Copy of the method, without its dense output if that would cover only a part of the step. */
    struct method method;
    double t, h;
};

/* Describes the inside of the last step; `cold` means that it was taken by method_turning_step(),
 * perhaps in parts. */
struct inside inside_of(struct run *run, bool cold, double t, double h);
/* The system that the last step was taken of: p->step, or another in *frozen. */
struct step inside_step(const struct inside *inside, struct sliding *sliding,
                        struct system *frozen);
void inside_state(const struct inside *inside, double theta, double *y);

/* Compiles the target's events for the present system of the run, with signs at its present state.
 * Returns false if out of memory. */
bool events_begin(struct run *run, const struct segment *segment);
/* The run has states that were not watched, or went back: sizes of its variables are found anew. */
void events_forget_sizes(struct run *run);
/* Finds the events in the step just taken from p->before at t over h. Returns false if out of
 * memory. */
bool events_find(struct run *run, const struct segment *segment, double t, double h);
/* Keeps those up to the present time; ends at one that stops the run, and puts the run there.
 * Returns false if out of memory. */
bool events_keep(struct run *run, const struct segment *segment, double h, bool *stops);
/* Returns true if the condition became true in the step, and not after another event that stops the
 * run. *theta is then the first such fraction of the step. */
bool events_until(const struct run *run, double *theta);
/* Returns true if another event stops the run in the step. */
bool events_stop(const struct run *run);
/* The state where it did is known better now: run->t and run->y, for the events at the same moment
 * too. */
void events_until_at(struct run *run, double theta);
/* Drops those after the present step; of that step those ahead of the present time. */
void event_records_truncate(struct run *run, double ahead);

#define ALWAYS_INLINE static inline __attribute__((always_inline))

/* Four numbers at once, in whatever registers there are; of wider ones, where there are none,
 * compilers make a mess. */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));
typedef uint64_t four_bits __attribute__((vector_size(32), aligned(8), may_alias));
#define VECTOR_LANES 4
/* Raises each of *max to that of *x. */
ALWAYS_INLINE void four_raise(four *max, const four *x)
{
    for (int i = 0; i < VECTOR_LANES; i++)
        (*max)[i] = (*x)[i] > (*max)[i] ? (*x)[i] : (*max)[i];
}

/* Creates the propagator, which computes the states after steps first + 1, … of a linear scene
 * without evaluating forces (propagate.c). */
/* Returns NULL if out of memory or if a step fails. */
struct propagator *propagator_create(const struct run *run, double h);
double propagator_step(const struct propagator *propagator); /* [s] the h it is made for */
/* All of its state that does not follow from the scene and the method. */
struct propagator_place {
    double h;         /* [s] */
    double anchor[2]; /* state at the beginning of its block */
    int64_t anchored; /* step of the grid at the anchor; -1 if there is none */
};

struct propagator_place propagator_place(const struct propagator *propagator);
void propagator_set_place(struct propagator *propagator, const struct propagator_place *place);
/* The step of the grid where the block of `step` begins, whether its state is known, and that
 * state. */
int64_t propagator_block(int64_t step);
int64_t propagator_rest(int64_t step); /* steps from there to its end */
bool propagator_knows(const struct propagator *propagator, int64_t step);
void propagator_anchor(struct propagator *propagator, int64_t step, const double *y);
/* Computes up to `count` states after step `first` of the grid. On entry y [2] is the state after
 * that step, on return the last state. Returns the number of rows written: fewer if the block of
 * step `first` was begun by something else. */
int64_t propagator_advance(struct propagator *propagator, int64_t first, int64_t count, double *y,
                           double *row);
/* Returns true if the rows of the last call are certainly within bounds, without looking at
 * each. */
bool propagator_within(const struct propagator *propagator, const double *bound);

/* Takes up to p->batch whole steps at once (many.c), if nothing has to be looked at between them.
 * Returns false if single steps are needed. */
bool advance_many(struct run *run, const struct segment *segment, enum stop *stop);
enum stop stop_of_step(enum step_status status);
/* Returns the time [s] that a step to t has reached: `end` if they differ by rounding only, else
 * t. */
double run_arrival(double t, double end);
/* Copies the part of a controller that a system of this size uses. */
void controller_copy(struct controller *target, const struct controller *source,
                     const struct system *system);
/* all finite, and not what counts as diverged */
bool run_in_bounds(const struct run *run, const double *y);

/* ---- stiffness.c ---- */

/* Returns the k-th of `count` rows that are spread over those from `first` on; the last is the last
 * row of the run. */
size_t run_spread_row(const struct run *run, size_t first, size_t k, size_t count);
/* Returns the integral of the Jacobian's spectral radius over the run, from some of its rows. */
double run_stiffness(const struct run *run);

void opinion_forget(struct run *run); /* it starts anew */
/* Returns what the opinion measures errors of variable i by, or infinity where it does not know the
 * present state. */
double opinion_size(const struct run *run, int i);
/* Returns how many rows of a run a brief opinion compares with the closed form: what takes a share
 * of its work. */
size_t opinion_brief_rows(const struct system *system, const struct method *method, double evals);
/*
 * Handle variables that came to rest within their tolerance (regrowth.c), so that neither of the
 * solutions of the opinion knows them. The first returns true if they may have grown again since
 * then, at a small share of the run's work; the second follows what becomes of errors of that size:
 * opinion.sunk and lost.
 */
bool regrowth_is_likely(struct run *run);
void regrowth_look(struct run *run, const struct cancel *cancel);

/* Returns the memory of one more epoch (run.c), whose system and plan come into force; NULL if out
 * of memory. */
struct epoch *run_push_epoch(struct run *run);
void run_use_epoch(struct run *run);

/* The epoch that led to the state at `step`: where one ends, the state still belongs to it. */
const struct epoch *run_epoch(const struct run *run, int64_t step);

/* Visits the rows of a run in order, or its present state, with what an observable needs beside the
 * state. */
struct walk {
    const struct run *run;
    unsigned needs;
    size_t next, done_begin, done_end; /* rows from - to are in `done` */
    struct balance balance;
    struct work_done done;
    double state[LIMIT_VARIABLES], exact[LIMIT_VARIABLES];
    /* table of the exact solution in the epoch; NULL if it does not exist yet or is of no use */
    struct exact_table *table;
    const struct epoch *epoch; /* epoch that it was requested for; NULL if there is none yet */
    struct sample sample;
};

void walk_begin(struct walk *walk, const struct run *run, unsigned needs);
/* Returns false after the last row, when nothing is held any longer. A caller that stops before
 * that has to call walk_leave(). */
bool walk_next(struct walk *walk);
void walk_leave(struct walk *walk);
void walk_present(struct walk *walk, const struct run *run, unsigned needs);

/* Returns true if fixed steps of the scene are powers of a matrix (plan.c). */
bool plan_propagates(const struct system *system, const struct method *method,
                     const struct run_settings *settings, bool adaptive);

/* ---- ledger.c ---- */

double system_energy(const struct system *system, const double *y); /* [J] */
bool ledger_known(const struct run *run); /* the trace has each step, or marks */
bool ledger_waits(const struct run *run); /* nothing is kept before somebody asks */
/* Takes the steps again where rows are apart and have no marks yet. Returns ledger_known(). */
bool ledger_demand(const struct run *run);
/* The steps to come do not follow from the run's scene, grids and number of steps. */
void ledger_will_not_repeat(struct run *run);
/* starts at the first state */
void balance_begin(const struct run *run, struct balance *balance);
/*
 * Extends the balance over at most `count` steps whose states follow in `row`, and adaptive ones'
 * times in `time`, each `stride` on. Returns the number of steps taken, at least 1: none of them
 * crosses a change of the scene or of the grid. With `marking`, rows of the trace among them get
 * their marks.
 */
int balance_block(const struct run *run, struct balance *balance, const double *row,
                  const double *time, size_t stride, int64_t count, struct work_done *done,
                  bool marking);
/* The balance at the present state, even inside of a step. Returns false, and an unknown work, if
 * Ctrl-C came first. */
bool balance_present(const struct run *run, struct balance *balance);
/* Returns true if the next row is one with which the trace leaves some out: the balance has to be
 * kept from there on. */
bool ledger_is_due(const struct run *run);
/* Does a part of the thinning that is due, at most some 20 ms; and all of it. Both return false if
 * out of memory. */
bool ledger_thin(struct run *run);
bool ledger_ready(struct run *run);
void ledger_forget_thinning(struct run_private *p);
/* Returns true if all steps are in the balance because it was asked for; and puts new ones into
 * it. */
bool ledger_is_asked(const struct run *run);
void ledger_follow(const struct run *run);
/* Called after steps to these states were offered to the trace, whose marks it sets. */
void ledger_take(struct run *run, const double *row, const double *time, size_t stride,
                 int64_t count);
/* the last row is this state, inside of the next step */
void ledger_inside(struct run *run, double t, const double *y);
void ledger_back(struct run *run); /* the run went back to a recorded row, the last one */
void ledger_rescale(struct run *run, double factor); /* run_private.factor becomes this */
