/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * figure: a plot as data, then as cells: ranges, ticks, axes, polylines, legends, ASCII and braille
 * raster.
 *
 * Screen panes and the `plot` command draw through the same functions; a cell canvas is all that a
 * terminal needs to know.
 */
#pragma once

#include <hooke/base/error.h>

/* ---- canvas: a rectangle of character cells ---- */

enum style {
    STYLE_PLAIN,
    STYLE_DIM,
    STYLE_BOLD,
    STYLE_CURVE_1,
    STYLE_CURVE_2,
    STYLE_CURVE_3,
    STYLE_CURVE_4,
    STYLE_ALERT
};

struct cell {
    uint32_t codepoint; /* 0 marks the right half of a wide character */
    uint8_t style;      /* enum style */
};

struct canvas {
    int width, height;
    struct cell *cell; /* [height * width] */
};

/* blanks; returns false if out of memory */
bool canvas_init(struct canvas *canvas, int width, int height);
void canvas_free(struct canvas *canvas);
/* Writes one cell; positions outside of the canvas are ignored. */
void canvas_put(struct canvas *canvas, int x, int y, uint32_t codepoint, enum style style);
/* returns the column after it; clipped */
int canvas_text(struct canvas *canvas, int x, int y, struct text text, enum style style);
/* Lines without trailing blanks; colour escapes only when `color`. */
void canvas_print(const struct canvas *canvas, bool color, struct buffer *output);

struct cancel;
struct figure;
struct heat;

/* Dots of one cell: what a character set can resolve. */
struct dot_grid {
    int dots_horizontal, dots_vertical;
};

/* Says figures in sentences and tables, for those who are read to. All return false only if out of
 * memory. */
struct figure_words {
    bool (*describe)(const struct figure *figure, struct buffer *output); /* sentences alone */
    bool (*print)(const struct figure *figure, int width, struct buffer *output);
    bool (*print_heat)(const struct heat *heat, int width, struct buffer *output);
    bool (*draw)(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                 int height);
};

/* A set of characters that figures are drawn with. */
struct charset {
    struct dot_grid dots;
    bool plain; /* frames are '-' and '|' */
    /* words that replace the drawing, or NULL for figures that are drawn */
    const struct figure_words *words;
};
extern const struct charset charset_ascii, charset_block, charset_braille;

/* Columns enough for a figure in words: no oscillation is drawn as its envelope. */
#define WORDS_COLUMNS 4000

/* ---- heat map: a value over two axes, as shades ----
 *
 * One cell or more for each point; where there are more points than cells a cell shows the largest
 * of its own. Columns follow the places on the axes, whatever their values: they are labelled.
 */
struct heat_axis {
    const char *label, *unit;
    double factor;       /* number shown = value / factor */
    const double *value; /* [count] */
    int count;
    bool log; /* the places are evenly spaced on a logarithmic axis */
};

/* The edge between place i - 1 of an axis and place i: half way; the outer ones as far beyond the
 * first and the last place as the next edge is inside. */
double heat_edge(const struct heat_axis *axis, int i);

struct heat {
    const char *title, *unit;
    double factor;
    struct heat_axis x, y; /* y points up */
    const double *value;   /* [x.count][y.count]; NAN is shown as a missing value */
    /* Letters for the values -1, 0, 1 ...; the last one also marks all larger values. NULL draws
     * shades. */
    const char *letters;
};

/* The range of values that the shades of a map stand for. low > high if there is no value. */
struct heat_scale {
    double low, high; /* range of the finite values */
    bool log;         /* positive values of very different size */
};
/* Returns the scale of a map. */
struct heat_scale heat_scale_of(const struct heat *heat);
/* Returns where a value lies on the scale, from 0 to 1. */
double heat_share(const struct heat_scale *scale, double value);
/* Returns the largest value of the places [x0, x1) and [y0, y1), or NAN if none has one. */
double heat_largest(const struct heat *heat, int x0, int x1, int y0, int y1);
/* Returns the character of a value, or 'x' for NAN. */
uint32_t heat_glyph(const struct heat *heat, const struct heat_scale *scale,
                    const struct charset *charset, double value);
/* The shades of a character set, from the lowest to the highest value; returns how many. */
int heat_shades(const struct charset *charset, const uint32_t **shade);

/* ---- figures ---- */

struct axis {
    const char *label;              /* "y", "t", "v" */
    const char *unit;               /* unit printed in brackets, or "" for none */
    double factor;                  /* number shown = value / factor; 0 counts as 1 */
    double first_value, last_value; /* range in values; used if fixed */
    bool fixed, log;
    /* Smallest value on a log axis; smaller ones are left out of the range and counted. With 0
     * only values <= 0 are left out. */
    double min;
    /* Curves that vary by less than this fraction of their size are drawn with zero on the axis.
     * With 0 a curve that hardly varies is drawn around its middle; with a negative value its
     * range is not widened. */
    double flat;
};

struct curve {
    const char *label;   /* name in the legend, such as "verlet" or "data" */
    const double *x, *y; /* [n] NaN is a gap */
    size_t n;
    bool points; /* samples are marks instead of a line, and are drawn last */
    bool plain;  /* has no colour in text, because its mark is enough */
    bool arrows; /* pieces between gaps are arrows: tail, tip, then in pictures their heads */
    bool cloud;  /* points, so many that each is the smallest dot there is */
    bool joined; /* a line joins the points; in pictures each has a shape, never a letter */
    char mark; /* glyph of this overlay in ASCII ('#', 'o', 'x', '+'), or 0 to choose by position */
    /* Index, from 1, of the curve whose colour and shape this one shares, or 0 for its own. */
    int look;
    int panel;            /* 0, or 1 where the figure has a second one */
    bool thinned;         /* a choice of the samples that looks the same: they are not counted */
    const double *t;      /* [n] [s] times of the points of a plane, or NULL if unknown */
    const double *spread; /* [n] half the width of a band about a line, below everything; or NULL */
    const char *spread_label; /* name of the band in the legend */
    /* [n] For points in a picture, half the length of each error bar, NAN for a point without
     * one. NULL draws none. Text figures have no room for them. */
    const double *bar;
    const struct cancel *cancel; /* ends every loop over its samples; NULL if nobody can */
};

/* A thin grey line between two points, or a grey area whose corners they are: below all curves, in
 * no range, in no legend. */
struct figure_guide {
    double x[2], y[2];
    bool area;
};

/* Words that end left of a point. A text figure leaves out those that would cover something. */
struct figure_label {
    double x, y;
    const char *text;
};

struct figure {
    const char *title;
    struct axis x, y;
    /* x and y of the second panel, for curves of another size. It is drawn below the first one
     * with the same x axis; in a plane beside it or below, whichever gives more room, with its
     * own x axis. If NULL, all curves share one panel. */
    const struct axis *second;
    int panel;  /* panel that is drawn: 0, except in the figures that figure_panels() returns */
    bool part;  /* one of two panels: only its curves are drawn, with labels even on a single row */
    bool plane; /* x is no independent variable: curves leave the plot through all four sides */
    const struct curve *curve;
    int curves;
    const struct heat *heat; /* shades drawn below the curves, whose axes are fixed; or NULL */
    bool equal;              /* same length for a unit on both axes (phase plot) */
    bool zero_line;
    bool grid;      /* pictures have lines at the labels of both axes */
    bool has_point; /* the current point is marked */
    double point[2];
    double aspect;    /* height over width of a cell; 0 counts as 2 */
    const char *note; /* left end of the lower frame, or NULL: "14 periods: envelope" */
    int gutter;       /* least width of the y labels (hysteresis of live plots) */
    /* right end of the upper frame, after the legend, or NULL: "last 2 T, equal axes" */
    const char *caption;
    /* Words about the figure, where its curves do not say enough, or NULL. */
    const char *words;
    const struct figure_guide *guide; /* [guides] */
    int guides;
    const struct figure_label *label; /* [labels] */
    int labels;
};

/* The factor of an axis that numbers shown are divided by; of a unit, so that nothing overflows. */
static inline double axis_factor(const struct axis *axis)
{
    return axis->factor > 1e-30 && axis->factor < 1e30 ? axis->factor : 1;
}

/* Returns the glyph of a curve, or 0 if it is drawn with dots. */
char figure_mark(const struct figure *figure, int curve);
/* Returns true if drawing a curve was cancelled; the caller must then discard the figure. */
bool figure_stopped(const struct figure *figure);
/* The first curve (of this panel) that has a band with a name; NULL if there is none. */
const struct curve *figure_band(const struct figure *figure);

/*
 * Tick positions by the extended Wilkinson algorithm (Talbot, Lin, Hanrahan 2010): about `want`, at
 * most `max`, all inside [from, to], labels with `decimals` decimals. Steps are 1, 2, 2.5, 3, 4 or
 * 5 times a power of ten. count 0: no range.
 */
struct ticks {
    double first, step;
    int count, decimals;
    int exponent;        /* labels are (value - offset) / 10^exponent, 0 mostly */
    double offset;       /* subtracted from long labels of a narrow range; the title shows it */
    int offset_decimals; /* decimals of offset / 10^offset_power */
    int offset_power;    /* power of ten of a very large or small offset, else 0 */
};
struct ticks ticks_linear(double range_begin, double range_end, int want, int max);
/* Labels of decades for a log axis (0 < from < to): powers of ten from `first` in steps of `step`
 * decades. */
struct ticks ticks_log(double range_begin, double range_end, int max);

/* Scale between the two ends of an axis. Never overflows, whatever the values. */
struct scale {
    double first_value, last_value; /* values at the ends */
    bool log;
    /* fraction = (value * unit - origin) * gain; for log the value is its log10 */
    double unit, origin, gain;
};
/* 0 at from, 1 at to; cut off at +-1e6; NAN for what cannot be shown. */
double scale_fraction(const struct scale *scale, double value);

/* Layout that figure_draw will use in a rectangle, for cursors and for callers that keep ranges
 * and gutters steady. */
struct figure_layout {
    const struct charset *charset;
    bool frame, x_labels, y_labels;
    int gutter;                   /* width of the y labels */
    int left, top, columns, rows; /* [cell] the plot, in the rectangle */
    struct scale x, y;
    struct ticks x_ticks, y_ticks; /* positions in displayed numbers (value / factor) */
    bool x_decades, y_decades;     /* ticks are powers of ten */
    size_t hidden; /* values that a log axis does not show: <= 0, or below axis.least */
};
void figure_layout(const struct figure *figure, int width, int height,
                   const struct charset *charset, struct figure_layout *layout);
/* A figure of two panels is drawn as two figures. */
struct figure_panel {
    struct figure figure;
    /* [cell] where, in the rectangle; what comes later covers what overlaps */
    int x, y, width, height;
};
#define PANELS_MAX 2
/* Splits the figure into panels, with labels aligned where panels share an axis, and returns
 * their number. Returns one panel if there is no room for two. */
int figure_panels(const struct figure *figure, int width, int height, const struct charset *charset,
                  struct figure_panel panel[PANELS_MAX]);

/* Counts the samples of a curve that lie outside of the axes. Samples beyond a window of time
 * are left out on purpose and do not count. */
struct curve_outside {
    size_t count, total; /* samples outside, of all in the window */
    bool leaves;         /* it was inside before */
    /* Position at which the curve leaves: t, or x if that is the independent variable; NAN if
     * unknown. */
    double position;
    double farthest; /* value that lies farthest beyond the frame */
    bool along_x;    /* the farthest value is one of x */
    bool is_beyond_upper;
};
void curve_outside(const struct figure *figure, const struct figure_layout *layout, int curve,
                   struct curve_outside *outside);
/* Finds the cell (relative to the plot) of a point. Returns false if it is outside of the plot. */
bool figure_cell(const struct figure_layout *layout, double x, double y, int *column, int *row);

/* Draws into the rectangle; false only without memory. Anything from 1x1 up is drawn as well as it
 * fits. */
bool figure_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                 int height, const struct charset *charset);
/* The whole figure as text lines; returns false if out of memory or stopped. */
bool figure_print(const struct figure *figure, int width, int height, const struct charset *charset,
                  bool color, struct buffer *output);

/* ---- pictures, which modules make ---- */

#define PICTURE_MIN 0.03 /* [m] a side of a page, as users choose it */
#define PICTURE_MAX 1.0
#define POINTS_PER_METRE (72 / 0.0254)
/* [cell] of a text figure that shows as much: for callers that choose what is drawn */
#define PICTURE_COLUMNS 250
