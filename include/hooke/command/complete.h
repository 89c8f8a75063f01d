/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations that the parts of completion share. */
#pragma once

#include <hooke/command/handler.h>
#include <hooke/language/complete.h>

/* ---- what there is of each kind ---- */

/* variables of the scene, and how to take them back */
void complete_atol(struct completion *c, bool named);
void complete_topics(struct completion *c); /* topics of help */
/* Completes the value of NAME in `set`: its units if NAME has a unit, or the choices of the
 * setting. */
void complete_set(struct completion *c, struct text name, struct text preceding);

/* ---- where the cursor stands ---- */

struct text last_word(struct text preceding);
int count_words(struct text text);
/* Completes the words, keys and options that may come next in the command, and the next positional
 * argument. */
void complete_next(struct completion *c, const struct command *command, struct text preceding);
/* Returns true where the word is an item behind NAME= or a comma or colon after it; sets *name to
 * the last such name, empty if there is none. */
bool complete_is_item(struct text preceding, struct text *name);
/* NAME=FROM:TO of parameters of the scene, dt and tol. */
void complete_grid(struct completion *c, const struct command *command, struct text preceding);

/* Completes a statement that defines a scene or an event; `rest` is the text between the command
 * and the word. */
void complete_formula(struct completion *c, const struct command *command, struct text rest);
