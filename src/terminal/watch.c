/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Callbacks of the session in the panes: the terminal is served between two slices of a run, and
 * the screen is written into files. */
#include "terminal/panes.h"
#include <hooke/base/cancel.h>

#include <limits.h>

/* Draws the prompt if keys were typed during a run and the rest of the screen has not changed. */
static void echo_typed(struct panes *panes)
{
    if (panes->echo_stale && !panes->screen_stale)
        panes_show(panes, true, INT_MAX);
}

/* Serves the terminal between two slices of a live run until `deadline` [clock_ns]: keys, lines,
 * drawing. Returns false if the run must stop. */
static bool panes_slice(void *context, struct session *session, int64_t deadline)
{
    struct panes *panes = context;
    (void)session;
    signals_busy(false);
    panes->running = true;
    /* keys are handled before a frame, which may take as long as a slice, and after it */
    panes_read(panes, 0);
    do {
        panes_process(panes);
        echo_typed(panes);
        panes_wait(panes, deadline);
        panes_process(panes);
        echo_typed(panes);
    } while (clock_ns() < deadline && !panes_over(panes) && !panes->interrupted);
    panes->running = false;
    signals_busy(true);
    const bool go_on = !panes_over(panes) && !panes->interrupted;
    panes->interrupted = false;
    return go_on;
}

static void panes_clear_log(void *context)
{
    log_clear(&panes_session(context)->log);
}

/* Appends the present screen as text, with the command line that is being edited; context is the
 * struct panes. Returns false with *error. */
static bool shot_text(void *context, const struct session *session, struct buffer *text,
                      struct error *error)
{
    struct panes *panes = context;
    struct prompt_line prompt;
    struct buffer scratch = {0};
    panes_prompt(panes, &prompt, &scratch);
    const bool ok =
        screenshot_text(session, &prompt, panes->screen.width, panes->screen.height, text, error);
    buffer_free(&scratch);
    return ok;
}

/* Writes the present screen to a file, in the format that the path's ending names, with the command
 * line that is being edited; context is the struct panes, and `policy` says whether a file may be
 * replaced. Returns false with *error. */
static bool shot_file(void *context, const struct session *session, const char *path,
                      struct write_policy policy, struct error *error)
{
    struct panes *panes = context;
    struct prompt_line prompt;
    struct buffer scratch = {0};
    panes_prompt(panes, &prompt, &scratch);
    const bool ok = screenshot_file(session, &prompt, panes->screen.width, panes->screen.height,
                                    path, policy, error);
    buffer_free(&scratch);
    return ok;
}

/* Changes the front end: to the plain prompt, or draws everything again. Returns false with an
 * error for the panes themselves. */
static bool panes_change_front(void *context, enum front_change panes_change_front,
                               struct error *error)
{
    struct panes *panes = context;
    switch (panes_change_front) {
    case FRONT_PLAIN:
        panes->program->next = FRONT_IS_PLAIN;
        return true;
    case FRONT_REDRAW:
        panes_repaint(panes);
        return true;
    case FRONT_PANES:
        break;
    }
    return error_set(error, ERROR_COMMAND, "the panes are already shown");
}

/* Shows the progress of a study in the row for messages on keys, and clears that row at its end
 * (fraction > 1). Nothing is shown for a run, which the panes draw. */
static void show_progress(void *context, const struct run *run, double fraction)
{
    struct panes *panes = context;
    bool is_finished;
    if (run) {
        return;
    }
    if (fraction <= 1) {
        panes_save(panes, false);
    }
    const bool due = progress_due(fraction, &is_finished);
    if (!due && !is_finished) {
        return;
    }
    buffer_clear(&panes->notice);
    if (due) {
        progress_text(panes->program->session, run, fraction, &panes->notice);
    }
    const bool busy = signals_busy(false); /* no stop while it is drawn */
    panes_show(panes, false, INT_MAX);
    signals_busy(busy);
}

static void panes_executed(void *context)
{
    panes_save(context, true);
}

/* Sets the callbacks of the panes that the session calls. */
void watch_offer(struct panes *panes, struct front *front)
{
    *front = (struct front){.interactive = true,
                            .utf8 = front->utf8,
                            .cancel = &interrupt,
                            .feed = front->feed,
                            .context = panes,
                            .clear = panes_clear_log,
                            .progress = show_progress,
                            .executed = panes_executed,
                            .watched = true,
                            .slice = panes_slice,
                            .screenshot = shot_file,
                            .screen = shot_text,
                            .time_shown = front->time_shown,
                            .change = panes_change_front};
}
