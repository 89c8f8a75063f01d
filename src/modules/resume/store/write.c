/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes a session as records: those of what has changed since the last call. */
#include <hooke/data.h>
#include <hooke/base/file.h>
#include <hooke/base/cancel.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/module.h>
#include "modules/resume/store/reading.h"

#include <stdlib.h>
#include <string.h>

#define ROWS_AT_ONCE ((size_t)1 << 12)    /* number of rows in a record */
#define WRITTEN_AT_ONCE ((size_t)1 << 20) /* [byte] */

/* The state of a run in the file. */
struct stored_run {
    uint64_t id, sum; /* id and checksum of the last R */
    size_t rows;      /* number of rows in the file */
    bool left_out;
};

/* A call of session_store(). */
struct output {
    struct stored *stored;
    const struct store_sink *sink;
    struct error *error;
    bool written; /* records were written, so that an S has to follow */
};

/* ---- records ---- */

/* Returns true, and sets stored->unfinished, if the caller has cancelled the writing; a later call
 * of session_store() continues it. */
static bool must_stop(struct output *output)
{
    output->stored->unfinished = cancelled(output->sink->cancel);
    return output->stored->unfinished;
}

/* Begins a record in the buffer, with an empty head. */
static void record_begin(struct output *output)
{
    static const struct record_head none;
    struct stored *stored = output->stored;
    stored->sent = SIZE_MAX; /* nothing of it is to be written yet */
    buffer_clear(&stored->record);
    buffer_put(&stored->record, (struct text){(const char *)&none, sizeof none});
}

/* Returns the content of the record so far. */
static struct text content_of(const struct output *output)
{
    const struct text all = buffer_text(&output->stored->record);
    return text_after(all, sizeof(struct record_head));
}

/* Writes the part of the record that the file does not have yet (from byte stored->sent on), in
 * pieces of at most WRITTEN_AT_ONCE. Returns false with an error, or if cancelled between two
 * pieces; the next call of session_store() then continues with the remaining ones. */
static bool record_send(struct output *output)
{
    struct stored *stored = output->stored;
    while (stored->sent < stored->record.len) {
        struct text piece = {stored->record.data + stored->sent, stored->record.len - stored->sent};
        piece.len = piece.len < WRITTEN_AT_ONCE ? piece.len : WRITTEN_AT_ONCE;
        if ((stored->sent > 0 && must_stop(output)) ||
            !output->sink->write(output->sink->context, piece, output->error))
            return false;
        stored->sent += piece.len;
    }
    return true;
}

/* Fills in the head of the record and writes it. Returns false with an error, or if stopped. */
static bool record_end(struct output *output, enum record_kind kind)
{
    struct record_head head = {.magic = RECORD_MAGIC, .kind = kind};
    struct stored *stored = output->stored;
    if (stored->record.failed)
        return error_memory(output->error);
    head.bytes = content_of(output).len;
    head.sum = bytes_sum(content_of(output));
    head.own = bytes_sum((struct text){(const char *)&head, offsetof(struct record_head, own)});
    memcpy(stored->record.data, &head, sizeof head);
    stored->bytes += stored->record.len;
    stored->sent = 0;
    output->written = true;
    return record_send(output);
}

/* ---- runs ---- */

/* Appends the requests of a run's journal. */
static void put_asked(const struct run_slot *slot, struct buffer *output)
{
    const struct request **list;
    int count;
    if (!journal_list(slot->last, 0, &list, &count)) {
        output->failed = true;
        return;
    }
    for (int i = 0; i < count; i++) {
        const size_t begun = field_begin(output, "asked");
        fields_put(output, store_request, store_request_count, list[i]);
        if (list[i]->condition)
            field_text(output, "condition", text_of(list[i]->condition));
        field_end(output, begun);
    }
    free(list);
}

/* Returns what the file has of the run with that id, or NULL. */
static struct stored_run *find_run(struct stored *stored, uint64_t id)
{
    for (int i = 0; i < stored->runs; i++)
        if (stored->run[i].id == id)
            return &stored->run[i];
    return NULL;
}

/* Adds a run to those that the file has. Returns NULL if out of memory. */
static struct stored_run *stored_run_add(struct stored *stored, uint64_t id)
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

/* Writes the rows of a run from the first one on that differs from those in the file. Returns false
 * with an error, or if stopped or past the deadline. */
static bool put_rows(struct output *output, struct run *run, struct stored_run *stored_run)
{
    struct stored *stored = output->stored;
    const size_t rows = run_recorded(run), bytes = run_row_bytes(run);
    const size_t same = run_rows_stored(run),
                 first = same < stored_run->rows ? same : stored_run->rows;
    stored_run->rows = first;
    run_set_stored(run, rows); /* changes of rows are noted from now on */
    while (stored_run->rows < rows && !must_stop(output)) {
        const size_t left = rows - stored_run->rows,
                     count = left < ROWS_AT_ONCE ? left : ROWS_AT_ONCE;
        const struct rows_head head = {stored_run->id, stored_run->rows, count, bytes};
        record_begin(output);
        buffer_put(&stored->record, (struct text){(const char *)&head, sizeof head});
        run_store_rows(run, stored_run->rows, count, &stored->record);
        stored_run->rows += count;
        if (!record_end(output, RECORD_ROWS))
            return false;
        if (output->sink->deadline > 0 && stored_run->rows < rows &&
            clock_ns() > output->sink->deadline) {
            stored->unfinished = true;
            break;
        }
    }
    return !stored->unfinished;
}

/* Writes a run unless the file has it unchanged, with its rows unless `left_out`. `going` means
 * that it is advancing. Returns false with an error, or if stopped. */
static bool put_run(struct output *output, const struct run_slot *slot, bool left_out, bool going)
{
    struct stored_run *stored_run = find_run(output->stored, slot->id);
    if (!stored_run && !(stored_run = stored_run_add(output->stored, slot->id)))
        return error_memory(output->error);
    if (left_out) {
        stored_run->rows = 0;
    } else if (!put_rows(output, slot->run, stored_run)) {
        return false;
    }
    struct buffer *record = &output->stored->record;
    record_begin(output);
    field_put(record, "id", &slot->id, sizeof slot->id);
    field_put(record, "number", &slot->run->number, sizeof slot->run->number);
    field_put(record, "left_out", &left_out, sizeof left_out);
    field_put(record, "going", &going, sizeof going);
    field_text(record, "method", text_of(slot->run->method->row.name));
    store_put_scene(&slot->run->scene, "scene", record);
    store_put_events(slot->events, record);
    field_put(record, "statement", &slot->statement, sizeof slot->statement);
    field_put(record, "origin", slot->origin, sizeof slot->origin);
    if (slot->note)
        field_text(record, "note", text_of(slot->note));
    put_asked(slot, record);
    const size_t begun = field_begin(record, "state");
    run_store(slot->run, record);
    field_end(record, begun);
    const uint64_t sum = record->failed ? 0 : bytes_sum(content_of(output));
    if (sum == stored_run->sum && !record->failed)
        return true;
    stored_run->sum = sum;
    return record_end(output, RECORD_RUN);
}

/* Removes the runs that the session has dropped from the list of those in the file, if the list is
 * longer than the session's. If undo brings such a run back, it is then written again. */
static void forget_runs(struct stored *stored, const struct session *session)
{
    int kept = 0;
    for (int i = 0; stored->runs > session->runs.count && i < stored->runs; i++) {
        const struct stored_run *run = &stored->run[i];
        bool there = false;
        for (int k = 0; k < session->runs.count && !there; k++)
            there = session->runs.slot[k]->id == run->id;
        if (there)
            stored->run[kept++] = *run;
    }
    stored->runs = stored->runs > session->runs.count ? kept : stored->runs;
}

/* Writes all runs, the newest first; older ones without rows once all rows exceed STORE_ROW_BYTES.
 * Returns false with an error, or if stopped. */
static bool put_runs(struct output *output, const struct session *session)
{
    size_t all = 0;
    int without_room = 0;
    for (int i = session->runs.count; i-- > 0;) {
        const struct run *run = session->runs.slot[i]->run;
        all += run_recorded(run) * run_row_bytes(run);
        const bool left_out = all > STORE_ROW_BYTES;
        without_room += left_out;
        const bool going = session->live.advancing && i == session->runs.current;
        if (must_stop(output) || !put_run(output, session->runs.slot[i], left_out, going))
            return false;
    }
    output->stored->left_out = without_room;
    forget_runs(output->stored, session);
    return true;
}

/* ---- recordings ---- */

/* Returns true if the file has a recording with that checksum. */
static bool has_recording(const struct stored *stored, uint64_t sum)
{
    for (int i = 0; i < stored->recordings; i++)
        if (stored->recording[i] == sum)
            return true;
    return false;
}

/* Removes the recordings that the session has dropped from the list of those in the file, so that
 * the list has room for all present ones. */
static void forget_recordings(struct stored *stored, const struct session *session)
{
    int kept = 0;
    for (int i = 0; i < stored->recordings; i++) {
        bool there = false;
        for (int k = 0; k < session->recordings && !there; k++)
            there = session->recording[k]->sum == stored->recording[i];
        stored->recording[kept] = stored->recording[i];
        kept += there;
    }
    stored->recordings = kept;
}

/* Stops the reading of a file when writing is to stop, for file_read_watched(). */
static bool look_while_reading(void *context, struct text content, size_t offset, uintmax_t size,
                               struct error *error)
{
    (void)content;
    (void)offset;
    (void)size;
    return !must_stop(context) || error_set(error, ERROR_CANCELLED, "stopped");
}

/* Offsets in the record at which the value of the sum and the content begin. */
struct bytes_place {
    size_t sum, content;
};

/* Begins a record of bytes whose checksum is filled in by bytes_end(). */
static struct bytes_place bytes_begin(struct output *output)
{
    struct buffer *record = &output->stored->record;
    const uint64_t later = 0;
    struct bytes_place place;
    record_begin(output);
    field_put(record, "sum", &later, sizeof later);
    place.sum = record->len - sizeof later;
    place.content = field_begin(record, "content");
    return place;
}

/* Ends a field of bytes. Returns their checksum, or 0 if it is empty or out of memory. */
static uint64_t bytes_end(struct output *output, struct bytes_place place)
{
    struct buffer *record = &output->stored->record;
    const size_t begin = place.content + sizeof(uint32_t);
    field_end(record, place.content);
    if (record->failed || record->len == begin)
        return 0;
    const uint64_t sum = bytes_sum((struct text){record->data + begin, record->len - begin});
    memcpy(record->data + place.sum, &sum, sizeof sum);
    return sum;
}

/* Writes the bytes of a recording's file, as it was loaded or as it is now, unless the file has
 * them. Without them the recording is only named. Returns false with an error, or if stopped. */
static bool put_recording(struct output *output, struct recording_slot *slot)
{
    struct stored *stored = output->stored;
    struct read_watch watch = {.context = output, .look = look_while_reading};
    struct error ignored;
    if (slot->growing || (slot->sum != 0 && has_recording(stored, slot->sum)))
        return true;
    const struct bytes_place place = bytes_begin(output);
    if (slot->content.len > 0)
        buffer_put(&stored->record, buffer_text(&slot->content));
    else
        file_read_watched(slot->recording->path, STORE_RECORDING_BYTES, &watch, &stored->record,
                          &ignored);
    if (stored->unfinished)
        return false;
    const uint64_t sum = bytes_end(output, place);
    /* the file has changed, so that the recording's own bytes are gone */
    const bool wanted = sum != 0 && (slot->sum == 0 || slot->sum == sum);
    const bool there = has_recording(stored, sum);
    if (wanted)
        slot->sum = sum;
    else
        slot->sum = slot->sum ? slot->sum : 1;
    if (!wanted || there)
        return true;
    stored->recording[stored->recordings++] = sum;
    return record_end(output, RECORD_BYTES);
}

/* Writes the bytes of a module that are written only once, such as the curve of a fit, unless the
 * file has them (by their checksum). Returns false with an error, or if stopped. */
static bool put_content(struct output *output, const struct session_part *part)
{
    struct stored *stored = output->stored;
    struct text piece[2];
    uint64_t *sum;
    const bool some = part->module->store.content(part->state, piece, &sum);
    if (some && *sum != 0 && *sum == stored->content)
        return true;
    stored->content = 0;
    if (!some)
        return true;
    const struct bytes_place place = bytes_begin(output);
    for (int i = 0; i < 2; i++)
        buffer_put(&stored->record, piece[i]);
    *sum = stored->content = bytes_end(output, place);
    return record_end(output, RECORD_BYTES);
}

/* Writes the contents of all modules that have one. Returns false with an error, or if stopped. */
static bool put_contents(struct output *output, const struct session *session)
{
    for (int i = 0; i < session->parts->count; i++)
        if (session->parts->item[i].module->store.content &&
            !put_content(output, &session->parts->item[i]))
            return false;
    return true;
}

/* ---- what was found ---- */

/* Writes large results of a module, one record each. Returns false with an error, or if stopped. */
static bool put_part(struct output *output, const struct session_part *part)
{
    struct stored *stored = output->stored;
    const struct module_store *store = &part->module->store;
    int next = 0;
    if (!store->put_next)
        return true;
    store->forget(part->state, stored);
    while (!must_stop(output)) {
        record_begin(output);
        if (!store->put_next(part->state, stored, &next))
            return true;
        const bool whole = !stored->record.failed;
        stored->found -= !whole; /* another time */
        if (!record_end(output, RECORD_FOUND))
            return false;
    }
    return false;
}

/* Writes the large results of all modules. Returns false with an error, or if stopped. */
static bool put_found(struct output *output, const struct session *session)
{
    bool ok = true;
    for (int i = 0; i < session->parts->count && ok; i++)
        ok = put_part(output, &session->parts->item[i]);
    return ok;
}

/* ---- what was typed and said ---- */

/* Writes a record with the lines typed since the last call, if there are any. While a statement is
 * executing (nesting > 0) they count as unwritten, since the entry changes when the statement ends.
 * Returns false with an error, or if stopped. */
static bool put_lines(struct output *output, const struct session *session)
{
    const struct history *history = &session->history;
    struct stored *stored = output->stored;
    if (stored->entries == history->count)
        return true;
    if (stored->entries < history->first || stored->text < history->text_first) {
        stored->entries = history->first;
        stored->text = history->text_first;
    }
    struct buffer *record = &output->stored->record;
    const size_t there = stored->text - history->text_first;
    record_begin(output);
    field_put(record, "from", &stored->entries, sizeof stored->entries);
    field_put(record, "text_from", &stored->text, sizeof stored->text);
    if (stored->entries == history->first)
        field_put(record, "lines_gone", &history->lines_gone, sizeof history->lines_gone);
    const size_t item = sizeof *history->entry;
    field_put(record, "item", &item, sizeof item);
    field_put(record, "entries", history_entry(session, stored->entries),
              (history->count - stored->entries) * sizeof *history->entry);
    field_put(record, "text", history->text.data + there, history->text.len - there);
    if (session->execution.nesting == 0) {
        stored->entries = history->count;
        stored->text = history->text_first + history->text.len;
    }
    return record_end(output, RECORD_LINES);
}

/* Writes the output printed since the last call, as far as the log has it. Returns false with an
 * error, or if stopped. */
static bool put_said(struct output *output, const struct log *log)
{
    uint64_t unsaved_lines = log->said - output->stored->said;
    unsaved_lines = unsaved_lines < (uint64_t)log->count ? unsaved_lines : (uint64_t)log->count;
    if (unsaved_lines == 0)
        return true;
    record_begin(output);
    while (unsaved_lines-- > 0) {
        buffer_put(&output->stored->record, text_of(log_line(log, (int)unsaved_lines)));
        buffer_char(&output->stored->record, '\n');
    }
    output->stored->said = log->said;
    return record_end(output, RECORD_SAID);
}

/* ---- all of it ---- */

/* Writes all that has changed, then an S if anything was written. Returns false with an error, or
 * if stopped. */
static bool put_all(struct output *output, struct session *session)
{
    if (must_stop(output))
        return false;
    forget_recordings(output->stored, session);
    for (int i = 0; i < session->recordings; i++)
        if (!put_recording(output, session->recording[i]))
            return false;
    if (!put_contents(output, session) || !put_found(output, session) ||
        !put_runs(output, session) || !put_lines(output, session) ||
        !put_said(output, &session->log))
        return false;
    record_begin(output);
    store_put_state(session, &output->stored->record);
    const uint64_t sum = output->stored->record.failed ? 0 : bytes_sum(content_of(output));
    if (sum == output->stored->state && !output->written && !output->stored->record.failed)
        return true;
    if (!record_end(output, RECORD_STATE))
        return false;
    output->stored->state = sum;
    return true;
}

/* Writes the rest of a record at which the last call was stopped, then what has changed since.
 * Returns true also if it is stopped again; stored->unfinished is set then. */
bool session_store(struct session *session, struct stored *stored, const struct store_sink *sink,
                   struct error *error)
{
    struct output output = {
        .stored = stored, .sink = sink, .error = error, .written = stored->unfinished};
    stored->unfinished = false;
    const bool ok = record_send(&output) && put_all(&output, session);
    if (!stored->unfinished)
        buffer_free(&stored->record);
    return ok || stored->unfinished;
}

void stored_free(struct stored *stored)
{
    free(stored->run);
    buffer_free(&stored->record);
    *stored = (struct stored){0};
}
