/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Axes as a person reads them: from the numbers beside the ticks, and from nothing else. Included
 * after <cmocka.h> by tests that draw.
 */
#pragma once

#include "cmocka_testing.h"

#include <hooke/figure.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- chance ---- */

struct dice {
    uint64_t state;
};

static inline uint32_t dice_roll(struct dice *dice) /* PCG-like: Knuth's multiplier, high bits */
{
    dice->state = dice->state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(dice->state >> 32);
}

static inline int dice_below(struct dice *dice, int n)
{
    return (int)(dice_roll(dice) % (uint32_t)n);
}

static inline double dice_between(struct dice *dice, double a, double b)
{
    return a + (b - a) * dice_roll(dice) / 4294967296.0;
}

/* A recording of a swing that dies away: times [s], distances [cm]; of some a part in the middle is
 * missing. */
static inline void write_swing(struct dice *dice, const char *name)
{
    const double period = dice_between(dice, 0.3, 3), step = dice_between(dice, 0.01, 0.1),
                 from = dice_below(dice, 3) ? 0 : dice_between(dice, 0, 30);
    const int n = (int)(exp(dice_between(dice, log(2), log(120))) / step) + 20;
    const int gap = dice_below(dice, 3) ? 0 : n / 5, left_out = n / 2; /* rows */
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fprintf(file, "Time (s)\tDistance (cm)\n");
    for (int i = 0; i < n; i++) {
        const double t = i * step;
        if (i > left_out && i <= left_out + gap)
            continue;
        fprintf(file, "%.4f\t%.3f\n", from + t,
                20 + 5 * exp(-0.01 * t) * cos(6.2831853 * t / period) +
                    dice_between(dice, -0.02, 0.02));
    }
    assert_int_equal(fclose(file), 0);
}

static char axes_folder[] = "/tmp/hooke-axes-XXXXXX";

static inline int axes_folder_enter(void **state)
{
    (void)state;
    return mkdtemp(axes_folder) && chdir(axes_folder) == 0 ? 0 : -1;
}

static inline int axes_folder_leave(void **state)
{
    (void)state;
    unlink("swing.txt");
    unlink("figure.svg");
    return chdir("/") == 0 ? rmdir(axes_folder) : -1;
}

/* ---- one axis ---- */

#define TICKS_MAX 64

/* Numbers and where they stand, as read; a place is known to half a unit. */
struct read_axis {
    double value[TICKS_MAX], at[TICKS_MAX];
    int n;
    bool log;
    double unit;   /* value of 1, with the power of ten of the title */
    double offset; /* that the title takes off, in that unit */
};

static inline double axis_unit(const struct axis *axis)
{
    return axis->factor > 0 ? axis->factor : 1;
}

static inline double read_place(const struct read_axis *axis, double value, double *reach)
{
    const int last = axis->n - 1;
    double v = value / axis->unit - axis->offset, a = axis->value[0], b = axis->value[last];
    if (axis->log) {
        v = v > 0 ? log10(v) : NAN;
        a = log10(a);
        b = log10(b);
    }
    const double part = (v - a) / (b - a);
    *reach = 0.5 * (fabs(part) + fabs(1 - part)); /* what both ticks may be off */
    return axis->at[0] + part * (axis->at[last] - axis->at[0]);
}

/* The ticks between the outermost two agree with them. */
static inline bool read_axis_is_even(const struct read_axis *axis, double min)
{
    double reach;
    for (int i = 0; i < axis->n; i++)
        if (fabs(read_place(axis, (axis->value[i] + axis->offset) * axis->unit, &reach) -
                 axis->at[i]) > min * (reach + 0.5) + 1e-6)
            return false;
    return true;
}

/* ---- a screen ---- */

struct reader {
    const struct canvas *canvas;
    int left, right, top, bottom; /* the frame of the pane */
    int axis_row;                 /* with the ticks of x */
    int first, last;              /* columns of the plot */
    struct read_axis x, y;
};

static inline uint32_t cell_at(const struct canvas *canvas, int x, int y)
{
    return x < 0 || y < 0 || x >= canvas->width || y >= canvas->height
               ? ' '
               : canvas->cell[(size_t)y * (size_t)canvas->width + (size_t)x].codepoint;
}

static inline bool is_number_cell(uint32_t c)
{
    return (c >= '0' && c <= '9') || c == '-' || c == '.' || c == 'e';
}

/* The number that begins at x; *end is after it. */
static inline double read_number(const struct canvas *canvas, int x, int y, int limit, int *end)
{
    char text[40];
    int n = 0;
    for (; x < limit && is_number_cell(cell_at(canvas, x, y)) && n < 39; x++)
        text[n++] = (char)cell_at(canvas, x, y);
    text[n] = 0;
    *end = x;
    return n ? strtod(text, NULL) : (double)NAN;
}

/* The power of ten that a title in row y gives: "y [1e-6 m]"; 1 if it has none. */
static inline double read_power(const struct canvas *canvas, int from, int to, int y)
{
    for (int x = from; x < to; x++) {
        int end;
        if (cell_at(canvas, x, y) != '[' || cell_at(canvas, x + 1, y) != '1' ||
            cell_at(canvas, x + 2, y) != 'e')
            continue;
        return read_number(canvas, x + 1, y, to, &end);
    }
    return 1;
}

/* What a title in row y takes off: "y - 2.2326 m [1e-5 m]". */
static inline double read_offset(const struct canvas *canvas, int from, int to, int y)
{
    for (int x = from + 3; x < to && cell_at(canvas, x, y) != '['; x++) {
        const uint32_t sign = cell_at(canvas, x, y);
        int end;
        if ((sign != '-' && sign != '+') || cell_at(canvas, x - 1, y) != ' ' ||
            cell_at(canvas, x + 1, y) != ' ')
            continue;
        /* of the axis; a mark of the legend, "+ 3", has none */
        const uint32_t label = cell_at(canvas, x - 2, y);
        if (label == ' ' || label == '-' || label == 0x2500)
            continue;
        const double offset = read_number(canvas, x + 2, y, to, &end);
        if (!isnan(offset))
            return sign == '-' ? offset : -offset;
    }
    return 0;
}

static inline bool is_x_tick(uint32_t c)
{
    return c == '+' || c == 0x252C;
}

/* unit: of the label in the title. False: there are fewer than two numbers. */
static inline bool read_x_axis(struct reader *r, double unit)
{
    const struct canvas *c = r->canvas;
    const int y = r->axis_row;
    int x = r->left + 1, tick = 0, end;
    while (x < r->right && cell_at(c, x, y) != '+' && cell_at(c, x, y) != 0x2514)
        x++;
    r->first = x + 1; /* after the origin */
    r->last = r->first;
    for (x = r->first; x < r->right && cell_at(c, x, y) != ' '; x++) {
        r->last = x;
        if (is_x_tick(cell_at(c, x, y)) && tick < TICKS_MAX)
            r->x.at[tick++] = x;
    }
    for (x = r->left + 1; x<r->right; x = end> x ? end : x + 1) {
        const double value = read_number(c, x, y + 1, r->right, &end);
        if (end > x && r->x.n < TICKS_MAX)
            r->x.value[r->x.n++] = value;
    }
    const double power = read_power(c, r->left, r->right, y + 2);
    r->x.unit = unit * power;
    r->x.offset = read_offset(c, r->left, r->right, y + 2) / power;
    return tick == r->x.n && tick > 1;
}

static inline bool read_y_axis(struct reader *r, double unit, bool decades)
{
    const struct canvas *c = r->canvas;
    int end;
    for (int y = r->bottom - 1; y > r->top; y--) {
        const uint32_t mark = cell_at(c, r->first - 1, y);
        if ((mark != '+' && mark != 0x2524) || y == r->axis_row || r->y.n == TICKS_MAX)
            continue;
        int x = r->first - 2;
        while (x > r->left && is_number_cell(cell_at(c, x, y)))
            x--;
        const double value = read_number(c, x + 1, y, r->first - 1, &end);
        if (isnan(value))
            return false;
        r->y.at[r->y.n] = y;
        r->y.value[r->y.n++] = value;
    }
    r->y.log = decades;
    const double power = read_power(c, r->left, r->right, r->top);
    r->y.unit = unit * power;
    r->y.offset = read_offset(c, r->left, r->right, r->top) / power;
    return r->y.n > 1;
}

/* ---- ink and samples ---- */

struct ink {
    const struct reader *r;
    int width, height;
    bool *may; /* [height][width] the axes put something of a curve there */
};

static inline void ink_may(struct ink *ink, int x, int y)
{
    if (x >= ink->r->first && x <= ink->r->last && y > ink->r->top && y < ink->r->bottom)
        ink->may[y * ink->width + x] = true;
}

/* Where a straight line between two samples may be seen, if places are known to `reach` cells. */
static inline void ink_line(struct ink *ink, const double a[4], const double b[4])
{
    const double reach_x = 0.5 + fmin(fmax(a[2], b[2]), 3) + 1e-6,
                 reach_y = 0.5 + fmin(fmax(a[3], b[3]), 3) + 1e-6;
    const double low = fmin(a[0], b[0]), high = fmax(a[0], b[0]);
    const double left_end = ink->r->first - 1, right_end = ink->r->last + 1;
    const int from = (int)fmin(fmax(ceil(low - reach_x), left_end), right_end),
              to = (int)fmax(fmin(floor(high + reach_x), right_end), left_end);
    for (int x = from; x <= to; x++) {
        const double left = fmax(low, x - reach_x), right = fmin(high, x + reach_x),
                     span = b[0] - a[0];
        double y0 = a[1], y1 = b[1];
        if (fabs(span) > 1e-9) {
            y0 = a[1] + (left - a[0]) / span * (b[1] - a[1]);
            y1 = a[1] + (right - a[0]) / span * (b[1] - a[1]);
        }
        const double above = ink->r->top - 1, below = ink->r->bottom + 1;
        const int top = (int)fmin(fmax(ceil(fmin(y0, y1) - reach_y), above), below),
                  bottom = (int)fmax(fmin(floor(fmax(y0, y1) + reach_y), below), above);
        for (int y = top; y <= bottom; y++)
            ink_may(ink, x, y);
    }
}

/* x, y, and what they are known to; false: none. */
static inline bool reader_spot(const struct reader *r, const struct curve *curve, size_t i,
                               double spot[4])
{
    spot[0] = read_place(&r->x, curve->x[i], &spot[2]);
    spot[1] = read_place(&r->y, curve->y[i], &spot[3]);
    return isfinite(spot[0]) && isfinite(spot[1]);
}

static inline bool has_ink_near(const struct reader *r, const double spot[4])
{
    /* A line that passes from one column to the next leaves the dot between them to one of both: up
     * to half a cell. */
    const double dot = 0.5, reach_x = 0.5 + spot[2] + 1e-6, reach_y = 0.5 + dot + spot[3] + 1e-6;
    if (spot[0] < r->first || spot[0] > r->last || spot[1] <= r->top || spot[1] >= r->bottom)
        return true; /* outside it is not seen */
    for (int y = (int)ceil(spot[1] - reach_y); y <= floor(spot[1] + reach_y); y++)
        for (int x = (int)ceil(spot[0] - reach_x); x <= floor(spot[0] + reach_x); x++)
            if (x < r->first || x > r->last || y <= r->top || y >= r->bottom ||
                cell_at(r->canvas, x, y) != ' ')
                return true; /* over the edge */
    return false;
}

/* Ink only where the axes put something of a curve, and some at each sample of a line; *problem
 * says what is wrong. */
static inline bool reader_agrees(const struct reader *r, const struct figure *figure,
                                 char problem[200])
{
    struct ink ink = {r, r->canvas->width, r->canvas->height, NULL};
    bool fine = true;
    if (!read_axis_is_even(&r->x, 1) || !read_axis_is_even(&r->y, 1)) {
        snprintf(problem, 200, "the numbers of an axis do not stand at even distances");
        return false;
    }
    ink.may = calloc((size_t)(ink.width * ink.height), sizeof *ink.may);
    assert_non_null(ink.may);
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        double spot[4], before[4] = {0};
        bool joined = false;
        for (size_t i = 0; i < curve->n; i++) {
            if (!reader_spot(r, curve, i, spot)) {
                joined = false;
                continue;
            }
            ink_line(&ink, joined && !curve->points ? before : spot, spot);
            memcpy(before, spot, sizeof before);
            joined = true;
            /* an arrow is one character between its ends */
            if (fine && !curve->points && !curve->arrows && !has_ink_near(r, spot)) {
                snprintf(problem, 200, "nothing is drawn at x = %g, y = %g: column %g, row %g",
                         curve->x[i], curve->y[i], spot[0], spot[1]);
                fine = false;
            }
        }
    }
    for (int y = r->top + 1; y < r->bottom && y != r->axis_row && fine; y++) {
        for (int x = r->first; x <= r->last && fine; x++) {
            const struct cell *cell = &r->canvas->cell[y * r->canvas->width + x];
            if (cell->style < STYLE_CURVE_1 || cell->style > STYLE_CURVE_4 ||
                ink.may[y * ink.width + x])
                continue;
            snprintf(problem, 200, "column %d, row %d has ink where the axes have no sample", x, y);
            fine = false;
        }
    }
    free(ink.may);
    return fine;
}
