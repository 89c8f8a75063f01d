/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A sweep as text: table, curve, heat map; and as a table to be written. */
#ifndef HOOKE_COMMAND_SWEEP_TEXT_H
#define HOOKE_COMMAND_SWEEP_TEXT_H

#include "export.h"

/* What was swept, with the names of its measures. */
struct swept {
    const struct sweep *sweep;
    const struct sweep_measure *measure;
    const struct model *model;
};

void sweep_text(const struct session *session, const struct swept *swept, struct arena *arena, struct buffer *text);
/* Columns: point, the axes, the measures, status. */
bool sweep_table(const struct swept *swept, struct export *export, struct error *error);

#endif
