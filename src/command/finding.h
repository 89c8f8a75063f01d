/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Hints for errors about unknown words: the interpreter calls explain_unknown(), which uses the
 * other functions (finding.c, taking.c, rewriting.c). */
#pragma once

#include <hooke/command.h>

struct catalog;

/* Words of the field and of other programs, with what to type in their place. */
extern const struct catalog word_catalog;

/* Replaces the guesses in the hint of an error about an unknown word. The new hint names the things
 * elsewhere that have this name, or its probable meaning, and the commands that take it. */
void explain_unknown(const struct session *session, struct text statement, struct error *error);

/* Appends how the command takes a word typed in that form, such as `steps=5` for --steps, or at
 * most `most` other commands that take it as a name or as a choice. Returns false if the command
 * takes it in that form, or if none does. `command` may be NULL. */
bool put_takers(const struct command *command, struct text word, enum argument_form form, int most,
                struct buffer *text);

/* Appends the statement in this program's notation, if its first word is no command because it is
 * written as in another program. Returns false if it has no such form. */
bool put_rewritten(const struct session *session, struct text statement, struct buffer *text);
/* Appends a row's text in which NAME, VALUE and EXPR are replaced by what the statement has for
 * them, as in `par a=1` and `disp(k)`. */
void put_filled(const char *brief, struct text statement, struct buffer *text);
/* Returns the name before the parentheses, such as ode45 of [t,y] = ode45(f), or {NULL, 0} if
 * nothing is called. */
struct text called_word(struct text statement);
/* Appends how to define a name that an expression does not know: by param in a scene's law, else by
 * let. Appends nothing if the name cannot be used. */
void put_named(const struct session *session, bool law, struct text name, struct buffer *text);

/* Returns true if `where` contains the letters of the word, upper or lower case; false if NULL. */
bool text_mentions(const char *where, struct text word);
