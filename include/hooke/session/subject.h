/* SPDX-License-Identifier: GPL-3.0-or-later */
/* subject: the run, recording or part of one that measure, fit, export and plot act on, as a
 * series; what is known about it; and columns of runs by name. */
#pragma once

#include <hooke/data/series.h>
#include <hooke/session/names.h>

struct cancel;

/* ---- the subject of a command ---- */

/* A series with its origin. Opened by subject_open() (<hooke/language.h>); memory is the arena's.
 */
struct subject {
    struct series series;
    char name[LIMIT_NAME + 16]; /* Name, such as "run 1" or "data swing3". */
    bool energy;                /* The series is an energy. */
    bool column;                /* It is a column that the user has named. */
    struct run *run;            /* The run, or NULL for a recording. */
    /* The recording, or NULL for a run. */
    struct recording *recording;
    char how[340];             /* Origin of m, k and v for the energy of a recording, in words. */
    struct measured mass, k;   /* Mass [kg] and stiffness [N/m] used for it. */
    struct energy_noise noise; /* Noise of the energy of a recording. */
};

/* Returns the scene with which a series is compared: that of the run; for a recording (`run` is
 * NULL) the current one, if it is an oscillator whose k or m the user has set, else NULL. */
const struct scene *subject_scene(const struct session *session, const struct run *run);
/* Returns true if the scene is an oscillator; otherwise sets an error that `what` needs one. */
bool needs_spring(const struct scene *scene, const char *what, struct error *error);
/* Returns the period [s] of the oscillation with its linear damping; for other models that of an
 * oscillation with the amplitude of their start. Returns NAN if it does not oscillate or if `scene`
 * is NULL. */
double scene_period(const struct scene *scene);
/* Returns the period [s] of an undamped pendulum with this amplitude [rad], by the complete
 * elliptic integral, or NAN for another scene. */
double scene_period_at(const struct scene *scene, double amplitude);
/* Returns a derived quantity [SI] by its name, or NAN if it is not defined or if `scene` is NULL.
 */
double derived_value(const struct scene *scene, const char *name);
/* Adds a measurement [SI] to `list measurements` and stores it as the result measured_NAME; the
 * oldest row is dropped if there are too many. Returns false, with `error` set, if out of memory.
 */
bool session_add_measurement(struct session *session, const char *name, const char *subject,
                             struct measured value, enum quantity unit, double periods,
                             struct error *error);
/* Makes a series of the first variable of a run, or of its energy, from the oldest time on even if
 * the run went backwards. Returns false with `error` set. */
bool run_series(const struct run *run, bool energy, struct arena *arena, struct series *series,
                struct error *error);
/* Finds the period [s] of a run's position over all rows, in the cheapest way that is valid for it.
 * Returns false if it has none. */
bool run_period(const struct run *run, struct arena *arena, struct measured *period);

/* ---- columns of a run, by name (columns.c) ---- */

/* A column of a run: a state variable, an observed quantity or an observable. */
struct chosen_column {
    /* The observable, or NULL for state variable number `variable`; numbers from n on are observed
     * quantities. */
    const struct observable *observable;
    int variable;
};

/* Returns true if both models have the same columns in the same order, as models that were typed
 * again with other laws have. */
bool models_alike(const struct model *a, const struct model *b);
/* Finds a column by its name; names of the model take precedence over observables. Returns false,
 * with `error` set, if there is none. */
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

/* Velocities, and perhaps energies, of a recording of positions. Arrays are the arena's. */
struct data_motion {
    size_t n;
    const double *t, *y; /* [n] times [s] and positions [SI] as in recording_series(). */
    double *v;           /* [n] velocities [m/s], NAN where unknown. */
    double *energy;      /* [n] energies [J], NAN where unknown; NULL if they were not requested. */
    double middle;       /* [m] equilibrium position */
    double omega;        /* [rad/s] of the oscillation, NAN if there is none */
    enum quantity quantity; /* Quantity of v. */
    const struct cancel *cancel;
    /* [1/s] standard deviation of v for independent noise of standard deviation 1 in the positions
     */
    double gain;
    double loss;             /* Relative loss of v by smoothing; 0 if v comes from the sensor. */
    struct measured mass, k; /* Mass [kg] and stiffness [N/m] used for the energy. */
    struct energy_noise noise;
    char how_v[160], how_k[160]; /* Their origin, in words. */
};

/* Makes a series of the samples from t_begin to t_end [s] whose velocity, or energy if `energy`, is
 * known. Returns false, with `error` set, if out of memory. */
bool motion_series(const struct data_motion *motion, bool energy, double t_begin, double t_end,
                   struct arena *arena, struct series *series, struct error *error);
