/* SPDX-License-Identifier: GPL-3.0-or-later */
/* figure: what the two files that draw pictures share. Lengths in points from the upper left corner
 * of the page. */
#pragma once

#include "modules/pictures/path.h"
#include "modules/pictures/surface/surface.h"

struct page {
    struct surface *surface;
    struct buffer *text; /* scratch */
    struct picture_style style;
    const struct figure *figure;
    struct figure_layout layout; /* its columns and rows are cells of style.digit x style.row */
    double width, height;        /* size of the page */
    double from_x, from_y, to_x, to_y; /* area of this panel on the page, with its labels */
    bool x_labels;                     /* labels are drawn below the plot */
    double gutter; /* least width of the y labels: panels over each other are aligned */
    double left, top, right, bottom; /* area of the plot */
    struct path *path;               /* [curves] of those of this panel, then their error bars */
};

static inline struct plot_area page_area(const struct page *page)
{
    return (struct plot_area){&page->layout.x, &page->layout.y, page->left,
                              page->top,       page->right,     page->bottom};
}

static inline double page_x(const struct page *page, double x)
{
    const struct plot_area area = page_area(page);
    return plot_x(&area, x);
}

static inline double page_y(const struct page *page, double y)
{
    const struct plot_area area = page_area(page);
    return plot_y(&area, y);
}

/* Text of the usual size whose middle is at height y; `align` as of surface_text. Returns the
 * width. */
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

static inline double page_text_width(const struct page *page, const char *text)
{
    return surface_text_width(page->surface, page->style.font, text);
}

/* Fills in `path`, from `arena`, or roughly, within a point; page_free_paths frees what they hold.
 * Returns false if out of memory. */
bool page_trace(struct page *page, bool rough, struct arena *arena);
void page_free_paths(struct page *page);
/* [pt] of a dot of dense data: larger where lines have to be seen on it. */
double page_dot(const struct page *page);

/* A straight line of its own. */
void page_straight(const struct page *page, double x0, double y0, double x1, double y1,
                   const double color[3], double width);
/* Returns the height of labels and title of the axis below a plot. */
double page_labels_height(const struct picture_style *style);
/* Chooses the plot of the panel, its ranges and its ticks. */
void page_lay_out(struct page *page);
/* Returns the position on the page of a number of an axis. */
double page_tick(const struct page *page, bool vertical, double shown);
void page_grid(struct page *page, bool vertical);
/* Ticks, labels and titles. */
void page_axes(struct page *page);
/* Appends `end` to the text, which is made no wider than `room`: in a smaller size, which is
 * returned, if need be without its last letters. */
double page_fit(const struct page *page, struct buffer *text, const char *end, double size,
                double room);

void page_curves(struct page *page);
/* Draws the coloured places of a map, which lie below everything. */
void page_heat(const struct page *page);
/* Draws the bar that says what the colours of a map stand for, right of the plot. */
void page_bar(const struct page *page);
/* [pt] Width of that bar with its numbers. */
double page_bar_width(const struct picture_style *style);
/* Draws areas and thin lines, which lie below all curves. */
void page_guides(const struct page *page);
/* Draws words on paper, so that they can be read above curves. */
void page_labels(struct page *page);
/* Draws the legend's sample of a curve, its middle at height y, if `draw` is set. Returns its
 * width. */
double page_sample(struct page *page, int curve, double x, double y, bool draw);
/* Likewise for the band of a curve. */
double page_band_sample(struct page *page, int curve, double x, double y, bool draw);

/* The title, and after it the legend, if that stands there, in as many lines as it needs, but no
 * further down than a third of the page: then it says how many are left out. Returns the height at
 * which it ends. Only measures unless `draw`. */
double page_heading(struct page *page, bool legend, bool draw);
/* Finds a place in the panel, whose paths are known, where the legend of the page's figure
 * covers neither ink nor the line of zero, as left, top, right, bottom. Returns false if there
 * is none. */
bool legend_place(struct page *page, const struct page *panel, double box[4]);
void legend_draw(struct page *page, const double box[4]);
