/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * error: why a function failed, as a message for the user.
 *
 * A function that can fail returns false or NULL and fills a struct error that its caller owns. On
 * success the struct is left unchanged, so that it needs no initialisation before the call.
 */
#pragma once

#include <hooke/base/text.h>

/* Kinds of failures; the values are exit statuses of the program. */
enum error_code {
    ERROR_NONE = 0,
    ERROR_COMMAND = 1,    /* The command is wrong or is refused. */
    ERROR_USAGE = 2,      /* An option is wrong or a script cannot be read. */
    ERROR_NUMERICAL = 3,  /* The computation diverged or did not converge. */
    ERROR_IO = 4,         /* A file is missing, malformed or cannot be written. */
    ERROR_CANCELLED = 130 /* Stopped by Ctrl-C. */
};

/* Kinds of hints, from the least useful to the most useful: no hint, a list of valid names, a
 * similar name, the usage of the command, advice for this very case. A caller that knows a more
 * useful hint replaces any hint but advice. */
enum hint_kind { HINT_NONE, HINT_LIST, HINT_GUESS, HINT_USAGE, HINT_ADVICE };

/* A failure; owns all of its texts but `where`. */
struct error {
    enum error_code code;
    char text[600];    /* One sentence in lower case without a final full stop. */
    char hint[300];    /* Advice on what to do, or "". */
    struct text where; /* Slice of the caller's input that is wrong; `data` is NULL if unknown. */
    /* Kind of the name that was looked up and not found, such as "method", or "" if names of any
     * kind could have been meant. NULL for all other errors. */
    const char *unknown;
    /* Kind of the hint: HINT_GUESS if any part of it is a guess, else the kind of its first part.
     */
    enum hint_kind hint_kind;
};

/* Sets code and text, and clears all other members. This function and those below return false, so
 * that a caller can write `return error_set(…)`. */
bool error_set(struct error *error, enum error_code code, const char *format, ...)
    PRINTF_LIKE(3, 4);
/* Does the same as error_set() with the code ERROR_COMMAND, and sets `where` to the wrong part of
 * the input. */
bool error_at(struct error *error, struct text where, const char *format, ...) PRINTF_LIKE(3, 4);
/* Appends a hint to an error that is set. */
bool error_hint(struct error *error, const char *format, ...) PRINTF_LIKE(2, 3);
/* Appends the hint "usage: USAGE" and sets hint_kind to HINT_USAGE. */
bool error_usage(struct error *error, const char *usage);
bool error_memory(struct error *error); /* Sets "out of memory: nothing was changed". */
/* Returns the name of a code in JSON: "command", "usage", "numerical", "io" or "cancelled". */
const char *error_name(enum error_code code);
