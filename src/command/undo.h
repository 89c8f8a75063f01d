/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Moving between snapshots: undo, redo, checkpoint, restore. */
#ifndef HOOKE_COMMAND_UNDO_H
#define HOOKE_COMMAND_UNDO_H

#include "internal.h"

/* One step back (or forward again). label: the command that was undone. */
bool undo_move(struct session *session, bool back, char label[LIMIT_NAME + 1], struct error *error);
bool checkpoint_make(struct session *session, const char *name, struct error *error);
/* The latest one where name is empty. *label: its name, owned by the session. */
bool checkpoint_restore(struct session *session, struct text name, const char **label, struct error *error);
const char *snapshot_label(const struct snapshot *snapshot);

#endif
