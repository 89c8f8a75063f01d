/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command start, which sets states from which trajectories are drawn in the phase portrait. */
#ifndef COMMAND_ROWS
#include <hooke/base/unit.h>
#include <hooke/plot.h>
#include <hooke/report.h>
#include "modules/dynamics/handlers.h"

#include <math.h>
#include <string.h>

/* Sets `state` to that of the scene's run, or to the scene's start. It is NAN, with `error` filled,
 * if the scene has no start. */
static void present_state(const struct session *session, const struct system *system, double *state,
                          struct error *error)
{
    const struct run *run = session_run(session);
    struct system start;
    for (int i = 0; i < system->n; i++)
        state[i] = NAN;
    if (run && run->scene.model == system->model)
        memcpy(state, run->y, (size_t)system->n * sizeof *state);
    else if (scene_bind_motion(&session->setup.scene, &start, error))
        memcpy(state, start.start, (size_t)system->n * sizeof *state);
}

/* Sets `state` from the cursor on the portrait, or from the run at cursor A. Returns false with
 * `error` filled if there is no cursor. */
static bool state_at_cursor(const struct session *session, const struct system *system,
                            double *state, struct error *error)
{
    const struct run *run = session_run(session);
    const struct cursors *cursors = &session->view.cursors;
    struct plot_plane plane;
    if (cursors->shown && cursors->plane && cursor_plane(session, &plane)) {
        struct error unknown; /* variables that the plane does not show may be unknown */
        present_state(session, system, state, &unknown);
        for (int k = 0; k < 2; k++)
            state[plane.variable[k]] = cursors->point[k];
        return true;
    }
    if (!run || run->scene.model != system->model || !cursors->cursor[0].set) {
        error_set(error, ERROR_COMMAND, "there is no cursor on a run of this scene");
        return error_hint(error, "cursor A TIME sets one");
    }
    size_t row = trace_row_at(run->trace, cursors->cursor[0].t);
    row = row < trace_count(run->trace) ? row : trace_count(run->trace) - 1;
    memcpy(state, trace_state(run->trace, row), (size_t)system->n * sizeof *state);
    return true;
}

/* Reads one item NAME=VALUE of the argument into `state`. Returns false with *error. */
static bool read_start_value(struct session *session, const struct arguments *args,
                             struct text item, const struct system *system, double *state,
                             struct error *error)
{
    struct parser parser = {session, args->scope, args->arena, item};
    struct item value = {0};
    const int i = read_variable(&parser, item, system, "start", "1", error);
    if (i < 0)
        return false;
    const struct variable variable = system_variable(system, i);
    if (!parse_value(&parser, variable.name, variable.quantity, &value, error) ||
        !refuse_rest(&parser, &value, error))
        return false;
    state[i] = value.value.value;
    return true;
}

/* Lists the starts from number `first` (counted from 0) on. */
static void list_starts(const struct session *session, const struct system *system, int first,
                        struct reply *reply)
{
    const struct view *view = &session->view;
    const int starts = view->start_n == system->n ? view->starts : 0;
    if (starts == 0)
        reply_line(reply, "no trajectory has been started: start %s=VALUE",
                   system->model->variable[0].name);
    for (int k = first; k < starts; k++) {
        struct buffer *text = reply_buffer(reply);
        buffer_format(text, "%3d ", k + 1);
        for (int i = 0; i < system->n; i++) {
            buffer_char(text, ' ');
            put_variable(text, system, i, view->start[k][i], 6);
        }
        reply_begin(reply, "start");
        reply_int(reply, "n", k + 1);
        reply_state(reply, system, "state", view->start[k]);
        reply_end(reply);
    }
}

/* Lists, adds or clears starts. A new one is the state of the run, the cursor, or the scene's
 * start, with the given values. */
HANDLER(start)
{
    const struct argument_value *what = argument_value(args, "NAME=VALUE");
    struct view *view = &session->view;
    const struct model *model = session->setup.scene.model;
    const struct system system = {.model = model, .n = model->n};
    double state[LIMIT_VARIABLES] = {0};
    struct error unknown = {0}; /* reason why there is no present state */
    if (system.n < 2 || system.n > STARTS_VARIABLES)
        return error_set(error, ERROR_COMMAND, "portraits work for scenes with 2 to %d variables",
                         STARTS_VARIABLES);
    struct text rest = what->count ? text_trim(what->item->text) : TEXT(""), item;
    if (text_is(rest, "clear")) {
        view->starts = 0;
        reply_line(reply, "all starts are removed; no trajectory is drawn");
        session_changed(session);
        return true;
    }
    if (rest.len == 0) {
        list_starts(session, &system, 0, reply);
        return true;
    }
    if (text_is(rest, "cursor")) {
        if (!state_at_cursor(session, &system, state, error))
            return false;
        rest = TEXT("");
    } else {
        present_state(session, &system, state, &unknown);
    }
    while (rest.len > 0 && text_split(&rest, ',', &item))
        if (!read_start_value(session, args, text_trim(item), &system, state, error))
            return false;
    for (int i = 0; i < system.n; i++)
        if (isnan(state[i])) {
            *error = unknown;
            return false;
        }
    if (view->start_n != system.n)
        view->starts = 0;
    if (view->starts == LIMIT_STARTS) {
        error_at(error, what->item->text, "there are already %d starts", LIMIT_STARTS);
        return error_hint(error, "start clear");
    }
    view->start_n = system.n;
    memset(view->start[view->starts], 0, sizeof view->start[0]);
    memcpy(view->start[view->starts++], state, (size_t)system.n * sizeof *state);
    list_starts(session, &system, view->starts - 1, reply);
    session_changed(session);
    return true;
}
#endif

COMMAND(start, .group = "DYNAMICS", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("NAME=VALUE", TYPE_REST)))
