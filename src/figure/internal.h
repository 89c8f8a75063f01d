/* SPDX-License-Identifier: GPL-3.0-or-later */
/* figure: what its files share. */
#ifndef HOOKE_FIGURE_INTERNAL_H
#define HOOKE_FIGURE_INTERNAL_H

#include <hooke/figure.h>

#include <math.h>

#define TICK_TEXT_SIZE 48

/* The best ticks for [from, to]; when `loose`, the outermost may lie beyond it. */
struct ticks ticks_search(double from, double to, int want, int max, bool loose);
double tick_value(const struct ticks *ticks, int i, bool log);
int tick_text(const struct ticks *ticks, int i, bool log, char out[TICK_TEXT_SIZE]); /* length */

/* Parts of a step for ticks without labels: 5 of 1, 2.5 and 5, 4 of 2 and 4, 3 of 3. */
int tick_parts(const struct ticks *ticks);

/* what a title takes off: "- 2.2326" */
int offset_text(const struct ticks *ticks, char out[TICK_TEXT_SIZE]);

struct scale scale_of(double from, double to, bool log);

#define LARGEST 1e300 /* ranges end here, so that differences stay finite */
/* [axis lengths] fractions are cut off here: still an integer number of dots */
#define FARTHEST 1e6

/* scale_fraction for the inner loops. */
static inline double fraction_of(const struct scale *scale, double value)
{
    if (!isfinite(value) || (scale->log && value <= 0))
        return NAN;
    double fraction =
        ((scale->log ? log10(value) : value * scale->unit) - scale->origin) * scale->gain;
    return fraction > FARTHEST ? FARTHEST : fraction < -FARTHEST ? -FARTHEST : fraction;
}

/* What the curves span along an axis. */
struct extent {
    double low, high; /* low > high: nothing */
    size_t hidden;    /* values a log axis cannot show */
};

struct extent axis_extent(const struct figure *figure, bool vertical);
/* The range an axis shows: fixed, or the extent with some air, widened to about `want` ticks. */
struct scale axis_scale(const struct figure *figure, bool vertical, struct extent extent, int want,
                        int max);

static inline double axis_factor(const struct axis *axis)
{
    /* of a unit: nothing overflows through it */
    return axis->factor > 1e-30 && axis->factor < 1e30 ? axis->factor : 1;
}

/* Chooses ranges and ticks for layout->columns x rows, of curves that reach that far. */
void layout_scales(const struct figure *figure, struct figure_layout *layout, struct extent x,
                   struct extent y);
/* "title y [1e-6 m]"; with an offset "title y - 2.2326 m [1e-6 m]" */
void axis_title(const struct axis *axis, const struct ticks *ticks, const char *title, char *out,
                size_t size);
/* What the lower frame says in so many cells: which curves leave it, the figure's note, how much is
 * hidden; nothing: empty. */
void figure_note(const struct figure *figure, const struct figure_layout *layout, int available,
                 struct buffer *out);

/* Glyph of a curve; 0: it is drawn with dots. */
char figure_mark(const struct figure *figure, int curve);

/* Whether the curve is one of this panel. */
static inline bool curve_drawn(const struct figure *figure, int curve)
{
    return !figure->part || figure->curve[curve].panel == figure->panel;
}

/* Where a curve first leaves through each side of the plot: left, right, bottom, top. */
struct curve_exit {
    bool left;
    double x, y; /* fractions */
};

/* Of those with an independent variable only bottom and top. Returns whether there is any. */
bool curve_exits(const struct figure *figure, const struct figure_layout *layout, int curve,
                 struct curve_exit exits[4]);

/* The panels of a figure as figures of their own. Returns how many. */
int figure_parts(const struct figure *figure, struct figure part[PANELS_MAX]);
/* Whether two planes have more room beside each other than one below the other. */
bool planes_across(const struct figure *figure, int width, int height);

/* In columns of the plot; the label may begin left of it. */
int x_tick_column(const struct figure *figure, const struct figure_layout *layout, int i);
int x_label_start(const struct figure_layout *layout, int column, int len);

/* Dots of one cell: what a character set can resolve. */
struct dot_grid {
    int across, down;
};

struct dot_grid charset_grid(enum charset charset);

/* Draws curves into the plot of a canvas. */
struct raster {
    struct canvas *canvas;
    const struct figure_layout *layout;
    int x, y; /* where the plot begins on the canvas */
    enum style style;
    char mark;     /* 0: as a line of dots */
    uint32_t fill; /* of a band */
};

void raster_line(const struct raster *raster, const struct curve *curve);
/* Arrows of one cell, by their directions on the paper. */
void raster_arrows(const struct raster *raster, const struct curve *curve);
/* Fills the cells of the curve's band; where it is thinner than a dot there is only the line. */
void raster_band(const struct raster *raster, const struct curve *curve);
/* Marks no nearer to each other than `apart` columns along the curve, so that what lies under them
 * stays visible. */
void raster_points(const struct raster *raster, const struct curve *curve, int apart);
/* An arrow where the curve first leaves, each side. */
void raster_exits(const struct raster *raster, const struct figure *figure, int curve);
void raster_put(const struct raster *raster, int column, int row, uint32_t codepoint);

#endif
