/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the commands of dynamics share. */
#pragma once

#include "modules/dynamics/kept.h"
#include <hooke/command/handler.h>

/* Writes the table of equilibria for people (equilibria.c). */
void put_equilibria(struct buffer *output, const struct system *system,
                    const struct equilibria *found, struct arena *arena);
void reply_equilibrium(const struct system *system, const struct equilibria *found, int k,
                       bool full, struct reply *reply);
/* Pairs once: "-0.1 +- 1.4i, -3". */
void put_eigenvalues(struct buffer *output, const struct solution *solution);

/* ---- shared.c ---- */

/* Takes NAME= off an argument: the parser's rest becomes the value. Returns false if there is none.
 */
bool take_equals(struct parser *parser, struct text argument, struct text name);
/* Takes NAME= of a variable off an argument, and returns which variable; -1 with `error` filled, in
 * which `example` shows a value. */
int read_variable(struct parser *parser, struct text argument, const struct system *system,
                  const char *command, const char *example, struct error *error);

/* A table of results: memory of each of its columns is NULL if it is out. */
enum { TABLE_BUILDER_COLUMNS = 2 * DYNAMICS_VARIABLES + 6 };
struct table_builder {
    struct arena arena;
    struct table_column *column;
    size_t rows; /* set before */
    int count;
    bool failed;
};
double *table_add_reals(struct table_builder *builder, const char *name, const char *suffix,
                        enum quantity quantity);
const char **table_add_texts(struct table_builder *builder, const char *name);
/* Makes it the last table of its kind, unless memory is out, and frees what is left. */
void table_finish(struct table_builder *builder, struct reply *reply, const char *kind);

/* Values by their names, in SI, as an object of the record. */
void reply_state(struct reply *reply, const struct system *system, const char *key,
                 const double *state);
/* An exponent [1/s] as an object of the array that is open. */
void reply_exponent(struct reply *reply, double value, double uncertainty);
/* Puts "NAME = VALUE" of variable i. */
void put_variable(struct buffer *output, const struct system *system, int i, double value,
                  int digits);
/* "-1 m .. 1 m" */
const char *shown_range(struct value_text *text, double begin, double end, enum quantity quantity,
                        int digits);
#define SHOWN_RANGE(from, to, quantity, digits)                                                    \
    shown_range(&(struct value_text){""}, from, to, quantity, digits)
void reply_stable(struct reply *reply, const struct solution *s, bool family);
void reply_values(struct reply *reply, const char *key, const struct solution *solution);
/* Lists equilibria, orbits, branches, points (kept.c). Returns false if out of memory. */
bool dynamics_list_equilibria(struct session *session, struct arena *arena, struct reply *reply);
bool dynamics_list_orbits(struct session *session, struct arena *arena, struct reply *reply);
bool dynamics_list_branches(struct session *session, struct arena *arena, struct reply *reply);
bool dynamics_list_points(struct session *session, struct arena *arena, struct reply *reply);
/* The points that a branch keeps as a table for people, and their records. */
void put_points(const struct session *session, const struct kept_branch *const *branch, int count,
                struct arena *arena, struct buffer *output);
void reply_points(const struct session *session, const struct kept_branch *branch,
                  struct reply *reply);
/* Solution that is stored under a number or a label, with the scene in which it was found. */
struct kept_reference {
    const struct kept_orbit *orbit;
    const struct kept_branch *branch; /* set with `point` if a label was given */
    const struct kept_point *point;
    struct solution solution;
    struct scene scene; /* scene with the parameters of the solution */
};
/* number NULL: the first equilibrium, the last orbit. */
bool find_equilibrium(const struct session *session, const struct dynamics *dynamics,
                      const struct item *number, struct kept_reference *found, struct error *error);
bool find_orbit(const struct session *session, const struct dynamics *dynamics,
                const struct item *number, struct kept_reference *found, struct error *error);
bool find_label(const struct session *session, const struct dynamics *dynamics, struct text label,
                struct kept_reference *found, struct error *error);
/* Sets state, t and span of the request: the end of the current run if that is one of the scene's
 * model and did not fail, else the scene's start. Returns which, in words (orbit.c). */
const char *orbit_begin(const struct session *session, const struct system *system,
                        struct orbit_request *request);
/* Names of the solvers of equilibria and flows, which do not depend on the session's method. */
#define NEWTON_SOLVER "bounds of the equations and Newton's method"
#define FLOW_SOLVER "dop853, or radau5 where that needs too many steps, with its own tolerances"
/* Adds a line that says so where the user has chosen a method, a step or a tolerance. */
void reply_own_solver(const struct session *session, const char *solver, struct reply *reply);
/* ", 12 ms", where times are shown. */
void put_seconds(struct buffer *output, const struct session *session, double seconds);
/* `use` of what is no run. */
bool use_kept(HANDLER_PARAMETERS);

/* Finds the largest exponent of a run or a recording, as it was named (lyapunov_series.c). */
bool lyapunov_of_series(struct session *session, const struct arguments *args, struct reply *reply,
                        struct error *error);
