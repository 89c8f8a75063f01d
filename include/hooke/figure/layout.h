/* SPDX-License-Identifier: GPL-3.0-or-later */
/* figure: ranges, ticks and panels, for whatever draws figures: cells, or a module that makes
 * pictures. */
#pragma once

#include <hooke/base/cancel.h>
#include <hooke/figure.h>

#include <math.h>

/* Returns true if sample i of the curve exists and the figure is not cancelled: the condition of
 * loops over samples. The result of a cancelled loop is dropped. */
static inline bool curve_goes_on(const struct curve *curve, size_t i)
{
    return i < curve->n && (i % LOOK_EACH_ROWS != 0 || !cancelled(curve->cancel));
}

#define TICK_TEXT_SIZE 48

/* Returns the value of tick i on its axis. */
double tick_value(const struct ticks *ticks, int i, bool log);
/* Writes the label of tick i. Returns its length. */
int tick_text(const struct ticks *ticks, int i, bool log, char output[TICK_TEXT_SIZE]);

/* Returns into how many parts ticks without labels divide a step: 5 of steps 1, 2.5 and 5, 4 of 2
 * and 4, 3 of 3. */
int tick_parts(const struct ticks *ticks);

/* Writes the offset that a title subtracts, such as "- 2.2326". Returns its length. */
int offset_text(const struct ticks *ticks, char output[TICK_TEXT_SIZE]);

struct scale scale_of(double first, double last, bool log);

/* [axis lengths] Fractions are cut off here, where they are still a whole number of dots. */
#define FRACTION_MAX 1e6

/* Returns where a value is along the axis, 0 to 1 from its start to its end, or NAN if the axis
 * cannot show it. */
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

/* The range of the curves along an axis. */
struct extent {
    double low, high; /* low > high if there are no values */
    size_t hidden;    /* number of values that a logarithmic axis cannot show */
};

/* Choice of the samples that an extent is taken over. All zeros choose every finite sample. */
struct extent_window {
    bool vertical;             /* extent of y instead of x */
    const double *other_range; /* [2] range on the other axis to which samples belong, or NULL */
    double min;                /* smallest value that counts, if it is positive */
    int panel;                 /* panel whose curves are taken, from 1, or 0 for all panels */
    bool bands, bars;          /* bands and error bars extend the range */
};

/* Returns what curves hold. An end of the window's other_range that is NAN is open. */
struct extent curves_extent(const struct curve *curve, int curves,
                            const struct extent_window *window);
/* Returns the extent along an axis that is not fixed, with error bars if those are drawn. */
struct extent axis_extent(const struct figure *figure, bool vertical, bool bars);
/* Chooses ranges and ticks for layout->columns x rows, of curves that reach that far. */
void layout_scales(const struct figure *figure, struct figure_layout *layout, struct extent x,
                   struct extent y);
/* Appends the text of the lower frame, at most `available` cells: which curves leave the plot, the
 * figure's note, how many values are hidden. Appends nothing if there is nothing to say. */
void figure_note(const struct figure *figure, const struct figure_layout *layout, int available,
                 struct buffer *output);

/* Returns true if the figure's panel shows the curve. */
static inline bool curve_drawn(const struct figure *figure, int curve)
{
    return !figure->part || figure->curve[curve].panel == figure->panel;
}

/* First exit of a curve through one side of the plot (left, right, bottom, top). */
struct curve_exit {
    bool left;
    double x, y; /* fractions */
};

/* Finds the exits of a curve, only through bottom and top if it has an independent variable.
 * Returns true if there is any. */
bool curve_exits(const struct figure *figure, const struct figure_layout *layout, int curve,
                 struct curve_exit exits[4]);

/* Makes a figure of each panel of a figure. Returns how many. */
int figure_parts(const struct figure *figure, struct figure part[PANELS_MAX]);
/* Returns true if two planes have more room side by side than one below the other. */
bool planes_across(const struct figure *figure, int width, int height);
