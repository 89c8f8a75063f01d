/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * figure: a plot as data (struct figure: curves, axes, heat map), its layout in a rectangle
 * (ranges, ticks, panels) and its drawing into a canvas of character cells.
 *
 * A caller fills a struct figure, which owns nothing, and calls figure_draw() with a rectangle of a
 * canvas, or figure_print() for lines of text. Panes and the command `plot` use the same functions;
 * pictures (SVG, PDF, PNG) are drawn from the same struct by a module.
 */
#pragma once

#include <hooke/base/error.h>

/* ---- canvas: a rectangle of character cells ---- */

/* Style of a cell; the front end chooses a colour for each. */
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

/* A character cell. */
struct cell {
    uint32_t codepoint; /* Code point; 0 marks the right half of a wide character. */
    uint8_t style;      /* enum style */
};

/* A rectangle of cells; begin with canvas_init(), end with canvas_free(). */
struct canvas {
    int width, height; /* Size [cell]. */
    struct cell *cell; /* [height * width] cells, row by row, owned. */
};

/* Makes a canvas of width x height blank cells. Returns false if out of memory. */
bool canvas_init(struct canvas *canvas, int width, int height);
/* Frees the cells. */
void canvas_free(struct canvas *canvas);
/* Writes one cell at column x and row y, from 0 at the top left; positions outside are ignored. */
void canvas_put(struct canvas *canvas, int x, int y, uint32_t codepoint, enum style style);
/* Writes a text in row y from column x on, clipped at the edges. Returns the column behind the
 * text. */
int canvas_text(struct canvas *canvas, int x, int y, struct text text, enum style style);
/* Returns the colour of a style for a terminal with that many colours, or -1 if it has none. With
 * 256, colours of curves are readable on white and on black; with 8, they avoid yellow and cyan. */
int style_color(enum style style, int colors);
/* Appends the canvas as lines without trailing blanks, with escape sequences for a terminal with
 * that many colours, or without any if `colors` is 0. Sets output->failed if out of memory. */
void canvas_print(const struct canvas *canvas, int colors, struct buffer *output);

struct cancel;
struct figure;
struct heat;

/* Numbers of dots, across and down, that a character set can show in one cell. */
struct dot_grid {
    int dots_horizontal, dots_vertical;
};

/* Functions that describe figures in sentences and tables, for screen readers. All return false
 * only if out of memory. The module `words` provides them. */
struct figure_words {
    /* Appends a description in sentences. */
    bool (*describe)(const struct figure *figure, struct buffer *output);
    /* Appends the figure as figure_print() does, in words, in lines of `width` columns. */
    bool (*print)(const struct figure *figure, int width, struct buffer *output);
    /* Appends a heat map alone, in words, in lines of `width` columns. */
    bool (*print_heat)(const struct heat *heat, int width, struct buffer *output);
    /* Writes the words into a rectangle of a canvas. */
    bool (*draw)(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                 int height);
};

/* A set of characters by which figures are drawn. */
struct charset {
    struct dot_grid dots; /* Dots per cell with which curves are drawn. */
    bool plain;           /* Frames are drawn by '-' and '|'. */
    /* Functions that describe the figure in words instead, or NULL for figures that are drawn. */
    const struct figure_words *words;
};
/* Characters of ASCII, of block elements, and of braille dots. */
extern const struct charset charset_ascii, charset_block, charset_braille;

/* Number of columns for a figure in words, large enough that no oscillation is reduced to its
 * envelope. */
#define WORDS_COLUMNS 4000

/*
 * ---- heat map: a value over two axes, as shades or letters ----
 *
 * Each axis has a list of values, called places, such as the values of a parameter in a sweep. The
 * map has a value for each pair of places. A place is drawn as one cell or more; if there are more
 * places than cells, a cell shows the largest value of its places. All places are drawn with equal
 * width, even if their values are unevenly spaced; the labels show the values.
 */

/* An axis of a heat map. */
struct heat_axis {
    const char *label, *unit; /* Name and unit of the values, or "". */
    double factor;            /* Number shown = value / factor. */
    const double *value;      /* [count] values of the places, monotonic. */
    int count;
    bool log; /* The places are evenly spaced on a logarithmic axis. */
};

/* Returns the value at the edge between places i - 1 and i of an axis (0 <= i <= count), half way
 * between them. The outer edges, 0 and `count`, are as far from their place as the edge on its
 * other side. */
double heat_edge(const struct heat_axis *axis, int i);

/* A heat map; owns nothing. */
struct heat {
    /* Title of the map, and unit of the values. */
    const char *title, *unit;
    double factor;         /* Number shown = value / factor. */
    struct heat_axis x, y; /* Axes; y points up. */
    const double *value;   /* [x.count][y.count] values; NAN is shown as missing. */
    /* Letters that are drawn for the values -1, 0, 1, …; the last letter also for larger values.
     * NULL draws values as shades. */
    const char *letters;
};

/* Range of values that the shades of a map show; low > high if there is no value. */
struct heat_scale {
    double low, high; /* Range of the finite values. */
    bool log;         /* The scale is logarithmic, for positive values of very different sizes. */
};
/* Returns the scale of a map. */
struct heat_scale heat_scale_of(const struct heat *heat);
/* Returns the position of a value on the scale, from 0 (low) to 1 (high). */
double heat_share(const struct heat_scale *scale, double value);
/* Returns the largest value of the places x0 <= x < x1 and y0 <= y < y1, or NAN if none has a
 * value. */
double heat_largest(const struct heat *heat, int x0, int x1, int y0, int y1);
/* Returns the character that is drawn for a value; 'x' for NAN. */
uint32_t heat_glyph(const struct heat *heat, const struct heat_scale *scale,
                    const struct charset *charset, double value);
/* Sets *shade to the characters with which a character set draws shades, ordered from the lowest to
 * the highest value; constants. Returns their number. */
int heat_shades(const struct charset *charset, const uint32_t **shade);

/* ---- figures ---- */

/* An axis of a figure. */
struct axis {
    const char *label;              /* Name of the quantity: "y", "t", "v". */
    const char *unit;               /* Unit that is printed in brackets, or "". */
    double factor;                  /* Number shown = value / factor; 0 stands for 1. */
    double first_value, last_value; /* Range of values if `fixed`. */
    bool fixed,                     /* The range is given by first_value and last_value. */
        log;                        /* The axis is logarithmic. */
    /* Smallest value on a logarithmic axis, or 0. Values that are smaller, or not positive, are not
     * drawn and are counted as hidden. */
    double min;
    /* Smallest variation of the curves, as a fraction of their size, for which the axis shows only
     * their range. If they vary by less the axis includes zero. With 0 a curve that is nearly
     * constant gets a widened range around its middle; a negative value never widens the range. */
    double flat;
};

/* A curve or a set of points; owns nothing. Zero members are the defaults. */
struct curve {
    const char *label;   /* Name in the legend, such as "verlet" or "data". */
    const double *x, *y; /* [n] coordinates; NAN makes a gap. */
    size_t n;
    bool points; /* Samples are drawn as marks instead of a line, after all lines. */
    bool plain;  /* The curve has no colour in text, because its mark distinguishes it. */
    /* Samples between two gaps are an arrow: its tail, its tip, and further points, drawn only in
     * pictures, of its head. */
    bool arrows;
    bool cloud; /* The points are so many that each is drawn as the smallest possible dot. */
    /* A line joins the points. In pictures each point has a shape instead of a letter. */
    bool joined;
    /* Character of the curve in ASCII ('#', 'o', 'x', '+'), or 0 to choose one by the index of the
     * curve. */
    char mark;
    /* Number, from 1, of the curve whose colour and shape this curve shares, or 0 if it has its
     * own. */
    int look;
    int panel; /* Panel in which the curve is drawn: 0, or 1 if the figure has a second panel. */
    /* The samples are a selection that looks like all samples, so that counts of them (such as of
     * hidden ones) mean nothing. */
    bool thinned;
    const double *t; /* [n] times [s] of the points of a plane, or NULL if unknown. */
    /* [n] half the vertical width of a band around the line, drawn below all curves; or NULL. */
    const double *spread;
    const char *spread_label; /* Name of the band in the legend, or NULL. */
    /* [n] half the length of each point's error bar, NAN for none; NULL draws none. Error
     * bars are drawn only in pictures. */
    const double *bar;
    const struct cancel *cancel; /* Flag that stops loops over the samples; may be NULL. */
};

/* A thin grey line between two points, or a grey area with two opposite corners at them, drawn
 * below all curves; it changes no range and is not in the legend. */
struct figure_guide {
    double x[2], y[2]; /* Coordinates of the two points. */
    bool area;         /* An area is drawn instead of a line. */
};

/* A text that ends left of a point. Text figures omit it if it would cover something. */
struct figure_label {
    double x, y; /* Coordinates of the point. */
    const char *text;
};

/* A plot as data; owns nothing. Zero members are the defaults. */
struct figure {
    const char *title;
    struct axis x, y; /* Axes of the first panel. */
    /* [2] axes x and y of a second panel, for curves of another size, or NULL if all curves share
     * one panel. The second panel is below the first one with the same x axis; if the figure is a
     * plane, beside or below it, whichever gives more room, with an x axis of its own. */
    const struct axis *second;
    int panel; /* Panel that is drawn: 0, except in the figures of figure_panels(). */
    /* The figure is one of two panels: only the curves of `panel` are drawn, with axis labels even
     * on a single row. */
    bool part;
    /* The figure is a plane, such as a phase plot: x is not an independent variable, so that curves
     * can leave the plot through all four sides. */
    bool plane;
    const struct curve *curve; /* [curves] */
    int curves;
    /* Heat map that is drawn below the curves, whose axes are then fixed; or NULL. */
    const struct heat *heat;
    bool equal;     /* A unit has the same length on both axes (phase plot). */
    bool zero_line; /* A line is drawn at y = 0. */
    bool grid;      /* Pictures have grid lines at the labels of both axes. */
    bool has_point; /* `point` is marked as the current one. */
    double point[2];
    double aspect; /* Height over width of a cell; 0 stands for 2. */
    /* Text at the left end of the lower frame, such as "14 periods: envelope", or NULL. */
    const char *note;
    /* Smallest width [column] for the y labels; a caller that keeps it constant makes live plots
     * stay in place when labels get longer. */
    int gutter;
    /* Text at the right end of the upper frame, after the legend, such as "last 2 T, equal axes",
     * or NULL. */
    const char *caption;
    /* Sentences for screen readers, if the curves do not tell enough, or NULL. */
    const char *words;
    const struct figure_guide *guide; /* [guides] */
    int guides;
    const struct figure_label *label; /* [labels] */
    int labels;
};

/* Returns the factor of an axis, or 1 if the factor is 0 or so extreme that value / factor could
 * overflow. */
static inline double axis_factor(const struct axis *axis)
{
    return axis->factor > 1e-30 && axis->factor < 1e30 ? axis->factor : 1;
}

/* Returns the character of curve number `curve`, or 0 if it is drawn with dots. */
char figure_mark(const struct figure *figure, int curve);
/* Returns true if drawing was cancelled; the caller must then discard the figure. */
bool figure_stopped(const struct figure *figure);
/* Returns the first curve of this panel that has a band with a name, or NULL if there is none. */
const struct curve *figure_band(const struct figure *figure);

/* Ticks of an axis: `count` ticks at first + i step, where count = 0 if the range is empty. */
struct ticks {
    double first, step;  /* First tick and distance of ticks, in displayed numbers. */
    int count, decimals; /* Number of ticks, and of decimals of their labels. */
    /* Labels show (value - offset) / 10^exponent; the exponent is mostly 0. */
    int exponent;
    /* Offset that is subtracted from long labels of a narrow range and shown in the title; mostly
     * 0. */
    double offset;
    /* The title shows offset / 10^offset_power with this number of decimals. */
    int offset_decimals;
    int offset_power; /* Power of ten of a very large or small offset, else 0. */
};
/* Chooses ticks by the extended Wilkinson algorithm (Talbot, Lin, Hanrahan 2010): about `want` and
 * at most `max` ticks, all inside the range. Steps are 1, 2, 2.5, 3, 4 or 5 times a power of ten.
 */
struct ticks ticks_linear(double range_begin, double range_end, int want, int max);
/* Chooses ticks of a logarithmic axis, 0 < range_begin < range_end: at most `max` powers of
 * ten, whose exponents are `first` + i `step`. */
struct ticks ticks_log(double range_begin, double range_end, int max);

/* Map from values to the fraction of an axis; it never overflows, whatever the values. */
struct scale {
    double first_value, last_value; /* Values at the ends. */
    bool log;
    /* fraction = (value * unit - origin) * gain; on a logarithmic axis with log10(value) in place
     * of value * unit. */
    double unit, origin, gain;
};
/* Returns the fraction of a value: 0 at first_value, 1 at last_value, limited to +-1e6; NAN if the
 * value cannot be shown. */
double scale_fraction(const struct scale *scale, double value);

/* Layout that figure_draw() uses in a rectangle, for cursors and for callers that keep ranges and
 * widths steady. */
struct figure_layout {
    const struct charset *charset; /* Characters that the figure is drawn with. */
    /* The rectangle has room for a frame, and for labels of the axes. */
    bool frame, x_labels, y_labels;
    int gutter;                    /* Width [column] of the y labels. */
    int left, top, columns, rows;  /* [cell] position of the plot in the rectangle, and its size */
    struct scale x, y;             /* Scales of the axes. */
    struct ticks x_ticks, y_ticks; /* Ticks, in displayed numbers (value / factor). */
    bool x_decades, y_decades;     /* Ticks are powers of ten. */
    /* Number of values that a logarithmic axis does not show: <= 0, or below axis.min. */
    size_t hidden;
};
/* Computes the layout for a rectangle of this size [cell]. */
void figure_layout(const struct figure *figure, int width, int height,
                   const struct charset *charset, struct figure_layout *layout);
/* One panel of a figure, as a figure of its own. */
struct figure_panel {
    /* Figure with `part` set, or the whole figure if it has a single panel. */
    struct figure figure;
    /* [cell] position in the rectangle and size; a later panel covers an earlier one where they
     * overlap */
    int x, y, width, height;
};
/* Largest number of panels of a figure. */
#define PANELS_MAX 2
/* Sets panel [PANELS_MAX] to the panels of a figure, with aligned labels if they share an axis.
 * Returns their number, which is 1 if a figure with a second panel has no room for both. */
int figure_panels(const struct figure *figure, int width, int height, const struct charset *charset,
                  struct figure_panel panel[PANELS_MAX]);

/* Samples of a curve that the axes do not show. Samples outside of the window of time of a time
 * plot are left out on purpose and do not count. */
struct curve_outside {
    size_t count, total; /* Number of samples outside, and of all in the window. */
    bool leaves;         /* The curve leaves the axes: a sample outside follows one inside. */
    /* Position at which the curve leaves the axes: the time t, or x if x is the independent
     * variable; NAN if unknown. */
    double position;
    double farthest; /* Value, of x or y, that lies farthest outside. */
    bool along_x;    /* `farthest` is a value of x instead of y. */
    /* `farthest` lies beyond the upper end of its axis. */
    bool is_beyond_upper;
};
/* Fills *outside for curve number `curve`. */
void curve_outside(const struct figure *figure, const struct figure_layout *layout, int curve,
                   struct curve_outside *outside);
/* Sets *column and *row to the cell of the point (x, y), counted from the top left cell of the
 * plot. Returns false if the point is outside. */
bool figure_cell(const struct figure_layout *layout, double x, double y, int *column, int *row);

/* Draws the figure into the rectangle of width x height cells at (x, y) of a canvas. Any size from
 * 1x1 on is allowed; labels and frame that do not fit are left out. Returns false if out of memory.
 */
bool figure_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                 int height, const struct charset *charset);
/* Appends the figure as `height` lines of text, `width` columns wide, with the colours of a
 * terminal that has `colors` of them. Returns false if out of memory or cancelled. */
bool figure_print(const struct figure *figure, int width, int height, const struct charset *charset,
                  int colors, struct buffer *output);

/* ---- sizes of pictures, which a module draws ---- */

/* Smallest and largest side [m] of a picture that users may choose. */
#define PICTURE_MIN 0.03
#define PICTURE_MAX 1.0
/* Points (1/72 inch) per metre. */
#define POINTS_PER_METRE (72 / 0.0254)
/* Width [cell] of a text figure that shows as much detail as a picture; callers that select rows by
 * the width use it for pictures. */
#define PICTURE_COLUMNS 250
