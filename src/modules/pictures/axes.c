/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Axes of a picture: choice of the plot's area, ticks, labels, titles. */
#include "modules/pictures/picture.h"
#include "modules/pictures/symbols.h"

#include <stdio.h>

void page_straight(const struct page *page, double x0, double y0, double x1, double y1,
                   const double color[3], double width)
{
    surface_move(page->surface, x0, y0);
    surface_line(page->surface, x1, y1);
    surface_paint(page->surface, &(struct brush){.color = color, .width = width});
}

/* Scales by the factor of the axis, whose labels may be in another unit than its data. */
double page_tick(const struct page *page, bool vertical, double shown)
{
    const struct axis *axis = vertical ? &page->figure->y : &page->figure->x;
    double fraction =
        fraction_of(vertical ? &page->layout.y : &page->layout.x, shown * axis_factor(axis));
    return vertical ? page->bottom - fraction * (page->bottom - page->top)
                    : page->left + fraction * (page->right - page->left);
}

/* Returns the height of labels below a plot, from the tick at its edge to the label. */
double page_labels_height(const struct picture_style *style)
{
    return style->tick + style->tick_gap + style->font + style->leading;
}

/* Draws a grid line at each tick of the vertical or of the horizontal axis. */
void page_grid(struct page *page, bool vertical)
{
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;
    const double width = page->style.grid_line;
    for (int i = 0; i < ticks->count; i++) {
        const double position = page_tick(page, vertical, tick_value(ticks, i, decades));
        if (vertical)
            page_straight(page, page->left, position, page->right, position, style_grid, width);
        else
            page_straight(page, position, page->top, position, page->bottom, style_grid, width);
    }
}

/* Draws one tick outwards from the frame at a position on the page. */
static void draw_tick(struct page *page, bool vertical, double position, double length)
{
    const double width = page->style.frame_line;
    if (vertical)
        page_straight(page, page->left - length, position, page->left, position, style_black,
                      width);
    else
        page_straight(page, position, page->bottom, position, page->bottom + length, style_black,
                      width);
}

/* Returns `text` as rewritten by put(), in the scratch memory of the page. */
static const char *page_symbols(const struct page *page,
                                void (*put)(struct buffer *output, struct text text),
                                const char *text)
{
    buffer_clear(page->text);
    put(page->text, text_of(text));
    page->surface->failed |= page->text->failed;
    return buffer_view(page->text);
}

/* Returns the label of tick i with symbols, in the scratch memory of the page. */
static const char *tick_label(const struct page *page, bool vertical, int i)
{
    char text[TICK_TEXT_SIZE];
    const struct ticks *const ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    tick_text(ticks, i, vertical ? page->layout.y_decades : page->layout.x_decades, text);
    return page_symbols(page, put_number_symbols, text);
}

/* Draws the ticks without labels of the vertical axis if `vertical` is set, else of the horizontal
 * one, if they are far enough apart: omitted decades, 2, 3 … 9 in each decade, or parts of a step
 * that are round numbers. */
static void draw_minor_ticks(struct page *page, bool vertical)
{
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;
    const double low = vertical ? page->top : page->left;
    const double high = vertical ? page->bottom : page->right,
                 min_gap = 1.5 * page->style.minor_tick;
    /* number of parts into which minor ticks divide the step between two labels */
    int parts = tick_parts(ticks);
    if (decades)
        parts = ticks->step > 1 ? (int)ticks->step : 9;
    const double length = fabs(page_tick(page, vertical, tick_value(ticks, 1, decades)) -
                               page_tick(page, vertical, tick_value(ticks, 0, decades)));
    if (ticks->count < 2 || length < min_gap * parts * (decades && ticks->step == 1 ? 2 : 1))
        return;
    for (int i = -1; i < ticks->count; i++) {
        for (int part = 1; part < parts; part++) {
            const double power = ticks->first + i * ticks->step;
            double value;
            if (!decades)
                value = power + part * ticks->step / parts;
            else
                value = ticks->step > 1 ? pow(10, power + part) : (part + 1) * pow(10, power);
            const double position = page_tick(page, vertical, value);
            if (position >= low && position <= high)
                draw_tick(page, vertical, position, page->style.minor_tick);
        }
    }
}

/* Returns where the middle of a label of x is drawn: at its tick, or left of it where the label
 * would leave the page. */
static double x_label_middle(const struct page *page, double position, double width)
{
    return fmin(position, page->to_x + 1.5 * page->style.edge - width / 2);
}

/* Draws ticks at the frame, with their labels. */
static void draw_ticks(struct page *page, bool vertical)
{
    const struct picture_style *style = &page->style;
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;

    for (int i = 0; i < ticks->count; i++) {
        const double position = page_tick(page, vertical, tick_value(ticks, i, decades)),
                     label_y = page->bottom + style->tick + style->tick_gap + style->font / 2;
        const char *text = tick_label(page, vertical, i);
        draw_tick(page, vertical, position, style->tick);
        if (vertical) {
            page_text(page, page->left - style->tick - style->tick_gap, position, 1, style_black,
                      text);
        } else if (page->x_labels) {
            page_text(page, x_label_middle(page, position, page_text_width(page, text)), label_y,
                      0.5, style_black, text);
        }
    }
    draw_minor_ticks(page, vertical);
}

/* Cuts off characters at the end until the text is no wider than `width` [pt]; it then ends in
 * three dots. */
static void shorten_text(const struct page *page, struct buffer *text, double size, double width)
{
    static const char dots[] = "…";
    size_t len = text->len;
    while (len > 0 && !text->failed &&
           surface_text_width(page->surface, size, buffer_view(text)) > width) {
        do
            len--;
        while (len > 0 && ((unsigned char)text->data[len] & 0xC0) == 0x80);
        text->len = len;
        text->data[len] = '\0';
        if (len > 0)
            buffer_put(text, TEXT(dots));
    }
}

/* Appends `end`, which holds the unit and is never shortened, to *text, shortened so that both fit
 * into `room` [pt] at the font size `size` [pt]. Smaller fonts down to STYLE_SHRINK * size are
 * tried first. Returns the font size. */
double page_fit(const struct page *page, struct buffer *text, const char *end, double size,
                double room)
{
    struct buffer both = {0};
    buffer_put(&both, buffer_text(text));
    buffer_put(&both, text_of(end));
    const double width = surface_text_width(page->surface, size, buffer_view(&both));
    const double bare = surface_text_width(page->surface, size, end); /* is never shortened */
    const double fitted = width > room ? fmin(fmax(size * room / width, STYLE_SHRINK * size),
                                              size * fmax(room, 1) / fmax(bare, 1))
                                       : size;
    shorten_text(page, text, fitted, room - surface_text_width(page->surface, fitted, end));
    buffer_put(text, text_of(text->len || *end != ' ' ? end : end + 1));
    page->surface->failed |= text->failed || both.failed;
    buffer_free(&both);
    return fitted;
}

/* Writes the unit after the name: " [m·s⁻¹]"; with a power and an offset " − 2.2326 m [10⁻⁶ m]". */
static void put_axis_unit(const struct ticks *ticks, struct text unit, struct buffer *output)
{
    char offset[TICK_TEXT_SIZE], power[16];
    if (ticks->offset != 0) {
        offset_text(ticks, offset);
        buffer_put(output, TEXT(" "));
        put_number_symbols(output, text_of(offset));
        buffer_put(output, unit.len ? TEXT(" ") : TEXT(""));
        put_unit_symbols(output, unit);
    }
    if (unit.len || ticks->exponent) {
        buffer_put(output, TEXT(" ["));
        snprintf(power, sizeof power, "1e%d", ticks->exponent);
        put_number_symbols(output, ticks->exponent ? text_of(power) : TEXT(""));
        buffer_put(output, unit.len && ticks->exponent ? TEXT(" ") : TEXT(""));
        put_unit_symbols(output, unit);
        buffer_char(output, ']');
    }
}

/* Draws the title of the vertical or horizontal axis with its unit, in the middle of the plot, or
 * shifted if it is longer than the plot; it is shortened if it is longer than the panel. */
static void draw_axis_title(struct page *page, bool vertical)
{
    const struct picture_style *style = &page->style;
    const struct axis *axis = vertical ? &page->figure->y : &page->figure->x;
    /* the title of x stays clear of the title of y */
    const double low = vertical ? page->from_y : page->from_x + 1.6 * style->font;
    const double high = vertical ? page->to_y : page->to_x + style->edge;
    struct buffer name = {0}, unit = {0};
    put_name_symbols(&name, text_of(axis->label));
    put_axis_unit(vertical ? &page->layout.y_ticks : &page->layout.x_ticks, text_of(axis->unit),
                  &unit);
    const double size = page_fit(page, &name, buffer_view(&unit), style->font, high - low);
    const double half = surface_text_width(page->surface, size, buffer_view(&name)) / 2;
    const double middle =
        vertical ? (page->top + page->bottom) / 2 : (page->left + page->right) / 2;
    const double position = fmin(fmax(middle, low + half), high - half);
    struct surface_text text = {.x = position,
                                .y = position,
                                .align = 0.5,
                                .turned = vertical,
                                .size = size,
                                .color = style_black,
                                .text = buffer_view(&name)};
    if (vertical)
        text.x = page->from_x + style->font;
    else
        text.y = page->bottom + page_labels_height(style) - 0.14 * style->font;
    surface_put_text(page->surface, &text);
    page->surface->failed |= unit.failed;
    buffer_free(&name);
    buffer_free(&unit);
}

void page_axes(struct page *page)
{
    for (int vertical = 0; vertical < 2; vertical++)
        draw_ticks(page, vertical);
    draw_axis_title(page, true);
    if (page->x_labels)
        draw_axis_title(page, false);
}

/* Returns the width [pt] of the widest label of y. */
static double widest_label(struct page *page)
{
    double width = 0;
    for (int i = 0; i < page->layout.y_ticks.count; i++)
        width = fmax(width, page_text_width(page, tick_label(page, true, i)));
    return width;
}

/* Returns true if the labels of an axis keep a distance of 1.1 (vertical) or 0.6 font sizes from
 * each other. */
static bool labels_apart(const struct page *page, bool vertical)
{
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;
    const double min_gap = (vertical ? 1.1 : 0.6) * page->style.font;
    double end = -INFINITY;
    for (int i = 0; i < ticks->count && (vertical || page->x_labels); i++) {
        const double place = page_tick(page, vertical, tick_value(ticks, i, decades)),
                     width = vertical ? 0 : page_text_width(page, tick_label(page, vertical, i));
        const double position = vertical ? -place : x_label_middle(page, place, width) - width / 2;
        if (position < end + min_gap)
            return false;
        end = position + width;
    }
    return true;
}

/* Adds a margin to the range of x if the figure is a plane of points only, so that none lies on the
 * frame. */
static void widen_plane(const struct figure *figure, struct extent *extent)
{
    bool points = figure->plane && !figure->x.fixed && !figure->x.log && !figure->equal;
    for (int c = 0; c < figure->curves; c++)
        points &= figure->curve[c].points || !curve_drawn(figure, c);
    const double air = 0.03 * (extent->high - extent->low);
    if (points && air > 0 && isfinite(air)) {
        extent->low -= air;
        extent->high += air;
    }
}

/* Chooses plot area, ranges and ticks of a panel as for a text figure with cells of digit x row
 * points; reduces the number of ticks until labels do not overlap. */
void page_lay_out(struct page *page)
{
    struct figure figure = *page->figure;
    struct extent x = axis_extent(&figure, false, true), y = axis_extent(&figure, true, true);
    const struct picture_style *style = &page->style;
    struct dot_grid grid = charset_braille.dots;
    double gutter = page->gutter, density = 1; /* number of ticks relative to a text figure's */
    bool fits;

    widen_plane(&figure, &x);
    page->layout = (struct figure_layout){
        .charset = &charset_braille, .frame = true, .hidden = x.hidden + y.hidden};
    page->top = page->from_y;
    page->bottom = page->to_y - (page->x_labels ? page_labels_height(style) : 0);
    page->bottom = fmax(page->bottom, page->top + 1);
    page->right = page->to_x;
    do { /* the labels of y need room, and the room determines the labels */
        gutter = fmax(gutter, widest_label(page));
        page->left =
            fmin(page->from_x + style->font + style->edge + gutter + style->tick + style->tick_gap,
                 page->right - 1);
        double width = page->right - page->left, height = page->bottom - page->top;
        page->layout.columns = (int)fmax(density * width / style->digit, 1);
        page->layout.rows = (int)fmax(density * height / style->row, 1);
        /* Equal axes have to be equal in points, not in cells. */
        figure.aspect = height / width * (page->layout.columns - 1.0 / grid.dots_horizontal) /
                        (page->layout.rows - 1.0 / grid.dots_vertical);
        layout_scales(&figure, &page->layout, x, y);
        const bool are_apart = labels_apart(page, false) && labels_apart(page, true);
        fits = widest_label(page) <= gutter && (are_apart || density < 0.02);
        density *= are_apart ? 1 : 0.8;
    } while (!fits);
    page->gutter = gutter;
}
