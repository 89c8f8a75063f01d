/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A sweep that Ctrl-C has stopped, and `continue`. */
#include "command/study/sweep.h"

#include <stdlib.h>
#include <string.h>

void sweep_keep_stopped(struct session *session, struct text statement, struct sweep *sweep)
{
    struct stopped_sweep *stopped = calloc(1, sizeof *stopped);
    session_forget_sweep(session);
    session->stopped = stopped;
    if (stopped && (stopped->statement = strndup(statement.at, statement.len))) {
        session_save_motion(session, &stopped->made);
        stopped->found = *sweep;
        *sweep = (struct sweep){.count = 0};
    } else {
        session_forget_sweep(session); /* without memory it cannot go on */
    }
}

/* In the log stands the sweep: a script that is made of it has not been stopped. */
static void mean_sweep(struct session *session, const char *statement)
{
    struct buffer text = {0};
    buffer_format(&text, "sweep %s", statement);
    session->meant = text.failed ? NULL : strdup(buffer_view(&text));
    buffer_free(&text);
}

bool sweep_continue(struct session *session, const struct arguments *args, struct reply *reply,
                    struct error *error)
{
    struct stopped_sweep *stopped = session->stopped;
    struct buffer now = {0};
    session_save_motion(session, &now);
    const bool same = text_equal(buffer_text(&now), buffer_text(&stopped->made));
    buffer_free(&now);
    if (!same) {
        error_set(error, ERROR_COMMAND, "the sweep that was stopped had another set-up");
        return error_hint(error, "'sweep' starts it with the present one, 'run' a run");
    }
    const char *statement = arena_text(args->arena, text_of(stopped->statement));
    if (!statement)
        return error_memory(error);
    session->stopped = NULL; /* where it is stopped again, that is another one */
    const bool ok =
        sweep_statement(session, args, text_of(statement), &stopped->found, reply, error);
    session->study_points = 0;
    if (ok)
        mean_sweep(session, statement);
    struct stopped_sweep *again = session->stopped;
    session->stopped = stopped;
    if (ok || again) {
        session_forget_sweep(session);
        session->stopped = again;
    }
    return ok;
}
