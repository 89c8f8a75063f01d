/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the curves of a picture: lines with dashes and marks of their own, data as points with
 * error bars, bands, arrows where a run leaves the plot. */
#include "modules/pictures/picture.h"

#define SHAPED_POINTS_MAX 150 /* Largest number of points that still get a shape. */
#define LINE_MARKS 9          /* Number of marks along a line, enough to follow it. */

/* Shapes of marks as corners in units of their radius. The first is a circle, which has no corners;
 * corners of a cross are the ends of its two strokes. */
static const struct {
    int corners;
    bool cross;
    double corner[4][2];
} shapes[] = {{0, false, {{0}}},
              {4, false, {{-0.85, -0.85}, {0.85, -0.85}, {0.85, 0.85}, {-0.85, 0.85}}},
              {3, false, {{0, -1.15}, {1.1, 0.8}, {-1.1, 0.8}}},
              {4, false, {{0, -1.25}, {1.25, 0}, {0, 1.25}, {-1.25, 0}}},
              {3, false, {{0, 1.15}, {1.1, -0.8}, {-1.1, -0.8}}},
              {4, true, {{-1, -1}, {1, 1}, {-1, 1}, {1, -1}}},
              {4, true, {{-1.3, 0}, {1.3, 0}, {0, -1.3}, {0, 1.3}}}};

/* Twelve marks: five shapes, filled on lines and empty elsewhere, then the same the other way
 * round, then two crosses. As the numbers of colours (7) and dashes (6) have no common divisor, no
 * two of the first 42 curves look the same. */
enum { SOLID_SHAPES = 5, MARKS = 12 };

/* Returns how many lines, or points, precede the curve, or the one whose look it shares. */
static size_t rank_in_kind(const struct figure *figure, int curve)
{
    size_t count = 0;
    curve = figure->curve[curve].look ? figure->curve[curve].look - 1 : curve;
    for (int i = 0; i < curve; i++)
        count += figure->curve[i].points == figure->curve[curve].points;
    return count;
}

/* Returns the number of curves that are lines. */
static int line_count(const struct figure *figure)
{
    int lines = 0;
    for (int i = 0; i < figure->curves; i++)
        lines += !figure->curve[i].points;
    return lines;
}

/* Returns the index of the curve whose colour and shape this one has: often its own. */
static int look_index(const struct page *page, int curve)
{
    const int look = page->figure->curve[curve].look;
    return look ? look - 1 : curve;
}

/* Returns the colour of a curve. */
static const double *curve_color(const struct page *page, int curve)
{
    return style_palette[(size_t)look_index(page, curve) % style_palette_count];
}

/* Returns the brush for a line of the curve, with its colour and dashes. */
static struct brush line_ink(const struct page *page, int curve, double width)
{
    const size_t dashes = rank_in_kind(page->figure, curve) % style_dashes_count;
    return (struct brush){.color = curve_color(page, curve),
                          .width = width,
                          .dashes = &style_dashes[dashes],
                          .dash = page->style.dash};
}

/* Returns true if the mark is a letter or digit, which is drawn as such. Other marks are drawn as
 * shapes, which can be distinguished when they are small. */
static bool has_letter(const struct curve *curve)
{
    char c = curve->mark;
    return curve->points && !curve->joined &&
           ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '?');
}

/* Returns true if a line passes through the marks of the curve. */
static bool on_line(const struct curve *curve)
{
    return !curve->points || curve->joined;
}

/* Adds the mark that distinguishes the curve, at (x, y) [pt], to the path of the surface;
 * paint_points() paints it. */
static void add_mark(const struct page *page, int curve, double x, double y)
{
    const size_t mark = rank_in_kind(page->figure, curve) % MARKS,
                 shape = mark < 2 * SOLID_SHAPES ? mark % SOLID_SHAPES : mark - SOLID_SHAPES;
    const double radius = page->style.mark;
    const int corners = shapes[shape].corners;

    if (!corners)
        surface_circle(page->surface, x, y, radius);
    for (int i = 0; i < corners; i++) {
        const bool begins = i == 0 || (shapes[shape].cross && i == 2);
        (begins ? surface_move : surface_line)(page->surface,
                                               x + radius * shapes[shape].corner[i][0],
                                               y + radius * shapes[shape].corner[i][1]);
    }
    if (corners && !shapes[shape].cross)
        surface_close(page->surface);
}

/* Returns true if the marks of the curve are filled. */
static bool has_full_marks(const struct page *page, int curve)
{
    const size_t mark = rank_in_kind(page->figure, curve) % MARKS;
    const bool inverted = mark >= SOLID_SHAPES;
    return mark < 2 * SOLID_SHAPES && on_line(&page->figure->curve[curve]) != inverted;
}

/* Paints the marks or, if `dense`, the dots that were added. */
static void paint_points(const struct page *page, int index, bool dense)
{
    surface_paint(page->surface,
                  &(struct brush){.color = curve_color(page, index),
                                  .width = dense ? page_dot(page) : page->style.mark_line,
                                  .fill = !dense && has_full_marks(page, index)});
}

/* ---- paths ---- */

/* Adds a path to that of the surface. */
static void add_path(const struct page *page, const struct path *path)
{
    const struct corner *corner = path_corners(path);
    for (size_t i = 0; i < path_count(path); i++)
        (corner[i].begins ? surface_move : surface_line)(page->surface, corner[i].x, corner[i].y);
}

/* ---- lines ---- */

struct mark_place {
    double x, y;
};

/* Stores a position. Returns true if it lies inside the plot. */
static bool position_in_plot(const struct page *page, double x, double y, struct mark_place *spot)
{
    *spot = (struct mark_place){x, y};
    return x >= page->left && x <= page->right && y >= page->top && y <= page->bottom;
}

/* Returns where the first mark is, in steps between marks; marks of different curves alternate. */
static double first_mark_step(const struct page *page, int curve)
{
    return 0.5 + (double)rank_in_kind(page->figure, curve) / page->figure->curves;
}

/* Finds up to `max` positions in the plot at equal distances along a line, for its marks. Sets
 * place[] and returns their number. */
static int marks_along(const struct page *page, int curve, struct mark_place *place, int max)
{
    const struct path *path = &page->path[curve];
    const struct corner *corner = path_corners(path);
    const double every = fmax(path->length / LINE_MARKS, page->style.mark_apart);
    double length = 0, next = every * first_mark_step(page, curve);
    int n = 0;
    for (size_t i = 1; i < path_count(path); i++) {
        const struct corner *previous = &corner[i - 1];
        const double dx = corner[i].x - previous->x, dy = corner[i].y - previous->y,
                     distance = hypot(dx, dy);
        if (corner[i].begins)
            continue;
        for (; n < max && next <= length + distance; next += every) {
            const double part = (next - length) / distance;
            n +=
                position_in_plot(page, previous->x + part * dx, previous->y + part * dy, &place[n]);
        }
        length += distance;
    }
    return n;
}

/* Finds positions at samples, for a path of which most is left out. Returns their number. */
static int marks_at_samples(const struct page *page, int index, struct mark_place *place, int max)
{
    const struct curve *curve = &page->figure->curve[index];
    const double every = (double)curve->n / LINE_MARKS;
    int n = 0;
    for (double next = every * first_mark_step(page, index); n < max && next < (double)curve->n;
         next += every)
        n += position_in_plot(page, page_x(page, curve->x[(size_t)next]),
                              page_y(page, curve->y[(size_t)next]), &place[n]);
    return n;
}

/* Draws marks, on white if they are empty or if halo, its width [pt] around the marks, is above
 * 0. */
static void draw_marks(const struct page *page, int curve, const struct mark_place *place,
                       int marks, double halo)
{
    const bool covers =
        halo > 0 || (on_line(&page->figure->curve[curve]) && !has_full_marks(page, curve));
    for (int paper = covers; paper >= 0; paper--) {
        for (int i = 0; i < marks; i++)
            add_mark(page, curve, place[i].x, place[i].y);
        if (paper)
            surface_paint(page->surface,
                          &(struct brush){.color = style_white, .width = halo, .fill = true});
        else
            paint_points(page, curve, false);
    }
}

/* Draws the line of curve number `curve` and, if `marked`, marks along it that distinguish it from
 * others. Lines that would fill the plot are thinner; a curve of arrows is grey and has no marks.
 */
static void draw_line(struct page *page, int curve, bool marked)
{
    const struct path *path = &page->path[curve];
    const struct picture_style *style = &page->style;
    struct mark_place place[LINE_MARKS + 1];
    /* Many turns need thin lines. */
    const bool many = path->length > 40 * (page->right - page->left);
    const double width = fmax(many ? style->thin_line : style->curve_line, path->width);
    const struct brush line =
        path->width > 0 ? (struct brush){.color = curve_color(page, curve), .width = width}
                        : line_ink(page, curve, width);
    const bool arrows = page->figure->curve[curve].arrows;
    const struct brush thin = {.color = style_gray, .width = style->thin_line};
    int marks = 0;
    if (marked && !arrows)
        marks =
            (path->width > 0 ? marks_at_samples : marks_along)(page, curve, place, LINE_MARKS + 1);

    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    add_path(page, path);
    surface_paint(page->surface, arrows ? &thin : &line);
    surface_unclip(page->surface);
    draw_marks(page, curve, place, marks, path->width > 0 ? 3 * style->mark_line : 0);
}

/* ---- bands ---- */

/* [pt] Points within this width become one corner of a band's edge. */
#define BAND_BIN_POINTS 0.5

static void paint_band(const struct page *page, int curve)
{
    surface_paint(
        page->surface,
        &(struct brush){.color = curve_color(page, curve), .opacity = STYLE_BAND, .fill = true});
}

/* Adds one edge of a curve's band to the path: the upper one forwards (side 1), the lower one
 * backwards (-1), so that both enclose the band. Only the outermost sample in each BAND_BIN_POINTS
 * [pt] is used. */
static void add_band_edge(const struct page *page, const struct curve *curve, int side)
{
    double bin = NAN, last_x = 0, edge = NAN;
    for (size_t k = 0; curve_goes_on(curve, k); k++) {
        const size_t i = side > 0 ? k : curve->n - 1 - k;
        const double x = page_x(page, curve->x[i]),
                     y = page_y(page, curve->y[i] + side * curve->spread[i]);
        if (!isfinite(x + y))
            continue;
        if (floor(x / BAND_BIN_POINTS) != bin && isfinite(edge))
            surface_line(page->surface, last_x, edge);
        if (floor(x / BAND_BIN_POINTS) != bin)
            edge = y;
        else
            edge = side > 0 ? fmin(edge, y) : fmax(edge, y);
        bin = floor(x / BAND_BIN_POINTS);
        last_x = x;
    }
    if (isfinite(edge))
        surface_line(page->surface, last_x, edge);
}

/* Fills the band between the edges y + spread and y - spread of a curve. */
static void draw_band(struct page *page, int index)
{
    const struct curve *curve = &page->figure->curve[index];
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    surface_new_path(page->surface);
    add_band_edge(page, curve, 1);
    add_band_edge(page, curve, -1);
    surface_close(page->surface);
    paint_band(page, index);
    surface_unclip(page->surface);
}

/* Draws a short band in the legend, or only returns its width. */
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

/* Finds the position of sample i on the page. Returns true if it is inside the plot. */
static bool point_position(const struct page *page, const struct curve *curve, size_t i, double *x,
                           double *y)
{
    *x = page_x(page, curve->x[i]);
    *y = page_y(page, curve->y[i]);
    double edge = 1e-6; /* rounding */
    return *x >= page->left - edge && *x <= page->right + edge && *y >= page->top - edge &&
           *y <= page->bottom + edge;
}

/* Returns true if the curve has too many points for shapes, so that it is drawn as dots below
 * lines. */
static bool is_dense(const struct page *page, const struct curve *curve)
{
    size_t inside = 0;
    double x, y;
    for (size_t i = 0; curve_goes_on(curve, i) && inside <= SHAPED_POINTS_MAX && !has_letter(curve);
         i++)
        inside += point_position(page, curve, i, &x, &y);
    return inside > SHAPED_POINTS_MAX && !curve->joined;
}

static void put_letter(const struct page *page, int curve, double x, double y)
{
    page_text(page, x, y, 0.5, curve_color(page, curve),
              (char[]){page->figure->curve[curve].mark, '\0'});
}

/* Draws the error bars of a curve, with caps and white inside their marks unless the points are
 * dense (too many for single marks). */
static void draw_bars(struct page *page, int index, bool dense)
{
    const struct curve *curve = &page->figure->curve[index];
    const struct picture_style *style = &page->style;
    const struct path *path = &page->path[page->figure->curves + index];
    const struct brush line = {.color = curve_color(page, index),
                               .width =
                                   fmax(dense ? style->thin_line : style->mark_line, path->width)},
                       paper = {.color = style_white, .fill = true};
    double x, y;
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    add_path(page, path);
    for (size_t i = 0; !dense && curve_goes_on(curve, i); i++) {
        for (int side = -1; side <= 1 && curve->bar[i] > 0; side += 2) {
            x = page_x(page, curve->x[i]);
            y = page_y(page, curve->y[i] + side * curve->bar[i]);
            if (!isfinite(x + y))
                continue;
            surface_move(page->surface, x - style->cap, y);
            surface_line(page->surface, x + style->cap, y);
        }
    }
    surface_paint(page->surface, &line);
    surface_unclip(page->surface);
    for (size_t i = 0; !dense && !has_letter(curve) && curve_goes_on(curve, i); i++)
        if (point_position(page, curve, i, &x, &y))
            add_mark(page, index, x, y);
    surface_paint(page->surface, &paper);
}

/* Draws points as shapes or letters; if they are dense, as dots, which are lines of length 0 with
 * round ends. */
static void draw_points(struct page *page, int index, bool dense)
{
    const struct curve *curve = &page->figure->curve[index];
    const struct path *path = &page->path[index];
    const struct corner *corner = path_corners(path);
    double x, y;

    if (curve->bar)
        draw_bars(page, index, dense);
    for (size_t i = 0; dense && i < path_count(path); i++) {
        surface_move(page->surface, corner[i].x, corner[i].y);
        surface_line(page->surface, corner[i].x, corner[i].y);
    }
    for (size_t i = 0; !dense && curve_goes_on(curve, i); i++) {
        if (!point_position(page, curve, i, &x, &y))
            continue;
        if (has_letter(curve))
            put_letter(page, index, x, y);
        else if (curve->joined)
            draw_marks(page, index, &(struct mark_place){x, y}, 1, 0);
        else
            add_mark(page, index, x, y);
    }
    paint_points(page, index, dense);
}

/* Returns the width of the sample of curve `index` in the legend and, if `draw` is set, draws it
 * with its left end at (x, y), as a short line, a mark, a letter or dots, like the curve itself. */
double page_sample(struct page *page, int index, double x, double y, bool draw)
{
    const struct picture_style *style = &page->style;
    const struct curve *curve = &page->figure->curve[index];
    double width;
    if (on_line(curve))
        width = style->sample;
    else
        width = has_letter(curve) ? 0.7 * style->font : style->mark_sample;
    const double middle = x + width / 2;
    const bool dense = curve->points && is_dense(page, curve);

    if (!draw)
        return width;
    if (has_letter(curve)) {
        put_letter(page, index, middle, y);
        return width;
    }
    if (on_line(curve)) {
        const struct brush brush = line_ink(page, index, style->curve_line);
        surface_move(page->surface, x, y);
        surface_line(page->surface, x + width, y);
        surface_paint(page->surface, &brush);
    }
    for (int i = -1; i <= 1 && dense; i++) {
        const double dot_x = middle + 2.5 * style->dot * i,
                     height = y + style->dot * (i ? 0.5 : -0.5);
        surface_move(page->surface, dot_x, height);
        surface_line(page->surface, dot_x, height);
    }
    if (!dense && (curve->points || line_count(page->figure) > 1))
        draw_marks(page, index, &(struct mark_place){middle, y}, 1, 0);
    paint_points(page, index, dense);
    return width;
}

/* ---- all ---- */

/* Draws arrowheads on the frame where a run leaves the plot. */
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
        surface_paint(page->surface,
                      &(struct brush){.color = curve_color(page, index), .fill = true});
    }
}

/* Draws the lines that join the points of a curve. */
static void draw_joins(const struct page *page, int index)
{
    const struct brush ink = line_ink(page, index, page->style.curve_line);
    surface_clip(page->surface, page->left, page->top, page->right, page->bottom);
    add_path(page, &page->path[index]);
    surface_paint(page->surface, &ink);
    surface_unclip(page->surface);
}

/* Draws the lines that fill the plot below the others, from the last to the first. */
static void draw_lines(struct page *page)
{
    const struct figure *figure = page->figure;
    const bool marked = line_count(figure) > 1;
    for (int fills = 1; fills >= 0; fills--)
        for (int i = figure->curves - 1; i >= 0; i--)
            if (!figure->curve[i].points && curve_drawn(figure, i) &&
                (page->path[i].width > 0) == fills)
                draw_line(page, i, marked);
}

/* Draws all curves of a panel in the order in which things may cover each other: guides, bands,
 * joining lines, dense points, lines, single points, arrows, labels. The first curve is drawn
 * last. */
void page_curves(struct page *page)
{
    const struct figure *figure = page->figure;

    page_guides(page);
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].spread)
            draw_band(page, i);
    for (int i = figure->curves - 1; i >= 0; i--)
        if (curve_drawn(figure, i) && figure->curve[i].joined)
            draw_joins(page, i);
    /* Dense data, lines with the first above, data that lines can be seen through. */
    for (int dense = 1; dense >= 0; dense--) {
        for (int i = figure->curves - 1; i >= 0; i--)
            if (curve_drawn(figure, i) && figure->curve[i].points &&
                is_dense(page, &figure->curve[i]) == dense)
                draw_points(page, i, dense);
        if (dense)
            draw_lines(page);
    }
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && !figure->curve[i].arrows)
            draw_exits(page, i);
    page_labels(page);
}
