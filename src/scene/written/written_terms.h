/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Single terms of what is written. */
#ifndef HOOKE_SCENE_WRITTEN_TERMS_H
#define HOOKE_SCENE_WRITTEN_TERMS_H

#include <hooke/scene/written.h>

/* What a term adds to a row; *expr NULL: nothing. */
bool written_term_row(struct written *written, const struct bound_term *term, int row,
                      bool as_typed, const struct expr **expr, struct error *error);
/* A text of a built-in term. NULL: error. */
const struct expr *written_slope_text(struct written *written, const char *text,
                                      struct error *error);

#endif
