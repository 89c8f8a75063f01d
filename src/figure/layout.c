/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Layout of a figure in a rectangle of cells: whether there is room for a frame and labels, the
 * ranges and ticks of the axes, and the division into two panels. */
#include <hooke/base/catalog.h>
#include "figure/internal.h"

#define MIN_ROWS 3     /* rows of the plot below which the x labels are left out */
#define MIN_COLUMNS 10 /* columns of the plot below which the y labels are left out */
#define TICK_GAP 2     /* [cell] least distance between two x labels */

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

/* Returns the cell in which a position along an axis is, given as a fraction of the axis of `cells`
 * cells with `dots` dots each. The ends of the axis are the first and the last dot. */
static int cell_index(double fraction, int cells, int dots)
{
    return (int)(floor(fraction * (cells * dots - 1) + 0.5) / dots);
}

/* Finds the cell of the plot that contains the point (x, y). Returns false if the point is outside
 * of the range of either axis. */
bool figure_cell(const struct figure_layout *layout, double x, double y, int *column, int *row)
{
    double x_fraction = scale_fraction(&layout->x, x), y_fraction = scale_fraction(&layout->y, y);
    double edge = 1e-9; /* allowance for rounding */
    struct dot_grid grid = layout->charset->dots;

    if (!(x_fraction >= -edge && x_fraction <= 1 + edge && y_fraction >= -edge &&
          y_fraction <= 1 + edge))
        return false;
    *column = cell_index(x_fraction, layout->columns, grid.dots_horizontal);
    *row = cell_index(1 - y_fraction, layout->rows, grid.dots_vertical);
    return true;
}

/* Returns true if the labels of an axis are powers of ten: it is logarithmic and its range contains
 * at least two. */
static bool has_decades(const struct scale *scale, const struct axis *axis)
{
    return scale->log && ticks_log(scale->first_value / axis_factor(axis),
                                   scale->last_value / axis_factor(axis), 1000)
                                 .count > 1;
}

/* Returns at most `max` ticks, about `want`, for an axis, in the numbers that its labels show
 * (value / factor). */
static struct ticks axis_ticks(const struct scale *scale, const struct axis *axis, bool decades,
                               int want, int max)
{
    double low = scale->first_value / axis_factor(axis),
           high = scale->last_value / axis_factor(axis);
    if (scale->log && !(low > 0)) /* division by the factor has rounded the lower end to 0 */
        return (struct ticks){0};
    const int wanted = want < max ? want : max;
    return decades ? ticks_log(low, high, max) : ticks_linear(low, high, wanted, max);
}

/* Returns the width [cell] of the widest label of an axis. */
static int widest_label(const struct ticks *ticks, bool decades)
{
    char text[TICK_TEXT_SIZE];
    int width = 0;
    for (int i = 0; i < ticks->count; i++)
        width = larger(width, tick_text(ticks, i, decades, text));
    return width;
}

int x_tick_column(const struct figure *figure, const struct figure_layout *layout, int i)
{
    double value = tick_value(&layout->x_ticks, i, layout->x_decades) * axis_factor(&figure->x);
    return cell_index(scale_fraction(&layout->x, value), layout->columns,
                      layout->charset->dots.dots_horizontal);
}

int x_label_start(const struct figure_layout *layout, int column, int len)
{
    return larger(smaller(column - len / 2, layout->columns - len), layout->frame - layout->left);
}

/* Returns true if the x labels fit into the plot without touching each other. */
static bool x_labels_fit(const struct figure *figure, const struct figure_layout *layout)
{
    char text[TICK_TEXT_SIZE];
    int end = -layout->left - TICK_GAP;
    for (int i = 0; i < layout->x_ticks.count; i++) {
        int len = tick_text(&layout->x_ticks, i, layout->x_decades, text);
        int start = x_label_start(layout, x_tick_column(figure, layout, i), len);
        if (start < end + TICK_GAP || start + len > layout->columns)
            return false;
        end = start + len;
    }
    return true;
}

/* Returns true if each label of the y axis has a row of its own. */
static bool y_labels_fit(const struct figure *figure, const struct figure_layout *layout)
{
    int column, row, previous_row = layout->rows;
    for (int i = 0; i < layout->y_ticks.count; i++) {
        double value = tick_value(&layout->y_ticks, i, layout->y_decades) * axis_factor(&figure->y);
        if (!figure_cell(layout, layout->x.first_value, value, &column, &row) ||
            row >= previous_row)
            return false;
        previous_row = row;
    }
    return true;
}

/* Chooses the ticks of the vertical or horizontal axis, about `want` and at most `max`, and reduces
 * their number until no two labels meet. Where only one would remain, the first and the last of the
 * previous attempt are taken instead. */
static void fit_ticks(const struct figure *figure, struct figure_layout *layout, bool vertical,
                      int want, int max)
{
    const struct axis *axis = vertical ? &figure->y : &figure->x;
    const struct scale *scale = vertical ? &layout->y : &layout->x;
    struct ticks *ticks = vertical ? &layout->y_ticks : &layout->x_ticks, finer = {0};
    bool decades = has_decades(scale, axis);

    *(vertical ? &layout->y_decades : &layout->x_decades) = decades;
    do {
        *ticks = axis_ticks(scale, axis, decades, want, max);
        if (ticks->count < 2 && finer.count > 2) {
            *ticks = finer;
            ticks->step *= finer.count - 1;
            ticks->count = 2;
        }
        finer = *ticks;
        max = smaller(max, ticks->count) - 1;
    } while (ticks->count && !(vertical ? y_labels_fit : x_labels_fit)(figure, layout));
}

/* Extends the range of one axis about its middle until a unit has the same length on both axes.
 * Lengths are in columns of characters; a row is `aspect` columns high. Does nothing if a range
 * would exceed RANGE_VALUE_MAX. */
static void equalise_axes(const struct figure *figure, struct figure_layout *layout)
{
    struct dot_grid grid = layout->charset->dots;
    double aspect = figure->aspect > 0 ? figure->aspect : 2;
    double width = fmax(layout->columns - 1.0 / grid.dots_horizontal, 0.5);
    double height = aspect * fmax(layout->rows - 1.0 / grid.dots_vertical, 0.5);
    double x_factor = axis_factor(&figure->x), y_factor = axis_factor(&figure->y);
    double x_half = layout->x.last_value / 2 - layout->x.first_value / 2,
           y_half = layout->y.last_value / 2 - layout->y.first_value / 2;
    double unit = fmax(x_half / x_factor / width, y_half / y_factor / height);
    double x_middle = layout->x.first_value / 2 + layout->x.last_value / 2,
           y_middle = layout->y.first_value / 2 + layout->y.last_value / 2;

    x_half = unit * width * x_factor;
    y_half = unit * height * y_factor;
    if (x_half + fabs(x_middle) > RANGE_VALUE_MAX || y_half + fabs(y_middle) > RANGE_VALUE_MAX)
        return;
    layout->x = scale_of(x_middle - x_half, x_middle + x_half, false);
    layout->y = scale_of(y_middle - y_half, y_middle + y_half, false);
}

/* Chooses the ranges and ticks of both axes for the plot's layout->columns x layout->rows cells and
 * for curves of extents x and y. */
void layout_scales(const struct figure *figure, struct figure_layout *layout, struct extent x,
                   struct extent y)
{
    /* Labels are wanted every 12 columns and every 4 rows; at most every 4 columns and every 2
     * rows. */
    int x_want = 2 + (layout->columns + 4) / 12, y_want = 2 + (layout->rows + 1) / 4;
    int x_max = larger(layout->columns / 4, 1), y_max = larger((layout->rows + 1) / 2, 3);

    layout->x = axis_scale(figure, false, x, x_want, x_max);
    layout->y = axis_scale(figure, true, y, y_want, y_max);
    if (figure->equal && !layout->x.log && !layout->y.log)
        equalise_axes(figure, layout);
    fit_ticks(figure, layout, true, y_want, y_max);
    fit_ticks(figure, layout, false, x_want, x_max);
}

/* Chooses what is drawn of a figure in width x height cells, from 1x1 up: frame, labels, width of
 * the y labels (gutter), ranges and ticks. */
void figure_layout(const struct figure *figure, int width, int height,
                   const struct charset *charset, struct figure_layout *layout)
{
    bool frame = width >= 8 && height >= (figure->part ? 3 : 4);
    bool x_labels = frame && height >= (figure->part ? 1 : MIN_ROWS) + 4;

    struct extent x = axis_extent(figure, false, false), y = axis_extent(figure, true, false);

    *layout = (struct figure_layout){
        .charset = charset,
        .frame = frame,
        .x_labels = x_labels,
        .y_labels = x_labels,
        .gutter = larger(figure->gutter, 1),
        .top = frame,
        .hidden = x.hidden + y.hidden,
        .rows = larger(height - 2 * frame - 2 * x_labels, 1),
    };
    /* Repeats until the widest y label fits, because the gutter depends on the labels, the labels
     * on the ranges, and the ranges of equal axes on the gutter. */
    for (;;) {
        layout->left = frame + (layout->y_labels ? layout->gutter + 2 : 0);
        layout->columns = larger(width - layout->left - frame - layout->y_labels, 1);
        if (layout->y_labels && layout->columns < MIN_COLUMNS) {
            layout->y_labels = false;
            continue;
        }
        layout_scales(figure, layout, x, y);
        int need = widest_label(&layout->y_ticks, layout->y_decades);
        if (!layout->y_labels || need <= layout->gutter)
            break;
        layout->gutter = need;
    }
}

/* ---- panels ---- */

#define FRAME_ROWS 2  /* [cell] upper and lower frame */
#define LABEL_ROWS 2  /* [cell] axis and labels below the plot */
#define LABEL_CELLS 8 /* [cell] frame and labels beside the plot */

/* Places two panels that share an x axis one above the other in one frame: the lower panel overlaps
 * and hides the labels and the lower frame of the upper one. Both get the wider gutter, so that
 * their axes align. Returns false if there are too few cells. */
static bool stack_panels(const struct figure *figure, int width, int height,
                         const struct charset *charset, struct figure_panel panel[PANELS_MAX])
{
    int label_rows = LABEL_ROWS, rows = height - FRAME_ROWS - 1 - label_rows;
    if (rows < PANELS_MAX) { /* too low for labels */
        label_rows = 0;
        rows = height - FRAME_ROWS - 1;
    }
    if (rows < PANELS_MAX || width < 8)
        return false;
    int upper = (rows + 1) / 2, gutter = figure->gutter;
    panel[0].height = 1 + upper + label_rows + 1;
    panel[1].y = 1 + upper;
    panel[1].height = height - panel[1].y;
    for (int i = 0; i < PANELS_MAX; i++) {
        struct figure_layout layout;
        figure_layout(&panel[i].figure, width, panel[i].height, charset, &layout);
        gutter = larger(gutter, layout.gutter);
    }
    panel[0].figure.gutter = panel[1].figure.gutter = gutter;
    return true;
}

/* Returns the side [cell of height] of the largest square plot that fits into width x height cells
 * with its frame and labels; aspect is height over width of a cell. */
static double largest_square(int width, int height, double aspect)
{
    return fmin((width - LABEL_CELLS) / aspect, height - FRAME_ROWS - LABEL_ROWS);
}

/* Returns true if the two panels of a plane become larger side by side than one below the other. */
bool planes_across(const struct figure *figure, int width, int height)
{
    double aspect = figure->aspect > 0 ? figure->aspect : 2;
    return largest_square(width / 2, height, aspect) > largest_square(width, height / 2, aspect);
}

/* Places the two panels of a plane side by side or one below the other, whichever gives larger
 * plots. Returns false if there are too few cells. */
static bool arrange_planes(const struct figure *figure, int width, int height,
                           struct figure_panel panel[PANELS_MAX])
{
    const bool side_by_side = planes_across(figure, width, height);
    const int plane_width = side_by_side ? width / 2 : width;
    const int plane_height = side_by_side ? height : height / 2;
    if (plane_width < LABEL_CELLS || plane_height < FRAME_ROWS + 1)
        return false;
    panel[0].width = side_by_side ? width - width / 2 : width;
    panel[0].height = side_by_side ? height : height - height / 2;
    panel[1].x = side_by_side ? panel[0].width : 0;
    panel[1].y = side_by_side ? 0 : panel[0].height;
    panel[1].width = width - panel[1].x;
    panel[1].height = height - panel[1].y;
    return true;
}

/* Makes a figure of each panel, with its own y axis, for drawing it alone. Title and caption go to
 * the first panel. Returns the number of panels, 1 or 2. */
int figure_parts(const struct figure *figure, struct figure part[PANELS_MAX])
{
    part[0] = *figure;
    part[0].second = NULL;
    if (!figure->second)
        return 1;
    for (int i = 0; i < PANELS_MAX; i++) {
        part[i] = part[0];
        part[i].panel = i;
        part[i].part = true;
        part[i].has_point = figure->has_point && figure->curves > 0 && figure->curve[0].panel == i;
    }
    part[1].x = figure->second[0];
    part[1].y = figure->second[1];
    part[1].title = "";
    part[1].caption = NULL;
    /* Only one panel has the note: the lower one where both share an x axis, because the other has
     * no lower frame. */
    part[figure->plane ? 1 : 0].note = NULL;
    return PANELS_MAX;
}

/* Divides width x height cells among the panels of a figure. Returns the number of panels, 1 if
 * there is no room for two: then all curves share the axes of the first. */
int figure_panels(const struct figure *figure, int width, int height, const struct charset *charset,
                  struct figure_panel panel[PANELS_MAX])
{
    struct figure part[PANELS_MAX];
    int parts = figure_parts(figure, part);

    for (int i = 0; i < parts; i++)
        panel[i] = (struct figure_panel){.figure = part[i], .width = width, .height = height};
    if (parts > 1 && (figure->plane ? arrange_planes(figure, width, height, panel)
                                    : stack_panels(figure, width, height, charset, panel)))
        return parts;
    panel[0].figure = *figure; /* too few cells for two: the first axes hold for all curves */
    panel[0].figure.second = NULL;
    return 1;
}
