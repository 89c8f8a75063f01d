/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The results that have a table (for export, plots, documents): those made from the session's state
 * when asked for, and the last one of each kind that a command reported. */
#include <hooke/report.h>

#include <math.h>

/* ---- tables made from the session's state ---- */

/* Makes a table of all measurements of the session. Returns false with an error if there are none.
 */
static bool export_measurements(const struct session *session, struct export *export,
                                struct error *error)
{
    if (session->measurements == 0) {
        error_set(error, ERROR_COMMAND, "there is no measurement to export");
        return error_hint(error, "type: measure period");
    }
    return columns_table(&measurement_columns, session->measurement, (size_t)session->measurements,
                         export->arena, &export->table)
               ? export_scene_keys(session, export, error)
               : error_memory(error);
}

/* Makes a table with a row for each run. Returns false with an error if there are no runs. */
bool export_run_table(const struct session *session, struct export *export, struct error *error)
{
    struct run_row *row = arena_array(export->arena, (size_t)session->runs.count + 1, sizeof *row);
    if (session->runs.count == 0) {
        error_set(error, ERROR_COMMAND, "there is no run for a table");
        return error_hint(error, "type: compare euler verlet");
    }
    for (int i = 0; row && i < session->runs.count; i++)
        row[i] = (struct run_row){session->runs.slot[i], session->runs.slot[i]->run,
                                  i == session->runs.current};
    return row && columns_table(&run_columns, row, (size_t)session->runs.count, export->arena,
                                &export->table)
               ? export_scene_keys(session, export, error)
               : error_memory(error);
}

/* ---- the catalog of results ---- */

/* A result that a command reported last; `command` makes one. */
#define FOUND(name, brief, command)                                                                \
    {                                                                                              \
        .row = {name, "", brief, "", NULL}, .type = command                                        \
    }
/* The same for a study, which `export FILE table` takes if it is the latest. */
#define STUDIED(name, brief)                                                                       \
    {                                                                                              \
        .row = {name, "", brief, "", NULL}, .study = true, .type = name                            \
    }

static const struct result_row rows[] = {
    {.row = {"runs", "", "a row for each run", "", NULL}, .table = export_run_table},
    {.row = {"run", "", "the present state of the current run", "", NULL},
     .say = reply_current_run,
     .type = "run"},
    {.row = {"measurements", "", "all measurements", "", NULL}, .table = export_measurements},
    {.row = {"events", "", "events of the current run", "", NULL},
     .kind = "event",
     .table = export_event_records},
    FOUND("fit", "the last fit: its values, laws and parameters", "fit"),
    FOUND("measure", "the last value that was measured", "measure period"),
    FOUND("peak", "lines of the last spectrum", "plot spectrum"),
    FOUND("recording", "properties of recordings, after data or load", "load FILE"),
    FOUND("clean", "what is wrong with a recording", "data clean"),
    FOUND("adopt", "values adopted from a fit", "adopt"),
    FOUND("cursor", "positions and values of the cursors", "cursor A 0"),
    {.row = {"list", "", "the rows of the last list", "", NULL},
     .type = "list methods",
     .sceneless = true},
    FOUND("loaded", "a table read from a file", "load FILE"),
#include "lists/results.def"
};

const struct catalog result_catalog = CATALOG("result", rows);

/* Returns the result that a row of the catalog belongs to. */
static const struct result_row *result_at(const struct row *row)
{
    return (const struct result_row *)(const void *)row;
}

/* Returns the kind of the records that are its rows. */
static struct text result_kind(const struct result_row *row)
{
    return text_of(row->kind ? row->kind : row->row.name);
}

/* Returns the result whose records have this kind, or NULL. */
static const struct result_row *result_of_kind(struct text kind)
{
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        if (text_equal(kind, result_kind(&rows[i])))
            return &rows[i];
    return NULL;
}

/* Makes a table of a result that no command has stored, because it describes the present session
 * (such as the current run): collects the records that it replies, without printing them, in
 * `records`, and stores these under the result's name. */
static void store_present_records(struct session *session, const struct result_row *row)
{
    struct table_store records = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){NULL, NULL, NULL});
    reply.muted = true;
    reply.store = &records;
    row->say(session, &reply);
    reply_free(&reply);
    session_keep_results(session, &records, row->row.name);
}

/* Makes the table of a result, or takes the last stored one. Returns false with an error and the
 * command that makes one if there is none. */
bool export_result(struct session *session, const struct row *result, struct export *export,
                   struct error *error)
{
    const struct result_row *row = result_at(result);
    if (row->table)
        return row->table(session, export, error);
    if (row->say)
        store_present_records(session, row);
    const struct stored_table *stored = table_store_find(&session->studies.found, result_kind(row));
    if (!stored) {
        error_set(error, ERROR_COMMAND, "there is no table of %s yet", result->name);
        return error_hint(error, "type: %s", row->type);
    }
    export->table = stored->table;
    return true;
}

bool result_is_kept(const struct session *session, const struct row *result)
{
    return table_store_find(&session->studies.found, result_kind(result_at(result))) != NULL;
}

/* Exports the result of the last study, or the table of runs if there was a run since. */
bool export_latest(struct session *session, struct export *export, struct error *error)
{
    const struct row *studied =
        session->studies.at_run == session->runs.next_number && session->studies.last
            ? catalog_find(&result_catalog, text_of(session->studies.last))
            : NULL;
    return studied ? export_result(session, studied, export, error)
                   : export_run_table(session, export, error);
}

/* ---- storing results of commands ---- */

/* Stores a table of a result with the keys of the session's set-up, in place of the records of the
 * reply. Does nothing if out of memory. */
void reply_result(const struct session *session, struct reply *reply, const char *kind,
                  const struct result_columns *columns, const void *rows_of, size_t count,
                  const char *method, const char *reference)
{
    struct arena arena = {0};
    struct export export = {.arena = &arena};
    struct keys keys;
    struct error ignored;
    struct buffer duration = {0};
    if (reply->store && columns_table(columns, rows_of, count, &arena, &export.table) &&
        keys_begin(&keys, &export, &ignored)) {
        buffer_exact(&duration, (struct measured){session->setup.settings.duration, 0},
                     QUANTITY_TIME);
        if (method)
            keys_add_text(&keys, "method", method);
        keys_add(&keys, "duration", &duration);
        if (reference && reference[0])
            keys_add_text(&keys, "reference", reference);
        keys_add_scene(&keys, &session->setup.scene);
        if (keys_finish(&keys, &export, &ignored))
            table_store_put(reply->store, kind, &arena, &export.table);
    }
    arena_reset(&arena);
}

/* Decides whether the session keeps a table that a statement reported, and adds the keys of the
 * scene to it. */
static bool stored_table_keep(void *context, struct stored_table *stored)
{
    struct session *session = context;
    const struct result_row *row = result_of_kind(text_of(stored->kind));
    struct export export = {&stored->arena, stored->table};
    struct error ignored;
    if (!row || row->table || stored->table.rows == 0)
        return false;
    if (!stored->table.key && !row->sceneless && export_scene_keys(session, &export, &ignored))
        stored->table = export.table;
    if (row->study) {
        session->studies.last = row->row.name;
        session->studies.at_run = session->runs.next_number;
    }
    return true;
}

/* Moves the tables that a statement reported to the session. Returns the result of the statement
 * (of `command`, or the last one it reported), or NULL if it has no table. */
const struct row *session_keep_results(struct session *session, struct table_store *said,
                                       const char *command)
{
    const struct row *result = catalog_find(&result_catalog, text_of(command));
    for (int i = 0; i < said->count; i++) {
        const struct result_row *row = result_of_kind(text_of(said->table[i]->kind));
        if (!row && result && said->count == 1) /* the only table gets the command's kind */
            said->table[i]->kind = result->name;
        if (row && (!result || !table_store_find(said, result_kind(result_at(result)))))
            result = &row->row;
    }
    /* A result that another statement found does not belong to this one. */
    const struct result_row *row = result_at(result);
    if (row && !row->table && !row->say && !table_store_find(said, result_kind(row)))
        result = NULL;
    table_store_take(&session->studies.found, said, stored_table_keep, session);
    return result;
}
