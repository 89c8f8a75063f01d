/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command cursor: two cursors on plots over time, with the period between them, or a point on a
 * portrait. */
#ifndef COMMAND_ROWS
#include <hooke/plot/cursor.h>
#include <hooke/command/handler.h>

#include <math.h>

/* Actions of `cursor WHAT`. */
enum cursor_action {
    GO_LEFT,
    GO_RIGHT,
    GO_NEXT,
    GO_PREVIOUS,
    GO_MORE,
    GO_LESS,
    GO_OTHER,
    GO_SERIES,
    GO_LOCK,
    GO_KEEP,
    GO_OFF,
    GO_UP,
    GO_DOWN
};

static const struct row actions[] = {
    [GO_LEFT] = {"left", "", "move earlier, by one sample or by the time given", "", NULL},
    [GO_RIGHT] = {"right", "", "move later, by one sample or by the time given", "", NULL},
    [GO_NEXT] = {"next", "", "move to the next crossing or peak", "", NULL},
    [GO_PREVIOUS] = {"previous", "", "move to the previous crossing or peak", "", NULL},
    [GO_MORE] = {"more", "", "move B one period farther from A", "", NULL},
    [GO_LESS] = {"less", "", "move B one period closer to A", "", NULL},
    [GO_OTHER] = {"other", "", "move the other cursor from now on", "", NULL},
    [GO_SERIES] = {"series", "", "change between run and recording", "", NULL},
    [GO_LOCK] = {"lock", "", "lock the cursors together, or unlock them", "", NULL},
    [GO_KEEP] = {"keep", "", "keep the period as a measurement", "", NULL},
    [GO_OFF] = {"off", "", "hide the cursors", "", NULL},
    [GO_UP] = {"up", "", "up, in a portrait", "", NULL},
    [GO_DOWN] = {"down", "", "down, in a portrait", "", NULL},
};
const struct catalog cursor_action_catalog = CATALOG("action", actions);

/* Moves the other cursor by the same shift as the active one, if they are locked together. reach is
 * the distance within which it snaps. */
static void move_locked_cursor(struct cursors *c, const struct ground *ground, double shift,
                               double reach)
{
    if (c->locked)
        cursor_put(c, ground, !c->active, c->cursor[!c->active].t + shift, reach);
}

/* Moves the active cursor by shift [s]; it snaps to a crossing or peak within half of that. */
static void move_by(struct cursors *c, const struct ground *ground, double shift)
{
    cursor_put(c, ground, c->active, c->cursor[c->active].t + shift, 0.5 * fabs(shift));
    move_locked_cursor(c, ground, shift, 0.5 * fabs(shift));
}

/* Moves the active cursor to the next or previous crossing or peak. Returns false with the error
 * set if there is none. */
static bool active_cursor_jump(struct cursors *c, const struct ground *ground, bool forward,
                               struct error *error)
{
    const double previous = c->cursor[c->active].t;
    if (!cursor_jump(c, ground, forward, error))
        return false;
    const double shift = c->cursor[c->active].t - previous;
    move_locked_cursor(c, ground, shift, 0.25 * fabs(shift));
    return true;
}

/* Adds the period between the cursors to the measurements. Returns false with the error set if
 * there is none. */
static bool cursor_keep_period(struct session *session, struct reply *reply, struct error *error)
{
    struct cursor_reading r;
    const struct cursors *c = &session->view.cursors;
    if (!session_cursor_reading(session, &r) || !isfinite(r.period.value)) {
        error_set(error, ERROR_COMMAND,
                  "no period between the cursors: they are less than one period apart, or %s does "
                  "not oscillate",
                  c->subject);
        return error_hint(error, "for example cursor periods 4");
    }
    if (!session_add_measurement(session, "period", c->subject, r.period, QUANTITY_TIME, r.periods,
                                 error))
        return false;
    reply_line(reply, "kept ('list measurements')");
    return true;
}

/* Performs the action of `cursor WHAT [TIME]` on cursors over time. Returns false with the error
 * set. */
static bool cursor_action_perform(struct session *session, const struct arguments *args,
                                  struct ground *ground, struct reply *reply, struct error *error)
{
    struct cursors *c = &session->view.cursors;
    const struct argument_value *step_argument = argument_value(args, "TIME");
    const double time =
        step_argument->count ? step_argument->item->value.value : ground_spacing(ground);
    const double n = isfinite(c->periods) ? c->periods : 0;
    const enum cursor_action what = (enum cursor_action)argument_value(args, "WHAT")->item->index;
    switch (what) {
    case GO_LEFT:
    case GO_RIGHT:
        move_by(c, ground, what == GO_LEFT ? -time : time);
        return true;
    case GO_NEXT:
    case GO_PREVIOUS:
        return active_cursor_jump(c, ground, what == GO_NEXT, error);
    case GO_MORE:
        return cursor_span(c, ground, n + 1, error);
    case GO_LESS:
        return n >= 2
                   ? cursor_span(c, ground, n - 1, error)
                   : error_set(error, ERROR_COMMAND, "A and B must be at least one period apart");
    case GO_OTHER:
        c->active = !c->active;
        return true;
    case GO_LOCK:
        c->locked = !c->locked;
        return true;
    case GO_SERIES:
        if (!session_run(session) || !session_recording(session))
            return error_set(error, ERROR_COMMAND, "there is only one series: %s", ground->name);
        c->on_data = !c->on_data;
        if (!ground_open(session, args->arena, ground, error))
            return false;
        cursors_put_again(c, ground);
        return true;
    case GO_KEEP:
        return cursor_keep_period(session, reply, error);
    case GO_OFF: /* done by the handler */
        return true;
    case GO_UP:
    case GO_DOWN:
        error_set(error, ERROR_COMMAND, "'up' and 'down' move the point in a portrait only");
        return error_hint(error, "focus portrait full, then cursor");
    }
    return false;
}

/* ---- the point on a portrait ---- */

/* Performs the action of `cursor WHAT` on the point c->point of a portrait, which stays inside its
 * box. Returns false with the error set. */
static bool act_on_plane(const struct session *session, const struct arguments *args,
                         struct cursors *c, const struct plot_plane *plane, struct error *error)
{
    const struct argument_value *step_argument = argument_value(args, "TIME");
    const enum cursor_action what = (enum cursor_action)argument_value(args, "WHAT")->item->index;
    const int axis = what == GO_UP || what == GO_DOWN;
    const double *box = plane->box[axis];
    const double step =
        step_argument->count ? step_argument->item->value.value : (box[1] - box[0]) / 100;
    switch (what) {
    case GO_LEFT:
    case GO_DOWN:
    case GO_RIGHT:
    case GO_UP:
        c->point[axis] += what == GO_LEFT || what == GO_DOWN ? -step : step;
        c->point[axis] = fmin(fmax(c->point[axis], box[0]), box[1]);
        return true;
    case GO_NEXT:
    case GO_PREVIOUS:
        return plot_row(view_focus(&session->view))
            ->plane->next(session, plane, what == GO_NEXT, c->point, error);
    case GO_OFF:
        c->shown = c->plane = false;
        return true;
    default:
        error_set(error, ERROR_COMMAND, "'%s' works only with cursors on a plot over time",
                  actions[what].name);
        return error_hint(error, "in a portrait use left, right, up, down, next, previous, off; "
                                 "'start cursor' begins a trajectory there");
    }
}

/* Makes sure that the portrait has been drawn, which defines its plane; a screen has done that
 * already. Returns false with the error set. */
static bool draw_plane(const struct session *session, struct arena *arena, struct error *error)
{
    const struct figure_request request = {.kind = view_focus(&session->view),
                                           .recording = -1,
                                           .window = {NAN, NAN},
                                           .width = 80,
                                           .follow = true};
    struct plot_plane plane;
    struct figure figure;
    return cursor_plane(session, &plane) ||
           session_figure(session, &request, arena, &figure, error);
}

/* Shows, moves or hides the point on a portrait. Without arguments (any is false) it appears, first
 * at the state of the run, or disappears. */
static bool cursor_point(struct session *session, const struct arguments *args, bool any,
                         struct reply *reply, struct error *error)
{
    struct plot_plane plane;
    struct cursors *c = &session->view.cursors, previous = *c;
    struct buffer text = {0};
    const struct run *run = session_run(session);
    if (!cursor_plane(session, &plane))
        return error_memory(error);
    const bool present = run && run->scene.model == session->setup.scene.model;
    for (int k = 0; k < 2 && !c->plane; k++) {
        const double *box = plane.box[k],
                     coordinate = present ? run->y[plane.variable[k]] : 0.5 * (box[0] + box[1]);
        c->point[k] = fmin(fmax(coordinate, box[0]), box[1]);
    }
    c->shown = any || !c->plane;
    c->plane = c->shown;
    if (any && !act_on_plane(session, args, c, &plane, error)) {
        *c = previous;
        return false;
    }
    session_changed(session);
    if (!c->shown) {
        reply_line(reply, "cursors off");
        return true;
    }
    cursor_plane_lines(session, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}

/* Puts cursor `which` to the time that the argument gives, if it is given. Returns false with the
 * error set if it is outside of the series. */
static bool cursor_put_argument(struct cursors *c, const struct ground *ground, int which,
                                const struct argument_value *argument, struct error *error)
{
    const struct series *s = &ground->series;
    const double t = argument->count ? argument->item->value.value : 0;
    if (argument->count && (t < s->t[0] || t > s->t[s->n - 1]))
        return error_at(error, argument->item->text, "t = %.6g s is outside %s (%.6g..%.6g s)", t,
                        ground->name, s->t[0], s->t[s->n - 1]);
    if (argument->count)
        cursor_put(c, ground, which, t, HUGE_VAL);
    return true;
}

/* Applies all arguments of the command to the cursors. Returns false with the error set. */
static bool cursor_apply(struct session *session, const struct arguments *args,
                         struct ground *ground, struct reply *reply, struct error *error)
{
    struct cursors *c = &session->view.cursors;
    const struct argument_value *periods = argument_value(args, "periods");
    for (int i = 0; i < 2 && has_argument(args, "snap"); i++)
        cursor_put(c, ground, i, c->cursor[i].t, HUGE_VAL);
    if (!cursor_put_argument(c, ground, 0, argument_value(args, "A"), error) ||
        !cursor_put_argument(c, ground, 1, argument_value(args, "B"), error) ||
        !cursor_put_argument(c, ground, c->active, argument_value(args, "go"), error))
        return false;
    if (periods->count && !cursor_span(c, ground, periods->item->value.value, error)) {
        error->where = periods->item->text;
        return false;
    }
    return !has_argument(args, "WHAT") ||
           cursor_action_perform(session, args, ground, reply, error);
}

/* Adds one cursor to the record. */
static void reply_cursor(struct reply *reply, const char *key, const struct cursors *c, int which)
{
    reply_object(reply, key);
    reply_real(reply, "t", c->cursor[which].t);
    reply_real(reply, "uncertainty", c->cursor[which].t_uncertainty);
    reply_real(reply, "y", c->cursor[which].y);
    reply_int(reply, "crossing", c->cursor[which].crossing);
    reply_close(reply);
}

/* Replies with what the cursors read: lines and a record. */
static void reply_reading(const struct session *session, struct reply *reply)
{
    const struct cursors *c = &session->view.cursors;
    struct cursor_reading r;
    struct buffer text = {0};
    if (!session_cursor_reading(session, &r))
        return;
    session_cursor_lines(session, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    reply_begin(reply, "cursor");
    reply_string(reply, "of", c->subject);
    reply_string(reply, "snap", catalog_row(&snap_catalog, (size_t)c->snap)->name);
    reply_cursor(reply, "a", c, 0);
    reply_cursor(reply, "b", c, 1);
    reply_real(reply, "dt", r.dt);
    reply_real(reply, "periods", r.periods);
    reply_measured(reply, "period", r.period, QUANTITY_TIME);
    reply_measured(reply, "frequency", r.frequency, QUANTITY_FREQUENCY);
    reply_real(reply, "theory", r.theory);
    reply_real(reply, "deviation", r.deviation);
    reply_real(reply, "decrement", r.decrement);
    reply_real(reply, "quality", r.quality);
    reply_end(reply);
}

/* Shows or hides the cursors if there are no arguments; otherwise applies these to them, or to the
 * point if a portrait is in focus. */
HANDLER(cursor)
{
    struct cursors *c = &session->view.cursors;
    struct ground ground;
    bool any = false;
    for (int i = 0; i < args->command->arguments; i++)
        any |= has_argument_at(args, i);
    session->live.pausing = session->live.state == LIVE_RUNNING;
    const bool timed = any && !has_argument(args, "WHAT");
    if (!timed && plot_row(view_focus(&session->view))->plane && (c->plane || !c->shown))
        return draw_plane(session, args->arena, error) &&
               cursor_point(session, args, any, reply, error);
    c->plane = false;
    const bool turns_off =
        has_argument(args, "WHAT") && argument_value(args, "WHAT")->item->index == GO_OFF;
    if (any ? turns_off : c->shown) {
        c->shown = false;
        reply_line(reply, "cursors off");
        return true;
    }
    const struct cursors previous = *c;
    if (has_argument(args, "snap"))
        c->snap = (enum snap)argument_value(args, "snap")->item->index;
    const bool opened = ground_open(session, args->arena, &ground, error);
    c->shown = opened;
    if (opened && (!c->cursor[0].set || !c->cursor[1].set))
        cursor_spread(c, &ground);
    if (!opened || !cursor_apply(session, args, &ground, reply, error)) {
        *c = previous;
        return false;
    }
    cursor_settle(c, &ground);
    session_changed(session);
    reply_reading(session, reply);
    return true;
}
#endif

COMMAND(cursor, .group = "MEASURE", .flags = COMMAND_ANYTIME,
        ARGUMENTS(WORD("A", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("B", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("go", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("snap", TYPE_CHOICE, .choices = &snap_catalog),
                  WORD("periods", TYPE_INTEGER),
                  PLACE("WHAT", TYPE_CHOICE, .choices = &cursor_action_catalog),
                  PLACE("TIME", TYPE_VALUE, .quantity = QUANTITY_TIME)))
