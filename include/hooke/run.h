/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run: the integration of one scene by one method: the plan, the steps, the recorded rows (trace),
 * events, the reason of a stop, and the estimate of the error (opinion).
 *
 * run_create() makes a run at its start, run_advance() takes steps until a target, trace_…() read
 * the rows, run_destroy() frees it. A run owns its trace and its work memory, and is used by one
 * thread at a time. Observables, errors and the energy balance are in <hooke/run/observable.h>.
 */
#pragma once

#include <hooke/method.h>
#include <hooke/run/record.h>

struct cancel;
struct catalog;

/*
 * ---- trace: the rows that were recorded ----
 *
 * A row is a state of n values with its time. The last row is always the current state, even if it
 * is not recorded. With fixed steps the times are t0 + i dt and are not stored. A trace with
 * RECORD_AUTO is decimated if it has too many rows: its rows form buckets, and two neighbouring
 * buckets are merged into one, which keeps the first row and those with the smallest and largest
 * position, so that no peak is lost; the step index of each row is then stored. Pointers into the
 * trace are valid until the run changes.
 */

struct trace;

/* Returns the number of rows, at least 1. */
size_t trace_count(const struct trace *trace);
double trace_time(const struct trace *trace, size_t i); /* Returns the time [s] of row i. */
/* Returns the index of the first row whose time is at or after t [s] in the direction of the run,
 * which may go backwards in time; the number of rows if there is none. */
size_t trace_row_at(const struct trace *trace, double t);
/* Returns the number of steps before row i. */
int64_t trace_step(const struct trace *trace, size_t i);
/* Returns the state [n] of row i; owned by the trace. */
const double *trace_state(const struct trace *trace, size_t i);
/* Returns true if rows were dropped by decimation. */
bool trace_decimated(const struct trace *trace);
size_t trace_bytes(const struct trace *trace); /* Returns the memory [byte] that the trace uses. */

/* ---- settings and the plan ---- */

/* Ways to compute fixed steps, the fastest first. The propagator multiplies the state by powers of
 * the method's one-step matrix, without evaluating forces; it needs a linear scene of two variables
 * without a drive. A specialised kernel is code for one method and kind of scene. The general way
 * works for all and gives the same bits as a kernel; states of the propagator differ from these by
 * a few eps per step. */
enum kernel { KERNEL_PROPAGATOR, KERNEL_SPECIALISED, KERNEL_GENERAL };

/* Names of the ways, struct row at the index of the enum: propagator, specialised, general. */
extern const struct catalog kernel_catalog;

/* Settings of a run, copied when it is created. */
struct run_settings {
    double dt; /* [s] Fixed step, or first guess of an adaptive method; larger than 0. */
    /* Relative tolerance of adaptive steps; 0 for fixed steps. Ignored if the method has no
     * adaptive steps. */
    double tol;
    enum drag drag;     /* Variant of drag. */
    enum kernel kernel; /* Fastest way of computing steps that is allowed. */
    /* Fixed steps use compensated sums (Kahan 1965): rounding errors of the state are carried
     * along. */
    bool compensated;
    struct recording_rule record; /* Rule by which steps are recorded as rows. */
    /* The caller does not need the energy balance, so that it may be left out if there is more than
     * one step between recorded rows. */
    bool unbalanced;
    size_t memory; /* [byte] budget of the trace; 0 stands for 1 GiB */
};

/* Plan of a run: which computations it needs, and predictions of its size and duration. */
struct plan {
    /* Steps are chosen by the tolerance. */
    bool adaptive;
    bool propagates;  /* Steps are powers of the one-step matrix; no forces are evaluated. */
    bool exact_known; /* The exact solution of the scene is known. */
    bool ledger;      /* The work of drag and drive is summed for the energy balance. */
    double steps;     /* Predicted number of steps, NAN if adaptive. */
    double bytes;     /* Predicted size [byte] of the trace. */
    double seconds;   /* Predicted wall time [s]. */
    /* Predicted amplitude growth per step of the linear oscillator, NAN if the scene is not linear.
     */
    double growth;
    /* Largest stable dt [s], computed only if growth > 1, else NAN. */
    double limit;
    int64_t whole;  /* Number of steps of length dt in the span. */
    double partial; /* Length [s] of the last, shorter step, or 0. */
    bool exact_end; /* The span is a whole number of steps; `partial` is 0. */
};

/* Makes the plan of a run over `span` [s], which may be negative (backwards in time) or infinite.
 * Returns false, with a message that gives numbers and advice, if dt, span, number of steps (2^53)
 * or memory are not possible. */
bool plan_make(const struct system *system, const struct method *method,
               const struct run_settings *settings, double span, struct plan *plan,
               struct error *error);
/* Plans fixed steps dt > 0 over a finite span, both [s]: sets only steps, whole, partial and
 * exact_end. Returns false with `error` set. */
bool plan_grid(const struct system *system, double dt, double span, struct plan *plan,
               struct error *error);
/* Returns the supremum of the stable steps [s] for the scene as a linear oscillator: HUGE_VAL if
 * all are stable, 0 if none is, NAN if it is not linear. Takes milliseconds. */
double plan_stable_limit(const struct system *system, const struct method *method, enum drag drag);
/* Appends the plan as lines for the command `plan`. */
void plan_describe(const struct scene *scene, const struct system *system,
                   const struct method *method, const struct run_settings *settings,
                   const struct plan *plan, struct buffer *text);

/* ---- runs ---- */

/* Reason why a run stopped. */
enum stop {
    STOP_NONE,      /* The run has not stopped and can continue. */
    STOP_END,       /* The run reached the requested time. */
    STOP_CONDITION, /* The condition of `until` became true. */
    STOP_DIVERGED,  /* The state is not finite, or a variable is above run_bound(). */
    STOP_CANCELLED,
    STOP_NO_SOLUTION, /* An implicit equation was not solved. */
    STOP_STALLED,     /* An adaptive step would be below the rounding of t. */
    STOP_FULL,        /* The memory budget is used up. */
    STOP_SINGULAR,    /* The exact solution ends here, see struct singularity. */
    STOP_GIVEN_UP     /* The caller stopped the run because it would take too long. */
};

/* Returns true if the run was only interrupted and can continue as it would have. */
static inline bool stop_is_pause(enum stop stop)
{
    return stop == STOP_CANCELLED || stop == STOP_GIVEN_UP;
}

/* Returns true if the run failed: no further step is possible. */
static inline bool stop_is_failure(enum stop stop)
{
    return stop == STOP_DIVERGED || stop == STOP_NO_SOLUTION || stop == STOP_STALLED ||
           stop == STOP_SINGULAR;
}

/* Returns the status in JSON: ok, diverged, cancelled, … (ok for STOP_END, STOP_CONDITION,
 * STOP_NONE). */
const char *stop_name(enum stop stop);

/* Adaptive steps shorter than this fraction of the time since the start are examined for a
 * singularity. */
#define RUN_CREEP 1e-6

/* Time at which the exact solution of an equation ends, as system_singularity() finds it. */
struct singularity {
    double t;    /* Time [s] of the end; NAN if there is none or it is unknown. */
    bool finite; /* The solution remains finite at t; only its derivative becomes infinite. */
};

/* A fixed step that was far too long: its result has little to do with the exact solution that
 * starts from the state before the step. */
struct unsound_step {
    /* Error of the step as a multiple of the variable's value; 0 if no such step was found. */
    double times;
    double t, value; /* Time [s] at the end of the step, and value of the variable then [SI]. */
    double solution; /* Value [SI] of the exact solution at that time. */
    int variable;    /* Index of the variable with the largest error. */
};

/*
 * ---- opinion: the estimated error of an adaptive run ----
 *
 * The error of a run is estimated by its distance from the closed form or, if none is known, from a
 * second solution by a method of another kind at a hundredth of the tolerance. Distances of a
 * variable are divided by its largest magnitude so far, at least its size along the run (scale of
 * struct controller), or by atol / tol if atol is given.
 */

/* A warning is given if the estimated error is above this many tolerances. */
#define OPINION_WRONG 100
/* First budget of the second solution, in evaluations (with those of Jacobians): the larger one of
 * OPINION_BUDGET divided by the number of variables, which takes some milliseconds, and the
 * fraction OPINION_SHARE of the run's own evaluations. */
#define OPINION_BUDGET 4e5
#define OPINION_SHARE 0.1
/* Second budget, which replaces the first one if the error that was found within the first budget
 * suggests that the end of the run may be wrong. OPINION_DOUBT is the fraction of the run's own
 * evaluations; OPINION_BUDGET_DOUBT takes about a tenth of a second. */
#define OPINION_DOUBT 0.45
#define OPINION_BUDGET_DOUBT 4e6

/* Estimated error of a run, as a multiple of the sizes of variables described above. It is known up
 * to time t of the run. */
struct opinion {
    /* Error at the time t, or its mean up to t if that is larger; NAN if there is no estimate. */
    double error;
    /* Largest error up to t. An error of the time at which a value jumps counts as an error of the
     * value. */
    double max;
    double t; /* [s] time up to which solutions were compared */
    /* Time [s] from which on the error is as large as the motion; NAN if there is no such time. */
    double lost;
    double work; /* Number of evaluations and Jacobians of the second solution. */
    /* [n] errors [SI] of the variables at the run's current time; if that is later than t, they are
     * extrapolated by the growth of `error`. */
    double end[LIMIT_VARIABLES];
    /* Method of the second solution, or NULL if the closed form was used. */
    const struct method *method;
    double tol; /* Tolerance of that method. */
};

/* A run. Callers read it; only its functions change it, except `number`, `name`, `cancel` and the
 * warned_… flags. */
struct run {
    int number; /* Number of the run in commands, from 1. */
    char name[LIMIT_NAME + 1];
    struct scene scene; /* The scene at the start. */
    /* The system that is integrated at present. */
    struct system system;
    const struct method *method;
    struct run_settings settings;
    struct plan plan;    /* Plan made at the start. */
    struct trace *trace; /* Recorded rows, owned. */

    int64_t steps; /* Number of steps taken. */
    double t;      /* Current time [s]. */
    /* Current state [n]. */
    double y[LIMIT_VARIABLES];
    /* Work so far. */
    struct cost cost;
    double seconds; /* Wall time [s] spent in run_advance(). */
    /* Reason of the last stop. */
    enum stop stop;
    struct singularity singular; /* Valid with STOP_SINGULAR. */
    /* The step with the largest error that run_diagnose() has found. */
    struct unsound_step unsound;
    /* Kinds of warnings about the run that users have already seen; each is given once. */
    bool warned_growth, warned_sliding, warned_piling, warned_unsound, warned_doubt, warned_error;
    bool warned_burst;
    /* First burst, a short fast change of a force (<hooke/scene/bursts.h>), that run_missed_burst()
     * found; t_begin == t_end if none. */
    struct burst missed;
    /* State of the step-size control. */
    struct controller controller;
    struct opinion opinion; /* Estimated error, filled by run_second_opinion(). */
    /* Flag that stops computations that read the run; NULL if they cannot be cancelled. */
    const struct cancel *cancel;

    struct run_private *private_state; /* Work memory, private. */
};

/* Returns the magnitude [SI] of state variable i above which a run counts as diverged. */
double run_bound(const struct system *system, int i);
/* Provides row [count][n], the states after the next `count` whole steps, which the caller has
 * computed already. A run of fixed steps uses them instead of computing the same states, and does
 * not count their evaluations. The caller owns the array and keeps it until these steps are taken.
 */
void run_give(struct run *run, const double *row, int64_t count);
/* Creates a run at its start, with one recorded row; `span` [s] is as in plan_make(). Returns NULL,
 * with `error` set, if the scene cannot be bound, the method does not apply, or out of memory. Free
 * it by run_destroy(). */
struct run *run_create(const struct scene *scene, const struct method *method,
                       const struct run_settings *settings, double span, struct error *error);
/* Frees a run with its trace and work memory; NULL is allowed. */
void run_destroy(struct run *run);

/* An event: an expression passes through 0 during the run. Each step is searched for events on the
 * method's dense output, which gives the time of an event within rounding. Bounds of the expression
 * prove that no event is missed; run_event_doubt() reports steps for which they do not. An
 * expression that is 0 at the start of a run makes no event there. An event that rounding would put
 * just behind the end of the run happens at the end. Events whose times differ only by rounding
 * happen at one time, in the order of their definition. */
struct event {
    char name[LIMIT_NAME + 1];
    /* The expression is left - right, or left alone if `right` is NULL. */
    const struct expr *left, *right;
    int direction; /* 1 for rising, -1 for falling, 0 for both */
    /* The event also happens where the expression touches 0, within the errors of the run, without
     * changing its sign. */
    bool touching;
    bool stop; /* The run stops at the event, with STOP_CONDITION. */
    /* Scope that gives observables their values at the run's current state; set by the caller. */
    const struct expr_scope *scope;
};

/* Compiles the text of an event: EXPR [rising|falling|touching], or a comparison, for an event that
 * happens where the comparison becomes true. Fills the members from `left` to `touching`, in the
 * arena, and sets *used to the length [byte] of the part of the text that was read. Returns false
 * with `error` set. */
bool event_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                   struct event *event, size_t *used, struct error *error);

/* An event that has happened. */
struct event_record {
    int event;     /* Index of the event in run_target.event. */
    int direction; /* 1 for rising, -1 for falling, 0 for touching */
    int64_t step;  /* Number of steps of the run, including the step with the event. */
    double t;      /* Time [s] of the event. */
};

/* Steps for which bounds did not prove that no event was missed, because the steps were longer than
 * the time scale of the event's expression. */
struct event_doubt {
    int64_t steps;          /* Number of such steps. */
    double t_first, t_last; /* Times [s] of the first and the last of them. */
    /* The only reason for doubt is that the expression came so near to 0 that the errors of the run
     * decide whether it reached 0. */
    bool is_close;
};

/* Returns the doubt about event number `event` of run_target.event; LIMIT_EVENTS stands for the
 * condition of the target. */
struct event_doubt run_event_doubt(const struct run *run, int event);
/* Return the number of events that have happened, record i of these, and the state [n] at the time
 * of record i. The run owns records and states. */
size_t run_event_records(const struct run *run);
const struct event_record *run_event_record(const struct run *run, size_t i);
const double *run_event_record_state(const struct run *run, size_t i);

/* The goal of run_advance(), owned by the caller. */
struct run_target {
    double t; /* Time [s] at which to stop; HUGE_VAL (-HUGE_VAL backwards) if there is no end. */
    /* Largest number of further steps, counted from this call; negative if there is no limit. */
    int64_t steps;
    /* Condition at which to stop, or NULL. The time at which it becomes true is found as that of an
     * event. A condition that is true at the start must become false first. With <= and >= it is
     * also true where both sides touch within the errors of the run. */
    const struct condition *condition;
    /* Scope of the condition, which gives observables their values at the run's current state. */
    const struct expr_scope *scope;
    const struct event *event; /* [events] events to search for. */
    int events;
};

/* Returns the time [s] since which dry friction has held the body at rest, according to the
 * recorded rows, or NAN if it is not at rest. */
double run_rest(const struct run *run);
/* Advances the run until the target, another reason to stop, cancellation, or the end of budget_ns
 * [ns of wall time], where 0 means no limit. Returns true while there is more to do. The rows do
 * not depend on how the work is divided into calls. Fixed steps lie on the grid t0 + i dt. The last
 * step before the target or the condition may be shorter, which does not change settings.dt; the
 * next call then begins a new grid at the current time, as after a change of direction.
 * A failed step, or one that cannot be recorded (STOP_FULL), leaves the state before it, bit for
 * bit; calling again tries it again. */
bool run_advance(struct run *run, const struct run_target *target, int64_t budget_ns,
                 const struct cancel *cancel);
/* Sets a run of fixed steps to the state y [n], which the caller has computed, after `steps` steps
 * from t0. Recorded rows remain as they are. The next step of the method starts without values of
 * earlier steps. */
void run_place(struct run *run, int64_t steps, const double *y);
/* Goes back by `rows` recorded rows and drops the later ones, without integrating. If there are
 * fewer rows, goes back to the start and returns false. Restores time, state and the parameters
 * then in force, but not the memory of a multistep method or of step control, which start again;
 * and a propagator cannot restart inside a bucket of a decimated trace. A row inside a step
 * (RECORD_TIMES) becomes the end of that step. */
bool run_back(struct run *run, int64_t rows);
/* Changes parameters during the run: uses those of `scene` from the current step on; y0, v0 and t0
 * have no effect. The grid of times remains, the exact solution is continued from its own value,
 * and the change of energy counts as work. Returns false, with `error` set and the run unchanged,
 * if that fails. */
bool run_rebind(struct run *run, const struct scene *scene, struct error *error);
/* Returns the system that was in force on the step to a row; owned by the run. */
const struct system *run_system_to(const struct run *run, size_t row);
/* Undoes the last run_rebind() if no step was taken since, so that the run has its previous
 * parameters again. */
void run_unbind(struct run *run);
/* Sets variable i of the current state to a value [SI]. The jump counts as a step of length 0, so
 * that two rows have the same time. The change of energy counts as work, and the exact solution is
 * unknown from there. run_back() does not stop at the row before the jump. Returns false, with
 * `error` set and the run unchanged, if the value counts as diverged, if the method does not allow
 * it, or if out of memory.
 */
bool run_kick(struct run *run, int i, double value, struct error *error);
/* Sets slope [n + 1], the derivatives of the value that run_kick() has just set with respect to the
 * n variables before the jump and to time. A second solution needs them to estimate the error
 * beyond the jump. */
void run_set_jump_slopes(struct run *run, const double *slope);
/* Returns true if steps or rows depend on earlier steps and not on the current state alone, so that
 * the same bits can only be reached by repeating the whole run. */
bool run_remembers(const struct run *run);
/* Determines whether and how the solution through (t, y) ends before `end` [s], by at most 20000
 * steps of dop853. Allocates memory. The criterion is described in src/run/failure/follow.c. */
struct singularity system_singularity(const struct system *system, double t, const double *y,
                                      double end, const struct cancel *cancel);
/* Returns "goes to infinity" or "gets an infinite slope", to follow the words "the solution". */
const char *singularity_text(const struct singularity *singularity);
/* Determines whether the exact solution of a run ends at the time at which the run failed, or at an
 * earlier time over which the run has stepped; then sets run->stop to STOP_SINGULAR. Examines the
 * rows since the last call. */
void run_diagnose(struct run *run);
/* Appends the reason why the run stopped, as a sentence for the user, such as "diverged at t =
 * 12.31 s (step 18): dt = 0.7 s is above …; try dt <= 0.06 s". */
void run_explain(const struct run *run, struct buffer *text);
/* Limits of the work on an opinion. OPINION_BRIEF allows the fraction OPINION_BRIEF_SHARE of the
 * run's own work; it is the same as OPINION_DEMANDED if a variable with an atol is small compared
 * with its largest values. OPINION_DEMANDED allows the first budget above. OPINION_WHOLE
 * continues to the end of the run. The second budget is used by OPINION_BRIEF if the error so far
 * suggests that no digit is correct at the end, and by OPINION_DEMANDED if the error there may
 * exceed OPINION_WRONG. */
enum opinion_effort { OPINION_BRIEF, OPINION_DEMANDED, OPINION_WHOLE };

/* Computes run->opinion of an adaptive run up to its current state, or as far as the effort allows;
 * nothing else of the run changes. Compares at most 256 recorded states per call. */
void run_second_opinion(struct run *run, enum opinion_effort effort, const struct cancel *cancel);
/* Returns true if there is an opinion that can be trusted: nothing is known that both solutions may
 * have missed, such as a burst, or the two solutions differ by much anyway. */
bool run_opinion_known(const struct run *run);
/* Sets magnitude_floor [n] to the magnitude [SI] below which a variable of an adaptive run has no
 * correct digit, for variables that are that small now; it follows from the error that the run
 * allows or that its opinion states. Variables that only pass through 0, and all others, get 0.
 * Returns the number of variables whose floor is not 0. */
int run_below_tolerance(const struct run *run, double *magnitude_floor);
/* Searches the rows since the last call for a burst between the points at which steps evaluated the
 * forces. Returns true with *missed set to the first one, or false if there is none or if not all
 * steps were recorded. */
bool run_missed_burst(struct run *run, struct burst *missed);

#include <hooke/run/observable.h>
