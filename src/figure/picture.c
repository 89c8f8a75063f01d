/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Pictures: the page, its axes, titles and legend, and the file that comes of it. */
#define _GNU_SOURCE /* memmem */
#include "figure/picture.h"

#ifdef HAVE_CAIRO
#include <stdio.h>
#include <string.h>

#define CELL_WIDTH 6.0 /* [pt] of a digit: ticks are chosen as for cells of this size */
#define CELL_HEIGHT 12.0
#define EDGE 8.0  /* [pt] blank around everything */
#define LINE 14.0 /* [pt] from one line of text to the next */
#define TICK 4.0  /* [pt] */
#define LEAST 60  /* [pt] of a page */
#define MOST 5000
#define PIXELS 2    /* a point, of a PNG */
#define BETWEEN 8.0 /* [pt] blank between two panels */

static const double black[3] = {0, 0, 0}, gray[3] = {0.45, 0.45, 0.45}, light[3] = {0.9, 0.9, 0.9};

static void set_ink(const struct page *page, const double color[3], double width)
{
    page->api->set_source_rgb(page->cairo, color[0], color[1], color[2]);
    page->api->set_line_width(page->cairo, width);
    page->api->set_dash(page->cairo, NULL, 0, 0);
}

static void draw_straight(const struct page *page, double x0, double y0, double x1, double y1)
{
    page->api->move_to(page->cairo, x0, y0);
    page->api->line_to(page->cairo, x1, y1);
    page->api->stroke(page->cairo);
}

/* ---- text ---- */

/* Labels come from files and names: what is not plain text would make cairo refuse all of it. */
static const char *plain(struct page *page, const char *text)
{
    buffer_clear(&page->text);
    safe_text(&page->text, text_of(text), false);
    return page->text.len && !page->text.failed ? page->text.data : "";
}

static double width_of(const struct page *page, const char *text)
{
    cairo_text_extents_t extents = {0};
    page->api->text_extents(page->cairo, text, &extents);
    return extents.x_advance;
}

double page_text_width(struct page *page, const char *text)
{
    return width_of(page, plain(page, text));
}

double page_text(struct page *page, double x, double y, double align, const char *text)
{
    const char *shown = plain(page, text);
    double width = width_of(page, shown);
    page->api->move_to(page->cairo, x - align * width, y);
    page->api->show_text(page->cairo, shown);
    return width;
}

static void set_font(const struct page *page, cairo_font_weight_t weight, double size)
{
    page->api->select_font_face(page->cairo, "sans", CAIRO_FONT_SLANT_NORMAL, weight);
    page->api->set_font_size(page->cairo, size);
}

/* ---- title and legend ---- */

static const char *entry_label(const struct curve *curve, bool band)
{
    return band ? (curve->spread ? curve->spread_label : NULL) : curve->label;
}

/*
 * The title, and after it the legend in as many lines as it needs, but no further down than
 * `limit`: then it says how many are left out. Returns the height at which it ends. Only measures
 * unless `draw`.
 */
static double draw_heading(struct page *page, double limit, bool draw)
{
    const struct figure *figure = page->figure;
    double start = EDGE + 4, x = start, y = EDGE + FONT_SIZE + 2, end = page->width - EDGE;
    int first = 0, hidden = 0;

    set_font(page, CAIRO_FONT_WEIGHT_BOLD, FONT_SIZE + 2);
    set_ink(page, black, 1);
    if (figure->title && *figure->title)
        x += 20 + (draw ? page_text(page, x, y, 0, figure->title)
                        : page_text_width(page, figure->title));
    set_font(page, CAIRO_FONT_WEIGHT_NORMAL, FONT_SIZE);
    for (int e = 0; e < 2 * figure->curves; e++) { /* curves, then bands */
        const int i = e % figure->curves;
        double (*const put_sample)(struct page *, int, double, double, bool) =
            e < figure->curves ? page_sample : page_band_sample;
        const char *label = entry_label(&figure->curve[i], e >= figure->curves);
        if (!label || !*label)
            continue;
        double sample = put_sample(page, i, 0, 0, false) + 5,
               width = sample + page_text_width(page, label);
        if (first++ && x + width > end && y + LINE > limit - EDGE) {
            hidden++;
            continue;
        }
        if (x > start && x + width > end) {
            x = start;
            y += LINE;
        }
        if (draw) {
            put_sample(page, i, x, y - 0.36 * FONT_SIZE, true);
            set_ink(page, black, 1);
            page_text(page, x + sample, y, 0, label);
        }
        x += width + 16;
    }
    if (hidden && draw) {
        char more[48];
        snprintf(more, sizeof more, "and %d more", hidden);
        set_ink(page, gray, 1);
        page_text(page, end, limit, 1, more);
    }
    return hidden ? limit + EDGE : y + EDGE;
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

/* Lines of the grid below everything, or ticks at the frame with their labels. */
static void draw_ticks(struct page *page, bool vertical, bool grid)
{
    const struct ticks *ticks = vertical ? &page->layout.y_ticks : &page->layout.x_ticks;
    bool decades = vertical ? page->layout.y_decades : page->layout.x_decades;
    char text[TICK_TEXT_SIZE];

    for (int i = 0; i < ticks->count; i++) {
        double value = tick_value(ticks, i, decades), at = tick_position(page, vertical, value);
        if (grid && vertical) {
            draw_straight(page, page->left, at, page->right, at);
        } else if (grid) {
            draw_straight(page, at, page->top, at, page->bottom);
        } else if (vertical) {
            tick_text(ticks, i, decades, text);
            draw_straight(page, page->left - TICK, at, page->left, at);
            page_text(page, page->left - TICK - 3, at + 0.36 * FONT_SIZE, 1, text);
        } else {
            tick_text(ticks, i, decades, text);
            double half = page_text_width(page, text) / 2;
            draw_straight(page, at, page->bottom, at, page->bottom + TICK);
            if (!page->x_labels)
                continue;
            page_text(page, fmin(at, page->to_x + 1.5 * EDGE - half),
                      page->bottom + TICK + FONT_SIZE + 1, 0.5, text);
        }
    }
    /* Between single decades: 2, 3 … 9. */
    for (int i = -1; !grid && decades && ticks->step == 1 && i < ticks->count; i++) {
        for (int digit = 2; digit < 10; digit++) {
            double at = tick_position(page, vertical, digit * tick_value(ticks, i, true));
            if (vertical && at >= page->top && at <= page->bottom)
                draw_straight(page, page->left - TICK / 2, at, page->left, at);
            else if (!vertical && at >= page->left && at <= page->right)
                draw_straight(page, at, page->bottom, at, page->bottom + TICK / 2);
        }
    }
}

static void draw_axis_titles(struct page *page)
{
    const struct cairo_api *api = page->api;
    char text[256];

    axis_title(&page->figure->y, &page->layout.y_ticks, "", text, sizeof text);
    api->save(page->cairo);
    api->translate(page->cairo, page->from_x + FONT_SIZE, (page->top + page->bottom) / 2);
    api->rotate(page->cairo, -1.5707963267948966);
    page_text(page, 0, 0, 0.5, text);
    api->restore(page->cairo);

    double y = page->bottom + TICK + FONT_SIZE + 1 + LINE + 1;
    axis_title(&page->figure->x, &page->layout.x_ticks, "", text, sizeof text);
    if (page->x_labels)
        page_text(page, (page->left + page->right) / 2, y, 0.5, text);
}

static double widest_label(struct page *page)
{
    char text[TICK_TEXT_SIZE];
    double width = 0;
    for (int i = 0; i < page->layout.y_ticks.count; i++) {
        tick_text(&page->layout.y_ticks, i, page->layout.y_decades, text);
        width = fmax(width, page_text_width(page, text));
    }
    return width;
}

/* The room for the plot; ranges and ticks as for a text figure whose cells are CELL_WIDTH x
 * CELL_HEIGHT. */
static void lay_out(struct page *page)
{
    struct figure figure = *page->figure;
    struct extent x = axis_extent(&figure, false), y = axis_extent(&figure, true);
    struct dot_grid grid = charset_grid(CHARSET_BRAILLE);
    double gutter = page->gutter;

    page->layout = (struct figure_layout){
        .charset = CHARSET_BRAILLE, .frame = true, .hidden = x.hidden + y.hidden};
    page->top = page->from_y;
    page->bottom = page->to_y - (page->x_labels ? TICK + FONT_SIZE + LINE + 4 : 0);
    page->bottom = fmax(page->bottom, page->top + 1);
    page->right = page->to_x;
    do { /* the labels need room, and the room decides on the labels */
        gutter = fmax(gutter, widest_label(page));
        page->left = fmin(page->from_x + FONT_SIZE + 8 + gutter + TICK + 3, page->right - 1);
        double width = page->right - page->left, height = page->bottom - page->top;
        page->layout.columns = (int)fmax(width / CELL_WIDTH, 1);
        page->layout.rows = (int)fmax(height / CELL_HEIGHT, 1);
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
    double left = EDGE, right = page->width - 2 * EDGE, width = right - left, height = bottom - top;
    bool plane = sheet->figure->plane;
    bool across = plane && planes_across(sheet->figure, (int)(width / CELL_WIDTH),
                                         (int)(height / CELL_HEIGHT));

    for (int i = 0; i < sheet->parts; i++) {
        page[i].figure = &sheet->part[i];
        page[i].from_x = left;
        page[i].to_x = right;
        page[i].from_y = top;
        page[i].to_y = bottom;
        page[i].x_labels = true;
    }
    if (sheet->parts > 1 && across) {
        page[0].to_x = left + width / 2 - EDGE;
        page[1].from_x = left + width / 2 + EDGE;
    } else if (sheet->parts > 1) { /* two plots of one height; labels of a common axis stand below
                                      the lower one only */
        double labels = TICK + FONT_SIZE + LINE + 4,
               plot = (height - BETWEEN - (plane ? 2 : 1) * labels) / 2;
        page[0].x_labels = plane;
        page[0].to_y = top + plot + (plane ? labels : 0);
        page[1].from_y = page[0].to_y + BETWEEN;
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
    int available = (int)(sheet->page->width / CELL_WIDTH);
    for (int i = 0; i < sheet->parts; i++) {
        figure_note(&sheet->part[i], &sheet->page[i].layout, available, &note);
        buffer_put(out, out->len && note.len ? TEXT("; ") : TEXT(""));
        buffer_put(out, buffer_text(&note));
    }
    buffer_free(&note);
}

static void draw_panel(struct page *page)
{
    const struct cairo_api *api = page->api;
    const struct figure *figure = page->figure;
    double zero = fraction_of(&page->layout.y, 0), point[2];

    set_ink(page, light, 0.6);
    draw_ticks(page, false, true);
    draw_ticks(page, true, true);
    if (figure->zero_line && zero > 0 && zero < 1) {
        set_ink(page, gray, 0.8);
        draw_straight(page, page->left, tick_position(page, true, 0), page->right,
                      tick_position(page, true, 0));
    }

    page_curves(page);
    point[0] = figure->has_point ? fraction_of(&page->layout.x, figure->point[0]) : NAN;
    point[1] = figure->has_point ? fraction_of(&page->layout.y, figure->point[1]) : NAN;
    if (point[0] >= 0 && point[0] <= 1 && point[1] >= 0 && point[1] <= 1) {
        set_ink(page, black, 1);
        api->arc(page->cairo, page->left + point[0] * (page->right - page->left),
                 page->bottom - point[1] * (page->bottom - page->top), 3, 0, 6.283185307179586);
        api->fill(page->cairo);
    }
    set_ink(page, black, 0.8);
    api->rectangle(page->cairo, page->left, page->top, page->right - page->left,
                   page->bottom - page->top);
    api->stroke(page->cairo);
    draw_ticks(page, false, false);
    draw_ticks(page, true, false);
    draw_axis_titles(page);
}

static bool draw_sheet(struct picture_sheet *sheet, struct arena *arena)
{
    struct page *page = sheet->page;
    struct page heading = *page; /* title and legend are those of all panels */
    struct buffer note = {0};
    bool drawn = true;

    heading.figure = sheet->figure;
    double top = draw_heading(&heading, page->height / 3, false), bottom = page->height - EDGE;
    place_panels(sheet, top, bottom);
    put_notes(sheet, &note);
    if (note.len || (sheet->figure->caption && *sheet->figure->caption))
        place_panels(sheet, top, bottom - LINE);
    heading.layout = page->layout;
    heading.left = page->left;
    heading.right = page->right;
    heading.top = page->top;
    heading.bottom = page->bottom;
    draw_heading(&heading, page->height / 3, true);
    for (int i = 0; i < sheet->parts && drawn; i++) {
        page[i].ink = arena_alloc(arena, page_ink_size(&page[i], GRAINS));
        drawn = page[i].ink != NULL;
        if (drawn)
            draw_panel(&page[i]);
        drawn &= !page[i].text.failed;
    }
    for (int i = 0; i < sheet->parts; i++)
        buffer_free(&page[i].text);
    set_ink(&heading, gray, 1);
    page_text(&heading, EDGE + 4, page->height - EDGE, 0,
              note.len && !note.failed ? note.data : "");
    page_text(&heading, page->right, page->height - EDGE, 1, sheet->figure->caption);
    drawn &= !heading.text.failed && !note.failed;
    buffer_free(&heading.text);
    buffer_free(&note);
    return drawn;
}

/* ---- files ---- */

static cairo_status_t take_bytes(void *out, const unsigned char *data, unsigned int length)
{
    struct buffer *buffer = out;
    buffer_put(buffer, (struct text){(const char *)data, length});
    return buffer->failed ? CAIRO_STATUS_WRITE_ERROR : CAIRO_STATUS_SUCCESS;
}

static cairo_surface_t *make_surface(const struct cairo_api *api, enum picture kind, double width,
                                     double height, struct buffer *out)
{
    if (kind == PICTURE_PNG)
        return api->image_surface_create(CAIRO_FORMAT_RGB24, (int)(PIXELS * width),
                                         (int)(PIXELS * height));
    if (kind == PICTURE_SVG)
        return api->svg_surface_create_for_stream(take_bytes, out, width, height);
    cairo_surface_t *surface = api->pdf_surface_create_for_stream(take_bytes, out, width, height);
    /* the same figure, the same file */
    api->pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, NULL);
    return surface;
}

/* cairo numbers the surfaces of a process in the SVG; without that the same figure gives the same
 * file. */
static void forget_count(struct buffer *out, size_t from)
{
    static const char mark[] = "id=\"surface";
    char *at = out->data ? memmem(out->data + from, out->len - from, mark, sizeof mark - 1) : NULL;
    if (!at)
        return;
    at += sizeof mark - 1;
    const size_t digits = strspn(at, "0123456789");
    memmove(at, at + digits, (size_t)(out->data + out->len - at) - digits + 1); /* with the NUL */
    out->len -= digits;
}

static double page_length(double wanted, double usual)
{
    return !(wanted > 0) ? usual : fmin(fmax(wanted, LEAST), MOST);
}

bool picture_with(const struct cairo_api *api, const struct figure *figure, enum picture kind,
                  double width, double height, struct buffer *out, struct error *error)
{
    struct page page = {.api = api,
                        .width = page_length(width, PICTURE_WIDTH),
                        .height = page_length(height, PICTURE_HEIGHT)};
    struct picture_sheet sheet = {.figure = figure};
    struct arena arena = {0};
    const size_t before = out->len;
    cairo_surface_t *surface = make_surface(api, kind, page.width, page.height, out);
    page.cairo = api->create(surface);

    if (kind == PICTURE_PNG)
        api->scale(page.cairo, PIXELS, PIXELS);
    api->set_source_rgb(page.cairo, 1, 1, 1);
    api->paint(page.cairo);
    api->set_line_cap(page.cairo, CAIRO_LINE_CAP_ROUND);
    api->set_line_join(page.cairo, CAIRO_LINE_JOIN_ROUND);
    sheet.parts = figure_parts(figure, sheet.part);
    sheet.page[0] = sheet.page[1] = page;
    bool drawn = draw_sheet(&sheet, &arena) && api->status(page.cairo) == CAIRO_STATUS_SUCCESS;
    api->destroy(page.cairo);
    if (kind == PICTURE_PNG)
        drawn = drawn &&
                api->surface_write_to_png_stream(surface, take_bytes, out) == CAIRO_STATUS_SUCCESS;
    api->surface_finish(surface);
    drawn = drawn && api->surface_status(surface) == CAIRO_STATUS_SUCCESS && !out->failed;
    api->surface_destroy(surface);
    if (drawn && kind == PICTURE_SVG)
        forget_count(out, before);
    arena_reset(&arena);
    return drawn || error_memory(error); /* what else can fail */
}
#endif
