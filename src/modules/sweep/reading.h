/* SPDX-License-Identifier: GPL-3.0-or-later */
/* 'at EVENT' and 'measure=' of a sweep. */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/session/names.h>
#include "modules/sweep/compute/sweep.h"

struct arguments;
struct parser;

/* Takes the text of a section off a statement that begins with 'at': what follows up to an option
 * or skip=, keep=, measure=. */
struct text next_section(struct text *rest);
bool read_section(struct session *session, const struct arguments *args, struct text text,
                  struct sweep_section *section, struct error *error);
/* Once all is read (skip and keep < 0: not given): columns where none were named, limits. */
bool finish_section(struct sweep_request *request, bool measured, struct error *error);
/* A slot of names_scope() as one of a sweep: < 0 where it does not depend on the point. */
int slot_of_point(const struct expr_scope *scope, int slot);
/* measure=A,B,.. (reading_measures.c) */
bool read_measures(struct parser *parser, struct sweep_request *request, struct error *error);
