/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The canvas: a rectangle of character cells that figures and panes are drawn into, and its output
 * as lines of text, with colour escapes or without. */
#include <hooke/base/safe_text.h>
#include <hooke/figure.h>

#include <stdlib.h>

/* Allocates width x height blank cells; negative sizes count as 0. Returns false if out of memory
 * or if the count overflows. canvas_free() frees them. */
bool canvas_init(struct canvas *canvas, int width, int height)
{
    size_t columns = width > 0 ? (size_t)width : 0;
    size_t rows = height > 0 ? (size_t)height : 0;
    size_t count = columns * rows;

    *canvas = (struct canvas){0};
    if (rows && count / rows != columns)
        return false;
    struct cell *cell = calloc(count ? count : 1, sizeof *cell);
    if (!cell)
        return false;
    for (size_t i = 0; i < count; i++)
        cell[i] = (struct cell){' ', STYLE_PLAIN};
    *canvas = (struct canvas){(int)columns, (int)rows, cell};
    return true;
}

void canvas_free(struct canvas *canvas)
{
    free(canvas->cell);
    *canvas = (struct canvas){0};
}

/* Returns true for control characters (C0, DEL and C1), which would move a terminal's cursor. */
static bool is_control(uint32_t codepoint)
{
    return codepoint < 0x20 || (codepoint >= 0x7f && codepoint < 0xa0);
}

/* Writes a character into cell (x, y), or into two cells if it is wide. Control characters become
 * '?'. Positions outside of the canvas are ignored. */
void canvas_put(struct canvas *canvas, int x, int y, uint32_t codepoint, enum style style)
{
    if (x < 0 || y < 0 || x >= canvas->width || y >= canvas->height)
        return;
    struct cell *row = canvas->cell + (size_t)y * (size_t)canvas->width;
    bool wide = !is_control(codepoint) && codepoint_width(codepoint) == 2;
    int last = wide ? x + 1 : x;

    if (last == canvas->width) { /* a wide character in the last column is replaced by a blank */
        wide = false;
        codepoint = ' ';
        last = x;
    }
    /* A wide character that is overwritten in one of its two cells leaves a blank in the other. */
    if (row[x].codepoint == 0 && x > 0)
        row[x - 1].codepoint = ' ';
    if (last + 1 < canvas->width && row[last + 1].codepoint == 0)
        row[last + 1].codepoint = ' ';
    row[x] = (struct cell){is_control(codepoint) ? '?' : codepoint, (uint8_t)style};
    if (wide)
        row[last] = (struct cell){0, (uint8_t)style};
}

/* Writes text from cell (x, y) on, cut off at the right border. Returns the column after it. */
int canvas_text(struct canvas *canvas, int x, int y, struct text text, enum style style)
{
    while (text.len && x < canvas->width) {
        size_t used;
        uint32_t codepoint = text_codepoint(text, &used);
        int width = is_control(codepoint) ? 1 : codepoint_width(codepoint);
        if (width) /* a cell holds one code point: combining marks are left out */
            canvas_put(canvas, x, y, codepoint, style);
        x += width;
        text.data += used;
        text.len -= used;
    }
    return x;
}

/* Colours of 256 are fixed, of a contrast of at least 3:1 with white and with black, and distinct
 * for colour-blind eyes: blue, vermilion, purple, green, after Okabe and Ito (2008). Colours of 8
 * follow the terminal's theme. */
int style_color(enum style style, int colors)
{
    static const struct {
        int of_8, of_256;
    } color[] = {
        [STYLE_CURVE_1] = {4, 32}, [STYLE_CURVE_2] = {1, 166}, [STYLE_CURVE_3] = {5, 133},
        [STYLE_CURVE_4] = {2, 29}, [STYLE_ALERT] = {1, 160},
    };
    if (style >= COUNT_OF(color) || color[style].of_8 == 0 || colors == 0)
        return -1;
    return colors >= 256 ? color[style].of_256 : color[style].of_8;
}

/* Appends the escape sequence that begins the style; backgrounds are never painted. */
static void put_style(enum style style, int colors, struct buffer *output)
{
    const int color = style_color(style, colors);
    if (style == STYLE_DIM)
        buffer_put(output, TEXT("\033[2m"));
    else if (style == STYLE_BOLD)
        buffer_put(output, TEXT("\033[1m"));
    else if (color >= 0)
        buffer_format(output, colors >= 256 ? "\033[38;5;%dm" : "\033[3%dm", color);
}

/* Appends the canvas as lines without trailing blanks. Escapes for styles are written only if
 * there are colours and the style changes; every line ends in the plain style. */
void canvas_print(const struct canvas *canvas, int colors, struct buffer *output)
{
    for (int y = 0; y < canvas->height; y++) {
        const struct cell *row = canvas->cell + (size_t)y * (size_t)canvas->width;
        int end = canvas->width;
        unsigned style = STYLE_PLAIN;
        while (end > 0 && row[end - 1].codepoint == ' ')
            end--;
        for (int x = 0; x < end; x++) {
            /* The right half of a wide character was written with its left half. */
            if (row[x].codepoint == 0)
                continue;
            if (colors && row[x].codepoint != ' ' && row[x].style != style) {
                if (style != STYLE_PLAIN)
                    buffer_put(output, TEXT("\033[0m"));
                style = row[x].style;
                put_style((enum style)style, colors, output);
            }
            buffer_codepoint(output, row[x].codepoint);
        }
        if (style != STYLE_PLAIN)
            buffer_put(output, TEXT("\033[0m"));
        buffer_char(output, '\n');
    }
}
