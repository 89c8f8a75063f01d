/* SPDX-License-Identifier: GPL-3.0-or-later */
/* observable: quantities of a run that are computed from its recorded rows on demand: observables,
 * errors against the exact solution, and the energy balance. A part of <hooke/run.h>, which
 * includes it. Functions return SI values. Those for all rows take time for each row; they stop
 * early if run->cancel is set. */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/scene/model.h>

struct run;

/*
 * ---- observables ----
 *
 * An observable is a built-in function of a recorded row, such as energy or phase-error: a column
 * of exports, an axis of plots, a name in expressions. An observed quantity, in contrast, is an
 * expression that the user has defined for a typed scene by a line `observe NAME = EXPR`.
 */
struct sample { /* One row of a run, or its current state, as the argument of an observable. */
    const struct run *run;
    /* Time [s]. */
    double t;
    const double *y; /* State [n]. */
    /* Work [J] of non-conservative forces since the start; set only for observables with NEED_WORK.
     */
    double work;
    /* Energy [J] that drag has removed, >= 0 for real drag; only with NEED_WORK. */
    double dissipated;
    double initial;      /* Energy [J] at the start; only with NEED_WORK. */
    const double *exact; /* Exact state [n] at t; only with NEED_EXACT. */
    /* System (with the parameters of that time) on the step that led to this state. */
    const struct system *system;
};

/* Requirements of an observable, combined by |. */
enum observable_need {
    NEED_EXACT = 1,     /* The exact solution of the scene, in sample.exact. */
    NEED_WORK = 2,      /* The work since the start, in sample.work. */
    NEED_MECHANICS = 4, /* A second-order scene: mass, forces, energy. */
    /* A linear oscillation about an equilibrium: a linear spring with stiffness > 0, and no other
     * force than those of struct oscillator. */
    NEED_CENTRE = 8,
    NEED_LINE = 64, /* A scene with one coordinate, which is a length. */
    /* A power or work of forces without a potential, which is always 0 in a conservative scene. The
     * observable is defined there nevertheless, as 0, but lists may leave it out. */
    NEED_POWER = 32,
    /* A system whose potential energy is known (member `energy` of struct system). */
    NEED_ENERGY = 128,
    /* The observable is a ratio of energies: before it is computed, states, work and energies are
     * multiplied by a common scale, so that their squares remain in the range of doubles. */
    NEED_RATIO = 16,
};

/* A row of observable_catalog. */
struct observable {
    /* Name (t, y, v, a, energy, kinetic, potential, dissipated, power, error, phase-error, …), SI
     * unit, description, source. */
    struct row row;
    /* Quantity in scenes of the oscillator; see observable_quantity() for any system. */
    enum quantity quantity;
    /* Flags of enum observable_need. */
    unsigned needs;
    /* Returns the value [SI] for a row. */
    double (*value)(const struct sample *sample);
};

/* All observables. */
extern const struct catalog observable_catalog;
/* Returns the observable with this name or alias, or NULL if there is none. */
const struct observable *observable_by_name(struct text name);
/* Returns observable i of the catalog. */
const struct observable *observable_at(size_t i);
/* Returns the observable whose struct row this is; it must be in the catalog. */
const struct observable *observable_from(const struct row *row);

/* Return quantity and unit of an observable for a system. y, v, a, error and exact belong to the
 * first coordinate (theta of a pendulum) and have its quantities. In a scene without units every
 * quantity but time is a number. */
enum quantity observable_quantity(const struct observable *observable, const struct system *system);
const char *observable_unit(const struct observable *observable, const struct system *system);
/* Returns true if the observable is defined for this system; exact_known tells that the exact
 * solution is available. */
bool observable_defined(const struct observable *observable, const struct system *system,
                        bool exact_known);
/* Returns the observable `energy`, or `kinetic` if only the kinetic energy is known. */
const struct observable *observable_energy(const struct system *system);

/* Finds the equilibrium [m] about which the free motion of a linear oscillator swings. Returns
 * false if there is none. */
bool run_centre(const struct run *run, double *centre);
/* Computes the observable for all rows of the trace into values [trace_count]. Returns false, with
 * `error` set, if it is not defined for this run (no exact solution …), or if cancelled. */
bool run_column(const struct run *run, const struct observable *observable, double *values,
                struct error *error);
/* Copies state variable i (0 … n - 1) of all rows of the trace to values [trace_count]. */
void run_variable_column(const struct run *run, int i, double *values);
/* Return the values [SI] of observed quantity i of a typed scene (its `observe` line number i, from
 * 0): run_observed_column() for all rows, in values [trace_count]; run_observed() at the current
 * state. */
void run_observed_column(const struct run *run, int i, double *values);
double run_observed(const struct run *run, int i);
/* Returns the observable at the run's current state, or NAN if it is not defined. */
double run_observable(const struct run *run, const struct observable *observable);
/* Makes *scope the scope of names for expressions at the run's current state: state variables, then
 * observed quantities, then observables (energy-error is also energy_error). Their slots are the
 * numbers from 0 to run_scope_slots() - 1. A caller that has more names wraps the callbacks find,
 * load and offer of *scope. Returns false if `run` is NULL. */
bool run_scope(const struct run *run, struct expr_scope *scope);
int run_scope_slots(const struct run *run);

/* Kind of the name that has a slot of run_scope(): the time, a state variable, or another quantity
 * that changes during the run, which is a function of these. */
enum moving_kind { MOVING_TIME, MOVING_STATE, MOVING_OTHER };

/* The name of a slot of run_scope(), whose value moves (changes) during the run. */
struct moving {
    enum moving_kind kind;
    int index; /* Index of the state variable for MOVING_STATE, 0 for MOVING_TIME, else the slot. */
};

/* Returns the kind and the index of the name with this slot of run_scope(). */
struct moving run_scope_moving(const struct run *run, int slot);
/* Returns the largest speed of the first coordinate in the rows from t_begin to t_end [s]. Only for
 * second-order scenes. */
double run_speed_max(const struct run *run, double t_begin, double t_end);

/* Energy balance of a run, also called ledger. With E0 the energy at the start, E that after a
 * step, and W the work since the start, its error is (E - E0 - W)/E0, tested after each step,
 * recorded or not. W is the work of drag and drive (0 in conservative scenes), of jumps of the
 * state, and of changes of parameters; in each step it is the integral of the power along the
 * quintic Hermite interpolant of the states at both ends. If E0 = 0, the largest |E| so far
 * replaces E0 as the unit. The errors are NAN if that is 0, too, in first-order scenes, and if
 * settings.unbalanced has switched the balance off. */
struct ledger {
    double initial;   /* Energy E0 [J] at the start. */
    double final;     /* Energy E [J] at the end. */
    double work;      /* Work W [J] at the end. */
    double error;     /* Error (E - E0 - W)/E0 at the end. */
    double error_max; /* Largest magnitude of `error` at any time so far. */
    double factor;    /* E/E0 at the end, also if both energies are too small for a double. */
};
/* Computes the balance of a run. Repeated calls only process the steps since the last call. Steps
 * that were not recorded are computed again or, if that is not possible, their work was added
 * during the run. */
void run_ledger(const struct run *run, struct ledger *ledger);
/* Computes the balance of a run in bounded time. Short runs get the full balance. For longer ones
 * `work` and `error` are NAN, and error_max is the largest error in a sample of rows, or NAN if
 * forces do work. */
void run_ledger_brief(const struct run *run, struct ledger *ledger);
/* Returns true if the method, not the scene, has made the energy grow more than a hundredfold. */
bool run_is_unstable(const struct run *run);
/* Returns the status of a run in one word: "unstable" if run_is_unstable(), else the word for the
 * reason of its last stop (run->stop). */
const char *run_status(const struct run *run);
/* Returns the ratio of the largest energy of a row to that at the start, if the motion went through
 * far larger energies than at its start and end; otherwise NAN. An error of the energy balance in
 * units of E0 has to be compared with this ratio. Reads all rows. */
double run_energy_peak(const struct run *run, const struct ledger *ledger);

/* Errors against the exact solution over the recorded rows, in units of the amplitude
 * max |y_exact|; all NAN if no exact solution is known. With several coordinates, and in
 * first-order scenes, each error is the largest of those of the variables, each in units
 * of its own amplitude. */
struct run_errors {
    double end; /* Error at the end. */
    double max; /* Largest error of a row. */
    /* Phase [rad] of the numerical minus that of the exact oscillation at the end; NAN unless the
     * scene is a linear oscillation. */
    double phase;
    double amplitude; /* Relative error of the amplitude at the end. */
    double floor;     /* Error of the exact solution itself, see system_exact(). */
};
/* Computes the errors of a run. */
void run_errors(const struct run *run, struct run_errors *errors);
