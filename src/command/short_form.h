/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Answers that fit on one screen: longer ones are shown in full only with --full. The interpreter
 * calls short_form_begin() before and short_form_end() after a statement. */
#pragma once

#include <hooke/command/handler.h>

/* Most messages that are held together with the text; further ones are written at once. */
#define SHORT_FORM_MESSAGES 16

/* Holds the output of a statement until its length is known. */
struct short_form {
    struct sink outer;   /* sink of the reply, restored by short_form_end() */
    int width, rows_max; /* [cell] of a line; [row] of the answer */
    bool folds;          /* lines wider than a terminal are broken; those for programs are not */
    bool active;         /* false if the statement shows everything and nothing is held back */
    struct buffer text;  /* results, and messages at their places */
    struct {
        size_t begin, len;
    } message[SHORT_FORM_MESSAGES];
    int messages;
};

/* Begins to hold the output of a command that has the option --full, unless that was given. */
void short_form_begin(struct short_form *form, const struct session *session,
                      const struct arguments *arguments, struct reply *reply);
/* Writes what was held. If it is too long, rows before its last third are replaced by a line with
 * their number. */
void short_form_end(struct short_form *form, struct reply *reply);
