/* SPDX-License-Identifier: GPL-3.0-or-later */
/* cursor */
#ifndef COMMAND_ROWS
#include <hooke/plot/cursor.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    [GO_LEFT] = {"left", "", "earlier, by a sample or the time given", "", NULL},
    [GO_RIGHT] = {"right", "", "later, by a sample or the time given", "", NULL},
    [GO_NEXT] = {"next", "", "to the next crossing, or peak", "", NULL},
    [GO_PREVIOUS] = {"previous", "", "to the crossing, or peak, before", "", NULL},
    [GO_MORE] = {"more", "", "one period more between A and B", "", NULL},
    [GO_LESS] = {"less", "", "one period less", "", NULL},
    [GO_OTHER] = {"other", "", "move the other cursor from now on", "", NULL},
    [GO_SERIES] = {"series", "", "to the run, or to the recording", "", NULL},
    [GO_LOCK] = {"lock", "", "move both together, or apart again", "", NULL},
    [GO_KEEP] = {"keep", "", "keep the period as a measurement", "", NULL},
    [GO_OFF] = {"off", "", "hide the cursors", "", NULL},
    [GO_UP] = {"up", "", "on a portrait: up", "", NULL},
    [GO_DOWN] = {"down", "", "on a portrait: down", "", NULL},
};
const struct catalog cursor_action_catalog = CATALOG("action", actions);

/* The active cursor by so much, and the other with it where they are locked. It snaps where it
 * comes near. */
static void move_by(struct cursors *c, const struct ground *ground, double by)
{
    const double reach = 0.5 * fabs(by);
    cursor_put(c, ground, c->active, c->at[c->active].t + by, reach);
    if (c->locked)
        cursor_put(c, ground, !c->active, c->at[!c->active].t + by, reach);
}

static bool jump(struct cursors *c, const struct ground *ground, bool forward, struct error *error)
{
    const double before = c->at[c->active].t;
    if (!cursor_jump(c, ground, forward, error))
        return false;
    if (c->locked)
        cursor_put(c, ground, !c->active, c->at[!c->active].t + c->at[c->active].t - before,
                   0.25 * fabs(c->at[c->active].t - before));
    return true;
}

static bool keep(struct session *session, struct reply *reply, struct error *error)
{
    struct cursor_reading r;
    const struct cursors *c = &session->view.cursors;
    if (!session_cursor_reading(session, &r) || !isfinite(r.period.value)) {
        error_set(
            error, ERROR_COMMAND,
            "the cursors show no period: less than one lies between them, or %s does not oscillate",
            c->of);
        return error_hint(error, "for example cursor periods 4");
    }
    if (!session_add_measurement(session, "period", c->of, r.period, QUANTITY_TIME, r.periods,
                                 error))
        return false;
    reply_line(reply, "kept ('list measurements')");
    return true;
}

static bool act(struct session *session, const struct arguments *args, struct ground *ground,
                struct reply *reply, struct error *error)
{
    struct cursors *c = &session->view.cursors;
    const struct argument_value *by = argument_value(args, "TIME");
    const double time = by->count ? by->item->value.value : ground_spacing(ground);
    const double n = isfinite(c->periods) ? c->periods : 0;
    switch ((enum cursor_action)argument_value(args, "WHAT")->item->index) {
    case GO_LEFT:
    case GO_RIGHT:
        move_by(c, ground, argument_value(args, "WHAT")->item->index == GO_LEFT ? -time : time);
        return true;
    case GO_NEXT:
        return jump(c, ground, true, error);
    case GO_PREVIOUS:
        return jump(c, ground, false, error);
    case GO_MORE:
        return cursor_span(c, ground, n + 1, error);
    case GO_LESS:
        return n >= 2 ? cursor_span(c, ground, n - 1, error)
                      : error_set(error, ERROR_COMMAND,
                                  "at least one period has to lie between A and B");
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
        for (int i = 0; i < 2; i++)
            cursor_put(c, ground, i, c->at[i].t, c->at[i].crossing > 0 ? HUGE_VAL : 0);
        return true;
    case GO_KEEP:
        return keep(session, reply, error);
    case GO_OFF:
        c->shown = false;
        return true;
    case GO_UP:
    case GO_DOWN:
        error_set(error, ERROR_COMMAND, "up and down are for the point on a portrait");
        return error_hint(error, "focus portrait full, then cursor");
    }
    return false;
}

/* ---- the point on a portrait ---- */

/* Along an axis by so much, or by a hundredth of it; not out of the box. */
static void move_point(struct cursors *c, const struct plot_plane *plane, int axis, double by)
{
    const double *box = plane->box[axis];
    c->point[axis] = fmin(fmax(c->point[axis] + by, box[0]), box[1]);
}

static bool act_on_plane(const struct session *session, const struct arguments *args,
                         struct cursors *c, const struct plot_plane *plane, struct error *error)
{
    const struct argument_value *by = argument_value(args, "TIME");
    const int what = argument_value(args, "WHAT")->item->index;
    const int axis = what == GO_UP || what == GO_DOWN;
    const double step =
        by->count ? by->item->value.value : (plane->box[axis][1] - plane->box[axis][0]) / 100;
    switch ((enum cursor_action)what) {
    case GO_LEFT:
    case GO_DOWN:
        move_point(c, plane, axis, -step);
        return true;
    case GO_RIGHT:
    case GO_UP:
        move_point(c, plane, axis, step);
        return true;
    case GO_NEXT:
    case GO_PREVIOUS:
        return plot_row(view_focus(&session->view))
            ->plane->next(session, plane, what == GO_NEXT, c->point, error);
    case GO_OFF:
        c->shown = c->plane = false;
        return true;
    default:
        error_set(error, ERROR_COMMAND, "'%s' is for the cursors on a plot over time",
                  actions[what].name);
        return error_hint(error,
                          "on a portrait: left, right, up, down, next, previous, off; 'start "
                          "cursor' begins a trajectory there");
    }
}

/* A screen has drawn it already. */
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

/* Where nothing is said the point appears, or goes; first where the motion is. */
static bool point(struct session *session, const struct arguments *args, bool any,
                  struct reply *reply, struct error *error)
{
    struct plot_plane plane;
    struct cursors *c = &session->view.cursors, before = *c;
    struct buffer text = {0};
    const struct run *run = session_run(session);
    if (!cursor_plane(session, &plane))
        return error_memory(error);
    const bool present = run && run->scene.model == session->setup.scene.model;
    for (int k = 0; k < 2 && !c->plane; k++) {
        const double *box = plane.box[k],
                     at = present ? run->y[plane.variable[k]] : 0.5 * (box[0] + box[1]);
        c->point[k] = fmin(fmax(at, box[0]), box[1]);
    }
    c->shown = any || !c->plane;
    c->plane = c->shown;
    if (any && !act_on_plane(session, args, c, &plane, error)) {
        *c = before;
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

static bool put_arguments(struct cursors *c, const struct ground *ground, int which,
                          const struct argument_value *at, struct error *error)
{
    const struct series *s = &ground->series;
    const double t = at->item->value.value;
    if (t < s->t[0] || t > s->t[s->n - 1])
        return error_at(error, at->item->text, "t = %.6g s is outside of %s (%.6g..%.6g s)", t,
                        ground->name, s->t[0], s->t[s->n - 1]);
    cursor_put(c, ground, which, t, HUGE_VAL);
    return true;
}

/* One change of the cursors; what fails leaves them as they were. */
static bool apply(struct session *session, const struct arguments *args, struct ground *ground,
                  struct reply *reply, struct error *error)
{
    struct cursors *c = &session->view.cursors;
    const struct argument_value *a = argument_value(args, "A"), *b = argument_value(args, "B"),
                                *go = argument_value(args, "go"),
                                *snap = argument_value(args, "snap"),
                                *periods = argument_value(args, "periods");
    if (snap->count) {
        c->snap = (enum snap)snap->item->index;
        for (int i = 0; i < 2; i++)
            cursor_put(c, ground, i, c->at[i].t, HUGE_VAL);
    }
    if ((a->count && !put_arguments(c, ground, 0, a, error)) ||
        (b->count && !put_arguments(c, ground, 1, b, error)) ||
        (go->count && !put_arguments(c, ground, c->active, go, error)))
        return false;
    if (periods->count && !cursor_span(c, ground, periods->item->value.value, error)) {
        error->where = periods->item->text;
        return false;
    }
    return !has_argument(args, "WHAT") || act(session, args, ground, reply, error);
}

static void reply_cursor(struct reply *reply, const char *key, const struct cursors *c, int which)
{
    reply_object(reply, key);
    reply_real(reply, "t", c->at[which].t);
    reply_real(reply, "uncertainty", c->at[which].t_uncertainty);
    reply_real(reply, "y", c->at[which].y);
    reply_int(reply, "crossing", c->at[which].crossing);
    reply_close(reply);
}

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
    reply_string(reply, "of", c->of);
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

HANDLER(cursor)
{
    struct cursors *c = &session->view.cursors;
    struct ground ground;
    bool any = false;
    for (int i = 0; i < args->command->arguments; i++)
        any |= has(args, i);
    session->live.pausing = session->live.state == LIVE_RUNNING;
    const bool timed = any && !has_argument(args, "WHAT");
    if (!timed && plot_row(view_focus(&session->view))->plane && (c->plane || !c->shown))
        return draw_plane(session, args->arena, error) && point(session, args, any, reply, error);
    c->plane = false;
    const bool hide =
        any ? has_argument(args, "WHAT") && argument_value(args, "WHAT")->item->index == GO_OFF
            : c->shown;
    if (hide || (!any && c->shown)) {
        c->shown = false;
        reply_line(reply, "cursors off");
        return true;
    }
    const struct cursors before = *c;
    if (!ground_open(session, args->arena, &ground, error)) {
        *c = before;
        return false;
    }
    c->shown = true;
    if (!c->at[0].set || !c->at[1].set)
        cursor_spread(c, &ground);
    if (!apply(session, args, &ground, reply, error)) {
        *c = before;
        return false;
    }
    cursor_settle(c, &ground);
    session_changed(session);
    reply_reading(session, reply);
    return true;
}
#endif

COMMAND(cursor,
        .row = {"cursor", "", "two cursors on the plot: times, periods, decrement", "", NULL},
        .group = "MEASURE",
        .text = "Without anything it shows or hides them. A, B and go put them to a time; they "
                "snap to the nearest "
                "up-crossing of the\n"
                "equilibrium, placed by the line fit that measures periods, or as 'cursor snap' "
                "says. periods: B = A + N "
                "periods. Also:\n"
                "left, right [TIME], next, previous (crossing), more, less (periods), other (A or "
                "B moves), series (run or "
                "recording), lock,\n"
                "keep (as a measurement), off. They stand on the current run unless told; a run "
                "that goes on is paused.\n"
                "While the pane portrait has the focus it is a point on its plane: left, right, "
                "up, down, next and\n"
                "previous (equilibrium); Enter, or 'start cursor', begins a trajectory there.",
        .examples = "run; cursor\nrun; cursor A 1 s; cursor periods 4; cursor keep",
        .see = "measure list start", .flags = COMMAND_ANYTIME,
        ARGUMENTS(WORD("A", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("B", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("go", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  WORD("snap", TYPE_CHOICE, .choices = &snap_catalog),
                  WORD("periods", TYPE_INTEGER),
                  PLACE("WHAT", TYPE_CHOICE, .choices = &cursor_action_catalog),
                  PLACE("TIME", TYPE_VALUE, .quantity = QUANTITY_TIME)))
