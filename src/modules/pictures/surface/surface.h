/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * figure: what pictures are drawn on. Lengths in points from the upper left corner of the page.
 *
 * A path is built of lines and circles, then stroked or filled, which ends it. Two kinds of surface
 * know how: svg.c writes SVG itself, cairo_surface.c hands all to cairo.
 */
#pragma once

#include "modules/pictures/style.h"

#include <hooke/base/safe_text.h>
#include "modules/pictures/pictures.h"

enum path_kind { PATH_MOVE, PATH_LINE, PATH_CIRCLE, PATH_CLOSE };

struct path_point {
    enum path_kind kind;
    double x, y, radius; /* end point, or centre of a circle; unused by PATH_CLOSE */
};

struct brush {
    const double *color;               /* [3] */
    double width;                      /* width of a line; 0 with fill draws no outline */
    const struct style_dashes *dashes; /* dashes, or NULL for a solid line */
    double dash;                       /* their unit */
    double opacity;                    /* 0 counts as 1 */
    bool fill;                         /* the inside, too */
};

struct surface_text {
    double x, y;  /* the baseline */
    double align; /* 0 starts at x, 0.5 is centred, 1 ends there */
    bool turned;  /* rotated by 90 degrees, to be read from below */
    double size;
    const double *color;
    const char *text; /* plain text, see surface_put_text */
};

struct surface;

struct surface_kind {
    void (*paint)(struct surface *surface, const struct brush *brush); /* surface->path */
    /* box is left, top, right, bottom; NULL ends the clipping */
    void (*clip)(struct surface *surface, const double box[4]);
    void (*text)(struct surface *surface, const struct surface_text *text);
    double (*text_width)(struct surface *surface, double size, const char *text);
};

struct surface {
    const struct surface_kind *kind;
    struct path_point *path;
    size_t points, capacity;
    struct buffer plain; /* scratch */
    bool failed;         /* there was no memory */
};

void surface_move(struct surface *surface, double x, double y);
void surface_line(struct surface *surface, double x, double y);
void surface_circle(struct surface *surface, double x, double y, double radius);
void surface_box(struct surface *surface, double left, double top, double right, double bottom);
void surface_close(struct surface *surface);
void surface_new_path(struct surface *surface);
/* Strokes or fills the path, and forgets it. */
void surface_paint(struct surface *surface, const struct brush *brush);
/* Nothing is drawn outside, until surface_unclip(). */
void surface_clip(struct surface *surface, double left, double top, double right, double bottom);
void surface_unclip(struct surface *surface);
/* Any text: what is not plain is made so. Returns its width. */
double surface_put_text(struct surface *surface, const struct surface_text *text);
double surface_text_width(struct surface *surface, double size, const char *text);
void surface_free(struct surface *surface);

/* [size] Width of plain text in DejaVu Sans, the widest of the fonts that pictures ask for. */
double text_advance(struct text text);

/* Appends an SVG document; done by svg_end. */
struct svg_surface {
    struct surface surface;
    struct buffer *output;
    double font; /* size of most texts */
    int clips;
};

void svg_begin(struct svg_surface *svg, double width, double height, double font, const char *title,
               struct buffer *output);
void svg_end(struct svg_surface *svg);

/* Draws a figure on a page of that size; returns false if out of memory. */
bool picture_draw(struct surface *surface, const struct figure *figure, double width,
                  double height);
