/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the line being edited, in the last row. A longer line scrolls sideways, by half a screen at
 * a time. */
#include <hooke/base/safe_text.h>
#include "view/internal.h"

#include <stdio.h>

/* [byte] longest form of a character that is shown as text, with its NUL */
#define ESCAPE_SIZE 8

/* Takes the next character off the text and returns how it is shown: itself, `^J` for a control
 * character, `\xNN` for a byte that is no UTF-8 (written to output). */
static struct text take_shown_character(struct text *text, char output[ESCAPE_SIZE])
{
    static const char invalid[] = "\xEF\xBF\xBD"; /* U+FFFD itself */
    size_t used;
    uint32_t codepoint = text_codepoint(*text, &used);
    struct text piece = {text->data, used};
    text->data += used;
    text->len -= used;
    if (codepoint == CODEPOINT_INVALID && !text_is(piece, invalid))
        piece = (struct text){
            output, (size_t)snprintf(output, ESCAPE_SIZE, "\\x%02X", (unsigned char)*piece.data)};
    else if (codepoint < 0x20 || codepoint == 0x7F)
        piece = (struct text){
            output, (size_t)snprintf(output, ESCAPE_SIZE, "^%c", (int)(codepoint ^ 0x40))};
    else if (codepoint < 0xA0 && codepoint >= 0x80)
        piece = (struct text){
            output, (size_t)snprintf(output, ESCAPE_SIZE, "\\x%02X", (unsigned)codepoint)};
    return piece;
}

/* Returns the width [cell] of the first `bytes` of the text. */
static int shown_width(struct text text, size_t bytes)
{
    size_t remaining = bytes < text.len ? text.len - bytes : 0;
    char output[ESCAPE_SIZE];
    int width = 0;
    while (text.len > remaining)
        width += text_width(take_shown_character(&text, output));
    return width;
}

/* Draws the columns column_begin..column_end of the text, from column x of the screen on. */
static void draw_text_columns(const struct screen *screen, struct text text, int column_begin,
                              int column_end, int x, int y, enum style style)
{
    char output[ESCAPE_SIZE];
    for (int column = 0; text.len && column < column_end;) {
        struct text piece = take_shown_character(&text, output);
        for (struct text glyph = piece; glyph.len;) {
            size_t used;
            int width = codepoint_width(text_codepoint(glyph, &used));
            if (column >= column_begin && column + width <= column_end)
                canvas_text(screen->canvas, x + column - column_begin, y,
                            (struct text){glyph.data, used}, style);
            column += width;
            glyph.data += used;
            glyph.len -= used;
        }
    }
}

/* Draws the prompt and the part of the line around the cursor, with < and > where it is cut. Sets
 * *cursor_x to the cursor's column. */
void prompt_draw(const struct screen *screen, const struct prompt_line *prompt, int y,
                 int *cursor_x)
{
    int width = screen->canvas->width, lead = shown_width(prompt->prompt, prompt->prompt.len);
    int total = shown_width(prompt->line, prompt->line.len),
        cursor = shown_width(prompt->line, prompt->cursor);

    if (lead > width / 2 && lead + total >= width) /* no room for both */
        lead = 0;
    else
        draw_text_columns(screen, prompt->prompt, 0, lead, 0, y, STYLE_BOLD);
    int field = larger(width - lead, 1), step = larger(field / 2, 1), offset = 0;
    bool marks = field >= 4;
    if (cursor > field - 1 - (marks && total > field))
        offset = (cursor - (field - 2) + step - 1) / step * step;
    if (!marks)
        offset = larger(cursor - (field - 1), 0);
    bool is_cut_left = marks && offset > 0, is_cut_right = marks && total - offset > field;
    draw_text_columns(screen, prompt->line, offset + is_cut_left, offset + field - is_cut_right,
                      lead + is_cut_left, y, STYLE_PLAIN);
    if (is_cut_left)
        canvas_put(screen->canvas, lead, y, '<', STYLE_DIM);
    if (is_cut_right)
        canvas_put(screen->canvas, lead + field - 1, y, '>', STYLE_DIM);
    *cursor_x = smaller(lead + cursor - offset, width - 1);
}
