/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_COMMAND_SESSION_TOPICS_H
#define HOOKE_COMMAND_SESSION_TOPICS_H

#include "command/internal.h"

/* What a newcomer asks for, and lines that show it; each works after those above it. */
struct guide_topic {
    struct row row;
    const char *text;   /* a paragraph */
    const char *recipe; /* lines of commands */
};

/* The catalogs that `help` explains rows of, one after the other; NULL: there are no more. */
const struct catalog *help_catalog(int i);

#endif
