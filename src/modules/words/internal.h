/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the files of the module words share. */
#pragma once

#include "modules/words/describe.h"
#include <hooke/base/cancel.h>

/* Largest backward movement that does not count as a turning point, for a measured curve in
 * standard deviations of the noise, and for any curve relative to its range. */
#define TURN_SIGMAS 8.0
#define TURN_ROUNDING 1e-9

/* The points of a curve that can be drawn, by ascending x except in a plane. */
struct points {
    const double *x, *y; /* [n] the curve's own values if all of them are used, or copies */
    size_t n;
    double noise;  /* standard deviation of measured y, or 0 for a line */
    bool measured; /* samples may be missing */
    const struct cancel *cancel;
};

/* Returns point i. */
static inline struct curve_point point_at(const struct points *points, size_t i)
{
    return (struct curve_point){points->x[i], points->y[i]};
}

/* Returns true while i is an index of a point and nobody cancels; for loops. */
static inline bool points_go_on(const struct points *points, size_t i)
{
    return i < points->n && (i % LOOK_EACH_ROWS != 0 || !cancelled(points->cancel));
}

/* Removes single samples that are far from their neighbours, unless there are many. Returns false
 * if out of memory. */
bool drop_echoes(struct points *points, struct arena *arena);
/* Finds turning points, crossings, period and amplitudes. Only turning points if x is not time
 * (`timed`). Returns false if out of memory. */
bool read_turns(const struct points *points, bool timed, struct arena *arena,
                struct curve_reading *reading);
/* Appends a number with four digits. */
void figure_number(double value, struct buffer *output); /* four digits */
/* Appends a value as the axis shows it, with its factor and unit. A value that is negligible
 * relative to `range`, that of the axis, counts as 0; range may be NULL. */
void figure_value(const struct axis *axis, double value, const double *range,
                  struct buffer *output);
/* Finds how often a curve in a plane winds around its centre, and sets course to COURSE_WINDS if it
 * does. Directions are measured in halves of the ranges of the curve, or in the same unit if
 * `equal` is set. */
void read_winding(const struct points *points, bool equal, struct curve_reading *reading);

/* Prints a figure as a description and a table, in lines of `width` [cells]. Returns false if out
 * of memory or cancelled. */
bool words_print(const struct figure *figure, int width, struct buffer *output);
/* Prints a heat map as a description. Returns false if out of memory. */
bool words_heat(const struct heat *heat, int width, struct buffer *output);
/* Draws as many whole sentences of the description as a rectangle of cells holds. Returns false if
 * out of memory or cancelled. */
bool words_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                int height);
