/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Words that follow a number, where a unit would be, and are none. */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/quantity.h>

struct expr_scope;

/* Returns the word at the start of a text as a unit would be written: um, km/h, cm^3. It ends
 * before the other operators: um of um-4.14cm. */
struct text unit_word(struct text text);
/* Reports that the word after a number is no unit, with what it could be: a name or a function to
 * multiply by, a unit that is spelled out, or one with a similar name. Lists the units of the
 * quantity unless that is QUANTITY_OTHER. Returns false. */
bool refuse_unit_word(const struct expr_scope *scope, struct text word, struct text number,
                      enum quantity quantity, struct error *error);
