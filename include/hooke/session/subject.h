/* SPDX-License-Identifier: GPL-3.0-or-later */
/* subject: the series on which the commands measure, fit, export and plot act (the subject): a run,
 * a recording or a part of one. Also what is known about the series, and columns of runs by name.
 */
#pragma once

#include <hooke/data/series.h>
#include <hooke/session/names.h>

struct cancel;

/* ---- the subject of a command ---- */

/* A series and where it comes from. Opened by subject_open() (<hooke/language.h>), in whose arena
 * its memory is. */
struct subject {
    struct series series;
    char name[LIMIT_NAME + 16]; /* Name, such as "run 1" or "data swing3". */
    bool energy;                /* The series is an energy instead of a position. */
    bool column;                /* The series is a column that the user has named in the command. */
    struct run *run;            /* The run, or NULL for a recording. */
    /* The recording, or NULL for a run. */
    struct recording *recording;
    /* Words on how mass, stiffness and velocity were found for the energy of a recording. */
    char how[340];
    /* Mass [kg] and stiffness [N/m] from which that energy was computed. */
    struct measured mass, k;
    struct energy_noise noise; /* Noise of the energy of a recording. */
};

/* Returns the scene with which a series is compared: that of the run; for a recording (`run` is
 * NULL) the current one, if it is an oscillator whose k or m the user has set, else NULL. */
const struct scene *subject_scene(const struct session *session, const struct run *run);
/* Returns true if the scene is an oscillator; otherwise sets the error that `what`, such as the
 * name of a command, needs an oscillator. */
bool needs_spring(const struct scene *scene, const char *what, struct error *error);
/* Returns the period [s] of the oscillation, with its linear damping; for models other than the
 * oscillator that of an oscillation with the amplitude of the initial state. Returns NAN if the
 * scene does not oscillate or if `scene` is NULL. */
double scene_period(const struct scene *scene);
/* Returns the period [s] of an undamped pendulum with this amplitude [rad], by the complete
 * elliptic integral, or NAN for another scene. */
double scene_period_at(const struct scene *scene, double amplitude);
/* Returns a derived quantity [SI] by its name, or NAN if it is not defined or if `scene` is NULL.
 */
double derived_value(const struct scene *scene, const char *name);
/* Adds a measurement [SI] of the quantity `name` of the series `subject` to `list measurements`,
 * and stores it as the result measured_NAME. `periods` is the number of periods that were used, NAN
 * if it does not apply. The oldest row is dropped if there are too many. Returns false, with
 * `error` set, if out of memory. */
bool session_add_measurement(struct session *session, const char *name, const char *subject,
                             struct measured value, enum quantity unit, double periods,
                             struct error *error);
/* Makes a series of the first variable of a run, or with `energy` of its energy; times ascend, even
 * if the run went backwards in time. Returns false with `error` set. */
bool run_series(const struct run *run, bool energy, struct arena *arena, struct series *series,
                struct error *error);
/* Measures the period [s] of the first variable of a run over all rows, by the fastest procedure
 * that is valid for the run. Returns false if it has no period. */
bool run_period(const struct run *run, struct arena *arena, struct measured *period);

/* ---- columns of a run, by name (columns.c) ---- */

/* A column of a run: a state variable, an observed quantity or an observable. */
struct chosen_column {
    /* The observable. If NULL, `variable` chooses the column: the index of a state variable, or n
     * plus the index of an observed quantity. */
    const struct observable *observable;
    int variable;
};

/* Returns true if both models have the same columns in the same order, for example if only the
 * equations of a typed model were changed. */
bool models_alike(const struct model *a, const struct model *b);
/* Finds the column of this name; names of variables and observed quantities take precedence over
 * observables. Returns false, with `error` set, if there is none. */
bool chosen_find(const struct model *model, struct text name, struct chosen_column *column,
                 struct error *error);
/* Returns name and quantity of a column. */
struct variable chosen_variable(const struct system *system, const struct chosen_column *column);
/* Returns the SI unit of a column, as in files. */
const char *chosen_unit(const struct system *system, const struct chosen_column *column);
/* Computes a column for all rows of the trace into values [trace_count]. Returns false, with
 * `error` set, if it is not defined or if cancelled. */
bool chosen_values(const struct run *run, const struct chosen_column *column, double *values,
                   struct error *error);

/* ---- velocity and energy of a recording of positions ---- */

/* Velocities, and perhaps energies, of a recording of positions. Arrays are in the arena that was
 * passed to series_tools()->motion(). */
struct data_motion {
    size_t n;
    const double *t, *y; /* [n] times [s] and positions [SI] as in recording_series(). */
    double *v;           /* [n] velocities [m/s], NAN where unknown. */
    double *energy;      /* [n] energies [J], NAN where unknown; NULL if they were not requested. */
    double middle;       /* Equilibrium position [m]. */
    double omega;        /* Angular frequency [rad/s] of the oscillation, NAN if there is none. */
    enum quantity quantity; /* Quantity of v. */
    const struct cancel *cancel;
    /* Ratio [1/s] of the standard deviation of the noise of v to that of y, for independent noise
     * of the positions y. */
    double gain;
    /* Fraction of the amplitude of v that is lost because v is computed from y by local parabolas,
     * which smooth it; 0 if v comes from the sensor. */
    double loss;
    struct measured mass, k; /* Mass [kg] and stiffness [N/m] used for the energy. */
    struct energy_noise noise;
    char how_v[160], how_k[160]; /* Words on how the velocities and the stiffness were found. */
};

/* Makes a series of the velocities, or with `energy` of the energies, of the samples from t_begin
 * to t_end [s] for which they are known. Returns false, with `error` set, if out of memory. */
bool motion_series(const struct data_motion *motion, bool energy, double t_begin, double t_end,
                   struct arena *arena, struct series *series, struct error *error);
