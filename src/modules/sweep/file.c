/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Files of sweeps that grow: reading, adding points, completing, and checking shards. */
#define _GNU_SOURCE /* O_CLOEXEC, getline */
#include "modules/sweep/file.h"
#include <hooke/base/file.h>
#include <hooke/base/cancel.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/fields.h>
#include "modules/sweep/compute/sweep.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- line by line, in memory that does not grow with the file ---- */

/* Reads a file line by line from its own position. */
struct line_reader {
    FILE *stream;
    char *data;
    size_t capacity;
    int64_t offset, number; /* end of the line [byte], and its number from 1 */
};

/* Begins to read at an offset [byte]; fd remains open. Returns false if that fails; lines_end()
 * must be called in any case. */
static bool lines_begin(struct line_reader *reader, int fd, int64_t offset)
{
    const int copy = dup(fd);
    *reader = (struct line_reader){.offset = offset, .stream = copy < 0 ? NULL : fdopen(copy, "r")};
    if (!reader->stream && copy >= 0)
        close(copy);
    return reader->stream && fseeko(reader->stream, (off_t)offset, SEEK_SET) == 0;
}

/* Reads the next line with its newline, which the last one may lack. Returns false at the end of
 * the file, or if it cannot be read. */
static bool next_line(struct line_reader *reader, struct text *line)
{
    const ssize_t len = getline(&reader->data, &reader->capacity, reader->stream);
    *line = (struct text){reader->data, len > 0 ? (size_t)len : 0};
    reader->offset += (int64_t)line->len;
    reader->number++;
    return len > 0;
}

static void lines_end(struct line_reader *reader)
{
    if (reader->stream)
        fclose(reader->stream);
    free(reader->data);
}

/* ---- reading ---- */

/* State of reading a file. */
struct sweep_scan {
    struct sweep_file *file;
    struct line_reader lines;
    struct buffer head; /* lines of the present head */
    size_t begun;       /* number of blocks that belong to files read before */
    /* Offset of the last point [byte], the number of its rows, and the largest number of rows of a
     * point. */
    int64_t point_at, rows, rows_seen;
    bool sealed; /* the last line was a seal */
    struct error *error;
};

/* Sets the error for the present line and returns false. */
static bool refuse_line(const struct sweep_scan *scan, const char *what)
{
    char name[SAFE_NAME_SIZE];
    error_set(scan->error, ERROR_IO, "%s, line %lld: %s",
              safe_name(text_of(scan->file->path), name), (long long)scan->lines.number, what);
    return error_hint(scan->error, "the file is unchanged");
}

/* Returns a checksum of the lines of a head, which identifies the sweep. */
static uint64_t head_sum(struct text head)
{
    uint64_t sum = 0;
    struct text line;
    while (text_split(&head, '\n', &line) && line.len > 0)
        sum = (sum ^ bytes_sum(line)) * 0x100000001b3u;
    return sum;
}

#define SEAL_FORMAT "# sweep %016" PRIx64 ": %lld points in all, at most %lld row%s each\n"

void sweep_seal(struct text head, int64_t total, int64_t rows_max, struct buffer *seal)
{
    buffer_format(seal, SEAL_FORMAT, head_sum(head), (long long)total, (long long)rows_max,
                  rows_max == 1 ? "" : "s");
}

/* Reads a seal line, which ends a complete part of the file with the checksum of the head. `sum` is
 * the checksum in the line. Stores the first seal; returns false with an error if the line differs
 * from earlier seals or does not belong to the head. */
static bool take_seal(struct sweep_scan *scan, struct text line, uint64_t sum)
{
    struct sweep_file *file = scan->file;
    const bool other = (file->seal.len > 0 && !text_equal(buffer_text(&file->seal), line)) ||
                       (file->heads > 0 && head_sum(buffer_text(&file->head)) != sum);
    if (other)
        return refuse_line(scan, "this belongs to another sweep than the lines before");
    if (file->seal.len == 0)
        buffer_put(&file->seal, line);
    if (scan->rows_seen > file->rows_max)
        return refuse_line(scan, "a point above appears twice");
    file->seals++;
    scan->sealed = true;
    return !file->seal.failed || error_memory(scan->error);
}

/* Adds a line to scan->head, which is complete with the line that names the columns: the first head
 * then becomes that of the file, later ones must be equal to it. Returns false with an error if one
 * differs. */
static bool take_head(struct sweep_scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    buffer_put(&scan->head, line);
    if (scan->head.failed)
        return error_memory(scan->error);
    if (line.data[0] == '#')
        return true;
    if (file->heads++ == 0) {
        file->head = scan->head;
        scan->head = (struct buffer){0};
    } else if (!text_equal(buffer_text(&file->head), buffer_text(&scan->head))) {
        return refuse_line(scan, "this belongs to another sweep than the lines before");
    }
    buffer_clear(&scan->head);
    return true;
}

/* Appends a block. Returns false with an error if out of memory. */
static bool add_block(struct sweep_file *file, struct sweep_block block, struct error *error)
{
    if (file->blocks == file->capacity) {
        const size_t capacity = 2 * file->capacity + 16;
        struct sweep_block *more = realloc(file->block, capacity * sizeof *more);
        if (!more)
            return error_memory(error);
        file->block = more;
        file->capacity = capacity;
    }
    file->block[file->blocks++] = block;
    return true;
}

/* Reads a row, which begins with the number of its point. A point may have several rows. Extends
 * the last block if the point is the same or the next one, else begins another block. Returns false
 * with an error if the line is no row. */
static bool take_row(struct sweep_scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    struct sweep_block *last = file->blocks > scan->begun ? &file->block[file->blocks - 1] : NULL;
    char *end;
    errno = 0;
    const int64_t point = strtoll(line.data, &end, 10),
                  offset = scan->lines.offset - (int64_t)line.len;
    if (!(line.data[0] >= '0' && line.data[0] <= '9') || *end != ',' || errno != 0)
        return refuse_line(scan, "this is not a row of a sweep");
    scan->sealed = false;
    const int64_t next = last ? last->first + last->count : -1;
    const bool same = last && point == next - 1 && offset == last->end;
    if (!same)
        scan->point_at = offset;
    scan->rows = same ? scan->rows + 1 : 1;
    scan->rows_seen = scan->rows > scan->rows_seen ? scan->rows : scan->rows_seen;
    if (!last || (!same && point != next))
        return add_block(file, (struct sweep_block){point, 1, offset, scan->lines.offset},
                         scan->error);
    last->count += point == next;
    last->end = scan->lines.offset;
    return true;
}

/* Reads one line of a sweep's file into scan->file, by its kind: the line of an unfinished file,
 * which tells its shard; the seal behind the rows of a sweep, with a checksum of its head, the
 * number of points in all and the largest number of rows of a point; a line of the head, the last
 * of which names the columns ("point,..."); or else a row of values. Returns false with an error if
 * the line belongs to another sweep or is none of these. */
static bool take_line(struct sweep_scan *scan, struct text line)
{
    struct sweep_file *file = scan->file;
    const bool comment = line.data[0] == '#';
    uint64_t sum;
    long long a, b;
    if (file->unfinished && (comment || text_starts(line, TEXT("point,"))))
        return refuse_line(scan, "the part before was incomplete when it was added");
    if (comment && sscanf(line.data, "# unfinished, shard %lld/%lld", &a, &b) == 2) {
        file->unfinished = true;
        file->shard = a;
        file->shards = b;
        return true;
    }
    if (comment && sscanf(line.data, "# sweep %" SCNx64 ": %lld points in all, at most %lld", &sum,
                          &a, &b) == 3) {
        file->total = a;
        file->rows_max = b;
        return take_seal(scan, line, sum);
    }
    if (text_starts(line, TEXT("# ")) || text_starts(line, TEXT("point,")))
        return take_head(scan, line);
    return take_row(scan, line);
}

/* Leaves out the last point if rows of it may be missing. */
static void drop_incomplete_point(struct sweep_scan *scan)
{
    struct sweep_file *file = scan->file;
    struct sweep_block *last = file->blocks > scan->begun ? &file->block[file->blocks - 1] : NULL;
    if (!last || scan->sealed || (file->rows_max > 0 && scan->rows >= file->rows_max))
        return;
    file->end = last->end = scan->point_at;
    file->blocks -= --last->count == 0;
}

/* Reads a file and adds its blocks of points to *file. Ignores a torn last line and a last point of
 * which rows may be missing, as left by a killed program. Returns false with an error, also if
 * cancelled. */
bool sweep_file_read(int fd, struct sweep_file *file, struct error *error)
{
    struct sweep_scan scan = {.file = file, .error = error, .begun = file->blocks};
    struct text line = {0};
    bool ok = lines_begin(&scan.lines, fd, 0) || error_memory(error), torn = false;
    file->shard = file->shards = 1;
    file->unfinished = false;
    while (ok && !torn && next_line(&scan.lines, &line)) {
        /* a line without its end was being written when a program was killed */
        torn = line.data[line.len - 1] != '\n' && strchr("#p0123456789", line.data[0]);
        if (!torn) {
            ok = take_line(&scan, line);
            file->end = scan.lines.offset;
        }
        if (ok && cancelled_at(file->cancel, (size_t)scan.lines.number))
            ok = error_set(error, ERROR_CANCELLED, "stopped; nothing was changed");
    }
    if (ok && !torn && !feof(scan.lines.stream))
        ok = refuse_line(&scan, "it cannot be read beyond this line");
    if (ok && file->blocks > scan.begun && file->rows_max > 0 && scan.rows_seen > file->rows_max)
        ok = refuse_line(&scan, "a point above appears twice");
    file->size = scan.lines.offset;
    if (ok)
        drop_incomplete_point(&scan);
    lines_end(&scan.lines);
    buffer_free(&scan.head);
    return ok;
}

/* Frees what the structure owns, not the structure. */
void sweep_file_free(struct sweep_file *file)
{
    buffer_free(&file->head);
    buffer_free(&file->seal);
    free(file->block);
    file->block = NULL;
}

/* Orders blocks for qsort() by their first point. */
static int by_first(const void *a, const void *b)
{
    const struct sweep_block *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

void sweep_file_sort(struct sweep_file *file)
{
    if (file->blocks > 0)
        qsort(file->block, file->blocks, sizeof *file->block, by_first);
}

/* ---- writing ---- */

/* Appends lines to the file and moves its end. */
bool sweep_file_put(struct sweep_file *file, int fd, struct text lines, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct error why = {0};
    if (!append_lines(fd, lines, true, &why)) {
        error_set(error, ERROR_IO, "cannot write %s: %s", safe_name(text_of(file->path), name),
                  why.text);
        return error_hint(error, "its points are kept; the same command continues with it");
    }
    file->end = file->size = file->end + (int64_t)lines.len;
    return true;
}

bool sweep_file_add(struct sweep_file *file, int fd, int64_t first, int64_t count, struct text rows,
                    struct error *error)
{
    const int64_t offset = file->end;
    return sweep_file_put(file, fd, rows, error) &&
           add_block(file, (struct sweep_block){first, count, offset, file->end}, error);
}

/* Returns true if the point is the last one of a cell. */
static bool ends_cell(const struct sweep_file *file, int64_t point)
{
    return (point + 1) % sweep_cell(file->total) == 0 || point + 1 == file->total;
}

/* Returns true if the file has exactly these points in order, with heads and seals. */
bool sweep_file_is_whole(const struct sweep_file *file, int64_t first, int64_t count)
{
    if (file->total == 0)
        return false;
    const int64_t cell = sweep_cell(file->total);
    return !file->unfinished && file->blocks == 1 && file->block[0].first == first &&
           file->block[0].count == count && file->heads == (first == 0) &&
           file->seals == (count + cell - 1) / cell && file->size == file->end;
}

/* Copies all points of the file in the order of its sorted blocks to the writer: the head if the
 * first point is among them, rows, and a seal after each cell of points and at the end. Returns
 * false with an error if the data cannot be read again, or if cancelled. */
bool sweep_file_make_whole(const struct sweep_file *file, int fd, struct text head,
                           struct text seal, struct writer *writer, struct error *error)
{
    struct line_reader lines = {0};
    struct text line;
    int64_t last = -1;
    bool ok = true;
    if (file->block[0].first == 0)
        writer_put(writer, head);
    for (size_t i = 0; i < file->blocks && ok; i++) {
        ok = lines_begin(&lines, fd, file->block[i].begin);
        for (size_t k = 0; ok && lines.offset < file->block[i].end; k++) {
            ok = next_line(&lines, &line) && !cancelled_at(file->cancel, k);
            if (!ok || line.data[0] < '0' || line.data[0] > '9')
                continue;
            const int64_t point = strtoll(line.data, NULL, 10);
            if (last >= 0 && point != last && ends_cell(file, last))
                writer_put(writer, seal);
            writer_put(writer, line);
            last = point;
        }
        lines_end(&lines);
    }
    writer_put(writer, seal);
    if (!ok && cancelled(file->cancel))
        return error_set(error, ERROR_CANCELLED,
                         "stopped: all points are computed, but not yet sorted");
    return ok || error_set(error, ERROR_IO, "the written data cannot be read again");
}

/* ---- checking files together ---- */

/* Adds a file to `all`. Returns false with an error if it cannot be read or has no points. */
static bool read_one(const char *path, struct sweep_file *all, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct stat st;
    const size_t blocks = all->blocks;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    all->path = path;
    safe_name(text_of(path), name);
    if (fd < 0)
        return error_set(error, ERROR_IO, "cannot read %s: %s", name, system_message(errno));
    bool ok = (fstat(fd, &st) == 0 && S_ISREG(st.st_mode)) ||
              error_set(error, ERROR_IO, "cannot read %s: it is not a regular file", name);
    ok = ok && sweep_file_read(fd, all, error) &&
         ((all->blocks > blocks && all->total > 0) ||
          error_set(error, ERROR_IO, "%s has no points of a sweep", name));
    close(fd);
    return ok;
}

enum { DIFFERENCES_SHOWN = 20 }; /* number of differences that are listed */

/* Output of a check, and how many differences were found. */
struct differences {
    struct reply *reply;
    int64_t count;
};

/* Reports that points first to end - 1 are `what` (missing, ...). Does nothing if there are none;
 * only counts after DIFFERENCES_SHOWN reports. */
static void put_difference(struct differences *differences, int64_t first, int64_t end,
                           const char *what)
{
    char line[128];
    if (end <= first || differences->count++ >= DIFFERENCES_SHOWN)
        return;
    if (end == first + 1)
        snprintf(line, sizeof line, "point %lld is %s", (long long)first, what);
    else
        snprintf(line, sizeof line, "points %lld to %lld are %s", (long long)first,
                 (long long)end - 1, what);
    reply_line(differences->reply, "%s", line);
    reply_string(differences->reply, NULL, line);
}

/* Replies with the missing and repeated points of all files together. Returns true if each point of
 * the sweep is present exactly once. */
static bool reply_check(struct sweep_file *all, int files, struct reply *reply)
{
    struct differences differences = {.reply = reply};
    int64_t next = 0, points = 0, missing = 0;
    sweep_file_sort(all);
    reply_begin(reply, "check-sweep");
    reply_array(reply, "differences");
    for (size_t i = 0; i <= all->blocks; i++) {
        const struct sweep_block block =
            i < all->blocks ? all->block[i] : (struct sweep_block){.first = all->total};
        const int64_t end = block.first + block.count;
        put_difference(&differences, next, block.first, "missing");
        put_difference(&differences, block.first, end < next ? end : next,
                       "present more than once");
        points += block.count;
        missing += block.first > next ? block.first - next : 0;
        next = end > next ? end : next;
    }
    put_difference(&differences, all->total, next, "not points of this sweep");
    if (differences.count > DIFFERENCES_SHOWN)
        reply_line(reply, "and %lld more", (long long)differences.count - DIFFERENCES_SHOWN);
    reply_close(reply);
    reply_bool(reply, "whole", differences.count == 0);
    reply_int(reply, "files", files);
    reply_int(reply, "points", points);
    reply_int(reply, "total", all->total);
    reply_int(reply, "missing", missing);
    const char *verdict = differences.count ? "incomplete" : "complete, each point once";
    reply_line(reply, "%d file%s, %lld points of %lld: %s", files, files == 1 ? "" : "s",
               (long long)points, (long long)all->total, verdict);
    reply_end(reply);
    return differences.count == 0;
}

/* Checks that `count` files together have each point of their sweep once (`hooke --check-sweep`),
 * and replies. Returns the exit status, 0 if they have. */
int sweep_check(struct session *session, const char *const *path, int count, struct reply *reply)
{
    struct sweep_file all = {.cancel = session->front.cancel};
    struct error error = {0};
    bool ok = true;
    int status = 0;
    reply_command_begin(reply, (enum output_format)session->setup.settings.format);
    for (int i = 0; i < count && ok; i++)
        ok = read_one(path[i], &all, &error);
    if (ok) {
        status = reply_check(&all, count, reply) ? 0 : ERROR_COMMAND;
    } else {
        reply_error(reply, &error, NULL, (struct text){NULL, 0});
        status = (int)error.code;
    }
    sweep_file_free(&all);
    reply_command_end(reply, "check-sweep");
    return status;
}
