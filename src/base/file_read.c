/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/base/safe_text.h>
#include "base/internal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define READ_CHUNK_BYTES 16384u
#define PATIENCE_NS 200000000 /* [ns] that a named pipe waits for a writer … */
#define PATIENCE_LOOKS 20     /* … in so many looks */
/* bytes within a watch's patience: a file is faster than this, a sensor never */
#define SLOW_BYTES 65536

struct file_reading {
    const char *path;
    /* `old_len` is the number of bytes of content that are not the file's */
    size_t limit, old_len;
    uintmax_t size; /* stated; 0 if there is none */
    struct read_watch *watch;
    int64_t
        deadline; /* [clock_ns] what may have no end has to have ended by then; 0 if it need not */
};

/* Suggests files of the same folder whose names are like the one that does not exist. */
static void suggest_files(const char *path, struct error *error)
{
    enum { ENTRIES_MAX = 4096, FOLDER_MAX = 4096 };
    const char *slash = strrchr(path, '/');
    const size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    char folder[FOLDER_MAX] = ".", name[SAFE_NAME_SIZE];
    struct suggestion suggestion = {.wanted = text_of(path + length)};
    if (length >= sizeof folder)
        return;
    const size_t copied = length > 0 ? length : 1;
    memcpy(folder, length > 0 ? path : ".", copied);
    DIR *listed = opendir(folder);
    const struct dirent *entry;
    for (int i = 0; listed && i < ENTRIES_MAX && (entry = readdir(listed)); i++)
        if (entry->d_name[0] != '.' &&
            strcmp(safe_name(text_of(entry->d_name), name), entry->d_name) == 0)
            suggestion_offer(&suggestion, entry->d_name);
    if (listed)
        closedir(listed);
    suggestion_hint(&suggestion, error);
}

static bool cannot_read(struct error *error, const char *path, int number)
{
    char name[SAFE_NAME_SIZE];
    if (number == EINTR)
        return error_set(error, ERROR_CANCELLED, "reading %s was interrupted",
                         safe_name(text_of(path), name));
    const char *reason;
    if (number != EISDIR)
        reason = system_message(number);
    else
        reason = strcmp(path, STANDARD_INPUT) == 0 ? "standard input is closed, or is a directory"
                                                   : "it is a directory";
    error_set(error, ERROR_IO, "cannot read %s: %s", safe_name(text_of(path), name), reason);
    if (number == ENOENT)
        suggest_files(path, error);
    return false;
}

/*
 * A named pipe that nobody writes to has no end: its writer gets a moment to come, a reader that
 * waits for ever none. EINTR is not retried: it is how Ctrl-C gets out of a pipe into which nothing
 * is written.
 */
static bool await_writer(int fd, const char *path, struct buffer *content, struct error *error)
{
    char name[SAFE_NAME_SIZE], first;
    const struct timespec moment = {.tv_nsec = PATIENCE_NS / PATIENCE_LOOKS};
    for (int look = 0; look < PATIENCE_LOOKS; look++) {
        const ssize_t got = read(fd, &first, 1);
        if (got == 1) {
            buffer_put(content, (struct text){&first, 1});
            return !content->failed || error_memory(error);
        }
        if (got < 0 && errno == EAGAIN) /* there is one, who has written nothing yet */
            return true;
        if (got < 0 || nanosleep(&moment, NULL) != 0)
            return cannot_read(error, path, errno);
    }
    return error_set(error, ERROR_IO, "cannot read %s: it is a pipe and no program writes to it",
                     safe_name(text_of(path), name));
}

static bool refuse_endless(const char *path, const char *why, struct read_watch *watch,
                           struct error *error)
{
    char name[SAFE_NAME_SIZE];
    if (watch)
        watch->endless = true;
    return error_set(error, ERROR_IO, "cannot read %s to its end: %s",
                     safe_name(text_of(path), name), why);
}

static bool is_socket(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISSOCK(st.st_mode);
}

/* Returns true if the system makes the contents up while they are read, perhaps for ever:
 * /proc/kmsg. */
static bool made_up(const struct stat *st, const struct read_watch *watch)
{
    return watch && watch->patience > 0 && S_ISREG(st->st_mode) && st->st_size == 0;
}

static bool open_file(const char *path, int *fd, struct stat *st, struct read_watch *watch,
                      struct buffer *content, struct error *error)
{
    const bool input = strcmp(path, STANDARD_INPUT) == 0;
    if (input)
        *fd = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
    else
        *fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (*fd < 0 && errno == ENXIO && watch && watch->patience > 0 && is_socket(path))
        return refuse_endless(path, "it is a socket", watch, error);
    if (*fd < 0 || fstat(*fd, st) != 0)
        return cannot_read(error, path, errno);
    if (watch && watch->patience > 0 && isatty(*fd))
        return refuse_endless(path, "it is a terminal or a serial line, which has no end", watch,
                              error);
    if (S_ISDIR(st->st_mode))
        return cannot_read(error, path, EISDIR);
    if (S_ISFIFO(st->st_mode) && !input && !await_writer(*fd, path, content, error))
        return false;
    if (made_up(st, watch)) /* it may say that there is more, and wait for it */
        return true;
    const int flags = fcntl(*fd, F_GETFL);
    return (flags >= 0 && fcntl(*fd, F_SETFL, flags & ~O_NONBLOCK) >= 0) ||
           cannot_read(error, path, errno);
}

static bool too_long(const char *path, size_t limit, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    return error_set(error, ERROR_IO, "%s is longer than %zu bytes; at most %zu can be read",
                     safe_name(text_of(path), name), limit, limit);
}

/* Returns false if it is neither at its end nor as fast as a file. */
static bool await_more(int fd, const struct file_reading *r, size_t so_far, struct error *error)
{
    if (r->deadline == 0)
        return true;
    struct pollfd ready = {.fd = fd, .events = POLLIN};
    const int64_t left = r->deadline - clock_ns();
    if (left <= 0 && so_far >= SLOW_BYTES)
        return true;
    const int count = left > 0 ? poll(&ready, 1, (int)(left / 1000000) + 1) : 0;
    if (count < 0)
        return cannot_read(error, r->path, errno);
    return count > 0 || refuse_endless(r->path, "data keep arriving", r->watch, error);
}

/* Reads a file that states its size only up to that size: somebody may be writing it faster than it
 * is read. */
static bool read_pieces(int fd, const struct file_reading *r, struct buffer *content,
                        struct error *error)
{
    char piece[READ_CHUNK_BYTES];
    for (bool first = true;; first = false) {
        const size_t so_far = content->len - r->old_len;
        const uintmax_t left = r->size > 0 ? r->size - so_far : READ_CHUNK_BYTES;
        if (!await_more(fd, r, so_far, error))
            return false;
        const ssize_t got =
            read(fd, piece, left < READ_CHUNK_BYTES ? (size_t)left : READ_CHUNK_BYTES);
        if (got < 0 && errno == EAGAIN && r->deadline > 0 && clock_ns() < r->deadline) {
            const struct timespec moment = {.tv_nsec = PATIENCE_NS / PATIENCE_LOOKS};
            if (nanosleep(&moment, NULL) != 0)
                return cannot_read(error, r->path, errno);
            continue;
        }
        if (got < 0 && errno == EAGAIN)
            return refuse_endless(r->path, "data keep arriving", r->watch, error);
        if (got < 0)
            return cannot_read(error, r->path, errno);
        if (got == 0)
            return true;
        if ((size_t)got > r->limit - so_far)
            return too_long(r->path, r->limit, error);
        buffer_put(content, (struct text){piece, (size_t)got});
        if (content->failed)
            return error_memory(error);
        const struct text seen = {content->data + r->old_len, content->len - r->old_len};
        if (r->watch &&
            !r->watch->look(r->watch->context, seen, first ? 0 : so_far, r->size, error))
            return false;
    }
}

static bool read_all(const char *path, size_t limit, struct read_watch *watch,
                     struct buffer *content, int *fd, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct stat st = {0}, final_status;
    struct file_reading r = {path, limit, content->len, 0, watch, 0};
    if (!open_file(path, fd, &st, watch, content, error))
        return false;
    r.size = S_ISREG(st.st_mode) ? (uintmax_t)st.st_size : 0;
    if (watch && watch->patience > 0 && (!S_ISREG(st.st_mode) || made_up(&st, watch)))
        r.deadline = clock_ns() + watch->patience;
    if (r.size > limit)
        return error_set(error, ERROR_IO, "%s has %ju bytes; at most %zu are read",
                         safe_name(text_of(path), name), r.size, limit);
    if (content->len - r.old_len > limit)
        return too_long(path, limit, error);
    if (!read_pieces(*fd, &r, content, error))
        return false;
    if (watch)
        watch->grew = r.size > 0 && fstat(*fd, &final_status) == 0 &&
                      (uintmax_t)final_status.st_size > r.size;
    buffer_put(content, TEXT("")); /* an empty file gives "", not NULL */
    return !content->failed || error_memory(error);
}

bool file_read_watched(const char *path, size_t limit, struct read_watch *watch,
                       struct buffer *content, struct error *error)
{
    const size_t old_len = content->len;
    int fd = -1;
    const bool done = read_all(path, limit, watch, content, &fd, error);
    /* nothing was written: nothing can be lost */
    if (fd >= 0)
        close(fd);
    if (!done && content->data) {
        content->len = old_len;
        content->data[old_len] = '\0';
    }
    return done;
}

bool file_read(const char *path, size_t limit, struct buffer *content, struct error *error)
{
    return file_read_watched(path, limit, NULL, content, error);
}
