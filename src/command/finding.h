/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_FINDING_H
#define HOOKE_COMMAND_FINDING_H

#include <hooke/command.h>

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

bool mentions(const char *where, struct text word); /* as letters, upper or lower case; NULL: no */

#endif
