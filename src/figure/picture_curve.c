/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Curves of a picture: lines of their own dashes and marks, data as points, arrows where a run
 * leaves. */
#include "figure/picture.h"

#define DOTS 20000 /* of dense data: more of them are drawn as larger squares */
#define SPARSE 150 /* points that still get a shape */
#define MARKS 9    /* along a line */

/* Corners on the unit circle; the circle itself has none. */
static const struct {
    int corners;
    double corner[4][2];
} shapes[] = {{0, {{0}}},
              {4, {{-0.85, -0.85}, {0.85, -0.85}, {0.85, 0.85}, {-0.85, 0.85}}},
              {3, {{0, -1.15}, {1.1, 0.8}, {-1.1, 0.8}}},
              {4, {{0, -1.25}, {1.25, 0}, {0, 1.25}, {-1.25, 0}}},
              {3, {{0, 1.15}, {1.1, -0.8}, {-1.1, -0.8}}}};

/* Place of a curve among those of its kind. */
static size_t kind_of(const struct figure *figure, int curve)
{
    size_t before = 0;
    for (int i = 0; i < curve; i++)
        before += figure->curve[i].points == figure->curve[curve].points;
    return before;
}

static int line_count(const struct figure *figure)
{
    int lines = 0;
    for (int i = 0; i < figure->curves; i++)
        lines += !figure->curve[i].points;
    return lines;
}

static const double *color_of(int curve)
{
    return style_palette[(size_t)curve % style_palette_count];
}

static struct brush line_ink(const struct page *page, int curve, double width)
{
    const size_t dashes = kind_of(page->figure, curve) % style_dashes_count;
    return (struct brush){.color = color_of(curve),
                          .width = width,
                          .dashes = &style_dashes[dashes],
                          .dash = page->style.dash};
}

/* A letter is the curve's name on the sheet; every other mark is a shape, which can be told apart
 * when it is small. */
static bool has_letter(const struct curve *curve)
{
    char c = curve->mark;
    return curve->points &&
           ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'));
}

static void add_shape(const struct page *page, size_t shape, double x, double y)
{
    const double radius = page->style.mark;
    int corners = shapes[shape % COUNT_OF(shapes)].corners;
    const double(*corner)[2] = shapes[shape % COUNT_OF(shapes)].corner;

    if (!corners)
        surface_circle(page->surface, x, y, radius);
    for (int i = 0; i < corners; i++)
        (i ? surface_line : surface_move)(page->surface, x + radius * corner[i][0],
                                          y + radius * corner[i][1]);
    if (corners)
        surface_close(page->surface);
}

/* Paints the marks that were added: those of a line are full. */
static void paint_points(const struct page *page, int index, bool dense)
{
    const struct picture_style *style = &page->style;
    const double dot = line_count(page->figure) ? 1.7 * style->dot : 1.1 * style->dot;
    surface_paint(page->surface, &(struct brush){.color = color_of(index),
                                                 .width = dense ? dot : style->mark_line,
                                                 .fill = !page->figure->curve[index].points});
}

/* ---- lines ---- */

struct spot {
    double x, y;
};

/* Places in the plot at equal distances along the path, each curve's between those of the others;
 * returns how many. */
static int places_along(const struct page *page, int curve, double every, struct spot *place,
                        int max)
{
    const struct path_point *path = page->surface->path;
    double length = 0,
           next = every * (0.5 + (double)kind_of(page->figure, curve) / page->figure->curves);
    int n = 0;
    for (size_t i = 1; i < page->surface->points; i++) {
        const double dx = path[i].x - path[i - 1].x, dy = path[i].y - path[i - 1].y,
                     distance = hypot(dx, dy);
        if (path[i].kind != PATH_LINE)
            continue;
        for (; n < max && next <= length + distance; next += every) {
            const double part = (next - length) / distance, x = path[i - 1].x + part * dx,
                         y = path[i - 1].y + part * dy;
            if (x >= page->left && x <= page->right && y >= page->top && y <= page->bottom)
                place[n++] = (struct spot){x, y};
        }
        length += distance;
    }
    return n;
}

static double path_length(const struct surface *surface)
{
    double length = 0;
    for (size_t i = 1; i < surface->points; i++)
        if (surface->path[i].kind == PATH_LINE)
            length += hypot(surface->path[i].x - surface->path[i - 1].x,
                            surface->path[i].y - surface->path[i - 1].y);
    return length;
}

static void draw_line(struct page *page, int curve, bool marked)
{
    struct spot place[MARKS + 1];
    const double width = page->right - page->left;
    page_path(page, &page->figure->curve[curve]);
    const double length = path_length(page->surface);
    const int marks = marked && length > 0
                          ? places_along(page, curve, fmax(length / MARKS, page->style.mark_apart),
                                         place, MARKS + 1)
                          : 0;
    /* Many turns need thin lines; a plot that they fill, none thinner than its grains. */
    const struct brush brush = line_ink(
        page, curve,
        length < 40 * width || page->grains == 1 ? page->style.curve_line : page->style.thin_line);
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    surface_paint(page->surface, &brush);
    surface_unclip(page->surface);
    for (int i = 0; i < marks; i++)
        add_shape(page, kind_of(page->figure, curve), place[i].x, place[i].y);
    paint_points(page, curve, false);
}

/* ---- bands ---- */

#define BIN 0.5 /* [pt] points that lie in one such width are one corner of the band's edge */

static void paint_band(const struct page *page, int curve)
{
    surface_paint(page->surface,
                  &(struct brush){.color = color_of(curve), .opacity = STYLE_BAND, .fill = true});
}

/* One edge of the band, forwards (side 1, the upper one) or backwards. */
static void add_edge(const struct page *page, const struct curve *curve, int side)
{
    double bin = NAN, at = 0, edge = NAN;
    for (size_t k = 0; k < curve->n; k++) {
        const size_t i = side > 0 ? k : curve->n - 1 - k;
        const double x = page_x(page, curve->x[i]),
                     y = page_y(page, curve->y[i] + side * curve->spread[i]);
        if (!isfinite(x + y))
            continue;
        if (floor(x / BIN) != bin && isfinite(edge))
            surface_line(page->surface, at, edge);
        edge = floor(x / BIN) != bin ? y : side > 0 ? fmin(edge, y) : fmax(edge, y);
        bin = floor(x / BIN);
        at = x;
    }
    if (isfinite(edge))
        surface_line(page->surface, at, edge);
}

static void draw_band(struct page *page, int index)
{
    const struct curve *curve = &page->figure->curve[index];
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    surface_new_path(page->surface);
    add_edge(page, curve, 1);
    add_edge(page, curve, -1);
    surface_close(page->surface);
    paint_band(page, index);
    surface_unclip(page->surface);
}

double page_band_sample(struct page *page, int index, double x, double y, bool draw)
{
    const double width = page->style.sample, half = page->style.band_sample / 2;
    if (draw) {
        surface_box(page->surface, x, y - half, x + width, y + half);
        paint_band(page, index);
    }
    return width;
}

/* ---- points ---- */

static bool point_position(const struct page *page, const struct curve *curve, size_t i, double *x,
                           double *y)
{
    *x = page_x(page, curve->x[i]);
    *y = page_y(page, curve->y[i]);
    double edge = 1e-6; /* of rounding */
    return *x >= page->left - edge && *x <= page->right + edge && *y >= page->top - edge &&
           *y <= page->bottom + edge;
}

/* More than can be told apart as shapes: dots below the lines, which would be hidden otherwise. */
static bool is_dense(const struct page *page, const struct curve *curve)
{
    size_t inside = 0;
    double x, y;
    for (size_t i = 0; i < curve->n && inside <= SPARSE; i++)
        inside += point_position(page, curve, i, &x, &y);
    return inside > SPARSE;
}

static void put_letter(const struct page *page, int curve, double x, double y)
{
    page_text(page, x, y, 0.5, color_of(curve), (char[]){page->figure->curve[curve].mark, '\0'});
}

/* Points as a path of shapes, or of lines without length that their round ends turn into dots: one
 * for each square of that size. Returns how many. */
static long add_points(struct page *page, int index, bool dense, double square)
{
    const struct curve *curve = &page->figure->curve[index];
    double x, y;
    long points = 0;

    surface_new_path(page->surface);
    page_ink_clear(page, 1);
    for (size_t i = 0; i < curve->n; i++) {
        if (!point_position(page, curve, i, &x, &y))
            continue;
        double column = page->left + floor((x - page->left) / square) * square,
               row = page->top + floor((y - page->top) / square) * square;
        if (dense && !page_ink_line(page, column, row, column, row))
            continue;
        points++;
        if (has_letter(curve)) {
            put_letter(page, index, x, y);
        } else if (dense) {
            surface_move(page->surface, x, y);
            surface_line(page->surface, x, y);
        } else {
            add_shape(page, kind_of(page->figure, index), x, y);
        }
    }
    return points;
}

static void draw_points(struct page *page, int index, bool dense)
{
    const double dot = page->style.dot;
    if (add_points(page, index, dense, dot) > DOTS && !has_letter(&page->figure->curve[index]))
        add_points(page, index, dense, 1.5 * dot);
    paint_points(page, index, dense);
}

double page_sample(struct page *page, int index, double x, double y, bool draw)
{
    const struct picture_style *style = &page->style;
    const struct curve *curve = &page->figure->curve[index];
    const double width = !curve->points      ? style->sample
                         : has_letter(curve) ? 0.7 * style->font
                                             : style->mark_sample,
                 middle = x + width / 2;
    const bool dense = curve->points && is_dense(page, curve);

    if (!draw)
        return width;
    if (has_letter(curve)) {
        put_letter(page, index, middle, y);
        return width;
    }
    if (!curve->points) {
        const struct brush brush = line_ink(page, index, style->curve_line);
        surface_move(page->surface, x, y);
        surface_line(page->surface, x + width, y);
        surface_paint(page->surface, &brush);
    }
    for (int i = -1; i <= 1 && dense; i++) {
        const double at = middle + 2.5 * style->dot * i, height = y + style->dot * (i ? 0.5 : -0.5);
        surface_move(page->surface, at, height);
        surface_line(page->surface, at, height);
    }
    if (!dense && (curve->points || line_count(page->figure) > 1))
        add_shape(page, kind_of(page->figure, index), middle, y);
    paint_points(page, index, dense);
    return width;
}

/* ---- all ---- */

static void draw_exits(struct page *page, int index)
{
    static const double ahead[4][2] = {{-1, 0}, {1, 0}, {0, 1}, {0, -1}};
    const double length = page->style.arrow, half = page->style.arrow_half;
    struct curve_exit exits[4];

    if (!curve_exits(page->figure, &page->layout, index, exits))
        return;
    for (int side = 0; side < 4; side++) {
        double x = page->left + exits[side].x * (page->right - page->left), dx = ahead[side][0];
        double y = page->bottom - exits[side].y * (page->bottom - page->top), dy = ahead[side][1];
        if (!exits[side].left)
            continue;
        surface_move(page->surface, x, y);
        surface_line(page->surface, x - length * dx + half * dy, y - length * dy + half * dx);
        surface_line(page->surface, x - length * dx - half * dy, y - length * dy - half * dx);
        surface_close(page->surface);
        surface_paint(page->surface, &(struct brush){.color = color_of(index), .fill = true});
    }
}

void page_curves(struct page *page)
{
    const struct figure *figure = page->figure;

    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].spread)
            draw_band(page, i);
    /* Dense data, lines with the first above, data that lines can be seen through. */
    for (int pass = 0; pass < 3; pass++) {
        for (int i = figure->curves - 1; i >= 0; i--) {
            const struct curve *curve = &figure->curve[i];
            bool dense = curve->points && is_dense(page, curve);
            if (!curve_drawn(figure, i) || pass != (!curve->points ? 1 : dense ? 0 : 2))
                continue;
            if (curve->points)
                draw_points(page, i, dense);
            else
                draw_line(page, i, line_count(figure) > 1);
        }
    }
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i))
            draw_exits(page, i);
}
