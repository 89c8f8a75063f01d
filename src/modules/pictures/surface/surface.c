/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Paths and texts of a picture, for every kind of surface. */
#include "modules/pictures/surface/surface.h"

#include <stdlib.h>

/* Appends an element to the path: the end point x, y of a move or a line, or a circle of that
 * centre and radius. Sets surface->failed if out of memory. */
static void add_point(struct surface *surface, enum path_kind kind, double x, double y,
                      double radius)
{
    if (surface->points == surface->capacity && !surface->failed) {
        const size_t capacity = surface->capacity ? 2 * surface->capacity : 256;
        struct path_point *path = realloc(surface->path, capacity * sizeof *path);
        surface->failed = !path;
        surface->path = path ? path : surface->path;
        surface->capacity = path ? capacity : surface->capacity;
    }
    if (!surface->failed)
        surface->path[surface->points++] = (struct path_point){kind, x, y, radius};
}

void surface_move(struct surface *surface, double x, double y)
{
    add_point(surface, PATH_MOVE, x, y, 0);
}

void surface_line(struct surface *surface, double x, double y)
{
    add_point(surface, surface->points ? PATH_LINE : PATH_MOVE, x, y, 0);
}

void surface_circle(struct surface *surface, double x, double y, double radius)
{
    add_point(surface, PATH_CIRCLE, x, y, radius);
}

void surface_close(struct surface *surface)
{
    if (surface->points)
        add_point(surface, PATH_CLOSE, 0, 0, 0);
}

/* Corners in clockwise order. */
void surface_box(struct surface *surface, double left, double top, double right, double bottom)
{
    surface_move(surface, left, top);
    surface_line(surface, right, top);
    surface_line(surface, right, bottom);
    surface_line(surface, left, bottom);
    surface_close(surface);
}

void surface_new_path(struct surface *surface)
{
    surface->points = 0;
}

void surface_paint(struct surface *surface, const struct brush *brush)
{
    if (surface->points && !surface->failed)
        surface->kind->paint(surface, brush);
    surface->points = 0;
}

void surface_clip(struct surface *surface, double left, double top, double right, double bottom)
{
    surface->kind->clip(surface, (const double[]){left, top, right, bottom});
}

void surface_unclip(struct surface *surface)
{
    surface->kind->clip(surface, NULL);
}

/* ---- text ---- */

/* Returns the text without control characters and invalid UTF-8, which labels from files may have
 * and which would make a picture unreadable. Valid until the next call. */
static const char *plain_text(struct surface *surface, const char *text)
{
    buffer_clear(&surface->plain);
    safe_text(&surface->plain, text_of(text), false);
    surface->failed |= surface->plain.failed;
    return surface->plain.len && !surface->plain.failed ? surface->plain.data : "";
}

double surface_text_width(struct surface *surface, double size, const char *text)
{
    return surface->kind->text_width(surface, size, plain_text(surface, text));
}

double surface_put_text(struct surface *surface, const struct surface_text *text)
{
    struct surface_text shown = *text;
    shown.text = plain_text(surface, text->text);
    if (*shown.text)
        surface->kind->text(surface, &shown);
    return surface->kind->text_width(surface, text->size, shown.text);
}

/* Returns the width of a text in units of the font size, by a table of the widths of DejaVu Sans;
 * other characters get generous estimates. */
double text_advance(struct text text)
{
    /* [size / 1000] from the blank on */
    static const short widths[] = {
        318,  401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337,
        636,  636, 636, 636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531,
        1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863, 748, 787,
        603,  787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500,
        500,  613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612,
        635,  635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838};
    const uint32_t superscript = 0x2070, subscript_end = 0x209C;
    double width = 0;
    for (size_t used; text.len; text.data += used, text.len -= used) {
        const uint32_t c = text_codepoint(text, &used);
        if (c >= ' ' && c - ' ' < COUNT_OF(widths))
            width += widths[c - ' '];
        else if (c == 0xB2 || c == 0xB3 || c == 0xB9 || (c >= superscript && c <= subscript_end))
            width += c == 0x207B ? 528 : 401;
        else {
            if (c == 0xB7)
                width += 318;
            else
                width += codepoint_width(c) > 1 ? 1000 : 838;
        }
    }
    return width / 1000;
}

void surface_free(struct surface *surface)
{
    free(surface->path);
    buffer_free(&surface->plain);
    *surface = (struct surface){0};
}
