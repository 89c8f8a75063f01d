/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is longer than the log, read on the whole screen. */
#include "terminal/panes.h"

/* What is less long is read in the log, or scrolled there; so is all on a lower screen. */
#define READING_ROWS 8

void reading_prompt(const struct session *session, struct text notice, struct buffer *text)
{
    const int width = session->front.width;
    const int rows = log_rows_newest(&session->log, session->log.count, width);
    const int left = session->view.scroll;
    if (notice.len > 0) {
        buffer_put(text, notice);
    } else if (left == 0) {
        buffer_put(text, TEXT("end"));
    } else {
        buffer_format(text, "%d %%", (int)(100.0 * (rows - left) / (rows > 0 ? rows : 1)));
    }
    buffer_put(text, width < 60 || notice.len > 0
                         ? TEXT(" (space, q)> ")
                         : TEXT(" (space: on, PgUp, / finds, n again, q: panes)> "));
}

void reading_command(const struct panes *panes, uint64_t said_before, struct buffer *line)
{
    const struct session *session = panes_session(panes);
    const uint64_t said = session->log.said - said_before;
    const int lines = said < (uint64_t)session->log.count ? (int)said : session->log.count;
    const int height = session->front.height, width = session->front.width;
    const int rows = log_rows_newest(&session->log, lines, width);
    if (rows <= screen_log_rows(session, width, height) || rows < READING_ROWS ||
        height < READING_ROWS || panes->running || keys_on_plot() || input_pending(&panes->input) ||
        panes_over(panes)) {
        return;
    }
    buffer_format(line, "scroll read %d", lines);
}
