/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Topics of help, shared by the commands help, recipe and completion. */
#pragma once

#include <hooke/command/handler.h>

struct catalog;

/* A task of a newcomer, with lines of commands that do it; each line works after those above it. */
struct guide_topic {
    struct row row;
    const char *text;   /* a paragraph */
    const char *recipe; /* lines of commands */
};

/* Returns the i-th catalog whose rows `help` explains, or NULL if there are no more. */
const struct catalog *help_catalog(int i);

/* Appends every command in a line, by groups, in the order of their first commands. */
void help_commands(struct buffer *text);
/* Appends one screen: the topics, and the names of the commands. */
void help_all(struct buffer *text);

/* Largest number of choices shown; longer lists are printed by commands of their own. */
#define HELP_CHOICES 24

/* Returns the word behind the command, with *command set, if a statement such as `set opinion` or
 * `compare dt=5ms` was typed; otherwise all of it, with NULL. */
struct text help_topic_of(struct text words, const struct command **command);
/* Appends the explanation of *word if it is an argument of the command, and shortens *word to the
 * name that has to be explained, too (`dt` of compare's dt=5ms), or to nothing if there is none. */
void help_given(const struct command *command, struct text *word, struct buffer *text);
