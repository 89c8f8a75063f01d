/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations that the files of src/figure share: ticks and ranges of axes, and the raster that
 * draws curves into the cells of a plot. figure_layout() chooses ranges and ticks first, then the
 * raster functions draw in its coordinates. */
#pragma once

#include <hooke/figure/layout.h>

/* Finds the best ticks for a range: about `want` and at most `max` labels. If `loose`, the first
 * and the last tick may lie outside of the range, else all lie inside. The result has count 0 if
 * the range is empty or too narrow for doubles. */
struct ticks ticks_search(double range_begin, double range_end, int want, int max, bool loose);

/* Ranges are limited to this magnitude, so that differences of their ends stay finite. */
#define RANGE_VALUE_MAX 1e300

/* Returns the range that an axis shows: the fixed one, or the extent of the curves with a margin,
 * widened to the next tick if that is near (`want` and `max` as in ticks_search()). */
struct scale axis_scale(const struct figure *figure, bool vertical, struct extent extent, int want,
                        int max);

/* Returns the column of the plot in which tick i of the x axis is. */
int x_tick_column(const struct figure *figure, const struct figure_layout *layout, int i);
/* Returns the column of the plot at which a label of len cells begins, centred on the tick's column
 * but kept inside the frame. It may be negative, left of the plot. */
int x_label_start(const struct figure_layout *layout, int column, int len);

/* Target of the functions below, which draw curves into the cells of a plot. */
struct raster {
    struct canvas *canvas;
    const struct figure_layout *layout;
    int x, y; /* [cell] upper left corner of the plot on the canvas */
    enum style style;
    char mark;     /* character that draws the curve, or 0 for a line of dots */
    uint32_t fill; /* character that fills a band */
};

/* Draws the curve as a line that is interrupted at NAN, or its points as single dots if it is a
 * cloud. */
void raster_line(const struct raster *raster, const struct curve *curve);
/* Draws a guide: a line of dots, or a rectangle filled with raster->fill. */
void raster_guide(const struct raster *raster, const struct figure_guide *guide);
/* Draws each arrow of the curve (tail, tip, NAN) as one arrow character in the middle between its
 * ends, chosen by its direction on the screen. */
void raster_arrows(const struct raster *raster, const struct curve *curve);
/* Fills the cells of the curve's band, y - spread to y + spread, and leaves out columns in which it
 * is thinner than a dot. */
void raster_band(const struct raster *raster, const struct curve *curve);
/* Draws the raster's mark at the points of a curve, but leaves out marks nearer than `apart`
 * columns to the previous mark, so that what lies under them stays visible. */
void raster_points(const struct raster *raster, const struct curve *curve, int apart);
/* Draws an arrow on each border of the plot at the position where the curve first leaves through
 * it. */
void raster_exits(const struct raster *raster, const struct figure *figure, int curve);
/* Draws the shades or letters of a map into all cells of the plot that it covers. */
void raster_heat(const struct raster *raster, const struct heat *heat);
/* Writes a character into a cell of the plot, in the raster's style; cells outside of the plot are
 * ignored. */
void raster_put(const struct raster *raster, int column, int row, uint32_t codepoint);
