/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readings of the two cursors (period, frequency, decrement) and, for plots of states such as
 * portraits, of the point that the cursor keys move on their plane. */
#include <hooke/run.h>
#include <hooke/result.h>
#include <hooke/base/numeric.h>
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/plot.h>
#include <hooke/session/subject.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Values below this fraction of the amplitude are shown as 0; a smaller decrement gives no Q. */
#define READING_ROUNDING 1e-9

/* Computes the readings of the two cursors. Returns false if they are hidden or not set. */
bool session_cursor_reading(const struct session *session, struct cursor_reading *reading)
{
    const struct cursors *c = &session->view.cursors;
    if (!c->shown || c->plane || !c->cursor[0].set || !c->cursor[1].set)
        return false;
    const struct scene *scene = subject_scene(session, c->on_data ? NULL : session_run(session));
    const double dt = c->cursor[1].t - c->cursor[0].t, n = c->periods;
    const double period = fabs(dt) / n,
                 spread = hypot(c->cursor[0].t_uncertainty, c->cursor[1].t_uncertainty) / n;
    const bool spring = !scene || scene->model == &oscillator_model;
    const bool damped = scene && fabs(param_value(scene, "gamma")) > 0;
    double decrement = copysign(1, dt) * log(c->cursor[0].amplitude / c->cursor[1].amplitude) / n;
    decrement = fabs(decrement) < READING_ROUNDING ? 0 : decrement;
    const char *theory;
    if (!spring)
        theory = "period";
    else
        theory = damped ? "T_d" : "T0";
    *reading =
        (struct cursor_reading){.dt = dt,
                                .periods = n,
                                .period = {period, spread},
                                .frequency = {1 / period, spread / (period * period)},
                                .theory = scene_period(scene),
                                .theory_name = theory,
                                .decrement = decrement,
                                .quality = decrement > READING_ROUNDING ? PI / decrement : NAN};
    reading->deviation = (period - reading->theory) / reading->theory;
    return true;
}

/* Appends "NAME = VALUE", or "NAME = -" if it is unknown. */
static void put_value(struct buffer *text, const char *name, struct measured value,
                      enum quantity quantity)
{
    buffer_format(text, "%s = ", name);
    if (isfinite(value.value))
        buffer_measured(text, value, quantity, 6);
    else
        buffer_char(text, '-');
}

/* Appends the line of one cursor: its time, value, crossing, and `tail`. */
static void put_line(const struct cursors *c, int which, const char *name, const char *tail,
                     struct buffer *text)
{
    buffer_format(text, "%s%c  ", which == c->active ? ">" : " ", 'A' + which);
    put_value(text, "t", (struct measured){c->cursor[which].t, c->cursor[which].t_uncertainty},
              QUANTITY_TIME);
    const double y = c->cursor[which].y, amplitude = c->cursor[which].amplitude;
    buffer_put(text, TEXT("   "));
    put_value(text, name, (struct measured){fabs(y) < READING_ROUNDING * amplitude ? 0 : y, 0},
              c->quantity);
    if (c->cursor[which].crossing > 0)
        buffer_format(text, "   up-crossing #%d", c->cursor[which].crossing);
    buffer_format(text, "   %s\n", tail);
}

/* Appends four lines with the positions and readings of the cursors, as `cursor` prints them. */
void session_cursor_lines(const struct session *session, struct buffer *text)
{
    const struct cursors *c = &session->view.cursors;
    struct cursor_reading r;
    char tail[LIMIT_NAME + 64];
    if (!session_cursor_reading(session, &r))
        return;
    const struct run *run = c->on_data ? NULL : session_run(session);
    const char *name = run ? run->system.model->variable[0].name : "y";
    snprintf(tail, sizeof tail, "snap: %s%s", catalog_row(&snap_catalog, (size_t)c->snap)->name,
             c->locked ? ", locked" : "");
    put_line(c, 0, name, tail, text);
    snprintf(tail, sizeof tail, "on: %s", c->subject);
    put_line(c, 1, name, tail, text);
    put_value(text, " B-A", (struct measured){r.dt, 0}, QUANTITY_TIME);
    if (isfinite(r.periods))
        buffer_format(text, " / %g period%s", r.periods, r.periods == 1 ? "" : "s");
    put_value(text, "   T", r.period, QUANTITY_TIME);
    put_value(text, "   f", r.frequency, QUANTITY_FREQUENCY);
    buffer_put(text, TEXT("\n theory "));
    put_value(text, r.theory_name, (struct measured){r.theory, 0}, QUANTITY_TIME);
    if (isfinite(r.deviation))
        buffer_format(text, "   deviation %+.2f %%",
                      fabs(r.deviation) < 0.5e-4 ? 0.0 : 100 * r.deviation);
    put_value(text, "   log decrement", (struct measured){r.decrement, 0}, QUANTITY_NUMBER);
    put_value(text, "   Q", (struct measured){r.quality, 0}, QUANTITY_NUMBER);
}

/* ---- the point on a plane ---- */

/* Finds the plane of the focused plot. Returns false if it has none or has not been drawn. */
bool cursor_plane(const struct session *session, struct plot_plane *plane)
{
    const struct plane_row *row = plot_row(view_focus(&session->view))->plane;
    return row && row->drawn(session, plane);
}

/* Computes the state at the point; variables that are not on the axes are those of the plane. */
static void cursor_plane_state(const struct session *session, const struct plot_plane *plane,
                               double *state)
{
    memcpy(state, plane->state, sizeof plane->state);
    for (int k = 0; k < 2; k++)
        state[plane->variable[k]] = session->view.cursors.point[k];
}

/* Appends the command that begins a trajectory at the point: "start x=1,y=0". */
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

/* Appends lines with the state at the point, its energy, and what is special there. */
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
