/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the valid records of a session file, whatever is between them. */
#include "modules/resume/store/reading.h"

#include <stdlib.h>
#include <string.h>

/* Makes room for one more item of `item` bytes in the array to which *list points (list is the
 * address of a pointer), which holds `count` of *capacity items. Returns false, with the array
 * unchanged, if out of memory. */
static bool reserve(void *list, size_t count, size_t *capacity, size_t item)
{
    if (count < *capacity)
        return true;
    const size_t more = *capacity ? 2 * *capacity : 64;
    void *larger = realloc(*(void **)list, more * item);
    if (!larger)
        return false;
    *(void **)list = larger;
    *capacity = more;
    return true;
}

/* Reads the head of a record. Returns false if there is none, or if its checksum is wrong. */
static bool read_head(struct text content, struct record_head *head)
{
    if (content.len < sizeof *head || memcmp(content.data, RECORD_MAGIC, sizeof head->magic) != 0)
        return false;
    memcpy(head, content.data, sizeof *head);
    return head->own == bytes_sum((struct text){content.data, offsetof(struct record_head, own)});
}

/* Skips to the next valid head. Returns false if there is none. */
static bool find_record(struct text *content, struct record_head *head)
{
    while (content->len >= sizeof *head) {
        if (read_head(*content, head))
            return true;
        const char *next = memchr(content->data + 1, RECORD_MAGIC[0], content->len - 1);
        if (!next)
            return false;
        *content = (struct text){next, content->len - (size_t)(next - content->data)};
    }
    return false;
}

/* Returns true for kinds of records that this version knows. */
static bool is_known_kind(uint32_t kind)
{
    return kind != 0 && kind < 128 && strchr("DRWLTBS", (int)kind);
}

/* Adds a record to the list; one whose checksum is wrong, or of an unknown kind, is only counted.
 * Returns false if out of memory. */
static bool take_record(struct reader *reader, const struct record_head *head, struct text content)
{
    if (head->sum != bytes_sum(content)) {
        reader->damaged++;
        return true;
    }
    if (!is_known_kind(head->kind)) {
        reader->unknown++;
        return true;
    }
    if (!reserve(&reader->record, reader->records, &reader->record_capacity,
                 sizeof *reader->record))
        return false;
    reader->record[reader->records++] = (struct read_record){(enum record_kind)head->kind, content};
    return true;
}

/* Collects all records of the file and skips damaged bytes between them. Returns false if out of
 * memory. */
static bool take_records(struct reader *reader, struct text rest)
{
    struct record_head head;
    while (rest.len > 0) {
        const char *begin = rest.data;
        if (!find_record(&rest, &head))
            return true;
        reader->damaged += rest.data != begin;
        if (head.bytes > rest.len - sizeof head) {
            /* incomplete, or its length is wrong though the checksum is right */
            rest = text_after(rest, sizeof head);
            continue;
        }
        const size_t bytes = (size_t)head.bytes;
        if (!take_record(reader, &head, (struct text){rest.data + sizeof head, bytes}))
            return false;
        rest = (struct text){rest.data + sizeof head + bytes, rest.len - sizeof head - bytes};
    }
    return true;
}

/* ---- runs ---- */

/* Returns the run of that id, or NULL if the file has none. */
struct read_run *reader_run(struct reader *reader, uint64_t id)
{
    for (size_t i = reader->runs; i-- > 0;)
        if (reader->run[i].id == id)
            return &reader->run[i];
    return NULL;
}

/* Returns the run of that id, which is added if it is new, or NULL if out of memory. */
static struct read_run *read_run_of(struct reader *reader, uint64_t id)
{
    struct read_run *run = reader_run(reader, id);
    if (run)
        return run;
    if (!reserve(&reader->run, reader->runs, &reader->run_capacity, sizeof *reader->run))
        return NULL;
    reader->run[reader->runs] = (struct read_run){.id = id};
    return &reader->run[reader->runs++];
}

/* Adds rows to their run, where they replace all rows from their first one on; damaged ones are
 * ignored. The rows remain in the file's content. Returns false if out of memory. */
static bool take_rows(struct reader *reader, struct text content)
{
    struct rows_head head;
    if (content.len < sizeof head)
        return true;
    memcpy(&head, content.data, sizeof head);
    content = text_after(content, sizeof head);
    struct read_run *run = read_run_of(reader, head.id);
    if (!run || !reserve(&run->piece, run->pieces, &run->piece_capacity, sizeof *run->piece))
        return false;
    if (head.row_bytes == 0 || head.count > content.len / head.row_bytes ||
        head.first > SIZE_MAX / 2)
        return true;
    while (run->pieces > 0 && run->piece[run->pieces - 1].first >= head.first)
        run->pieces--;
    struct stored_rows *last = run->pieces > 0 ? &run->piece[run->pieces - 1] : NULL;
    if (last && last->first + last->count > head.first)
        last->count = (size_t)head.first - last->first;
    run->piece[run->pieces++] = (struct stored_rows){(size_t)head.first, (size_t)head.count,
                                                     (size_t)head.row_bytes, content.data};
    return true;
}

/* Stores the content of a run, of which the last record counts. Returns false if out of memory. */
static bool take_run(struct reader *reader, struct text content)
{
    uint64_t id;
    if (!field_get(content, "id", &id, sizeof id))
        return true;
    struct read_run *run = read_run_of(reader, id);
    if (run)
        run->content = content;
    return run != NULL;
}

/* Collects all valid records up to the last state record, which completes a save, and rows and runs
 * by id. Returns false with an error if there is no state or if out of memory. */
bool reader_scan(struct reader *reader, struct text content, struct error *error)
{
    content = text_after(content, strlen(STORE_HEADER));
    bool ok = take_records(reader, content);
    while (reader->records > 0 && reader->record[reader->records - 1].kind != RECORD_STATE)
        reader->records--;
    for (size_t i = 0; i < reader->records && ok; i++) {
        const struct read_record *record = &reader->record[i];
        if (record->kind == RECORD_ROWS)
            ok = take_rows(reader, record->content);
        else if (record->kind == RECORD_RUN)
            ok = take_run(reader, record->content);
    }
    if (!ok)
        return error_memory(error);
    if (reader->records == 0)
        return error_set(error, ERROR_IO, "no part of it is intact");
    reader->state = reader->record[reader->records - 1].content;
    return true;
}
