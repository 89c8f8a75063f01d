/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The point on the plane of a plot of states, as a portrait is: where it stands, and the trajectory
 * from there. */
#include <hooke/plot.h>

#include <math.h>
#include <string.h>

bool cursor_plane(const struct session *session, struct plot_plane *plane)
{
    const struct plane_row *row = plot_row(view_focus(&session->view))->plane;
    return row && row->drawn(session, plane);
}

void cursor_plane_state(const struct session *session, const struct plot_plane *plane,
                        double *state)
{
    memcpy(state, plane->state, sizeof plane->state);
    for (int k = 0; k < 2; k++)
        state[plane->variable[k]] = session->view.cursors.point[k];
}

void cursor_plane_start(const struct session *session, struct buffer *line)
{
    struct plot_plane plane;
    const struct variable *variable = session->setup.scene.model->variable;
    const int sides = cursor_plane(session, &plane) ? 2 : 0;
    for (int k = 0; k < sides; k++) {
        buffer_format(line, "%s%s=", k ? "," : "start ", variable[plane.variable[k]].name);
        buffer_short(line, session->view.cursors.point[k], 6);
    }
}

void cursor_plane_lines(const struct session *session, struct buffer *text)
{
    struct plot_plane plane;
    const struct view *view = &session->view;
    struct system system;
    struct error ignored;
    double state[LIMIT_VARIABLES];
    if (!cursor_plane(session, &plane) || !scene_bind(plane.scene, &system, &ignored))
        return;
    cursor_plane_state(session, &plane, state);
    for (int k = 0; k < 2; k++) {
        const struct variable variable = system_variable(&system, plane.variable[k]);
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
    plot_row(view_focus(view))->plane->say(session, &plane, text);
}
