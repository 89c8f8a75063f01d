/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The style sheet of pictures. Every length, line width and colour that is drawn is defined here;
 * drawing code has none of its own. */
#pragma once

#include <stddef.h>

/* X(name, length [pt] at scale 1, meaning) */
#define STYLE_LENGTHS(X)                                                                           \
    X(font, 10, "text")                                                                            \
    X(title, 12, "the title")                                                                      \
    X(digit, 6.4, "width of a digit: ticks are chosen as for cells of this size")                  \
    X(row, 12, "height of such a cell")                                                            \
    X(leading, 14, "from one line of text to the next")                                            \
    X(edge, 8, "blank around everything")                                                          \
    X(panel_gap, 10, "blank between two panels")                                                   \
    X(tick, 4, "outwards from the frame")                                                          \
    X(minor_tick, 2, "likewise, without a label")                                                  \
    X(tick_gap, 3, "from a tick to its label")                                                     \
    X(frame_line, 0.8, "frame and ticks")                                                          \
    X(grid_line, 0.5, "grid")                                                                      \
    X(zero_line, 0.6, "where the value is 0")                                                      \
    X(curve_line, 1.2, "a curve")                                                                  \
    X(thin_line, 0.6, "a curve of very many turns")                                                \
    X(mark, 2.6, "radius of a mark")                                                               \
    X(mark_line, 0.9, "outline of a mark")                                                         \
    X(cap, 2, "half the width of the end of an error bar")                                         \
    X(mark_apart, 12, "from one mark on a line to the next, at least")                             \
    X(dot, 2.2, "of dense data")                                                                   \
    X(dot_below, 3.4, "likewise, with a line above")                                               \
    X(sample, 30, "of a line in the legend")                                                       \
    X(mark_sample, 12, "of a mark in the legend")                                                  \
    X(sample_gap, 5, "from it to its name")                                                        \
    X(band_sample, 8, "height of a band in the legend")                                            \
    X(entry_gap, 16, "between entries of the legend")                                              \
    X(arrow, 9, "where a run leaves the frame: length")                                            \
    X(arrow_half, 4.5, "half its width")                                                           \
    X(dash, 1, "unit of dashes")

/* All lengths of a picture in points, scaled to the size of its page. */
struct picture_style {
#define LENGTH(name, value, brief) double name; /* [pt] */
    STYLE_LENGTHS(LENGTH)
#undef LENGTH
};

/*
 * The style for a page of this size [pt]. Text and lines grow with the square root of the page: 10
 * pt of text on one of 640 x 400 pt, 7.3 pt on 12 x 8 cm, never less than 6 pt.
 */
struct picture_style picture_style(double width, double height);

/* Colours as red, green and blue, each from 0 to 1. */
extern const double style_black[3], style_white[3], style_gray[3], style_grid[3];
/* Colours of curves, which colour-blind readers can distinguish. */
extern const double style_palette[][3];
extern const size_t style_palette_count;
/* Text that does not fit is reduced to no less than this part of its size. */
#define STYLE_SHRINK 0.7
#define STYLE_BAND 0.25 /* opacity of a band */

/* Dash pattern [dash]: ink and gaps between round ends, in turn. An empty one is a solid line. */
struct style_dashes {
    double length[4];
    int n;
};
extern const struct style_dashes style_dashes[];
extern const size_t style_dashes_count;
