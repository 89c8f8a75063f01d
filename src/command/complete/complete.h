/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the parts of completion share. */
#ifndef HOOKE_COMMAND_COMPLETE_COMPLETE_H
#define HOOKE_COMMAND_COMPLETE_COMPLETE_H

#include "command/internal.h"

struct completion {
    struct session *session;
    struct text word; /* what stands before the cursor of the word */
    void (*offer)(void *context, const char *candidate, const char *brief);
    void *context;
    bool wants_file;
};

/* ---- what there is of each kind (complete_items.c) ---- */

void complete_offer(struct completion *c, const char *candidate, const char *brief);
void complete_affixed(struct completion *c, const char *before, const char *name, const char *after,
                      const char *brief);
void complete_catalog(struct completion *c, const struct catalog *catalog);
void complete_units(struct completion *c, enum quantity quantity); /* QUANTITY_OTHER: all */
void complete_settable(struct completion *c);
void complete_atol(struct completion *c,
                   bool named);            /* variables of the scene, and how to take them back */
void complete_names(struct completion *c); /* with a value in expressions */
void complete_operands(struct completion *c); /* these and functions */
/* State variables and observables of the current run, or of the one that the scene would give; not
 * what stands in `besides`, too (NULL: nothing). */
void complete_columns(struct completion *c, const struct catalog *besides);
void complete_events(struct completion *c); /* what is watched for */
void complete_topics(struct completion *c); /* of help */
/* One item of this type; before: what stands to the left of the word. */
void complete_item(struct completion *c, const struct argument *argument, struct text before);
/* After NAME of set: the unit of that name, or the choices of that setting. */
void complete_set(struct completion *c, struct text name, struct text before);

/* ---- where the cursor stands ---- */

bool ends_in_digit(struct text before);
struct text last_word(struct text before);
int count_words(struct text text);
/* What may come next: the words, keys and options of the command, and the item of the next place.
 */
void complete_next(struct completion *c, const struct command *command, struct text before);
void complete_sweep(struct completion *c, const struct command *command, struct text before);

/* The value that stands before the word ends in an operator, or inside of parentheses. */
bool value_is_open(struct text value);
/*
 * Inside of an expression of which `value` stands before the word: `names` where an operand can
 * stand, units of the quantity after a number, nothing after another operand. The word becomes its
 * part behind the last operator.
 */
void complete_value(struct completion *c, struct text value, enum quantity quantity,
                    void (*names)(struct completion *c));
/* In a statement that defines a scene or an event; rest: what stands between the command and the
 * word. */
void complete_formula(struct completion *c, const struct command *command, struct text rest);

#endif
