/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws what accompanies the curves of a picture: lines, shaded areas, and words beside points. */
#include "modules/pictures/picture.h"

/* Draws guides as thin grey lines, or as shaded areas. */
void page_guides(const struct page *page)
{
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    for (int i = 0; i < page->figure->guides; i++) {
        const struct figure_guide *guide = &page->figure->guide[i];
        const double x[2] = {page_x(page, guide->x[0]), page_x(page, guide->x[1])},
                     y[2] = {page_y(page, guide->y[0]), page_y(page, guide->y[1])};
        if (!guide->area) {
            page_straight(page, x[0], y[0], x[1], y[1], style_gray, page->style.thin_line);
            continue;
        }
        surface_box(page->surface, x[0], fmin(y[0], y[1]), x[1], fmax(y[0], y[1]));
        surface_paint(page->surface, &(struct brush){.color = style_grid, .fill = true});
    }
    surface_unclip(page->surface);
}

/* Draws each label left of its point, on nearly opaque white. */
void page_labels(struct page *page)
{
    for (int i = 0; i < page->figure->labels; i++) {
        const struct figure_label *label = &page->figure->label[i];
        const double x = page_x(page, label->x) - page->style.sample_gap - page->style.mark,
                     y = page_y(page, label->y), half = page->style.font / 2,
                     width = page_text_width(page, label->text);
        if (!isfinite(x + y))
            continue;
        surface_box(page->surface, x - width, y - half, x, y + half);
        surface_paint(page->surface,
                      &(struct brush){.color = style_white, .opacity = 0.8, .fill = true});
        page_text(page, x, y, 1, style_black, label->text);
    }
}
