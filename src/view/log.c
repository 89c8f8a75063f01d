/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The log: the last lines that commands said, from the top as on paper; once the pane is full the newest line is the
 * lowest. */
#include "internal.h"

#include <string.h>

void line_draw(const struct screen *screen, int x, int y, int width, struct text text, enum style style)
{
    if (width < 1)
        return;
    bool cut = text_width(text) > width;
    int end = x + width - cut;
    while (text.len) {
        size_t used;
        int columns = codepoint_width(text_codepoint(text, &used));
        if (x + columns > end)
            break;
        x = canvas_text(screen->canvas, x, y, (struct text){text.at, used}, style);
        text.at += used;
        text.len -= used;
    }
    if (cut)
        canvas_put(screen->canvas, end, y, screen->charset == CHARSET_ASCII ? '>' : 0x2026, STYLE_DIM);
}

static enum style style_of(struct text line)
{
    if (text_starts(line, TEXT("hooke> ")))
        return STYLE_BOLD;
    return text_starts(line, TEXT("error: ")) || memmem(line.at, line.len, ": error: ", 9) ? STYLE_ALERT : STYLE_PLAIN;
}

void log_draw(const struct screen *screen, struct rectangle at)
{
    const struct log *log = &screen->session->log;
    int scroll = larger(smaller(screen->session->view.scroll, log->count - at.height), 0);
    int shown = smaller(at.height, log->count - scroll);

    for (int row = 0; row < shown; row++) {
        struct text line = text_of(log_line(log, scroll + shown - 1 - row));
        line_draw(screen, at.x, at.y + row, at.width, line, style_of(line));
    }
}
