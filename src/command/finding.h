/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_FINDING_H
#define HOOKE_COMMAND_FINDING_H

#include <hooke/command.h>

struct catalog;

/* words of the field and of other programs: what to type */
extern const struct catalog word_catalog;

/* Of an error about a word that is not known where it stands: says in the hint, in the place of
 * guesses, what has this name elsewhere, or what is meant by it, and which commands take it. */
void explain_unknown(const struct session *session, struct text statement, struct error *error);

/* Appends how the command takes what was typed in that form, `steps=5` for --steps, or which others
 * do, the first `most` of them: as a name, or as a choice. False: it takes it so itself, or none
 * does. command: NULL: none. */
bool put_takers(const struct command *command, struct text word, enum argument_form form, int most,
                struct buffer *text);

/* Appends the statement as it is written here, where its first word is no command because another
 * program writes it so; false: it is not of such a form. */
bool put_rewritten(const struct session *session, struct text statement, struct buffer *text);
/* Appends a row's text with what was typed for NAME, VALUE and EXPR: of `par a=1` and `disp(k)`. */
void put_filled(const char *brief, struct text statement, struct buffer *text);
/* The name before the parentheses: ode45 of [t,y] = ode45(f); {NULL, 0}: nothing is called. */
struct text called_word(struct text statement);
/* Appends how a name that an expression does not know is made: by param in a scene's law, else let.
 */
void put_named(const struct session *session, bool law, struct text name, struct buffer *text);

bool text_mentions(const char *where,
                   struct text word); /* as letters, upper or lower case; NULL: no */

#endif
