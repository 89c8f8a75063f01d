/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Executed lines: the session's list, and the file that `record` appends to. */
#ifndef HOOKE_COMMAND_HISTORY_H
#define HOOKE_COMMAND_HISTORY_H

#include "internal.h"

#define HISTORY_MOST 5000

void history_add(struct session *session, struct text line);
/* Appends the statement to the file of `record`, if there is one; a failure ends the recording. */
bool history_record(struct session *session, struct text statement, struct error *error);
bool history_open(struct session *session, const char *path, struct error *error);
void history_close(struct session *session);

#endif
