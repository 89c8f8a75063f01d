/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session into records: those of what has changed since the last time. */
#include <hooke/run/store.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include "session/store/store.h"

#include <stdlib.h>
#include <string.h>

#define ROWS_AT_ONCE ((size_t)1 << 12)

struct stored_run {
    uint64_t id, sum; /* of the last R */
    uint64_t live;    /* bytes of its R */
    size_t rows;      /* in the file, and bytes of each */
    size_t row_bytes;
    bool left_out;
};

struct output {
    struct stored *stored;
    const struct store_sink *sink;
    struct buffer record;
    struct error *error;
    bool written; /* something was: an S has to follow */
};

/* ---- records ---- */

static void record_begin(struct output *out)
{
    static const struct record_head none;
    buffer_clear(&out->record);
    buffer_put(&out->record, (struct text){(const char *)&none, sizeof none});
}

static struct text content_of(const struct output *out)
{
    const struct text all = buffer_text(&out->record);
    return (struct text){all.at + sizeof(struct record_head), all.len - sizeof(struct record_head)};
}

static bool record_end(struct output *out, enum record_kind kind, uint64_t sum)
{
    struct record_head head = {.magic = RECORD_MAGIC, .kind = kind};
    if (out->record.failed)
        return error_memory(out->error);
    head.bytes = content_of(out).len;
    head.sum = sum;
    head.own = bytes_sum((struct text){(const char *)&head, offsetof(struct record_head, own)});
    memcpy(out->record.data, &head, sizeof head);
    if (!out->sink->write(out->sink->context, buffer_text(&out->record), out->error))
        return false;
    out->stored->bytes += out->record.len;
    out->stored->live += out->record.len;
    out->written = true;
    return true;
}

/* One that does not count as live: what is live of its kind is known elsewhere. */
static bool record_once(struct output *out, enum record_kind kind)
{
    const uint64_t live = out->stored->live;
    const bool ok = record_end(out, kind, out->record.failed ? 0 : bytes_sum(content_of(out)));
    out->stored->live = live;
    return ok;
}

/* ---- scenes ---- */

static void put_scene(const struct scene *scene, const char *name, struct buffer *to)
{
    const size_t begun = field_begin(to, name), params = scene_params(scene)->count;
    const size_t script = field_begin(to, "script");
    scene_kind_script(scene, to);
    field_end(to, script);
    field_put(to, "value", scene->value, params * sizeof *scene->value);
    field_put(to, "uncertainty", scene->uncertainty, params * sizeof *scene->uncertainty);
    field_put(to, "chosen", scene->chosen, params * sizeof *scene->chosen);
    field_put(to, "across", &scene->across, sizeof scene->across);
    field_put(to, "atol", scene->atol, sizeof scene->atol);
    field_end(to, begun);
}

static void put_events(const struct events *events, struct buffer *to)
{
    const size_t begun = field_begin(to, "events");
    events_save(events, false, to);
    field_end(to, begun);
}

/* ---- runs ---- */

static void put_asked(const struct run_slot *slot, struct buffer *to)
{
    const struct request **list;
    int count;
    if (!journal_list(slot->last, 0, &list, &count)) {
        to->failed = true;
        return;
    }
    const size_t begun = field_begin(to, "asked");
    for (int i = 0; i < count; i++) {
        const struct request *r = list[i];
        const struct asked asked = {.kind = (int32_t)r->kind,
                                    .param = r->param,
                                    .by_event = r->by_event,
                                    .conditioned = r->condition != NULL,
                                    .from = r->from,
                                    .end = r->end,
                                    .met = r->met,
                                    .rows = r->rows,
                                    .from_t = r->from_t,
                                    .t = r->t,
                                    .value = r->value};
        buffer_put(to, (struct text){(const char *)&asked, sizeof asked});
        if (r->condition)
            buffer_put(to, (struct text){r->condition, strlen(r->condition) + 1});
    }
    field_end(to, begun);
    free(list);
}

static struct stored_run *find_run(struct stored *stored, uint64_t id)
{
    for (int i = 0; i < stored->runs; i++)
        if (stored->run[i].id == id)
            return &stored->run[i];
    return NULL;
}

static struct stored_run *add_run(struct stored *stored, uint64_t id)
{
    if (stored->runs == stored->run_capacity) {
        const int capacity = stored->run_capacity ? 2 * stored->run_capacity : 16;
        struct stored_run *more = realloc(stored->run, (size_t)capacity * sizeof *more);
        if (!more)
            return NULL;
        stored->run = more;
        stored->run_capacity = capacity;
    }
    stored->run[stored->runs] = (struct stored_run){.id = id};
    return &stored->run[stored->runs++];
}

/* Those from the first one that is not as the file has it. */
static bool put_rows(struct output *out, struct run *run, struct stored_run *of)
{
    const size_t rows = run_recorded(run), bytes = run_row_bytes(run);
    size_t first = run_rows_stored(run);
    first = first < of->rows ? first : of->rows;
    out->stored->live -= (of->rows - first) * bytes; /* those will not be read again */
    for (size_t count; first < rows; first += count) {
        count = rows - first < ROWS_AT_ONCE ? rows - first : ROWS_AT_ONCE;
        const struct rows_head head = {of->id, first, count, bytes};
        record_begin(out);
        buffer_put(&out->record, (struct text){(const char *)&head, sizeof head});
        run_store_rows(run, first, count, &out->record);
        if (!record_end(out, RECORD_ROWS, bytes_sum(content_of(out))))
            return false;
        out->stored->live -= sizeof head + sizeof(struct record_head);
    }
    of->rows = rows;
    of->row_bytes = bytes;
    run_set_stored(run, rows);
    return true;
}

static bool put_run(struct output *out, const struct run_slot *slot, bool left_out, bool going)
{
    struct stored_run *of = find_run(out->stored, slot->id);
    if (!of) {
        if (!(of = add_run(out->stored, slot->id)))
            return error_memory(out->error);
        run_set_stored(slot->run, 0);
    }
    if (left_out) {
        out->stored->live -= of->rows * run_row_bytes(slot->run);
        of->rows = 0;
        run_set_stored(slot->run, 0);
    } else if (!put_rows(out, slot->run, of)) {
        return false;
    }
    struct buffer *to = &out->record;
    record_begin(out);
    field_put(to, "id", &slot->id, sizeof slot->id);
    field_put(to, "number", &slot->run->number, sizeof slot->run->number);
    field_put(to, "left_out", &left_out, sizeof left_out);
    field_put(to, "going", &going, sizeof going);
    field_text(to, "method", text_of(slot->run->method->row.name));
    put_scene(&slot->run->scene, "scene", to);
    put_events(slot->events, to);
    field_put(to, "statement", &slot->statement, sizeof slot->statement);
    field_put(to, "origin", slot->origin, sizeof slot->origin);
    if (slot->note)
        field_text(to, "note", text_of(slot->note));
    put_asked(slot, to);
    const size_t begun = field_begin(to, "state");
    run_store(slot->run, to);
    field_end(to, begun);
    const uint64_t sum = to->failed ? 0 : bytes_sum(content_of(out));
    if (sum == of->sum && !to->failed)
        return true;
    out->stored->live -= of->live;
    of->sum = sum;
    of->live = to->len;
    return record_end(out, RECORD_RUN, sum);
}

/* Those that were dropped; undo may bring one back, which is then written again. */
static void forget_runs(struct stored *stored, const struct session *session)
{
    int kept = 0;
    for (int i = 0; stored->runs > session->runs && i < stored->runs; i++) {
        const struct stored_run *of = &stored->run[i];
        bool there = false;
        for (int k = 0; k < session->runs && !there; k++)
            there = session->run[k]->id == of->id;
        if (there)
            stored->run[kept++] = *of;
        else
            stored->live -= of->live + of->rows * of->row_bytes;
    }
    stored->runs = stored->runs > session->runs ? kept : stored->runs;
}

/* The newest first, as long as there is room for their rows. */
static bool put_runs(struct output *out, const struct session *session)
{
    size_t all = 0;
    out->stored->left_out = 0;
    for (int i = session->runs; i-- > 0;) {
        const struct run *run = session->run[i]->run;
        all += run_recorded(run) * run_row_bytes(run);
        const bool left_out = all > STORE_ROW_BYTES;
        out->stored->left_out += left_out;
        const bool going = session->live.advancing && i == session->current_run;
        if (!put_run(out, session->run[i], left_out, going))
            return false;
    }
    forget_runs(out->stored, session);
    return true;
}

/* ---- recordings ---- */

static bool has_recording(const struct stored *stored, uint64_t sum)
{
    for (int i = 0; i < stored->recordings; i++)
        if (stored->recording[i] == sum)
            return true;
    return false;
}

/* Those that were dropped, of which there may be as many as are kept. */
static void forget_recordings(struct stored *stored, const struct session *session)
{
    int kept = 0;
    for (int i = 0; i < stored->recordings; i++) {
        bool there = false;
        for (int k = 0; k < session->recordings && !there; k++)
            there = session->recording[k]->sum == stored->recording[i];
        if (!there)
            stored->live -= stored->recording_bytes[i];
        stored->recording[kept] = stored->recording[i];
        stored->recording_bytes[kept] = stored->recording_bytes[i];
        kept += there;
    }
    stored->recordings = kept;
}

/* The bytes of its file as it was loaded, or as it is now; without them it is only named. */
static bool put_recording(struct output *out, struct recording_slot *slot)
{
    struct stored *stored = out->stored;
    struct buffer content = {0};
    struct error ignored;
    bool ok = true;
    if (slot->sum == 0 || !has_recording(stored, slot->sum)) {
        if (slot->content.len > 0)
            buffer_put(&content, buffer_text(&slot->content));
        else if (!file_read(slot->recording->path, STORE_RECORDING_BYTES, &content, &ignored))
            buffer_clear(&content);
        const uint64_t sum = bytes_sum(buffer_text(&content));
        /* another file by now: that of the recording is gone */
        const bool wanted = content.len > 0 && (slot->sum == 0 || slot->sum == sum);
        if (wanted && !has_recording(stored, sum)) {
            record_begin(out);
            field_put(&out->record, "sum", &sum, sizeof sum);
            field_text(&out->record, "content", buffer_text(&content));
            ok = record_end(out, RECORD_BYTES, bytes_sum(content_of(out)));
            stored->recording_bytes[stored->recordings] = out->record.len;
            stored->recording[stored->recordings++] = sum;
        }
        slot->sum = wanted ? sum : slot->sum ? slot->sum : 1;
    }
    buffer_free(&content);
    return ok;
}

static void put_loaded(const struct recording_slot *slot, struct buffer *to)
{
    const struct recording *recording = slot->recording;
    char *path = realpath(recording->path, NULL);
    const size_t begun = field_begin(to, "recording");
    field_text(to, "name", text_of(recording->name));
    field_text(to, "path", text_of(path ? path : recording->path));
    field_text(to, "options", text_of(slot->options));
    field_put(to, "sum", &slot->sum, sizeof slot->sum);
    field_put(to, "rows", &recording->rows, sizeof recording->rows);
    for (int i = 0; i < RECORDING_FIELDS; i++) {
        char name[] = "field0";
        name[5] = (char)('0' + i);
        field_put(to, name, (const char *)recording + recording_fields[i].offset,
                  recording_fields[i].bytes);
    }
    field_end(to, begun);
    free(path);
}

/* ---- what was typed and said ---- */

/* A statement that goes on while this is written will be another entry at its end. */
static bool put_lines(struct output *out, const struct session *session)
{
    const struct history *history = &session->history;
    struct stored *stored = out->stored;
    if (stored->entries == history->count)
        return true;
    if (stored->entries < history->first || stored->text < history->text_first) {
        stored->entries = history->first;
        stored->text = history->text_first;
    }
    struct buffer *to = &out->record;
    const size_t there = stored->text - history->text_first;
    record_begin(out);
    field_put(to, "from", &stored->entries, sizeof stored->entries);
    field_put(to, "text_from", &stored->text, sizeof stored->text);
    if (stored->entries == history->first)
        field_put(to, "lines_gone", &history->lines_gone, sizeof history->lines_gone);
    field_put(to, "entries", history_entry(session, stored->entries),
              (history->count - stored->entries) * sizeof *history->entry);
    field_put(to, "text", history->text.data + there, history->text.len - there);
    if (session->nesting == 0) {
        stored->entries = history->count;
        stored->text = history->text_first + history->text.len;
    }
    return record_once(out, RECORD_LINES);
}

static bool put_said(struct output *out, const struct log *log)
{
    uint64_t since = log->said - out->stored->said;
    since = since < (uint64_t)log->count ? since : (uint64_t)log->count;
    if (since == 0)
        return true;
    record_begin(out);
    while (since-- > 0) {
        buffer_put(&out->record, text_of(log_line(log, (int)since)));
        buffer_char(&out->record, '\n');
    }
    out->stored->said = log->said;
    return record_once(out, RECORD_SAID);
}

/* [byte] of both that a new file would have. */
static uint64_t live_text(const struct session *session)
{
    const struct history *history = &session->history;
    uint64_t bytes = (history->count - history->first) * sizeof *history->entry + history->text.len;
    for (int i = 0; i < session->log.count; i++)
        bytes += strlen(log_line(&session->log, i)) + 1;
    return bytes;
}

/* ---- all the rest ---- */

static void put_settings(const struct settings *settings, struct buffer *to)
{
    const size_t begun = field_begin(to, "settings");
    for (size_t i = 0; i < setting_catalog.count; i++) {
        const struct setting *setting = setting_at(i);
        const bool chosen = setting_is_chosen(setting, settings);
        const struct row *choice = setting_choice(setting, settings);
        const size_t of = field_begin(to, setting->row.name);
        field_put(to, "chosen", &chosen, sizeof chosen);
        if (choice)
            field_text(to, "choice", text_of(choice->name));
        field_put(to, "value", (const char *)settings + setting->offset, setting->bytes);
        field_end(to, of);
    }
    field_end(to, begun);
}

/* Its bytes, without the address of a name that stands beside it: put_fit(). */
static void put_item(const struct store_array *array, const void *item, struct buffer *to)
{
    struct stored_fit fit;
    if (array->offset == offsetof(struct session, stored_fit)) {
        memcpy(&fit, item, sizeof fit);
        fit.fit.model = NULL;
        item = &fit;
    }
    buffer_put(to, (struct text){item, array->item});
}

static void put_arrays(const struct session *session, struct buffer *to)
{
    for (size_t i = 0; i < store_array_count; i++) {
        const struct store_array *array = &store_arrays[i];
        const char *at = (const char *)session + array->offset;
        const int count = *(const int *)(const void *)((const char *)session + array->count);
        const size_t item = array->item;
        if (array->max == 0)
            at = *(char *const *)(const void *)at;
        const size_t begun = field_begin(to, array->name);
        field_put(to, "item", &item, sizeof item);
        const size_t items = field_begin(to, "items");
        for (int k = 0; k < count; k++)
            put_item(array, at + (size_t)k * item, to);
        field_end(to, items);
        field_end(to, begun);
    }
}

static void put_fit(const struct session *session, struct buffer *to)
{
    if (session->has_fit)
        field_text(to, "fit_model", text_of(session->fit.model));
    struct fit fit;
    memcpy(&fit, &session->fit, sizeof fit);
    fit.model = NULL;
    field_put(to, "fit", &fit, sizeof fit);
    for (int i = 0; i < session->stored_fits; i++)
        field_text(to, "stored_model", text_of(session->stored_fit[i].fit.model));
    for (int i = 0; i < 2 && session->fit_samples > 0; i++)
        field_put(to, i ? "fit_values" : "fit_times", session->fit_curve[i],
                  session->fit_samples * sizeof(double));
    if (session->has_fit && session->fit_scene.model)
        put_scene(&session->fit_scene, "fit_scene", to);
    if (session->adopted.scene.model)
        put_scene(&session->adopted.scene, "adopted_scene", to);
}

static void put_tables(const struct session *session, struct buffer *to)
{
    for (int i = 0; i < session->found.count; i++) {
        const struct stored_table *of = session->found.of[i];
        const size_t begun = field_begin(to, "table");
        field_text(to, "kind", text_of(of->kind));
        const size_t text = field_begin(to, "csv");
        table_format(&of->table, TABLE_CSV, to);
        field_end(to, text);
        field_end(to, begun);
    }
    if (session->studied)
        field_text(to, "studied", text_of(session->studied));
}

static void put_lesson(const struct lesson *lesson, struct buffer *to)
{
    if (!lesson)
        return;
    const size_t begun = field_begin(to, "lesson");
    fields_put(to, store_lesson, store_lesson_count, lesson);
    field_text(to, "text", buffer_text(&lesson->text));
    field_end(to, begun);
}

static void put_state(const struct session *session, struct buffer *to)
{
    const struct setup *setup = &session->setup;
    field_text(to, "version", text_of(HOOKE_VERSION));
    fields_put(to, store_session, store_session_count, session);
    for (int i = 0; i < session->recordings; i++)
        put_loaded(session->recording[i], to);
    for (int i = 0; i < setup->owns; i++) {
        struct scene scene;
        scene_init(&scene, setup->own[i]);
        put_scene(&scene, "own", to);
    }
    put_scene(&setup->scene, "scene", to);
    put_events(setup->events, to);
    field_text(to, "method", text_of(setup->method->row.name));
    put_settings(&setup->settings, to);
    put_arrays(session, to);
    put_fit(session, to);
    put_tables(session, to);
    put_lesson(session->lesson, to);
    const size_t runs = field_begin(to, "runs");
    for (int i = 0; i < session->runs; i++)
        buffer_put(to,
                   (struct text){(const char *)&session->run[i]->id, sizeof session->run[i]->id});
    field_end(to, runs);
    const size_t view = field_begin(to, "view");
    fields_put(to, store_view, store_view_count, &session->view);
    if (session->view.focus)
        field_text(to, "focus", text_of(session->view.focus->name));
    field_end(to, view);
}

static bool put_all(struct output *out, struct session *session)
{
    forget_recordings(out->stored, session);
    for (int i = 0; i < session->recordings; i++)
        if (!put_recording(out, session->recording[i]))
            return false;
    if (!put_runs(out, session) || !put_lines(out, session) || !put_said(out, &session->log))
        return false;
    record_begin(out);
    put_state(session, &out->record);
    const uint64_t sum = out->record.failed ? 0 : bytes_sum(content_of(out));
    if (sum == out->stored->state && !out->written && !out->record.failed)
        return true;
    if (!record_once(out, RECORD_STATE))
        return false;
    out->stored->state = sum;
    out->stored->latest = out->record.len + live_text(session);
    return true;
}

bool session_store(struct session *session, struct stored *stored, const struct store_sink *sink,
                   struct error *error)
{
    struct output out = {.stored = stored, .sink = sink, .error = error};
    const bool ok = put_all(&out, session);
    buffer_free(&out.record);
    return ok;
}

void stored_free(struct stored *stored)
{
    free(stored->run);
    *stored = (struct stored){0};
}
