/* SPDX-License-Identifier: GPL-3.0-or-later */
/* figure: what the two files that draw pictures share. Lengths in points from the upper left corner
 * of the page. */
#ifndef HOOKE_FIGURE_PICTURE_H
#define HOOKE_FIGURE_PICTURE_H

#include "figure/internal.h"
#include "figure/surface.h"

struct page {
    struct surface *surface;
    struct buffer *text; /* scratch */
    struct picture_style style;
    const struct figure *figure;
    struct figure_layout layout; /* its columns and rows are cells of style.digit x style.row */
    double width, height;        /* of the page */
    double from_x, from_y, to_x, to_y; /* of the page: this panel, with its labels */
    bool x_labels;                     /* below the plot */
    double gutter; /* least width of the y labels: panels over each other are aligned */
    double left, top, right, bottom; /* of the plot */
    uint8_t *ink; /* scratch: which grains of the plot a curve has passed through */
    int grains;   /* along a point: GRAINS, or a half or a quarter of it */
};

#define GRAINS 4

/* [byte] that `ink` needs for the plot, with so many grains along a point. */
size_t page_ink_size(const struct page *page, int grains);
void page_ink_clear(struct page *page, int grains);
/* Whether a line in the plot passes where there was no ink; then there is. */
bool page_ink_line(const struct page *page, double x0, double y0, double x1, double y1);
/* Makes the path of a curve that of the surface; NAN is a gap. */
void page_path(struct page *page, const struct curve *curve);

static inline double page_x(const struct page *page, double x)
{
    return page->left + fraction_of(&page->layout.x, x) * (page->right - page->left);
}

static inline double page_y(const struct page *page, double y)
{
    return page->bottom - fraction_of(&page->layout.y, y) * (page->bottom - page->top);
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

void page_curves(struct page *page);
/* What stands for a curve in the legend, its middle at height y. Returns its width; only that
 * unless `draw`. */
double page_sample(struct page *page, int curve, double x, double y, bool draw);
/* Likewise for the band of a curve. */
double page_band_sample(struct page *page, int curve, double x, double y, bool draw);
#endif
