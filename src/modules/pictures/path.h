/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Converts the samples of a curve to a path that a pen draws, in points of the page, with a bounded
 * number of corners: path_of_line() or path_of_dots(), then path_corners(), then path_free().
 * Samples that follow each other in a column are replaced by the first, the last and the extremes;
 * parts that pass only where the curve has been already are left out. A curve that has too many
 * corners all the same is drawn by a wider pen on a coarser grid. */
#pragma once

#include <hooke/figure/layout.h>

/* Rectangle of the plot on the page [pt], and the scales along its sides. */
struct plot_area {
    const struct scale *x, *y;
    double left, top, right, bottom;
};

/* Returns the position on the page [pt] of a value of x. */
static inline double plot_x(const struct plot_area *area, double x)
{
    return area->left + fraction_of(area->x, x) * (area->right - area->left);
}

/* Returns the position on the page [pt] of a value of y; y of the page grows downwards. */
static inline double plot_y(const struct plot_area *area, double y)
{
    return area->bottom - fraction_of(area->y, y) * (area->bottom - area->top);
}

/* One corner of a path. */
struct corner {
    double x, y; /* [pt] */
    bool begins; /* the pen is put down here, so that no line leads to this corner */
};

struct path {
    struct buffer corners; /* array of struct corner, see path_corners() */
    double length;         /* [pt] length of the curve on the page, including omitted parts */
    double width; /* [pt] width of the pen that a coarser grid needs, or 0 if any will do */
};

/* Returns the number of corners. */
static inline size_t path_count(const struct path *path)
{
    return path->corners.len / sizeof(struct corner);
}

/* Returns the corners, which are valid until the path is freed. */
static inline const struct corner *path_corners(const struct path *path)
{
    return (const struct corner *)(const void *)path->corners.data;
}

void path_free(struct path *path);

/* [pt] Lines are computed this far beyond the frame, at which the surface clips them. */
#define PLOT_MARGIN 3.0

/* ---- curves ---- */

struct path_limit {
    size_t corners; /* largest number of corners, if the coarsest grid allows it */
    bool rough;     /* a path accurate to 1 pt is enough, to find what the curve would cover */
};

/*
 * Finds the path of a curve; NAN is a gap, a sample between two gaps is a dot. On the finest grid
 * no sample is farther than 0.3 px (0.225 pt) from the path and no corner from the line through the
 * samples; on a coarser one no sample is farther than path->width. Returns false if out of memory
 * or if the curve is cancelled.
 */
bool path_of_line(const struct curve *curve, const struct plot_area *area,
                  const struct path_limit *limit, struct path *path);
/* Finds a path of single corners, one for each dot inside the plot; dots closer than 1/8 pt become
 * one. If there are more than the limit, one dot is drawn in each square of 1 to 4 pt. Returns
 * false if out of memory or cancelled. */
bool path_of_dots(const struct curve *curve, const struct plot_area *area,
                  const struct path_limit *limit, struct path *path);

/* Returns true if the path passes through the rectangle [pt]. */
bool path_meets(const struct path *path, double left, double top, double right, double bottom);
