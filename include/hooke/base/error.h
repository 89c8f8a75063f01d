/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * error: what is said when a function fails.
 *
 * A fallible function returns bool and fills a caller-owned error: a sentence for the user that
 * names the input and what is allowed. The values of the codes are the exit statuses of the
 * program.
 */
#pragma once

#include <hooke/base/text.h>

enum error_code {
    ERROR_NONE = 0,
    ERROR_COMMAND = 1,    /* the request makes no sense or is refused */
    ERROR_USAGE = 2,      /* bad option, script not readable */
    ERROR_NUMERICAL = 3,  /* diverged, did not converge */
    ERROR_IO = 4,         /* no such data file, malformed data, cannot write */
    ERROR_CANCELLED = 130 /* stopped by Ctrl-C */
};

/* Kinds of hints, from the least useful to the most. Whoever knows more replaces all but advice. */
enum hint_kind { HINT_NONE, HINT_LIST, HINT_GUESS, HINT_USAGE, HINT_ADVICE };

struct error {
    enum error_code code;
    char text[600];    /* one sentence, lower case, no final full stop */
    char hint[300];    /* advice on what to do, or "" */
    struct text where; /* the part of the caller's input that is wrong; `at` is NULL if unknown */
    /* The kind of name that was looked up and not found, such as "method", "" if it may be of any
     * kind; NULL for all other errors. */
    const char *unknown;
    /* HINT_GUESS if any part of the hint is a guess, else the kind of its first part */
    enum hint_kind hint_kind;
};

/* All return false, so that `return error_set(…)` reads well. */
bool error_set(struct error *error, enum error_code code, const char *format, ...)
    PRINTF_LIKE(3, 4);
/* The same with ERROR_COMMAND, and the place in the input. */
bool error_at(struct error *error, struct text where, const char *format, ...) PRINTF_LIKE(3, 4);
/* Adds a hint to an error that is set already. */
bool error_hint(struct error *error, const char *format, ...) PRINTF_LIKE(2, 3);
/* Adds the hint "usage: USAGE". */
bool error_usage(struct error *error, const char *usage);
bool error_memory(struct error *error); /* sets "out of memory" */
/* Returns the name of a code in JSON: "command", "usage", "numerical", "io" or "cancelled". */
const char *error_name(enum error_code code);
