/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The plane of the phase portrait, on which the cursors' point moves, and when the plot is
 * offered. */
#include "modules/dynamics/dynamics_results.h"
#include "modules/dynamics/plots.h"

#include <math.h>
#include <string.h>

/* Distance from an equilibrium, as a fraction of the region, within which the point is on it. */
static const double on_equilibrium_max = 0.01;

/* Sets the plane of the portrait that is drawn. Returns false if none is of the present model. */
static bool plane_drawn(const struct session *session, struct plot_plane *plane)
{
    const struct dynamics_part *part = session_part_if_made(session, &dynamics_module);
    const struct stored_portrait *stored = part ? &part->portrait : NULL;
    if (!stored || !stored->request.scene || stored->scene.model != session->setup.scene.model)
        return false;
    *plane = (struct plot_plane){.scene = &stored->scene};
    memcpy(plane->variable, stored->request.variable, sizeof plane->variable);
    memcpy(plane->box, stored->request.box, sizeof plane->box);
    memcpy(plane->state, stored->request.state, sizeof stored->request.state);
    return true;
}

/* Moves the point {x, y} to the next equilibrium to the right, or left if not `forward`; after the
 * last one it goes on at the other side of the region. Those above each other are taken upwards
 * (downwards if not `forward`). Returns false with *error if there is none. */
static bool next_equilibrium(const struct session *session, const struct plot_plane *plane,
                             bool forward, double point[2], struct error *error)
{
    const struct equilibria *found = &stored_portrait(session)->portrait.found;
    const int sign = forward ? 1 : -1;
    int best = -1;
    double nearest[2] = {HUGE_VAL, HUGE_VAL};
    for (int e = 0; e < found->count; e++) {
        const double *state = found->solution[e].state;
        double displacement[2];
        for (int k = 0; k < 2; k++)
            displacement[k] = sign * (state[plane->variable[k]] - point[k]);
        const double width = plane->box[0][1] - plane->box[0][0];
        const bool is_aligned = fabs(displacement[0]) < 1e-9 * width;
        if (is_aligned && !(displacement[1] > 1e-9 * (plane->box[1][1] - plane->box[1][0])))
            displacement[0] = width;
        else if (!is_aligned && displacement[0] < 0)
            displacement[0] += width;
        if (displacement[0] < nearest[0] ||
            (displacement[0] == nearest[0] && displacement[1] < nearest[1])) {
            memcpy(nearest, displacement, sizeof displacement);
            best = e;
        }
    }
    for (int k = 0; k < 2 && best >= 0; k++)
        point[k] = found->solution[best].state[plane->variable[k]];
    return best >= 0 || error_set(error, ERROR_COMMAND, "there is no equilibrium in this portrait");
}

/* Returns the index of the equilibrium that the cursor is on, closer than on_equilibrium_max of the
 * region's width and height, or -1. */
static int equilibrium_at_cursor(const struct session *session, const struct plot_plane *plane)
{
    const struct equilibria *found = &stored_portrait(session)->portrait.found;
    for (int e = 0; e < found->count; e++) {
        double distance = 0;
        for (int k = 0; k < 2; k++)
            distance = fmax(distance, fabs(found->solution[e].state[plane->variable[k]] -
                                           session->view.cursors.point[k]) /
                                          (plane->box[k][1] - plane->box[k][0]));
        if (distance < on_equilibrium_max)
            return e;
    }
    return -1;
}

/* Appends the equilibrium that the cursor is on, if there is one. */
static void say_equilibrium(const struct session *session, const struct plot_plane *plane,
                            struct buffer *text)
{
    const int there = equilibrium_at_cursor(session, plane);
    const struct equilibria *found = &stored_portrait(session)->portrait.found;
    if (there >= 0)
        buffer_format(text, "   on equilibrium %d, %s", there + 1,
                      catalog_row(&equilibrium_catalog, found->form[there].type)->name);
}

const struct plane_row portrait_plane = {
    .drawn = plane_drawn, .next = next_equilibrium, .say = say_equilibrium};

/* ---- when it is offered ---- */

bool portrait_fits(const struct model *model)
{
    return model->n > 1;
}

bool portrait_offered(const struct session *session)
{
    const int n = session->setup.scene.model->n;
    return n > 1 && n <= STARTS_VARIABLES;
}
