/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The transcript of a session: every statement that it came from, as a script that a new session
 * can read. What sourced files held stands there itself, names that were abbreviated stand there in
 * full, and commands that only wrote a file are left out.
 */
#ifndef HOOKE_COMMAND_STORY_H
#define HOOKE_COMMAND_STORY_H

#include "command/internal.h"

/* A statement is over. at: length of the transcript when it began: what was typed while it went on
 * comes after it. */
void transcript_add(struct session *session, const struct arguments *arguments,
                    struct text statement, bool nested, bool ok, size_t at);

#endif
