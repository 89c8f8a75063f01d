/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Results stored for the present equations: equilibria, orbits, and branches with their labelled
 * special points. They are dropped when the equations change, but not when values of parameters or
 * initial values do. No memory is allocated before there is a result.
 */
#pragma once

#include <hooke/module.h>
#include "modules/dynamics/dynamics.h"
#include "modules/dynamics/stored_portrait.h"

/* The equilibria found last. */
struct kept_equilibria {
    uint64_t id;   /* identifier in the session's file, or 0 if it is not stored */
    double *value; /* [params] SI, parameters of the scene at that time */
    int count;
    struct solution *solution;
    struct equilibrium_form *form;
    bool forced, complete;
};

struct kept_orbit {
    uint64_t id;
    int number; /* counted from 1 */
    double *value;
    struct solution solution;
    int samples;    /* number of samples over one period */
    double *sample; /* [samples][n + 1] time since the start [s], state */
};

struct kept_point {
    int index; /* place in the branch */
    enum special special;
    int number; /* its label is the letters of `special` with it */
};

struct kept_branch {
    uint64_t id;
    int number;
    double *value;        /* but for what varies */
    int params, param[2]; /* indices of what varies among the scene's */
    double low[2], high[2];
    char origin[LIMIT_NAME + 1]; /* "equilibrium 1", "HB1" */
    struct branch branch;        /* its points are owned */
    struct kept_point *special;
    int specials;
};

struct dynamics {
    char *equations; /* as text: they are compared */
    int params, n;
    uint64_t next_id;
    struct kept_equilibria equilibria;
    struct kept_orbit orbit[LIMIT_ORBITS];
    int orbits, next_orbit;
    struct kept_branch *branch[LIMIT_BRANCHES];
    int branches, next_branch;
    int next_point[SPECIAL_COUNT]; /* numbers that labels go on with */
};

extern const struct module dynamics_module;

/* State of the module in a session. */
struct dynamics_part {
    struct dynamics *found;          /* NULL if nothing was found yet */
    struct stored_portrait portrait; /* shown by 'plot portrait' and its pane */
};

/* Functions of dynamics_module.store (store.c). */
void dynamics_put_head(const void *part, struct buffer *buffer);
bool dynamics_put_next(const void *part, struct stored *stored, int *next);
void dynamics_forget(const void *part, struct stored *stored);
void dynamics_read(struct reader *reader);

/* Returns the results stored for the present equations, or NULL if there are none. */
const struct dynamics *session_dynamics(const struct session *session);
void dynamics_free(struct dynamics *dynamics);

/* Copies; what was found of other equations goes. Returns false if out of memory. */
bool dynamics_keep_equilibria(struct session *session, const struct equilibria *found,
                              struct error *error);
/* sample [samples][n + 1]. The orbit that is kept, also where it was known already; the oldest goes
 * where there are LIMIT_ORBITS. Returns NULL if out of memory. */
const struct kept_orbit *dynamics_keep_orbit(struct session *session, const struct solution *orbit,
                                             int samples, const double *sample,
                                             struct error *error);
/*
 * Takes over the branch in *like, also when it fails; of the rest only what varies, from where and
 * which way is read. value [params]: of the scene that it was followed in. Its special points get
 * labels: the one that is there already at the same place. The oldest branch goes where there are
 * LIMIT_BRANCHES. Returns NULL if out of memory.
 */
struct kept_branch *dynamics_keep_branch(struct session *session, struct kept_branch *like,
                                         const double *value, struct error *error);

/* Returns the orbit of this number, or NULL if there is none. `dynamics` may be NULL. */
const struct kept_orbit *dynamics_orbit(const struct dynamics *dynamics, int number);
/* Finds the special point with a label such as "HB1", in upper or lower case, on the latest branch
 * that has it. Returns NULL if there is none. */
const struct kept_point *dynamics_point(const struct dynamics *dynamics, struct text label,
                                        const struct kept_branch **branch);
static inline const struct branch_point *kept_point_at(const struct kept_branch *branch,
                                                       const struct kept_point *point)
{
    return &branch->branch.point[point->index];
}
#define KEPT_LABEL 16
void kept_point_label(const struct kept_point *point, char label[KEPT_LABEL]);

/* The scene with these values of all its parameters [params]. */
void dynamics_scene(const struct session *session, const double *value, struct scene *scene);
/* Likewise at a point of a branch. */
void dynamics_scene_at(const struct session *session, const struct kept_branch *branch, int index,
                       struct scene *scene);

/*
 * Fills box [n] with the region of state space in which equilibria are searched: what the current
 * run of the scene has shown and its natural sizes about 0, widened; of an angle one turn. Returns
 * false with `error` filled if out of memory.
 */
bool dynamics_search_box(const struct session *session, const struct system *system,
                         struct arena *arena, double box[][2], struct error *error);
