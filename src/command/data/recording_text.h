/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_DATA_RECORDING_TEXT_H
#define HOOKE_COMMAND_DATA_RECORDING_TEXT_H

#include <hooke/data.h>
#include <hooke/command.h>

/* What a recording is, in the reply's format. */
void reply_recording(const struct recording *recording, struct reply *reply);

/* Its description as lines, its warnings as warnings. */
void reply_description(const struct recording *recording, struct reply *reply);

#endif
