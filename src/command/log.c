/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The last lines that commands said: a ring. */
#include "internal.h"

#include <stdlib.h>

static void add_line(struct log *log, struct text line)
{
    struct buffer safe = {0};
    safe_text(&safe, line, false);
    buffer_put(&safe, TEXT("")); /* a string also where the line is empty */
    if (safe.failed) {
        buffer_free(&safe);
        return;
    }
    const int place = (log->first + log->count) % LIMIT_LOG;
    if (log->count == LIMIT_LOG) {
        free(log->line[place]);
        log->first = (log->first + 1) % LIMIT_LOG;
    } else {
        log->count++;
    }
    log->line[place] = safe.data;
}

void log_add(struct log *log, struct text text)
{
    struct text line;
    if (!log->line && !(log->line = calloc(LIMIT_LOG, sizeof *log->line)))
        return;
    if (text.len > 0 && text.at[text.len - 1] == '\n')
        text.len--;
    do {
        if (!text_split(&text, '\n', &line))
            line = TEXT("");
        add_line(log, line);
    } while (text.at);
}

const char *log_line(const struct log *log, int i)
{
    return i >= 0 && i < log->count ? log->line[(log->first + log->count - 1 - i) % LIMIT_LOG] : NULL;
}

void log_clear(struct log *log)
{
    for (int i = 0; i < log->count; i++)
        free(log->line[(log->first + i) % LIMIT_LOG]);
    free(log->line);
    *log = (struct log){0};
}
