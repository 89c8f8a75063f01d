/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps in files that grow: reading and checking, adding, making whole. */
#define _GNU_SOURCE /* pread */
#include <hooke/report/sweep.h>
#include <hooke/base/fields.h>

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PIECE ((size_t)1 << 16)
#define LINE_MOST ((size_t)1 << 22) /* [byte] */
#define NAMES "point,"
#define MARK "# points "
#define SHARD "# shard = "

/* ---- line by line, in memory that does not grow with the file ---- */

struct line_reader {
    int fd;
    int64_t at; /* [byte] of the next line */
    char *data;
    size_t used, len, capacity;
    int64_t number; /* of the line, from 1 */
};

enum line_state { LINE_NONE, LINE_WHOLE, LINE_PART, LINE_FAILED };

static enum line_state refill(struct line_reader *reader)
{
    if (reader->used > 0) /* before the first there is no memory */
        memmove(reader->data, reader->data + reader->used, reader->len - reader->used);
    reader->len -= reader->used;
    reader->used = 0;
    if (reader->capacity - reader->len < PIECE) {
        char *more = reader->capacity < LINE_MOST
                         ? realloc(reader->data, 2 * reader->capacity + 2 * PIECE)
                         : NULL;
        if (!more)
            return LINE_FAILED;
        reader->data = more;
        reader->capacity = 2 * reader->capacity + 2 * PIECE;
    }
    ssize_t got;
    do
        got = pread(reader->fd, reader->data + reader->len, PIECE,
                    (off_t)(reader->at + (int64_t)reader->len));
    while (got < 0 && errno == EINTR);
    reader->len += got > 0 ? (size_t)got : 0;
    return got < 0 ? LINE_FAILED : got == 0 ? LINE_NONE : LINE_WHOLE;
}

/* With its newline; the last one may have none. */
static enum line_state next_line(struct line_reader *reader, struct text *line)
{
    const char *end = NULL;
    while (!(end = reader->len > reader->used
                       ? memchr(reader->data + reader->used, '\n', reader->len - reader->used)
                       : NULL)) {
        const enum line_state state = refill(reader);
        if (state == LINE_FAILED)
            return state;
        if (state == LINE_NONE)
            break;
    }
    const char *begin = reader->data + reader->used;
    const size_t left = reader->len - reader->used;
    *line = (struct text){begin, end ? (size_t)(end + 1 - begin) : left};
    reader->used += line->len;
    reader->at += (int64_t)line->len;
    reader->number++;
    return end ? LINE_WHOLE : left > 0 ? LINE_PART : LINE_NONE;
}

static uint64_t add_line(uint64_t sum, struct text line)
{
    return (sum ^ bytes_sum(line)) * 0x100000001b3u;
}

/* ---- reading ---- */

struct scan {
    struct sweep_file *file;
    struct line_reader lines;
    struct buffer head;       /* of the present segment, where it is not the first */
    bool in_head, in_rows;    /* what the line before was */
    struct sweep_block block; /* the present one */
    int64_t row_line;         /* where it begins */
    uint64_t sum;
    struct error *error;
};

static bool is_wrong(const struct scan *scan, int64_t line, const char *what)
{
    char name[SAFE_NAME_SIZE];
    error_set(scan->error, ERROR_IO, "%s, line %lld: %s",
              safe_name(text_of(scan->file->path), name), (long long)line, what);
    return error_hint(scan->error, "the file is left as it is");
}

static bool end_head(struct scan *scan)
{
    struct sweep_file *file = scan->file;
    scan->in_head = false;
    if (file->segments > 1 && !text_equal(buffer_text(&scan->head), buffer_text(&file->head)))
        return is_wrong(scan, scan->lines.number - 1,
                        "what begins above is of another sweep than what comes before");
    if (file->segments > 1)
        return true;
    struct text rest = buffer_text(&file->head), line;
    for (file->seed = 0; text_split(&rest, '\n', &line) && line.len > 0;)
        file->seed = add_line(file->seed, line);
    return true;
}

static bool take_head(struct scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    if (scan->in_rows)
        return is_wrong(scan, scan->row_line,
                        "the rows from here on have no mark: the shard that they are from was not "
                        "whole when it was put here");
    if (!scan->in_head) {
        buffer_clear(&scan->head);
        file->segments++;
        scan->in_head = true;
    }
    if (text_starts(line, TEXT(SHARD))) {
        long long part = 0, of = 0;
        char z[64];
        snprintf(z, sizeof z, "%.*s", (int)(line.len < 60 ? line.len : 60), line.at);
        if (sscanf(z, SHARD "%lld/%lld", &part, &of) != 2 || part < 1 || part > of)
            return is_wrong(scan, scan->lines.number, "this is no shard");
        if (file->segments == 1) {
            file->shard = part;
            file->shards = of;
        }
        return true;
    }
    struct buffer *head = file->segments == 1 ? &file->head : &scan->head;
    buffer_put(head, line);
    return !head->failed || error_memory(scan->error);
}

static bool take_names(struct scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    if (!scan->in_head || file->names.len > 0)
        return is_wrong(scan, scan->lines.number, "the names of the columns do not belong here");
    buffer_put(&file->names, line);
    return end_head(scan);
}

static bool take_row(struct scan *scan, struct text line)
{
    char z[32];
    snprintf(z, sizeof z, "%.*s", (int)(line.len < 24 ? line.len : 24), line.at);
    char *end;
    const int64_t point = strtoll(z, &end, 10);
    if (scan->in_head && !end_head(scan))
        return false;
    if (!(line.at[0] >= '0' && line.at[0] <= '9') || *end != ',' || scan->file->segments == 0)
        return is_wrong(scan, scan->lines.number, "this is no row of a sweep");
    if (!scan->in_rows) {
        scan->block =
            (struct sweep_block){.first = point, .at = scan->lines.at - (int64_t)line.len};
        scan->row_line = scan->lines.number;
        scan->sum = scan->file->seed;
        scan->in_rows = true;
    }
    if (point != scan->block.first + scan->block.count)
        return is_wrong(scan, scan->lines.number, "another point belongs here");
    scan->block.count++;
    scan->block.bytes += (int64_t)line.len;
    scan->sum = add_line(scan->sum, line);
    return true;
}

static bool keep_block(struct sweep_file *file, struct sweep_block block, struct error *error)
{
    if (file->blocks == file->capacity) {
        const size_t capacity = file->capacity ? 2 * file->capacity : 16;
        struct sweep_block *more = realloc(file->block, capacity * sizeof *more);
        if (!more)
            return error_memory(error);
        file->block = more;
        file->capacity = capacity;
    }
    file->block[file->blocks++] = block;
    return true;
}

static void put_mark(const struct sweep_block *block, int64_t total, uint64_t sum,
                     struct buffer *text)
{
    buffer_format(text, MARK "%lld to %lld of %lld: %s, sum %016" PRIx64 "\n",
                  (long long)block->first, (long long)(block->first + block->count - 1),
                  (long long)total, block->whole ? "whole" : "so far", sum);
}

/* The mark is the one that belongs to these rows, and no other. */
static bool take_mark(struct scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    struct buffer right = {0};
    long long from, to, total = 0;
    char z[160];
    snprintf(z, sizeof z, "%.*s", (int)(line.len < 150 ? line.len : 150), line.at);
    if (sscanf(z, MARK "%lld to %lld of %lld", &from, &to, &total) != 3 ||
        (file->total > 0 && total != file->total))
        return is_wrong(scan, scan->lines.number, "this is no mark of this sweep");
    if (!scan->in_rows)
        return is_wrong(scan, scan->lines.number, "the rows of this mark are missing");
    scan->block.whole = strstr(z, ": whole,") != NULL;
    put_mark(&scan->block, total, scan->sum, &right);
    const bool same = text_equal(buffer_text(&right), line);
    buffer_free(&right);
    if (!same) {
        char what[160];
        snprintf(what, sizeof what,
                 "the rows from line %lld to here are not those that were written: they, this line "
                 "or the head were changed",
                 (long long)scan->row_line);
        return is_wrong(scan, scan->lines.number, what);
    }
    file->total = total;
    file->end = scan->lines.at;
    scan->in_rows = false;
    return keep_block(file, scan->block, scan->error);
}

static bool take_line(struct scan *scan, struct text line)
{
    if (text_starts(line, TEXT(MARK)))
        return take_mark(scan, line);
    if (text_starts(line, TEXT("# ")))
        return take_head(scan, line);
    const bool ok = text_starts(line, TEXT(NAMES)) ? take_names(scan, line) : take_row(scan, line);
    if (ok && !scan->in_rows)
        scan->file->end = scan->lines.at; /* the head is whole, so far */
    return ok;
}

bool sweep_file_read(int fd, struct sweep_file *file, struct error *error)
{
    struct scan scan = {.file = file, .lines = {.fd = fd}, .error = error};
    struct text line;
    enum line_state state = LINE_NONE;
    bool ok = true;
    file->shard = file->shards = 1;
    while (ok && (state = next_line(&scan.lines, &line)) == LINE_WHOLE) {
        ok = take_line(&scan, line);
        if (ok && cancelled_at(file->cancel, (size_t)scan.lines.number))
            ok = error_set(error, ERROR_CANCELLED, "stopped: nothing was changed");
        if (scan.in_head && file->blocks == 0)
            file->end = scan.lines.at;
    }
    if (ok && state == LINE_FAILED)
        ok = is_wrong(&scan, scan.lines.number + 1, "it cannot be read from here on");
    if (ok && scan.in_head)
        ok = end_head(&scan);
    /* Of what a killed program was writing, this is the beginning. */
    if (ok && state == LINE_PART && !text_starts(line, TEXT("#")) && file->blocks > 0 &&
        !(line.at[0] >= '0' && line.at[0] <= '9'))
        ok = is_wrong(&scan, scan.lines.number, "this is no row of a sweep");
    file->size = scan.lines.at;
    free(scan.lines.data);
    buffer_free(&scan.head);
    return ok;
}

void sweep_file_free(struct sweep_file *file)
{
    buffer_free(&file->head);
    buffer_free(&file->names);
    free(file->block);
    file->block = NULL;
}

/* ---- which points are there ---- */

static int by_first(const void *a, const void *b)
{
    const struct sweep_block *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

bool sweep_file_arrange(struct sweep_file *file, int64_t first, int64_t count, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    int64_t next = first;
    if (file->blocks > 0)
        qsort(file->block, file->blocks, sizeof *file->block, by_first);
    for (size_t i = 0; i < file->blocks; i++) {
        const struct sweep_block *block = &file->block[i];
        const bool outside = block->first < first || block->first + block->count > first + count;
        if (outside || block->first < next) {
            error_set(error, ERROR_IO, "%s has point %lld %s", safe_name(text_of(file->path), name),
                      (long long)block->first,
                      outside ? "or some behind it that are not of this shard" : "twice");
            return error_hint(error, "the file is left as it is");
        }
        next = block->first + block->count;
    }
    return true;
}

bool sweep_file_gap(const struct sweep_file *file, int64_t from, int64_t end, int64_t *first,
                    int64_t *count)
{
    *first = from;
    int64_t next = end;
    for (size_t i = 0; i < file->blocks; i++) {
        const struct sweep_block *block = &file->block[i];
        if (block->first <= *first && *first < block->first + block->count)
            *first = block->first + block->count;
        else if (block->first > *first && block->first < next)
            next = block->first;
        if (block->first > *first)
            break;
    }
    *count = next - *first;
    return *count > 0;
}

/* ---- writing ---- */

static bool put_lines(struct sweep_file *file, int fd, struct buffer *lines, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct error why = {0};
    bool ok = !lines->failed || error_memory(error);
    if (ok && !append_lines(fd, buffer_text(lines), true, &why)) {
        ok = error_set(error, ERROR_IO, "cannot write %s: %s", safe_name(text_of(file->path), name),
                       why.text);
        error_hint(error, "what it has is kept; the same statement goes on with it");
    }
    if (ok)
        file->end = file->size = file->end + (int64_t)lines->len;
    buffer_free(lines);
    return ok;
}

bool sweep_file_begin(struct sweep_file *file, int fd, struct text head, struct text shard,
                      struct text names, struct error *error)
{
    struct buffer lines = {0};
    struct text rest = head, line;
    buffer_put(&lines, head);
    buffer_put(&lines, shard);
    buffer_put(&lines, names);
    buffer_clear(&file->head);
    buffer_put(&file->head, head);
    for (file->seed = 0; text_split(&rest, '\n', &line) && line.len > 0;)
        file->seed = add_line(file->seed, line);
    file->segments = 1;
    return put_lines(file, fd, &lines, error);
}

bool sweep_file_add(struct sweep_file *file, int fd, int64_t first, int64_t count, struct text rows,
                    struct error *error)
{
    const struct sweep_block block = {
        .first = first, .count = count, .at = file->end, .bytes = (int64_t)rows.len};
    struct buffer lines = {0};
    uint64_t sum = file->seed;
    buffer_put(&lines, rows);
    for (const char *at = rows.at, *end = rows.at + rows.len; at < end;) {
        const char *next = memchr(at, '\n', (size_t)(end - at));
        const size_t len = next ? (size_t)(next + 1 - at) : (size_t)(end - at);
        sum = add_line(sum, (struct text){at, len});
        at += len;
    }
    put_mark(&block, file->total, sum, &lines);
    return put_lines(file, fd, &lines, error) && keep_block(file, block, error);
}

bool sweep_file_is_whole(const struct sweep_file *file, int64_t first, int64_t count)
{
    return file->segments == 1 && file->blocks == 1 && file->block[0].whole &&
           file->block[0].first == first && file->block[0].count == count &&
           file->size == file->end;
}

bool sweep_file_make_whole(const struct sweep_file *file, int fd, struct text shard,
                           struct text names, struct writer *writer, struct error *error)
{
    struct line_reader lines = {.fd = fd};
    struct buffer mark = {0};
    struct text line;
    struct sweep_block all = {.first = file->block[0].first, .whole = true};
    uint64_t sum = file->seed;
    bool ok = true;
    writer_put(writer, buffer_text(&file->head));
    writer_put(writer, shard);
    writer_put(writer, names);
    for (size_t i = 0; i < file->blocks && ok; i++) {
        const struct sweep_block *block = &file->block[i];
        lines.at = block->at;
        lines.used = lines.len = 0;
        for (int64_t k = 0; k < block->count && ok; k++) {
            ok = next_line(&lines, &line) == LINE_WHOLE && !cancelled_at(file->cancel, (size_t)k);
            sum = ok ? add_line(sum, line) : 0;
            if (ok)
                writer_put(writer, line);
        }
        all.count += block->count;
    }
    put_mark(&all, file->total, sum, &mark);
    writer_put(writer, buffer_text(&mark));
    ok &= !mark.failed;
    buffer_free(&mark);
    free(lines.data);
    if (!ok && cancelled(file->cancel))
        return error_set(error, ERROR_CANCELLED, "stopped: all points are there, not yet in order");
    return ok || error_set(error, ERROR_IO, "what was written cannot be read again");
}
