/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session into records: those of what has changed since the last time. */
#include <hooke/data.h>
#include <hooke/base/file.h>
#include <hooke/base/cancel.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/module.h>
#include "modules/resume/store/reading.h"

#include <stdlib.h>
#include <string.h>

#define ROWS_AT_ONCE ((size_t)1 << 12)
#define WRITTEN_AT_ONCE ((size_t)1 << 20) /* [byte] */

struct stored_run {
    uint64_t id, sum; /* of the last R */
    size_t rows;      /* in the file */
    bool left_out;
};

struct output {
    struct stored *stored;
    const struct store_sink *sink;
    struct error *error;
    bool written; /* something was: an S has to follow */
};

/* ---- records ---- */

/* To be left here, and gone on with from here another time. */
static bool stops(struct output *out)
{
    out->stored->unfinished = cancelled(out->sink->cancel);
    return out->stored->unfinished;
}

static void record_begin(struct output *out)
{
    static const struct record_head none;
    struct stored *stored = out->stored;
    stored->sent = SIZE_MAX; /* nothing of it is to be written yet */
    buffer_clear(&stored->record);
    buffer_put(&stored->record, (struct text){(const char *)&none, sizeof none});
}

static struct text content_of(const struct output *out)
{
    const struct text all = buffer_text(&out->stored->record);
    return (struct text){all.at + sizeof(struct record_head), all.len - sizeof(struct record_head)};
}

/* In pieces, with a look between them. */
static bool record_send(struct output *out)
{
    struct stored *stored = out->stored;
    while (stored->sent < stored->record.len) {
        struct text piece = {stored->record.data + stored->sent, stored->record.len - stored->sent};
        piece.len = piece.len < WRITTEN_AT_ONCE ? piece.len : WRITTEN_AT_ONCE;
        if ((stored->sent > 0 && stops(out)) ||
            !out->sink->write(out->sink->context, piece, out->error))
            return false;
        stored->sent += piece.len;
    }
    return true;
}

static bool record_end(struct output *out, enum record_kind kind)
{
    struct record_head head = {.magic = RECORD_MAGIC, .kind = kind};
    struct stored *stored = out->stored;
    if (stored->record.failed)
        return error_memory(out->error);
    head.bytes = content_of(out).len;
    head.sum = bytes_sum(content_of(out));
    head.own = bytes_sum((struct text){(const char *)&head, offsetof(struct record_head, own)});
    memcpy(stored->record.data, &head, sizeof head);
    stored->bytes += stored->record.len;
    stored->sent = 0;
    out->written = true;
    return record_send(out);
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
    for (int i = 0; i < count; i++) {
        const size_t begun = field_begin(to, "asked");
        fields_put(to, store_request, store_request_count, list[i]);
        if (list[i]->condition)
            field_text(to, "condition", text_of(list[i]->condition));
        field_end(to, begun);
    }
    free(list);
}

static struct stored_run *find_run(struct stored *stored, uint64_t id)
{
    for (int i = 0; i < stored->runs; i++)
        if (stored->run[i].id == id)
            return &stored->run[i];
    return NULL;
}

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

/* Those from the first one that is not as the file has it. */
static bool put_rows(struct output *out, struct run *run, struct stored_run *of)
{
    struct stored *stored = out->stored;
    const size_t rows = run_recorded(run), bytes = run_row_bytes(run);
    const size_t same = run_rows_stored(run), first = same < of->rows ? same : of->rows;
    of->rows = first;
    run_set_stored(run, rows); /* those that the file has are as they are from now on */
    while (of->rows < rows && !stops(out)) {
        const size_t left = rows - of->rows, count = left < ROWS_AT_ONCE ? left : ROWS_AT_ONCE;
        const struct rows_head head = {of->id, of->rows, count, bytes};
        record_begin(out);
        buffer_put(&stored->record, (struct text){(const char *)&head, sizeof head});
        run_store_rows(run, of->rows, count, &stored->record);
        of->rows += count;
        if (!record_end(out, RECORD_ROWS))
            return false;
        if (out->sink->until > 0 && of->rows < rows && clock_ns() > out->sink->until) {
            stored->unfinished = true;
            break;
        }
    }
    return !stored->unfinished;
}

static bool put_run(struct output *out, const struct run_slot *slot, bool left_out, bool going)
{
    struct stored_run *of = find_run(out->stored, slot->id);
    if (!of && !(of = stored_run_add(out->stored, slot->id)))
        return error_memory(out->error);
    if (left_out) {
        of->rows = 0;
    } else if (!put_rows(out, slot->run, of)) {
        return false;
    }
    struct buffer *to = &out->stored->record;
    record_begin(out);
    field_put(to, "id", &slot->id, sizeof slot->id);
    field_put(to, "number", &slot->run->number, sizeof slot->run->number);
    field_put(to, "left_out", &left_out, sizeof left_out);
    field_put(to, "going", &going, sizeof going);
    field_text(to, "method", text_of(slot->run->method->row.name));
    store_put_scene(&slot->run->scene, "scene", to);
    store_put_events(slot->events, to);
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
    of->sum = sum;
    return record_end(out, RECORD_RUN);
}

/* Those that were dropped; undo may bring one back, which is then written again. */
static void forget_runs(struct stored *stored, const struct session *session)
{
    int kept = 0;
    for (int i = 0; stored->runs > session->runs.count && i < stored->runs; i++) {
        const struct stored_run *of = &stored->run[i];
        bool there = false;
        for (int k = 0; k < session->runs.count && !there; k++)
            there = session->runs.slot[k]->id == of->id;
        if (there)
            stored->run[kept++] = *of;
    }
    stored->runs = stored->runs > session->runs.count ? kept : stored->runs;
}

/* The newest first, as long as there is room for their rows. */
static bool put_runs(struct output *out, const struct session *session)
{
    size_t all = 0;
    int without_room = 0;
    for (int i = session->runs.count; i-- > 0;) {
        const struct run *run = session->runs.slot[i]->run;
        all += run_recorded(run) * run_row_bytes(run);
        const bool left_out = all > STORE_ROW_BYTES;
        without_room += left_out;
        const bool going = session->live.advancing && i == session->runs.current;
        if (stops(out) || !put_run(out, session->runs.slot[i], left_out, going))
            return false;
    }
    out->stored->left_out = without_room;
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
        stored->recording[kept] = stored->recording[i];
        kept += there;
    }
    stored->recordings = kept;
}

static bool look_while_reading(void *context, struct text content, size_t from, uintmax_t size,
                               struct error *error)
{
    (void)content;
    (void)from;
    (void)size;
    return !stops(context) || error_set(error, ERROR_CANCELLED, "stopped");
}

/* Where the value of the sum and the content begin, in the record. */
struct bytes_place {
    size_t sum, content;
};

static struct bytes_place bytes_begin(struct output *out)
{
    struct buffer *record = &out->stored->record;
    const uint64_t later = 0;
    struct bytes_place place;
    record_begin(out);
    field_put(record, "sum", &later, sizeof later);
    place.sum = record->len - sizeof later;
    place.content = field_begin(record, "content");
    return place;
}

/* Ends a field of bytes. Returns their checksum, or 0 if it is empty or out of memory. */
static uint64_t bytes_end(struct output *out, struct bytes_place place)
{
    struct buffer *record = &out->stored->record;
    const size_t from = place.content + sizeof(uint32_t);
    field_end(record, place.content);
    if (record->failed || record->len == from)
        return 0;
    const uint64_t sum = bytes_sum((struct text){record->data + from, record->len - from});
    memcpy(record->data + place.sum, &sum, sizeof sum);
    return sum;
}

/* The bytes of its file as it was loaded, or as it is now; without them it is only named. */
static bool put_recording(struct output *out, struct recording_slot *slot)
{
    struct stored *stored = out->stored;
    struct read_watch watch = {.context = out, .look = look_while_reading};
    struct error ignored;
    if (slot->growing || (slot->sum != 0 && has_recording(stored, slot->sum)))
        return true;
    const struct bytes_place place = bytes_begin(out);
    if (slot->content.len > 0)
        buffer_put(&stored->record, buffer_text(&slot->content));
    else
        file_read_watched(slot->recording->path, STORE_RECORDING_BYTES, &watch, &stored->record,
                          &ignored);
    if (stored->unfinished)
        return false;
    const uint64_t sum = bytes_end(out, place);
    /* another file by now: that of the recording is gone */
    const bool wanted = sum != 0 && (slot->sum == 0 || slot->sum == sum);
    const bool there = has_recording(stored, sum);
    slot->sum = wanted ? sum : slot->sum ? slot->sum : 1;
    if (!wanted || there)
        return true;
    stored->recording[stored->recordings++] = sum;
    return record_end(out, RECORD_BYTES);
}

/* What a module has that is written once, as the curve of a fit. */
static bool put_content(struct output *out, const struct session_part *part)
{
    struct stored *stored = out->stored;
    struct text piece[2];
    uint64_t *sum;
    const bool some = part->module->store.content(part->state, piece, &sum);
    if (some && *sum != 0 && *sum == stored->content)
        return true;
    stored->content = 0;
    if (!some)
        return true;
    const struct bytes_place place = bytes_begin(out);
    for (int i = 0; i < 2; i++)
        buffer_put(&stored->record, piece[i]);
    *sum = stored->content = bytes_end(out, place);
    return record_end(out, RECORD_BYTES);
}

static bool put_contents(struct output *out, const struct session *session)
{
    for (int i = 0; i < session->parts->count; i++)
        if (session->parts->item[i].module->store.content &&
            !put_content(out, &session->parts->item[i]))
            return false;
    return true;
}

/* ---- what was found ---- */

static bool put_part(struct output *out, const struct session_part *part)
{
    struct stored *stored = out->stored;
    const struct module_store *store = &part->module->store;
    int next = 0;
    if (!store->put_next)
        return true;
    store->forget(part->state, stored);
    while (!stops(out)) {
        record_begin(out);
        if (!store->put_next(part->state, stored, &next))
            return true;
        const bool whole = !stored->record.failed;
        stored->found -= !whole; /* another time */
        if (!record_end(out, RECORD_FOUND))
            return false;
    }
    return false;
}

static bool put_found(struct output *out, const struct session *session)
{
    bool ok = true;
    for (int i = 0; i < session->parts->count && ok; i++)
        ok = put_part(out, &session->parts->item[i]);
    return ok;
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
    struct buffer *to = &out->stored->record;
    const size_t there = stored->text - history->text_first;
    record_begin(out);
    field_put(to, "from", &stored->entries, sizeof stored->entries);
    field_put(to, "text_from", &stored->text, sizeof stored->text);
    if (stored->entries == history->first)
        field_put(to, "lines_gone", &history->lines_gone, sizeof history->lines_gone);
    const size_t item = sizeof *history->entry;
    field_put(to, "item", &item, sizeof item);
    field_put(to, "entries", history_entry(session, stored->entries),
              (history->count - stored->entries) * sizeof *history->entry);
    field_put(to, "text", history->text.data + there, history->text.len - there);
    if (session->execution.nesting == 0) {
        stored->entries = history->count;
        stored->text = history->text_first + history->text.len;
    }
    return record_end(out, RECORD_LINES);
}

static bool put_said(struct output *out, const struct log *log)
{
    uint64_t since = log->said - out->stored->said;
    since = since < (uint64_t)log->count ? since : (uint64_t)log->count;
    if (since == 0)
        return true;
    record_begin(out);
    while (since-- > 0) {
        buffer_put(&out->stored->record, text_of(log_line(log, (int)since)));
        buffer_char(&out->stored->record, '\n');
    }
    out->stored->said = log->said;
    return record_end(out, RECORD_SAID);
}

/* ---- all of it ---- */

static bool put_all(struct output *out, struct session *session)
{
    if (stops(out))
        return false;
    forget_recordings(out->stored, session);
    for (int i = 0; i < session->recordings; i++)
        if (!put_recording(out, session->recording[i]))
            return false;
    if (!put_contents(out, session) || !put_found(out, session) || !put_runs(out, session) ||
        !put_lines(out, session) || !put_said(out, &session->log))
        return false;
    record_begin(out);
    store_put_state(session, &out->stored->record);
    const uint64_t sum = out->stored->record.failed ? 0 : bytes_sum(content_of(out));
    if (sum == out->stored->state && !out->written && !out->stored->record.failed)
        return true;
    if (!record_end(out, RECORD_STATE))
        return false;
    out->stored->state = sum;
    return true;
}

bool session_store(struct session *session, struct stored *stored, const struct store_sink *sink,
                   struct error *error)
{
    struct output out = {
        .stored = stored, .sink = sink, .error = error, .written = stored->unfinished};
    stored->unfinished = false;
    const bool ok = record_send(&out) && put_all(&out, session);
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
