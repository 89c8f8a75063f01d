/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pictures: the page, its axes, titles and legend. */
#include "figure/picture.h"
#include "figure/symbols.h"

#include <stdio.h>
#include <string.h>

static void draw_straight(const struct page *page, double x0, double y0, double x1, double y1,
                          const double color[3], double width)
{
    surface_move(page->surface, x0, y0);
    surface_line(page->surface, x1, y1);
    surface_paint(page->surface, &(struct brush){.color = color, .width = width});
}

/* ---- axes ---- */

static double tick_position(const struct page *page, bool vertical, double shown)
{
    const struct axis *axis = vertical ? &page->figure->y : &page->figure->x;
    double fraction =
        fraction_of(vertical ? &page->layout.y : &page->layout.x, shown * axis_factor(axis));
    return vertical ? page->bottom - fraction * (page->bottom - page->top)
                    : page->left + fraction * (page->right - page->left);
}

/* Of the plot: from its upper end, with tick and label. */
static double labels_height(const struct picture_style *style)
{
    return style->tick + style->tick_gap + style->font + style->leading;
}

static void draw_grid(struct page *page, bool vertical)
{
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;
    const double width = page->style.grid_line;
    for (int i = 0; i < ticks->count; i++) {
        const double at = tick_position(page, vertical, tick_value(ticks, i, decades));
        if (vertical)
            draw_straight(page, page->left, at, page->right, at, style_grid, width);
        else
            draw_straight(page, at, page->top, at, page->bottom, style_grid, width);
    }
}

static void draw_tick(struct page *page, bool vertical, double at, double length)
{
    const double width = page->style.frame_line;
    if (vertical)
        draw_straight(page, page->left - length, at, page->left, at, style_black, width);
    else
        draw_straight(page, at, page->bottom, at, page->bottom + length, style_black, width);
}

static const char *symbols(const struct page *page,
                           void (*put)(struct buffer *out, struct text text), const char *text)
{
    buffer_clear(page->text);
    put(page->text, text_of(text));
    page->surface->failed |= page->text->failed;
    return buffer_view(page->text);
}

static const char *tick_label(const struct page *page, bool vertical, int i)
{
    char text[TICK_TEXT_SIZE];
    tick_text(vertical ? &page->layout.y_ticks : &page->layout.x_ticks, i,
              vertical ? page->layout.y_decades : page->layout.x_decades, text);
    return symbols(page, put_number_symbols, text);
}

/* Where there is no label, if there is room: unlabelled decades, or 2, 3 … 9 in each, or parts of a
 * step that are whole in its digit. */
static void draw_minor_ticks(struct page *page, bool vertical)
{
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;
    const double from = vertical ? page->top : page->left,
                 to = vertical ? page->bottom : page->right, apart = 1.5 * page->style.minor_tick;
    const int parts = decades ? (ticks->step > 1 ? (int)ticks->step : 9) : tick_parts(ticks);
    const double length = fabs(tick_position(page, vertical, tick_value(ticks, 1, decades)) -
                               tick_position(page, vertical, tick_value(ticks, 0, decades)));
    if (ticks->count < 2 || length < apart * parts * (decades && ticks->step == 1 ? 2 : 1))
        return;
    for (int i = -1; i < ticks->count; i++) {
        for (int part = 1; part < parts; part++) {
            const double power = ticks->first + i * ticks->step;
            const double value = !decades          ? power + part * ticks->step / parts
                                 : ticks->step > 1 ? pow(10, power + part)
                                                   : (part + 1) * pow(10, power);
            const double at = tick_position(page, vertical, value);
            if (at >= from && at <= to)
                draw_tick(page, vertical, at, page->style.minor_tick);
        }
    }
}

/* At the frame, with their labels. */
static void draw_ticks(struct page *page, bool vertical)
{
    const struct picture_style *style = &page->style;
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;

    for (int i = 0; i < ticks->count; i++) {
        const double at = tick_position(page, vertical, tick_value(ticks, i, decades)),
                     below = page->bottom + style->tick + style->tick_gap + style->font / 2;
        const char *text = tick_label(page, vertical, i);
        draw_tick(page, vertical, at, style->tick);
        if (vertical) {
            page_text(page, page->left - style->tick - style->tick_gap, at, 1, style_black, text);
        } else if (page->x_labels) {
            const double half = page_text_width(page, text) / 2;
            page_text(page, fmin(at, page->to_x + 1.5 * style->edge - half), below, 0.5,
                      style_black, text);
        }
    }
    draw_minor_ticks(page, vertical);
}

/* "v/ω₀ [m·s⁻¹]"; with a power and an offset "y − 2.2326 m [10⁻⁶ m]". */
static const char *axis_text(const struct page *page, bool vertical)
{
    const struct axis *axis = vertical ? &page->figure->y : &page->figure->x;
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    const struct text unit = text_of(axis->unit);
    struct buffer *out = page->text;
    char offset[TICK_TEXT_SIZE], power[16];

    buffer_clear(out);
    put_name_symbols(out, text_of(axis->label));
    if (ticks->offset != 0) {
        offset_text(ticks, offset);
        buffer_put(out, TEXT(" "));
        put_number_symbols(out, text_of(offset));
        buffer_put(out, TEXT(" "));
        put_unit_symbols(out, unit);
    }
    if (unit.len || ticks->exponent) {
        buffer_put(out, out->len ? TEXT(" [") : TEXT("["));
        snprintf(power, sizeof power, "1e%d", ticks->exponent);
        put_number_symbols(out, ticks->exponent ? text_of(power) : TEXT(""));
        buffer_put(out, unit.len && ticks->exponent ? TEXT(" ") : TEXT(""));
        put_unit_symbols(out, unit);
        buffer_char(out, ']');
    }
    page->surface->failed |= out->failed;
    return buffer_view(out);
}

static void draw_axis_titles(struct page *page)
{
    const struct picture_style *style = &page->style;

    surface_put_text(page->surface, &(struct surface_text){.x = page->from_x + style->font,
                                                           .y = (page->top + page->bottom) / 2,
                                                           .align = 0.5,
                                                           .turned = true,
                                                           .size = style->font,
                                                           .color = style_black,
                                                           .text = axis_text(page, true)});
    if (page->x_labels)
        page_text(page, (page->left + page->right) / 2,
                  page->bottom + labels_height(style) - style->font / 2, 0.5, style_black,
                  axis_text(page, false));
}

static double widest_label(struct page *page)
{
    double width = 0;
    for (int i = 0; i < page->layout.y_ticks.count; i++)
        width = fmax(width, page_text_width(page, tick_label(page, true, i)));
    return width;
}

/* The room for the plot; ranges and ticks as for a text figure whose cells are digit x row. */
static void lay_out(struct page *page)
{
    struct figure figure = *page->figure;
    struct extent x = axis_extent(&figure, false), y = axis_extent(&figure, true);
    const struct picture_style *style = &page->style;
    struct dot_grid grid = charset_grid(CHARSET_BRAILLE);
    double gutter = page->gutter;

    page->layout = (struct figure_layout){
        .charset = CHARSET_BRAILLE, .frame = true, .hidden = x.hidden + y.hidden};
    page->top = page->from_y;
    page->bottom = page->to_y - (page->x_labels ? labels_height(style) : 0);
    page->bottom = fmax(page->bottom, page->top + 1);
    page->right = page->to_x;
    do { /* the labels need room, and the room decides on the labels */
        gutter = fmax(gutter, widest_label(page));
        page->left =
            fmin(page->from_x + style->font + style->edge + gutter + style->tick + style->tick_gap,
                 page->right - 1);
        double width = page->right - page->left, height = page->bottom - page->top;
        page->layout.columns = (int)fmax(width / style->digit, 1);
        page->layout.rows = (int)fmax(height / style->row, 1);
        /* So that equal axes are equal in points. */
        figure.aspect = height / width * (page->layout.columns - 1.0 / grid.across) /
                        (page->layout.rows - 1.0 / grid.down);
        layout_scales(&figure, &page->layout, x, y);
    } while (widest_label(page) > gutter);
    page->gutter = gutter;
}

/* ---- panels ---- */

struct picture_sheet {
    const struct figure *figure; /* all of it: title, legend, caption */
    struct figure part[PANELS_MAX];
    int parts;
    struct page page[PANELS_MAX]; /* one for each panel */
};

/* Divides the page from top to bottom. */
static void place_panels(struct picture_sheet *sheet, double top, double bottom)
{
    struct page *page = sheet->page;
    const struct picture_style *style = &page->style;
    double left = style->edge, right = page->width - 2 * style->edge, width = right - left,
           height = bottom - top;
    bool plane = sheet->figure->plane;
    bool across = plane && planes_across(sheet->figure, (int)(width / style->digit),
                                         (int)(height / style->row));

    for (int i = 0; i < sheet->parts; i++) {
        page[i].figure = &sheet->part[i];
        page[i].from_x = left;
        page[i].to_x = right;
        page[i].from_y = top;
        page[i].to_y = bottom;
        page[i].x_labels = true;
    }
    if (sheet->parts > 1 && across) {
        page[0].to_x = left + width / 2 - style->edge;
        page[1].from_x = left + width / 2 + style->edge;
    } else if (sheet->parts > 1) { /* two plots of one height; labels of a common axis stand below
                                      the lower one only */
        double labels = labels_height(style),
               plot = (height - style->between - (plane ? 2 : 1) * labels) / 2;
        page[0].x_labels = plane;
        page[0].to_y = top + plot + (plane ? labels : 0);
        page[1].from_y = page[0].to_y + style->between;
    }
    for (int i = 0; i < sheet->parts; i++)
        lay_out(&page[i]);
    if (sheet->parts > 1 && !across) {
        double gutter = fmax(page[0].gutter, page[1].gutter);
        for (int i = 0; i < sheet->parts; i++) {
            page[i].gutter = gutter;
            lay_out(&page[i]);
        }
    }
}

/* What the panels have to say, in one line. */
static void put_notes(const struct picture_sheet *sheet, struct buffer *out)
{
    struct buffer note = {0};
    int available = (int)(sheet->page->width / sheet->page->style.digit);
    for (int i = 0; i < sheet->parts; i++) {
        figure_note(&sheet->part[i], &sheet->page[i].layout, available, &note);
        buffer_put(out, out->len && note.len ? TEXT("; ") : TEXT(""));
        buffer_put(out, buffer_text(&note));
    }
    buffer_free(&note);
}

static void draw_panel(struct page *page)
{
    const struct picture_style *style = &page->style;
    const struct figure *figure = page->figure;
    double zero = fraction_of(&page->layout.y, 0);

    for (int vertical = 0; vertical < 2 && figure->grid; vertical++)
        draw_grid(page, vertical);
    if (figure->zero_line && zero > 0 && zero < 1) {
        const double at = tick_position(page, true, 0);
        draw_straight(page, page->left, at, page->right, at, style_gray, style->zero_line);
    }
    page_curves(page);
    surface_box(page->surface, page->left, page->top, page->right, page->bottom);
    surface_paint(page->surface, &(struct brush){.color = style_black, .width = style->frame_line});
    draw_ticks(page, false);
    draw_ticks(page, true);
    draw_axis_titles(page);
}

/* Divides what is below `top`, notes at the foot left out. */
static void place(struct picture_sheet *sheet, double top, struct buffer *note)
{
    const struct page *page = sheet->page;
    const char *caption = sheet->figure->caption;
    const double foot = page->height - page->style.edge;
    buffer_clear(note);
    place_panels(sheet, top, foot);
    put_notes(sheet, note);
    if (note->len || (caption && *caption))
        place_panels(sheet, top, foot - page->style.leading);
}

static bool trace_panels(struct picture_sheet *sheet, struct arena *arena)
{
    bool traced = true;
    for (int i = 0; i < sheet->parts && traced; i++)
        traced = page_trace(&sheet->page[i], arena);
    return traced;
}

static void free_paths(struct picture_sheet *sheet)
{
    for (int i = 0; i < sheet->parts; i++)
        page_free_paths(&sheet->page[i]);
}

/* The legend stands in the plot where it covers nothing, else above. */
static bool draw_sheet(struct picture_sheet *sheet, struct arena *arena)
{
    struct page *page = sheet->page;
    const struct picture_style *style = &page->style;
    struct page heading = *page; /* title and legend are those of all panels */
    struct buffer note = {0};
    double spot[2];

    heading.figure = sheet->figure;
    place(sheet, page_heading(&heading, false, false), &note);
    bool drawn = trace_panels(sheet, arena);
    const bool inside = drawn && sheet->parts == 1 && legend_place(page, spot);
    if (!inside) {
        free_paths(sheet);
        place(sheet, page_heading(&heading, true, false), &note);
        drawn = drawn && trace_panels(sheet, arena);
    }
    heading.layout = page->layout;
    heading.left = page->left;
    heading.right = page->right;
    heading.top = page->top;
    heading.bottom = page->bottom;
    page_heading(&heading, !inside, true);
    for (int i = 0; i < sheet->parts && drawn; i++)
        draw_panel(&page[i]);
    if (inside)
        legend_draw(page, spot);
    free_paths(sheet);
    const double foot = page->height - style->edge - style->font / 3;
    page_text(&heading, 1.5 * style->edge, foot, 0, style_gray,
              symbols(page, put_number_symbols, buffer_view(&note)));
    page_text(&heading, page->right, foot, 1, style_gray, sheet->figure->caption);
    drawn &= !note.failed;
    buffer_free(&note);
    return drawn;
}

bool picture_draw(struct surface *surface, const struct figure *figure, double width, double height)
{
    struct buffer text = {0};
    const struct page page = {.surface = surface,
                              .text = &text,
                              .style = picture_style(width, height),
                              .width = width,
                              .height = height};
    struct picture_sheet sheet = {.figure = figure, .page = {page, page}};
    struct arena arena = {0};
    sheet.parts = figure_parts(figure, sheet.part);
    const bool drawn = draw_sheet(&sheet, &arena) && !surface->failed;
    arena_reset(&arena);
    buffer_free(&text);
    return drawn;
}
