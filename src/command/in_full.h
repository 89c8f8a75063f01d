/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A statement as a file has to say it. */
#pragma once

#include <hooke/command/handler.h>

/* All it does is to write a file that it may replace. */
bool writes_file(const struct arguments *arguments);
/* Writes the statement without abbreviations, with the consent that was given. */
void statement_in_full(const struct session *session, const struct arguments *arguments,
                       struct text statement, struct buffer *output);
