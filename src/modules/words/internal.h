/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readings of curves: what their files share. */
#pragma once

#include "modules/words/describe.h"
#include <hooke/base/cancel.h>

/* Largest backward movement that does not count as a turn: for a measured curve in standard
 * deviations, and for any curve relative to its swing. */
#define TURN_SIGMAS 8.0
#define TURN_ROUNDING 1e-9

/* The points of a curve that have a place, by ascending x but for those of a plane. */
struct points {
    const double *x, *y; /* [n] those of the curve where all of them are read, or copies */
    size_t n;
    double noise;  /* standard deviation of measured y, or 0 for a line */
    bool measured; /* samples may be missing */
    const struct cancel *cancel;
};

static inline struct curve_point point_at(const struct points *points, size_t i)
{
    return (struct curve_point){points->x[i], points->y[i]};
}

/* As curve_goes_on(). */
static inline bool points_go_on(const struct points *points, size_t i)
{
    return i < points->n && (i % LOOK_EACH_ROWS != 0 || !cancelled(points->cancel));
}

/* Leaves out single samples far off their neighbours; returns false if out of memory. */
bool drop_echoes(struct points *points, struct arena *arena);
/* Turns, crossings, period, amplitudes; over something else than time no crossings. */
bool read_turns(const struct points *points, bool timed, struct arena *arena,
                struct curve_reading *reading);
/* Write a number as the axes show it, with their factor and unit. A value that is negligible
 * beside `range`, that of the axis, counts as 0; range may be NULL. */
void figure_number(double value, struct buffer *output); /* four digits */
void figure_value(const struct axis *axis, double value, const double *range,
                  struct buffer *output);
/* Finds the centre, the number of turns and the distances from the centre. Directions are
 * measured in halves of the range of the curve, or in the same unit if `equal` is set. */
void read_winding(const struct points *points, bool equal, struct curve_reading *reading);

/* As a charset: the description and a table; as many whole sentences as there is room for.
 */
bool words_print(const struct figure *figure, int width, struct buffer *output);
/* Writes the description of a heat map, without a table. */
bool words_heat(const struct heat *heat, int width, struct buffer *output);
bool words_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                int height);
