/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ink as grains on a page, and the outlines of the region that it covers. */
#include "figure/path.h"

#include <string.h>

bool grains_init(struct grains *grains, const struct plot_area *area, int density,
                 struct arena *arena)
{
    grains->density = density;
    grains->left = area->left - PLOT_MARGIN;
    grains->top = area->top - PLOT_MARGIN;
    grains->across = (int)((area->right - area->left + 2 * PLOT_MARGIN) * density) + 3;
    grains->down = (int)((area->bottom - area->top + 2 * PLOT_MARGIN) * density) + 3;
    grains->bytes = grains->across / 8 + 1;
    grains->bit = arena_alloc(arena, (size_t)grains->bytes * (size_t)grains->down);
    if (grains->bit)
        grains_clear(grains);
    return grains->bit;
}

void grains_clear(struct grains *grains)
{
    memset(grains->bit, 0, (size_t)grains->bytes * (size_t)grains->down);
}

/* A way may pass beside the area by a part of a grain. */
static bool is_within(const struct grains *grains, int x, int y)
{
    return x >= 0 && x < grains->across && y >= 0 && y < grains->down;
}

static bool has(const struct grains *grains, int x, int y)
{
    return is_within(grains, x, y) &&
           grains->bit[(size_t)y * (size_t)grains->bytes + (size_t)x / 8] >> x % 8 & 1;
}

static void mark(struct grains *grains, int x, int y)
{
    if (is_within(grains, x, y))
        grains->bit[(size_t)y * (size_t)grains->bytes + (size_t)x / 8] |= (uint8_t)(1U << x % 8);
}

static double grain_x(const struct grains *grains, double x)
{
    return (x - grains->left) * grains->density + 1;
}

static double grain_y(const struct grains *grains, double y)
{
    return (y - grains->top) * grains->density + 1;
}

bool grains_pass(struct grains *grains, double x0, double y0, double x1, double y1)
{
    const double x = grain_x(grains, x0), y = grain_y(grains, y0);
    double dx = (x1 - x0) * grains->density, dy = (y1 - y0) * grains->density;
    const int steps = (int)ceil(fmax(fabs(dx), fabs(dy)));
    const bool steep = fabs(dy) > fabs(dx);
    bool fresh = false;

    dx /= steps ? steps : 1;
    dy /= steps ? steps : 1;
    for (int i = 0; i <= steps && !fresh; i++)
        fresh = !has(grains, (int)(x + i * dx), (int)(y + i * dy));
    for (int i = 0; i <= steps && fresh; i++) {
        const int column = (int)(x + i * dx), row = (int)(y + i * dy);
        mark(grains, column, row);
        if (grains->wide) {
            mark(grains, column - steep, row - !steep);
            mark(grains, column + steep, row + !steep);
        }
    }
    return fresh;
}

/* Grains from..to of a row. */
static void fill_row(struct grains *grains, int row, int from, int to)
{
    uint8_t *byte = &grains->bit[(size_t)row * (size_t)grains->bytes];
    from = from < 1 ? 1 : from;
    to = to > grains->across - 2 ? grains->across - 2 : to;
    if (from > to)
        return;
    const uint8_t first = (uint8_t)(0xFFU << from % 8), last = (uint8_t)(0xFFU >> (7 - to % 8));
    if (from / 8 == to / 8) {
        byte[from / 8] |= first & last;
        return;
    }
    byte[from / 8] |= first;
    memset(&byte[from / 8 + 1], 0xFF, (size_t)(to / 8 - from / 8 - 1));
    byte[to / 8] |= last;
}

static int row_within(const struct grains *grains, double y)
{
    return (int)fmin(fmax(y, 1), grains->down - 2);
}

static void fill_disc(struct grains *grains, double x, double y, double radius)
{
    const int from = row_within(grains, ceil(y - radius - 0.5)),
              to = row_within(grains, floor(y + radius - 0.5));
    for (int row = from; row <= to; row++) {
        const double up = row + 0.5 - y, half = sqrt(fmax(radius * radius - up * up, 0));
        fill_row(grains, row, (int)ceil(x - half - 0.5), (int)floor(x + half - 0.5));
    }
    fill_row(grains, row_within(grains, y), (int)x, (int)x); /* at least the grain it is in */
}

void grains_stroke(struct grains *grains, double x0, double y0, double x1, double y1, double width)
{
    const double radius = width / 2 * grains->density, ax = grain_x(grains, x0),
                 ay = grain_y(grains, y0), bx = grain_x(grains, x1), by = grain_y(grains, y1),
                 dx = bx - ax, dy = by - ay, length = hypot(dx, dy);

    fill_disc(grains, bx, by, radius);
    if (length < 0.5)
        return;
    /* The rows of a band whose corners are `radius` aside of the ends. */
    const double side_x = fabs(dy) / length * radius, side_y = fabs(dx) / length * radius,
                 low = fmin(ax, bx), high = fmax(ax, bx);
    const int from = row_within(grains, ceil(fmin(ay, by) - side_y - 0.5)),
              to = row_within(grains, floor(fmax(ay, by) + side_y - 0.5));
    const double half = fabs(dy) > 1e-9 ? radius * length / fabs(dy) : HUGE_VAL,
                 slope = fabs(dy) > 1e-9 ? dx / dy : 0;
    for (int row = from; row <= to; row++) {
        const double middle = ax + (row + 0.5 - ay) * slope;
        fill_row(grains, row, (int)ceil(fmax(middle - half, low - side_x) - 0.5),
                 (int)floor(fmin(middle + half, high + side_x) - 0.5));
    }
}

/* ---- outlines ---- */

struct outline {
    const struct grains *grains;
    struct path *path;
    struct path_thinning thinning;
    double area; /* [grain^2] twice, positive around ink */
    double hole;
};

static void put_corner(void *out, double x, double y, bool begins)
{
    path_put(out, x, y, begins);
}

/* The middle of an edge between two grains. */
static void outline_to(struct outline *outline, double x, double y, bool begins)
{
    const struct grains *grains = outline->grains;
    const double to_x = grains->left + (x - 1) / grains->density,
                 to_y = grains->top + (y - 1) / grains->density;
    if (begins)
        thin_begin(&outline->thinning, to_x, to_y);
    else
        thin_to(&outline->thinning, to_x, to_y);
}

/* Goes around from the left edge of the grain, ink at the right hand; grains that touch at a corner
 * are together. */
static void go_around(struct outline *outline, struct grains *seen, int x, int y)
{
    static const int way[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}; /* east south west north */
    static const int right[4][2] = {{0, 0}, {-1, 0}, {-1, -1}, {0, -1}},
                     left[4][2] = {{0, -1}, {0, 0}, {-1, 0}, {-1, -1}}; /* grains ahead */
    const size_t before = outline->path->corners.len;
    int at[2] = {x, y + 1}, to = 3;

    outline->area = 0;
    outline_to(outline, x, y + 0.5, true);
    do {
        if (to == 3)
            mark(seen, at[0], at[1] - 1);
        at[0] += way[to][0];
        at[1] += way[to][1];
        outline->area += (double)at[0] * way[to][1] - (double)at[1] * way[to][0];
        if (has(outline->grains, at[0] + left[to][0], at[1] + left[to][1]))
            to = (to + 3) % 4;
        else if (!has(outline->grains, at[0] + right[to][0], at[1] + right[to][1]))
            to = (to + 1) % 4;
        outline_to(outline, at[0] + 0.5 * way[to][0], at[1] + 0.5 * way[to][1], false);
    } while (at[0] != x || at[1] != y + 1 || to != 3);
    thin_end(&outline->thinning);
    if (outline->area < 0 && -outline->area < 2 * outline->hole)
        outline->path->corners.len = before;
}

bool grains_outline(const struct grains *grains, struct grains *scratch, double tolerance,
                    double hole, size_t most, struct path *path)
{
    struct outline outline = {.grains = grains,
                              .path = path,
                              .hole = hole * grains->density * grains->density,
                              .thinning = {.tolerance = tolerance, .put = put_corner, .out = path}};
    for (int y = 1; y < grains->down - 1; y++) {
        const uint8_t *byte = &grains->bit[(size_t)y * (size_t)grains->bytes];
        for (int x = 1; x < grains->across; x++) {
            if (x % 8 == 0) { /* nothing begins in a byte that is blank, or goes on */
                while (x / 8 < grains->bytes &&
                       (byte[x / 8] == 0 || (byte[x / 8] == 0xFF && byte[x / 8 - 1] & 0x80)))
                    x += 8;
                if (x >= grains->across)
                    break;
            }
            if (has(grains, x, y) && !has(grains, x - 1, y) && !has(scratch, x, y))
                go_around(&outline, scratch, x, y);
            if (path_count(path) > most)
                return false;
        }
    }
    return true;
}
