/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the files of this layer: the private part of struct run, and the functions
 * of each file that others here call. run_create() allocates struct run_private, run_advance()
 * fills it, run_destroy() frees it. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/base/numeric.h>
#include <hooke/run.h>
#include <string.h>

#include "run/failure/failure.h"
#include "run/saltation.h"
#include "run/trace.h"

struct cancel;

/* Copies a state of n numbers. It is called once or twice in each step; most scenes have two
 * variables, for which the call of memcpy() takes longer than the copy. */
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

/* A part of a run in which the scene does not change: one begins at the start, one more with each
 * run_rebind(). */
struct epoch {
    int64_t first; /* step index of its start */
    double t;      /* [s] time of its start */
    /* State at which the exact solution of this epoch starts: the value of the exact solution at
     * the end of the epoch before. */
    double start[LIMIT_VARIABLES];
    struct system system; /* the scene with its parameters bound */
    struct plan plan;
    enum drag drag;          /* drag variant of the method for this system */
    double value[PARAM_MAX]; /* values of the scene's parameters in SI */
};

/* The energy balance of a run up to one of its states. balance_begin() sets it to the start,
 * balance_block() carries it over the steps that follow. */
struct balance {
    int64_t step;              /* step up to which the balance goes */
    double t;                  /* [s] time of that step; with fixed steps that of the grid */
    double y[LIMIT_VARIABLES]; /* [n] state after that step */
    double initial;            /* energy at the start, in units of factor^2 J */
    int solved;                /* steps whose work was found by solving the equations anew */
    struct energy_tally tally; /* the work and the largest error up to that step */
};

/* ---- work between states one step apart (work.c) ---- */

#define WORK_BLOCK 128 /* largest number of steps of one call; a power of 2 */

/* Cosine and sine of k omega h for k = 0, 1, …: a table of the drive at times h apart. */
struct turns {
    double omega, h; /* [rad/s], [s] for which the table was made */
    double cosine[WORK_BLOCK + 1], sine[WORK_BLOCK + 1];
};

/* Input of work_between(): `count` steps under one system, from the state `initial_state`; row k is
 * the state after step k. */
struct work {
    const struct system *system;
    double factor; /* all states are multiplied by it before energies are computed */
    int count;     /* 1 … WORK_BLOCK */
    const double *initial_state, *row;
    size_t stride; /* numbers from one row to the next */
    /* Times [count + 1] of the states; NULL if they are at origin + (index + k) h, in one block of
     * the index. */
    const double *t;
    double origin, h; /* [s] */
    int64_t index;
    struct turns *turns;
};

/* Output of work_between(), in units of factor^2 J. */
struct work_done {
    /* work in each step; drag is the part of it that drag did */
    double work[WORK_BLOCK], drag[WORK_BLOCK];
    double energy[WORK_BLOCK]; /* energy after each step */
    /* The work is the integral of the power along a quintic polynomial between the states.
     * `jumps` marks steps for which that is wrong, because the force jumps inside the step or at
     * one of its ends; `coarse` marks steps for which it may be inaccurate, because the
     * acceleration changes much. The arrays are valid only if any_jumps or any_coarse is true. */
    bool jumps[WORK_BLOCK], coarse[WORK_BLOCK];
    bool any_jumps, any_coarse;
    /* totals since the start, set by balance_block() */
    double all_work[WORK_BLOCK], all_drag[WORK_BLOCK];
};

/* Computes the energy after each step and the work of drag and drive in it. The balance adds them
 * up. */
void work_between(const struct work *work, struct work_done *done);

/* A change of the state from outside, by run_kick(): a step of no length. */
struct kick {
    int64_t step;  /* step index of the state after the change */
    double t;      /* [s] */
    double energy; /* [J] change of the energy of the state */
};

/* Events that have happened in a run, with the states at them, in order of time. */
struct event_records {
    struct event_record *record;
    double *state; /* [count][n] */
    size_t count, capacity;
};

struct run_private {
    struct step step; /* input and output of the method's next step */
    double *work;     /* memory of the method */
    /* Memory of the method for the steps of inside_state(); NULL if states inside of a step are
     * found by interpolation. */
    double *side;
    /* [n] difference of the state after the last step of a multistep method from the state after
     * the same step without memory (inside.c); valid if gap_known */
    double *gap;
    bool gap_known;
    double *previous_state; /* [n] state before the last step */
    double *low_before;     /* [n] step.low before the last step; unused if that is NULL */
    double *bound;          /* [n] magnitudes above which the run has diverged */
    struct epoch *epoch;    /* [epochs] at least one; the last one is in force */
    size_t epochs, epoch_capacity;
    int64_t batch;          /* steps between two looks at the clock and at Ctrl-C */
    int64_t look;           /* step at which run_creeps() looks next */
    size_t looked;          /* rows that run_diagnose() has examined */
    size_t checks;          /* strange steps that it found among them */
    size_t searched;        /* last row that run_missed_burst() has examined */
    double probed;          /* [s] run_force_unresolved() has looked for pulses up to there */
    march_function *kernel; /* NULL if this method and system have none */
    struct propagator *propagator; /* NULL if it has not been made or the scene has none */
    /* States [CHUNK_ROWS][n] that do not go into the trace unchanged; NULL until they are
     * needed. */
    double *scratch;
    double *work_before; /* copy of `work` before a batch of steps; NULL if there was no batch */
    /* States [n] each after the steps given_first + 1 … given_end, which run_give() provided. */
    const double *given;
    int64_t given_first, given_end;
    double factor; /* power of two by which states are multiplied before energies are computed */
    /* Run whose steps this one repeats for its energy balance (ledger.c); else NULL. */
    const struct run *original;
    /* The steps cannot be repeated from the scene and the settings alone: a condition or an event
     * may have ended a step early, or the step-size control began anew. */
    bool is_unrepeatable;
    /* Energy balance: up to the last step if rows have marks, else up to the last step for which
     * the balance was requested. */
    struct balance balance;
    struct thinning *thinning; /* see ledger.c; NULL if none has begun */
    /* [saves] tallies after each CHUNK_ROWS steps, from which the balance continues when the run
     * goes back; used if rows have no marks */
    struct energy_tally *saved;
    size_t saves, save_capacity;
    struct turns turns; /* table of work_between() */
    struct event_records event_records;
    struct second *second;     /* see opinion.c; NULL if no second solution has begun */
    struct event_watch *watch; /* see watch.h; NULL if there are no events */
    struct event_doubt doubt[LIMIT_EVENTS + 1]; /* the last is that of the condition */
    struct kick *kick;                          /* [kicks] in order of steps */
    size_t kicks, kick_capacity;
    struct responses responses; /* see saltation.h */
    enum solution_fate fate;    /* set by run_diagnose() */
    double sunk;                /* result of run_opinion_sunk() */
    /* evaluations and Jacobians of the solutions that regrowth_look() followed */
    double regrowth_work;
};

/* Clears the rounding errors that compensated sums carry along, after the state was changed by
 * something else than a step. */
static inline void forget_rounding(struct run_private *p, int n)
{
    if (p->step.low)
        memset(p->step.low, 0, (size_t)n * sizeof *p->step.low);
}

/* Target and grid of one call of run_advance(). */
struct segment {
    const struct run_target *target;
    struct time_grid grid;   /* grid of fixed steps; unused if the run is adaptive */
    int64_t last;            /* step index at which the whole fixed steps end */
    double rest;             /* [s] signed partial step after it; 0 if there is none */
    bool exact;              /* the whole fixed steps end at the target's time */
    int64_t limit;           /* step index at which the call ends in any case */
    bool rows_between_steps; /* rows are due at times at which no step ends */
    bool armed;              /* the condition was false since it was last true, so that it counts */
};

/* ---- rows at even times, if trace->interval is set (even.c) ---- */

/* Sets the time of the next row to the first one after t [s] in the direction of h. */
void trace_aim(struct trace *trace, double t, double h);
/* Returns true if steps of the present grid end at all times at which rows are due. Then every
 * trace->every-th step is recorded, from step trace->next on. */
bool trace_in_step(struct trace *trace);
/* Does the work of trace_record_many() for rows at even times, if trace_in_step(). */
int64_t trace_record_even(struct trace *trace, int64_t step, const double *row, int64_t count);
/*
 * Records the rows that are due in the step just taken from previous_state at t over h; the run is
 * at the end of the step. `cold` is that of inside_of(). Returns STOP_NONE, STOP_FULL also if out
 * of memory, or STOP_DIVERGED if a state inside of the step is out of bounds although that at its
 * end is not.
 */
enum stop even_record(struct run *run, bool cold, double t, double h);
/* Drops the rows after time t [s], but never the first one. */
void even_drop(struct trace *trace, double t);
/* Returns true if row_time [s], that of the last row, is the present time but for rounding. */
bool even_present(const struct trace *trace, double row_time);

/* ---- states inside of the last step (inside.c) ---- */

/* Describes the step just taken, from previous_state at t over h, for inside_state(). */
struct inside {
    struct run *run; /* stands at the end of the step */
    /* Copy of the method, without its dense output if that would cover only a part of the step. */
    struct method method;
    double t, h; /* [s] */
};

/* Describes the last step of the run; `cold` means that it was taken by method_turning_step(),
 * perhaps in parts. */
struct inside inside_of(struct run *run, bool cold, double t, double h);
/* Returns the input of the last step, with the system that it was made with: that of the run, or
 * one whose switches were frozen, which is written to *frozen. The caller frees *sliding. */
struct step inside_step(const struct inside *inside, struct sliding *sliding,
                        struct system *frozen);
/* Computes the state y [n] at the fraction theta of the step, 0 to 1: by a shorter step of the
 * method if the run has p->side, else by dense output. */
void inside_state(const struct inside *inside, double theta, double *y);

/* ---- events (event.c, records.c) ----
 *
 * events_begin() once for each call of run_advance(); after each step events_find(), then
 * events_until() and events_until_at() for the condition, then events_keep().
 */

/* Compiles the target's events for the present system of the run, with signs at its present state.
 * Returns false if out of memory. */
bool events_begin(struct run *run, const struct segment *segment);
/* Marks the sizes of the variables as unknown, because the run went back or has states that were
 * not watched; events_begin() finds them anew. */
void events_forget_sizes(struct run *run);
/* Finds the events in the step just taken from previous_state at t over h, with their states.
 * Returns false if out of memory. */
bool events_find(struct run *run, const struct segment *segment, double t, double h);
/* Records the events found in the step up to the present time. If one of them stops the run, puts
 * the run there and sets *stops. Returns false if out of memory or if no more can be recorded. */
bool events_keep(struct run *run, const struct segment *segment, double h, bool *stops);
/* Returns true if the condition became true in the step, and not after another event that stops the
 * run. *theta is then the first such fraction of the step. */
bool events_until(const struct run *run, double *theta);
/* Returns true if an event of the step stops the run; the condition counts as one. */
bool events_stop(const struct run *run);
/* Gives the events at the fraction theta of the step the run's present time and state, which were
 * located more accurately. */
void events_until_at(struct run *run, double theta);
/* Drops the records after the present step, and those of that step which are after the present time
 * in the direction of `ahead` [s]; 0 keeps all of them. */
void event_records_truncate(struct run *run, double ahead);

#define ALWAYS_INLINE static inline __attribute__((always_inline))

/* ---- vectors of four numbers ----
 *
 * Four fit the registers of most processors; compilers translate wider vectors badly if there are
 * no registers for them.
 */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));
typedef uint64_t four_bits __attribute__((vector_size(32), aligned(8), may_alias));
#define VECTOR_LANES 4
/* Replaces each of the four numbers *max by that of *x if that is larger. */
ALWAYS_INLINE void four_raise(four *max, const four *x)
{
    for (int i = 0; i < VECTOR_LANES; i++)
        (*max)[i] = (*x)[i] > (*max)[i] ? (*x)[i] : (*max)[i];
}

/* ---- the propagator of a linear scene (propagate.c) ----
 *
 * It computes states by powers of the matrix of one step, without evaluating forces. Steps of the
 * grid form blocks of equal length, so that the states do not depend on how a run is cut into
 * calls: those inside of a block are computed from the state at its beginning, the anchor.
 */

/* Returns the propagator of the run's scene and method for steps of h [s], which the caller frees
 * with free(), or NULL if out of memory or if a step fails. */
struct propagator *propagator_create(const struct run *run, double h);
/* Returns the step [s] that the propagator was made for. */
double propagator_step(const struct propagator *propagator);
/* The state of a propagator that does not follow from the scene and the method. */
struct propagator_place {
    double h;         /* [s] */
    double anchor[2]; /* state at the beginning of its block */
    int64_t anchored; /* step of the grid at the anchor; -1 if there is none */
};

/* Return and set the anchor, to store a run and restore it. */
struct propagator_place propagator_place(const struct propagator *propagator);
void propagator_set_place(struct propagator *propagator, const struct propagator_place *place);
/* Returns the step of the grid at which the block of `step` begins. */
int64_t propagator_block(int64_t step);
/* Returns the number of steps from `step` to the end of its block. */
int64_t propagator_rest(int64_t step);
/* Returns true if the steps after `step` can be computed: the anchor is that of its block, or a
 * block begins there. */
bool propagator_knows(const struct propagator *propagator, int64_t step);
/* Makes y [2] after `step`, the first one of a block, the anchor. */
void propagator_anchor(struct propagator *propagator, int64_t step, const double *y);
/* Computes up to `count` states after step `first` of the grid. On entry y [2] is the state after
 * that step, on return the last state. Returns the number of rows written: fewer if the anchor of
 * the block of step `first` is unknown. */
int64_t propagator_advance(struct propagator *propagator, int64_t first, int64_t count, double *y,
                           double *row);
/* Returns true if the rows of the last call are certainly within bounds, without looking at
 * each. */
bool propagator_within(const struct propagator *propagator, const double *bound);

/* Makes up to p->batch whole steps at once (many.c), if nothing has to be looked at between them,
 * and records them. Returns false if single steps are needed; else sets *stop, STOP_NONE if the run
 * can continue. */
bool advance_many(struct run *run, const struct segment *segment, enum stop *stop);
/* Returns the reason for which a run stops after a step of that status; STOP_NONE for STEP_OK. */
enum stop stop_of_step(enum step_status status);
/* Returns the time [s] that a step to t has reached: `end` if they differ by rounding only, else
 * t. */
double run_arrival(double t, double end);
/* Copies the part of a controller that a system of this size uses. */
void controller_copy(struct controller *target, const struct controller *source,
                     const struct system *system);
/* Returns true if all variables of y are finite and below the bounds above which a run diverges. */
bool run_in_bounds(const struct run *run, const double *y);

/* ---- errors of adaptive runs (stiffness.c, opinion.c, regrowth.c) ---- */

/* Returns the k-th of `count` rows that are spread evenly over those from `first` on; the last is
 * the last row of the run. */
size_t run_spread_row(const struct run *run, size_t first, size_t k, size_t count);
/* Returns the integral over time of the Jacobian's spectral radius along the run, estimated from
 * some of its rows. */
double run_stiffness(const struct run *run);

/* Discards the opinion and the second solution, so that the next opinion starts anew. */
void opinion_forget(struct run *run);
/* Returns the size by which the opinion divides errors of variable i, or infinity if it does not
 * know the present state. */
double opinion_size(const struct run *run, int i);
/* Returns how many rows a brief opinion compares with the closed form: as many as take a fixed
 * share of the work of a run with `evals` evaluations. */
size_t opinion_brief_rows(const struct system *system, const struct method *method, double evals);
/*
 * Handle variables that came to rest within their tolerance, so that neither the run nor the second
 * solution knows their true values (regrowth.c). The first returns true if such values may have
 * grown again since then; it takes a small share of the run's work. The second follows errors of
 * that size along the run and corrects run->opinion and the result of run_opinion_sunk().
 */
bool regrowth_is_likely(struct run *run);
void regrowth_look(struct run *run, const struct cancel *cancel);

/* ---- epochs (run.c) ---- */

/* Appends an epoch, which the caller fills, and returns it, or NULL if out of memory. */
struct epoch *run_push_epoch(struct run *run);
/* Puts the system and the plan of the last epoch into force. */
void run_use_epoch(struct run *run);

/* Returns the epoch whose equations led to the state after `step`. The state at the end of an epoch
 * belongs to that one, not to the next. */
const struct epoch *run_epoch(const struct run *run, int64_t step);

/* ---- samples of observables (walk.c) ---- */

/* Visits the rows of a run in order, or its present state, and makes of each the sample that an
 * observable is computed from. */
struct walk {
    const struct run *run;
    unsigned needs;              /* bits of enum observable_need: what the samples contain */
    size_t next;                 /* row of the next walk_next() */
    struct balance balance;      /* energy balance up to row done_end - 1 */
    size_t done_begin, done_end; /* rows done_begin … done_end - 1 are in `done` */
    struct work_done done;
    double state[LIMIT_VARIABLES]; /* state of the row times run_private.factor */
    double exact[LIMIT_VARIABLES]; /* exact solution at its time */
    /* table of the exact solution in `epoch`; NULL if it does not exist yet or is of no use */
    struct exact_table *table;
    const struct epoch *epoch; /* epoch for which `table` was requested; NULL at first */
    struct sample sample;      /* the result of walk_next() and walk_present() */
};

/* Begins a walk over all rows, for samples with these needs. */
void walk_begin(struct walk *walk, const struct run *run, unsigned needs);
/* Sets walk->sample to the next row. Returns false after the last one, and frees the memory of the
 * walk. A caller that stops earlier has to call walk_leave(). */
bool walk_next(struct walk *walk);
void walk_leave(struct walk *walk);
/* Sets walk->sample to the present state of the run, without walk_begin(). Nothing has to be
 * freed. */
void walk_present(struct walk *walk, const struct run *run, unsigned needs);

/* Returns true if fixed steps of the scene are powers of a matrix (plan.c). */
bool plan_propagates(const struct system *system, const struct method *method,
                     const struct run_settings *settings, bool adaptive);

/* ---- the energy balance (energy/ledger.c, energy/balance.c) ----
 *
 * A mark is the balance at a recorded row, kept with the row. A trace with each step needs none,
 * because the balance can be computed from its rows.
 */

/* Returns the kinetic and potential energy [J] of a state. */
double system_energy(const struct system *system, const double *y);
/* Returns true if the balance is available: the trace has each step, or its rows have marks. */
bool ledger_known(const struct run *run);
/* Returns true if nothing of the balance is computed until it is requested. */
bool ledger_waits(const struct run *run);
/* Makes the balance available: repeats the steps of the run if its rows are more than a step apart
 * and have no marks. Returns ledger_known(). */
bool ledger_demand(const struct run *run);
/* Prepares for steps that could not be repeated from the run's scene, grids and number of steps:
 * computes the marks up to the present state first. */
void ledger_will_not_repeat(struct run *run);
/* Sets the balance to the first state of the run. */
void balance_begin(const struct run *run, struct balance *balance);
/*
 * Extends the balance over at most `count` steps. Their states follow each other in `row`, `stride`
 * numbers apart, and so do the times of adaptive steps in `time`, which is NULL for fixed ones.
 * Returns the number of steps taken, at least 1; it ends at a change of the scene or of the grid.
 * `marking` sets the marks of rows of the trace among these steps.
 */
int balance_block(const struct run *run, struct balance *balance, const double *row,
                  const double *time, size_t stride, int64_t count, struct work_done *done,
                  bool marking);
/* Computes the balance at the present state, also if that is inside of a step. Returns false, with
 * NAN as the work, if Ctrl-C came first. */
bool balance_present(const struct run *run, struct balance *balance);
/* Returns true if the trace has each step, is full, and will leave out rows when the next one is
 * recorded: their marks have to be computed first, by ledger_thin(). */
bool ledger_is_due(const struct run *run);
/* Do a part of the thinning that is due, which takes at most some 20 ms, and all of it. Both return
 * false if out of memory. */
bool ledger_thin(struct run *run);
bool ledger_ready(struct run *run);
/* Drops a thinning that has begun. */
void ledger_forget_thinning(struct run_private *p);
/* Returns true if the balance was requested up to the last step, so that it will be again. */
bool ledger_is_asked(const struct run *run);
/* Extends the balance to the steps that are new in the trace. */
void ledger_follow(const struct run *run);
/* Extends the balance over `count` steps that the run has just made, and sets the marks of rows
 * among them; does nothing if rows have no marks. The arguments are those of balance_block(). */
void ledger_take(struct run *run, const double *row, const double *time, size_t stride,
                 int64_t count);
/* Sets the mark of the last row, which is the state y at t [s] inside of the last step. */
void ledger_inside(struct run *run, double t, const double *y);
/* Takes the balance back to the last recorded row, where the run is. */
void ledger_back(struct run *run);
/* Sets run_private.factor, and converts all sums and marks to its units. */
void ledger_rescale(struct run *run, double factor);
