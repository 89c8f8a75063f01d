/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names of columns in a statement, for the type of arguments TYPE_COLUMN. */
#pragma once

#include <hooke/language.h>

/* Returns true if a typed scene, the session's or that of a run, has a variable or an observed
 * expression of this name. */
bool session_has_typed_variable(const struct session *session, struct text name);
/* Returns true if a table that a study left in the session has a column of this name. */
bool session_has_found_column(const struct session *session, struct text name);
/* Returns true if the remaining text of a statement contains the word `of`, outside of strings: the
 * column before it is one of a table. */
bool statement_has_of(struct text rest);
