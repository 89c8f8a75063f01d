/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the commands of comparison share, and the data that they keep. */
#pragma once

#include <hooke/command/handler.h>
#include "modules/comparison/compute/compare.h"

extern const struct module comparison_module;

/* Type of the argument of `stress` (stressed_type.c): methods, and the names of its cases. */
extern const struct argument_type_row stressed_type;

/* Data that the module keeps in a session. */
struct comparison_part {
    /* the latest study, for `plot precision`, or NULL if there is none */
    struct precision *precision;
    struct references references; /* references of the scenes that were studied last */
};

/* Returns the references that are kept between studies, or NULL if out of memory: none are then. */
struct references *session_references(const struct session *session);
/* Returns the last precision study, or NULL if none was made. */
const struct precision *session_precision(const struct session *session);

/*
 * Takes the methods that the statement names in the place of those in choice [*count], with the
 * drag `usual` where they know it. One drag= holds for all that know it, and for a method alone;
 * several hold for one method each.
 */
bool choose_methods(const struct arguments *args, enum drag usual, struct method_choice *choice,
                    int *count, struct error *error);
/* The same for a plot, where rows of methods are given, or with *count 0 the present one is taken.
 * Returns NULL if out of memory. */
struct method_choice *methods_choice(const struct session *session, const struct row *const *method,
                                     int *count, struct arena *arena);

/* Drops choices that are made twice, and says so. Returns how many are left. */
int drop_repeated(struct method_choice *choice, int count, struct reply *reply);

/* Moves lines to the text, those that are too wide on several. */
void put_folded_lines(struct buffer *lines, int width, struct buffer *text);

/* ---- a precision study in text (precision_text.c, figure.c) ---- */

/* Letter of a curve in tables and figure. */
char precision_letter(int curve);
/* Error over time, both logarithmic (over evaluations where nothing was timed); memory from the
 * arena. */
bool precision_figure(const struct precision *precision, struct arena *arena, struct figure *figure,
                      struct error *error);
/* Appends one table per method, or that of `only` unless it is NULL; a wide table has more
 * columns. */
void precision_tables(const struct precision *precision, const struct method *only, int width,
                      struct arena *arena, struct buffer *output);
/* Appends one line per method: its slope, and its cost at best. */
void precision_overview(const struct precision *precision, struct buffer *output);
/* Appends the fastest methods for errors that are `step` decades apart. With `all`, also the
 * methods with the fewest evaluations, and those that are not ranked. */
void precision_winners(const struct precision *precision, int step, bool all, int width,
                       struct arena *arena, struct buffer *output);
/* "a euler  b verlet …", in lines of that width. */
void precision_legend(const struct precision *precision, int width, struct buffer *output);
/* Records of points, and of the fastest for each error. */
void reply_precision(const struct session *session, const struct precision *precision,
                     struct arena *arena, struct reply *reply);
