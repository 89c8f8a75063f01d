/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion: what there is of each kind. */
#pragma once

#include <hooke/language.h>
#include <hooke/session/events.h>

struct catalog;

struct completion {
    struct session *session;
    struct text word; /* part of the word before the cursor */
    void (*offer)(void *context, const char *candidate, const char *brief);
    void *context;
    /* Ending of the files that are possible there, "" for any; NULL if no name of a file is
     * possible. */
    const char *file;
};

void complete_offer(struct completion *c, const char *candidate, const char *brief);
void complete_affixed(struct completion *c, const char *prefix, const char *name,
                      const char *suffix, const char *brief);
void complete_catalog(struct completion *c, const struct catalog *catalog);
void complete_units(struct completion *c, enum quantity quantity); /* QUANTITY_OTHER for all */
void complete_settable(struct completion *c);
void complete_names(struct completion *c);    /* names with a value in expressions */
void complete_operands(struct completion *c); /* these and functions */
/* Offers state variables and observables of the current run, or of the one that the scene would
 * give, except for names in `besides`, which may be NULL. */
void complete_columns(struct completion *c, const struct catalog *besides);
void complete_events(struct completion *c); /* offers the events that are watched for */
/* Completes one item of this type; `preceding` is the text to the left of the word. */
void complete_item(struct completion *c, const struct argument *argument, struct text preceding);

char last_letter(struct text text); /* ignores blanks; returns 0 if there is none */
bool ends_in_digit(struct text preceding);
/* The value that stands before the word ends in an operator, or inside of parentheses. */
bool value_is_open(struct text value);
/*
 * Inside of an expression of which `value` stands before the word: `names` where an operand can
 * stand, units of the quantity after a number, nothing after another operand. The word becomes its
 * part behind the last operator.
 */
void complete_value(struct completion *c, struct text value, enum quantity quantity,
                    void (*names)(struct completion *c));
