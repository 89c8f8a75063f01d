/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws a figure as a page: divides it into panels, and draws title, legend, panels and the lines
 * at the foot. picture_draw() is the entry. */
#include "modules/pictures/picture.h"
#include "modules/pictures/symbols.h"

/* ---- panels ---- */

/* A page with one or two panels, one above or beside the other. */
struct picture_sheet {
    const struct figure *figure;    /* the whole figure: title, legend, caption */
    struct figure part[PANELS_MAX]; /* the figure of each panel */
    int parts;                      /* number of panels */
    struct page page[PANELS_MAX];   /* one for each panel */
};

/* Divides the area between top and bottom [pt] among the one or two panels and lays them out:
 * planes side by side if the page is wide, others below each other with aligned frames. Two panels
 * that would be too small are drawn as one. */
static void place_panels(struct picture_sheet *sheet, double top, double bottom)
{
    struct page *page = sheet->page;
    const struct picture_style *style = &page->style;
    const bool bar = sheet->figure->heat && !sheet->figure->heat->letters;
    double left = style->edge,
           right = page->width - 2 * style->edge - (bar ? page_bar_width(style) : 0),
           width = right - left, height = bottom - top;
    const bool plane = sheet->figure->plane;
    const bool is_horizontal = plane && planes_across(sheet->figure, (int)(width / style->digit),
                                                      (int)(height / style->row));

    const double labels = page_labels_height(style),
                 plot = (height - style->panel_gap - (plane ? 2 : 1) * labels) / 2;
    if (sheet->parts > 1 &&
        (is_horizontal ? width / 2 < 8 * style->font : plot < 2 * style->font)) {
        sheet->parts = 1; /* no room for two: the first sets the ranges */
        sheet->part[0] = *sheet->figure;
        sheet->part[0].second = NULL;
    }
    for (int i = 0; i < sheet->parts; i++) {
        page[i].figure = &sheet->part[i];
        page[i].from_x = left;
        page[i].to_x = right;
        page[i].from_y = top;
        page[i].to_y = bottom;
        page[i].x_labels = true;
    }
    if (sheet->parts > 1 && is_horizontal) {
        page[0].to_x = left + width / 2 - style->edge;
        page[1].from_x = left + width / 2 + style->edge;
    } else if (sheet->parts > 1) { /* two plots of one height; labels of a common axis stand below
                                      the lower one only */
        page[0].x_labels = plane;
        page[0].to_y = top + plot + (plane ? labels : 0);
        page[1].from_y = page[0].to_y + style->panel_gap;
    }
    for (int i = 0; i < sheet->parts; i++)
        page_lay_out(&page[i]);
    if (sheet->parts > 1 && !is_horizontal) { /* their frames are aligned */
        double gutter = fmax(page[0].gutter, page[1].gutter);
        for (int i = 0; i < sheet->parts; i++) {
            page[i].gutter = gutter;
            page_lay_out(&page[i]);
        }
    }
}

/* Lines below everything: notes of the panels, such as hidden points, and the caption behind the
 * last of them. */
struct foot {
    struct buffer line[PANELS_MAX];
    int lines;
    bool caption;
};

#define FOOT_PART 6 /* the foot takes at most 1/FOOT_PART of the page's height */

/* Writes the notes of all panels to foot->line: in one line if there is room, else in a line for
 * each panel, else with less detail. Decides whether the caption fits beside the last. */
static void foot_write(const struct picture_sheet *sheet, struct foot *foot)
{
    const struct page *page = sheet->page;
    const struct picture_style *style = &page->style;
    const char *caption = sheet->figure->caption ? sheet->figure->caption : "";
    const double room = page->width - 3 * style->edge,
                 available =
                     room - (*caption ? page_text_width(page, caption) + style->entry_gap : 0);
    const bool many = sheet->parts > 1 && page->height > 2 * FOOT_PART * style->leading;
    for (int way = 0; way < 2; way++) { /* first in one line, then shorter or in two */
        const double each = way == 0 || many ? room : fmax(available, 1) / sheet->parts;
        for (int i = 0; i < PANELS_MAX; i++)
            buffer_clear(&foot->line[i]);
        for (int i = 0; i < sheet->parts; i++) {
            struct buffer note = {0}, *line = &foot->line[way && many ? i : 0];
            figure_note(&sheet->part[i], &sheet->page[i].layout, (int)(each / style->digit), &note);
            buffer_put(line, line->len && note.len ? TEXT("; ") : TEXT(""));
            put_number_symbols(line, buffer_text(&note));
            page->surface->failed |= line->failed || note.failed;
            buffer_free(&note);
        }
        if (page_text_width(page, buffer_view(&foot->line[0])) <= available)
            break;
    }
    if (foot->line[1].len)
        foot->lines = 2;
    else
        foot->lines = foot->line[0].len || *caption ? 1 : 0;
    foot->caption = foot->lines &&
                    page_text_width(page, buffer_view(&foot->line[foot->lines - 1])) <= available &&
                    *caption;
}

/* Draws the lines at the foot of the page, from the last to the first, and frees them. */
static void draw_foot(struct picture_sheet *sheet, struct foot *foot)
{
    struct page *page = sheet->page;
    const struct picture_style *style = &page->style;
    const double start = 1.5 * style->edge, end = page->width - start;
    double y = page->height - style->edge - style->font / 3;
    if (foot->caption)
        page_text(page, end, y, 1, style_gray, sheet->figure->caption);
    for (int i = foot->lines - 1; i >= 0; i--, y -= style->leading) {
        const double size = page_fit(page, &foot->line[i], "", style->font, end - start);
        surface_put_text(page->surface,
                         &(struct surface_text){.x = start,
                                                .y = y + 0.36 * size,
                                                .size = size,
                                                .color = style_gray,
                                                .text = buffer_view(&foot->line[i])});
    }
    for (int i = 0; i < PANELS_MAX; i++)
        buffer_free(&foot->line[i]);
}

/* Draws one panel: heat map, grid, line of zero, curves, frame, axes. */
static void draw_panel(struct page *page)
{
    const struct picture_style *style = &page->style;
    const struct figure *figure = page->figure;
    double zero = fraction_of(&page->layout.y, 0);

    if (figure->heat)
        page_heat(page);
    for (int vertical = 0; vertical < 2 && figure->grid; vertical++)
        page_grid(page, vertical);
    if (figure->zero_line && zero > 0 && zero < 1) {
        const double zero_y = page_tick(page, true, 0);
        page_straight(page, page->left, zero_y, page->right, zero_y, style_gray, style->zero_line);
    }
    page_curves(page);
    surface_box(page->surface, page->left, page->top, page->right, page->bottom);
    surface_paint(page->surface, &(struct brush){.color = style_black, .width = style->frame_line});
    page_axes(page);
    if (figure->heat)
        page_bar(page);
}

/* Places the panels between `top` [pt] and the lower edge of the page and writes the notes into
 * `foot`, which depend on the ranges of the panels. If there are notes, places the panels again,
 * above them. */
static void lay_out_sheet(struct picture_sheet *sheet, double top, struct foot *foot)
{
    const struct page *page = sheet->page;
    const double end = page->height - page->style.edge;
    place_panels(sheet, top, end);
    foot_write(sheet, foot);
    if (foot->lines)
        place_panels(sheet, top, end - foot->lines * page->style.leading);
}

/* Computes the paths of all panels. Returns false if out of memory. */
static bool trace_panels(struct picture_sheet *sheet, bool rough, struct arena *arena)
{
    bool traced = true;
    for (int i = 0; i < sheet->parts && traced; i++)
        traced = page_trace(&sheet->page[i], rough, arena);
    return traced;
}

/* Frees the paths of all panels. */
static void free_paths(struct picture_sheet *sheet)
{
    for (int i = 0; i < sheet->parts; i++)
        page_free_paths(&sheet->page[i]);
}

/* Draws the page. Rough paths, which are fast, tell whether the legend has room inside a plot;
 * otherwise it is placed above the plots, which are laid out again. Returns false if out of memory
 * or cancelled. */
static bool draw_sheet(struct picture_sheet *sheet, struct arena *arena)
{
    struct page *page = sheet->page;
    struct page heading = *page; /* title and legend are those of all panels */
    struct foot foot = {.lines = 0};
    double legend[4];

    heading.figure = sheet->figure;
    lay_out_sheet(sheet, page_heading(&heading, false, false), &foot);
    bool drawn = trace_panels(sheet, true, arena), inside = false;
    for (int i = 0; i < sheet->parts && drawn && !inside; i++)
        inside = legend_place(&heading, &sheet->page[i], legend);
    free_paths(sheet);
    if (!inside)
        lay_out_sheet(sheet, page_heading(&heading, true, false), &foot);
    drawn = drawn && trace_panels(sheet, false, arena);
    heading.layout = page->layout;
    heading.left = page->left;
    heading.right = page->right;
    heading.top = page->top;
    heading.bottom = page->bottom;
    page_heading(&heading, !inside, true);
    for (int i = 0; i < sheet->parts && drawn; i++)
        draw_panel(&page[i]);
    if (inside)
        legend_draw(&heading, legend);
    free_paths(sheet);
    draw_foot(sheet, &foot);
    return drawn;
}

/* Draws the figure on a surface of width x height [pt]. Returns false if out of memory or
 * cancelled, or if the surface failed (surface->failed). */
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
    const bool drawn = draw_sheet(&sheet, &arena) && !surface->failed && !figure_stopped(figure);
    arena_reset(&arena);
    buffer_free(&text);
    return drawn;
}
