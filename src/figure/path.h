/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * figure: from samples to what a pen draws, in points of a page, with a bounded number of corners.
 *
 * A curve of few turns is a line. One that fills the plot is the region that the pen would cover,
 * as closed outlines: an envelope of a thousand periods has two edges, however many samples.
 */
#ifndef HOOKE_FIGURE_PATH_H
#define HOOKE_FIGURE_PATH_H

#include "figure/internal.h"

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
    double length;         /* [pt] of the line, with what is not drawn twice */
    bool region;           /* closed outlines, to be filled: holes run the other way round */
};

static inline size_t path_count(const struct path *path)
{
    return path->corners.len / sizeof(struct corner);
}

static inline const struct corner *path_corners(const struct path *path)
{
    return (const struct corner *)(const void *)path->corners.data;
}

void path_put(struct path *path, double x, double y, bool begins);
void path_free(struct path *path);

/*
 * Leaves out the corners that lie within `tolerance` of the line without them: the directions from
 * the last corner kept that pass all points since then so closely are a cone; a point outside of it
 * makes the one before it a corner (Williams 1978, Sklansky and Gonzalez 1980). So does a way back.
 */
struct path_thinning {
    double tolerance;
    void (*put)(void *out, double x, double y, bool begins);
    void *out;
    double x, y;            /* the last corner kept */
    double at[2];           /* the last point */
    double low[2], high[2]; /* the cone's sides, if there is one */
    double farthest;        /* from the corner */
    bool down, moved, cone;
};

void thin_begin(struct path_thinning *thinning, double x, double y);
void thin_to(struct path_thinning *thinning, double x, double y);
void thin_end(struct path_thinning *thinning);

/* ---- grains: what ink covers, as bits ---- */

struct grains {
    uint8_t *bit;     /* with a blank border of one grain */
    int across, down; /* with it */
    int bytes;        /* of a row */
    int density;      /* along a point */
    bool wide;        /* what passes inks the grains beside, too */
    double left, top; /* [pt] of the area, with its margin */
};

/* [pt] lines go on behind the frame, where they are cut off */
#define PLOT_MARGIN 3.0

bool grains_init(struct grains *grains, const struct plot_area *area, int density,
                 struct arena *arena);
void grains_clear(struct grains *grains);
/* Whether a line passes where there was no ink; then there is. */
bool grains_pass(struct grains *grains, double x0, double y0, double x1, double y1);
/* The ink of a round pen of this width that comes from (x0, y0), where it was put down before. */
void grains_stroke(struct grains *grains, double x0, double y0, double x1, double y1, double width);
/* Adds the outlines of the ink, within `tolerance` [pt]; holes smaller than `hole` [pt^2] are
 * filled. No more than `most` corners: false if it has more. */
bool grains_outline(const struct grains *grains, struct grains *scratch, double tolerance,
                    double hole, size_t most, struct path *path);

/* ---- curves ---- */

struct pen {
    double width; /* [pt] */
    size_t most;  /* corners */
    bool rough;   /* within a point: only to see what the ink meets */
};

/*
 * The path of a curve; NAN is a gap, a sample between two is a dot. No sample is farther than
 * 0.3 px (0.225 pt) from the ink, and no corner from the samples' line. Of a curve that has more
 * than pen->most corners then, as a line and as a region, straight parts may be 0.4 px off; after
 * that small holes are filled, and grains are coarser. False without memory.
 */
bool path_of_line(const struct curve *curve, const struct plot_area *area, const struct pen *pen,
                  struct path *path);
/* Dots as corners that begin, those of one place as one; many as a region likewise. Of so many that
 * lie apart that neither is short enough, one in each square of 1 to 4 pt. */
bool path_of_dots(const struct curve *curve, const struct plot_area *area, const struct pen *pen,
                  struct path *path);

/* Whether ink of the path lies in a rectangle. */
bool path_meets(const struct path *path, double left, double top, double right, double bottom);

#endif
