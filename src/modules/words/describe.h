/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What a figure shows, in numbers and in words: for those who cannot see it, as the text of a
 * picture in a document, and for tests. Read from the very curves that are drawn.
 */
#pragma once

#include <hooke/figure.h>

enum course {
    COURSE_NONE,     /* fewer than two points, or too large to be added up */
    COURSE_CONSTANT, /* all the same, to rounding */
    COURSE_SCATTERS, /* noise about a level */
    COURSE_RISES,    /* without a turn */
    COURSE_FALLS,
    COURSE_TURNS,      /* up and down without a period */
    COURSE_OSCILLATES, /* over time */
    COURSE_WINDS       /* in a plane, around a centre */
};

struct curve_point {
    double x, y;
};

/* Values are those of the curve, not what the axes show of them (value / factor). NAN: not so. */
struct curve_reading {
    const char *label;             /* of the curve, or its mark; never NULL */
    size_t n, gaps;                /* points that have a place, and those that do not */
    struct curve_point start, end; /* as they are drawn */
    struct curve_point low, high;  /* least and largest y */
    enum course course;
    /* Of a curve that rises or falls. */
    bool all_along; /* not back by more than its noise, or rounding */
    double factor;  /* end over start, where both have the same sign */
    double rate;    /* d ln|y| / dx, the slope of the least-squares line, if it is one within 5 % */
    double power;   /* d ln y / d ln x, likewise: where both axes are logarithmic */
    /* Of one with turns. */
    size_t turns;     /* highest and lowest places on the way */
    size_t crossings; /* of the middle between them */
    /* x: the longest time without samples where it has periods; NAN if there is none */
    double hole[2];
    size_t periods; /* between crossings of the same direction: so many were averaged, */
    double period;  /* each; NAN: irregular */
    double spread;  /* standard deviation of one; of the values, where they scatter */
    double noise;   /* standard deviation, of what was measured; 0: a line */
    double level[2], amplitude[2]; /* middle and half the swing: of the first and the last one */
    double growth;                 /* d ln amplitude / dx, least squares, if it is a line */
    /* Of one that winds. */
    double winds;              /* signed number, counterclockwise positive */
    double distance[2];        /* from the centre: at the start, and after the last whole turn */
    bool about_origin;         /* the centre; false: the middle of what the curve spans */
    struct curve_point centre; /* where it is */
    /* of the band about the line: x, half the width; NAN if there is none */
    struct curve_point widest;
};

/* How far a curve is from the first that holds points of a recording, or from the first. */
struct curve_distance {
    int curve;      /* its place in the figure */
    double largest; /* NAN if they do not overlap, or it is a plane */
    double x;       /* x */
    double rms;     /* over the points of the other curve */
};

struct figure_reading {
    const struct figure *figure;
    struct curve_reading *curve;   /* [figure->curves] */
    double x[2], y[PANELS_MAX][2]; /* what the axes hold: as fixed, or from end to end of it */
    double second_x[2];            /* of a second plane */
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
