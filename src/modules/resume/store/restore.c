/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Restores a session from the content of its file. */
#include <hooke/base/safe_text.h>
#include <hooke/command.h>
#include <hooke/module.h>
#include <hooke/plot.h>
#include <hooke/report.h>
#include "modules/resume/store/reading.h"
#include <hooke/session/events.h>
#include <hooke/session/log.h>

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Adds a line to the notes on what could not be restored. */
void reader_note(struct reader *reader, const char *format, ...)
{
    va_list args;
    struct buffer line = {0};
    va_start(args, format);
    buffer_vformat(&line, format, args);
    va_end(args);
    safe_text(reader->notes, buffer_text(&line), false);
    buffer_char(reader->notes, '\n');
    buffer_free(&line);
}

/* Collects the text that commands print, for reader_execute(). */
static bool restored_text_keep(void *context, struct text text)
{
    buffer_put(context, text);
    return true;
}

/* Executes commands, one per line, up to the first that fails. Their replies are dropped. Returns
 * false with an error, the first line of the failed command's reply. */
bool reader_execute(struct reader *reader, struct text commands, struct error *error)
{
    const struct source where = {.name = reader->name};
    struct buffer said = {0};
    struct reply reply;
    struct text line;
    bool ok = true;
    reply_init(&reply, (struct sink){sink_nothing, restored_text_keep, &said});
    while (ok && commands.len > 0 && text_split(&commands, '\n', &line)) {
        buffer_clear(&said);
        ok = command_exec(reader->session, line, &where, &reply);
    }
    struct text first = TEXT(""), rest = buffer_text(&said);
    if (!ok && text_split(&rest, '\n', &first))
        error_set(error, ERROR_COMMAND, "%.*s", (int)first.len, first.data);
    reply_free(&reply);
    buffer_free(&said);
    return ok;
}

/* ---- values ---- */

/* Moves the `count` elements `made` into the array of `owner`; `made` has room for them as
 * allocated arrays have, a power of two. */
static void place_elements(const struct store_array *array, char *made, int count, void *owner)
{
    char *cursor = (char *)owner + array->offset;
    if (array->max == 0) {
        free(*(void **)(void *)cursor);
        *(void **)(void *)cursor = made;
    } else {
        memcpy(cursor, made, (size_t)count * array->item);
        free(made);
    }
    *(int *)(void *)((char *)owner + array->count) = count;
}

/* Reads an array of the state into `owner`, unless an element is damaged or there are too many,
 * which is noted. */
void reader_array(struct reader *reader, const struct store_array *array, void *owner)
{
    struct text text = reader->state, name, value;
    char *made = NULL;
    int count = 0;
    bool fine = true;
    while (fine && field_next(&text, &name, &value)) {
        if (!text_is(name, array->name))
            continue;
        if ((count & (count - 1)) == 0) {
            char *more = realloc(made, (count > 0 ? 2 * (size_t)count : 1) * array->item);
            made = more ? more : made;
            fine = more != NULL;
        }
        char *element = made + (size_t)count * array->item;
        fine = fine && (array->max == 0 || count < array->max);
        if (fine) {
            memset(element, 0, array->item);
            fine = fields_get_known(value, array->member, array->members, element) &&
                   (!array->sound || array->sound(element));
        }
        count++;
    }
    if (fine && count > 0) {
        place_elements(array, made, count, owner);
        return;
    }
    free(made);
    if (!fine)
        reader_note(reader, "%s is left out because it is damaged or from another version",
                    array->name);
}

/* Restores a table of results into the session; a damaged one is left out with a note. */
static void read_table(struct reader *reader, struct text text)
{
    struct text kind, csv;
    struct arena arena = {0};
    struct table table;
    struct error ignored;
    const char *name = field_find(text, "kind", &kind) ? arena_text(&arena, kind) : NULL;
    if (!name || !field_find(text, "csv", &csv) ||
        !table_parse(csv, NULL, &arena, &table, &ignored) ||
        !table_store_put(&reader->session->studies.found, name, &arena, &table))
        reader_note(reader, "the table of the last %.*s is left out", (int)kind.len, kind.data);
    arena_reset(&arena);
}

/* Restores all tables of results, and which study was the last. */
static void read_tables(struct reader *reader)
{
    struct text text = reader->state, name, value;
    table_store_free(
        /* tables left by the commands that made scenes and recordings */
        &reader->session->studies.found);
    reader->session->studies.found = (struct table_store){.table = NULL};
    while (field_next(&text, &name, &value))
        if (text_is(name, "table"))
            read_table(reader, value);
    reader->session->studies.last = NULL;
    if (field_find(reader->state, "studied", &value)) {
        const struct row *row = catalog_find(&result_catalog, value);
        reader->session->studies.last = row ? row->name : NULL;
    }
}

/* ---- what was typed and said ---- */

/* Restores typed lines from a record (the section), which are appended to the history. A record
 * that does not continue the lines read before replaces them. A damaged record is ignored. */
static void read_lines(struct history *history, struct text section)
{
    struct text entries, text;
    size_t first_entry, text_from, item;
    if (!field_get(section, "item", &item, sizeof item) || item != sizeof *history->entry ||
        !field_get(section, "from", &first_entry, sizeof first_entry) ||
        !field_get(section, "text_from", &text_from, sizeof text_from) ||
        !field_find(section, "entries", &entries) || !field_find(section, "text", &text) ||
        first_entry > SIZE_MAX / 2 || text_from > SIZE_MAX / 2)
        return;
    /* it begins here: what was before is gone, or damaged */
    if (first_entry < history->first || first_entry > history->count ||
        text_from < history->text_first || text_from > history->text_first + history->text.len) {
        history->text.len = 0;
        history->first = history->count = first_entry;
        history->text_first = text_from;
        history->lines_gone = 0;
        static const struct field gone = FIELD_IN(struct history, lines_gone, 0, INT_MAX / 2);
        fields_get(section, &gone, 1, history);
    }
    first_entry -= history->first;
    text_from -= history->text_first;
    const size_t more = entries.len / sizeof *history->entry, count = first_entry + more;
    if (count > history->capacity) {
        struct entry *larger = realloc(history->entry, 2 * count * sizeof *larger);
        if (!larger)
            return;
        history->entry = larger;
        history->capacity = 2 * count;
    }
    if (more > 0)
        memcpy(&history->entry[first_entry], entries.data, more * sizeof *history->entry);
    history->text.len = text_from;
    buffer_put(&history->text, text);
    history->count = history->first + count;
}

/* Returns true if a text of the history lies within what was read. */
static bool is_inside_history(const struct history *history, size_t position, size_t len)
{
    const size_t offset = position - history->text_first;
    return position >= history->text_first && offset <= history->text.len &&
           len <= history->text.len - offset;
}

/* Restores typed lines and the text of the log pane. Lines from a damaged entry on are dropped. */
static void read_history(struct reader *reader)
{
    struct history *history = &reader->session->history;
    buffer_free(&history->text);
    free(history->entry);
    *history = (struct history){.entry = NULL};
    log_clear(&reader->session->log);
    for (size_t i = 0; i < reader->records; i++) {
        const struct read_record *record = &reader->record[i];
        if (record->kind == RECORD_LINES)
            read_lines(history, record->content);
        else if (record->kind == RECORD_SAID)
            log_add(&reader->session->log, record->content);
    }
    history->lines = history->lines_gone;
    for (size_t i = history->first; i < history->count; i++) {
        const struct entry *entry = history_entry(reader->session, i);
        if (!is_inside_history(history, entry->text, entry->len) ||
            (entry->full_len > 0 && !is_inside_history(history, entry->full, entry->full_len)) ||
            entry->output > (entry->full_len ? entry->full_len : entry->len)) {
            history->count = i;
            break;
        }
        history->lines += history_is_typed(reader->session, entry);
        history->done += (entry->flags & ENTRY_DONE) != 0;
    }
}

/* ---- the whole ---- */

/* Restores the session's set-up by executing the stored commands; those that fail are noted for the
 * user. Then restores the scenes and events, and reader->places, which maps stored parameters to
 * those of the present program. */
static void read_setup(struct reader *reader)
{
    struct session *session = reader->session;
    const struct setup *setup = &session->setup;
    struct text commands, line, names;
    struct scene own;
    struct error why;
    if (!field_find(reader->state, "setup", &commands))
        commands = TEXT("");
    while (commands.len > 0 && text_split(&commands, '\n', &line))
        if (!reader_execute(reader, line, &why))
            reader_note(reader, "'%.*s' is left out: %s", (int)line.len, line.data, why.text);
    for (int i = 0; i < setup->owns; i++) {
        scene_init(&own, setup->own[i]);
        reader_made_scene(reader, &own);
    }
    reader_made_scene(reader, &setup->scene);
    if (setup->events)
        reader_made_events(reader, setup->events);
    if (!field_find(reader->state, "names", &names) ||
        !field_find_places(names, scene_params(&setup->scene), &reader->places))
        reader->places = (struct field_places){.rows = 0};
}

/* Returns true for valid ends of an axis, or none (NAN). */
static bool is_range(const double range[2])
{
    return (isnan(range[0]) && isnan(range[1])) ||
           (isfinite(range[0]) && isfinite(range[1]) && range[0] < range[1]);
}

/* Restores what the panes show; a damaged view is noted. */
static void read_view(struct reader *reader)
{
    struct session *session = reader->session;
    struct text text, focus;
    if (!field_find(reader->state, "view", &text))
        return;
    struct view view = session->view;
    view.focus = field_find(text, "focus", &focus) ? catalog_find(&plot_catalog, focus) : NULL;
    if (fields_get_known(text, store_view, store_view_count, &view) && is_range(view.x) &&
        is_range(view.y))
        session->view = view;
    else
        reader_note(reader, "the view is left out because it is damaged");
}

/* Corrects the indices of the current run and recording and the next number and id of runs, for
 * lists that lack what could not be restored. index and run_id are those of the current run in the
 * file. */
static void session_run_order(struct session *session, int index, uint64_t run_id)
{
    session->runs.current = index < 0 ? -1 : session->runs.count - 1;
    for (int i = 0; i < session->runs.count && index >= 0; i++)
        if (session->runs.slot[i]->id == run_id)
            session->runs.current = i;
    if (session->current_recording >= session->recordings || session->current_recording < -1)
        session->current_recording = session->recordings - 1;
    if (session->runs.next_number < 1 || session->runs.next_number > INT_MAX / 2)
        session->runs.next_number = 1;
    for (int i = 0; i < session->runs.count; i++) {
        session->runs.next_number = session->runs.next_number > session->runs.slot[i]->run->number
                                        ? session->runs.next_number
                                        : session->runs.slot[i]->run->number + 1;
        session->runs.next_id = session->runs.next_id > session->runs.slot[i]->id
                                    ? session->runs.next_id
                                    : session->runs.slot[i]->id + 1;
    }
}

/* Restores the session from the records of its file. Runs and recordings change the set-up, indices
 * and numbers while they are added, so that these are read after them. Parts that are damaged are
 * left out with a note. */
static void read_all(struct reader *reader)
{
    struct session *session = reader->session;
    struct text ids;
    struct setup setup;
    uint64_t current = UINT64_MAX;
    read_setup(reader);
    memcpy(&setup, &session->setup, sizeof setup);
    /* messages name parts that cannot be restored */
    session->setup.settings.format = FORMAT_TEXT;
    reader_recordings(reader);
    if (field_find(reader->state, "runs", &ids))
        reader_runs(reader, ids);
    memcpy(&session->setup, &setup, sizeof setup);
    for (size_t i = 0; i < store_array_count; i++)
        reader_array(reader, &store_arrays[i], session);
    if (!fields_get_known(reader->state, store_session, store_session_count, session))
        reader_note(reader, "some values are left out because they are damaged");
    reader_move(&reader->places, session->setup.origin, sizeof *session->setup.origin);
    const int index = session->runs.current;
    if (field_find(reader->state, "runs", &ids) && index >= 0 &&
        ((size_t)index + 1) * sizeof current <= ids.len)
        memcpy(&current, ids.data + (size_t)index * sizeof current, sizeof current);
    session_run_order(session, index, current);
    read_tables(reader);
    /* may execute commands: after a run that is damaged was taken out */
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->store.read)
            module_list[i]->store.read(reader);
    for (size_t i = 0; module_left_out[i]; i++)
        if (field_find(reader->state, module_left_out[i], &ids))
            reader_note(
                reader,
                "data of the module %s are left out because this program was built without it",
                module_left_out[i]);
    read_view(reader);
    undo_clear(session);
    read_history(reader);
    session_changed(session);
}

/* Restores the content of a session file into a new session. `name` is the file's name for
 * messages, `temporary` a folder for temporary files or NULL; *notes receives a line for each part
 * left out. Returns false with an error if nothing can be restored. */
bool session_restore(struct session *session, struct text content, const char *name,
                     const char *temporary, struct buffer *notes, struct error *error)
{
    struct reader reader = {
        .session = session, .name = name, .temporary = temporary, .notes = notes};
    if (!text_starts(content, TEXT(STORE_HEADER)))
        return error_set(error, ERROR_IO, "%s was written by another version of hooke", name);
    const bool ok = reader_scan(&reader, content, error);
    if (ok) {
        session->execution.restoring = true;
        read_all(&reader);
        session->execution.restoring = false;
        if (reader.damaged + reader.unknown > 0)
            reader_note(&reader, "%zu record%s skipped: %zu damaged, %zu of an unknown kind",
                        reader.damaged + reader.unknown,
                        reader.damaged + reader.unknown == 1 ? " was" : "s were", reader.damaged,
                        reader.unknown);
    }
    for (size_t i = 0; i < reader.runs; i++)
        free(reader.run[i].piece);
    free(reader.run);
    free(reader.record);
    free(reader.made);
    arena_reset(&reader.arena);
    return ok;
}
