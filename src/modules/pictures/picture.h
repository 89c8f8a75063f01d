/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The page of a picture and the functions that draw its parts, shared by the files of this folder.
 * Lengths are in points from the upper left corner of the page. picture_draw() in picture.c calls:
 * page_lay_out(), page_trace(), page_heading(), page_heat(), page_grid(), page_curves(),
 * page_axes(), page_bar(), page_free_paths(). */
#pragma once

#include "modules/pictures/path.h"
#include "modules/pictures/surface/surface.h"

/* One panel of a picture: the surface it is drawn on, its figure and its area. Pages of the same
 * picture differ in figure, layout, area and paths. */
struct page {
    struct surface *surface;
    struct buffer *text; /* scratch memory for one text; its content is valid until the next use */
    struct picture_style style;
    const struct figure *figure;
    struct figure_layout layout; /* its columns and rows are cells of style.digit x style.row */
    double width, height;        /* [pt] size of the whole page */
    double from_x, from_y, to_x, to_y; /* area of this panel on the page, with its labels */
    bool x_labels; /* ticks of x get labels; panels with a common x have one set */
    double gutter; /* least width of the y labels: panels over each other are aligned */
    double left, top, right, bottom; /* area of the plot */
    struct path *path; /* [2 * curves] paths of the curves, then of their error bars */
};

/* Returns the area of the plot with its scales, as the functions for paths take it. */
static inline struct plot_area page_area(const struct page *page)
{
    return (struct plot_area){&page->layout.x, &page->layout.y, page->left,
                              page->top,       page->right,     page->bottom};
}

/* Returns the position on the page [pt] of a value of x. */
static inline double page_x(const struct page *page, double x)
{
    const struct plot_area area = page_area(page);
    return plot_x(&area, x);
}

/* Returns the position on the page [pt] of a value of y. */
static inline double page_y(const struct page *page, double y)
{
    const struct plot_area area = page_area(page);
    return plot_y(&area, y);
}

/* Draws text of the usual size, vertically centred at y; `align` as in struct surface_text. Returns
 * its width. */
static inline double page_text(const struct page *page, double x, double y, double align,
                               const double *color, const char *text)
{
    const double size = page->style.font; /* half of a digit's height above the baseline */
    return surface_put_text(page->surface, &(struct surface_text){.x = x,
                                                                  .y = y + 0.36 * size,
                                                                  .align = align,
                                                                  .size = size,
                                                                  .color = color,
                                                                  .text = text});
}

/* Returns the width [pt] of a text of the usual size. */
static inline double page_text_width(const struct page *page, const char *text)
{
    return surface_text_width(page->surface, page->style.font, text);
}

/* Computes page->path, in memory of `arena`: few enough corners for a file, or rough paths within 1
 * pt. The caller frees their corners with page_free_paths(). Returns false if out of memory. */
bool page_trace(struct page *page, bool rough, struct arena *arena);
/* Frees the corners of all paths. */
void page_free_paths(struct page *page);
/* Returns the diameter [pt] of a dot of dense data, which is larger if lines are drawn on it. */
double page_dot(const struct page *page);

/* Draws a straight line. */
void page_straight(const struct page *page, double x0, double y0, double x1, double y1,
                   const double color[3], double width);
/* Returns the height of labels and title of the axis below a plot. */
double page_labels_height(const struct picture_style *style);
/* Chooses the area of the plot within the panel, its ranges and its ticks. */
void page_lay_out(struct page *page);
/* Returns the position on the page of a number of an axis, in the unit of its labels. */
double page_tick(const struct page *page, bool vertical, double shown);
/* Draws the lines of the grid that cross one axis. */
void page_grid(struct page *page, bool vertical);
/* Draws ticks, their labels, and the titles of both axes. */
void page_axes(struct page *page);
/* Shortens text so that it and `end` are no wider than `room` [pt], and appends `end`. The font is
 * reduced first, down to STYLE_SHRINK, then letters are cut off. Returns the size of the font. */
double page_fit(const struct page *page, struct buffer *text, const char *end, double size,
                double room);

/* Draws guides, bands, curves, points, arrows and labels of the figure. */
void page_curves(struct page *page);
/* Draws the coloured cells of a heat map, which lie below everything else. */
void page_heat(const struct page *page);
/* Draws the bar that explains the colours of a heat map, right of the plot. */
void page_bar(const struct page *page);
/* Returns the width [pt] of that bar with its numbers. */
double page_bar_width(const struct picture_style *style);
/* Draws areas and thin lines, which lie below all curves. */
void page_guides(const struct page *page);
/* Draws the words of the figure on white, so that they can be read above curves. */
void page_labels(struct page *page);
/* Draws the legend's sample of a curve, from x on, its middle at height y, if `draw` is set.
 * Returns its width [pt]. */
double page_sample(struct page *page, int curve, double x, double y, bool draw);
/* Draws the legend's sample of a curve's band in the same way. */
double page_band_sample(struct page *page, int curve, double x, double y, bool draw);

/* Draws the title and, if `legend` is set, the legend behind it, in as many lines as needed up to a
 * third of the page; then it tells how many entries are left out. Returns the height [pt] at which
 * the plot may begin. Only measures unless `draw` is set. */
double page_heading(struct page *page, bool legend, bool draw);
/* Finds a rectangle (left, top, right, bottom) in the panel, whose paths are known, where the
 * legend of the page's figure covers neither ink nor the line of zero. Returns false if there is
 * none. */
bool legend_place(struct page *page, const struct page *panel, double box[4]);
/* Draws the legend in that rectangle. */
void legend_draw(struct page *page, const double box[4]);
