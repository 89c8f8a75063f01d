/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws figures into cells: the frame, titles, legend and axes of each panel, then its curves by
 * the functions of raster.c. figure_draw() is the entry, figure_print() writes a figure as lines of
 * text. */
#include <hooke/base/safe_text.h>
#include "figure/internal.h"

#include <stdio.h>

/* Characters of frames, axes and marks. Box characters are code points, because alternate character
 * sets break in captures and in mosh. */
struct strokes {
    uint32_t top_left, top_right, bottom_left, bottom_right, horizontal, vertical, x_tick, y_tick,
        origin, zero, point, band;
};

/* Returns the strokes of a charset: ASCII if it is plain, else box characters. */
static const struct strokes *charset_strokes(const struct charset *charset)
{
    static const struct strokes plain = {'+', '+', '+', '+', '-', '|',
                                         '+', '+', '+', '-', '@', ':'};
    static const struct strokes box = {0x250C, 0x2510, 0x2514, 0x2518, 0x2500, 0x2502,
                                       0x252C, 0x2524, 0x2514, 0x2508, 0x25CF, 0x2591};
    return charset->plain ? &plain : &box;
}

/* A panel being drawn: its figure, layout, and rectangle on the canvas. */
struct text_sheet {
    const struct figure *figure;
    const struct figure_layout *layout;
    const struct strokes *strokes;
    struct canvas *canvas;
    int x, y, width, height; /* [cell] the rectangle, with the frame */
};

/* Returns the character that draws curve i, or 0 for dots: the first line has dots, every other
 * curve a mark of its own, so that no curve is identified by colour alone. */
char figure_mark(const struct figure *figure, int i)
{
    static const char lines[] = "#x+%", points[] = "o*&=";
    const struct curve *curve = &figure->curve[i];
    size_t earlier_curves = 0;

    if (curve->mark)
        return curve->mark;
    for (int c = 0; c < i; c++)
        earlier_curves += figure->curve[c].points == curve->points && !figure->curve[c].mark;
    if (curve->cloud)
        return '.';
    if (curve->points)
        return points[earlier_curves % (sizeof points - 1)];
    return earlier_curves ? lines[(earlier_curves - 1) % (sizeof lines - 1)] : 0;
}

/* Returns the colour of curve i. */
static enum style curve_style(const struct figure *figure, int i)
{
    const int look = figure->curve[i].look;
    return (enum style)(STYLE_CURVE_1 + (look ? look - 1 : i) % 4);
}

/* Draws a frame along the border of the rectangle. */
static void draw_frame(const struct text_sheet *sheet)
{
    const struct strokes *s = sheet->strokes;
    int right = sheet->x + sheet->width - 1, bottom = sheet->y + sheet->height - 1;

    for (int x = sheet->x; x <= right; x++) {
        canvas_put(sheet->canvas, x, sheet->y, s->horizontal, STYLE_DIM);
        canvas_put(sheet->canvas, x, bottom, s->horizontal, STYLE_DIM);
    }
    for (int y = sheet->y; y <= bottom; y++) {
        canvas_put(sheet->canvas, sheet->x, y, s->vertical, STYLE_DIM);
        canvas_put(sheet->canvas, right, y, s->vertical, STYLE_DIM);
    }
    canvas_put(sheet->canvas, sheet->x, sheet->y, s->top_left, STYLE_DIM);
    canvas_put(sheet->canvas, right, sheet->y, s->top_right, STYLE_DIM);
    canvas_put(sheet->canvas, sheet->x, bottom, s->bottom_left, STYLE_DIM);
    canvas_put(sheet->canvas, right, bottom, s->bottom_right, STYLE_DIM);
}

/* Writes " text " on the frame from column x on, cut off before column `end`; nothing if there is
 * no room for a letter. Returns the column after it. */
static int frame_text(const struct text_sheet *sheet, int x, int end, int y, struct text text,
                      enum style style)
{
    if (!text.len || end - x < 3)
        return x;
    canvas_put(sheet->canvas, x++, y, ' ', STYLE_PLAIN);
    bool cut;
    x = canvas_text(sheet->canvas, x, y, text_in_room(text, end - x - 1, &cut), style);
    canvas_put(sheet->canvas, x++, y, ' ', STYLE_PLAIN);
    return x;
}

/* Appends a word, after a blank if it is not the first; nothing if it is empty. */
static void put_word(struct buffer *text, const char *word)
{
    buffer_put(text, *word && text->len ? TEXT(" ") : TEXT(""));
    buffer_put(text, text_of(word));
}

/* Writes the title of an axis to title_text: "title y [1e-6 m]" or, with an offset,
 * "title y - 2.2326 m [1e-6 m]". An empty title or label is left out. */
static void axis_title(const struct axis *axis, const struct ticks *ticks, const char *title,
                       char *title_text, size_t size)
{
    const char *label = axis->label ? axis->label : "";
    const char *unit = axis->unit ? axis->unit : "";
    char power[16] = "", offset[TICK_TEXT_SIZE] = "";
    struct buffer text = {0};

    buffer_put(&text, text_of(title));
    if (ticks->exponent)
        snprintf(power, sizeof power, "1e%d%s", ticks->exponent, *unit ? " " : "");
    if (ticks->offset != 0)
        offset_text(ticks, offset);
    if (!text_equal(text_of(title), text_of(label))) /* a title that is the label: "error [m]" */
        put_word(&text, label);
    put_word(&text, offset);
    if (*offset)
        put_word(&text, unit);
    if (*power || *unit) {
        put_word(&text, "[");
        buffer_format(&text, "%s%s]", power, unit);
    }
    snprintf(title_text, size, "%s", text.len && !text.failed ? text.data : "");
    buffer_free(&text);
}

/* Returns true if the legend names the curve: it is drawn and has a label. */
static bool has_legend_entry(const struct figure *figure, int curve)
{
    return curve_drawn(figure, curve) && figure->curve[curve].label && *figure->curve[curve].label;
}

/* Returns the width [cell] of a curve's entry in the legend behind `used` cells: gap, mark, label.
 */
static int legend_entry_width(const struct figure *figure, int i, int used)
{
    if (!has_legend_entry(figure, i))
        return 0;
    return text_width(text_of(figure->curve[i].label)) + (figure_mark(figure, i) ? 2 : 3) +
           (used ? 2 : 0);
}

const struct curve *figure_band(const struct figure *figure)
{
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].spread && figure->curve[i].spread_label)
            return &figure->curve[i];
    return NULL;
}

/* Returns the width [cell] of all entries of the legend. */
static int legend_width(const struct figure *figure)
{
    int width = 0;
    for (int i = 0; i < figure->curves; i++)
        width += legend_entry_width(figure, i, width);
    return width;
}

/* Draws the legend ("-- verlet # euler o data"), the name of a band and the caption at the right
 * end of the upper frame, as many of them as fit right of column `min_column`. */
static void draw_legend(const struct text_sheet *sheet, int min_column)
{
    const struct figure *figure = sheet->figure;
    int right = sheet->x + sheet->width - 2, available = right - min_column - 3, used = 0,
        shown = 0;
    struct text caption = text_of(figure->caption);

    for (; shown < figure->curves; shown++) {
        const int width = legend_entry_width(figure, shown, used);
        if (used + width > available)
            break;
        used += width;
    }
    const struct curve *band = shown < figure->curves ? NULL : figure_band(figure);
    const int band_width = band ? text_width(text_of(band->spread_label)) + 2 : 0;
    const int band_end = used + band_width + (band && used ? 2 : 0);
    band = band_end <= available ? band : NULL;
    used = band ? band_end : used;
    if (shown < figure->curves || used + (used ? 2 : 0) + text_width(caption) > available)
        caption = TEXT("");
    used += text_width(caption) + (used && caption.len ? 2 : 0);
    if (!used)
        return;

    int x = right - used - 1, y = sheet->y;
    canvas_put(sheet->canvas, x - 1, y, ' ', STYLE_PLAIN);
    for (int end = right - 1, column = x; column <= end; column++)
        canvas_put(sheet->canvas, column, y, ' ', STYLE_PLAIN);
    for (int i = 0; i < shown; i++) {
        const struct curve *curve = &figure->curve[i];
        char mark = figure_mark(figure, i);
        if (!has_legend_entry(figure, i))
            continue;
        x = canvas_text(sheet->canvas, x, y, mark ? (struct text){&mark, 1} : TEXT("--"),
                        curve_style(figure, i));
        x = canvas_text(sheet->canvas, x + 1, y, text_of(curve->label), STYLE_PLAIN) + 2;
    }
    if (band) {
        canvas_put(sheet->canvas, x, y, sheet->strokes->band, STYLE_DIM);
        x = canvas_text(sheet->canvas, x + 2, y, text_of(band->spread_label), STYLE_PLAIN) + 2;
    }
    canvas_text(sheet->canvas, x, y, caption, STYLE_PLAIN);
}

/* Appends the scale of a map's shades, "0.1 [ .:-=+*%@#] 2.3 cm". */
static void put_heat_scale(const struct heat *heat, const struct charset *charset,
                           struct buffer *output)
{
    const struct heat_scale scale = heat_scale_of(heat);
    const double factor = heat->factor > 0 ? heat->factor : 1;
    const uint32_t *shade;
    const int shades = heat_shades(charset, &shade);
    if (!(scale.low <= scale.high) || heat->letters)
        return;
    buffer_format(output, "%.4g [", scale.low / factor);
    for (int i = 0; i < shades; i++)
        buffer_codepoint(output, shade[i]);
    buffer_format(output, "] %.4g%s%s", scale.high / factor, *heat->unit ? " " : "", heat->unit);
    buffer_put(output, scale.log ? TEXT(", logarithmic") : TEXT(""));
}

/* Writes title, y axis and legend on the upper frame, the note and the x axis on the lower one. The
 * figure's title is left out if there is no room for both. */
static void draw_titles(const struct text_sheet *sheet)
{
    const struct figure *figure = sheet->figure;
    int left = sheet->x + 2, right = sheet->x + sheet->width - 2,
        bottom = sheet->y + sheet->height - 1;
    char text[256];
    struct buffer title = {0}, note = {0};

    axis_title(&figure->y, &sheet->layout->y_ticks, figure->title ? figure->title : "", text,
               sizeof text);
    if (text_width(text_of(text)) > right - left - 2) /* the axis matters more */
        axis_title(&figure->y, &sheet->layout->y_ticks, "", text, sizeof text);
    if (figure->part && text_width(text_of(text)) + legend_width(figure) + 10 >
                            sheet->width) /* both share a frame */
        axis_title(&figure->y, &sheet->layout->y_ticks, "", text, sizeof text);
    bool cut;
    const struct text fits = text_in_room(text_of(text), right - left - 2, &cut);
    buffer_put(&title,
               cut && figure->title && fits.data[fits.len] != ' ' ? text_of(figure->title) : fits);
    if (figure->part &&
        /* a single row has no labels: the title gets the range */
        sheet->layout->y_ticks.count < 2) {
        const struct scale *y = &sheet->layout->y;
        const double factor = axis_factor(&figure->y);
        buffer_format(&title, " %.2g..%.2g", y->first_value / factor, y->last_value / factor);
    }
    draw_legend(sheet, frame_text(sheet, left, right, sheet->y, buffer_text(&title), STYLE_PLAIN));
    buffer_free(&title);

    axis_title(&figure->x, &sheet->layout->x_ticks, "", text, sizeof text);
    int start = right - text_width(text_of(text)) - 2;
    frame_text(sheet, start < left ? left : start, right, bottom, text_of(text), STYLE_PLAIN);
    if (figure->heat)
        put_heat_scale(figure->heat, sheet->layout->charset, &note);
    else
        figure_note(figure, sheet->layout, start - left - 3, &note);
    frame_text(sheet, left, start - 1, bottom, buffer_text(&note), STYLE_PLAIN);
    buffer_free(&note);
}

/* Draws the x axis below the plot, with ticks and labels. */
static void draw_x_axis(const struct text_sheet *sheet)
{
    const struct figure_layout *layout = sheet->layout;
    int x = sheet->x + layout->left, y = sheet->y + layout->top + layout->rows;
    char text[TICK_TEXT_SIZE];

    for (int column = layout->y_labels ? -1 : 0; column < layout->columns; column++)
        canvas_put(sheet->canvas, x + column, y,
                   column < 0 ? sheet->strokes->origin : sheet->strokes->horizontal, STYLE_DIM);
    for (int i = 0; i < layout->x_ticks.count; i++) {
        int column = x_tick_column(sheet->figure, layout, i);
        int len = tick_text(&layout->x_ticks, i, layout->x_decades, text);
        canvas_put(sheet->canvas, x + column, y, sheet->strokes->x_tick, STYLE_DIM);
        canvas_text(sheet->canvas, x + x_label_start(layout, column, len), y + 1, text_of(text),
                    STYLE_PLAIN);
    }
}

/* Draws the y axis left of the plot, with ticks and labels. */
static void draw_y_axis(const struct text_sheet *sheet)
{
    const struct figure_layout *layout = sheet->layout;
    int x = sheet->x + layout->left - 1, y = sheet->y + layout->top, column, row;
    char text[TICK_TEXT_SIZE];

    for (row = 0; row < layout->rows; row++)
        canvas_put(sheet->canvas, x, y + row, sheet->strokes->vertical, STYLE_DIM);
    for (int i = 0; i < layout->y_ticks.count; i++) {
        double value =
            tick_value(&layout->y_ticks, i, layout->y_decades) * axis_factor(&sheet->figure->y);
        int len = tick_text(&layout->y_ticks, i, layout->y_decades, text);
        if (!figure_cell(layout, layout->x.first_value, value, &column, &row))
            continue;
        canvas_put(sheet->canvas, x, y + row, sheet->strokes->y_tick, STYLE_DIM);
        canvas_text(sheet->canvas, x - len, y + row, text_of(text), STYLE_PLAIN);
    }
}

/* rows of a panel up to which a line is drawn without marks */
#define FEW_ROWS 3

/* Returns true if no other curve is drawn in the panel. */
static bool is_only_curve_in_panel(const struct figure *figure, int curve)
{
    for (int i = 0; i < figure->curves; i++)
        if (i != curve && curve_drawn(figure, i))
            return false;
    return true;
}

/* Returns true if `width` cells of row y are blank from column x on. */
static bool cells_are_blank(const struct canvas *canvas, int x, int y, int width)
{
    for (int i = x; i < x + width; i++)
        if (i < 0 || i >= canvas->width || y < 0 || y >= canvas->height ||
            canvas->cell[(size_t)y * (size_t)canvas->width + (size_t)i].codepoint != ' ')
            return false;
    return true;
}

/* Draws labels left of their points, unless they would cover something. */
static void draw_labels(const struct text_sheet *sheet)
{
    enum { GAPS = 6 /* [cell] that a label may end left of its point */ };
    const struct figure_layout *layout = sheet->layout;
    int column, row;
    for (int i = 0; i < sheet->figure->labels; i++) {
        const struct figure_label *label = &sheet->figure->label[i];
        const int width = text_width(text_of(label->text));
        if (!figure_cell(layout, label->x, label->y, &column, &row))
            continue;
        int start = column - width - 1;
        for (int gap = 0; gap < GAPS && start >= 0; gap++, start--)
            if (cells_are_blank(sheet->canvas, sheet->x + layout->left + start,
                                sheet->y + layout->top + row, width + 1)) {
                canvas_text(sheet->canvas, sheet->x + layout->left + start,
                            sheet->y + layout->top + row, text_of(label->text), STYLE_BOLD);
                break;
            }
    }
}

/* Draws everything inside the plot, from back to front: map, guides, bands, the zero line, arrows,
 * lines, data, exits, labels, the current point. */
static void draw_curves(const struct text_sheet *sheet)
{
    const struct figure *figure = sheet->figure;
    const struct figure_layout *layout = sheet->layout;
    struct raster raster = {sheet->canvas, layout, sheet->x + layout->left, sheet->y + layout->top,
                            STYLE_DIM,     0,      sheet->strokes->band};
    int column, row, lines = 0;

    if (figure->heat)
        raster_heat(&raster, figure->heat);
    for (int i = 0; i < figure->guides; i++)
        raster_guide(&raster, &figure->guide[i]);
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].spread)
            raster_band(&raster, &figure->curve[i]);

    if (figure->zero_line && figure_cell(layout, layout->x.first_value, 0, &column, &row))
        for (column = 0; column < layout->columns; column += 2)
            raster_put(&raster, column, row, sheet->strokes->zero);
    raster.style = STYLE_DIM;
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].arrows) {
            raster.style = figure->curve[i].plain ? STYLE_PLAIN : STYLE_DIM;
            raster_arrows(&raster, &figure->curve[i]);
        }
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].joined) {
            raster.style = curve_style(figure, i);
            raster_line(&raster, &figure->curve[i]);
        }
    /* overlays come first, then the first line, data last */
    for (int pass = 0; pass < 3; pass++) {
        for (int i = figure->curves - 1; i >= 0; i--) {
            const struct curve *curve = &figure->curve[i];
            /* A line shows more than marks do if there are few rows. */
            raster.mark = figure->part && layout->rows <= FEW_ROWS && !curve->points &&
                                  is_only_curve_in_panel(figure, i)
                              ? 0
                              : figure_mark(figure, i);
            raster.style = curve->plain ? STYLE_PLAIN : curve_style(figure, i);
            if (!curve_drawn(figure, i) || curve->arrows ||
                pass != (curve->points ? 2 : !raster.mark))
                continue;
            if (curve->cloud)
                raster.mark = 0;
            if (curve->points && !curve->cloud)
                raster_points(&raster, curve,
                              lines && curve->n > (size_t)layout->columns / 2 ? 5 : 1);
            else
                raster_line(&raster, curve);
            lines += !curve->points;
        }
    }
    for (int i = 0; i < figure->curves; i++) {
        raster.style = curve_style(figure, i);
        if (curve_drawn(figure, i) && !figure->curve[i].arrows)
            raster_exits(&raster, figure, i);
    }
    draw_labels(sheet);
    raster.style = STYLE_BOLD;
    if (figure->has_point && figure_cell(layout, figure->point[0], figure->point[1], &column, &row))
        raster_put(&raster, column, row, sheet->strokes->point);
}

/* Clears the rectangle of a panel and draws frame, titles, axes and curves into it. */
static void draw_panel(const struct figure_panel *panel, struct canvas *canvas, int x, int y,
                       const struct charset *charset)
{
    struct figure_layout layout;
    struct text_sheet sheet = {&panel->figure, &layout,      charset_strokes(charset),
                               canvas,         x + panel->x, y + panel->y,
                               panel->width,   panel->height};

    for (int row = 0; row < panel->height; row++)
        for (int column = 0; column < panel->width; column++)
            canvas_put(canvas, sheet.x + column, sheet.y + row, ' ', STYLE_PLAIN);
    figure_layout(&panel->figure, panel->width, panel->height, charset, &layout);
    if (layout.frame) {
        draw_frame(&sheet);
        draw_titles(&sheet);
    }
    if (layout.x_labels)
        draw_x_axis(&sheet);
    if (layout.y_labels)
        draw_y_axis(&sheet);
    draw_curves(&sheet);
}

/* Draws a figure, or its words for screen readers, into width x height cells of the canvas from (x,
 * y) on. Returns false if out of memory. */
bool figure_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                 int height, const struct charset *charset)
{
    struct figure_panel panel[PANELS_MAX];

    if (width < 1 || height < 1)
        return true;
    if (charset->words)
        return charset->words->draw(figure, canvas, x, y, width, height);
    int panels = figure_panels(figure, width, height, charset, panel);
    for (int i = 0; i < panels; i++) {
        draw_panel(&panel[i], canvas, x, y, charset);
        /* panels share a frame: corners become branches */
        if (i && !figure->plane && !charset->plain) {
            canvas_put(canvas, x + panel[i].x, y + panel[i].y, 0x251C, STYLE_DIM);
            canvas_put(canvas, x + panel[i].x + panel[i].width - 1, y + panel[i].y, 0x2524,
                       STYLE_DIM);
        }
    }
    return true;
}

bool figure_stopped(const struct figure *figure)
{
    bool stopped = false;
    for (int i = 0; i < figure->curves; i++)
        stopped |= cancelled(figure->curve[i].cancel);
    return stopped;
}

/* Appends a figure as lines of text. Returns false if out of memory or cancelled. */
bool figure_print(const struct figure *figure, int width, int height, const struct charset *charset,
                  int colors, struct buffer *output)
{
    struct canvas canvas;

    if (charset->words)
        return charset->words->print(figure, width, output);
    if (!canvas_init(&canvas, width, height))
        return false;
    bool done = figure_draw(figure, &canvas, 0, 0, width, height, charset);
    canvas_print(&canvas, colors, output);
    canvas_free(&canvas);
    return done && !output->failed && !figure_stopped(figure);
}
