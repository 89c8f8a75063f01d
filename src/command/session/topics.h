/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_SESSION_TOPICS_H
#define HOOKE_COMMAND_SESSION_TOPICS_H

#include <hooke/command/handler.h>

struct catalog;

/* What a newcomer asks for, and lines that show it; each works after those above it. */
struct guide_topic {
    struct row row;
    const char *text;   /* a paragraph */
    const char *recipe; /* lines of commands */
};

/* The catalogs that `help` explains rows of, one after the other; NULL: there are no more. */
const struct catalog *help_catalog(int i);

/* Appends every command in a line, by groups, in the order of their first commands. */
void help_commands(struct buffer *text);
/* Appends one screen: the topics, and the names of the commands. */
void help_all(struct buffer *text);

#define HELP_CHOICES 20 /* of more there is a list of its own */

/* Of a statement as it is typed, `set opinion` or `compare dt=5ms`, the word behind the command,
 * and the command; else all of it, and NULL. */
struct text help_topic_of(struct text words, const struct command **command);
/* Appends what argument of the command the word is, and leaves of it the name that is explained
 * besides: `dt` of compare's dt=5ms, `k` of sweep's k=1:2; nothing. */
void help_given(const struct command *command, struct text *word, struct buffer *text);

#endif
