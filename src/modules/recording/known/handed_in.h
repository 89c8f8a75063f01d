/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings of a hand-in whose original files are not on this machine. */
#pragma once

#include "modules/recording/table/load.h"

/* Format name of a recording that was read from an export. */
#define HANDED_IN "hand-in"

/* Returns the recording that a hand-in loads from `path`. `here` is the recording that this path
 * has on this machine, or NULL; it is destroyed if the hand-in contains a copy of another file
 * (recording-N-NAME), which is used instead. Without either, the values in recording-N.csv are
 * used, which cover the windows of the hand-in. Returns NULL if the folder has neither. */
struct recording *recording_checked(const char *folder, const char *path,
                                    const struct load_options *options, struct recording *here);
