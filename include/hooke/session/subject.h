/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Series of runs and recordings, what is known of them, what was computed with what. */
#ifndef HOOKE_SESSION_SUBJECT_H
#define HOOKE_SESSION_SUBJECT_H

#include <hooke/data/series.h>
#include <hooke/session/names.h>

struct cancel;

/* ---- what measure, fit, export and plot act on (source of a series) ---- */

struct subject {
    struct series series;
    char name[LIMIT_NAME + 16]; /* "run 1", "data swing3" */
    bool energy;                /* the series is an energy */
    bool column;                /* it is a column that was asked for by name */
    struct run *run;            /* NULL: a recording */
    struct recording *recording;
    char how[340];             /* of the energy of a recording: whose m, k and v */
    struct measured mass, k;   /* these */
    struct energy_noise noise; /* of the energy of a recording */
};

/* The scene that a run or a recording is measured against: its own; for a recording the present
 * one, if somebody has said what the spring is, else NULL. */
const struct scene *subject_scene(const struct session *session, const struct run *run);
/* Whether the scene is an oscillator; error if not, which says that `what` needs one. */
bool needs_spring(const struct scene *scene, const char *what, struct error *error);
/* [s] of the oscillation with its linear damping, of another model as wide as it starts; NAN: it
 * does not oscillate, or there is no scene. */
double scene_period(const struct scene *scene);
/* [s] of a pendulum that swings so far [rad], without damping: complete elliptic integral; NAN:
 * another scene. */
double scene_period_at(const struct scene *scene, double amplitude);
/* NAN: no scene, or not defined */
double derived_value(const struct scene *scene, const char *name);
/* Keeps it as a row of `list measurements` and as the result measured_NAME. */
bool session_add_measurement(struct session *session, const char *name, const char *of,
                             struct measured value, enum quantity unit, double periods,
                             struct error *error);
/* The first variable, or energy, of a run over time; oldest first also where it went backwards. */
bool run_series(const struct run *run, bool energy, struct arena *arena, struct series *series,
                struct error *error);
/* As of its position over all recorded rows, found the cheapest way that is sound for it; false: it
 * has none. */
bool run_period(const struct run *run, struct arena *arena, struct measured *period);

/* ---- what a run has to show over its rows (columns.c) ---- */

struct chosen_column {
    const struct observable
        *observable; /* NULL: number `variable` of the state, or of what is observed behind it */
    int variable;
};

/* Whether both have the same things to show, in the same order: models may be typed anew with other
 * laws. */
bool models_alike(const struct model *a, const struct model *b);
/* A user's names come before those of observables. Error: the model has nothing of that name. */
bool chosen_find(const struct model *model, struct text name, struct chosen_column *column,
                 struct error *error);
/* Its name and quantity. */
struct variable chosen_variable(const struct system *system, const struct chosen_column *column);
/* SI, as in files. */
const char *chosen_unit(const struct system *system, const struct chosen_column *column);
/* Over all rows of the trace, into out [trace_count]. */
bool chosen_values(const struct run *run, const struct chosen_column *column, double *out,
                   struct error *error);

/* ---- velocity and energy of a recording of positions (data_motion.c) ---- */

struct data_motion {
    size_t n;
    const double *t, *y;    /* [n] as recording_series gives them */
    double *v;              /* [n] [m/s] NAN: not known there */
    double *energy;         /* [n] [J] NAN: not known there; NULL: not asked for */
    double middle;          /* [m] equilibrium, in y */
    double omega;           /* [rad/s] of the oscillation; NAN: it has none */
    enum quantity quantity; /* of v */
    const struct cancel *cancel;
    double gain; /* [1/s] standard deviation of v for positions with independent noise of 1 */
    double loss; /* by which part v comes out too small; 0: of the sensor's own */
    struct measured mass, k; /* of the energy */
    struct energy_noise noise;
    char how_v[160], how_k[160]; /* where they come from, in words */
};

/* The rows where v (energy: the energy) is known, as a series; from, to [s]. */
bool motion_series(const struct data_motion *motion, bool energy, double from, double to,
                   struct arena *arena, struct series *series, struct error *error);

#endif
