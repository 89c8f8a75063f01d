/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is wrong with a recording, as a table and as a record. */
#ifndef HOOKE_COMMAND_FINDINGS_H
#define HOOKE_COMMAND_FINDINGS_H

#include "internal.h"

/* Looks at the recording if nobody has yet. */
bool find_faults(struct recording *recording, struct arena *arena, struct error *error);
/*
 * Which part of a subject is the free oscillation: the one judgement of it, that of 'data clean', in words for every
 * command that works on a window. Nothing where the whole of it is.
 */
enum window_law { WINDOW_LAW_SINE, WINDOW_LAW_STICKS /* it knows what rests */ };

struct window_advice {
    char text[200]; /* "": none */
};

void advise_window(const struct subject *subject, enum window_law law, struct arena *arena,
                   struct window_advice *advice);
void reply_advice(const struct subject *subject, struct arena *arena, struct reply *reply); /* as a warning */

/* The table, then what was done or would be done. */
void reply_findings(const struct recording *recording, struct arena *arena, struct reply *reply);

#endif
