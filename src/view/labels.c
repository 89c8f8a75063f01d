/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shortens a legend: if the frame has no room for the names of all runs, they are replaced by the
 * runs' numbers, as in the list of runs, so that every mark is explained. */
#include <hooke/run.h>
#include <hooke/base/safe_text.h>
#include <hooke/plot.h>
#include "view/internal.h"

#include <stdio.h>

#define FRAME_CELLS 8 /* [cell] part of a frame that neither title nor legend can use */
/* [cell] width of a legend's entry beside its label, for the mark and blanks */
#define LEGEND_MARK_CELLS 4
#define POWER_CELLS 6 /* [cell] width of "1e-12 " in a title */

/* Replaces the labels of runs by their numbers if title, axis and all labels do not fit into the
 * upper frame of `width` cells. */
void labels_shorten(struct screen *screen, int width, int height,
                    const struct figure_request *request, struct figure *figure)
{
    struct figure_layout layout;
    char number[16];
    figure_layout(figure, width, height, screen->charset, &layout);
    const int power = layout.y_ticks.exponent ? POWER_CELLS : 0;
    int need = FRAME_CELLS + text_width(text_of(figure->title)) + (*figure->title ? 1 : 0) +
               text_width(text_of(figure->y.label)) + text_width(text_of(figure->y.unit)) + 3 +
               power;
    for (int i = 0; i < figure->curves; i++)
        need += figure->curve[i].label
                    ? text_width(text_of(figure->curve[i].label)) + LEGEND_MARK_CELLS
                    : 0;
    if (need <= width || plot_row(request->kind)->residual)
        return;
    struct curve *brief = arena_array(&screen->arena, (size_t)figure->curves + 1, sizeof *brief);
    for (int i = 0; brief && i < figure->curves; i++) {
        brief[i] = figure->curve[i];
        if (i < request->runs && brief[i].label) {
            snprintf(number, sizeof number, "%d",
                     screen->session->runs.slot[request->run[i]]->run->number);
            brief[i].label = arena_text(&screen->arena, text_of(number));
        }
    }
    figure->curve = brief ? brief : figure->curve;
}
