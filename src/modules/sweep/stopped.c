/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Keeps a sweep that Ctrl-C has stopped, and completes it by `continue`. */
#include "modules/sweep/handlers.h"

#include <stdlib.h>
#include <string.h>

/* Frees a stopped sweep; NULL is allowed. */
static void stopped_free(struct stopped_sweep *stopped)
{
    if (!stopped)
        return;
    free(stopped->statement);
    buffer_free(&stopped->made);
    sweep_free(&stopped->found);
    free(stopped);
}

void sweep_part_free(void *part)
{
    stopped_free(((struct sweep_part *)part)->stopped);
}

/* Frees the stopped sweep. */
void sweep_forget_stopped(struct session *session)
{
    struct sweep_part *part = session_part_if_made(session, &sweep_module);
    if (!part)
        return;
    stopped_free(part->stopped);
    part->stopped = NULL;
}

bool sweep_waits(const struct session *session)
{
    const struct sweep_part *part = session_part_if_made(session, &sweep_module);
    return part && part->stopped;
}

/* Stores a stopped sweep with its statement and set-up for `continue`, and moves its results out of
 * `sweep`. If out of memory it cannot be continued. */
void sweep_keep_stopped(struct session *session, struct text statement, struct sweep *sweep)
{
    sweep_forget_stopped(session);
    struct sweep_part *part = session_part(session, &sweep_module);
    struct stopped_sweep *stopped = part ? calloc(1, sizeof *stopped) : NULL;
    if (stopped && (stopped->statement = strndup(statement.data, statement.len))) {
        session_save_motion(session, &stopped->made);
        stopped->found = *sweep;
        *sweep = (struct sweep){.count = 0};
        part->stopped = stopped;
    } else {
        stopped_free(stopped); /* cannot be continued without memory */
    }
}

/* Lets the log have the whole sweep instead of `continue`, so that a script made of it does not
 * depend on the stop. */
static void log_whole_sweep(struct session *session, const char *statement)
{
    struct buffer text = {0};
    buffer_format(&text, "sweep %s", statement);
    session->execution.meant = text.failed ? NULL : strdup(buffer_view(&text));
    buffer_free(&text);
}

/* Completes the stopped sweep, if the set-up is still the same, and replies with it. A sweep that
 * is stopped again, or that fails, can be continued again. Returns false with an error. */
bool sweep_continue(struct session *session, const struct arguments *args, struct reply *reply,
                    struct error *error)
{
    struct sweep_part *part = session_part(session, &sweep_module);
    struct stopped_sweep *stopped = part->stopped;
    struct buffer now = {0};
    session_save_motion(session, &now);
    const bool same = text_equal(buffer_text(&now), buffer_text(&stopped->made));
    buffer_free(&now);
    if (!same) {
        error_set(error, ERROR_COMMAND, "the sweep that was stopped had another set-up");
        return error_hint(error,
                          "'sweep' starts it again with the present set-up, 'run' starts a run");
    }
    const char *statement = arena_text(args->arena, text_of(stopped->statement));
    if (!statement)
        return error_memory(error);
    part->stopped = NULL; /* if it is stopped again, it is stored anew */
    const bool ok =
        sweep_statement(session, args, text_of(statement), &stopped->found, reply, error);
    session->studies.points = 0;
    if (ok)
        log_whole_sweep(session, statement);
    if (ok || part->stopped)
        stopped_free(stopped);
    else
        part->stopped = stopped;
    return ok;
}
