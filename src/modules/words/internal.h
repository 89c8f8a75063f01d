/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readings of curves: what their files share. */
#pragma once

#include "modules/words/describe.h"
#include <hooke/base/cancel.h>

/* What a curve that was measured may go back by and does not turn [standard deviations], and any
 * curve [of its swing]. */
#define TURN_SIGMAS 8.0
#define TURN_ROUNDING 1e-9

/* The points of a curve that have a place, by ascending x but for those of a plane. */
struct points {
    const double *x, *y; /* [n] those of the curve where all of them are read, or copies */
    size_t n;
    double noise;  /* standard deviation of y, of what was measured; 0: a line */
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
/* As the axes show numbers: with their factor and unit. range: of the axis, beside which a value
 * may be nothing; NULL if there is none. */
void figure_number(double value, struct buffer *output); /* four digits */
void figure_value(const struct axis *axis, double value, const double *range,
                  struct buffer *output);
/* Around what, how often, how far from there. half: of what the curve spans, by which both
 * directions are measured; equal: by the same. */
void read_winding(const struct points *points, bool equal, struct curve_reading *reading);

/* As a charset: the description and a table; as many whole sentences as there is room for.
 */
bool words_print(const struct figure *figure, int width, struct buffer *output);
/* Without a table. */
bool words_heat(const struct heat *heat, int width, struct buffer *output);
bool words_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                int height);
