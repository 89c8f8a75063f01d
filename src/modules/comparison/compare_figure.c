/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The runs of the last comparison for the eye: their errors, or energies, along the time. */
#include <hooke/plot/drawing.h>
#include "modules/comparison/comparison.h"
#include "modules/comparison/plots.h"

/* Fills in the places of the compared runs that are still kept. Returns how many there are. */
static int compared_places(const struct session *session, int place[COMPARED_MAX])
{
    const struct comparison_part *part = session_part_if_made(session, &comparison_module);
    int count = 0;
    for (int i = 0; part && i < part->compared_count; i++)
        for (int k = 0; k < session->runs.count; k++)
            if (session->runs.slot[k]->run->number == part->compared[i])
                place[count++] = k;
    return count;
}

bool compare_known(const struct session *session)
{
    int place[COMPARED_MAX];
    return compared_places(session, place) > 0;
}

bool compare_plot(struct drawing *d, struct figure *figure)
{
    int *place = arena_array(d->arena, COMPARED_MAX, sizeof *place);
    if (!place)
        return error_memory(d->error);
    struct figure_request request = *d->request;
    request.recording = -1;
    request.run = place;
    request.runs = compared_places(d->session, place);
    if (request.runs == 0) {
        error_set(d->error, ERROR_COMMAND, "there is no comparison to plot");
        return error_hint(d->error, "type: compare euler verlet rk4");
    }
    const struct system *system = &d->session->runs.slot[place[0]]->run->system;
    const bool exact = system_has_exact(system);
    request.kind = exact                                   ? PLOT_ERROR
                   : plot_fits(PLOT_ENERGY, system->model) ? PLOT_ENERGY
                                                           : PLOT_POSITION;
    request.log = exact;
    return session_figure(d->session, &request, d->arena, figure, d->error);
}
