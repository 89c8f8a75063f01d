/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the parts of completion share. */
#ifndef HOOKE_COMMAND_COMPLETE_H
#define HOOKE_COMMAND_COMPLETE_H

#include "choices.h"

struct completion {
    struct session *session;
    struct text word; /* what stands before the cursor of the word */
    void (*offer)(void *context, const char *candidate, const char *brief);
    void *context;
    bool wants_file;
};

void complete_offer(struct completion *c, const char *candidate, const char *brief);
void complete_events(struct completion *c); /* what is watched for */
void complete_catalog(struct completion *c, const struct catalog *catalog);
int count_words(struct text text);

/* The value that stands before the word ends in an operator, or inside of parentheses. */
bool value_is_open(struct text value);
/*
 * Inside of an expression of which `value` stands before the word: `names` where an operand can stand, units of the
 * quantity after a number, nothing after another operand. The word becomes its part behind the last operator.
 */
void complete_value(struct completion *c, struct text value, enum quantity quantity,
                    void (*names)(struct completion *c));
/* In a statement that defines a scene or an event; rest: what stands between the command and the word. */
void complete_formula(struct completion *c, const struct command *command, struct text rest);

#endif
