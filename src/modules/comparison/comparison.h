/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the commands of the module comparison share, and the data that the module keeps in
 * a session. */
#pragma once

#include <hooke/command/handler.h>
#include "modules/comparison/compute/compare.h"

extern const struct module comparison_module; /* row of the module (comparison.c) */

/* Type of the argument METHOD|CASE of `stress`: names of methods and of cases (stressed_type.c). */
extern const struct argument_type_row stressed_type;

/* Data that the module keeps in a session, from one command to the next. */
struct comparison_part {
    /* the latest precision study, for `plot precision`, or NULL if there is none; owned */
    struct precision *precision;
    struct references references; /* reference solutions of the scenes that were studied last */
};

/* Returns the references that are kept between studies. Returns NULL if out of memory: the study
 * then computes its reference and does not store it. */
struct references *session_references(const struct session *session);
/* Returns the last precision study, which the session owns, or NULL if none was made. */
const struct precision *session_precision(const struct session *session);

/* Fills in the methods that the statement names, or keeps those in choice [*count] if it names
 * none. Each gets the drag variant `usual` if it has that variant, otherwise its own. One drag=
 * holds for all methods that know it, and for a method alone; several hold for one method each.
 * choice has room for the named methods. Returns false with an error if the numbers of methods and
 * variants differ. */
bool choose_methods(const struct arguments *args, enum drag usual, struct method_choice *choice,
                    int *count, struct error *error);
/* Makes the list of methods of a plot from rows of the method catalog, each with its own drag
 * variant. If *count is 0, the list holds the session's method with its drag, and *count becomes 1.
 * Memory is from the arena; returns NULL if out of memory. */
struct method_choice *methods_choice(const struct session *session, const struct row *const *method,
                                     int *count, struct arena *arena);

/* Drops methods that are named twice with the same drag, with a note in the reply. Returns how many
 * are left. */
int drop_repeated(struct method_choice *choice, int count, struct reply *reply);

/* Number of rows of an answer below which notes are left out in favour of results. */
enum { SMALL_ANSWER_ROWS = 16 };

/* ---- a precision study in text (precision_text.c, figure.c) ---- */

/* Returns the letter that stands for a curve in tables and in the diagram: a to z, then A to Z,
 * then '?'. */
char precision_letter(int curve);
/* Draws the work-precision diagram into *figure: errors over times, both logarithmic, or over
 * evaluations where nothing was timed. Memory is from the arena. Returns false with an error if out
 * of memory. */
bool precision_figure(const struct precision *precision, struct arena *arena, struct figure *figure,
                      struct error *error);
/* Appends one table of points per method, or only that of the method `only` unless it is NULL. A
 * width [cells] of 110 and more has more columns. Appends nothing if out of memory. */
void precision_tables(const struct precision *precision, const struct method *only, int width,
                      struct arena *arena, struct buffer *output);
/* Appends one line per method: its letter, name, number of settings and slope. */
void precision_overview(const struct precision *precision, struct buffer *output);
/* Appends a table with the fastest methods for errors that are `step` decades apart. With `all`, it
 * also has the methods with the fewest evaluations and those that are not ranked. `width` is in
 * cells; memory is from the arena. Appends nothing if out of memory. */
void precision_winners(const struct precision *precision, int step, bool all, int width,
                       struct arena *arena, struct buffer *output);
/* Appends the letters of all curves with their methods, as in "a euler  b verlet", in lines of
 * `width` [cells]. */
void precision_legend(const struct precision *precision, int width, struct buffer *output);
/* Adds to the reply the records of all points, and of the fastest method for each error, and stores
 * the points as a result that `plot` and `list` find. Adds nothing if out of memory. */
void reply_precision(const struct session *session, const struct precision *precision,
                     struct arena *arena, struct reply *reply);
