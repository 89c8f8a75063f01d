/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The point on the plane of a portrait: where it stands, and the trajectory from there. */
#include <hooke/plot.h>
#include <hooke/session/portrait.h>

#include <math.h>
#include <string.h>

#define ON 0.01 /* of the box: the point stands on an equilibrium */

const struct portrait_request *cursor_plane(const struct session *session)
{
    const struct stored_portrait *stored = session->portrait;
    const bool drawn = stored->request.scene && stored->scene.model == session->setup.scene.model;
    return drawn && view_focus(&session->view) == PLOT_PORTRAIT ? &stored->request : NULL;
}

void cursor_plane_state(const struct session *session, double *state)
{
    const struct portrait_request *plane = &session->portrait->request;
    memcpy(state, plane->state, sizeof plane->state);
    for (int k = 0; k < 2; k++)
        state[plane->variable[k]] = session->view.cursors.point[k];
}

void cursor_plane_start(const struct session *session, struct buffer *line)
{
    const struct portrait_request *plane = cursor_plane(session);
    const struct variable *variable = session->setup.scene.model->variable;
    for (int k = 0; plane && k < 2; k++) {
        buffer_format(line, "%s%s=", k ? "," : "start ", variable[plane->variable[k]].name);
        buffer_short(line, session->view.cursors.point[k], 6);
    }
}

/* The place of the equilibrium that it stands on; -1: on none. */
static int equilibrium_there(const struct session *session, const struct portrait_request *plane)
{
    const struct equilibria *found = &session->portrait->portrait.found;
    for (int e = 0; e < found->count; e++) {
        double off = 0;
        for (int k = 0; k < 2; k++)
            off = fmax(
                off, fabs(found->of[e].state[plane->variable[k]] - session->view.cursors.point[k]) /
                         (plane->box[k][1] - plane->box[k][0]));
        if (off < ON)
            return e;
    }
    return -1;
}

void cursor_plane_lines(const struct session *session, struct buffer *text)
{
    const struct portrait_request *plane = cursor_plane(session);
    const struct view *view = &session->view;
    struct system system;
    struct error ignored;
    double state[LIMIT_VARIABLES];
    if (!plane || !scene_bind(&session->portrait->scene, &system, &ignored))
        return;
    cursor_plane_state(session, state);
    for (int k = 0; k < 2; k++) {
        const struct variable variable = system_variable(&system, plane->variable[k]);
        buffer_format(text, "%s%s = ", k ? "   " : "", variable.name);
        buffer_quantity(text, view->cursors.point[k], variable.quantity, 5);
    }
    if (system.energy) {
        buffer_put(text, TEXT("   E = "));
        buffer_quantity(text, system_kinetic(&system, state) + system_potential(&system, state),
                        observable_quantity(observable_energy(&system), &system), 5);
    }
    buffer_format(text, "\nstarts: %d of %d", view->start_n == system.n ? view->starts : 0,
                  LIMIT_STARTS);
    const int there = equilibrium_there(session, plane);
    if (there >= 0)
        buffer_format(
            text, "   on equilibrium %d, %s", there + 1,
            catalog_row(&equilibrium_catalog, session->portrait->portrait.found.form[there].type)
                ->name);
}
