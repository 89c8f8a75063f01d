/* SPDX-License-Identifier: GPL-3.0-or-later */
/* layout: ranges, ticks and panels of a figure, for code that draws figures: into cells, or as
 * pictures in a module. Coordinates are fractions of the axes. */
#pragma once

#include <hooke/base/cancel.h>
#include <hooke/figure.h>

#include <math.h>

/* Returns true if the curve has sample i and is not cancelled: the condition of loops over samples.
 * The result of a cancelled loop is discarded. */
static inline bool curve_goes_on(const struct curve *curve, size_t i)
{
    return i < curve->n && (i % LOOK_EACH_ROWS != 0 || !cancelled(curve->cancel));
}

/* Size [byte] of any tick label with its NUL. */
#define TICK_TEXT_SIZE 48

/* Returns the number at tick i. `log`, here and below, is true if the ticks are powers of ten. */
double tick_value(const struct ticks *ticks, int i, bool log);
/* Writes the label of tick i. Returns its length [byte]. */
int tick_text(const struct ticks *ticks, int i, bool log, char output[TICK_TEXT_SIZE]);

/* Returns the number of parts into which small ticks divide a step: 5 for steps of 1, 2.5 and 5, 4
 * for 2 and 4, 3 for 3 (times a power of ten). */
int tick_parts(const struct ticks *ticks);

/* Writes the offset as an axis title shows it, such as "- 2.2326". Returns its length [byte]. */
int offset_text(const struct ticks *ticks, char output[TICK_TEXT_SIZE]);

/* Returns the scale of an axis from `first` to `last`, logarithmic if `log`. */
struct scale scale_of(double first, double last, bool log);

/* Largest magnitude of a fraction [axis lengths]; larger ones are set to it. */
#define FRACTION_MAX 1e6

/* Returns the position of a value along the axis, 0 at its start and 1 at its end, limited to
 * FRACTION_MAX; NAN if the axis cannot show it. */
static inline double fraction_of(const struct scale *scale, double value)
{
    if (!isfinite(value) || (scale->log && value <= 0))
        return NAN;
    double fraction =
        ((scale->log ? log10(value) : value * scale->unit) - scale->origin) * scale->gain;
    return fraction > FRACTION_MAX    ? FRACTION_MAX
           : fraction < -FRACTION_MAX ? -FRACTION_MAX
                                      : fraction;
}

/* Range of the values of curves along an axis. */
struct extent {
    double low, high; /* Smallest and largest value; low > high if there are none. */
    size_t hidden;    /* Number of values that a logarithmic axis cannot show. */
};

/* Selection of the samples that count for an extent. All zeros select every finite sample. */
struct extent_window {
    bool vertical; /* The extent is that of y instead of x. */
    /* [2] range on the other axis in which samples count, or NULL; an end that is NAN is open. */
    const double *other_range;
    double min;       /* Smallest value that counts, if > 0. */
    int panel;        /* Panel whose curves count, from 1, or 0 for all panels. */
    bool bands, bars; /* The extent includes bands, and error bars. */
};

/* Returns the extent of curve [curves] along an axis; `window` selects axis and samples. */
struct extent curves_extent(const struct curve *curve, int curves,
                            const struct extent_window *window);
/* Returns the extent of the figure's curves along the x or (vertical) y axis, which is not fixed,
 * including error bars if `bars`. */
struct extent axis_extent(const struct figure *figure, bool vertical, bool bars);
/* Chooses scales and ticks of *layout for a plot of layout->columns by layout->rows cells whose
 * curves have the extents x and y. */
void layout_scales(const struct figure *figure, struct figure_layout *layout, struct extent x,
                   struct extent y);
/* Appends the text of the lower frame, at most `available` columns wide: the curves that leave the
 * plot, the figure's note, the number of hidden values. May append nothing. */
void figure_note(const struct figure *figure, const struct figure_layout *layout, int available,
                 struct buffer *output);

/* Returns true if curve number `curve` is drawn in the figure's panel. */
static inline bool curve_drawn(const struct figure *figure, int curve)
{
    return !figure->part || figure->curve[curve].panel == figure->panel;
}

/* First exit of a curve through one side of the plot (left, right, bottom, top). */
struct curve_exit {
    bool left;   /* The curve has left the plot through this side. */
    double x, y; /* Position of the exit, in fractions of the axes. */
};

/* Finds the exits of curve number `curve` through the left, right, bottom and top side. If x is an
 * independent variable only bottom and top count. Returns true if there is any exit. */
bool curve_exits(const struct figure *figure, const struct figure_layout *layout, int curve,
                 struct curve_exit exits[4]);

/* Makes a figure of its own for each panel. Returns the number of panels. */
int figure_parts(const struct figure *figure, struct figure part[PANELS_MAX]);
/* Returns true if two planes have more room side by side than one below the other in a rectangle of
 * this size [cell]. */
bool planes_across(const struct figure *figure, int width, int height);
