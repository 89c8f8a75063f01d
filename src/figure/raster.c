/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws curves into the cells of a plot, as dots (braille 2x4, block 2x2, ASCII 1x4) or as marks,
 * with bands, guides, arrows and exits. A pen walks along the curve and knows, for the dot column
 * it is in, the height at which it entered and leaves, and the extremes between (M4: Jugel, Jerzak,
 * Hackenbroich, Markl, VLDB 2014): no peak is lost, whatever the number of samples. Neighbouring
 * columns share the height at which the curve passes from one to the other and each dot belongs to
 * one of them, so lines are thin. */
#include "figure/internal.h"

#include <string.h>

const struct charset charset_ascii = {.dots = {1, 4}, .plain = true};
const struct charset charset_block = {.dots = {2, 2}};
const struct charset charset_braille = {.dots = {2, 4}};

void raster_put(const struct raster *raster, int column, int row, uint32_t codepoint)
{
    const struct figure_layout *layout = raster->layout;
    if (column >= 0 && row >= 0 && column < layout->columns && row < layout->rows)
        canvas_put(raster->canvas, raster->x + column, raster->y + row, codepoint, raster->style);
}

/* Returns the character in a cell of the plot if it was drawn in the raster's style, which is that
 * of the current curve, else ' '. */
static uint32_t raster_get(const struct raster *raster, int column, int row)
{
    const struct canvas *canvas = raster->canvas;
    int x = raster->x + column, y = raster->y + row;
    if (x < 0 || y < 0 || x >= canvas->width || y >= canvas->height)
        return ' ';
    const struct cell *cell = &canvas->cell[(size_t)y * (size_t)canvas->width + (size_t)x];
    return cell->style == raster->style ? cell->codepoint : ' ';
}

/* Sets a dot, given in dot coordinates, without clearing the dots that the same curve already has
 * in its cell. */
static void put_dot(const struct raster *raster, struct dot_grid grid, int column, int row)
{
    static const uint32_t bit[4][2] = {
        {0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}}; /* ISO 11548-1, Unicode U+2800 */
    static const uint32_t quadrant[16] = {' ',    0x2598, 0x259D, 0x2580, 0x2596, 0x258C,
                                          0x259E, 0x259B, 0x2597, 0x259A, 0x2590, 0x259C,
                                          0x2584, 0x2599, 0x259F, 0x2588};
    int x = column / grid.dots_horizontal, y = row / grid.dots_vertical,
        dot_column = column % grid.dots_horizontal, dot_row = row % grid.dots_vertical;
    uint32_t old = raster_get(raster, x, y);

    if (grid.dots_vertical == 4) {
        raster_put(raster, x, y,
                   (old >= 0x2800 && old <= 0x28FF ? old : 0x2800) | bit[dot_row][dot_column]);
        return;
    }
    /* Index of a quadrant character is the bit mask of its four dots. */
    unsigned mask = 0;
    for (unsigned i = 0; i < COUNT_OF(quadrant); i++)
        if (quadrant[i] == old)
            mask = i;
    raster_put(raster, x, y, quadrant[mask | 1U << (2 * dot_row + dot_column)]);
}

/* Draws the dots low..high (rows of dots, downwards) of a dot column; rows outside of the plot are
 * ignored. In ASCII or with a mark a cell gets one character: the mark, a stroke of the direction
 * `slope` (-1 upwards, 1 downwards to the right, 0 neither), or a level mark if at most two dots
 * are set. */
static void put_dot_span(const struct raster *raster, int column, int low, int high, int slope)
{
    struct dot_grid grid = raster->layout->charset->dots;
    int last = raster->layout->rows * grid.dots_vertical - 1, span = high - low + 1;
    int first_dot = low < 0 ? 0 : low;
    int last_dot = high > last ? last : high;

    if (raster->mark || grid.dots_horizontal == 1) {
        static const char level[] = "'-._";
        char stroke;
        /* Spans of more than one and a half cells look vertical. */
        if (span > 6 || !slope)
            stroke = '|';
        else
            stroke = slope < 0 ? '/' : '\\';
        for (int row = first_dot / grid.dots_vertical;
             first_dot <= last_dot && row <= last_dot / grid.dots_vertical; row++) {
            int first = first_dot > row * grid.dots_vertical ? first_dot : row * grid.dots_vertical;
            int final = last_dot < row * grid.dots_vertical + grid.dots_vertical - 1
                            ? last_dot
                            : row * grid.dots_vertical + grid.dots_vertical - 1;
            char glyph = final - first < 2 ? level[(first + final) / 2 % 4] : stroke;
            raster_put(raster, column / grid.dots_horizontal, row,
                       (uint32_t)(raster->mark ? raster->mark : glyph));
        }
        return;
    }
    for (int row = first_dot; row <= last_dot; row++)
        put_dot(raster, grid, column, row);
}

/* Pen that walks along a curve and draws each dot column when it leaves it. */
struct cell_pen {
    const struct raster *raster;
    int columns; /* number of dot columns of the plot */
    /* is_drawing is true while the pen is on the paper, starts if the curve begins in this column
     */
    bool is_drawing, starts;
    /* [dot] current column; -1 and `columns` stand for everything left and right of the plot */
    int column;
    int heading;      /* 1 while the curve goes to the right, -1 to the left */
    double enter;     /* [dot] where the curve came into the column, or starts */
    double low, high; /* [dot] extremes in this column */
    double x, y;      /* [dot] last point */
};

/* Returns the dot column of position x, -1 or pen->columns if it is beside the plot. */
static int pen_column(const struct cell_pen *pen, double x)
{
    if (x < -0.5)
        return -1;
    return x >= pen->columns - 0.5 ? pen->columns : (int)(x + 0.5);
}

/* Draws the current column: the curve leaves it at height y, or ends there if `ends`. */
static void pen_leave(struct cell_pen *pen, double y, bool ends)
{
    double y_enter = pen->starts ? NAN : pen->enter;
    double y_leave = ends ? NAN : y;
    double border_min = fmin(y_enter, y_leave),
           border_max = fmax(y_enter, y_leave); /* heights where the borders are crossed */
    /* Draws the dots in the interval between the ways in and out. An extreme beyond them is rounded
     * to its dot. */
    double low = border_min <= pen->low ? ceil(border_min) : floor(pen->low + 0.5);
    double high = border_max >= pen->high ? floor(border_max) : floor(pen->high + 0.5);

    if (pen->column < 0 || pen->column >= pen->columns)
        return;
    if (low > high)
        low = high = floor((pen->low + pen->high) / 2 + 0.5);
    double rise = y - pen->enter;
    int slope;
    if (2 * fabs(rise) < pen->high - pen->low)
        slope = 0;
    else
        slope = rise < 0 ? -pen->heading : pen->heading;
    put_dot_span(pen->raster, pen->column, (int)low, (int)high, slope);
}

/* Begins a column at height y, with the pen on the paper. */
static void pen_enter(struct cell_pen *pen, int column, double y)
{
    pen->column = column;
    pen->enter = pen->low = pen->high = y;
    pen->starts = !pen->is_drawing;
    pen->is_drawing = true;
}

/* Ends the line at the last point and lifts the pen. */
static void pen_up(struct cell_pen *pen)
{
    if (pen->is_drawing)
        pen_leave(pen, pen->y, true);
    pen->is_drawing = false;
}

/* Continues the line to (x, y), or begins one there. Every column on the way is drawn, with the
 * height at which the segment crosses its border interpolated. */
static void pen_draw_to(struct cell_pen *pen, double x, double y)
{
    if (!pen->is_drawing) {
        pen_enter(pen, pen_column(pen, x), y);
    } else {
        int target = pen_column(pen, x);
        while (pen->column != target) {
            pen->heading = target > pen->column ? 1 : -1;
            double part = (pen->column + 0.5 * pen->heading - pen->x) / (x - pen->x);
            double crossing = pen->y + part * (y - pen->y);
            pen->low = fmin(pen->low, crossing);
            pen->high = fmax(pen->high, crossing);
            pen_leave(pen, crossing, false);
            pen_enter(pen, pen->column + pen->heading, crossing);
        }
    }
    pen->low = y < pen->low ? y : pen->low;
    pen->high = y > pen->high ? y : pen->high;
    pen->x = x;
    pen->y = y;
}

/* Draws a curve as a line of dots or marks; NAN interrupts it, and a cloud is lifted after every
 * point. */
void raster_line(const struct raster *raster, const struct curve *curve)
{
    const struct figure_layout *layout = raster->layout;
    struct dot_grid grid = layout->charset->dots;
    double width = layout->columns * grid.dots_horizontal - 1,
           height = layout->rows * grid.dots_vertical - 1;
    struct cell_pen pen = {
        .raster = raster, .columns = layout->columns * grid.dots_horizontal, .heading = 1};

    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        double x = fraction_of(&layout->x, curve->x[i]), y = fraction_of(&layout->y, curve->y[i]);
        if (isnan(x) || isnan(y))
            pen_up(&pen);
        else
            pen_draw_to(&pen, x * width, (1 - y) * height);
        if (curve->cloud)
            pen_up(&pen);
    }
    pen_up(&pen);
}

/* Computes the rows [dot] of the upper and the lower edge of the band at sample i. */
static void band_edges(const struct raster *raster, const struct curve *curve, size_t i,
                       double edge[2])
{
    const struct figure_layout *layout = raster->layout;
    const double height = layout->rows * layout->charset->dots.dots_vertical - 1;
    edge[0] = (1 - fraction_of(&layout->y, curve->y[i] + curve->spread[i])) * height;
    edge[1] = (1 - fraction_of(&layout->y, curve->y[i] - curve->spread[i])) * height;
}

/* Fills the cells of a column between two heights [dot], unless they are less than a dot apart. */
static void fill_cells(const struct raster *raster, int column, double low, double high)
{
    const struct figure_layout *layout = raster->layout;
    const int dots_per_cell = layout->charset->dots.dots_vertical;
    const double last = layout->rows * dots_per_cell - 1;
    /* thinner than the line itself, or outside of the plot */
    if (!(low <= last && high >= 0 && high - low >= 1))
        return;
    for (int row = (int)(fmax(low, 0) + 0.5) / dots_per_cell;
         row <= (int)(fmin(high, last) + 0.5) / dots_per_cell; row++)
        raster_put(raster, column, row, raster->fill);
}

/* Fills the band of a curve column by column, with its edges interpolated between samples. */
void raster_band(const struct raster *raster, const struct curve *curve)
{
    const double width = raster->layout->columns - 1;
    double previous_x = NAN, previous_edge[2] = {NAN, NAN}, edge[2];
    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        const double x = fraction_of(&raster->layout->x, curve->x[i]) * width;
        band_edges(raster, curve, i, edge);
        if (isfinite(x + previous_x + edge[0] + edge[1] + previous_edge[0] + previous_edge[1]))
            for (int c = (int)fmax(ceil(previous_x - 0.5), 0);
                 c <= (int)fmin(floor(x + 0.5), width); c++) {
                const double part =
                    x > previous_x ? fmin(fmax((c - previous_x) / (x - previous_x), 0), 1) : 1;
                fill_cells(raster, c, previous_edge[0] + part * (edge[0] - previous_edge[0]),
                           previous_edge[1] + part * (edge[1] - previous_edge[1]));
            }
        previous_x = isfinite(x) ? x : NAN;
        memcpy(previous_edge, edge, sizeof previous_edge);
    }
}

/* Draws a guide: a line of dots, or a filled rectangle if it is an area. */
void raster_guide(const struct raster *raster, const struct figure_guide *guide)
{
    const struct figure_layout *layout = raster->layout;
    const struct curve line = {.x = guide->x, .y = guide->y, .n = 2};
    int column[2], row[2];
    if (!guide->area) {
        raster_line(raster, &line);
        return;
    }
    for (int i = 0; i < 2; i++)
        if (!figure_cell(layout, guide->x[i], guide->y[i], &column[i], &row[i]))
            return;
    for (int y = row[0] < row[1] ? row[0] : row[1]; y <= (row[0] < row[1] ? row[1] : row[0]); y++)
        for (int x = column[0]; x <= column[1]; x++)
            raster_put(raster, x, y, raster->fill);
}

/* Draws marks at points, except at those nearer than `apart` columns to the previous mark; a row
 * counts as two columns, because cells are about twice as high as wide. */
void raster_points(const struct raster *raster, const struct curve *curve, int apart)
{
    int seen = 0, last_column = 0, last_row = 0, column, row;

    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        if (!figure_cell(raster->layout, curve->x[i], curve->y[i], &column, &row))
            continue;
        int columns_apart = column > last_column ? column - last_column : last_column - column;
        int rows_apart = row > last_row ? row - last_row : last_row - row;
        if (seen++ && columns_apart + 2 * rows_apart < apart)
            continue;
        last_column = column;
        last_row = row;
        raster_put(raster, column, row, (uint32_t)raster->mark);
    }
}

/* Draws each arrow of the curve (two points between NANs) as an arrow character in its middle. */
void raster_arrows(const struct raster *raster, const struct curve *curve)
{
    /* Eight directions from the right, counterclockwise; ASCII has only four of them. */
    static const uint32_t arrow[] = {0x2192, 0x2197, 0x2191, 0x2196,
                                     0x2190, 0x2199, 0x2193, 0x2198};
    static const char plain[] = ">^<v";
    const struct figure_layout *layout = raster->layout;
    const double eighth = acos(-1) / 4;
    for (size_t i = 0; i + 1 < curve->n; i++) {
        int column, row;
        if ((i > 0 && !isnan(curve->x[i - 1])) || isnan(curve->x[i]) || isnan(curve->x[i + 1]) ||
            !figure_cell(layout, (curve->x[i] + curve->x[i + 1]) / 2,
                         (curve->y[i] + curve->y[i + 1]) / 2, &column, &row))
            continue;
        const double x = fraction_of(&layout->x, curve->x[i + 1]) -
                         fraction_of(&layout->x, curve->x[i]),
                     y = fraction_of(&layout->y, curve->y[i + 1]) -
                         fraction_of(&layout->y, curve->y[i]);
        const double turn = atan2(2 * layout->rows * y, layout->columns * x) / eighth;
        const bool lines = layout->charset->plain;
        const int mask = lines ? 3 : 7;
        const int arrow_index = (int)floor((lines ? turn / 2 : turn) + 0.5) & mask;
        raster_put(raster, column, row, lines ? (uint32_t)plain[arrow_index] : arrow[arrow_index]);
    }
}

/* Finds, for each side of the plot, the point at which the curve first leaves through it; a curve
 * over an independent variable leaves only through bottom and top. Returns false if it stays
 * inside. */
bool curve_exits(const struct figure *figure, const struct figure_layout *layout, int index,
                 struct curve_exit exits[4])
{
    const struct curve *curve = &figure->curve[index];
    struct curve_outside outside;
    bool inside = false;
    double old_x = 0, old_y = 0;

    curve_outside(figure, layout, index, &outside);
    memset(exits, 0, 4 * sizeof *exits);
    if (!outside.leaves || curve->points)
        return false;
    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        double x = fraction_of(&layout->x, curve->x[i]), y = fraction_of(&layout->y, curve->y[i]);
        double old_excess[4] = {-old_x, old_x - 1, -old_y, old_y - 1},
               excess[4] = {-x, x - 1, -y, y - 1}; /* positive beyond a border */
        int side = -1;
        double part = 2; /* fraction of the segment up to the first border that it crosses */
        for (int s = 0; s < 4 && inside && !isnan(x + y); s++) {
            if (excess[s] > 0 && old_excess[s] / (old_excess[s] - excess[s]) < part) {
                part = old_excess[s] / (old_excess[s] - excess[s]);
                side = s;
            }
        }
        if (side >= (figure->plane ? 0 : 2) && !exits[side].left)
            exits[side] =
                (struct curve_exit){true, old_x + part * (x - old_x), old_y + part * (y - old_y)};
        inside = x >= 0 && x <= 1 && y >= 0 && y <= 1;
        old_x = x;
        old_y = y;
    }
    return true;
}

/* Draws an arrow on each border through which the curve leaves, at the first exit. */
void raster_exits(const struct raster *raster, const struct figure *figure, int curve)
{
    /* Order of the sides: left, right, bottom, top. */
    static const uint32_t arrow[2][4] = {{'<', '>', 'v', '^'}, {0x2190, 0x2192, 0x2193, 0x2191}};
    const struct figure_layout *layout = raster->layout;
    struct curve_exit exits[4];

    if (!curve_exits(figure, layout, curve, exits))
        return;
    for (int side = 0; side < 4; side++) {
        int column = (int)(exits[side].x * (layout->columns - 1) + 0.5);
        int row = (int)((1 - exits[side].y) * (layout->rows - 1) + 0.5);
        if (exits[side].left)
            raster_put(raster, column, row, arrow[layout->charset != &charset_ascii][side]);
    }
}
