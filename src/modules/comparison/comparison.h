/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the commands of comparison share, and what they keep. */
#pragma once

#include <hooke/command/handler.h>
#include "modules/comparison/compute/compare.h"

extern const struct module comparison_module;

/* Of the argument of `stress` (stressed_type.c): methods, and the names of its cases. */
extern const struct argument_type_row stressed_type;

/* What the module keeps in a session. */
struct comparison_part {
    struct precision *precision;  /* the last study, for `plot precision`; NULL if there is none */
    struct references references; /* of the scenes that were studied last */
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
/* One table a method, or that of one method only (NULL: of all); a wide one has more columns. */
void precision_tables(const struct precision *precision, const struct method *only, int width,
                      struct arena *arena, struct buffer *output);
/* One line a method: its slope, and what it costs at best. */
void precision_overview(const struct precision *precision, struct buffer *output);
/* The fastest methods for errors that are `step` decades apart; all: with what is fewest, and what
 * is not ranked. */
void precision_winners(const struct precision *precision, int step, bool all, int width,
                       struct arena *arena, struct buffer *output);
/* "a euler  b verlet …", in lines of that width. */
void precision_legend(const struct precision *precision, int width, struct buffer *output);
/* Records of points, and of the fastest for each error. */
void reply_precision(const struct session *session, const struct precision *precision,
                     struct arena *arena, struct reply *reply);
