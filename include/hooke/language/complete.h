/* SPDX-License-Identifier: GPL-3.0-or-later */
/* complete: functions that offer completions of one kind (units, names, columns, …), for types of
 * arguments and for commands. Each offers those candidates that begin with the word before the
 * cursor. */
#pragma once

#include <hooke/language.h>
#include <hooke/session/events.h>

struct catalog;

/* State of one completion. */
struct completion {
    struct session *session;
    struct text word; /* The part of the word at the cursor that is to the left of the cursor. */
    /* Receives each candidate, with a line of explanation in `brief` or ""; gets `context`. */
    void (*offer)(void *context, const char *candidate, const char *brief);
    void *context; /* First argument of offer(). */
    /* Receives the ending of the files whose names are possible here ("" for any file), or NULL if
     * no file name is possible. The front end completes file names. */
    const char *file;
};

/* Offers a candidate if it begins with c->word. */
void complete_offer(struct completion *c, const char *candidate, const char *brief);
/* Does the same for the candidate made of prefix, name and suffix. */
void complete_affixed(struct completion *c, const char *prefix, const char *name,
                      const char *suffix, const char *brief);
/* Offers the names of all rows. */
void complete_catalog(struct completion *c, const struct catalog *catalog);
/* Offers the units of a quantity; QUANTITY_OTHER stands for all quantities. */
void complete_units(struct completion *c, enum quantity quantity);
/* Offers everything that `set` can change: parameters, derived quantities, settings. */
void complete_settable(struct completion *c);
void complete_names(struct completion *c); /* Offers the names that have a value in expressions. */
void complete_operands(struct completion *c); /* Offers these names, and functions. */
/* Offers state variables and observables of the current run, or of a run of the current scene,
 * except for names in the catalog `besides`, which may be NULL. */
void complete_columns(struct completion *c, const struct catalog *besides);
void complete_events(struct completion *c); /* Offers the names of the events. */
/* Completes an item of the argument's type; `preceding` is the text to the left of the word. */
void complete_item(struct completion *c, const struct argument *argument, struct text preceding);

/* Returns the last character that is no blank, or 0 if there is none. */
char last_letter(struct text text);
/* Returns true if the last character that is no blank is a digit. */
bool ends_in_digit(struct text preceding);
/* Returns true if the text before the word ends in an operator or inside parentheses, so that the
 * value is incomplete. */
bool value_is_open(struct text value);
/* Completes inside an expression; `value` is its text to the left of the word. Calls names() where
 * an operand can follow, offers units of the quantity after a number, and nothing after another
 * operand. Shortens c->word to its part behind the last operator. */
void complete_value(struct completion *c, struct text value, enum quantity quantity,
                    void (*names)(struct completion *c));
