/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes pictures as SVG 1.1. Text remains text. Coordinates are hundredths of a point, relative to
 * the previous point (rounded before the difference is taken, so that errors do not accumulate). */
#include "modules/pictures/surface/surface.h"

#include <math.h>
#include <stdlib.h>

/* Fonts that have the characters of units and powers: superscripts, Greek, minus. */
#define SVG_FONTS "DejaVu Sans,Segoe UI,Lucida Grande,Noto Sans,Helvetica,Arial,sans-serif"

/* Appends value / 100 with as few characters as possible: ".25", "-3", "17.5". */
static void put_hundredths(struct buffer *output, long value)
{
    char digits[24];
    const unsigned long size = (unsigned long)labs(value), rest = size % 100;
    size_t index = sizeof digits;
    if (rest) {
        if (rest % 10)
            digits[--index] = (char)('0' + rest % 10);
        digits[--index] = (char)('0' + rest / 10);
        digits[--index] = '.';
    }
    for (unsigned long whole = size / 100; whole > 0; whole /= 10)
        digits[--index] = (char)('0' + whole % 10);
    if (size == 0)
        digits[--index] = '0';
    if (value < 0)
        digits[--index] = '-';
    buffer_put(output, (struct text){digits + index, sizeof digits - index});
}

/* Rounds a length to hundredths of a point, limited to 1e6 pt so that it fits a long. */
static long hundredths(double value)
{
    return lround(100 * fmax(fmin(value, 1e6), -1e6));
}

/* Appends an attribute with a length, such as width="3.5". */
static void put_length(struct buffer *output, const char *name, double value)
{
    buffer_format(output, " %s=\"", name);
    put_hundredths(output, hundredths(value));
    buffer_char(output, '"');
}

/* Appends an attribute with a colour, such as fill="#0072b2". */
static void put_color(struct buffer *output, const char *name, const double *color)
{
    buffer_format(output, " %s=\"#", name);
    for (int i = 0; i < 3; i++)
        buffer_format(output, "%02x", (unsigned)lround(255 * color[i]));
    buffer_char(output, '"');
}

/* Appends a text with the characters escaped that XML reserves. */
static void put_escaped(struct buffer *output, const char *text)
{
    for (; *text; text++) {
        const char *name;
        if (*text == '<')
            name = "&lt;";
        else if (*text == '>')
            name = "&gt;";
        else if (*text == '&')
            name = "&amp;";
        else
            name = *text == '"' ? "&quot;" : NULL;
        if (name)
            buffer_put(output, text_of(name));
        else
            buffer_char(output, *text);
    }
}

/* ---- paths ---- */

/* State of a path that is being written, to abbreviate its commands. */
struct path_writer {
    struct buffer *output;
    char command;  /* the last one: it need not be repeated */
    long x, y;     /* [pt/100] */
    long start[2]; /* [pt/100] where the current line began */
};

/* Appends a command of an SVG path, such as M or l, with two numbers x, y in hundredths. The letter
 * is left out if it repeats the previous one, and so are blanks before a minus sign. */
static void put_pair(struct path_writer *state, char command, long x, long y)
{
    if (command != state->command)
        buffer_char(state->output, command);
    else if (x >= 0)
        buffer_char(state->output, ' ');
    put_hundredths(state->output, x);
    if (y >= 0)
        buffer_char(state->output, ' ');
    put_hundredths(state->output, y);
    state->command = command;
}

/* Appends one element of a path: absolute moves, relative lines, a circle as two arcs, and a line
 * of no length as "h0", which round ends make a dot. */
static void put_point(struct path_writer *state, const struct path_point *point)
{
    const long x = hundredths(point->x), y = hundredths(point->y), r = hundredths(point->radius);
    if (point->kind == PATH_MOVE) {
        put_pair(state, 'M', x, y);
        state->start[0] = x;
        state->start[1] = y;
        state->command = '\0'; /* coordinates without a letter would be a line */
    } else if (point->kind == PATH_LINE && x == state->x && y == state->y) { /* a dot */
        buffer_put(state->output, TEXT("h0"));
        state->command = 'h';
    } else if (point->kind == PATH_LINE) {
        put_pair(state, 'l', x - state->x, y - state->y);
    } else if (point->kind == PATH_CIRCLE) {
        put_pair(state, 'M', x - r, y);
        for (int half = 1; half >= -1; half -= 2) {
            buffer_char(state->output, 'a');
            put_hundredths(state->output, r);
            buffer_char(state->output, ' ');
            put_hundredths(state->output, r);
            buffer_put(state->output, TEXT(" 0 1 0 "));
            put_hundredths(state->output, half * 2 * r);
            buffer_put(state->output, TEXT(" 0"));
        }
        state->command = 'a';
    } else {
        buffer_char(state->output, 'z');
        state->command = 'z';
    }
    if (point->kind == PATH_CLOSE)
        state->x = state->start[0];
    else
        state->x = point->kind == PATH_CIRCLE ? x - r : x;
    state->y = point->kind == PATH_CLOSE ? state->start[1] : y;
}

/* Returns the buffer that an SVG surface writes to. */
static struct buffer *svg_output(struct surface *surface)
{
    return ((struct svg_surface *)(void *)surface)->output;
}

/* Appends the path of the surface as an element <path>. */
static void svg_paint(struct surface *surface, const struct brush *brush)
{
    struct buffer *output = svg_output(surface);
    struct path_writer state = {.output = output};
    buffer_put(output, TEXT("<path"));
    if (brush->fill)
        put_color(output, "fill", brush->color);
    if (brush->width > 0) {
        put_color(output, "stroke", brush->color);
        put_length(output, "stroke-width", brush->width);
    }
    if (brush->opacity > 0 && brush->opacity < 1)
        put_length(output, "opacity", brush->opacity);
    for (int i = 0; brush->dashes && i < brush->dashes->n; i++) {
        buffer_put(output, i ? TEXT(" ") : TEXT(" stroke-dasharray=\""));
        put_hundredths(output, hundredths(brush->dashes->length[i] * brush->dash));
        if (i == brush->dashes->n - 1)
            buffer_char(output, '"');
    }
    buffer_put(output, TEXT(" d=\""));
    for (size_t i = 0; i < surface->points; i++)
        put_point(&state, &surface->path[i]);
    buffer_put(output, TEXT("\"/>\n"));
}

/* Opens a group with a clip path for the box (left, top, right, bottom); NULL closes it. */
static void svg_clip(struct surface *surface, const double box[4])
{
    struct svg_surface *svg = (struct svg_surface *)(void *)surface;
    if (!box) {
        buffer_put(svg->output, TEXT("</g>\n"));
        return;
    }
    buffer_format(svg->output, "<clipPath id=\"c%d\"><rect", ++svg->clips);
    put_length(svg->output, "x", box[0]);
    put_length(svg->output, "y", box[1]);
    put_length(svg->output, "width", box[2] - box[0]);
    put_length(svg->output, "height", box[3] - box[1]);
    buffer_format(svg->output, "/></clipPath>\n<g clip-path=\"url(#c%d)\">\n", svg->clips);
}

/* ---- text ---- */

/* Returns the width [pt] of a text, by the widest of the fonts. */
static double svg_text_width(struct surface *surface, double size, const char *text)
{
    (void)surface;
    return size * text_advance(text_of(text));
}

/* Appends a text element. */
static void svg_text_put(struct surface *surface, const struct surface_text *text)
{
    const struct svg_surface *svg = (struct svg_surface *)(void *)surface;
    struct buffer *output = svg->output;
    buffer_put(output, TEXT("<text"));
    put_length(output, "x", text->x);
    put_length(output, "y", text->y);
    if (text->turned) {
        buffer_put(output, TEXT(" transform=\"rotate(-90 "));
        put_hundredths(output, hundredths(text->x));
        buffer_char(output, ' ');
        put_hundredths(output, hundredths(text->y));
        buffer_put(output, TEXT(")\""));
    }
    if (text->align > 0)
        buffer_put(output, text->align < 1 ? TEXT(" text-anchor=\"middle\"")
                                           : TEXT(" text-anchor=\"end\""));
    if (text->size != svg->font)
        put_length(output, "font-size", text->size);
    put_color(output, "fill", text->color);
    buffer_char(output, '>');
    put_escaped(output, text->text);
    buffer_put(output, TEXT("</text>\n"));
}

/* ---- the document ---- */

/* Starts an SVG picture of width x height [pt] with the font size `font` [pt] and, unless NULL or
 * empty, a title; appends its head and a white background to output. */
void svg_begin(struct svg_surface *svg, double width, double height, double font, const char *title,
               struct buffer *output)
{
    static const struct surface_kind kind = {svg_paint, svg_clip, svg_text_put, svg_text_width};
    *svg = (struct svg_surface){.surface.kind = &kind, .output = output, .font = font};
    buffer_put(output, TEXT("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\""));
    put_hundredths(output, hundredths(width));
    buffer_put(output, TEXT("pt\" height=\""));
    put_hundredths(output, hundredths(height));
    buffer_put(output, TEXT("pt\" viewBox=\"0 0 "));
    put_hundredths(output, hundredths(width));
    buffer_char(output, ' ');
    put_hundredths(output, hundredths(height));
    buffer_put(output, TEXT("\" font-family=\"" SVG_FONTS "\""));
    put_length(output, "font-size", font);
    buffer_put(output,
               TEXT(" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n"));
    if (title && *title) {
        buffer_put(output, TEXT("<title>"));
        put_escaped(output, title);
        buffer_put(output, TEXT("</title>\n"));
    }
    buffer_put(output, TEXT("<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"));
}

void svg_end(struct svg_surface *svg)
{
    buffer_put(svg->output, TEXT("</svg>\n"));
    svg->surface.failed |= svg->output->failed;
}
