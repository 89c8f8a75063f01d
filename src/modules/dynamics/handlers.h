/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the commands of the module dynamics share: reading of arguments, output of
 * results. */
#pragma once

#include "modules/dynamics/dynamics_results.h"
#include <hooke/command/handler.h>

/* Writes the table of equilibria for people (equilibria.c). */
void put_equilibria(struct buffer *output, const struct system *system,
                    const struct equilibria *found, struct arena *arena);
/* Adds the record of equilibrium k; with `full` it has index and eigenvectors. */
void reply_equilibrium(const struct system *system, const struct equilibria *found, int k,
                       bool full, struct reply *reply);
/* Appends the eigenvalues or multipliers with pairs written once: "-0.1 +- 1.4i, -3". */
void put_eigenvalues(struct buffer *output, const struct solution *solution);

/* ---- arguments and output (shared.c) ---- */

/* Reads "NAME =" at the beginning of an argument, so that the parser's rest is the value. Returns
 * false if there is no "=". */
bool take_equals(struct parser *parser, struct text argument, struct text name);
/* Reads "NAME=" of a variable at the beginning of an argument, so that the parser's rest is the
 * value. Returns the index of the variable, or -1 with *error, which shows `example`. */
int read_variable(struct parser *parser, struct text argument, const struct system *system,
                  const char *command, const char *example, struct error *error);

/* A table of results that is being built. Set `rows`, add columns and fill those that are not NULL,
 * then call table_finish(). */
enum { TABLE_BUILDER_COLUMNS = 2 * DYNAMICS_VARIABLES + 6 };
struct table_builder {
    struct arena arena;
    struct table_column *column;
    size_t rows; /* set before the first column is added */
    int count;   /* number of columns so far */
    bool failed; /* memory ran out, or the table is not wanted any more */
};
/* Adds a column of numbers, called name and suffix. Returns its [rows], or NULL if out of
 * memory. */
double *table_add_reals(struct table_builder *builder, const char *name, const char *suffix,
                        enum quantity quantity);
/* Adds a column of texts. Returns its [rows], or NULL if out of memory. */
const char **table_add_texts(struct table_builder *builder, const char *name);
/* Stores the table as the last one of its kind, unless it has failed, and frees what memory is
 * left. */
void table_finish(struct table_builder *builder, struct reply *reply, const char *kind);

/* Adds the state as an object `key` of the record: values by the names of variables, in SI. */
void reply_state(struct reply *reply, const struct system *system, const char *key,
                 const double *state);
/* Adds an exponent [1/s] as an object of the open array. */
void reply_exponent(struct reply *reply, double value, double uncertainty);
/* Appends "NAME = VALUE" for variable i. */
void put_variable(struct buffer *output, const struct system *system, int i, double value,
                  int digits);
/* Returns "-1 m .. 1 m", which is written into *text. */
const char *shown_range(struct value_text *text, double begin, double end, enum quantity quantity,
                        int digits);
#define SHOWN_RANGE(from, to, quantity, digits)                                                    \
    shown_range(&(struct value_text){""}, from, to, quantity, digits)
/* Adds the key `stable` to the record: null if unknown, or neutral as in a family. */
void reply_stable(struct reply *reply, const struct solution *s, bool family);
/* Adds the eigenvalues or multipliers as an array of pairs (real, imaginary). */
void reply_values(struct reply *reply, const char *key, const struct solution *solution);
/* Lists equilibria, orbits, branches, points (dynamics_lists.c). Returns false if out of memory. */
bool dynamics_list_equilibria(struct session *session, struct arena *arena, struct reply *reply);
bool dynamics_list_orbits(struct session *session, struct arena *arena, struct reply *reply);
bool dynamics_list_branches(struct session *session, struct arena *arena, struct reply *reply);
bool dynamics_list_points(struct session *session, struct arena *arena, struct reply *reply);
/* Appends a table of the special points of `count` branches. */
void put_points(const struct session *session, const struct stored_branch *const *branch, int count,
                struct arena *arena, struct buffer *output);
/* Adds a record for each special point of a branch. */
void reply_points(const struct session *session, const struct stored_branch *branch,
                  struct reply *reply);
/* A stored solution that was named by a number or a label, with the scene in which it was found. */
struct stored_solution {
    const struct stored_orbit *orbit;
    const struct stored_branch *branch; /* set with `point` if a label was given */
    const struct stored_point *point;
    struct solution solution;
    struct scene scene; /* scene with the parameters of the solution */
};
/* Finds a stored equilibrium or orbit by its number (NULL takes the first equilibrium, the last
 * orbit), or a special point by its label. Returns false with *error and a hint if there is
 * none. */
bool find_equilibrium(const struct session *session, const struct dynamics *dynamics,
                      const struct item *number, struct stored_solution *found,
                      struct error *error);
bool find_orbit(const struct session *session, const struct dynamics *dynamics,
                const struct item *number, struct stored_solution *found, struct error *error);
bool find_label(const struct session *session, const struct dynamics *dynamics, struct text label,
                struct stored_solution *found, struct error *error);
/* Sets state, t and span of the request: the end of the current run if that has the scene's model
 * and did not fail, else the scene's start. Returns in words which of the two (orbit.c). */
const char *orbit_begin(const struct session *session, const struct system *system,
                        struct orbit_request *request);
/* Names of the solvers of equilibria and flows, which do not depend on the session's method. */
#define NEWTON_SOLVER "bounds of the equations and Newton's method"
#define FLOW_SOLVER "dop853, or radau5 where that needs too many steps, with its own tolerances"
/* Tells that `solver` was used if the user has chosen a method, a step or a tolerance. */
void reply_own_solver(const struct session *session, const char *solver, struct reply *reply);
/* Appends ", 12 ms" if times are to be shown. */
void put_seconds(struct buffer *output, const struct session *session, double seconds);
/* Handler of `use` for labels, orbits and equilibria: takes their parameters and state into the
 * scene. */
bool use_stored_solution(HANDLER_PARAMETERS);

/* Finds and replies the largest Lyapunov exponent of the run or recording that the arguments name
 * (lyapunov_series.c). Returns false with *error. */
bool lyapunov_of_series(struct session *session, const struct arguments *args, struct reply *reply,
                        struct error *error);
