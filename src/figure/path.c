/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * From samples to the path of a curve.
 *
 * Of samples that follow each other in a column of an eighth of a point the first, the last and the
 * extremes are kept (M4: Jugel, Jerzak, Hackenbroich, Markl 2014, as in raster.c); what a straight
 * line shows as well is left out, and so is a part that passes only where the curve has been
 * already. What still has too many corners becomes the region that it covers.
 */
#include "figure/path.h"

#include <string.h>

#define COLUMNS 8 /* of a point, in each of which samples are summed up */
#define WAY                                                                                        \
    12          /* grains along a point, of a line's way: what passes those of before is not drawn \
                 */
#define ROUGH 1 /* likewise, only to see what it meets */
#define LONG 6000     /* corners of a line that may be shorter as a region */
#define DENSITY 8     /* grains along a point */
#define STRAIGHT 0.05 /* [pt] */
#define A_DOT 1.6     /* corners that a dot of its own takes as much room as */

void path_put(struct path *path, double x, double y, bool begins)
{
    const struct corner corner = {x, y, begins};
    buffer_put(&path->corners, (struct text){(const char *)&corner, sizeof corner});
}

void path_free(struct path *path)
{
    buffer_free(&path->corners);
}

/* ---- straight parts ---- */

static double cross(const double a[2], const double b[2])
{
    return a[0] * b[1] - a[1] * b[0];
}

void thin_begin(struct path_thinning *thinning, double x, double y)
{
    thin_end(thinning);
    thinning->put(thinning->out, x, y, true);
    thinning->x = thinning->at[0] = x;
    thinning->y = thinning->at[1] = y;
    thinning->down = true;
    thinning->moved = thinning->cone = false;
    thinning->farthest = 0;
}

/* Whether the point lies in the cone, which is narrowed to those that pass it. */
static bool narrow(struct path_thinning *thinning, double x, double y)
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
    if (thinning->cone && (cross(thinning->low, way) < 0 || cross(way, thinning->high) < 0 ||
                           thinning->low[0] * way[0] + thinning->low[1] * way[1] < 0))
        return false;
    if (!thinning->cone || cross(thinning->low, low) > 0)
        memcpy(thinning->low, low, sizeof low);
    if (!thinning->cone || cross(thinning->high, high) < 0)
        memcpy(thinning->high, high, sizeof high);
    thinning->cone = true;
    return true;
}

void thin_to(struct path_thinning *thinning, double x, double y)
{
    if (!narrow(thinning, x, y)) {
        thinning->put(thinning->out, thinning->at[0], thinning->at[1], false);
        thinning->x = thinning->at[0];
        thinning->y = thinning->at[1];
        thinning->cone = false;
        thinning->farthest = 0;
        narrow(thinning, x, y);
    }
    thinning->at[0] = x;
    thinning->at[1] = y;
    thinning->moved = true;
}

void thin_end(struct path_thinning *thinning)
{
    if (thinning->down && thinning->moved)
        thinning->put(thinning->out, thinning->at[0], thinning->at[1], false);
    thinning->down = thinning->moved = false;
}

/* ---- samples to lines ---- */

/* Narrows the part [from, to] of a line to where low <= at + part * way <= high. */
static void cut(double at, double way, double low, double high, double *from, double *to)
{
    double a = (low - at) / way, b = (high - at) / way;
    if (way == 0) {
        if (at < low || at > high)
            *to = -1;
        return;
    }
    *from = fmax(*from, fmin(a, b));
    *to = fmin(*to, fmax(a, b));
}

struct spot {
    double x, y;
    size_t i; /* of the sample */
};

struct tracer {
    const struct plot_area *area;
    struct path_thinning thinning;
    size_t samples;              /* since the last gap */
    double column;               /* that the last samples are in */
    struct spot low, high, last; /* of them */
    double x, y;                 /* followed up to here */
    bool whole;                  /* which is where the pen is */
};

static void trace_line(struct tracer *tracer, double x, double y)
{
    const struct plot_area *area = tracer->area;
    const double left = area->left - PLOT_MARGIN, right = area->right + PLOT_MARGIN,
                 top = area->top - PLOT_MARGIN, bottom = area->bottom + PLOT_MARGIN;
    double x0 = tracer->x, y0 = tracer->y, from = 0, to = 1;

    cut(x0, x - x0, left, right, &from, &to);
    cut(y0, y - y0, top, bottom, &from, &to);
    tracer->x = x;
    tracer->y = y;
    if (from > to) {
        tracer->whole = false;
        return;
    }
    double x1 = to < 1 ? x0 + to * (x - x0) : x, y1 = to < 1 ? y0 + to * (y - y0) : y;
    x0 += from * (x - x0);
    y0 += from * (y - y0);
    /* Of a line that is cut off far away rounding leaves more than the margin has. */
    if (!tracer->whole || from > 0)
        thin_begin(&tracer->thinning, fmin(fmax(x0, left), right), fmin(fmax(y0, top), bottom));
    thin_to(&tracer->thinning, fmin(fmax(x1, left), right), fmin(fmax(y1, top), bottom));
    tracer->whole = !(to < 1);
}

static void trace_to(struct tracer *tracer, const struct spot *spot)
{
    if (spot->x != tracer->x || spot->y != tracer->y)
        trace_line(tracer, spot->x, spot->y);
}

static void leave_column(struct tracer *tracer)
{
    bool fell = tracer->high.i < tracer->low.i;
    if (!tracer->samples)
        return;
    trace_to(tracer, fell ? &tracer->high : &tracer->low);
    trace_to(tracer, fell ? &tracer->low : &tracer->high);
    trace_to(tracer, &tracer->last);
}

/* The pen leaves the paper. A sample between two gaps is a dot. */
static void lift(struct tracer *tracer)
{
    leave_column(tracer);
    if (tracer->samples == 1)
        trace_line(tracer, tracer->x, tracer->y);
    thin_end(&tracer->thinning);
    tracer->samples = 0;
    tracer->whole = false;
}

static void trace_curve(const struct curve *curve, const struct plot_area *area, double tolerance,
                        void (*put)(void *, double, double, bool), void *out)
{
    struct tracer tracer = {.area = area,
                            .thinning = {.tolerance = tolerance, .put = put, .out = out}};
    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        const struct spot spot = {plot_x(area, curve->x[i]), plot_y(area, curve->y[i]), i};
        const double column = floor(spot.x * COLUMNS);
        if (isnan(spot.x) || isnan(spot.y)) {
            lift(&tracer);
            continue;
        }
        if (tracer.samples && column == tracer.column) {
            tracer.low = spot.y > tracer.low.y ? spot : tracer.low;
            tracer.high = spot.y < tracer.high.y ? spot : tracer.high;
        } else {
            leave_column(&tracer);
            if (tracer.samples)
                trace_line(&tracer, spot.x, spot.y);
            tracer.x = spot.x;
            tracer.y = spot.y;
            tracer.column = column;
            tracer.low = tracer.high = spot;
        }
        tracer.last = spot;
        tracer.samples++;
    }
    lift(&tracer);
}

/* ---- lines ---- */

/* Follows a line; draws what is new of it, until there are too many corners. */
struct follower {
    struct path *path;
    struct grains *grains;
    size_t most;
    double width;         /* of the pen, where all of it is inked */
    double at[2];         /* the pen */
    double end[2];        /* of what was drawn */
    bool begun, full;     /* something was drawn since the pen was put down; too much */
    double until;         /* [pt] of the way: up to here it was not */
    double drawn, enough; /* [pt] of lines; so many fill the plot */
};

static void follow(void *out, double x, double y, bool begins)
{
    struct follower *f = out;
    const double x0 = f->at[0], y0 = f->at[1];
    f->at[0] = x;
    f->at[1] = y;
    if (begins) {
        f->begun = false;
        return;
    }
    f->path->length += hypot(x - x0, y - y0);
    if (f->full || !grains_pass(f->grains, x0, y0, x, y))
        return;
    /* What was left out cannot be seen, or is a short part that goes on, or was drawn as part of
     * another turn. */
    const double skipped =
        f->begun ? (fabs(x0 - f->end[0]) + fabs(y0 - f->end[1])) * f->grains->density : INFINITY;
    if (skipped > 0)
        path_put(f->path, x0, y0, skipped > 5);
    path_put(f->path, x, y, false);
    f->begun = true;
    f->end[0] = x;
    f->end[1] = y;
    f->drawn += hypot(x - x0, y - y0);
    f->full = path_count(f->path) > f->most || f->drawn > f->enough;
    f->until = f->path->length;
}

static void ink(void *out, double x, double y, bool begins)
{
    struct follower *f = out;
    grains_stroke(f->grains, begins ? x : f->at[0], begins ? y : f->at[1], x, y, f->width);
    f->at[0] = x;
    f->at[1] = y;
}

/* ---- regions ---- */

/* What is tried until the outlines are short enough; the first FINE do not displace ink. */
#define FINE 3
static const struct {
    int density;
    double hole;  /* [pt^2] */
    double width; /* [grain] of the pen, at least */
} ways[] = {{8, 0, 0}, {8, 0.5, 0}, {8, 2, 0}, {4, 2, 1.5}, {2, 8, 1.5}, {1, 30, 1.5}, {1, 30, 3}};

typedef void draw_ink(const struct curve *, struct follower *, const struct plot_area *);

/* Draws all ink into grains, and outlines it, by the ways from..to. False: no memory. */
static bool outline(const struct curve *curve, const struct plot_area *area, const struct pen *pen,
                    draw_ink *draw, const size_t range[2], struct arena *arena, struct path *path)
{
    struct grains grains = {0}, scratch = {0};
    /* Much ink: coarser, that it may not take long. */
    const int finest = path->length < 1e7 ? DENSITY : path->length < 4e7 ? DENSITY / 2 : 2;
    double inked = -1; /* [pt] with this pen */
    for (size_t i = range[0]; i < range[1]; i++) {
        const int density = ways[i].density;
        const double width = fmax(pen->width, ways[i].width / density);
        if (density > finest)
            continue;
        if (cancelled(curve->cancel))
            return false;
        if (density != grains.density || width != inked) {
            struct follower f = {.grains = &grains, .width = width};
            if (!grains_init(&grains, area, density, arena) ||
                !grains_init(&scratch, area, density, arena))
                return false;
            draw(curve, &f, area);
            inked = width;
        }
        buffer_clear(&path->corners);
        grains_clear(&scratch);
        if (grains_outline(&grains, &scratch, 0.6 / density, ways[i].hole,
                           i + 1 < COUNT_OF(ways) ? pen->most : SIZE_MAX, path))
            break;
    }
    path->region = true;
    return true;
}

static void draw_line(const struct curve *curve, struct follower *f, const struct plot_area *area)
{
    trace_curve(curve, area, STRAIGHT, ink, f);
}

/* As a line. Returns which part of it could be drawn with so many corners: 1: all. */
static double single_line(const struct curve *curve, const struct plot_area *area,
                          const struct pen *pen, double tolerance, struct grains *grains,
                          struct path *path)
{
    const double size = (area->right - area->left) * (area->bottom - area->top);
    struct follower f = {.path = path,
                         .grains = grains,
                         .most = pen->rough ? SIZE_MAX : pen->most,
                         .enough = pen->rough ? HUGE_VAL : 2 * size / pen->width};
    grains_clear(grains);
    buffer_clear(&path->corners);
    path->length = 0;
    path->region = false;
    trace_curve(curve, area, tolerance, follow, &f);
    return !f.full ? 1 : path->length > 0 ? f.until / path->length * (1 - 1e-9) : 0;
}

/* Instead of a line of many corners the region, where it has half as many. */
static bool shorten(const struct curve *curve, const struct plot_area *area, double width,
                    struct arena *arena, struct path *path)
{
    struct path region = {.length = path->length};
    const struct pen half = {.width = width, .most = path_count(path) / 2};
    if (!outline(curve, area, &half, draw_line, (size_t[]){0, 1}, arena, &region)) {
        path_free(&region);
        return false;
    }
    if (region.region && path_count(&region) <= half.most) {
        path_free(path);
        *path = region;
    } else {
        path_free(&region);
    }
    return true;
}

bool path_of_line(const struct curve *curve, const struct plot_area *area, const struct pen *pen,
                  struct path *path)
{
    static const size_t fine[2] = {0, FINE}, rest[2] = {FINE, COUNT_OF(ways)};
    struct grains grains = {.wide = !pen->rough};
    struct arena arena = {0};
    bool ok = grains_init(&grains, area, pen->rough ? ROUGH : WAY, &arena);
    if (ok && pen->rough) {
        single_line(curve, area, pen, 0.5 / ROUGH, &grains, path);
    } else if (ok) {
        double part = single_line(curve, area, pen, STRAIGHT, &grains, path);
        if (part < 1 && part > 0.5) /* corners go with the root of the tolerance */
            part = single_line(curve, area, pen, 2 * STRAIGHT, &grains, path);
        if (part == 1)
            ok = path_count(path) < LONG || shorten(curve, area, pen->width, &arena, path);
        else
            ok = outline(curve, area, pen, draw_line, fine, &arena, path);
        if (ok && path_count(path) > pen->most &&
            single_line(curve, area, pen, 4 * STRAIGHT, &grains, path) < 1)
            ok = outline(curve, area, pen, draw_line, rest, &arena, path);
    }
    arena_reset(&arena);
    return ok && !path->corners.failed;
}

/* ---- dots ---- */

static bool dot_at(const struct curve *curve, const struct plot_area *area, size_t i,
                   double place[2])
{
    const double edge = 1e-6; /* of rounding */
    place[0] = plot_x(area, curve->x[i]);
    place[1] = plot_y(area, curve->y[i]);
    return place[0] >= area->left - edge && place[0] <= area->right + edge &&
           place[1] >= area->top - edge && place[1] <= area->bottom + edge;
}

static void draw_dots(const struct curve *curve, struct follower *f, const struct plot_area *area)
{
    double at[2];
    for (size_t i = 0; curve_goes_on(curve, i); i++)
        if (dot_at(curve, area, i, at))
            grains_stroke(f->grains, at[0], at[1], at[0], at[1], f->width);
}

/* One dot in each square of this size that has any, up to `most`. */
static bool single_dots(const struct curve *curve, const struct plot_area *area, double square,
                        size_t most, struct arena *arena, struct path *path)
{
    struct grains grains = {0};
    double at[2];
    if (!grains_init(&grains, area, square > 1 ? 1 : (int)(1 / square), arena))
        return false;
    buffer_clear(&path->corners);
    for (size_t i = 0; curve_goes_on(curve, i) && path_count(path) <= most; i++) {
        if (!dot_at(curve, area, i, at))
            continue;
        const double x = area->left + floor((at[0] - area->left) / square) * square,
                     y = area->top + floor((at[1] - area->top) / square) * square;
        if (grains_pass(&grains, x, y, x, y))
            path_put(path, at[0], at[1], true);
    }
    path->region = false;
    return true;
}

bool path_of_dots(const struct curve *curve, const struct plot_area *area, const struct pen *pen,
                  struct path *path)
{
    static const size_t fine[2] = {0, FINE};
    static const double squares[] = {1.0 / DENSITY, 0, 1, 2, 3, 4};
    const size_t most = (size_t)((double)pen->most / A_DOT);
    struct arena arena = {0};
    bool ok = true;
    if (pen->rough)
        ok = single_dots(curve, area, 1, SIZE_MAX, &arena, path);
    for (size_t i = 0; i < COUNT_OF(squares) && ok && !pen->rough; i++) {
        const bool last = i + 1 == COUNT_OF(squares), ink = squares[i] == 0;
        ok = ink ? outline(curve, area, pen, draw_dots, fine, &arena, path)
                 : single_dots(curve, area, squares[i], last ? SIZE_MAX : most, &arena, path);
        if (path_count(path) <= (ink ? pen->most : most))
            break;
    }
    arena_reset(&arena);
    return ok && !path->corners.failed;
}

bool path_meets(const struct path *path, double left, double top, double right, double bottom)
{
    const struct corner *corner = path_corners(path);
    const double x = (left + right) / 2, y = (top + bottom) / 2;
    const size_t n = path_count(path);
    size_t first = 0;
    bool within = false;
    for (size_t i = 0; i < n; i++) {
        const bool last = i + 1 == n || corner[i + 1].begins;
        first = corner[i].begins ? i : first;
        const struct corner *a = &corner[i], *b = &corner[!last ? i + 1 : path->region ? first : i];
        double from = 0, to = 1;
        cut(a->x, b->x - a->x, left, right, &from, &to);
        cut(a->y, b->y - a->y, top, bottom, &from, &to);
        if (from <= to)
            return true;
        if ((a->y > y) != (b->y > y) && x < a->x + (y - a->y) / (b->y - a->y) * (b->x - a->x))
            within = !within;
    }
    return within && path->region;
}
