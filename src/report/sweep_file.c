/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps in files that grow: reading and checking, adding, making whole. */
#define _GNU_SOURCE /* pread */
#include <hooke/report/sweep.h>
#include <hooke/base/fields.h>
#include <hooke/study/sweep.h>

#include <assert.h>
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
#define SWEEP ", sweep "

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

static uint64_t add_sum(uint64_t sum, uint64_t other)
{
    return (sum ^ other) * 0x100000001b3u;
}

static uint64_t add_lines(uint64_t sum, struct text lines)
{
    for (size_t at = 0, end; at < lines.len; at = end) {
        const char *next = memchr(lines.at + at, '\n', lines.len - at);
        end = next ? (size_t)(next + 1 - lines.at) : lines.len;
        sum = add_sum(sum, bytes_sum((struct text){lines.at + at, end - at}));
    }
    return sum;
}

uint64_t sweep_file_seed(struct text head)
{
    uint64_t sum = 0;
    struct text line;
    while (text_split(&head, '\n', &line) && line.len > 0)
        sum = add_sum(sum, bytes_sum(line));
    return sum;
}

/* ---- reading ---- */

struct sweep_scan {
    struct sweep_file *file;
    struct line_reader lines;
    struct buffer head;       /* of the present segment, where it is not the first */
    bool in_head, in_rows;    /* what the line before was */
    struct sweep_block block; /* the present one */
    int64_t row_line;         /* where it begins */
    uint64_t sum, seeded;     /* of its rows; as it was before marks named their sweep */
    struct error *error;
};

static bool is_wrong(const struct sweep_scan *scan, int64_t line, const char *what)
{
    char name[SAFE_NAME_SIZE];
    error_set(scan->error, ERROR_IO, "%s, line %lld: %s",
              safe_name(text_of(scan->file->path), name), (long long)line, what);
    return error_hint(scan->error, "the file is left as it is");
}

static bool end_head(struct sweep_scan *scan)
{
    struct sweep_file *file = scan->file;
    scan->in_head = false;
    const uint64_t seed =
        sweep_file_seed(buffer_text(file->segments > 1 ? &scan->head : &file->head));
    if ((file->total > 0 || file->segments > 1) && seed != file->seed)
        return is_wrong(scan, scan->lines.number - 1,
                        "what begins above is of another sweep than what comes before");
    file->seed = seed;
    return true;
}

static bool take_head(struct sweep_scan *scan, struct text line)
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
        if (file->segments == 1 && file->blocks == 0) {
            file->shard = part;
            file->shards = of;
        }
        return true;
    }
    struct buffer *head = file->segments == 1 ? &file->head : &scan->head;
    buffer_put(head, line);
    return !head->failed || error_memory(scan->error);
}

static bool take_names(struct sweep_scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    if (!scan->in_head || file->names.len > 0)
        return is_wrong(scan, scan->lines.number, "the names of the columns do not belong here");
    buffer_put(&file->names, line);
    return end_head(scan);
}

static bool take_row(struct sweep_scan *scan, struct text line)
{
    char z[32];
    snprintf(z, sizeof z, "%.*s", (int)(line.len < 24 ? line.len : 24), line.at);
    char *end;
    const int64_t point = strtoll(z, &end, 10);
    if (scan->in_head && !end_head(scan))
        return false;
    if (!(line.at[0] >= '0' && line.at[0] <= '9') || *end != ',')
        return is_wrong(scan, scan->lines.number, "this is no row of a sweep");
    if (!scan->in_rows) {
        scan->block =
            (struct sweep_block){.first = point, .at = scan->lines.at - (int64_t)line.len};
        scan->row_line = scan->lines.number;
        scan->sum = 0;
        scan->seeded = scan->file->seed;
        scan->in_rows = true;
    }
    const int64_t next = scan->block.first + scan->block.count;
    if (point != next && (scan->block.count == 0 || point != next - 1))
        return is_wrong(scan, scan->lines.number, "another point belongs here");
    scan->block.count += point == next;
    const uint64_t sum = bytes_sum(line);
    scan->sum = add_sum(scan->sum, sum);
    scan->seeded = add_sum(scan->seeded, sum);
    return true;
}

/* What goes on where the last one ends is one with it, in memory that does not grow. */
static bool keep_block(struct sweep_file *file, struct sweep_block block, struct error *error)
{
    struct sweep_block *last = file->blocks > 0 ? &file->block[file->blocks - 1] : NULL;
    if (last && last->first + last->count == block.first && last->at + last->bytes == block.at) {
        last->count += block.count;
        last->bytes += block.bytes;
        return true;
    }
    if (file->blocks == file->capacity) {
        const size_t capacity = file->capacity ? 2 * file->capacity : 16;
        struct sweep_block *more = realloc(file->block, capacity * sizeof *more);
        if (!more)
            return error_memory(error);
        file->block = more;
        file->capacity = capacity;
    }
    assert(file->block);
    file->block[file->blocks++] = block;
    return true;
}

static void put_mark(const struct sweep_block *block, int64_t total, uint64_t sum,
                     struct buffer *text)
{
    buffer_format(text, MARK "%lld to %lld of %lld: %s, sum %016" PRIx64, (long long)block->first,
                  (long long)(block->first + block->count - 1), (long long)total,
                  block->whole ? "whole" : "so far", sum);
}

static void put_new_mark(const struct sweep_block *block, int64_t total, uint64_t sum,
                         uint64_t seed, struct buffer *text)
{
    put_mark(block, total, add_sum(sum, seed), text);
    buffer_format(text, SWEEP "%016" PRIx64 "\n", seed);
}

double sweep_file_mark_bytes(int64_t total)
{
    const struct sweep_block block = {.first = total / 2, .count = 1, .whole = true};
    struct buffer text = {0};
    put_new_mark(&block, total, 0, 0, &text);
    const double bytes = (double)text.len / (double)sweep_cell(total);
    buffer_free(&text);
    return bytes;
}

static bool is_cell(const struct sweep_block *block, int64_t total)
{
    const int64_t cell = sweep_cell(total), left = total - block->first;
    return block->whole && block->first % cell == 0 && block->count == (left < cell ? left : cell);
}

/* The mark is the one that belongs to these rows, and no other. */
static bool is_right(struct sweep_scan *scan, struct text line, const char *sweep, int64_t total)
{
    struct sweep_file *file = scan->file;
    struct buffer right = {0};
    const uint64_t seed =
        sweep && file->total == 0 && file->segments == 0
            ? strtoull(sweep + strlen(SWEEP), NULL, 16) /* the head is in another file */
            : file->seed;
    if (sweep) {
        put_new_mark(&scan->block, total, scan->sum, seed, &right);
        file->seed = seed;
    } else {
        put_mark(&scan->block, total, scan->seeded, &right);
        buffer_char(&right, '\n');
    }
    const bool same = text_equal(buffer_text(&right), line);
    buffer_free(&right);
    return same;
}

static bool take_mark(struct sweep_scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    long long from, to, total = 0;
    char z[160];
    snprintf(z, sizeof z, "%.*s", (int)(line.len < 150 ? line.len : 150), line.at);
    const char *sweep = strstr(z, SWEEP);
    if (sscanf(z, MARK "%lld to %lld of %lld", &from, &to, &total) != 3 || total < 1 ||
        (file->total > 0 && total != file->total))
        return is_wrong(scan, scan->lines.number, "this is no mark of this sweep");
    if (!scan->in_rows)
        return is_wrong(scan, scan->lines.number, "the rows of this mark are missing");
    scan->block.whole = strstr(z, ": whole,") != NULL;
    if (!is_right(scan, line, sweep, total)) {
        char what[160];
        snprintf(what, sizeof what,
                 "the rows from line %lld to here are not those that were written: they, this line "
                 "or the head were changed",
                 (long long)scan->row_line);
        return is_wrong(scan, scan->lines.number, what);
    }
    file->ragged |= !sweep || !is_cell(&scan->block, total);
    file->total = total;
    file->end = scan->lines.at;
    scan->block.bytes = file->end - scan->block.at;
    scan->in_rows = false;
    return keep_block(file, scan->block, scan->error);
}

static bool take_line(struct sweep_scan *scan, struct text line)
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
    struct sweep_scan scan = {.file = file, .lines = {.fd = fd}, .error = error};
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
    buffer_put(&lines, head);
    buffer_put(&lines, shard);
    buffer_put(&lines, names);
    buffer_clear(&file->head);
    buffer_put(&file->head, head);
    file->seed = sweep_file_seed(head);
    file->segments = 1;
    return put_lines(file, fd, &lines, error);
}

bool sweep_file_add(struct sweep_file *file, int fd, int64_t first, int64_t count, struct text rows,
                    struct error *error)
{
    struct sweep_block block = {.first = first, .count = count, .at = file->end};
    struct buffer lines = {0};
    buffer_put(&lines, rows);
    put_new_mark(&block, file->total, add_lines(0, rows), file->seed, &lines);
    block.bytes = (int64_t)lines.len;
    file->ragged = true;
    return put_lines(file, fd, &lines, error) && keep_block(file, block, error);
}

bool sweep_file_is_whole(const struct sweep_file *file, int64_t first, int64_t count)
{
    return file->segments == (first == 0) && !file->ragged && file->shards == 1 &&
           file->blocks == 1 && file->block[0].first == first && file->block[0].count == count &&
           file->size == file->end;
}

/* A cell of the whole, as it is written. */
struct whole_cell {
    struct writer *writer;
    const struct sweep_file *file;
    struct sweep_block block;
    uint64_t sum;
};

static bool end_cell(struct whole_cell *cell)
{
    struct buffer mark = {0};
    if (cell->block.count > 0)
        put_new_mark(&cell->block, cell->file->total, cell->sum, cell->file->seed, &mark);
    writer_put(cell->writer, buffer_text(&mark));
    const bool ok = !mark.failed;
    buffer_free(&mark);
    cell->block =
        (struct sweep_block){.first = cell->block.first + cell->block.count, .whole = true};
    cell->sum = 0;
    return ok;
}

static bool write_row(struct whole_cell *cell, struct text line)
{
    const int64_t point = strtoll(line.at, NULL, 10);
    int64_t next = cell->block.first + cell->block.count;
    if (point == next && point % sweep_cell(cell->file->total) == 0 && !end_cell(cell))
        return false;
    cell->block.count += point == next;
    cell->sum = add_sum(cell->sum, bytes_sum(line));
    writer_put(cell->writer, line);
    return point == next || point == next - 1;
}

bool sweep_file_make_whole(const struct sweep_file *file, int fd, struct text head,
                           struct text names, struct writer *writer, struct error *error)
{
    struct line_reader lines = {.fd = fd};
    struct text line;
    struct whole_cell cell = {
        .writer = writer, .file = file, .block = {.first = file->block[0].first, .whole = true}};
    bool ok = true;
    if (file->block[0].first == 0) {
        writer_put(writer, head);
        writer_put(writer, names);
    }
    for (size_t i = 0; i < file->blocks && ok; i++) {
        const int64_t end = file->block[i].at + file->block[i].bytes;
        lines.at = file->block[i].at;
        lines.used = lines.len = 0;
        for (size_t k = 0; lines.at < end && ok; k++) {
            ok = next_line(&lines, &line) == LINE_WHOLE && !cancelled_at(file->cancel, k);
            if (ok && line.at[0] != '#')
                ok = write_row(&cell, line);
        }
    }
    ok = ok && end_cell(&cell);
    free(lines.data);
    if (!ok && cancelled(file->cancel))
        return error_set(error, ERROR_CANCELLED, "stopped: all points are there, not yet in order");
    return ok || error_set(error, ERROR_IO, "what was written cannot be read again");
}
