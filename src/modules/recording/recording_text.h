/* SPDX-License-Identifier: GPL-3.0-or-later */
#pragma once

#include "modules/recording/table/load.h"
#include <hooke/command.h>

/* Describes a recording in the reply's format. */
void reply_recording(const struct recording *recording, struct reply *reply);

/* Its description as lines, its warnings as warnings. */
void reply_description(const struct recording *recording, struct reply *reply);

/* `list formats` and `list recordings`. Return true. */
bool recording_list(struct session *session, struct arena *arena, struct reply *reply);
bool recording_list_formats(struct session *session, struct arena *arena, struct reply *reply);
