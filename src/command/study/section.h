/* SPDX-License-Identifier: GPL-3.0-or-later */
/* 'at EVENT' of a sweep. */
#ifndef HOOKE_COMMAND_STUDY_SECTION_H
#define HOOKE_COMMAND_STUDY_SECTION_H

#include <hooke/scene/formula.h>
#include <hooke/session/names.h>
#include <hooke/study/sweep.h>

struct arguments;

/* Of the rest of a statement that begins with 'at': what stands behind it, up to an option or
 * skip=, keep=, measure=. */
struct text next_section(struct text *rest);
bool read_section(struct session *session, const struct arguments *args, struct text text,
                  struct sweep_section *section, struct error *error);
/* Once all is read (skip and keep < 0: not given): columns where none were named, limits. */
bool finish_section(struct sweep_request *request, bool measured, struct error *error);
/* The expression in the slots of a sweep: what does not depend on the point is a number. NULL: no
 * memory. */
const struct expr *expr_of_point(const struct expr *expr, struct expr_scope *scope,
                                 struct arena *arena, struct error *error);

#endif
