/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Statements without abbreviations, for the history and for files. */
#pragma once

#include <hooke/command/handler.h>

/* Returns true if the statement does nothing but write a file that it may replace (it has a FILE
 * and the option --force). */
bool writes_file(const struct arguments *arguments);
/* Appends the statement without abbreviations, with --force if the user has confirmed it. */
void statement_in_full(const struct session *session, const struct arguments *arguments,
                       struct text statement, struct buffer *output);
