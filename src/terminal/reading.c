/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shows text that is longer than the log as pages on the whole screen. */
#include <hooke/base/safe_text.h>
#include "terminal/panes.h"

#include <string.h>

/* Texts of fewer rows, or on lower screens, are read in the log. */
#define READING_ROWS 8

/* Appends the prompt of a page: its position in percent, or a notice, and as many of the keys as
 * fit. */
void reading_prompt(const struct session *session, struct text notice, struct buffer *text)
{
    static const char *const keys[2][4] = {
        {" (space: more, PgUp, / find, n next, q: panes)> ", " (space, q)> ", " (q)> ", "> "},
        {" (space: more, PgUp, / find, n next, ! runs it, q: panes)> ", " (space, ! runs it, q)> ",
         " (!, q)> ", "> "}};
    const struct session *const s = session;
    const int rows = log_rows_newest(&s->log, s->log.count, s->front.width);
    const int left = s->view.scroll;
    if (notice.len > 0)
        buffer_put(text, text_width(notice) + 2 < s->front.width ? notice : TEXT("not found"));
    else if (left == 0)
        buffer_put(text, TEXT("end"));
    else
        buffer_format(text, "%d %%", (int)(100.0 * (rows - left) / (rows > 0 ? rows : 1)));
    /* the longest list of keys that leaves room for the cursor */
    const int width = text_width(buffer_text(text));
    for (size_t i = notice.len > 0; i < COUNT_OF(keys[0]); i++) {
        const char *shown = keys[s->view.recipe != NULL][i];
        if (width + (int)strlen(shown) < s->front.width || i + 1 == COUNT_OF(keys[0])) {
            buffer_put(text, text_of(shown));
            break;
        }
    }
}

/* Appends the command that reads the messages since said_before as pages, if the log is too small
 * for them and nothing was typed meanwhile. */
void reading_command(const struct panes *panes, uint64_t said_before, struct buffer *line)
{
    const struct session *session = panes_session(panes);
    const uint64_t said = session->log.said - said_before;
    const int lines = said < (uint64_t)session->log.count ? (int)said : session->log.count;
    const int height = session->front.height, width = session->front.width;
    const int rows = log_rows_newest(&session->log, lines, width);
    if (rows <= screen_log_rows(session, width, height) || rows < READING_ROWS ||
        height < READING_ROWS || panes->running || input_pending(&panes->input) ||
        panes_over(panes)) {
        return;
    }
    buffer_format(line, "scroll read %d", lines);
}

/* Returns the line at the top of the page, counted from the newest (0). */
int reading_line(const struct session *session)
{
    const struct log *log = &session->log;
    const int width = session->front.width, height = session->front.height;
    int line = 0;
    while (line + 1 < log->count &&
           log_rows_newest(log, line + 1, width) < session->view.scroll + height - 1)
        line++;
    return line;
}
