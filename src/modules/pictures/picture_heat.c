/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws heat maps in a picture: coloured cells, and the bar that explains the colours. */
#include "modules/pictures/picture.h"
#include "modules/pictures/symbols.h"

#include <math.h>

enum {
    LEVELS = 64,    /* colours of a map; neighbouring ones are hardly distinguishable */
    BAR_TICKS = 6,  /* wanted number of labels beside the bar */
    CATEGORIES = 12 /* colours of maps whose values are numbers of categories, shown as letters */
};

/* Colour map viridis (Smith and van der Walt 2015), whose even steps of lightness can be read in
 * grey. */
static const double anchors[][3] = {{0.267, 0.005, 0.329}, {0.254, 0.265, 0.530},
                                    {0.164, 0.471, 0.558}, {0.135, 0.659, 0.518},
                                    {0.478, 0.821, 0.318}, {0.993, 0.906, 0.144}};

/* Computes the colour of a level, from viridis by interpolation, or for a map of letters from the
 * palette, lightened so that letters on it can be read. */
static void level_color(const struct heat *heat, int level, double color[3])
{
    enum { LAST = (int)COUNT_OF(anchors) - 1 };
    const double place = (double)level / (LEVELS - 1) * LAST; /* position among the anchors */
    const int anchor = place < LAST ? (int)place : LAST - 1;
    for (int c = 0; c < 3; c++)
        color[c] = heat->letters
                       ? 0.65 + 0.35 * style_palette[(size_t)level % style_palette_count][c]
                       : anchors[anchor][c] +
                             (place - anchor) * (anchors[anchor + 1][c] - anchors[anchor][c]);
}

/* Returns the level (colour number) of a value, or -1 if the value is NAN. */
static int level_of(const struct heat *heat, const struct heat_scale *scale, double value)
{
    if (isnan(value))
        return -1;
    if (heat->letters)
        return (int)fmax(0, value) % CATEGORIES;
    return (int)fmin(LEVELS - 1, fmax(0, floor(heat_share(scale, value) * LEVELS)));
}

/* Fills the boxes that were added with a colour. */
static void paint_level(const struct page *page, const double color[3])
{
    /* An outline in the same colour closes the seams between neighbours. */
    surface_paint(page->surface, &(struct brush){.color = color, .width = 0.4, .fill = true});
}

/* Adds the cells of one colour level to the path; neighbouring cells of a column with that level
 * are joined to one box. */
static void add_boxes(const struct page *page, const struct heat *heat,
                      const struct heat_scale *scale, int level)
{
    for (int i = 0; i < heat->x.count; i++) {
        const double *value = heat->value + (size_t)i * (size_t)heat->y.count;
        for (int begin = 0, end; begin < heat->y.count; begin = end) {
            const bool wanted = level_of(heat, scale, value[begin]) == level;
            for (end = begin + 1;
                 end < heat->y.count && wanted && level_of(heat, scale, value[end]) == level;)
                end++;
            if (wanted)
                surface_box(page->surface, page_x(page, heat_edge(&heat->x, i)),
                            page_y(page, heat_edge(&heat->y, end)),
                            page_x(page, heat_edge(&heat->x, i + 1)),
                            page_y(page, heat_edge(&heat->y, begin)));
        }
    }
}

/* Draws the cells of a heat map, colour by colour. */
void page_heat(const struct page *page)
{
    const struct heat *heat = page->figure->heat;
    const struct heat_scale scale = heat_scale_of(heat);
    double color[3];
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    /* one path for each colour, which keeps the file small; -1 are cells without a value */
    for (int level = -1; level < (heat->letters ? CATEGORIES : LEVELS); level++) {
        surface_new_path(page->surface);
        add_boxes(page, heat, &scale, level);
        if (level >= 0)
            level_color(heat, level, color);
        paint_level(page, level >= 0 ? color : style_grid);
    }
    surface_unclip(page->surface);
}

double page_bar_width(const struct picture_style *style)
{
    return style->entry_gap + style->sample / 2 + style->tick + style->tick_gap + 5 * style->font;
}

/* Draws the numbers beside the colour bar of a heat map, whose right edge is at x = `right`, and
 * above it the name of the quantity with its unit and the common power of ten of the numbers. */
static void label_bar(const struct page *page, const struct heat *heat,
                      const struct heat_scale *scale, double right)
{
    const struct picture_style *style = &page->style;
    const double factor = heat->factor > 0 ? heat->factor : 1, height = page->bottom - page->top;
    const struct ticks ticks =
        scale->log
            ? ticks_log(scale->low / factor, scale->high / factor, BAR_TICKS)
            : ticks_linear(scale->low / factor, scale->high / factor, BAR_TICKS, 2 * BAR_TICKS);
    char text[TICK_TEXT_SIZE];
    for (int i = 0; i < ticks.count; i++) {
        const double tick_y =
            page->bottom - height * heat_share(scale, factor * tick_value(&ticks, i, scale->log));
        tick_text(&ticks, i, scale->log, text);
        page_straight(page, right, tick_y, right + style->tick, tick_y, style_black,
                      style->frame_line);
        buffer_clear(page->text);
        put_number_symbols(page->text, text_of(text));
        page_text(page, right + style->tick + style->tick_gap, tick_y, 0, style_black,
                  buffer_view(page->text));
    }
    buffer_clear(page->text);
    put_name_symbols(page->text, text_of(heat->title));
    if (ticks.exponent || (heat->unit && *heat->unit))
        buffer_put(page->text, TEXT(" ["));
    if (ticks.exponent) {
        buffer_format(page->text, "10^%d%s", ticks.exponent, heat->unit && *heat->unit ? " " : "");
    }
    if (heat->unit && *heat->unit)
        put_unit_symbols(page->text, text_of(heat->unit));
    if (ticks.exponent || (heat->unit && *heat->unit))
        buffer_char(page->text, ']');
    page_text(page, page->width - style->edge, page->top - style->font, 1, style_black,
              buffer_view(page->text));
}

/* Draws the colour bar beside a heat map: the colours from the lowest value to the highest, a frame
 * and labels. Draws nothing if there is only one value, or for maps of letters. */
void page_bar(const struct page *page)
{
    const struct heat *heat = page->figure->heat;
    const struct heat_scale scale = heat_scale_of(heat);
    const struct picture_style *style = &page->style;
    const double left = page->right + style->entry_gap, right = left + style->sample / 2,
                 step = (page->bottom - page->top) / LEVELS;
    double color[3];
    if (heat->letters || !(scale.high > scale.low)) /* letters need no bar, nor does one value */
        return;
    for (int level = 0; level < LEVELS; level++) {
        level_color(heat, level, color);
        surface_box(page->surface, left, page->bottom - (level + 1) * step, right,
                    page->bottom - level * step);
        paint_level(page, color);
    }
    surface_box(page->surface, left, page->top, right, page->bottom);
    surface_paint(page->surface, &(struct brush){.color = style_black, .width = style->frame_line});
    label_bar(page, heat, &scale, right);
}
