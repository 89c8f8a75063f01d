/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings of a hand-in whose own files are not here. */
#pragma once

#include "modules/recording/table/load.h"

#define HANDED_IN "hand-in" /* format of a recording that was taken from an export */

/* Returns the recording that a hand-in loads from path. `here` is the recording that path holds on
 * this machine, or NULL; it is released if the hand-in has a copy of another file
 * (recording-N-NAME), which is taken instead. Without either, the values in recording-N.csv are
 * taken, as far as the window of the hand-in reached. Returns NULL if the folder has neither. */
struct recording *recording_checked(const char *folder, const char *path,
                                    const struct load_options *options, struct recording *here);
