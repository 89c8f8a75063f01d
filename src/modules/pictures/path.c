/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Converts the samples of a curve to a path, in three stages: trace_curve() keeps the first, last
 * and extreme samples of each column (M4: Jugel, Jerzak, Hackenbroich, Markl 2014, as in raster.c),
 * struct path_thinning leaves out corners on straight parts, and path_follow() leaves out what
 * passes only where the curve has been already. If the path then has too many corners, it is
 * computed again on a coarser grid. */
#include "modules/pictures/path.h"

#include <string.h>

#define PATH_COLUMNS 8.0   /* [1/pt] most columns per point; each is reduced to four samples */
#define PATH_STRAIGHT 0.05 /* [pt] largest distance of an omitted corner from the path */

/* Appends a corner to the path. */
static void path_put(struct path *path, double x, double y, bool begins)
{
    const struct corner corner = {x, y, begins};
    buffer_put(&path->corners, (struct text){(const char *)&corner, sizeof corner});
}

void path_free(struct path *path)
{
    buffer_free(&path->corners);
}

/* ---- straight parts ---- */

/* Leaves out corners that lie within `tolerance` [pt] of the path without them. The directions from
 * the last retained corner that pass all points since then closely enough form a cone; a point
 * outside of it, or a reversal, makes the point before it a corner (Williams 1978, Sklansky and
 * Gonzalez 1980). */
struct path_thinning {
    double tolerance;
    void (*put)(void *context, double x, double y, bool begins); /* takes the retained corners */
    void *context;
    double x, y;               /* the last retained corner */
    double last[2];            /* the last point */
    double low[2], high[2];    /* the cone's sides, if there is one */
    double farthest;           /* largest distance of a point since then from the corner */
    bool is_down, moved, cone; /* a line has begun; it has a second point; there is a cone */
};

/* Ends the line that is being drawn, if any, at its last point. */
static void thinning_finish(struct path_thinning *thinning)
{
    if (thinning->is_down && thinning->moved)
        thinning->put(thinning->context, thinning->last[0], thinning->last[1], false);
    thinning->is_down = thinning->moved = false;
}

/* Returns the z component of a x b: positive if b is clockwise of a on the page. */
static double cross_product(const double a[2], const double b[2])
{
    return a[0] * b[1] - a[1] * b[0];
}

/* Puts the pen down at a point. */
static void thinning_start(struct path_thinning *thinning, double x, double y)
{
    thinning_finish(thinning);
    thinning->put(thinning->context, x, y, true);
    thinning->x = thinning->last[0] = x;
    thinning->y = thinning->last[1] = y;
    thinning->is_down = true;
    thinning->moved = thinning->cone = false;
    thinning->farthest = 0;
}

/* Returns true if the point (x, y) can be reached by a straight line from the last corner that
 * passes all points since then within the tolerance: if it lies in the cone of these directions.
 * Narrows the cone by the point. */
static bool narrow_cone(struct path_thinning *thinning, double x, double y)
{
    const double dx = x - thinning->x, dy = y - thinning->y, distance = sqrt(dx * dx + dy * dy);
    if (distance < thinning->farthest - thinning->tolerance)
        return false;
    thinning->farthest = fmax(thinning->farthest, distance);
    if (distance <= thinning->tolerance)
        return true;
    const double way[2] = {dx / distance, dy / distance}, sine = thinning->tolerance / distance,
                 cosine = sqrt(1 - sine * sine);
    const double low[2] = {way[0] * cosine + way[1] * sine, way[1] * cosine - way[0] * sine},
                 high[2] = {way[0] * cosine - way[1] * sine, way[1] * cosine + way[0] * sine};
    if (thinning->cone &&
        (cross_product(thinning->low, way) < 0 || cross_product(way, thinning->high) < 0 ||
         thinning->low[0] * way[0] + thinning->low[1] * way[1] < 0))
        return false;
    if (!thinning->cone || cross_product(thinning->low, low) > 0)
        memcpy(thinning->low, low, sizeof low);
    if (!thinning->cone || cross_product(thinning->high, high) < 0)
        memcpy(thinning->high, high, sizeof high);
    thinning->cone = true;
    return true;
}

/* Continues the line to a point. The previous point becomes a corner if the new one leaves the cone
 * of narrow_cone(). */
static void thinning_draw_to(struct path_thinning *thinning, double x, double y)
{
    if (!narrow_cone(thinning, x, y)) {
        thinning->put(thinning->context, thinning->last[0], thinning->last[1], false);
        thinning->x = thinning->last[0];
        thinning->y = thinning->last[1];
        thinning->cone = false;
        thinning->farthest = 0;
        narrow_cone(thinning, x, y);
    }
    thinning->last[0] = x;
    thinning->last[1] = y;
    thinning->moved = true;
}

/* ---- samples to lines ---- */

/* Clips a line, in one coordinate that goes from `point` at s = 0 to point + way at s = 1, to
 * [low, high]: narrows [*begin, *end] to the s of the part inside; *begin > *end means none. */
static void line_part_clip(double point, double way, double low, double high, double *begin,
                           double *end)
{
    double a = (low - point) / way, b = (high - point) / way;
    if (way == 0) {
        if (point < low || point > high)
            *end = -1;
        return;
    }
    *begin = fmax(*begin, fmin(a, b));
    *end = fmin(*end, fmax(a, b));
}

/* A sample as a point of the page [pt]. */
struct spot {
    double x, y;
    size_t i; /* index of the sample */
};

/* State of trace_curve() between samples. */
struct tracer {
    const struct plot_area *area;
    struct path_thinning thinning;
    double columns;              /* [1/pt] number of columns in a point */
    size_t samples;              /* number of samples since the last gap */
    double column;               /* number of the column of the last samples */
    struct spot low, high, last; /* extremes and last of the samples in the column */
    double x, y;                 /* the last point that was passed on */
    bool pen_there;              /* the pen is at that point, which was not clipped */
};

/* Draws the part of a line to (x, y) that is within the margin around the plot. Lifts the pen where
 * the line leaves it. */
static void tracer_draw_line(struct tracer *tracer, double x, double y)
{
    const struct plot_area *area = tracer->area;
    const double left = area->left - PLOT_MARGIN, right = area->right + PLOT_MARGIN,
                 top = area->top - PLOT_MARGIN, bottom = area->bottom + PLOT_MARGIN;
    double x0 = tracer->x, y0 = tracer->y, begin = 0, end = 1;

    line_part_clip(x0, x - x0, left, right, &begin, &end);
    line_part_clip(y0, y - y0, top, bottom, &begin, &end);
    tracer->x = x;
    tracer->y = y;
    if (begin > end) {
        tracer->pen_there = false;
        return;
    }
    double x1 = end < 1 ? x0 + end * (x - x0) : x;
    double y1 = end < 1 ? y0 + end * (y - y0) : y;
    x0 += begin * (x - x0);
    y0 += begin * (y - y0);
    /* Rounding of a line that is clipped far away exceeds the margin. */
    if (!tracer->pen_there || begin > 0)
        thinning_start(&tracer->thinning, fmin(fmax(x0, left), right), fmin(fmax(y0, top), bottom));
    thinning_draw_to(&tracer->thinning, fmin(fmax(x1, left), right), fmin(fmax(y1, top), bottom));
    tracer->pen_there = !(end < 1);
}

/* Draws a line to a sample unless that is where the last line ended. */
static void tracer_draw_to(struct tracer *tracer, const struct spot *spot)
{
    if (spot->x != tracer->x || spot->y != tracer->y)
        tracer_draw_line(tracer, spot->x, spot->y);
}

/* Draws the extremes of the column in their order in time, then its last sample. */
static void tracer_leave_column(struct tracer *tracer)
{
    bool fell = tracer->high.i < tracer->low.i;
    if (!tracer->samples)
        return;
    tracer_draw_to(tracer, fell ? &tracer->high : &tracer->low);
    tracer_draw_to(tracer, fell ? &tracer->low : &tracer->high);
    tracer_draw_to(tracer, &tracer->last);
}

/* Ends the line at a gap. A sample between two gaps becomes a dot. */
static void tracer_pen_lift(struct tracer *tracer)
{
    tracer_leave_column(tracer);
    if (tracer->samples == 1)
        tracer_draw_line(tracer, tracer->x, tracer->y);
    thinning_finish(&tracer->thinning);
    tracer->samples = 0;
    tracer->pen_there = false;
}

/* Passes the curve as lines to put(context, x, y, begins), thinned within `tolerance` [pt] and
 * reduced to the first, lowest, highest and last sample in each of `columns` columns per point. NAN
 * in the samples is a gap. */
static void trace_curve(const struct curve *curve, const struct plot_area *area, double tolerance,
                        double columns, void (*put)(void *, double, double, bool), void *context)
{
    struct tracer tracer = {.area = area,
                            .columns = columns,
                            .thinning = {.tolerance = tolerance, .put = put, .context = context}};
    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        const struct spot spot = {plot_x(area, curve->x[i]), plot_y(area, curve->y[i]), i};
        const double column = floor(spot.x * tracer.columns);
        if (isnan(spot.x) || isnan(spot.y)) {
            tracer_pen_lift(&tracer);
            continue;
        }
        if (tracer.samples && column == tracer.column) {
            tracer.low = spot.y > tracer.low.y ? spot : tracer.low;
            tracer.high = spot.y < tracer.high.y ? spot : tracer.high;
        } else {
            tracer_leave_column(&tracer);
            if (tracer.samples)
                tracer_draw_line(&tracer, spot.x, spot.y);
            tracer.x = spot.x;
            tracer.y = spot.y;
            tracer.column = column;
            tracer.low = tracer.high = spot;
        }
        tracer.last = spot;
        tracer.samples++;
    }
    tracer_pen_lift(&tracer);
}

/* ---- where the curve has been ---- */

/* A bitmap of the page with a bit for each grain, a small square; set bits are where something was
 * drawn. */
struct grains {
    uint8_t *bit;      /* the bitmap, with a blank border of one grain */
    int width, height; /* size with the border */
    int bytes;         /* bytes of a row */
    double density;    /* grains per point */
    int run;           /* a line is drawn if it has this many blank grains in a row */
    bool wide;         /* lines also mark the neighbouring grains, as a pen of that width covers */
    double left, top;  /* [pt] of the area, with its margin */
};

/* Allocates a blank bitmap of `density` grains per point for the area and its margin, which tells
 * where ink is. Returns false if out of memory. */
static bool grains_init(struct grains *grains, const struct plot_area *area, double density,
                        struct arena *arena)
{
    grains->density = density;
    grains->left = area->left - PLOT_MARGIN;
    grains->top = area->top - PLOT_MARGIN;
    grains->width = (int)((area->right - area->left + 2 * PLOT_MARGIN) * density) + 3;
    grains->height = (int)((area->bottom - area->top + 2 * PLOT_MARGIN) * density) + 3;
    grains->bytes = grains->width / 8 + 1;
    const size_t size = (size_t)grains->bytes * (size_t)grains->height;
    grains->bit = arena_alloc(arena, size);
    if (grains->bit)
        memset(grains->bit, 0, size);
    return grains->bit;
}

/* Returns the byte of a grain, or NULL outside of the bitmap: rounding may put a line beside the
 * area by a fraction of a grain. */
static uint8_t *grain_byte(const struct grains *grains, int x, int y)
{
    return x >= 0 && x < grains->width && y >= 0 && y < grains->height
               ? &grains->bit[(size_t)y * (size_t)grains->bytes + (size_t)x / 8]
               : NULL;
}

static bool is_grain_marked(const struct grains *grains, int x, int y)
{
    const uint8_t *byte = grain_byte(grains, x, y);
    return byte && *byte >> x % 8 & 1;
}

static void grain_mark(struct grains *grains, int x, int y)
{
    uint8_t *byte = grain_byte(grains, x, y);
    if (byte)
        *byte |= (uint8_t)(1U << x % 8);
}

/* Returns true if the line from (x0, y0) to (x1, y1) [pt] crosses grains->run blank grains in a
 * row, or only blank ones, and so is worth drawing; its grains are marked then. */
static bool grains_pass(struct grains *grains, double x0, double y0, double x1, double y1)
{
    const double x = (x0 - grains->left) * grains->density + 1,
                 y = (y0 - grains->top) * grains->density + 1;
    double dx = (x1 - x0) * grains->density, dy = (y1 - y0) * grains->density;
    const int steps = (int)ceil(fmax(fabs(dx), fabs(dy)));
    const bool steep = fabs(dy) > fabs(dx);
    int run = 0;

    dx /= steps ? steps : 1;
    dy /= steps ? steps : 1;
    for (int i = 0; i <= steps && run < grains->run; i++)
        run = is_grain_marked(grains, (int)(x + i * dx), (int)(y + i * dy)) ? 0 : run + 1;
    const bool fresh = run >= grains->run || run == steps + 1;
    for (int i = 0; i <= steps && fresh; i++) {
        const int column = (int)(x + i * dx), row = (int)(y + i * dy);
        grain_mark(grains, column, row);
        if (grains->wide) {
            grain_mark(grains, column - steep, row - !steep);
            grain_mark(grains, column + steep, row + !steep);
        }
    }
    return fresh;
}

/* ---- lines ---- */

/* State of path_follow(), which adds to a path what is new of a line. */
struct follower {
    struct path *path;
    struct grains *grains;
    size_t most;      /* number of corners from which the path is too long */
    double pen[2];    /* end of the line so far, drawn or omitted */
    double end[2];    /* end of the part that was drawn last */
    bool begun, full; /* a part was drawn since the pen was put down; the path is too long */
};

/* Adds the line from the pen to (x, y) to the path, unless it passes only grains that earlier lines
 * have marked, and moves the pen; `begins` moves it without a line. context is the struct follower.
 * Called as the last stage of trace_curve(). */
static void path_follow(void *context, double x, double y, bool begins)
{
    struct follower *f = context;
    const double x0 = f->pen[0], y0 = f->pen[1];
    f->pen[0] = x;
    f->pen[1] = y;
    if (begins) {
        f->begun = false;
        return;
    }
    f->path->length += hypot(x - x0, y - y0);
    if (f->full || !grains_pass(f->grains, x0, y0, x, y))
        return;
    /* Length of the omitted part in grains. A short one is drawn, so that the line continues; a
     * long one was drawn before, so that the pen is lifted. */
    const double skipped =
        f->begun ? (fabs(x0 - f->end[0]) + fabs(y0 - f->end[1])) * f->grains->density : INFINITY;
    if (skipped > 0)
        path_put(f->path, x0, y0, skipped > 5); /* a gap of 5 grains is hardly seen */
    path_put(f->path, x, y, false);
    f->begun = true;
    f->end[0] = x;
    f->end[1] = y;
    f->full = path_count(f->path) > f->most;
}

/* Grids from the finest, on which any pen covers what is left out, to the coarsest, with the number
 * of grains along a point, the tolerance of thinning, and the width of the pen that covers gaps. */
static const struct {
    double density;
    double tolerance; /* [pt] */
    double width;     /* [pt] */
} grids[] = {{12, PATH_STRAIGHT, 0}, {4, 0.06, 0.75}, {2, 0.1, 1.5},
             {1.5, 0.1, 2},          {1, 0.15, 3},    {0.3, 0.3, 9}};
#define GRID_ROUGH 4 /* index of the grid with one grain per point */

/* Computes the path of a curve, drawn as a line, within the area. Tries ever coarser grids until
 * the path has at most limit->corners corners; limit->rough uses a coarse one at once. Returns
 * false if out of memory or cancelled. */
bool path_of_line(const struct curve *curve, const struct plot_area *area,
                  const struct path_limit *limit, struct path *path)
{
    bool full = true;
    for (size_t i = limit->rough ? GRID_ROUGH : 0; i < COUNT_OF(grids) && full; i++) {
        const bool last = limit->rough || i + 1 == COUNT_OF(grids);
        struct arena arena = {0};
        struct grains grains = {.run = 1 + (i > 0), .wide = !limit->rough};
        struct follower f = {
            .path = path, .grains = &grains, .most = last ? SIZE_MAX : limit->corners};
        buffer_clear(&path->corners);
        path->length = 0;
        path->width = grids[i].width;
        const bool ok = grains_init(&grains, area, grids[i].density, &arena);
        if (ok)
            trace_curve(curve, area, grids[i].tolerance, fmin(grids[i].density, PATH_COLUMNS),
                        path_follow, &f);
        arena_reset(&arena);
        if (!ok || cancelled(curve->cancel))
            return false;
        full = f.full;
    }
    return !path->corners.failed;
}

/* ---- dots ---- */

/* Finds the position of sample i on the page. Returns true if it lies inside the plot. */
static bool dot_position(const struct curve *curve, const struct plot_area *area, size_t i,
                         double place[2])
{
    const double edge = 1e-6; /* rounding */
    place[0] = plot_x(area, curve->x[i]);
    place[1] = plot_y(area, curve->y[i]);
    return place[0] >= area->left - edge && place[0] <= area->right + edge &&
           place[1] >= area->top - edge && place[1] <= area->bottom + edge;
}

/* Adds one dot for each square of `square` [pt] that contains a sample, and stops when there are
 * more than `most`. Returns false if out of memory or cancelled. */
static bool put_single_dots(const struct curve *curve, const struct plot_area *area, double square,
                            size_t most, struct arena *arena, struct path *path)
{
    struct grains grains = {.run = 1};
    double dot[2];
    if (!grains_init(&grains, area, square > 1 ? 1 : 1 / square, arena))
        return false;
    buffer_clear(&path->corners);
    for (size_t i = 0; curve_goes_on(curve, i) && path_count(path) <= most; i++) {
        if (!dot_position(curve, area, i, dot))
            continue;
        const double x = area->left + floor((dot[0] - area->left) / square) * square,
                     y = area->top + floor((dot[1] - area->top) / square) * square;
        if (grains_pass(&grains, x, y, x, y))
            path_put(path, dot[0], dot[1], true);
    }
    path->width = 0;
    return !cancelled(curve->cancel);
}

/* Computes the path of a curve drawn as dots. Tries squares of increasing size, one dot each, until
 * there are at most limit->corners dots. Returns false if out of memory or cancelled. */
bool path_of_dots(const struct curve *curve, const struct plot_area *area,
                  const struct path_limit *limit, struct path *path)
{
    static const double squares[] = {0.125, 1, 2, 3, 4};
    struct arena arena = {0};
    bool ok = true;
    for (size_t i = limit->rough; i < COUNT_OF(squares) && ok; i++) {
        const bool last = limit->rough || i + 1 == COUNT_OF(squares);
        const size_t most = last ? SIZE_MAX : limit->corners;
        ok = put_single_dots(curve, area, squares[i], most, &arena, path);
        if (path_count(path) <= most)
            break;
    }
    arena_reset(&arena);
    return ok && !path->corners.failed;
}

/* Returns true if some line of the path is partly inside the box between left, right, top and
 * bottom [pt]. A corner that begins a line counts as a line of length 0. */
bool path_meets(const struct path *path, double left, double top, double right, double bottom)
{
    const struct corner *corner = path_corners(path);
    for (size_t i = 0; i < path_count(path); i++) {
        const struct corner *target = &corner[i], *source = target->begins ? target : target - 1;
        double begin = 0, end = 1;
        line_part_clip(source->x, target->x - source->x, left, right, &begin, &end);
        line_part_clip(source->y, target->y - source->y, top, bottom, &begin, &end);
        if (begin <= end)
            return true;
    }
    return false;
}
