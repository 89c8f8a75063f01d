/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Describes a figure in numbers and words, for readers who cannot see it, as the text of a picture
 * in a document, and for tests. The numbers are computed from the curves that are drawn.
 */
#pragma once

#include <hooke/figure.h>

enum course {
    COURSE_NONE,     /* fewer than two points, or too large to be added up */
    COURSE_CONSTANT, /* all the same, to rounding */
    COURSE_SCATTERS, /* noise about a level */
    COURSE_RISES,    /* rises without a turn */
    COURSE_FALLS,
    COURSE_TURNS,      /* moves up and down without a period */
    COURSE_OSCILLATES, /* oscillates over time */
    COURSE_WINDS       /* winds around a centre in a plane */
};

struct curve_point {
    double x, y;
};

/* Description of a curve, in the values of the curve, not in those that the axes show (value /
 * factor). NAN marks numbers that do not apply. */
struct curve_reading {
    const char *label;             /* label of the curve, or its mark; never NULL */
    size_t n, gaps;                /* points that have a place, and those that do not */
    struct curve_point start, end; /* as they are drawn */
    struct curve_point low, high;  /* least and largest y */
    enum course course;
    /* Members for a curve that rises or falls. */
    bool all_along; /* not back by more than its noise, or rounding */
    double factor;  /* end over start, where both have the same sign */
    double rate;    /* d ln|y| / dx, the slope of the least-squares line, if it is one within 5 % */
    double power;   /* d ln y / d ln x in the same way, if both axes are logarithmic */
    /* Members for a curve with turns. */
    size_t turns;     /* highest and lowest places on the way */
    size_t crossings; /* crossings of the middle between them */
    /* Ends of the longest time x without samples of a curve with periods; NAN if there is none. */
    double hole[2];
    size_t periods; /* number of averaged periods, between crossings of the same direction */
    double period;  /* length of one period, or NAN if irregular */
    double spread;  /* standard deviation of one; of the values, where they scatter */
    double noise;   /* standard deviation of measured values, or 0 for a line */
    double level[2], amplitude[2]; /* middle and half the swing: of the first and the last one */
    double growth;                 /* d ln amplitude / dx, least squares, if it is a line */
    /* Members for a curve that winds. */
    double winds;       /* signed number, counterclockwise positive */
    double distance[2]; /* distance from the centre at the start, and after the last whole turn */
    /* the centre is the origin; otherwise the middle of the range of the curve */
    bool about_origin;
    struct curve_point centre; /* the centre */
    /* widest point of the band about the line: x and half the width; NAN if there is none */
    struct curve_point widest;
};

/* Distance of a curve from the reference: the first curve with points of a recording, or else
 * the first curve. */
struct curve_distance {
    int curve;      /* its place in the figure */
    double largest; /* NAN if they do not overlap, or it is a plane */
    double x;       /* x */
    double rms;     /* root mean square over the points of the other curve */
};

struct figure_reading {
    const struct figure *figure;
    struct curve_reading *curve;   /* [figure->curves] */
    double x[2], y[PANELS_MAX][2]; /* ranges of the axes: fixed ones, or those of the curves */
    double second_x[2];            /* range of a second plane */
    /* the curve that distances are from; -1 if there is one only */
    int reference;
    struct curve_distance *distance; /* [distances] */
    int distances;
    int *order; /* [ordered] the curves from the highest end to the lowest, of those with points */
    int ordered;
};

/* Returns false if out of memory or if stopped. Memory from the arena; the figure has to live as
 * long. */
bool figure_read(const struct figure *figure, struct arena *arena, struct figure_reading *reading);

/* The axis of a curve: of its panel. */
const struct axis *curve_axis(const struct figure *figure, const struct curve *curve,
                              bool vertical);

/* Three to six sentences without line breaks; returns false if out of memory. */
bool describe_reading(const struct figure_reading *reading, struct buffer *output);
bool describe_figure(const struct figure *figure, struct buffer *output); /* both at once */

/* A heat map: what over what, its range, where it is highest and lowest, what has no value. */
bool describe_heat(const struct heat *heat, struct buffer *output);
