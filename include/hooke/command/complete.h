/* SPDX-License-Identifier: GPL-3.0-or-later */
/* complete: declarations shared by the files of src/command/complete, which complete the text of a
 * statement. command_complete() (<hooke/command.h>) is their entry. */
#pragma once

#include <hooke/command/handler.h>
#include <hooke/language/complete.h>

/* ---- candidates of each kind ---- */

/* Completes `atol`: variables of the scene, or values if `named`. */
void complete_atol(struct completion *c, bool named);
void complete_topics(struct completion *c); /* Offers the topics of help. */
/* Completes the value of NAME in `set`: its units, or the choices of the setting. */
void complete_set(struct completion *c, struct text name, struct text preceding);

/* ---- position of the cursor ---- */

/* Returns the last word of the text. */
struct text last_word(struct text preceding);
/* Returns the number of words of the text. */
int count_words(struct text text);
/* Completes the words, keys and options that may come next in the command, and the next positional
 * argument. */
void complete_next(struct completion *c, const struct command *command, struct text preceding);
/* Returns true if the word is an item behind NAME=, or behind a comma or colon after it; sets *name
 * to the last such name, or to the empty text. */
bool complete_is_item(struct text preceding, struct text *name);
/* Completes NAME=FROM:TO for parameters of the scene, dt and tol. */
void complete_grid(struct completion *c, const struct command *command, struct text preceding);

/* Completes a statement that defines a scene or an event; `rest` is the text between the command
 * and the word. */
void complete_formula(struct completion *c, const struct command *command, struct text rest);
