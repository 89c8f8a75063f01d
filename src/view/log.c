/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the log: the last lines of commands and replies. They begin at the top of the pane; once it
 * is full the newest line is the lowest. Longer lines continue in the next row. */
#define _GNU_SOURCE /* memmem */
#include <hooke/base/safe_text.h>
#include "view/internal.h"

#include <string.h>

/* Draws one line of text, cut with a mark if it is wider than `width`. */
void line_draw(const struct screen *screen, int x, int y, int width, struct text text,
               enum style style)
{
    if (width < 1)
        return;
    bool cut;
    const struct text shown = text_in_room(text, width, &cut);
    const int end = canvas_text(screen->canvas, x, y, shown, style);
    const bool word = cut && shown.len < text.len && text.data[shown.len] == ' ';
    if (cut)
        canvas_put(screen->canvas, end + word, y, screen->charset->plain ? '>' : 0x2026, STYLE_DIM);
}

/* Returns the style of a line: bold for commands, alert for errors. */
static enum style line_style(struct text line)
{
    if (text_starts(line, TEXT("hooke> ")))
        return STYLE_BOLD;
    return text_starts(line, TEXT("error: ")) || memmem(line.data, line.len, ": error: ", 9)
               ? STYLE_ALERT
               : STYLE_PLAIN;
}

/* Draws the part of the log that the view is scrolled to. */
void log_draw(const struct screen *screen, struct rectangle area)
{
    const struct log *log = &screen->session->log;
    const struct text newest = text_of(log_line(log, 0));
    if (area.height == 1 &&
        /* a single row shows the beginning of the newest line */
        screen->session->view.scroll <= 0) {
        line_draw(screen, area.x, area.y, area.width, newest, line_style(newest));
        return;
    }
    /* Goes back from the newest line to the line of the first visible row. */
    const int wanted = area.height + larger(screen->session->view.scroll, 0);
    int rows = 0, oldest = 0;
    while (oldest < log->count && rows < wanted)
        rows += log_rows(text_of(log_line(log, oldest++)), area.width);

    /* the oldest line stays at the top, however far one scrolls */
    int row = smaller(wanted - rows, 0);
    for (int i = oldest - 1; i >= 0 && row < area.height; i--) {
        const struct text line = text_of(log_line(log, i));
        size_t offset = 0;
        int indent;
        do {
            const struct text part = log_row(line, &offset, area.width, &indent);
            if (row >= 0 && row < area.height)
                line_draw(screen, area.x + indent, area.y + row, area.width - indent, part,
                          line_style(line));
            row++;
        } while (offset < line.len);
    }
}
