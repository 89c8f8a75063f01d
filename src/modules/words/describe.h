/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Describes a figure in numbers (figure_read()) and sentences (describe_reading(), or
 * describe_figure() for both), for readers who cannot see it, as the text of a picture in a
 * document, and for tests. The numbers are computed from the curves that are drawn. */
#pragma once

#include <hooke/figure.h>

/* The overall behaviour of a curve. */
enum course {
    COURSE_NONE,       /* fewer than two points, or values whose squares overflow */
    COURSE_CONSTANT,   /* all values are equal but for rounding */
    COURSE_SCATTERS,   /* noise around a level */
    COURSE_RISES,      /* rises without a turning point */
    COURSE_FALLS,      /* falls without a turning point */
    COURSE_TURNS,      /* moves up and down without a period */
    COURSE_OSCILLATES, /* oscillates over time */
    COURSE_WINDS       /* winds around a centre in a plane */
};

/* A point in the coordinates of the curve. */
struct curve_point {
    double x, y;
};

/* Description of a curve in its own values; axes show them divided by their factor. NAN marks
 * numbers that do not apply. */
struct curve_reading {
    const char *label;             /* label of the curve, or its mark; never NULL */
    size_t n, gaps;                /* numbers of points that can be drawn, and that cannot */
    struct curve_point start, end; /* first and last point */
    struct curve_point low, high;  /* least and largest y */
    enum course course;
    /* The following are for a curve that rises or falls. */
    bool all_along; /* it never goes back by more than noise or rounding */
    double factor;  /* end / start, if both have the same sign */
    double rate;    /* d ln|y| / dx by least squares, if deviations from the line are below 5 % */
    double power;   /* d ln y / d ln x in the same way, if both axes are logarithmic */
    /* The following are for a curve with turning points. */
    size_t turns;     /* number of turning points, at which it is highest or lowest */
    size_t crossings; /* number of crossings of the middle between turning points */
    /* Ends of the longest interval of x without samples in a curve with periods, or NAN. */
    double hole[2];
    size_t periods; /* number of averaged periods, between crossings of the same direction */
    double period;  /* length of one period, or NAN if irregular */
    double spread;  /* standard deviation of single periods, or of values that scatter */
    double noise;   /* standard deviation of measured values, or 0 for a line */
    /* middle, and half the peak-to-peak value, of the first and the last swing */
    double level[2], amplitude[2];
    double growth; /* d ln amplitude / dx by least squares, if it is a line */
    /* The following are for a curve that winds around a centre. */
    double winds;       /* number of turns, counterclockwise positive */
    double distance[2]; /* distance from the centre at the start, and after the last whole turn */
    /* the centre is the origin, otherwise the middle of the curve's range */
    bool about_origin;
    struct curve_point centre; /* the centre */
    /* x and half the width of the band around the curve at its widest, or NAN */
    struct curve_point widest;
};

/* Distance of a curve from the reference, which is the first curve with points of a recording or,
 * without any, the first curve. */
struct curve_distance {
    int curve;      /* its index in the figure */
    double largest; /* largest |difference of y|, NAN if they do not overlap */
    double x;       /* x */
    double rms;     /* root mean square over the points of the other curve */
};

/* Description of a figure. Memory is from the arena of figure_read(). */
struct figure_reading {
    const struct figure *figure;
    struct curve_reading *curve;   /* [figure->curves] */
    double x[2], y[PANELS_MAX][2]; /* ranges of the axes: fixed ones, or those of the curves */
    double second_x[2];            /* range of a second plane */
    /* index of the reference of the distances, or -1 if there are none */
    int reference;
    struct curve_distance *distance; /* [distances] */
    int distances;
    /* [ordered] indices of the curves with points, from the highest end to the lowest */
    int *order;
    int ordered;
};

/* Describes a figure in numbers, with memory from the arena; the figure must outlive the reading.
 * Returns false if out of memory or if cancelled. */
bool figure_read(const struct figure *figure, struct arena *arena, struct figure_reading *reading);

/* Returns the horizontal or vertical axis of a curve, which is that of its panel. */
const struct axis *curve_axis(const struct figure *figure, const struct curve *curve,
                              bool vertical);

/* Appends three to six sentences without line breaks. Returns false if out of memory. */
bool describe_reading(const struct figure_reading *reading, struct buffer *output);
bool describe_figure(const struct figure *figure, struct buffer *output); /* does both */

/* Appends sentences on a heat map: its axes, where it is lowest and highest, and how many points
 * have no value. Returns false if out of memory. */
bool describe_heat(const struct heat *heat, struct buffer *output);
