/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands for what the screen shows: layout, focus, range, zoom, pan, window, overlay, trail,
 * screenshot. They change session->view. */
#ifndef COMMAND_ROWS
#include <hooke/base/file.h>
#include <hooke/data.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/plot.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <string.h>

#define ZOOM_MAX 1e6 /* the whole span divided by the shortest range of time */

/* Counts a change of the session. Returns true. */
static bool note_change(struct session *session)
{
    session_changed(session);
    return true;
}

/* Makes both axes automatic. */
static void clear_ranges(struct view *view)
{
    view->x[0] = view->x[1] = view->y[0] = view->y[1] = NAN;
}

/* ---- layout, focus ---- */

/* Describes the layout, and the smaller one that is drawn if the screen is too small. */
static void describe_layout(const struct session *session, struct buffer *text)
{
    const struct view *view = &session->view;
    const int width = session->front.width ? session->front.width : 80;
    const int height = session->front.height ? session->front.height : 24;
    const enum layout drawn = layout_drawn(view->layout, width, height);
    const struct layout_row *row = layout_row(view->layout);
    /* A pane that no layout has takes the first place of each. */
    const struct plot_row *focus = plot_row(view_focus(view));
    const bool guest = !focus->in_layouts && view->layout != LAYOUT_LOG;
    buffer_format(text, "layout %s: %s", row->row.name, row->row.brief);
    if (guest)
        buffer_format(text, "; the first pane shows %s until 'focus position'", focus->row.name);
    if (drawn == view->layout)
        return;
    buffer_format(text, "\nit needs %d columns", row->width);
    if (row->height)
        buffer_format(text, " and %d rows", row->height);
    buffer_format(text, ": at %dx%d %s is drawn, %s", width, height, layout_row(drawn)->row.name,
                  layout_row(drawn)->row.brief);
}

/* Chooses a layout, or the next one. */
HANDLER(layout)
{
    UNUSED(error);
    const struct argument_value *name = argument_value(args, "NAME");
    struct view *view = &session->view;
    if (name->count)
        view->layout = (enum layout)name->item->index;
    else if (has_argument(args, "next"))
        view->layout = (enum layout)(((size_t)view->layout + 1) % layout_catalog.count);
    if (name->count || has_argument(args, "next"))
        view->full = false;
    describe_layout(session, reply_buffer(reply));
    return note_change(session);
}

/* Chooses the pane that commands act on, if it has something to show; full shows it alone. */
HANDLER(focus)
{
    const struct argument_value *pane = argument_value(args, "PANE");
    struct view *view = &session->view;
    const enum plot_kind wanted =
        pane->count ? (enum plot_kind)pane->item->index : view_focus(view);
    const struct row *row = &plot_row(wanted)->row;
    /* A saved session may have one whose run has changed, or whose fit is gone. */
    if (pane->count && !session->execution.restoring && !plot_offered(session, wanted)) {
        struct buffer offered = {0};
        const bool some = session_run(session) || session_recording(session);
        error_at(error, pane->item->text, "the pane %s (%s) cannot be shown for this scene or run",
                 row->name, row->brief);
        for (size_t i = 0; i < plot_catalog.count && some; i++)
            if (plot_offered(session, (enum plot_kind)i))
                buffer_format(&offered, "%s%s", offered.len ? ", " : "",
                              catalog_row(&plot_catalog, i)->name);
        error_hint(error, offered.len ? "available now: %s" : "type: run, or: load FILE%s",
                   buffer_view(&offered));
        buffer_free(&offered);
        return false;
    }
    /* ranges belong to the pane that was in focus */
    if (wanted != view_focus(view))
        clear_ranges(view);
    view_focus_on(view, wanted);
    if (has_argument(args, "full") || has_argument(args, "shared"))
        view->full = has_argument(args, "full");
    reply_line(reply, "focus %s%s: %s", row->name, view->full ? " full" : "", row->brief);
    return note_change(session);
}

/* ---- ranges ---- */

static const struct row axes[] = {{"x", "", "horizontal axis", "", NULL},
                                  {"y", "", "vertical axis", "", NULL}};
const struct catalog axis_catalog = CATALOG("axis", axes);

/* Replies with the range of the horizontal or vertical axis of the pane in focus. */
static void reply_range(const struct session *session, bool x, struct reply *reply)
{
    const double *range = x ? session->view.x : session->view.y;
    const char *pane = plot_row(view_focus(&session->view))->row.name;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "range %s of %s: ", x ? "x" : "y", pane);
    if (isnan(range[0]))
        buffer_put(text, TEXT("auto"));
    else
        buffer_format(
            text, "%s to %s",
            SHOWN_VALUE(range[0], plot_quantity(session, view_focus(&session->view), x), 6),
            SHOWN_VALUE(range[1], plot_quantity(session, view_focus(&session->view), x), 6));
}

/* Fixes the range of an axis, makes it automatic, or shows it. */
HANDLER(range)
{
    const bool x = argument_value(args, "AXIS")->item->index == 0;
    const struct argument_value *value = argument_value(args, "FROM:TO");
    double *range = x ? session->view.x : session->view.y;
    if (value->count && text_is(text_trim(value->item->text), "auto")) {
        range[0] = range[1] = NAN;
    } else if (value->count) {
        struct parser parser = {session, args->scope, args->arena, value->item->text};
        struct item item = {0};
        if (!parse_range(&parser, "range", plot_quantity(session, view_focus(&session->view), x),
                         &item, error) ||
            !refuse_rest(&parser, &item, error))
            return false;
        if (isnan(item.range[0]) || isnan(item.range[1]))
            return error_at(error, value->item->text, "both ends of the range are needed, or auto");
        memcpy(range, item.range, sizeof item.range);
    }
    reply_range(session, x, reply);
    return note_change(session);
}

/* Sets span to the times [s] of the current run and recording together. Returns false if there is
 * neither. */
static bool whole_span(const struct session *session, double span[2])
{
    const struct run *run = session_run(session);
    const struct recording *recording = session_recording(session);
    span[0] = HUGE_VAL;
    span[1] = -HUGE_VAL;
    if (run) {
        const double a = trace_time(run->trace, 0), b = run->t;
        span[0] = fmin(a, b);
        span[1] = fmax(a, b);
    }
    if (recording) {
        span[0] = fmin(span[0], recording->window[0]);
        span[1] = fmax(span[1], recording->window[1]);
    }
    return span[1] > span[0];
}

/* Sets span to the times [s] that the screen shows. Returns false if there is no screen. */
static bool on_screen(const struct session *session, double span[2])
{
    const struct front *front = &session->front;
    return front->time_shown && front->time_shown(front->context, session, span);
}

/* Sets shown to the times [s] that plots show at present (as drawn on the screen, else the fixed
 * range, else the last window, else everything), and whole to all times. Moves the focus to the
 * position if its pane has no time axis but others are shown. Returns false with the error set. */
static bool shown_span(struct session *session, double shown[2], double whole[2],
                       struct error *error)
{
    struct view *view = &session->view;
    if (plot_quantity(session, view_focus(&session->view), true) != QUANTITY_TIME && view->full) {
        error_set(error, ERROR_COMMAND, "the pane %s has no time axis",
                  plot_row(view_focus(view))->row.name);
        return error_hint(error, "type: focus position, or: range x FROM:TO");
    }
    if (!whole_span(session, whole)) {
        error_set(error, ERROR_COMMAND, "nothing to show: there is no run and no recording");
        return error_hint(error, "type: run, or: load FILE");
    }
    if (plot_quantity(session, view_focus(&session->view), true) != QUANTITY_TIME) {
        clear_ranges(view);
        view_focus_on(view, PLOT_POSITION);
    }
    if (on_screen(session, shown))
        return true;
    memcpy(shown, isnan(view->x[0]) ? whole : view->x, 2 * sizeof *shown);
    if (isnan(view->x[0]) && view->window > 0)
        shown[0] = fmax(shown[0], shown[1] - view->window);
    return true;
}

/* Shows the times from begin [s] over width [s], moved into the whole span. A range as wide as the
 * whole becomes automatic, if the automatic range shows all of it. */
static void set_span(struct session *session, double begin, double width, const double whole[2])
{
    struct view *view = &session->view;
    const double max = whole[1] - whole[0];
    if (!(width < max)) {
        double shown[2];
        view->x[0] = view->x[1] = NAN;
        if (on_screen(session, shown) && shown[1] - shown[0] < max * (1 - 1e-9))
            memcpy(view->x, whole, sizeof view->x);
        return;
    }
    width = fmax(width, max / ZOOM_MAX);
    begin = fmin(fmax(begin, whole[0]), whole[1] - width);
    view->x[0] = begin;
    view->x[1] = begin + width;
}

/* Divides the time range by FACTOR, about the active cursor if it is in sight, else about the
 * middle. */
HANDLER(zoom)
{
    const double factor = argument_value(args, "FACTOR")->item->value.value;
    struct view *view = &session->view;
    double shown[2] = {0}, whole[2] = {0};
    if (!shown_span(session, shown, whole, error))
        return false;
    /* Zoom about the active cursor if it is in sight. */
    const double t = view->cursors.cursor[view->cursors.active].t;
    const bool at_cursor = view->cursors.shown && !view->cursors.plane &&
                           view->cursors.cursor[view->cursors.active].set && t > shown[0] &&
                           t < shown[1];
    const double centre = at_cursor ? t : 0.5 * (shown[0] + shown[1]);
    set_span(session, centre - (centre - shown[0]) / factor, (shown[1] - shown[0]) / factor, whole);
    reply_range(session, true, reply);
    return note_change(session);
}

/* Moves the time range. */
HANDLER(pan)
{
    const double shift = argument_value(args, "TIME")->item->value.value;
    double shown[2] = {0}, whole[2] = {0};
    if (!shown_span(session, shown, whole, error))
        return false;
    set_span(session, shown[0] + shift, shown[1] - shown[0], whole);
    reply_range(session, true, reply);
    return note_change(session);
}

/* Sets or shows the length of time that plots show. */
HANDLER(window)
{
    UNUSED(error);
    const struct argument_value *value = argument_value(args, "TIME");
    if (value->count || has_argument(args, "auto"))
        session->view.window = value->count ? value->item->value.value : 0;
    struct buffer *text = reply_buffer(reply);
    buffer_put(text, TEXT("window "));
    if (session->view.window > 0)
        buffer_measured(text, (struct measured){session->view.window, 0}, QUANTITY_TIME, 6);
    else
        buffer_put(text, TEXT("auto"));
    return note_change(session);
}

/* Chooses other runs that are drawn over the current one. */
HANDLER(overlay)
{
    const struct argument_value *runs = argument_value(args, "run");
    struct view *view = &session->view;
    int number[LIMIT_OVERLAY] = {0}, count = 0;
    for (int r = 0; r < session->runs.count; r++) {
        bool wanted = false;
        for (int i = 0; i < runs->count; i++)
            wanted |= runs->item[i].index < 0 || runs->item[i].index == r;
        if (!wanted || r == session->runs.current)
            continue;
        if (count == LIMIT_OVERLAY)
            return error_at(error, runs->where,
                            "at most %d other runs can be drawn over the current one",
                            LIMIT_OVERLAY);
        number[count++] = session->runs.slot[r]->run->number;
    }
    if (runs->count || has_argument(args, "off")) {
        memcpy(view->overlay, number, sizeof number);
        view->overlays = count;
    }
    struct buffer *text = reply_buffer(reply);
    buffer_put(text, TEXT("overlay"));
    for (int i = 0; i < view->overlays; i++)
        buffer_format(text, "%s %d", i ? "" : " run", view->overlay[i]);
    if (view->overlays == 0)
        buffer_put(text, TEXT(" off"));
    return note_change(session);
}

/* Sets or shows the length of the phase plot's trail. */
HANDLER(trail)
{
    UNUSED(error);
    const struct argument_value *value = argument_value(args, "PERIODS");
    if (value->count || has_argument(args, "all"))
        session->view.trail = value->count ? value->item->value.value : HUGE_VAL;
    struct buffer *text = reply_buffer(reply);
    buffer_put(text, TEXT("trail "));
    if (isinf(session->view.trail))
        buffer_put(text, TEXT("all"));
    else
        buffer_format(text, "%s periods", SHOWN_SHORT(session->view.trail, 6));
    return note_change(session);
}

/* ---- screenshot ---- */

/* Writes the screen to a file or to the reply. */
HANDLER(screenshot)
{
    const struct argument_value *file = argument_value(args, "FILE");
    const struct front *front = &session->front;
    const bool possible = file->count ? front->screenshot != NULL : front->screen != NULL;
    if (!possible) {
        error_set(error, ERROR_COMMAND, "this program has no screen");
        return error_hint(
            error, "'plot position' draws a figure, 'plot position > figure.txt' writes one");
    }
    if (file->count) {
        const struct text name = file->item->text;
        const char *path = arena_text(args->arena, name);
        if (!path)
            return error_memory(error);
        if (!front->screenshot(front->context, session, path,
                               session_policy(session, has_argument(args, "force")), error)) {
            error->where = error->where.data ? error->where : name;
            return false;
        }
        struct buffer shown = {0};
        safe_text(&shown, name, false);
        reply_line(reply, "screen written to %s", buffer_view(&shown));
        buffer_free(&shown);
        return true;
    }
    return front->screen(front->context, session, reply_buffer(reply), error);
}
#endif

COMMAND(layout, .group = "PLOT", .flags = COMMAND_ANYTIME | COMMAND_RESTORES,
        ARGUMENTS(WORD("next", TYPE_NONE, .group = 1),
                  PLACE("NAME", TYPE_CHOICE, .choices = &layout_catalog, .group = 1)))

COMMAND(focus, .group = "PLOT", .flags = COMMAND_ANYTIME | COMMAND_RESTORES,
        ARGUMENTS(PLACE("PANE", TYPE_CHOICE, .choices = &pane_catalog),
                  WORD("full", TYPE_NONE, .group = 1), WORD("shared", TYPE_NONE, .group = 1)))

COMMAND(range, .group = "PLOT", .flags = COMMAND_ANYTIME | COMMAND_RESTORES,
        ARGUMENTS(PLACE("AXIS", TYPE_CHOICE, .flags = ARG_REQUIRED, .choices = &axis_catalog),
                  PLACE("FROM:TO", TYPE_REST)))

COMMAND(zoom, .group = "PLOT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("FACTOR", TYPE_VALUE, .flags = ARG_REQUIRED, .quantity = QUANTITY_NUMBER)))

COMMAND(pan, .group = "PLOT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("TIME", TYPE_VALUE, .flags = ARG_REQUIRED | ARG_NEGATIVE,
                        .quantity = QUANTITY_TIME)))

COMMAND(window, .group = "PLOT", .flags = COMMAND_ANYTIME | COMMAND_RESTORES,
        ARGUMENTS(WORD("auto", TYPE_NONE, .group = 1),
                  PLACE("TIME", TYPE_VALUE, .quantity = QUANTITY_TIME, .group = 1)))

COMMAND(overlay, .group = "PLOT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(WORD("off", TYPE_NONE, .group = 1),
                  WORD("run", TYPE_RUN, .flags = ARG_MANY | ARG_ALL, .group = 1)))

COMMAND(trail, .group = "PLOT", .flags = COMMAND_ANYTIME | COMMAND_RESTORES,
        ARGUMENTS(WORD("all", TYPE_NONE, .group = 1),
                  PLACE("PERIODS", TYPE_VALUE, .quantity = QUANTITY_NUMBER, .group = 1)))

COMMAND(screenshot, .group = "PLOT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("FILE", TYPE_FILE), OPTION("force", TYPE_NONE)))
