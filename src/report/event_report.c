/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reports what the events of a run recorded: as lines and records, as a table for files, and as
 * warnings where events may have been missed. */
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/session/events.h>
#include <hooke/scene/typed.h>

/* Returns the name of the event that made record i of a run. */
static const char *event_name(const struct run_slot *slot, size_t i)
{
    return slot->events->line[run_event_record(slot->run, i)->event].name;
}

/* Returns the number of values that a record shows: the state variables, then the observed
 * expressions. */
static int event_column_count(const struct run *run)
{
    return run->system.n + model_observed(run->system.model);
}

/* Returns the name and the quantity of value `column` of a record. */
static struct variable event_column(const struct run *run, int column)
{
    const int n = run->system.n;
    return column < n ? system_variable(&run->system, column)
                      : model_observed_variable(run->system.model, column - n);
}

/* Computes value `column` at the state of record i. */
static double event_column_value(const struct run *run, size_t i, int column)
{
    const double *y = run_event_record_state(run, i);
    const int n = run->system.n;
    return column < n ? y[column]
                      : system_observe(&run->system, column - n, run_event_record(run, i)->t, y);
}

/* Replies with event record number i of the slot's run: a line "1 NAME t = ... y = ..." and a
 * record `event` for programs. */
static void reply_event_record(const struct session *session, const struct run_slot *slot, size_t i,
                               struct reply *reply)
{
    const struct run *run = slot->run;
    const struct event_record *record = run_event_record(run, i);
    const int digits = session->setup.settings.digits;
    struct buffer *text = reply_buffer(reply);
    buffer_format(text, "%4zu  %-10s t = %s", i + 1, event_name(slot, i),
                  SHOWN_VALUE(record->t, QUANTITY_TIME, digits > 6 ? digits : 6));
    for (int c = 0; c < event_column_count(run); c++) {
        const struct variable column = event_column(run, c);
        buffer_format(text, "  %s = %s", column.name,
                      SHOWN_VALUE(event_column_value(run, i, c), column.quantity, digits));
    }
    reply_begin(reply, "event");
    reply_int(reply, "run", run->number);
    reply_string(reply, "name", event_name(slot, i));
    const char *direction;
    if (record->direction > 0)
        direction = "rising";
    else
        direction = record->direction < 0 ? "falling" : "touching";
    reply_string(reply, "direction", direction);
    reply_real(reply, "t", record->t);
    reply_object(reply, "state");
    for (int c = 0; c < event_column_count(run); c++) {
        const struct variable column = event_column(run, c);
        reply_real(reply, column.name, event_column_value(run, i, c));
    }
    reply_close(reply);
    reply_end(reply);
}

/* Writes a record with the number of times an event happened, whether that number is complete, and
 * the interval of time in which some may have been missed. */
static void reply_event_count(const struct run_slot *slot, int event,
                              const struct event_doubt *doubt, struct reply *reply)
{
    const size_t all = run_event_records(slot->run);
    long long count = 0;
    for (size_t i = 0; i < all; i++)
        count += run_event_record(slot->run, i)->event == event;
    reply_begin(reply, "events");
    reply_int(reply, "run", slot->run->number);
    reply_string(reply, "name", slot->events->line[event].name);
    reply_int(reply, "count", count);
    reply_bool(reply, "complete", doubt->steps == 0);
    reply_real(reply, "doubt_from", doubt->steps ? doubt->t_first : NAN);
    reply_real(reply, "doubt_to", doubt->steps ? doubt->t_last : NAN);
    reply_end(reply);
}

/* Warns once for a run of each event that may have been missed in some steps, and of the condition
 * of `run until`. */
void reply_event_doubts(struct run_slot *slot, struct reply *reply)
{
    struct run *run = slot->run;
    bool said = false;
    for (int i = 0; slot->events && i < slot->events->count; i++) {
        const struct event_doubt doubt = run_event_doubt(run, i);
        if (reply_wants_records(reply))
            reply_event_count(slot, i, &doubt, reply);
        if (doubt.steps == 0 || run->warned_doubt)
            continue;
        reply_warning(reply,
                      "event %s may be incomplete from t = %.6g s to %.6g s (%lld step%s): %s",
                      slot->events->line[i].name, doubt.t_first, doubt.t_last,
                      (long long)doubt.steps, plural_s(doubt.steps),
                      doubt.is_close ? "there it comes closer to 0 than the accuracy of the run"
                                     : "the steps were longer than the event's time scale");
        said = true;
    }
    const struct event_doubt doubt = run_event_doubt(run, LIMIT_EVENTS);
    if (doubt.steps > 0 && !run->warned_doubt) {
        reply_warning(reply,
                      "the condition may have been true before, from t = %.6g s to %.6g s (%lld "
                      "step%s) because the steps were longer than its time scale",
                      doubt.t_first, doubt.t_last, (long long)doubt.steps, plural_s(doubt.steps));
        said = true;
    }
    run->warned_doubt = run->warned_doubt || said;
}

/* Replies with all event records of the current run, or tells how to get some. */
void reply_event_records(const struct session *session, struct reply *reply)
{
    const struct run *run = session_run(session);
    for (size_t i = 0; run && i < run_event_records(run); i++)
        reply_event_record(session, session->runs.slot[session->runs.current], i, reply);
    if (!run || run_event_records(run) == 0)
        reply_line(
            reply,
            "no events happened; 'event NAME when EXPR do record' records one in the next run");
}

/* Makes export->table of all event records of the current run: event, time, direction, and the
 * values of the state at that time. Returns false with an error if there are none or if out of
 * memory. */
bool export_event_records(const struct session *session, struct export *export, struct error *error)
{
    const struct run *run = session_run(session);
    const size_t rows = run ? run_event_records(run) : 0;
    if (rows == 0) {
        error_set(error, ERROR_COMMAND, "no events happened");
        return error_hint(error, "type: event NAME when EXPR do record; run");
    }
    const size_t columns = (size_t)event_column_count(run);
    struct arena *arena = export->arena;
    struct table_column *exported = arena_array(arena, columns + 3, sizeof *exported);
    const char **name = arena_array(arena, rows, sizeof *name);
    double *t = arena_array(arena, rows, sizeof *t),
           *direction = arena_array(arena, rows, sizeof *direction);
    if (!exported || !name || !t || !direction)
        return error_memory(error);
    for (size_t i = 0; i < rows; i++) {
        name[i] = event_name(session->runs.slot[session->runs.current], i);
        t[i] = run_event_record(run, i)->t;
        direction[i] = run_event_record(run, i)->direction;
    }
    exported[0] = (struct table_column){.name = "event", .unit = "", .text = name};
    exported[1] = (struct table_column){.name = "t", .unit = "s", .value = t};
    exported[2] = (struct table_column){.name = "direction", .unit = "", .value = direction};
    for (int c = 0; c < (int)columns; c++) {
        const struct variable column = event_column(run, c);
        double *value = arena_array(arena, rows, sizeof *value);
        const char *title = arena_text(arena, text_of(column.name));
        if (!value || !title)
            return error_memory(error);
        for (size_t i = 0; i < rows; i++)
            value[i] = event_column_value(run, i, c);
        exported[c + 3] = (struct table_column){
            .name = title, .unit = quantity_unit(column.quantity), .value = value};
    }
    export->table = (struct table){.column = exported, .columns = (int)columns + 3, .rows = rows};
    return export_run_keys(session, session->runs.current, export, error);
}
