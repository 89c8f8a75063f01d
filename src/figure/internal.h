/* SPDX-License-Identifier: GPL-3.0-or-later */
/* figure: what its files share. */
#pragma once

#include <hooke/figure/layout.h>

/* The best ticks for [from, to]; when `loose`, the outermost may lie beyond it. */
struct ticks ticks_search(double range_begin, double range_end, int want, int max, bool loose);

#define RANGE_VALUE_MAX 1e300 /* Ranges end here, so that differences stay finite. */

/* The range an axis shows: fixed, or the extent with some air, widened to about `want` ticks. */
struct scale axis_scale(const struct figure *figure, bool vertical, struct extent extent, int want,
                        int max);

/* Returns the column of a tick in the plot; the label may begin left of it. */
int x_tick_column(const struct figure *figure, const struct figure_layout *layout, int i);
int x_label_start(const struct figure_layout *layout, int column, int len);

/* Draws curves into the plot of a canvas. */
struct raster {
    struct canvas *canvas;
    const struct figure_layout *layout;
    int x, y; /* origin of the plot on the canvas */
    enum style style;
    char mark;     /* 0 draws a line of dots */
    uint32_t fill; /* character that fills a band */
};

void raster_line(const struct raster *raster, const struct curve *curve);
/* A line of dots, or a filled area. */
void raster_guide(const struct raster *raster, const struct figure_guide *guide);
/* Arrows of one cell, by their directions on the paper. */
void raster_arrows(const struct raster *raster, const struct curve *curve);
/* Fills the cells of the curve's band; where it is thinner than a dot there is only the line. */
void raster_band(const struct raster *raster, const struct curve *curve);
/* Marks no nearer to each other than `apart` columns along the curve, so that what lies under them
 * stays visible. */
void raster_points(const struct raster *raster, const struct curve *curve, int apart);
/* An arrow where the curve first leaves, each side. */
void raster_exits(const struct raster *raster, const struct figure *figure, int curve);
void raster_put(const struct raster *raster, int column, int row, uint32_t codepoint);
