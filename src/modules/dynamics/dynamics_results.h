/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Results that a session stores for its equations: equilibria, orbits, and branches with their
 * labelled special points. They are dropped when the equations change, but not when values of
 * parameters or initial values do. dynamics_store_…() store a result; session_dynamics() returns
 * what is stored. */
#pragma once

#include <hooke/module.h>
#include "modules/dynamics/dynamics.h"
#include "modules/dynamics/stored_portrait.h"

/* The equilibria found last. */
struct stored_equilibria {
    uint64_t id;   /* identifier in the session's file, or 0 if it is not stored */
    double *value; /* [params] SI, parameters of the scene with which they were found */
    int count;
    struct solution *solution;
    struct equilibrium_form *form;
    bool forced, complete;
};

/* A stored orbit. */
struct stored_orbit {
    uint64_t id;
    int number;    /* name of the orbit for the user, counted from 1 */
    double *value; /* [params] SI, as above */
    struct solution solution;
    int samples;    /* number of samples over one period */
    double *sample; /* [samples][n + 1] time since the start [s], state */
};

/* A labelled special point of a stored branch. */
struct stored_point {
    int index; /* index in branch.point */
    enum special special;
    int number; /* the label is the letters of `special` and this number: HB1 */
};

/* A stored branch. */
struct stored_branch {
    uint64_t id;
    int number;
    double *value;                /* [params] SI; that of a parameter that varies has no meaning */
    int params, param[2];         /* number and indices of the scene's parameters that vary */
    double low[2], high[2];       /* SI; the ranges that were asked for */
    char origin[LIMIT_NAME + 1];  /* "equilibrium 1", "HB1" */
    struct branch branch;         /* the branch, whose points it owns */
    struct stored_point *special; /* [specials] labelled points */
    int specials;
};

/* All results for one set of equations. */
struct dynamics {
    char *equations; /* the equations as text, by which changes are noticed */
    int params, n;   /* number of parameters and of variables of the scene */
    uint64_t next_id;
    struct stored_equilibria equilibria;
    struct stored_orbit orbit[LIMIT_ORBITS];
    int orbits, next_orbit;
    struct stored_branch *branch[LIMIT_BRANCHES];
    int branches, next_branch;
    int next_point[SPECIAL_COUNT]; /* number of the next label of each kind */
};

extern const struct module dynamics_module;

/* State of the module in a session. */
struct dynamics_part {
    struct dynamics *found;          /* NULL if nothing was found yet */
    struct stored_portrait portrait; /* shown by 'plot portrait' and its pane */
};

/* ---- functions of dynamics_module.store (store.c); part is the struct dynamics_part ---- */

/* Writes counters, equations and the identifiers of all results. */
void dynamics_put_head(const void *part, struct buffer *buffer);
/* Writes the first result from number *next on that is not in the file yet as a record, and sets
 * *next behind it. Returns false if there is none. */
bool dynamics_put_next(const void *part, struct stored *stored, int *next);
/* Removes results that no longer exist from the list of what the file holds. */
void dynamics_forget(const void *part, struct stored *stored);
/* Reads the results of a session's file; damaged ones are left out with a note. */
void dynamics_read(struct reader *reader);

/* Returns the results stored for the present equations, or NULL if there are none. */
const struct dynamics *session_dynamics(const struct session *session);
void dynamics_free(struct dynamics *dynamics);

/* Stores a copy of the equilibria in place of earlier ones; results of other equations are freed.
 * Returns false with *error if out of memory. */
bool dynamics_store_equilibria(struct session *session, const struct equilibria *found,
                               struct error *error);
/* Stores a copy of an orbit with its samples [samples][n + 1]. An orbit that is stored already
 * retains its number; the oldest is dropped if there are LIMIT_ORBITS. Returns the stored orbit, or
 * NULL with *error if out of memory. */
const struct stored_orbit *dynamics_store_orbit(struct session *session,
                                                const struct solution *orbit, int samples,
                                                const double *sample, struct error *error);
/* Stores the branch like->branch, which it owns from then on, even on failure; params, param, low,
 * high and origin of *like describe it. `value` [params] are the parameters of the scene in which
 * it was followed. Special points get labels; one that is known from another branch gets the same
 * label. The oldest branch is dropped if there are LIMIT_BRANCHES. Returns the stored branch, or
 * NULL with *error if out of memory. */
struct stored_branch *dynamics_store_branch(struct session *session, struct stored_branch *like,
                                            const double *value, struct error *error);

/* Returns the orbit of this number, or NULL if there is none. `dynamics` may be NULL. */
const struct stored_orbit *dynamics_orbit(const struct dynamics *dynamics, int number);
/* Finds the special point with a label such as "HB1", in upper or lower case, on the latest branch
 * that has it. Returns NULL if there is none. */
const struct stored_point *dynamics_point(const struct dynamics *dynamics, struct text label,
                                          const struct stored_branch **branch);
/* Returns the point of the branch that a label belongs to. */
static inline const struct branch_point *stored_point_at(const struct stored_branch *branch,
                                                         const struct stored_point *point)
{
    return &branch->branch.point[point->index];
}
#define POINT_LABEL_SIZE 16 /* [byte] size of a label, such as "HB1" */
/* Writes the label of a special point. */
void stored_point_label(const struct stored_point *point, char label[POINT_LABEL_SIZE]);

/* Copies the session's scene with these values of all of its parameters [params]. */
void dynamics_scene(const struct session *session, const double *value, struct scene *scene);
/* Copies the session's scene with the parameters of one point of a branch. */
void dynamics_scene_at(const struct session *session, const struct stored_branch *branch, int index,
                       struct scene *scene);

/* Fills box [n] with the region of state space in which equilibria are searched: what the current
 * run of the scene has visited and its natural sizes around 0, both extended by a margin; for an
 * angle one turn. Returns false with *error if out of memory. */
bool dynamics_search_box(const struct session *session, const struct system *system,
                         struct arena *arena, double box[][2], struct error *error);
