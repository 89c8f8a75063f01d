/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings of a hand-in whose own files are not here. */
#ifndef HOOKE_COMMAND_HANDED_IN_H
#define HOOKE_COMMAND_HANDED_IN_H

#include <hooke/data.h>

#define HANDED_IN "hand-in" /* format of such a recording */

/* What the folder's recording-N.csv holds of the file of that name, as it was in it: as far as the
 * window of the hand-in reached. NULL: it holds nothing of it; *error is left alone. */
struct recording *recording_handed_in(const char *folder, const char *path,
                                      const struct load_options *options);

#endif
