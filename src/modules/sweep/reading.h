/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading of `at EVENT` (reading_section.c) and `measure=` (reading_measures.c) of a sweep's
 * statement. finish_section() is called after everything else is read. */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/session/names.h>
#include "modules/sweep/compute/sweep.h"

struct arguments;
struct parser;

/* Removes `at EVENT` from the begin of *rest and returns the event's text, which ends before an
 * option or skip=, keep=, measure=. */
struct text next_section(struct text *rest);
/* Reads the text of an event: the word `period`, the name of an event of the session, or an
 * expression. Returns false with an error, which points into the text. */
bool read_section(struct session *session, const struct arguments *args, struct text text,
                  struct sweep_section *section, struct error *error);
/* Completes the request's section and checks it: usual values of skip and keep where they were not
 * given (< 0), all variables as measures unless `measured`. Returns false with an error if limits
 * or measures do not suit a section. */
bool finish_section(struct sweep_request *request, bool measured, struct error *error);
/* Returns the slot of a sweep that corresponds to a slot of names_scope(), or a negative number if
 * the value does not depend on the point. */
int slot_of_point(const struct expr_scope *scope, int slot);
/* Reads the list of measures behind `measure=` into the request. Returns false with an error, which
 * points into the text. */
bool read_measures(struct parser *parser, struct sweep_request *request, struct error *error);
