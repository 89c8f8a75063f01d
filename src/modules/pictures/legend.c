/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Title and legend of a picture, which name its curves. The legend is placed inside the plot where
 * it covers nothing (legend_place, legend_draw), or above it behind the title (page_heading). */
#include "modules/pictures/picture.h"
#include "modules/pictures/symbols.h"

#include <stdio.h>
#include <string.h>

#define LEGEND_ENTRIES_MAX 8 /* Largest number of entries of a legend inside the plot. */

/* One line of the legend: a curve, or the band around a curve. */
struct legend_entry {
    int curve;
    bool band;
    const char *label;
    double sample, width; /* [pt] width of the sample with its gap, and of sample and label */
};

/* Returns the label as printed: with symbols (theta1 as θ₁) if it is a name in the title of the
 * axis, whose symbols it has to match, else unchanged. */
static const char *shown_label(struct page *page, const char *label)
{
    const struct figure *figure = page->figure;
    const char *axis = figure->y.label, *second = figure->second ? figure->second[1].label : NULL;
    if (!(axis && strstr(axis, label)) && !(second && strstr(second, label)))
        return label;
    buffer_clear(page->text);
    put_name_symbols(page->text, text_of(label));
    return buffer_view(page->text);
}

/* Finds entry e of 2 * curves: the curves come first, then their bands. Sets label, sample and
 * width [pt] of *entry. Returns false if that curve has no label or is not drawn. */
static bool legend_entry_find(struct page *page, int e, struct legend_entry *entry)
{
    const int i = e % page->figure->curves;
    const struct curve *curve = &page->figure->curve[i];
    *entry = (struct legend_entry){.curve = i, .band = e >= page->figure->curves};
    if (!entry->band)
        entry->label = curve->label;
    else
        entry->label = curve->spread ? curve->spread_label : NULL;
    if (!entry->label || !*entry->label || !curve_drawn(page->figure, i))
        return false;
    entry->sample = (entry->band ? page_band_sample : page_sample)(page, i, 0, 0, false) +
                    page->style.sample_gap;
    entry->width = entry->sample + page_text_width(page, shown_label(page, entry->label));
    return true;
}

/* Draws an entry with its left edge at x, its middle at height y. Samples are centred in the width
 * `sample` [pt], after which the label begins. */
static void legend_entry_draw(struct page *page, const struct legend_entry *entry, double sample,
                              double x, double y)
{
    (entry->band ? page_band_sample : page_sample)(page, entry->curve,
                                                   x + (sample - entry->sample) / 2, y, true);
    page_text(page, x + sample, y, 0, style_black, shown_label(page, entry->label));
}

/* Draws (if `draw`) or only measures the title and, if `legend`, the legend above the plots.
 * Entries that do not fit into a third of the page's height are counted and left out. Returns the
 * lower end of the heading [pt]. */
double page_heading(struct page *page, bool legend, bool draw)
{
    const struct figure *figure = page->figure;
    const struct picture_style *style = &page->style;
    const double limit = page->height / 3, start = 1.5 * style->edge,
                 end = page->width - style->edge;
    double x = start, y = style->edge + style->title / 2;
    int first = 0, hidden = 0;
    struct legend_entry entry;

    if (figure->title && *figure->title) {
        buffer_clear(page->text);
        buffer_put(page->text, text_of(figure->title));
        const double size = page_fit(page, page->text, "", style->title, end - start);
        const struct surface_text title = {.x = x,
                                           .y = y + 0.36 * style->title,
                                           .size = size,
                                           .color = style_black,
                                           .text = buffer_view(page->text)};
        x += style->entry_gap + (draw ? surface_put_text(page->surface, &title)
                                      : surface_text_width(page->surface, size, title.text));
    } else if (!legend) {
        return style->edge + style->font / 2; /* half a label of the axis */
    }
    for (int e = 0; e < 2 * figure->curves && legend; e++) {
        if (!legend_entry_find(page, e, &entry))
            continue;
        if (first++ && x + entry.width > end && y + style->leading > limit - style->edge) {
            hidden++;
            continue;
        }
        if (x > start && x + entry.width > end) {
            x = start;
            y += style->leading;
        }
        if (draw)
            legend_entry_draw(page, &entry, entry.sample, x, y);
        x += entry.width + style->entry_gap;
    }
    if (hidden && draw) {
        char more[48];
        snprintf(more, sizeof more, "and %d more", hidden);
        page_text(page, end, limit - style->font / 2, 1, style_gray, more);
    }
    return hidden ? limit + style->edge : y + style->edge + style->font / 2;
}

/* ---- in the plot ---- */

/* Returns true if the area between y - spread and y + spread meets the box. */
static bool band_meets(const struct page *page, const struct curve *curve, const double box[4])
{
    for (size_t i = 1; curve_goes_on(curve, i); i++) {
        const double x[2] = {page_x(page, curve->x[i - 1]), page_x(page, curve->x[i])};
        double high = HUGE_VAL, low = -HUGE_VAL;
        for (size_t k = i - 1; k <= i; k++) {
            high = fmin(high, page_y(page, curve->y[k] + curve->spread[k]));
            low = fmax(low, page_y(page, curve->y[k] - curve->spread[k]));
        }
        if (fmin(x[0], x[1]) <= box[2] && fmax(x[0], x[1]) >= box[0] && high <= box[3] &&
            low >= box[1])
            return true;
    }
    return false;
}

/* Returns true if no curve, band, error bar or line of zero passes through the box (left, top,
 * right, bottom) [pt]. page->path has the paths of the curves first, then those of their error
 * bars. */
static bool is_box_free(const struct page *page, const double box[4])
{
    const struct figure *figure = page->figure;
    const double zero = page_y(page, 0);
    if (figure->zero_line && zero >= box[1] && zero <= box[3])
        return false;
    for (int i = 0; i < figure->curves; i++) {
        if (!curve_drawn(figure, i))
            continue;
        if (path_meets(&page->path[i], box[0], box[1], box[2], box[3]) ||
            path_meets(&page->path[figure->curves + i], box[0], box[1], box[2], box[3]) ||
            (figure->curve[i].spread && band_meets(page, &figure->curve[i], box)))
            return false;
    }
    return true;
}

/* Finds the number of entries and the width of the widest sample [pt]. Returns the width of the
 * legend when its entries are placed below each other. */
static double measure_entries(struct page *page, double *sample, int *entries)
{
    double label = 0;
    struct legend_entry entry;
    *sample = *entries = 0;
    for (int e = 0; e < 2 * page->figure->curves; e++) {
        if (!legend_entry_find(page, e, &entry))
            continue;
        *sample = fmax(*sample, entry.sample);
        label = fmax(label, entry.width - entry.sample);
        ++*entries;
    }
    return *sample + label;
}

/* Finds a free place for the legend inside the plot of a panel and sets box to its left, top, right
 * and bottom [pt]. The legend may fill at most half of the width and of the height of the plot.
 * Returns false if there is no room. */
bool legend_place(struct page *page, const struct page *panel, double box[4])
{
    /* corners first, then the middle of the sides, then in between; 0 is left and top */
    static const double places[][2] = {
        {1, 0},    {0, 0},    {1, 1},   {0, 1},   {0.5, 0}, {0.5, 1},  {1, 0.2},  {1, 0.8},
        {1, 0.35}, {1, 0.65}, {1, 0.5}, {0, 0.2}, {0, 0.8}, {0, 0.35}, {0, 0.65}, {0, 0.5}};
    const struct picture_style *style = &page->style;
    int entries;
    double sample;
    const double width = measure_entries(page, &sample, &entries),
                 height = entries * style->leading;
    const double gap = style->edge, from_x = panel->left + gap, from_y = panel->top + gap,
                 room_x = panel->right - gap - width - from_x,
                 room_y = panel->bottom - gap - height - from_y;
    if (entries == 0 || entries > LEGEND_ENTRIES_MAX || room_x < width || room_y < height)
        return false;
    for (size_t i = 0; i < COUNT_OF(places); i++) {
        const double x = from_x + places[i][0] * room_x, y = from_y + places[i][1] * room_y;
        if (!is_box_free(panel, (double[]){x - gap, y - gap, x + width + gap, y + height + gap}))
            continue;
        memcpy(box, (double[]){x, y, x + width, y + height}, 4 * sizeof *box);
        return true;
    }
    return false;
}

/* Draws the legend in the box of legend_place(): the entries below each other, in a frame. */
void legend_draw(struct page *page, const double box[4])
{
    const double edge = page->style.edge / 2;
    double y = box[1] + page->style.leading / 2, sample;
    int entries;
    struct legend_entry entry;
    measure_entries(page, &sample, &entries);
    surface_box(page->surface, box[0] - edge, box[1] - edge / 2, box[2] + edge, box[3] + edge / 2);
    surface_paint(page->surface,
                  &(struct brush){.color = style_grid, .width = page->style.grid_line});
    for (int e = 0; e < 2 * page->figure->curves; e++) {
        if (!legend_entry_find(page, e, &entry))
            continue;
        legend_entry_draw(page, &entry, sample, box[0], y);
        y += page->style.leading;
    }
}
