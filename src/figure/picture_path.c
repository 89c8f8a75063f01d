/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * From samples to the path of a curve.
 *
 * Of samples that follow each other in a column of a quarter of a point, the first, the last and
 * the extremes are kept (M4, as in raster.c). Then a part that passes only where the curve has been
 * already is left out, with grains of a quarter of a point, or of a whole one if it fills the plot.
 * So no peak is lost, a curve that is traced again and again costs nothing, and the size of a file
 * is bounded by the page rather than by the samples.
 */
#include "figure/picture.h"

#include <string.h>

#define MARGIN 3.0  /* [pt] lines go on behind the frame, where they are cut off */
#define LINES 30000 /* of a path that has still finer grains */
#define SNAP 8      /* parts of a point that ends of coarse lines are rounded to */

static int grains_along(double length, int grains)
{
    return (int)((length + 2 * MARGIN) * grains) + 1;
}

size_t page_ink_size(const struct page *page, int grains)
{
    return (size_t)grains_along(page->right - page->left, grains) *
               (size_t)grains_along(page->bottom - page->top, grains) / 8 +
           1;
}

void page_ink_clear(struct page *page, int grains)
{
    page->grains = grains;
    memset(page->ink, 0, page_ink_size(page, grains));
}

bool page_ink_line(const struct page *page, double x0, double y0, double x1, double y1)
{
    int columns = grains_along(page->right - page->left, page->grains);
    double x = (x0 - page->left + MARGIN) * page->grains,
           y = (y0 - page->top + MARGIN) * page->grains;
    double dx = (x1 - x0) * page->grains, dy = (y1 - y0) * page->grains;
    int steps = (int)ceil(fmax(fabs(dx), fabs(dy)));
    bool fresh = false;

    dx /= steps ? steps : 1;
    dy /= steps ? steps : 1;
    for (int i = 0; i <= steps; i++) {
        size_t index = (size_t)(y + i * dy) * (size_t)columns + (size_t)(x + i * dx);
        uint8_t bit = (uint8_t)(1U << index % 8);
        fresh |= !(page->ink[index / 8] & bit);
        page->ink[index / 8] |= bit;
    }
    return fresh;
}

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
    struct page *page;
    bool begun;                  /* a path goes up to `end` */
    size_t samples;              /* since the last gap */
    double column;               /* [grain] that the last samples are in */
    struct spot low, high, last; /* of them */
    double x, y;                 /* followed up to here */
    double end[2];
    long lines; /* drawn */
};

static void trace_line(struct tracer *tracer, double x, double y)
{
    const struct page *page = tracer->page;
    double x0 = tracer->x, y0 = tracer->y, from = 0, to = 1;

    cut(x0, x - x0, page->left - MARGIN, page->right + MARGIN, &from, &to);
    cut(y0, y - y0, page->top - MARGIN, page->bottom + MARGIN, &from, &to);
    if (from > to)
        return;
    double x1 = to < 1 ? x0 + to * (x - x0) : x, y1 = to < 1 ? y0 + to * (y - y0) : y;
    x0 += from * (x - x0);
    y0 += from * (y - y0);
    /* Of a line that is cut off far away rounding leaves more than the margin has. */
    x0 = fmin(fmax(x0, page->left - MARGIN), page->right + MARGIN);
    x1 = fmin(fmax(x1, page->left - MARGIN), page->right + MARGIN);
    y0 = fmin(fmax(y0, page->top - MARGIN), page->bottom + MARGIN);
    y1 = fmin(fmax(y1, page->top - MARGIN), page->bottom + MARGIN);
    if (!page_ink_line(page, x0, y0, x1, y1))
        return;
    if (page->grains < GRAINS) { /* shorter numbers, too */
        x1 = floor(x1 * SNAP + 0.5) / SNAP;
        y1 = floor(y1 * SNAP + 0.5) / SNAP;
    }
    /* What was left out cannot be seen, or is a short part that goes on, or was drawn as part of
     * another turn. */
    double skipped = tracer->begun
                         ? (fabs(x0 - tracer->end[0]) + fabs(y0 - tracer->end[1])) * page->grains
                         : INFINITY;
    if (skipped > 5)
        surface_move(page->surface, x0, y0);
    else if (skipped > 1.5)
        surface_line(page->surface, x0, y0);
    surface_line(page->surface, x1, y1);
    tracer->lines++;
    tracer->begun = true;
    tracer->end[0] = x1;
    tracer->end[1] = y1;
}

static void trace_to(struct tracer *tracer, const struct spot *spot)
{
    if (spot->x != tracer->x || spot->y != tracer->y)
        trace_line(tracer, spot->x, spot->y);
    tracer->x = spot->x;
    tracer->y = spot->y;
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
    tracer->begun = false;
    tracer->samples = 0;
}

static long trace_curve(struct page *page, const struct curve *curve, int grains)
{
    struct tracer tracer = {.page = page};

    surface_new_path(page->surface);
    page_ink_clear(page, grains);
    for (size_t i = 0; i < curve->n; i++) {
        struct spot spot = {page_x(page, curve->x[i]), page_y(page, curve->y[i]), i};
        double column = floor(spot.x * grains);
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
    return tracer.lines;
}

void page_path(struct page *page, const struct curve *curve)
{
    for (int grains = GRAINS; trace_curve(page, curve, grains) > LINES && grains > 1;)
        grains /= 2;
}
