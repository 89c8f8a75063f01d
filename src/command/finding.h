/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_FINDING_H
#define HOOKE_COMMAND_FINDING_H

#include <hooke/base.h>

/* words of the field and of other programs: what to type */
extern const struct catalog word_catalog;

/* Of an error about a word that is not known where it stands: says in the hint, in the place of
 * guesses, what has this name elsewhere, or what is meant by it. */
void explain_unknown(struct text statement, struct error *error);

bool mentions(const char *where, struct text word); /* as letters, upper or lower case; NULL: no */

#endif
