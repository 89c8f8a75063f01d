/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Series of runs and recordings, what is known of them, what was computed with what. */
#pragma once

#include <hooke/data/series.h>
#include <hooke/session/names.h>

struct cancel;

/* ---- what measure, fit, export and plot act on (source of a series) ---- */

struct subject {
    struct series series;
    char name[LIMIT_NAME + 16]; /* "run 1", "data swing3" */
    bool energy;                /* the series is an energy */
    bool column;                /* it is a column that was asked for by name */
    struct run *run;            /* NULL for a recording */
    struct recording *recording;
    char how[340];             /* origin of m, k and v for the energy of a recording */
    struct measured mass, k;   /* these */
    struct energy_noise noise; /* noise of the energy of a recording */
};

/* The scene that a run or a recording is measured against: its own; for a recording the present
 * one, if somebody has said what the spring is, else NULL. */
const struct scene *subject_scene(const struct session *session, const struct run *run);
/* Returns true if the scene is an oscillator; otherwise sets an error that `what` needs one. */
bool needs_spring(const struct scene *scene, const char *what, struct error *error);
/* Returns the period [s] of the oscillation with its linear damping; for another model that of
 * an oscillation as wide as its start. Returns NAN if it does not oscillate or if there is no
 * scene. */
double scene_period(const struct scene *scene);
/* Returns the period [s] of an undamped pendulum with that amplitude [rad] by the complete elliptic
 * integral, or NAN for another scene. */
double scene_period_at(const struct scene *scene, double amplitude);
/* Returns NAN if there is no scene or if the quantity is not defined. */
double derived_value(const struct scene *scene, const char *name);
/* Keeps it as a row of `list measurements` and as the result measured_NAME. */
bool session_add_measurement(struct session *session, const char *name, const char *subject,
                             struct measured value, enum quantity unit, double periods,
                             struct error *error);
/* The first variable, or energy, of a run over time; oldest first also where it went backwards. */
bool run_series(const struct run *run, bool energy, struct arena *arena, struct series *series,
                struct error *error);
/* Finds the period of the run's position over all recorded rows, in the cheapest way that is valid
 * for it. Returns false if it has none. */
bool run_period(const struct run *run, struct arena *arena, struct measured *period);

/* ---- what a run has to show over its rows (columns.c) ---- */

struct chosen_column {
    /* NULL for variable number `variable` of the state, or for an observation after those */
    const struct observable *observable;
    int variable;
};

/* Returns true if both have the same columns in the same order: models may be typed anew with other
 * laws. */
bool models_alike(const struct model *a, const struct model *b);
/* Finds a column by its name; a user's names come before those of observables. Sets an error if the
 * model has nothing of that name. */
bool chosen_find(const struct model *model, struct text name, struct chosen_column *column,
                 struct error *error);
/* Its name and quantity. */
struct variable chosen_variable(const struct system *system, const struct chosen_column *column);
/* SI, as in files. */
const char *chosen_unit(const struct system *system, const struct chosen_column *column);
/* Computes the column over all rows of the trace, into values [trace_count]. */
bool chosen_values(const struct run *run, const struct chosen_column *column, double *values,
                   struct error *error);

/* ---- velocity and energy of a recording of positions (data_motion.c) ---- */

struct data_motion {
    size_t n;
    const double *t, *y;    /* [n] as recording_series gives them */
    double *v;              /* [n] [m/s] NAN: not known there */
    double *energy;         /* [n] [J]; NAN where it is not known; NULL if not asked for */
    double middle;          /* [m] equilibrium, in y */
    double omega;           /* [rad/s] of the oscillation; NAN if there is none */
    enum quantity quantity; /* quantity of v */
    const struct cancel *cancel;
    double gain; /* [1/s] standard deviation of v for positions with independent noise of 1 */
    double loss; /* relative loss of v; 0 if v is the sensor's own */
    struct measured mass, k; /* mass and stiffness used for the energy */
    struct energy_noise noise;
    char how_v[160], how_k[160]; /* their origin, in words */
};

/* The rows where v (energy: the energy) is known, as a series; from, to [s]. */
bool motion_series(const struct data_motion *motion, bool energy, double t_begin, double t_end,
                   struct arena *arena, struct series *series, struct error *error);
