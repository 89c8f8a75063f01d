/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Surfaces that pictures are drawn on. Lengths are in points from the upper left corner of the
 * page. A path is built with surface_move(), surface_line(), surface_circle(), surface_box() and
 * surface_close(), then stroked or filled by surface_paint(), which ends it. There are two kinds:
 * svg.c writes SVG itself, and cairo_surface.c passes all to cairo. */
#pragma once

#include "modules/pictures/style.h"

#include <hooke/base/safe_text.h>
#include "modules/pictures/pictures.h"

enum path_kind { PATH_MOVE, PATH_LINE, PATH_CIRCLE, PATH_CLOSE };

/* One element of a path. */
struct path_point {
    enum path_kind kind;
    double x, y, radius; /* end point, or centre of a circle; unused by PATH_CLOSE */
};

/* Colour, line and filling with which a path is painted. */
struct brush {
    const double *color;               /* [3] red, green, blue, 0 to 1 */
    double width;                      /* width of a line; 0 with fill draws no outline */
    const struct style_dashes *dashes; /* dashes, or NULL for a solid line */
    double dash;                       /* [pt] unit of the dashes */
    double opacity;                    /* 0 counts as 1 */
    bool fill;                         /* the inside is filled, too */
};

/* One line of text. */
struct surface_text {
    double x, y;  /* [pt] the baseline, at the point that align tells */
    double align; /* 0 starts at x, 0.5 is centred, 1 ends there */
    bool turned;  /* rotated by 90 degrees, to be read from below */
    double size;  /* [pt] of the font */
    const double *color;
    const char *text; /* plain text, see surface_put_text */
};

struct surface;

/* Functions of one kind of surface. Failures set surface->failed. */
struct surface_kind {
    /* paints surface->path */
    void (*paint)(struct surface *surface, const struct brush *brush);
    /* box is left, top, right, bottom; NULL ends the clipping */
    void (*clip)(struct surface *surface, const double box[4]);
    void (*text)(struct surface *surface, const struct surface_text *text);
    double (*text_width)(struct surface *surface, double size, const char *text);
};

/* A surface with the path that is being built. Zero but for `kind` at the start; freed by
 * surface_free(). */
struct surface {
    const struct surface_kind *kind;
    struct path_point *path;
    size_t points, capacity;
    struct buffer plain; /* scratch memory for text that is made safe */
    bool failed;         /* no memory was left; the picture is incomplete */
};

/* Begins a line at this point. */
void surface_move(struct surface *surface, double x, double y);
/* Adds a line to this point, or begins one if the path is empty. */
void surface_line(struct surface *surface, double x, double y);
/* Adds a closed circle. */
void surface_circle(struct surface *surface, double x, double y, double radius);
/* Adds a closed rectangle. */
void surface_box(struct surface *surface, double left, double top, double right, double bottom);
/* Closes the current line. */
void surface_close(struct surface *surface);
/* Forgets the path. */
void surface_new_path(struct surface *surface);
/* Strokes or fills the path, and forgets it. */
void surface_paint(struct surface *surface, const struct brush *brush);
/* Restricts drawing to a rectangle until surface_unclip(). Calls are not nested. */
void surface_clip(struct surface *surface, double left, double top, double right, double bottom);
void surface_unclip(struct surface *surface);
/* Draws a text; characters that cannot be printed are replaced. Returns its width. */
double surface_put_text(struct surface *surface, const struct surface_text *text);
/* Returns the width [pt] of a text in a font of that size [pt]. */
double surface_text_width(struct surface *surface, double size, const char *text);
/* Frees the path and the scratch memory. */
void surface_free(struct surface *surface);

/* [size] Width of plain text in DejaVu Sans, the widest of the fonts that pictures ask for. */
double text_advance(struct text text);

/* A surface that appends an SVG document to a buffer. */
struct svg_surface {
    struct surface surface;
    struct buffer *output;
    double font; /* [pt] size of most texts, which is stated once */
    int clips;   /* number of clip paths so far, whose names are numbered */
};

/* Begins the document, of this size [pt], and initializes *svg; svg_end() completes it. */
void svg_begin(struct svg_surface *svg, double width, double height, double font, const char *title,
               struct buffer *output);
void svg_end(struct svg_surface *svg);

/* Draws a figure on a page of that size; returns false if out of memory. */
bool picture_draw(struct surface *surface, const struct figure *figure, double width,
                  double height);
