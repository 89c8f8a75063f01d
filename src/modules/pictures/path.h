/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * figure: from samples to what a pen draws, in points of a page, with a bounded number of corners.
 *
 * Samples that follow each other in a column are replaced by the first, the last and the extremes;
 * what passes only where the curve has been already is left out. A curve that has too many corners
 * all the same is drawn by a wider pen on a coarser grid.
 */
#pragma once

#include <hooke/figure/layout.h>

/* [pt] the plot on the page, and the scales along its sides. */
struct plot_area {
    const struct scale *x, *y;
    double left, top, right, bottom;
};

static inline double plot_x(const struct plot_area *area, double x)
{
    return area->left + fraction_of(area->x, x) * (area->right - area->left);
}

static inline double plot_y(const struct plot_area *area, double y)
{
    return area->bottom - fraction_of(area->y, y) * (area->bottom - area->top);
}

struct corner {
    double x, y; /* [pt] */
    bool begins; /* the pen is put down here */
};

struct path {
    struct buffer corners; /* struct corner each */
    double length;         /* [pt] of the line, with the parts that are left out */
    double width;          /* [pt] of a pen that covers what the coarser grid left out, or 0 */
};

static inline size_t path_count(const struct path *path)
{
    return path->corners.len / sizeof(struct corner);
}

static inline const struct corner *path_corners(const struct path *path)
{
    return (const struct corner *)(const void *)path->corners.data;
}

void path_free(struct path *path);

/* [pt] lines continue behind the frame, where they are cut off */
#define PLOT_MARGIN 3.0

/* ---- curves ---- */

struct path_limit {
    size_t corners; /* largest number of corners, where the coarsest grid allows it */
    bool rough;     /* accurate to a point, to see which ink the curve meets */
};

/*
 * Finds the path of a curve; NAN is a gap, a sample between two gaps is a dot. On the finest grid
 * no sample is farther than 0.3 px (0.225 pt) from the path and no corner from the line through the
 * samples; on a coarser one no sample is farther than path->width. Returns false if out of memory
 * or if the curve is cancelled.
 */
bool path_of_line(const struct curve *curve, const struct plot_area *area,
                  const struct path_limit *limit, struct path *path);
/* Finds a path of corners that begin, a dot each; those of one place are one. If there are too
 * many, there is one in each square of 1 to 4 pt. */
bool path_of_dots(const struct curve *curve, const struct plot_area *area,
                  const struct path_limit *limit, struct path *path);

/* Returns true if the path passes through a rectangle. */
bool path_meets(const struct path *path, double left, double top, double right, double bottom);
