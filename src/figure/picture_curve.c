/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Curves of a picture: lines of their own dashes and marks, data as points, arrows where a run
 * leaves. */
#include "figure/picture.h"

#ifdef HAVE_CAIRO
#include <string.h>

/* [pt] of dense data; one for each such square, or for a larger one if there are more than DOTS */
#define DOT 2.0
#define DOTS 20000
#define SPARSE 150 /* points that still get a shape */
#define MARKS 9    /* along a line */
#define RADIUS 2.6 /* [pt] of a mark */
#define LINE_WIDTH 1.2

/* Okabe and Ito, Color Universal Design (2008); without the yellow, which paper swallows. */
static const double colors[][3] = {
    {0, 0.447, 0.698}, {0.835, 0.369, 0},     {0, 0.62, 0.451}, {0.8, 0.475, 0.655},
    {0.902, 0.624, 0}, {0.337, 0.706, 0.914}, {0, 0, 0}};
/* [pt] ink and gaps between round ends. */
static const struct {
    double length[6];
    int n;
} dashes[] = {{{0}, 0}, {{6, 4}, 2}, {{0, 3.4}, 2}, {{7, 3.5, 0, 3.5}, 4}, {{3, 4}, 2}};

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

static void choose_color(const struct page *page, int curve)
{
    const double *color = colors[(size_t)curve % COUNT_OF(colors)];
    page->api->set_source_rgb(page->cairo, color[0], color[1], color[2]);
}

static void choose_line(const struct page *page, int curve, double width)
{
    size_t dash = kind_of(page->figure, curve) % COUNT_OF(dashes);
    page->api->set_line_width(page->cairo, width);
    page->api->set_dash(page->cairo, dashes[dash].length, dashes[dash].n, 0);
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
    const struct cairo_api *api = page->api;
    int corners = shapes[shape % COUNT_OF(shapes)].corners;
    const double(*corner)[2] = shapes[shape % COUNT_OF(shapes)].corner;

    api->new_sub_path(page->cairo);
    if (!corners)
        api->arc(page->cairo, x, y, RADIUS, 0, 6.283185307179586);
    for (int i = 0; i < corners; i++)
        api->line_to(page->cairo, x + RADIUS * corner[i][0], y + RADIUS * corner[i][1]);
    api->close_path(page->cairo);
}

/* Paints the marks that were added: those of a line are full, so that dashes do not show in them.
 */
static void end_points(const struct page *page, const struct curve *curve, bool dense)
{
    page->api->set_dash(page->cairo, NULL, 0, 0);
    page->api->set_line_width(page->cairo, !dense                     ? 0.9
                                           : line_count(page->figure) ? 1.7 * DOT
                                                                      : 1.1 * DOT);
    if (!curve->points)
        page->api->fill_preserve(page->cairo);
    page->api->stroke(page->cairo);
}

/* ---- lines ---- */

/* Marks at equal distances along the path, each curve's between those of the others; only its
 * length if `every` is 0.
 */
static double follow_path(const struct page *page, const cairo_path_t *path, int curve,
                          double every)
{
    double length = 0, x = 0, y = 0;
    double next = every * (0.5 + (double)kind_of(page->figure, curve) / page->figure->curves);

    for (int i = 0; i < path->num_data; i += path->data[i].header.length) {
        const cairo_path_data_t *to = &path->data[i + 1];
        double distance = hypot(to->point.x - x, to->point.y - y);
        if (path->data[i].header.type == CAIRO_PATH_LINE_TO) {
            for (; every > 0 && next <= length + distance; next += every) {
                double part = (next - length) / distance, at_x = x + part * (to->point.x - x),
                       at_y = y + part * (to->point.y - y);
                if (at_x >= page->left && at_x <= page->right && at_y >= page->top &&
                    at_y <= page->bottom)
                    add_shape(page, kind_of(page->figure, curve), at_x, at_y);
            }
            length += distance;
        }
        x = to->point.x;
        y = to->point.y;
    }
    return length;
}

static void draw_line(struct page *page, int curve, bool marked)
{
    const struct cairo_api *api = page->api;

    double width = page->right - page->left;
    api->save(page->cairo);
    api->rectangle(page->cairo, page->left, page->top, width, page->bottom - page->top);
    api->clip(page->cairo);
    page_path(page, &page->figure->curve[curve]);
    cairo_path_t *path = api->copy_path(page->cairo);
    double length = follow_path(page, path, curve, 0);
    /* Many turns need thin lines; a plot that they fill, none thinner than its grains. */
    choose_line(page, curve,
                length < 40 * width || page->grains == 1 ? LINE_WIDTH : LINE_WIDTH / 2);
    api->stroke(page->cairo);
    api->restore(page->cairo);
    if (marked && length > 0) {
        follow_path(page, path, curve, fmax(length / MARKS, 12));
        end_points(page, &page->figure->curve[curve], false);
    }
    api->path_destroy(path);
}

/* ---- bands ---- */

#define SHARE 0.25 /* of ink in a band */
#define BIN 0.5    /* [pt] points that lie in one such width are one corner of the band's edge */

static void choose_tint(const struct page *page, int curve)
{
    const double *color = colors[(size_t)curve % COUNT_OF(colors)];
    page->api->set_source_rgba(page->cairo, color[0], color[1], color[2], SHARE);
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
            page->api->line_to(page->cairo, at, edge);
        edge = floor(x / BIN) != bin ? y : side > 0 ? fmin(edge, y) : fmax(edge, y);
        bin = floor(x / BIN);
        at = x;
    }
    if (isfinite(edge))
        page->api->line_to(page->cairo, at, edge);
}

static void draw_band(struct page *page, int index)
{
    const struct cairo_api *api = page->api;
    const struct curve *curve = &page->figure->curve[index];
    api->save(page->cairo);
    api->rectangle(page->cairo, page->left, page->top, page->right - page->left,
                   page->bottom - page->top);
    api->clip(page->cairo);
    api->new_path(page->cairo);
    add_edge(page, curve, 1);
    add_edge(page, curve, -1);
    api->close_path(page->cairo);
    choose_tint(page, index);
    api->fill(page->cairo);
    api->restore(page->cairo);
}

double page_band_sample(struct page *page, int index, double x, double y, bool draw)
{
    const double width = 30, height = 8;
    if (draw) {
        choose_tint(page, index);
        page->api->rectangle(page->cairo, x, y - height / 2, width, height);
        page->api->fill(page->cairo);
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

static void put_letter(struct page *page, char letter, double x, double y)
{
    page_text(page, x, y + 0.36 * FONT_SIZE, 0.5, (char[]){letter, '\0'});
}

/* Points as a path of shapes, or of lines without length that their round ends turn into dots: one
 * for each square of that size. Returns how many. */
static long add_points(struct page *page, int index, bool dense, double square)
{
    const struct cairo_api *api = page->api;
    const struct curve *curve = &page->figure->curve[index];
    double x, y;
    long points = 0;

    api->new_path(page->cairo);
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
            put_letter(page, curve->mark, x, y);
        } else if (dense) {
            api->move_to(page->cairo, x, y);
            api->line_to(page->cairo, x, y);
        } else {
            add_shape(page, kind_of(page->figure, index), x, y);
        }
    }
    return points;
}

static void draw_points(struct page *page, int index, bool dense)
{
    if (add_points(page, index, dense, DOT) > DOTS && !has_letter(&page->figure->curve[index]))
        add_points(page, index, dense, 1.5 * DOT);
    end_points(page, &page->figure->curve[index], dense);
}

double page_sample(struct page *page, int index, double x, double y, bool draw)
{
    const struct cairo_api *api = page->api;
    const struct curve *curve = &page->figure->curve[index];
    double width = !curve->points      ? 30
                   : has_letter(curve) ? FONT_SIZE * 0.7
                                       : 12,
           middle = x + width / 2;
    bool dense = curve->points && is_dense(page, curve);

    if (!draw)
        return width;
    choose_color(page, index);
    if (has_letter(curve)) {
        put_letter(page, curve->mark, middle, y);
        return width;
    }
    if (!curve->points) {
        api->move_to(page->cairo, x, y);
        api->line_to(page->cairo, x + width, y);
        choose_line(page, index, LINE_WIDTH);
        api->stroke(page->cairo);
    }
    for (int i = -1; i <= 1 && dense; i++) {
        api->move_to(page->cairo, middle + 5 * i, y + (i ? 1 : -1));
        api->line_to(page->cairo, middle + 5 * i, y + (i ? 1 : -1));
    }
    if (!dense && (curve->points || line_count(page->figure) > 1))
        add_shape(page, kind_of(page->figure, index), middle, y);
    end_points(page, curve, dense);
    return width;
}

/* ---- all ---- */

static void draw_exits(struct page *page, int index)
{
    static const double ahead[4][2] = {{-1, 0}, {1, 0}, {0, 1}, {0, -1}};
    const struct cairo_api *api = page->api;
    struct curve_exit exits[4];

    if (!curve_exits(page->figure, &page->layout, index, exits))
        return;
    choose_color(page, index);
    for (int side = 0; side < 4; side++) {
        double x = page->left + exits[side].x * (page->right - page->left), dx = ahead[side][0];
        double y = page->bottom - exits[side].y * (page->bottom - page->top), dy = ahead[side][1];
        if (!exits[side].left)
            continue;
        api->move_to(page->cairo, x, y);
        api->line_to(page->cairo, x - 9 * dx + 4.5 * dy, y - 9 * dy + 4.5 * dx);
        api->line_to(page->cairo, x - 9 * dx - 4.5 * dy, y - 9 * dy - 4.5 * dx);
        api->close_path(page->cairo);
        api->fill(page->cairo);
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
            choose_color(page, i);
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
#endif
