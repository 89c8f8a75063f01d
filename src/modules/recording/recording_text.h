/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings in replies. */
#pragma once

#include "modules/recording/table/load.h"
#include <hooke/command.h>

/* Adds the recording to the reply as a record. */
void reply_recording(const struct recording *recording, struct reply *reply);

/* Adds the recording's description and its warnings to the reply. */
void reply_description(const struct recording *recording, struct reply *reply);

/* Handle `list recordings` and `list formats`. Both return true. */
bool recording_list(struct session *session, struct arena *arena, struct reply *reply);
bool recording_list_formats(struct session *session, struct arena *arena, struct reply *reply);
