/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands for the list of runs: runs, use, rename, drop, note. */
#ifndef COMMAND_ROWS
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Replies with one run: a line and a record. */
static void reply_row(const struct session *session, int index, struct reply *reply)
{
    const struct run_slot *slot = session->runs.slot[index];
    const struct run *run = slot->run;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%c %3d  %-18s ", index == session->runs.current ? '*' : ' ', run->number,
                  run->method->row.name);
    if (run->plan.adaptive)
        buffer_format(text, "tol=%.3g", run->settings.tol);
    else
        buffer_format(text, "dt=%s", SHOWN_QUANTITY(run->settings.dt, QUANTITY_TIME, 4));
    buffer_format(text, "  t=%.6g s  %lld steps  %s", run->t, (long long)run->steps,
                  run_status(run));
    if (run->name[0]) {
        buffer_put(text, TEXT("  "));
        safe_text(text, text_of(run->name), false);
    }
    if (slot->note) {
        buffer_put(text, TEXT("  # "));
        safe_text(text, text_of(slot->note), false);
    }
    const struct run_row row = {slot, slot->run, index == session->runs.current};
    reply_records(reply, "runs", &run_columns, &row, 1);
}

/* Lists all runs. */
HANDLER(runs)
{
    UNUSED(args);
    UNUSED(error);
    if (session->runs.count == 0)
        reply_line(reply, "no runs");
    for (int i = 0; i < session->runs.count; i++)
        reply_row(session, i, reply);
    return true;
}

/* Uses a name that is not a run as that of a module's result. */
static bool use_label(HANDLER_PARAMETERS)
{
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->labels.use)
            return module_list[i]->labels.use(session, args, reply, error);
    return module_is_in("use LABEL", TEXT(""), error) &&
           error_set(error, ERROR_COMMAND, "'use' needs a run");
}

/* Makes a run the current one. */
HANDLER(use)
{
    const struct argument_value *run = argument_value(args, "N|LABEL");
    if (!run->count || run->item->index < 0)
        return use_label(session, args, reply, error);
    session->runs.current = run->item->index;
    session->data_is_latest = false;
    session_changed(session);
    reply_row(session, session->runs.current, reply);
    return true;
}

/* Gives a run a name that no other run has. */
HANDLER(rename)
{
    const struct text name = argument_value(args, "NAME")->item->text;
    struct run *run = session->runs.slot[argument_value(args, "N")->item->index]->run;
    if (name.len == 0 || name.len > LIMIT_NAME || peek_name(name).len != name.len)
        return error_at(
            error, name,
            "a name begins with a letter, followed by at most %d letters, digits, _ and -",
            LIMIT_NAME);
    const int other = session_find_run(session, name);
    if (other >= 0 && session->runs.slot[other]->run != run)
        return error_at(error, name, "run %d already has that name",
                        session->runs.slot[other]->run->number);
    if (text_is(name, "all"))
        return error_at(error, name, "'all' means every run and cannot be the name of one");
    memset(run->name, 0, sizeof run->name);
    memcpy(run->name, name.data, name.len);
    session_changed(session);
    reply_line(reply, "run %d is called %s", run->number, run->name);
    return true;
}

/* Removes runs, except for one in progress. */
HANDLER(drop)
{
    const struct argument_value *which = argument_value(args, "N");
    bool gone[LIMIT_RUNS] = {false};
    int count = 0;
    for (int i = 0; i < which->count; i++)
        for (int r = 0; r < session->runs.count; r++)
            gone[r] |= which->item[i].index < 0 || which->item[i].index == r;
    if (session->live.state == LIVE_RUNNING && gone[session->runs.current]) {
        error_at(error, which->where, "run %d is still in progress and cannot be dropped",
                 session->runs.slot[session->runs.current]->run->number);
        return error_hint(error, "'pause' or Ctrl-C pauses it");
    }
    for (int r = session->runs.count - 1; r >= 0; r--)
        if (gone[r]) {
            session_drop_run(session, r);
            count++;
        }
    reply_line(reply, "%d run%s dropped, %d left", count, plural_s(count), session->runs.count);
    return true;
}

/* Attaches a note to the current run. */
HANDLER(note)
{
    const struct text text = argument_value(args, "TEXT")->item->text;
    if (session->runs.current < 0) {
        error_set(error, ERROR_COMMAND, "there is no run for the note");
        return error_hint(error, "type: run");
    }
    struct run_slot *slot = session->runs.slot[session->runs.current];
    char *note = strndup(text.data, text.len);
    if (!note)
        return error_memory(error);
    free(slot->note);
    slot->note = note;
    session->changes++;
    reply_line(reply, "noted for run %d", slot->run->number);
    return true;
}
#endif

COMMAND(runs, .group = "RUNS", .flags = COMMAND_ANYTIME | COMMAND_TABLES)

COMMAND(use, .group = "RUNS", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("N|LABEL", TYPE_KEPT, .group = 1), WORD("orbit", TYPE_INTEGER, .group = 1),
                  WORD("equilibrium", TYPE_INTEGER, .group = 1)))

COMMAND(rename, .group = "RUNS", .flags = COMMAND_CHANGES | COMMAND_ANYTIME,
        ARGUMENTS(PLACE("N", TYPE_RUN, .flags = ARG_REQUIRED),
                  PLACE("NAME", TYPE_TEXT, .flags = ARG_REQUIRED)))

COMMAND(drop, .group = "RUNS", .flags = COMMAND_CHANGES | COMMAND_ANYTIME,
        ARGUMENTS(PLACE("N", TYPE_RUN, .flags = ARG_REQUIRED | ARG_MANY | ARG_ALL)))

COMMAND(note, .group = "RUNS", .flags = COMMAND_ANYTIME | COMMAND_RESTORES,
        ARGUMENTS(PLACE("TEXT", TYPE_REST, .flags = ARG_REQUIRED)))
