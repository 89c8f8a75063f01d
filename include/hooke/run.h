/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * run: the plan (what this scene really needs), advancing, the trace, observables, the energy
 * ledger, stop reasons.
 */
#pragma once

#include <hooke/method.h>
#include <hooke/run/record.h>

struct cancel;
struct catalog;

/* ---- trace: what was recorded ----
 *
 * Rows of n state values in chunks; the last row is always the present state, recorded or not. With
 * a fixed step the time is t0 + i dt and not stored. Above the cap the trace is decimated
 * (RECORD_AUTO, whose rows then carry their step index): pairs of buckets merge, keeping of each
 * the first sample and the samples of smallest and largest position, so that no peak is lost.
 * Pointers hold until the run moves.
 */

struct trace;

size_t trace_count(const struct trace *trace);
double trace_time(const struct trace *trace, size_t i); /* [s] */
/* The first row whose time is at or after t [s] on the way of the run, which may go backwards. */
size_t trace_row_at(const struct trace *trace, double t);
int64_t trace_step(const struct trace *trace, size_t i);        /* step index of the row */
const double *trace_state(const struct trace *trace, size_t i); /* [n] */
bool trace_decimated(const struct trace *trace);
size_t trace_bytes(const struct trace *trace); /* memory held */

/* ---- settings and the plan ---- */

/*
 * Ways to compute fixed steps. A propagator (linear scene of two variables, no drive) multiplies by
 * powers of the method's one-step matrix: no forces are evaluated, and the states differ from the
 * others' by a few eps a step. The other two give the same bits.
 */
enum kernel { KERNEL_PROPAGATOR, KERNEL_SPECIALISED, KERNEL_GENERAL };

/* struct row at the enum's place: propagator, specialised, general */
extern const struct catalog kernel_catalog;

struct run_settings {
    double dt; /* [s] positive; fixed step, or first guess of an adaptive method */
    /* Tolerance of adaptive steps, if the method has them; 0 asks for fixed steps. */
    double tol;
    enum drag drag;
    enum kernel kernel; /* the fastest way that is allowed */
    /* fixed steps: what rounding takes from the state is carried along (Kahan 1965) */
    bool compensated;
    struct recording_rule record;
    /* nobody will ask for the work of a run whose rows are more than a step apart: it is not
     * kept */
    bool unbalanced;
    size_t memory; /* [byte] budget for the trace, 0: 1 GiB */
};

/* Everything that will be computed for a scene and a method, and everything that is left out, as
 * lines for `plan` (filled by plan_describe). */
struct plan {
    bool adaptive;
    bool propagates;  /* no forces are evaluated: powers of the one-step matrix */
    bool exact_known; /* error against the closed form is available */
    bool ledger;      /* energy balance needs the work of drag and drive */
    double steps;     /* predicted, NaN if adaptive */
    double bytes;     /* predicted size of the trace */
    double seconds;   /* predicted run time */
    /* predicted amplitude growth a step of the linear oscillator, NaN if not linear */
    double growth;
    /* [s] largest stable dt, looked for only if growth > 1 (NaN otherwise): plan_stable_limit() */
    double limit;
    int64_t whole;  /* full steps of dt in the span */
    double partial; /* [s] last partial step; 0 if there is none */
    bool exact_end; /* span is a whole number of steps */
};

/* Checks dt, span, step count (2^53), memory; ERROR_COMMAND with numbers and advice. span [s] may
 * be negative (backwards). */
bool plan_make(const struct system *system, const struct method *method,
               const struct run_settings *settings, double span, struct plan *plan,
               struct error *error);
/* Plans fixed steps dt > 0 over the span: sets only steps, whole, partial and exact_end. */
bool plan_grid(const struct system *system, double dt, double span, struct plan *plan,
               struct error *error);
/* Supremum of the stable steps [s] of the scene as a linear oscillator: HUGE_VAL every step, 0
 * none, NaN not linear. Takes milliseconds. */
double plan_stable_limit(const struct system *system, const struct method *method, enum drag drag);
void plan_describe(const struct scene *scene, const struct system *system,
                   const struct method *method, const struct run_settings *settings,
                   const struct plan *plan, struct buffer *text);

/* ---- runs ---- */

enum stop {                 /* reason why a run stopped */
            STOP_NONE,      /* not at a stop: can continue */
            STOP_END,       /* reached the time asked for */
            STOP_CONDITION, /* `until` holds */
            STOP_DIVERGED,  /* not finite, or amplitude above 1e150 */
            STOP_CANCELLED,
            STOP_NO_SOLUTION, /* implicit equation not solved */
            STOP_STALLED,     /* adaptive step below rounding */
            STOP_FULL,        /* memory budget used up */
            STOP_SINGULAR,    /* the solution itself ends there */
            STOP_GIVEN_UP     /* whoever advanced it left it there: it would take too long */
};

/* It can go on along the way it was on. */
static inline bool stop_is_pause(enum stop stop)
{
    return stop == STOP_CANCELLED || stop == STOP_GIVEN_UP;
}

/* It did not get where it should, and cannot: no step on from there. */
static inline bool stop_is_failure(enum stop stop)
{
    return stop == STOP_DIVERGED || stop == STOP_NO_SOLUTION || stop == STOP_STALLED ||
           stop == STOP_SINGULAR;
}

/* the JSON `status`: ok, diverged, cancelled … (STOP_END, STOP_CONDITION, STOP_NONE are ok) */
const char *stop_name(enum stop stop);

/* Adaptive steps shorter than this part of the time since the start are examined. */
#define RUN_CREEP 1e-6

struct singularity {
    double t;    /* [s] NAN: none, or it cannot be told */
    bool finite; /* the solution stays finite, its slope does not */
};

/* A step of fixed size that has little to do with the solution from where it began. */
struct unsound_step {
    double times;    /* its error as a multiple of the value there; 0 if none was seen */
    double t, value; /* time at which it ended [s], and the variable there */
    double solution; /* and what it should be */
    int variable;    /* the one that is off most */
};

/*
 * Estimated distance of an adaptive run from the solution: its distance from the closed form, or
 * from a second solution of another kind at a hundredth of the tolerance. The unit is the largest
 * value of each variable so far, at least its size along the run (struct controller), or atol / tol
 * if atol is given.
 */
#define OPINION_WRONG 100 /* Errors beyond this many tolerances deserve a warning. */
/* First budget of the second solution: this many evaluations and Jacobians, over the number of
 * variables (some milliseconds), or this share of those of the run, if that is more. */
#define OPINION_BUDGET 4e5
#define OPINION_SHARE 0.1
/* The same, if the first part shows that the end may be wrong: about a tenth of a second. */
#define OPINION_DOUBT 0.45
#define OPINION_BUDGET_DOUBT 4e6

struct opinion {
    /* Error at the time t, or in the mean up to there if that is larger; NAN if there is no
     * opinion. Nothing is known of a run beyond t. */
    double error;
    double max; /* the largest on the way: where values jump an error of time is one of them */
    double t;   /* [s] compared up to there */
    /* Time [s] from which on the error is as large as the motion; NAN if there is none. */
    double lost;
    double work; /* evaluations and Jacobians of the second solution */
    /* [n] distances at t [SI]; where t is not the run's, grown as `error` is */
    double end[LIMIT_VARIABLES];
    /* method of the second solution; NULL if the closed form was used */
    const struct method *method;
    double tol; /* tolerance of that method */
};

struct run {
    int number; /* 1, 2, … as users see it */
    char name[LIMIT_NAME + 1];
    struct scene scene; /* as it was at the start */
    struct system system;
    const struct method *method;
    struct run_settings settings;
    struct plan plan;
    struct trace *trace;

    int64_t steps; /* taken */
    double t;      /* [s] now */
    double y[LIMIT_VARIABLES];
    struct cost cost;
    double seconds; /* wall time spent advancing */
    enum stop stop;
    struct singularity singular; /* valid with STOP_SINGULAR */
    struct unsound_step unsound; /* the worst one seen by run_diagnose() */
    bool warned_growth, warned_sliding, warned_piling, warned_unsound, warned_doubt, warned_error;
    bool warned_burst;
    struct burst missed; /* the first that run_missed_burst() found; t_begin == t_end if none */
    struct controller controller;
    struct opinion opinion; /* filled by run_second_opinion() */
    /* Ends computations that read the run; NULL if they cannot be cancelled. */
    const struct cancel *cancel;

    struct run_private *private_state; /* work memory */
};

/* A state variable that is larger ends a run: it diverges. */
double run_bound(const struct system *system, int i);
/* States after whole steps that are known already, as a run of fixed steps would find them: row
 * [count][n], the caller's, from the present step on; their evaluations are not counted. */
void run_give(struct run *run, const double *row, int64_t count);
/* A run at its start (one recorded row). NULL with error. */
struct run *run_create(const struct scene *scene, const struct method *method,
                       const struct run_settings *settings, double span, struct error *error);
void run_destroy(struct run *run);

/*
 * Something to notice on the way: the expression passes through 0. Looked for in each step on the
 * method's dense output, on which it is located to rounding; bounds of the expression there prove
 * that none is missed, or the run says where they do not (run_event_doubt). Not at the very start
 * of the run; at its end, also where it is due but for rounding. Those at the same time but for
 * rounding are at one, in the order of definition.
 */

struct event {
    char name[LIMIT_NAME + 1];
    const struct expr *left, *right; /* the value is left - right; right NULL: left */
    int direction;                   /* 1 for rising, -1 for falling, 0 for both */
    bool touching;                   /* also where it becomes 0, but for errors, and goes back */
    bool stop;                       /* the run stops there: STOP_CONDITION */
    const struct expr_scope
        *scope; /* loads observables of the run's present state; set by the caller */
};

/* EXPR [rising|falling|touching], or a comparison: where it becomes true. Fills left … direction;
 * *used [byte]. */
bool event_compile(struct text text, const struct expr_scope *scope, struct arena *arena,
                   struct event *event, size_t *used, struct error *error);

/* One that was noticed. */
struct event_record {
    int event;     /* place in the target's list */
    int direction; /* 1 rising, -1 falling, 0 touching */
    int64_t step;  /* step of the run after the event */
    double t;      /* [s] */
};

/* Steps for which bounds did not prove that no event was missed, because they were longer than the
 * event's own time scale. */
struct event_doubt {
    int64_t steps;          /* number of such steps; 0 if there are none */
    double t_first, t_last; /* [s] the first of them and the last */
    bool is_close; /* nothing but that it comes nearer to 0 than errors of the run may be */
};

/* Returns the doubt about an event, given by its index in the targets' lists; LIMIT_EVENTS stands
 * for the condition. */
struct event_doubt run_event_doubt(const struct run *run, int event);
size_t run_event_records(const struct run *run);
const struct event_record *run_event_record(const struct run *run, size_t i);
const double *run_event_record_state(const struct run *run, size_t i); /* [n] */

struct run_target {
    double t; /* Time [s] at which to stop; HUGE_VAL if there is no end. */
    /* Largest number of further steps, counted from this call; negative if there is no limit. */
    int64_t steps;
    const struct condition
        *condition; /* stop where it becomes true (looked for as events are, located by steps of the
                       method), or NULL; true at the start, it must become false first; with
                       <= and >= it is true where it touches, within the errors of the run */
    /* Scope of the condition; loads observables of this run's current state. */
    const struct expr_scope *scope;
    const struct event *event; /* [events] */
    int events;
};

/* Returns the time [s] since which dry friction has held the body, according to the recorded rows,
 * or NAN if it does not hold it. */
double run_rest(const struct run *run);
/*
 * Advances until the target, a stop reason, cancellation or the end of `budget_ns`, where 0 means
 * no limit. Returns true while there is more to do. The rows recorded do not depend on how the work
 * is cut into calls. The last partial step is local: settings.dt is unchanged and a later call
 * continues on the grid t0 + i dt where it can: after a partial step (end of a span, condition) and
 * after a turn a new grid starts at the present time. A failed step leaves the state before it, bit
 * for bit, and so does one that cannot be recorded (STOP_FULL); calling again tries again.
 */
bool run_advance(struct run *run, const struct run_target *target, int64_t budget_ns,
                 const struct cancel *cancel);
/*
 * A run of fixed steps on the grid that it began with: the state [n] after so many steps, as
 * somebody has computed them. What it has recorded stays. The method's next step is its first.
 */
void run_place(struct run *run, int64_t steps, const double *y);
/*
 * Goes back by `rows` recorded rows; never integrates backwards. Returns false, and goes to the
 * start, if there are fewer. Restores time, state and the parameters that were in force, but not
 * the memory of a multistep method or of a step control: these start again; a propagator does not
 * know the middle of its block any more where the trace is decimated. A row inside of a step
 * (RECORD_TIMES) becomes the end of that step.
 */
bool run_back(struct run *run, int64_t rows);
/*
 * A parameter changed while the run goes on: rebinds from `scene` at the present step; y0, v0, t0
 * have no effect. The grid of times stays, the exact solution is continued from its own value, and
 * the change of energy counts as work. The run is unchanged on error.
 */
bool run_rebind(struct run *run, const struct scene *scene, struct error *error);
/* The scene that was in force on the way to the state of a row. */
const struct system *run_system_to(const struct run *run, size_t row);
/* Takes back what run_rebind() has changed at the present step, if anything: the run has the scene
 * of before. */
void run_unbind(struct run *run);
/*
 * Gives variable i of the present state another value, in a step of no length: two rows at one
 * time. The change of energy counts as work, and from there on no exact solution is known.
 * run_back() does not stop at the row before the jump. The run is unchanged on error: a value that
 * no run may reach, no room.
 */
bool run_kick(struct run *run, int i, double value, struct error *error);
/* slope [n + 1]: the derivatives of the value just set by the state before it and by time. Without
 * them the second opinion ends there. */
void run_set_jump_slopes(struct run *run, const double *slope);
/* Its steps or rows depend on steps before, not on the present state alone: to come to the same
 * bits, it has to go all the way again. */
bool run_remembers(const struct run *run);
/*
 * Finds out whether and how the solution through (t, y) ends before `end`. Integrates at most 20000
 * steps of dop853; allocates. src/run/failure/follow.c has the criterion.
 */
struct singularity system_singularity(const struct system *system, double t, const double *y,
                                      double end, const struct cancel *cancel);
/* Returns "goes to infinity" or "gets an infinite slope", to follow the words "the solution". */
const char *singularity_text(const struct singularity *singularity);
/* Finds out whether a run has failed because its solution ends there, or has stepped over such an
 * end; then stop becomes STOP_SINGULAR. Looks at the rows since the last call. */
void run_diagnose(struct run *run);
/* Appends the reason why the run stopped, as a sentence for the user, such as "diverged at t =
 * 12.31 s (step 18): dt = 0.7 s is above …; try dt <= 0.06 s". */
void run_explain(const struct run *run, struct buffer *text);
/*
 * Limits of the work on an opinion. BRIEF allows OPINION_BRIEF_SHARE of the run's own work, but
 * counts as DEMANDED if small values were asked for (atol). DEMANDED allows the larger one of
 * OPINION_BUDGET and OPINION_SHARE. WHOLE continues to the end. BRIEF and DEMANDED may go on to the
 * larger one of OPINION_BUDGET_DOUBT and OPINION_DOUBT: BRIEF where the error so far says that no
 * digit may be left at the end, DEMANDED where it may get larger than OPINION_WRONG.
 */
enum opinion_effort { OPINION_BRIEF, OPINION_DEMANDED, OPINION_WHOLE };

/* Fills run->opinion up to the present state of an adaptive run, or as far as its effort goes:
 * nothing else of it changes. Compares recorded states, at most 256 in a call. */
void run_second_opinion(struct run *run, enum opinion_effort effort, const struct cancel *cancel);
/* Returns true if an opinion exists and has seen everything that the run may have missed: the
 * second solution has not seen what no step has seen, unless the two differ by much. */
bool run_opinion_known(const struct run *run);
/* Sets magnitude_floor [n] to the size [SI] under which each variable of an adaptive run has no
 * certain digit, because of the error that the run allows or has by its second opinion, and not
 * only because the variable passes through 0. Other variables get 0. Returns the number of
 * variables that are so small. */
int run_below_tolerance(const struct run *run, double *magnitude_floor);
/* A short time at which the equations do something that no step has seen, where all steps are
 * recorded; since it was last asked. */
bool run_missed_burst(struct run *run, struct burst *missed);

/* ---- observables ----
 *
 * Functions of a recorded row, computed when something asks. Columns of exports, axes of plots,
 * names in expressions.
 */
struct sample { /* one row of a run, or its current state */
    const struct run *run;
    double t;
    const double *y; /* [n] */
    /* [J] work of non-conservative forces since the start; valid if the observable needs it */
    double work;
    double dissipated;   /* [J] the part that drag took away, >= 0 for real drag; with NEED_WORK */
    double initial;      /* [J] energy at the start; with NEED_WORK */
    const double *exact; /* [n] exact state; with NEED_EXACT */
    const struct system *system; /* System in force on the way to this state. */
};

enum observable_need {
    NEED_EXACT = 1,     /* the closed form */
    NEED_WORK = 2,      /* work since the start */
    NEED_MECHANICS = 4, /* a second-order scene: mass, forces, energy */
    NEED_CENTRE =
        8, /* a linear oscillation about an equilibrium: a whole oscillator, stiffness > 0 */
    NEED_LINE = 64, /* one coordinate, in metres */
    NEED_POWER =
        32, /* says nothing in a conservative scene, where it is 0: lists may leave it out */
    NEED_ENERGY = 128, /* struct system's energy */
    /* the value is a ratio of energies: states, work and energies come scaled so that squares
     * stay in range */
    NEED_RATIO = 16,
};

struct observable {
    struct row row; /* t y v a energy kinetic potential dissipated power error phase-error … */
    enum quantity quantity;
    unsigned needs;
    double (*value)(const struct sample *sample);
};

extern const struct catalog observable_catalog;
/* Finds an observable by its name or alias; returns NULL if there is none. */
const struct observable *observable_by_name(struct text name);
const struct observable *observable_at(size_t i);
const struct observable *observable_from(const struct row *row); /* row of the catalog */

/*
 * y, v and a are the first coordinate of the scene (theta of a pendulum), error and exact too;
 * their quantity is that of the variable. In a scene without units every quantity is a number. Rows
 * show those of the oscillator.
 */
enum quantity observable_quantity(const struct observable *observable, const struct system *system);
const char *observable_unit(const struct observable *observable, const struct system *system);
/* Returns true if the observable is defined for this system. */
bool observable_defined(const struct observable *observable, const struct system *system,
                        bool exact_known);
/* The energy, or the kinetic energy where that is all there is. */
const struct observable *observable_energy(const struct system *system);

/* Finds the rest position about which the free motion of the oscillator swings; returns false if
 * there is none. */
bool run_centre(const struct run *run, double *centre);
/* Fills values [trace_count] with the observable for all rows of the trace. Returns false, with a
 * reason, if it is not defined for this run (no exact solution …), or if cancelled. */
bool run_column(const struct run *run, const struct observable *observable, double *values,
                struct error *error);
/* State variable i (0 … n - 1) over all rows of the trace into values [trace_count]. */
void run_variable_column(const struct run *run, int i, double *values);
/* Quantity i that a typed scene observes, likewise, and at the present state. */
void run_observed_column(const struct run *run, int i, double *values);
double run_observed(const struct run *run, int i);
/* Value at the run's present state. NAN if not defined. */
double run_observable(const struct run *run, const struct observable *observable);
/*
 * Names for expressions: the state variables, then what the scene observes, then the observables
 * (energy-error is also energy_error), at the run's present state. A caller that knows more names
 * wraps find, load and offer; slots here are 0 … run_scope_slots() - 1.
 */
bool run_scope(const struct run *run, struct expr_scope *scope);
int run_scope_slots(const struct run *run);

/* Kinds of slots of that scope: a column of the rows, or a function of them. */
enum moving_kind { MOVING_TIME, MOVING_STATE, MOVING_OTHER };

struct moving {
    enum moving_kind kind;
    int index; /* index of the state variable, or of the slot */
};

struct moving run_scope_moving(const struct run *run, int slot);
/* The largest speed of the first coordinate in recorded states from t_begin to t_end [s], of a
 * scene of second order. */
double run_speed_max(const struct run *run, double t_begin, double t_end);

/*
 * Energy ledger: largest |E - E0 - W|/E0 after any step, recorded or not, W = work of drag and
 * drive since the start (0 for conservative scenes, where it is not computed), of jumps and of
 * changes of parameters. Per step W is the integral of the power along the quintic Hermite
 * interpolant of both states. It is summed up when somebody asks, from where it was asked for last;
 * where the trace leaves steps out they are taken once more, or summed up while the run goes on if
 * that cannot be. Where E0 = 0 the unit is the
 * largest |E| so far; NAN if that is 0 too, for first-order scenes, and where settings.unbalanced
 * has left it out.
 */
struct ledger {
    double initial;   /* [J] E0 */
    double final;     /* [J] */
    double work;      /* [J] W at the end */
    double error;     /* (E - E0 - W)/E0 at the end */
    double error_max; /* largest |…| so far */
    double factor;    /* E/E0 at the end, where both may be below the smallest number */
};
void run_ledger(const struct run *run, struct ledger *ledger);
/* As run_ledger() of short runs. Of longer ones work and error are NAN; error_max is the largest in
 * a sample of rows where no work is done, else NAN. */
void run_ledger_brief(const struct run *run, struct ledger *ledger);
/*
 * Returns the largest energy of a recorded state over that at the start, if the motion went through
 * far larger energies than it began and ended with: an error "of E0" has to be compared with it.
 * Otherwise returns NAN. Passes over all rows.
 */
double run_energy_peak(const struct run *run, const struct ledger *ledger);

/*
 * Errors against the exact solution over the recorded rows, in units of the amplitude max
 * |y_exact|; all NAN where none is known. With several coordinates, and in first-order scenes, the
 * largest over the variables, each in units of its own amplitude.
 */
struct run_errors {
    double end; /* distance at the end */
    double max; /* largest distance on the trace */
    /* [rad] phase of the numerical relative to the exact oscillation at the end; NAN if nothing
     * oscillates linearly */
    double phase;
    double amplitude; /* relative amplitude error at the end */
    double floor;     /* conditioning floor of the exact solution */
};
void run_errors(const struct run *run, struct run_errors *errors);
