/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is wrong with a recording, as a table and as a record. */
#ifndef HOOKE_COMMAND_FINDINGS_H
#define HOOKE_COMMAND_FINDINGS_H

#include "internal.h"

/* Looks at the recording if nobody has yet. */
bool find_faults(struct recording *recording, struct arena *arena, struct error *error);
/* The table, then what was done or would be done. */
void reply_findings(const struct recording *recording, struct arena *arena, struct reply *reply);

#endif
