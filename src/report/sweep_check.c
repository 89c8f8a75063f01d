/* SPDX-License-Identifier: GPL-3.0-or-later */
/* hooke --check-sweep FILE...: shards of a sweep, put together or not, are all there. */
#define _GNU_SOURCE /* O_CLOEXEC */
#include <hooke/report/sweep.h>

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define DIFFERENCES_SHOWN 20

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

/* ---- files together ---- */

struct checking {
    const char *const *path;
    struct sweep_file all; /* sweep of the first, blocks of all */
    struct reply *reply;
    int64_t points, missing, differences;
};

static bool read_one(struct checking *check, int index, struct sweep_file *file,
                     struct error *error)
{
    const char *path = check->path[index];
    char name[SAFE_NAME_SIZE];
    struct stat st;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    file->path = path;
    file->cancel = check->all.cancel;
    if (fd < 0 || fstat(fd, &st) != 0 || !S_ISREG(st.st_mode)) {
        error_set(error, ERROR_IO, "cannot read %s: %s", safe_name(text_of(path), name),
                  fd < 0 ? system_message(errno) : "it is no file");
        if (fd >= 0)
            close(fd);
        return false;
    }
    bool ok = sweep_file_read(fd, file, error);
    close(fd);
    if (ok && file->blocks == 0)
        ok = error_set(error, ERROR_IO, "%s has no points of a sweep",
                       safe_name(text_of(path), name));
    if (ok && check->all.total > 0 &&
        (file->total != check->all.total || file->seed != check->all.seed))
        ok = error_set(error, ERROR_IO, "%s is of another sweep than the first file",
                       safe_name(text_of(path), name));
    return ok;
}

static void differs(struct checking *check, int64_t first, int64_t count, const char *what)
{
    if (check->differences++ >= DIFFERENCES_SHOWN)
        return;
    struct buffer text = {0};
    if (count == 1)
        buffer_format(&text, "point %lld is %s", (long long)first, what);
    else
        buffer_format(&text, "points %lld to %lld are %s", (long long)first,
                      (long long)(first + count - 1), what);
    reply_line(check->reply, "%s", buffer_view(&text));
    reply_string(check->reply, NULL, buffer_view(&text));
    buffer_free(&text);
}

static bool take_blocks(struct checking *check, int index, struct sweep_file *file)
{
    struct sweep_file *all = &check->all;
    if (all->total == 0) {
        all->total = file->total;
        all->seed = file->seed;
    }
    struct sweep_block *more =
        realloc(all->block, (all->blocks + file->blocks + 1) * sizeof *all->block);
    if (!more)
        return false;
    all->block = more;
    for (size_t i = 0; i < file->blocks; i++) {
        all->block[all->blocks] = file->block[i];
        all->block[all->blocks++].file = index;
    }
    return true;
}

/* Each point once. */
static void compare_blocks(struct checking *check)
{
    const struct sweep_file *all = &check->all;
    int64_t next = 0;
    if (all->blocks > 0)
        qsort(all->block, all->blocks, sizeof *all->block, by_first);
    for (size_t i = 0; i < all->blocks; i++) {
        const struct sweep_block *block = &all->block[i];
        const int64_t end = block->first + block->count;
        check->points += block->count;
        if (block->first < next) {
            differs(check, block->first, (end < next ? end : next) - block->first,
                    "there more than once");
        } else if (block->first > next) {
            differs(check, next, block->first - next, "missing");
            check->missing += block->first - next;
        }
        next = end > next ? end : next;
    }
    if (next < all->total) {
        differs(check, next, all->total - next, "missing");
        check->missing += all->total - next;
    }
    if (check->differences > DIFFERENCES_SHOWN)
        reply_line(check->reply, "and %lld more",
                   (long long)check->differences - DIFFERENCES_SHOWN);
}

int sweep_check(const char *const *path, int count, const struct cancel *cancel,
                struct reply *reply)
{
    struct checking check = {.path = path, .all.cancel = cancel, .reply = reply};
    struct error error = {0};
    bool ok = true;
    for (int i = 0; i < count && ok; i++) {
        struct sweep_file file = {0};
        ok = read_one(&check, i, &file, &error) &&
             (take_blocks(&check, i, &file) || error_memory(&error));
        sweep_file_free(&file);
    }
    if (!ok) {
        reply_error(reply, &error, NULL, (struct text){NULL, 0});
    } else {
        reply_begin(reply, "check-sweep");
        reply_array(reply, "differences");
        compare_blocks(&check);
        reply_close(reply);
        reply_bool(reply, "whole", check.differences == 0);
        reply_int(reply, "files", count);
        reply_int(reply, "points", check.points);
        reply_int(reply, "total", check.all.total);
        reply_int(reply, "missing", check.missing);
        reply_line(reply, "%d file%s, %lld points of %lld: %s", count, count == 1 ? "" : "s",
                   (long long)check.points, (long long)check.all.total,
                   check.differences ? "not whole" : "whole, each there once, sums right");
        reply_end(reply);
    }
    sweep_file_free(&check.all);
    return !ok ? (int)error.code : check.differences ? ERROR_COMMAND : 0;
}
