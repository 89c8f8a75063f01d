/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures as SVG, PDF and PNG files: figure_picture() is the entry of the module. */
#pragma once

#include <hooke/figure.h>

/* Kinds of pictures. PICTURE_PIXELS is not a file format: rows of 32-bit words 0x00RRGGBB in the
 * byte order of the machine, from the top. */
enum picture { PICTURE_SVG, PICTURE_PDF, PICTURE_PNG, PICTURE_PIXELS };
/* Pixels per point, horizontally and vertically, in a PNG and in PICTURE_PIXELS. */
#define PICTURE_PIXELS_EACH 2

#define PICTURE_WIDTH 640 /* [pt] 1/72 inch: with the height below about A5 */
#define PICTURE_HEIGHT 400

/*
 * Appends the figure as a picture file of width x height points (0 stands for the sizes above),
 * with the ranges, ticks, units and legend that figure_draw would choose for that room. Curves
 * differ by dashes and marks as well as by colour. The legend is placed where it covers nothing.
 * Long curves are reduced to what can be seen, within 0.3 px, so that the SVG of a curve is at most
 * 200 kB. The same figure gives the same picture. Draws through cairo, which is loaded on demand;
 * fails with ERROR_COMMAND if it is not installed. If this returns false, `output` must not be
 * used.
 */
bool figure_picture(const struct figure *figure, enum picture kind, double width, double height,
                    struct buffer *output, struct error *error);
/* Returns true if this build can draw it; otherwise sets *error. */
bool picture_offered(enum picture kind, struct error *error);
