/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session from its file. */
#include <hooke/module.h>
#include <hooke/session/read.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>

#include <limits.h>
#include <stdlib.h>
#include <string.h>

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

/* ---- values ---- */

static void read_setting(struct reader *reader, const struct setting *setting, struct text in,
                         struct settings *settings)
{
    const struct settings before = *settings;
    struct text choice;
    bool chosen = false;
    if (setting->choices && field_find(in, "choice", &choice)) {
        for (size_t i = 0; i < setting->choices->count; i++)
            if (text_is(choice, catalog_row(setting->choices, i)->name))
                *(int *)(void *)((char *)settings + setting->offset) = (int)i;
    } else {
        field_get(in, "value", (char *)settings + setting->offset, setting->bytes);
    }
    if (!sound_setting(setting, settings)) {
        reader_note(reader, "the setting %s is left out: it has no such value", setting->row.name);
        *settings = before;
        return;
    }
    if (fields_get(in, &(struct field){"chosen", 0, sizeof chosen, FIELD_BOOLS, 0, 0}, 1, &chosen))
        setting_choose(setting, chosen, settings);
}

static void read_settings(struct reader *reader, struct settings *settings)
{
    struct text of, value;
    if (!field_find(reader->state, "settings", &of))
        return;
    for (size_t i = 0; i < setting_catalog.count; i++)
        if (!setting_at(i)->typed && field_find(of, setting_at(i)->row.name, &value))
            read_setting(reader, setting_at(i), value, settings);
}

/* Reads the elements into `made`; false: one cannot be. */
static bool read_elements(const struct store_array *array, struct text in, struct text items,
                          size_t count, char *made)
{
    const size_t stored = reader_item(in, array->item);
    for (size_t i = 0; i < count; i++) {
        char *to = made + i * array->item;
        if (!reader_members(in, array->member, array->members,
                            (struct text){items.at + i * stored, stored}, array->item, to) ||
            !sound_item(array, to))
            return false;
    }
    return true;
}

static void read_array(struct reader *reader, const struct store_array *array)
{
    struct session *session = reader->session;
    struct text in, items;
    char *at = (char *)session + array->offset;
    if (!field_find(reader->state, array->name, &in) || !field_find(in, "items", &items))
        return;
    const size_t stored = reader_item(in, array->item), count = stored ? items.len / stored : 0;
    if (stored == 0 || (array->max > 0 && count > (size_t)array->max)) {
        reader_note(reader, "%s: left out, another version wrote it", array->name);
        return;
    }
    size_t room = 1; /* as these arrays grow: full at every power of two */
    while (room < count)
        room *= 2;
    char *made = malloc(room * array->item);
    if (!made)
        return;
    if (!read_elements(array, in, items, count, made)) {
        reader_note(reader, "%s: left out, damaged or of another version", array->name);
        free(made);
        return;
    }
    if (array->max == 0) {
        free(*(void **)(void *)at);
        *(void **)(void *)at = made;
    } else {
        memcpy(at, made, count * array->item);
        free(made);
    }
    *(int *)(void *)((char *)session + array->count) = (int)count;
}

/* ---- fits ---- */

/* Names of models are constants of the program. */
static const char *model_name(struct text name)
{
    static const char *const others[] = {"scene", "modes", "formula"};
    const struct row *row = catalog_find(&fit_catalog, name);
    for (size_t i = 0; i < COUNT_OF(others) && !row; i++)
        if (text_is(name, others[i]))
            return others[i];
    return row ? row->name : "fit";
}

/* Older files have it among the rest. */
static void read_curve(const struct reader *reader)
{
    struct session *session = reader->session;
    struct text times, values;
    uint64_t sum = 0;
    if (field_get(reader->state, "fit_curve", &sum, sizeof sum) &&
        reader_bytes(reader, sum, &times)) {
        times.len /= 2;
        values = (struct text){times.at + times.len, times.len};
    } else if (!field_find(reader->state, "fit_times", &times) ||
               !field_find(reader->state, "fit_values", &values)) {
        return;
    }
    if (times.len != values.len || times.len % sizeof(double) != 0)
        return;
    double *t = malloc(times.len + 1), *y = malloc(values.len + 1);
    if (!t || !y) {
        free(t);
        free(y);
        return;
    }
    memcpy(t, times.at, times.len);
    memcpy(y, values.at, values.len);
    session->fit_curve[0] = t;
    session->fit_curve[1] = y;
    session->fit_samples = times.len / sizeof *t;
    session->fit_curve_sum = sum;
}

/* The parameters that are known of what was adopted; none, if one is not there. */
static void move_adopted(const struct field_places *places, struct adopted_fit *adopted)
{
    for (int i = 0; i < adopted->known.count; i++) {
        const int old = adopted->known.index[i], row = old < places->count ? places->row[old] : -1;
        adopted->known.index[i] = row;
        if (row < 0)
            adopted->known.count = 0;
    }
}

/* Until November 2026 it was the bytes of a struct fit. */
static bool read_last_fit(const struct reader *reader, struct fit *fit)
{
    const struct store_array *like = &store_arrays[STORE_FITS];
    struct text in, items;
    struct stored_fit last;
    if (!field_find(reader->state, "last_fit", &in))
        return field_get(reader->state, "fit", fit, sizeof *fit);
    if (!field_find(in, "items", &items) ||
        !reader_members(in, like->member, like->members, items, sizeof last, &last))
        return false;
    memcpy(fit, &last.fit, sizeof *fit);
    return true;
}

static void read_fits(struct reader *reader)
{
    struct session *session = reader->session;
    struct text in = reader->state, name, value;
    struct error why = {0};
    int stored = 0;
    session->has_fit &= read_last_fit(reader, &session->fit);
    if (!sound_fit(&session->fit)) {
        reader_note(reader, "the last fit is left out: damaged");
        session->has_fit = false;
        memset(&session->fit, 0, sizeof session->fit);
    }
    session->fit.model = NULL;
    if (session->has_fit)
        session->fit.model = model_name(field_find(in, "fit_model", &value) ? value : TEXT(""));
    for (int i = 0; i < session->stored_fits; i++)
        session->stored_fit[i].fit.model = "fit";
    while (field_next(&in, &name, &value))
        if (text_is(name, "stored_model") && stored < session->stored_fits)
            session->stored_fit[stored++].fit.model = model_name(value);
    read_curve(reader);
    struct setup setup;
    struct field_places places;
    memcpy(&setup, &session->setup, sizeof setup);
    bool fine = true;
    if (field_find(reader->state, "fit_scene", &value)) {
        fine = reader_scene(reader, reader->state, "fit_scene", &session->fit_scene, &places, &why);
        if (fine)
            reader_move(&places, session->fit_free, sizeof *session->fit_free);
    }
    if (fine && field_find(reader->state, "adopted_scene", &value)) {
        fine = reader_scene(reader, reader->state, "adopted_scene", &session->adopted.scene,
                            &places, &why);
        if (fine)
            move_adopted(&places, &session->adopted);
    }
    if (!fine)
        reader_note(reader, "the scene of the last fit is left out: %s", why.text);
    memcpy(&session->setup, &setup, sizeof setup);
    if (!sound_adopted(&session->adopted)) {
        reader_note(reader, "what was adopted is left out: damaged");
        session->adopted = (struct adopted_fit){.of = ""};
    }
}

static void read_table(struct reader *reader, struct text in)
{
    struct text kind, csv;
    struct arena arena = {0};
    struct table table;
    struct error ignored;
    const char *name = field_find(in, "kind", &kind) ? arena_text(&arena, kind) : NULL;
    if (!name || !field_find(in, "csv", &csv) ||
        !table_parse(csv, NULL, &arena, &table, &ignored) ||
        !table_store_put(&reader->session->found, name, &arena, &table))
        reader_note(reader, "the table of the last %.*s is left out", (int)kind.len, kind.at);
    arena_reset(&arena);
}

static void read_tables(struct reader *reader)
{
    struct text in = reader->state, name, value;
    table_store_free(&reader->session->found); /* of the commands that made scenes and recordings */
    reader->session->found = (struct table_store){.of = NULL};
    while (field_next(&in, &name, &value))
        if (text_is(name, "table"))
            read_table(reader, value);
    reader->session->studied = NULL;
    if (field_find(reader->state, "studied", &value)) {
        const struct row *row = catalog_find(reader->restorer->results, value);
        reader->session->studied = row ? row->name : NULL;
    }
}

/* ---- what was typed and said ---- */

static void read_lines(struct history *history, struct text in)
{
    struct text entries, text;
    size_t from, text_from;
    if (!field_get(in, "from", &from, sizeof from) ||
        !field_get(in, "text_from", &text_from, sizeof text_from) ||
        !field_find(in, "entries", &entries) || !field_find(in, "text", &text) ||
        from > SIZE_MAX / 2 || text_from > SIZE_MAX / 2)
        return;
    /* it begins here: what was before is gone, or damaged */
    if (from < history->first || from > history->count || text_from < history->text_first ||
        text_from > history->text_first + history->text.len) {
        history->text.len = 0;
        history->first = history->count = from;
        history->text_first = text_from;
        history->lines_gone = 0;
        static const struct field gone = FIELD_IN(struct history, lines_gone, 0, INT_MAX / 2);
        fields_get(in, &gone, 1, history);
    }
    from -= history->first;
    text_from -= history->text_first;
    const size_t stored = reader_item(in, sizeof *history->entry);
    const size_t more = stored ? entries.len / stored : 0, count = from + more;
    if (count > history->capacity) {
        struct entry *larger = realloc(history->entry, 2 * count * sizeof *larger);
        if (!larger)
            return;
        history->entry = larger;
        history->capacity = 2 * count;
    }
    for (size_t i = 0; i < more; i++)
        if (!reader_members(in, store_entry, store_entry_count,
                            (struct text){entries.at + i * stored, stored}, sizeof *history->entry,
                            &history->entry[from + i]))
            return;
    history->text.len = text_from;
    buffer_put(&history->text, text);
    history->count = history->first + count;
}

static bool inside(const struct history *history, size_t at, size_t len)
{
    const size_t from = at - history->text_first;
    return at >= history->text_first && from <= history->text.len &&
           len <= history->text.len - from;
}

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
        if (!inside(history, entry->text, entry->len) ||
            (entry->full_len > 0 && !inside(history, entry->full, entry->full_len)) ||
            entry->output > (entry->full_len ? entry->full_len : entry->len)) {
            history->count = i;
            break;
        }
        history->lines += history_is_typed(reader->session, entry);
        history->done += (entry->flags & ENTRY_DONE) != 0;
    }
}

/* ---- the whole ---- */

static void read_owns(struct reader *reader)
{
    struct text in = reader->state, name, value;
    struct scene scene;
    while (field_next(&in, &name, &value)) {
        struct error why = {0};
        struct text script;
        if (!text_is(name, "own") || !field_find(value, "script", &script))
            continue;
        if (!reader->restorer->execute(reader->restorer->context, reader->session, script, &why))
            reader_note(reader, "a scene is left out: %s", why.text);
        scene = reader->session->setup.scene;
        if (scene.preset)
            reader_made(reader, script, &scene);
    }
}

static void read_setup(struct reader *reader)
{
    struct session *session = reader->session;
    struct setup *setup = &session->setup;
    struct error why = {0};
    struct scene scene;
    struct text name;
    if (!reader_scene(reader, reader->state, "scene", &scene, &reader->places, &why)) {
        reader_note(reader, "the scene is left out: %s", why.text);
        scene = setup->scene;
        field_same_places(scene_params(&scene), &reader->places);
    }
    const struct preset *own[LIMIT_OWN];
    const int owns = setup->owns;
    memcpy(own, setup->own, sizeof own);
    setup->scene = scene;
    const struct events *events = NULL;
    if (!reader_events(reader, reader->state, &events, &why))
        reader_note(reader, "the events are left out: %s", why.text);
    struct text ids;
    if (field_find(reader->state, "runs", &ids))
        reader_runs(reader, ids);
    /* these have had their scenes in its place */
    setup->scene = scene;
    setup->events = events;
    setup->owns = owns;
    memcpy(setup->own, own, sizeof own);
    const struct row *method =
        field_find(reader->state, "method", &name) ? catalog_find(&method_catalog, name) : NULL;
    if (method)
        setup->method = (const struct method *)(const void *)method;
    read_settings(reader, &setup->settings);
    struct text points;
    if (field_find(reader->state, "calibration", &points)) {
        calibration_take_line(points, &setup->calibration);
        setup->calibration.decided = true;
    }
}

static void read_view(struct reader *reader)
{
    struct session *session = reader->session;
    struct text in, focus;
    if (!field_find(reader->state, "view", &in))
        return;
    struct view view = session->view;
    view.focus =
        field_find(in, "focus", &focus) ? catalog_find(reader->restorer->panes, focus) : NULL;
    if (fields_get_known(in, store_view, store_view_count, &view) && sound_view(&view))
        session->view = view;
    else
        reader_note(reader, "the view is left out: damaged");
}

static void read_lesson(struct reader *reader)
{
    struct text in, text;
    struct lesson lesson = {.step = 0};
    if (!field_find(reader->state, "lesson", &in))
        return;
    struct lesson *kept = malloc(sizeof *kept);
    const bool ok = kept && field_find(in, "text", &text) &&
                    fields_get(in, store_lesson, store_lesson_count, &lesson) && lesson.step >= 0 &&
                    lesson.step <= lesson.steps;
    if (ok)
        buffer_put(&lesson.text, text);
    if (!ok || lesson.text.failed) {
        reader_note(reader, "the lesson is left out");
        buffer_free(&lesson.text);
        free(kept);
        return;
    }
    *kept = lesson;
    reader->session->lesson = kept;
}

/* Places in lists that are as long as they could be made. */
static void settle(struct session *session, int at, uint64_t run_id)
{
    session->current_run = at < 0 ? -1 : session->runs - 1;
    for (int i = 0; i < session->runs && at >= 0; i++)
        if (session->run[i]->id == run_id)
            session->current_run = i;
    if (session->current_recording >= session->recordings || session->current_recording < -1)
        session->current_recording = session->recordings - 1;
    if (session->next_run < 1 || session->next_run > INT_MAX / 2)
        session->next_run = 1;
    for (int i = 0; i < session->runs; i++) {
        session->next_run = session->next_run > session->run[i]->run->number
                                ? session->next_run
                                : session->run[i]->run->number + 1;
        session->next_id =
            session->next_id > session->run[i]->id ? session->next_id : session->run[i]->id + 1;
    }
}

/* Places and numbers change while runs and recordings are added: what the file
 * has of them is read after that. */
static void read_all(struct reader *reader)
{
    struct session *session = reader->session;
    struct text ids;
    uint64_t current = UINT64_MAX;
    read_array(reader, &store_arrays[STORE_LETS]); /* variables may stand in formulas */
    reader_recordings(reader);
    read_owns(reader);
    for (size_t i = 1; i < store_array_count; i++)
        read_array(reader, &store_arrays[i]);
    read_setup(reader);
    if (!fields_get_known(reader->state, store_session, store_session_count, session))
        reader_note(reader, "some values are left out: they are damaged");
    reader_move(&reader->places, session->setup.origin, sizeof *session->setup.origin);
    const int at = session->current_run;
    if (field_find(reader->state, "runs", &ids) && at >= 0 &&
        ((size_t)at + 1) * sizeof current <= ids.len)
        memcpy(&current, ids.at + (size_t)at * sizeof current, sizeof current);
    settle(session, at, current);
    read_fits(reader); /* executes commands: after a run that is damaged was taken
                          out */
    read_tables(reader);
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->store.read)
            module_list[i]->store.read(reader);
    for (size_t i = 0; module_left_out[i]; i++)
        if (field_find(reader->state, module_left_out[i], &ids))
            reader_note(reader,
                        "what the module %s keeps is left out: this program was built without it",
                        module_left_out[i]);
    read_view(reader);
    read_lesson(reader);
    undo_clear(session);
    read_history(reader);
    session_changed(session);
}

bool store_recognise(struct text content)
{
    return text_starts(content, text_of(STORE_HEADER));
}

bool session_restore(struct session *session, struct text content, const struct restorer *restorer,
                     struct buffer *notes, struct error *error)
{
    struct reader reader = {.session = session, .restorer = restorer, .notes = notes};
    const bool ok = reader_scan(&reader, content, error);
    if (ok) {
        session->restoring = true;
        read_all(&reader);
        session->restoring = false;
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
    return ok;
}
