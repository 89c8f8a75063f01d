/* SPDX-License-Identifier: GPL-3.0-or-later */
/* unit_word: errors about a word that follows a number in the position of a unit and is not a unit
 * (10 sec, 2 pi). */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/quantity.h>

struct expr_scope;

/* Returns the word at the start of a text, spelled as a unit could be: um, km/h, cm^3. It ends
 * before other operators: "um" of "um-4.14cm". Empty if there is none. */
struct text unit_word(struct text text);
/* Sets an error at `word`: it is not a unit, with a hint on what may be meant (a factor to multiply
 * by, a unit that is spelled out, a similar name) and the units of `quantity`, unless that is
 * QUANTITY_OTHER. `number` is the number before it, for the hint; `scope` may be NULL. Always
 * returns false. */
bool refuse_unit_word(const struct expr_scope *scope, struct text word, struct text number,
                      enum quantity quantity, struct error *error);
