/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names in a legend: where the frame has no room for all of them the runs go by their numbers, as
 * in the list of runs, so that no mark stays unexplained. */
#include <hooke/run.h>
#include <hooke/base/safe_text.h>
#include <hooke/plot.h>
#include "view/internal.h"

#include <stdio.h>

#define FRAME 8 /* [cell] of a frame that neither title nor legend can have */
#define ENTRY 4 /* [cell] of the legend beside a label: mark and blanks */
#define POWER 6 /* [cell] "1e-12 " in a title */

void labels_shorten(struct screen *screen, int width, int height,
                    const struct figure_request *request, struct figure *figure)
{
    struct figure_layout layout;
    char number[16];
    figure_layout(figure, width, height, screen->charset, &layout);
    int need = FRAME + text_width(text_of(figure->title)) + (*figure->title ? 1 : 0) +
               text_width(text_of(figure->y.label)) + text_width(text_of(figure->y.unit)) + 3 +
               (layout.y_ticks.exponent ? POWER : 0);
    for (int i = 0; i < figure->curves; i++)
        need += figure->curve[i].label ? text_width(text_of(figure->curve[i].label)) + ENTRY : 0;
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
