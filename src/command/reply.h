/* SPDX-License-Identifier: GPL-3.0-or-later */
/* How the interpreter brackets what a command says. */
#ifndef HOOKE_COMMAND_REPLY_H
#define HOOKE_COMMAND_REPLY_H

#include "internal.h"

void reply_command_begin(struct reply *reply, enum output_format format);
/* Lines of a command that made no record: as {kind, text}, or as comments of the CSV. */
void reply_command_end(struct reply *reply, const char *kind);

#endif
