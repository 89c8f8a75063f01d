/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes the paths of a picture's curves and error bars, few enough corners for a small file. */
#include "modules/pictures/picture.h"

#include <string.h>

#define PATH_CORNERS_MAX 18000 /* most corners of all curves; each takes 10 bytes of an SVG */
#define PATH_CORNERS_MIN 1000  /* most corners of a curve if there are very many curves */

double page_dot(const struct page *page)
{
    for (int i = 0; i < page->figure->curves; i++)
        if (!page->figure->curve[i].points)
            return page->style.dot_below;
    return page->style.dot;
}

/* Makes the curve *bars of vertical lines, with gaps between them, from a curve's error bars. Bars
 * on a logarithmic axis that reach 0 begin at the lower end of the axis. Returns false if out of
 * memory. */
static bool bar_curve(const struct page *page, const struct curve *curve, struct arena *arena,
                      struct curve *bars)
{
    const bool log = page->figure->y.log;
    double *x = arena_array(arena, 3 * curve->n + 1, sizeof *x),
           *y = arena_array(arena, 3 * curve->n + 1, sizeof *y);
    if (!x || !y)
        return false;
    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        const double low = curve->y[i] - curve->bar[i];
        x[3 * i] = x[3 * i + 1] = x[3 * i + 2] = curve->x[i];
        y[3 * i] = log && low <= 0 ? page->layout.y.first_value : low;
        y[3 * i + 1] = curve->y[i] + curve->bar[i];
        y[3 * i + 2] = NAN;
    }
    *bars = (struct curve){.x = x, .y = y, .n = 3 * curve->n, .cancel = curve->cancel};
    return true;
}

/* Computes the path of a curve, and that of its error bars, with up to `corners` corners each; 0
 * means rough paths. Returns false if out of memory or cancelled. */
static bool trace_curve_paths(const struct page *page, int index, size_t corners)
{
    const struct curve *curve = &page->figure->curve[index];
    const struct plot_area area = page_area(page);
    const struct path_limit limit = {
        .corners = corners < PATH_CORNERS_MIN ? PATH_CORNERS_MIN : corners, .rough = corners == 0};
    struct path *path = &page->path[index], *bar = path + page->figure->curves;
    struct arena arena = {0};
    struct curve bars;
    path_free(path);
    path_free(bar);
    *path = *bar = (struct path){0};
    const bool dots = curve->points && !curve->joined;
    bool ok = (dots ? path_of_dots : path_of_line)(curve, &area, &limit, path);
    if (ok && curve->bar)
        ok = bar_curve(page, curve, &arena, &bars) && path_of_line(&bars, &area, &limit, bar);
    arena_reset(&arena);
    return ok && !cancelled(curve->cancel);
}

/* Computes the paths of all drawn curves, rough ones if `rough`. Curves are computed again with
 * fewer corners if all together have more than PATH_CORNERS_MAX. Returns false if out of memory or
 * cancelled. */
bool page_trace(struct page *page, bool rough, struct arena *arena)
{
    const struct figure *figure = page->figure;
    const size_t n = 2 * (size_t)figure->curves, most = PATH_CORNERS_MAX / (n / 2 + 1);
    size_t corners = 0;
    bool ok = true;
    page->path = arena_array(arena, n + 1, sizeof *page->path);
    if (!page->path)
        return false;
    memset(page->path, 0, (n + 1) * sizeof *page->path);
    for (int i = 0; i < figure->curves && ok; i++)
        ok = !curve_drawn(figure, i) || trace_curve_paths(page, i, rough ? 0 : PATH_CORNERS_MAX);
    for (size_t i = 0; i < n && !rough; i++)
        corners += path_count(&page->path[i]);
    for (int i = 0; i < figure->curves && ok && corners > PATH_CORNERS_MAX; i++)
        ok = (path_count(&page->path[i]) <= most &&
              path_count(&page->path[figure->curves + i]) <= most) ||
             trace_curve_paths(page, i, most);
    return ok;
}

void page_free_paths(struct page *page)
{
    for (int i = 0; i < 2 * page->figure->curves && page->path; i++)
        path_free(&page->path[i]);
}
