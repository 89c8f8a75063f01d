/* SPDX-License-Identifier: GPL-3.0-or-later */
/* complete: declarations shared by the files of src/command/complete, which complete the text of a
 * statement. command_complete() (<hooke/command.h>) is their entry. */
#pragma once

#include <hooke/command/handler.h>
#include <hooke/language/complete.h>

/* ---- candidates of each kind ---- */

/* Completes the arguments of `atol`: variables of the scene or, if `named`, that is, if a variable
 * precedes the word at the cursor, values of its tolerance. */
void complete_atol(struct completion *c, bool named);
void complete_topics(struct completion *c); /* Offers the topics of help. */
/* Completes the value of the parameter or setting `name`: units, or the choices of the setting.
 * `preceding` is the text to the left of the word at the cursor, here and below. */
void complete_set(struct completion *c, struct text name, struct text preceding);

/* ---- position of the cursor ---- */

/* Returns the last word of the text. */
struct text last_word(struct text preceding);
/* Returns the number of words of the text. */
int count_words(struct text text);
/* Completes the word at the cursor by the words, keys and options that may come next in the
 * command, and by items of its next positional argument. */
void complete_next(struct completion *c, const struct command *command, struct text preceding);
/* Sets *name to the NAME of the last `NAME=` in the text before the cursor, or to an empty text if
 * there is none. Returns true if the word at the cursor is an item of that argument, because the
 * character before it is '=', a comma or a colon. */
bool complete_is_item(struct text preceding, struct text *name);
/* Completes NAME=FROM:TO, where NAME is a parameter of the scene, dt or tol. */
void complete_grid(struct completion *c, const struct command *command, struct text preceding);

/* Completes a statement that defines a part of a scene or an event; `rest` is the text between the
 * command's name and the word at the cursor. */
void complete_formula(struct completion *c, const struct command *command, struct text rest);
