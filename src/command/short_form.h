/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Answers in one screen: what is longer is shown only with --full. */
#pragma once

#include <hooke/command/handler.h>

/* Messages that wait for the text around them; later ones come before it. */
#define SHORT_FORM_MESSAGES 16

/* Holds what a statement says until its length is known. */
struct short_form {
    struct sink outer;   /* sink of the reply, restored by short_form_end() */
    int width, rows_max; /* [cell] of a line; [row] of the answer */
    bool active;         /* false if the statement shows everything and nothing is held back */
    struct buffer text;  /* results, and messages at their places */
    struct {
        size_t begin, len;
    } message[SHORT_FORM_MESSAGES];
    int messages;
};

/* Begins to hold the text of a command that has the option --full, where it is not given. */
void short_form_begin(struct short_form *form, const struct session *session,
                      const struct arguments *arguments, struct reply *reply);
/* Writes what was held. Where it is too long, rows before its last third are replaced by a line
 * that says how many they are. */
void short_form_end(struct short_form *form, struct reply *reply);
