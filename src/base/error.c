/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Errors: filling in struct error and its hints, whose texts are cut at whole characters. */
#include <hooke/base/safe_text.h>
#include "base/internal.h"

#include <locale.h>
#include <stdio.h>
#include <string.h>

/* Shortens the string z, which snprintf may have cut at the end of its buffer of `size` bytes, by
 * an incomplete UTF-8 sequence at its end. A string that does not fill the buffer is unchanged. */
static void drop_partial(char *z, size_t size)
{
    size_t len = strlen(z);
    if (len + 1 < size)
        return;
    size_t start = len;
    while (start > 0 && len - start < 4 && ((unsigned char)z[start - 1] & 0xC0) == 0x80)
        start--;
    if (start == 0 || (unsigned char)z[start - 1] < 0xC0)
        return;
    size_t used;
    struct text last = {z + start - 1, len - start + 1};
    if (text_codepoint(last, &used) == CODEPOINT_INVALID && used == 1)
        z[start - 1] = '\0';
}

/* Fills in an error with formatted text, without a place and a hint. */
static PRINTF_LIKE(3, 0) void error_format(struct error *error, enum error_code code,
                                           const char *format, va_list args)
{
    error->code = code;
    error->hint[0] = '\0';
    error->where = (struct text){NULL, 0};
    error->unknown = NULL;
    error->hint_kind = HINT_NONE;
    vsnprintf(error->text, sizeof error->text, format, args);
    drop_partial(error->text, sizeof error->text);
}

/* Sets an error without a place. Returns false, so that callers can return the call. */
bool error_set(struct error *error, enum error_code code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    error_format(error, code, format, args);
    va_end(args);
    return false;
}

/* Sets an error of a command at the place `where` in the line. Returns false. */
bool error_at(struct error *error, struct text where, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    error_format(error, ERROR_COMMAND, format, args);
    va_end(args);
    error->where = where;
    return false;
}

/* Appends a hint, separated by two spaces from an earlier one. Returns false. */
bool error_hint(struct error *error, const char *format, ...)
{
    size_t len = strlen(error->hint);
    if (len == 0)
        error->hint_kind = HINT_ADVICE;
    if (len > 0 && len + 2 < sizeof error->hint) {
        memcpy(error->hint + len, "  ", 3);
        len += 2;
    }
    va_list args;
    va_start(args, format);
    vsnprintf(error->hint + len, sizeof error->hint - len, format, args);
    va_end(args);
    drop_partial(error->hint, sizeof error->hint);
    return false;
}

/* Adds the usage of a command as a hint. Returns false. */
bool error_usage(struct error *error, const char *usage)
{
    error_hint(error, "usage: %s", usage);
    error->hint_kind = HINT_USAGE;
    return false;
}

bool error_memory(struct error *error)
{
    return error_set(error, ERROR_COMMAND, "out of memory: nothing was changed");
}

/* Returns the name of the code for JSON and for the API. */
const char *error_name(enum error_code code)
{
    static const char *const names[] = {"none", "command", "usage", "numerical", "io"};
    if (code == ERROR_CANCELLED)
        return "cancelled";
    return (size_t)code < COUNT_OF(names) ? names[code] : "unknown";
}

/* Returns the system's message for an errno in English, whatever the locale. */
const char *system_message(int number)
{
    /* The "C" locale is static in the C library: nothing is allocated, nothing has to be freed. */
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return plain ? strerror_l(number, plain) : "unknown error";
}
