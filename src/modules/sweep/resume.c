/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `sweep … --resume FILE`: computes a sweep in pieces, which are added to a file, so that it can be
 * continued after any stop. */
#define _GNU_SOURCE /* O_CLOEXEC */
#include <hooke/base/numeric.h>
#include <hooke/base/cancel.h>
#include <hooke/run/timing.h>
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include "modules/sweep/file.h"
#include "modules/sweep/handlers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <stdio.h>
#include <unistd.h>

#define PIECE_MOST 65536 /* largest number of points in a piece, unless a batch has more */
/* Bytes of results between two writes; as text, which is copied once, they take ten times as
 * much. */
#define PIECE_BYTES ((size_t)1 << 23)
#define PIECE_SECONDS 0.5 /* [s] least time of a piece; the largest is four times as long */

/* ---- the head, which says which sweep it is ---- */

/* Appends an axis as a statement has it, NAME=FROM:TO:STEP. */
static void put_axis(const struct sweep_axis *axis, struct buffer *text)
{
    const double steps = axis->count - 1;
    buffer_format(text, "%s=", axis->name);
    buffer_real(text, axis->begin);
    buffer_char(text, ':');
    buffer_real(text, axis->end);
    if (axis->count > 1 && !axis->log && axis->count < 100000) {
        buffer_format(text, ":%.12g", (axis->end - axis->begin) / steps); /* enough to count by */
    } else if (axis->count > 1) {
        buffer_put(text, axis->log ? TEXT(":x") : TEXT(":"));
        buffer_real(text, axis->log ? pow(axis->end / axis->begin, 1 / steps)
                                    : (axis->end - axis->begin) / steps);
    }
}

/* Appends the head of the request: version, set-up, sweep, and names of columns. Returns false if
 * out of memory. */
static bool put_head(const struct session *session, const struct sweep_request *request,
                     struct buffer *text)
{
    struct buffer setup = {0};
    session_save_motion(session, &setup);
    struct text rest = buffer_text(&setup), line;
    buffer_put(text, TEXT("# hooke = " HOOKE_VERSION "\n"));
    while (text_split(&rest, '\n', &line))
        if (line.len > 0)
            buffer_format(text, "# set-up = %.*s\n", (int)line.len, line.data);
    buffer_put(text, TEXT("# sweep = "));
    for (int a = 0; a < request->axes; a++) {
        put_axis(&request->axis[a], text);
        buffer_char(text, ' ');
    }
    const struct sweep_measure *shown = request->columns ? request->shown : request->measure;
    for (int m = 0; m < (request->columns ? request->columns : request->measures); m++)
        buffer_format(text, "%s%s", m ? "," : "measure=", sweep_measure_name(&shown[m]));
    if (request->section.wanted)
        buffer_format(text, " at %s skip=%lld keep=%lld", request->section.text,
                      (long long)request->section.skip, (long long)request->section.keep);
    buffer_char(text, '\n');
    text->failed |= setup.failed;
    buffer_free(&setup);
    struct sweep none;
    study_sweep_stretch(request, &none);
    none.count = 0;
    return sweep_rows(request, &none, text) && !text->failed;
}

/* Reads the sweep from the head of the file, as if it were typed, into the request. Returns false
 * with an error. */
static bool read_statement(struct session *session, const struct arguments *args,
                           const struct sweep_file *file, struct sweep_request *request,
                           struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct text rest = buffer_text(&file->head), line, found = {NULL, 0};
    const struct text key = TEXT("# sweep = ");
    while (text_split(&rest, '\n', &line))
        if (text_starts(line, key))
            found = text_after(line, key.len);
    const char *copy = found.data ? arena_text(args->arena, found) : NULL;
    struct sweep_options none = {0};
    struct error why = {0};
    safe_name(text_of(file->path), name);
    if (!copy) {
        error_set(error, ERROR_IO, "%s does not name the sweep that it belongs to", name);
        return error_hint(error,
                          file->blocks > 0
                              ? "it is a complete shard; only the first shard describes the sweep"
                              : "sweep NAME=FROM:TO --resume FILE begins one");
    }
    struct sweep_request read = sweep_request_begin(session);
    if (!read_sweep(session, args, text_of(copy), &read, &none, &why) || read.axes == 0)
        return error_set(error, ERROR_IO, "the sweep of %s cannot be read in this set-up: %s", name,
                         why.text);
    read.shard = request->shards > 1 ? request->shard : file->shard;
    read.shards = request->shards > 1 ? request->shards : file->shards;
    read.threads = request->threads;
    *request = read;
    return true;
}

/* ---- the file, locked ---- */

/* A file that is continued, and the sweep that belongs to it. */
struct growing_file {
    struct session *session;
    struct sweep_request *request;
    struct sweep_file file;
    int fd;                   /* -1 if not open */
    struct writer writer;     /* writes the complete file */
    struct buffer head, seal; /* those that the file must have */
    struct sweep all;         /* the points that the file must have; no results */
    /* numbers of points: computed now, missing at first, and in the present piece */
    int64_t computed, missing, piece;
};

/* Returns true if the file exists. */
static bool file_exists(const char *path)
{
    struct stat st;
    return lstat(path, &st) == 0;
}

/* Opens and locks the file; tries three times, as another program may replace it by the complete
 * file between opening and locking. Returns false with an error. */
static bool open_locked(struct growing_file *g, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    for (int look = 0; look < 3; look++) {
        struct stat opened, there;
        g->fd = append_open(g->file.path, session_policy(g->session, false), 0666, error);
        if (g->fd < 0)
            return false;
        const bool locked = file_lock(g->fd, true);
        if (locked && fstat(g->fd, &opened) == 0 && stat(g->file.path, &there) == 0 &&
            opened.st_ino == there.st_ino && opened.st_dev == there.st_dev)
            return true;
        close(g->fd);
        g->fd = -1;
        if (!locked)
            break;
    }
    return error_set(error, ERROR_IO, "%s is being written by another program",
                     safe_name(text_of(g->file.path), name));
}

/* Sets an error that shows the first line in which the file's head differs from the wanted one.
 * Returns false. */
static bool refuse_head(const struct growing_file *g, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct text has = buffer_text(&g->file.head), wants = buffer_text(&g->head), a, b;
    struct buffer one = {0}, other = {0};
    for (;;) {
        const bool more = text_split(&has, '\n', &a), wanted = text_split(&wants, '\n', &b);
        a = more ? a : TEXT("");
        b = wanted ? b : TEXT("");
        if (!text_equal(a, b) || !(more && wanted))
            break;
    }
    safe_text(&one, text_starts(a, TEXT("# ")) ? text_after(a, 2) : a, false);
    safe_text(&other, text_starts(b, TEXT("# ")) ? text_after(b, 2) : b, false);
    error_set(error, ERROR_IO, "%s belongs to another sweep: it has '%.200s', but this is '%.200s'",
              safe_name(text_of(g->file.path), name), buffer_view(&one), buffer_view(&other));
    buffer_free(&one);
    buffer_free(&other);
    return error_hint(
        error, "the file is unchanged; use another name, or the set-up that its # lines list");
}

/* Returns true if a file without points is the begin of the wanted head, as a killed program leaves
 * it; otherwise sets an error. */
static bool compare_begun(const struct growing_file *g, struct error *error)
{
    const struct text head = buffer_text(&g->head);
    const size_t size = g->file.size < (int64_t)head.len ? (size_t)g->file.size : head.len;
    char *begun = malloc(size + 1);
    if (!begun)
        return error_memory(error);
    const bool same =
        pread(g->fd, begun, size, 0) == (ssize_t)size && memcmp(begun, head.data, size) == 0;
    free(begun);
    return same || refuse_head(g, error);
}

/* Returns true if the file belongs to the sweep and shard of the request; otherwise sets an
 * error. */
static bool compare_sweep(const struct growing_file *g, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    const struct sweep_file *file = &g->file;
    const struct sweep_request *request = g->request;
    if (file->blocks == 0)
        return compare_begun(g, error);
    if (file->heads > 0 && !text_equal(buffer_text(&file->head), buffer_text(&g->head)))
        return refuse_head(g, error);
    safe_name(text_of(file->path), name);
    if (!text_equal(buffer_text(&file->seal), buffer_text(&g->seal))) {
        error_set(error, ERROR_IO,
                  "%s belongs to another sweep, or to this sweep with another set-up", name);
        return error_hint(error, "the file is unchanged");
    }
    return !file->unfinished ||
           (file->shard == request->shard && file->shards == request->shards) ||
           error_set(error, ERROR_IO, "%s is shard %lld/%lld of this sweep, not %lld/%lld", name,
                     (long long)file->shard, (long long)file->shards, (long long)request->shard,
                     (long long)request->shards);
}

/* Sorts the blocks. Returns false with an error if the file has a point twice, or one of another
 * shard. */
static bool arrange_points(struct growing_file *g, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct sweep_file *file = &g->file;
    const int64_t end = g->all.first + g->all.count;
    int64_t next = g->all.first;
    sweep_file_sort(file);
    for (size_t i = 0; i < file->blocks; i++) {
        const struct sweep_block *block = &file->block[i];
        const bool outside = block->first < g->all.first || block->first + block->count > end;
        if (outside || block->first < next) {
            error_set(error, ERROR_IO, "%s has point %lld %s", safe_name(text_of(file->path), name),
                      (long long)block->first,
                      outside ? "or later points that do not belong to this shard" : "twice");
            return error_hint(error, "the file is unchanged");
        }
        next = block->first + block->count;
    }
    return true;
}

/* Prepares the file for new points: removes an incomplete end, writes the head if the file is
 * empty, and marks it as unfinished. Returns false with an error. */
static bool begin_adding(struct growing_file *g, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct sweep_file *file = &g->file;
    struct buffer lines = {0};
    const bool fresh = file->blocks == 0;
    if (fresh)
        file->end = 0;
    if (file->size > file->end && ftruncate(g->fd, (off_t)file->end) != 0)
        return error_set(error, ERROR_IO, "cannot write %s", safe_name(text_of(file->path), name));
    if (fresh) {
        buffer_put(&lines, buffer_text(&g->head));
        buffer_put(&lines, buffer_text(&g->seal));
    }
    if (fresh || !file->unfinished)
        buffer_format(&lines, "# unfinished, shard %lld/%lld\n", (long long)g->request->shard,
                      (long long)g->request->shards);
    file->unfinished = true;
    file->total = g->all.total;
    const bool ok = !lines.failed ? sweep_file_put(file, g->fd, buffer_text(&lines), error)
                                  : error_memory(error);
    buffer_free(&lines);
    return ok;
}

/* ---- computing what is missing ---- */

/* Reports progress: points of finished pieces and the fraction of the present one. */
static void report_growth(void *context, double fraction)
{
    const struct growing_file *g = context;
    report_fraction(&g->session->front,
                    ((double)g->computed + fraction * (double)g->piece) / (double)g->missing);
}

/* Adds the finished points of a piece to the file; a stopped piece has some that are missing.
 * Returns false with an error. */
static bool add_finished(struct growing_file *g, const struct sweep *piece, struct error *error)
{
    for (int64_t block_begin = 0, block_end; block_begin < piece->count; block_begin = block_end) {
        for (block_end = block_begin;
             block_end < piece->count && piece->status[block_end] != SWEEP_MISSING;)
            block_end++;
        if (block_end == block_begin) {
            block_end++;
            continue;
        }
        struct sweep part = *piece;
        struct buffer rows = {0};
        part.first += block_begin;
        part.count = block_end - block_begin;
        part.value += block_begin * part.measures;
        part.status += block_begin;
        bool ok = sweep_rows(g->request, &part, &rows) || error_memory(error);
        /* End of the line of names. */
        const char *end = ok ? memchr(rows.data, '\n', rows.len) : NULL;
        if (end) {
            const struct text view = {end + 1, (size_t)(rows.data + rows.len - end - 1)};
            ok = sweep_file_add(&g->file, g->fd, part.first, part.count, view, error);
        }
        buffer_free(&rows);
        if (!ok)
            return false;
        g->computed += part.count;
    }
    return true;
}

/* Computes `count` points from `first` on and adds them to the file. Returns false with an error if
 * not all are finished. *seconds is the time it took. */
static bool compute_piece(struct growing_file *g, int64_t first, int64_t count, double *seconds,
                          struct error *error)
{
    struct sweep sweep;
    struct error why = {0};
    struct sweep_request request = *g->request;
    request.first = first;
    request.count = g->piece = count;
    request.progress = report_growth;
    request.context = g;
    study_sweep(&request, &sweep, &why);
    g->piece = 0;
    *seconds = sweep.seconds;
    /* a piece of which all points are refused is finished, too */
    const bool finished = sweep.finished == count;
    const bool ok = (sweep.finished == 0 || add_finished(g, &sweep, error)) && finished;
    if (!finished && error->code == ERROR_NONE)
        *error = why;
    sweep_free(&sweep);
    return ok;
}

/* Returns the number of points in a piece, which is smaller at a section, where a point has many
 * numbers. */
static int64_t most_points(const struct growing_file *g)
{
    const size_t each = (size_t)g->all.measures * sizeof(double);
    return each < PIECE_BYTES ? (int64_t)(PIECE_BYTES / each) : 1;
}

/* Computes missing points in pieces, whose size follows the time that they take. Returns false with
 * an error. */
static bool fill_gap(struct growing_file *g, int64_t first, int64_t count, struct error *error)
{
    const int64_t room = most_points(g), end = first + count,
                  batch = int64_min(study_sweep_batch(g->request), room),
                  usual = batch > PIECE_MOST ? batch : PIECE_MOST, most = int64_min(usual, room);
    int64_t size = batch;
    double seconds = 0;
    for (int64_t point = first, n; point < end; point += n) {
        n = size - point % batch; /* so that the next ones begin where a batch does */
        n = n < end - point ? n : end - point;
        if (!compute_piece(g, point, n, &seconds, error))
            return false;
        if (seconds < PIECE_SECONDS && 2 * size <= most)
            size *= 2;
        else if (seconds > 4 * PIECE_SECONDS && size >= 2 * batch)
            size /= 2;
    }
    return true;
}

/* Computes all points that the file lacks, unless that takes too long without `force`. Returns
 * false with an error. */
static bool growing_file_fill(struct growing_file *g, bool force, struct error *error)
{
    double steps, seconds;
    const size_t blocks = g->file.blocks; /* those that are added go behind them */
    int64_t next = g->all.first;
    g->missing = g->all.count;
    for (size_t i = 0; i < blocks; i++)
        g->missing -= g->file.block[i].count;
    g->session->studies.points = (double)g->missing;
    study_sweep_predict(g->request, &steps, &seconds);
    const double share = (double)g->missing / (double)g->all.count;
    if (!allow_long(g->session, share * seconds, share * steps, force, error))
        return false;
    for (size_t i = 0; i <= blocks; i++) {
        const struct sweep_block block =
            i < blocks ? g->file.block[i]
                       : (struct sweep_block){.first = g->all.first + g->all.count};
        if (!fill_gap(g, next, block.first - next, error))
            return false;
        next = block.first + block.count;
    }
    return arrange_points(g, error);
}

/* ---- all of it ---- */

/* Opens and reads the file, and checks that it belongs to the sweep. Returns false with an
 * error. */
static bool prepare_resume(struct growing_file *g, const struct arguments *args,
                           struct error *error)
{
    struct sweep_request *request = g->request;
    if (!open_locked(g, error) || !sweep_file_read(g->fd, &g->file, error) ||
        (request->axes == 0 && !read_statement(g->session, args, &g->file, request, error)))
        return false;
    study_sweep_stretch(request, &g->all);
    if (g->all.count == 0)
        return error_set(error, ERROR_COMMAND,
                         "this shard has no points because there are more shards than points");
    if (!put_head(g->session, request, &g->head))
        return error_memory(error);
    sweep_seal(buffer_text(&g->head), g->all.total,
               request->section.wanted ? request->section.keep : 1, &g->seal);
    return (!g->seal.failed || error_memory(error)) && compare_sweep(g, error) &&
           arrange_points(g, error);
}

/* Computes the missing points and completes the file. A complete file is unchanged. Returns false
 * with `error` filled. */
static bool growing_file_complete(struct growing_file *g, bool force, struct error *error)
{
    if (sweep_file_is_whole(&g->file, g->all.first, g->all.count))
        return true;
    return writer_open(&g->writer, g->file.path, session_policy(g->session, true), error) &&
           begin_adding(g, error) && growing_file_fill(g, force, error) &&
           sweep_file_make_whole(&g->file, g->fd, buffer_text(&g->head), buffer_text(&g->seal),
                                 &g->writer, error) &&
           writer_commit(&g->writer, error);
}

/* Replies with what the complete file has and how many points were computed now. */
static void reply_file(const struct growing_file *g, double seconds, struct reply *reply)
{
    const struct sweep *all = &g->all;
    char name[SAFE_NAME_SIZE];
    safe_name(text_of(g->file.path), name);
    reply_begin(reply, "sweep-file");
    reply_string(reply, "file", name);
    reply_int(reply, "first", all->first);
    reply_int(reply, "points", all->count);
    reply_int(reply, "total", all->total);
    reply_int(reply, "computed", g->computed);
    const bool timed = g->session->setup.settings.timing != TIMING_OFF;
    char took[32] = "";
    if (timed)
        snprintf(took, sizeof took, " in %.3g s", seconds);
    reply_real(reply, "seconds", timed ? seconds : NAN);
    reply_line(reply,
               "%s is complete: points %lld to %lld of %lld; this command computed %lld of them%s",
               name, (long long)all->first, (long long)(all->first + all->count - 1),
               (long long)all->total, (long long)g->computed, took);
    reply_end(reply);
}

/* Sets the error of a stopped sweep, with how many points the file has. */
static void set_stopped_error(const struct growing_file *g, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    int64_t has = 0;
    for (size_t i = 0; i < g->file.blocks; i++)
        has += g->file.block[i].count;
    error_set(error, ERROR_CANCELLED, "stopped: %s has %lld of %lld points",
              safe_name(text_of(g->file.path), name), (long long)has, (long long)g->all.count);
    error_hint(error, "'continue' or the same command continues it");
}

/* Computes the points that the file does not have yet and completes the file. */
bool sweep_into_file(struct session *session, const struct arguments *args,
                     struct sweep_request *request, const struct sweep_options *options,
                     struct reply *reply, struct error *error)
{
    const int64_t begin = clock_ns();
    struct growing_file g = {.session = session,
                             .request = request,
                             .fd = -1,
                             .writer = {.fd = -1, .folder = -1},
                             .file.cancel = session->front.cancel};
    *error = (struct error){.code = ERROR_NONE};
    g.file.path = arena_text(args->arena, options->file);
    if (!g.file.path)
        return error_memory(error);
    char name[SAFE_NAME_SIZE];
    bool ok = request->axes > 0 || file_exists(g.file.path) ||
              (error_set(error, ERROR_IO, "%s does not exist", safe_name(options->file, name)) ||
               error_hint(error, "sweep NAME=FROM:TO --resume FILE begins it"));
    ok = ok && prepare_resume(&g, args, error) && growing_file_complete(&g, options->force, error);
    report_fraction(&session->front, 2);
    if (ok)
        reply_file(&g, clock_seconds(begin), reply);
    else if (error->code == ERROR_CANCELLED && g.computed > 0)
        set_stopped_error(&g, error);
    if (!ok && !error->where.data)
        error->where = options->file;
    writer_abandon(&g.writer);
    if (g.fd >= 0)
        close(g.fd);
    sweep_file_free(&g.file);
    buffer_free(&g.head);
    buffer_free(&g.seal);
    return ok;
}
