/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads files into memory: regular files, pipes and standard input, with a limit of size and a
 * watch that may stop early or refuse what has no end. */
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

/* [byte] Most that is read at once. */
#define READ_CHUNK_BYTES 16384u
#define PATIENCE_NS 200000000 /* [ns] longest wait for a writer of a named pipe */
#define PATIENCE_ATTEMPTS 20  /* number of attempts within that time */
/* [byte] Data that arrive within the watch's patience: any file has more, a sensor less. */
#define SLOW_BYTES 65536

/* One file while it is read. */
struct file_reading {
    const char *path;
    size_t limit;             /* [byte] largest file that is read */
    size_t old_len;           /* [byte] in the buffer before the file */
    uintmax_t size;           /* [byte] stated by the system, or 0 if it states none */
    struct read_watch *watch; /* NULL if nobody watches */
    /* [clock_ns] A pipe or device has to end by then unless it is fast; 0 means any time. */
    int64_t deadline;
};

/* Sets the error's hint to files of the same folder whose names resemble that of `path`, which does
 * not exist. Leaves the hint unchanged if there are none; looks at no more than ENTRIES_MAX
 * entries, and at none that are hidden or not safe to print. */
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

/* Sets the error for an errno (ERROR_CANCELLED after a signal), with similar names if the file does
 * not exist. Returns false. */
static bool fail_to_read(struct error *error, const char *path, int number)
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

/* Waits, at most PATIENCE_NS, until a program writes to the named pipe fd, since a pipe without a
 * writer has no end. A byte that is read meanwhile is appended to `content`. Returns false with the
 * error set if nobody writes or reading fails. EINTR is not retried, so that Ctrl-C ends the
 * waiting. */
static bool await_writer(int fd, const char *path, struct buffer *content, struct error *error)
{
    char name[SAFE_NAME_SIZE], first;
    const struct timespec interval = {.tv_nsec = PATIENCE_NS / PATIENCE_ATTEMPTS};
    for (int look = 0; look < PATIENCE_ATTEMPTS; look++) {
        const ssize_t got = read(fd, &first, 1);
        if (got == 1) {
            buffer_put(content, (struct text){&first, 1});
            return !content->failed || error_memory(error);
        }
        if (got < 0 && errno == EAGAIN) /* a writer exists and has written nothing yet */
            return true;
        if (got < 0 || nanosleep(&interval, NULL) != 0)
            return fail_to_read(error, path, errno);
    }
    return error_set(error, ERROR_IO, "cannot read %s: it is a pipe and no program writes to it",
                     safe_name(text_of(path), name));
}

/* Sets the error for a source without an end, and marks the watch. Returns false. */
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

/* Returns true if the system generates the contents during reading, perhaps without end, as for
 * /proc/kmsg: a regular file of size 0. */
static bool is_generated(const struct stat *st, const struct read_watch *watch)
{
    return watch && watch->patience > 0 && S_ISREG(st->st_mode) && st->st_size == 0;
}

/* Opens path, refuses what has no end if a watch asks for it, and waits for the writer of a pipe.
 * Sets *fd, which the caller closes also on failure, and *st. Returns false with the error set. */
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
        return fail_to_read(error, path, errno);
    if (watch && watch->patience > 0 && isatty(*fd))
        return refuse_endless(path, "it is a terminal or a serial line, which has no end", watch,
                              error);
    if (S_ISDIR(st->st_mode))
        return fail_to_read(error, path, EISDIR);
    if (S_ISFIFO(st->st_mode) && !input && !await_writer(*fd, path, content, error))
        return false;
    if (is_generated(st, watch)) /* such a file may block reads: it stays non-blocking */
        return true;
    const int flags = fcntl(*fd, F_GETFL);
    return (flags >= 0 && fcntl(*fd, F_SETFL, flags & ~O_NONBLOCK) >= 0) ||
           fail_to_read(error, path, errno);
}

/* Sets the error for a file beyond the limit. Returns false. */
static bool too_long(const char *path, size_t limit, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    return error_set(error, ERROR_IO, "%s is longer than %zu bytes; at most %zu can be read",
                     safe_name(text_of(path), name), limit, limit);
}

/* Waits until data arrive or the deadline is over. Returns false with the error set if a source has
 * neither ended by then nor delivered data as fast as a file. */
static bool await_more(int fd, const struct file_reading *reading, size_t so_far,
                       struct error *error)
{
    if (reading->deadline == 0)
        return true;
    struct pollfd ready = {.fd = fd, .events = POLLIN};
    const int64_t left = reading->deadline - clock_ns();
    if (left <= 0 && so_far >= SLOW_BYTES)
        return true;
    const int count = left > 0 ? poll(&ready, 1, (int)(left / 1000000) + 1) : 0;
    if (count < 0)
        return fail_to_read(error, reading->path, errno);
    return count > 0 || refuse_endless(reading->path, "data keep arriving", reading->watch, error);
}

/* Reads from fd to the end of the file and appends to `content`, READ_CHUNK_BYTES at a time; after
 * each read, reading->watch (NULL allowed) sees what was read so far. If reading->size is known (>
 * 0), no more than that is read, since another program may append faster than this one reads.
 * Returns false with the error set if reading fails, the deadline passes, the file is longer than
 * reading->limit, or the watch refuses it. */
static bool read_pieces(int fd, const struct file_reading *reading, struct buffer *content,
                        struct error *error)
{
    char piece[READ_CHUNK_BYTES];
    for (bool first = true;; first = false) {
        const size_t so_far = content->len - reading->old_len;
        const uintmax_t left = reading->size > 0 ? reading->size - so_far : READ_CHUNK_BYTES;
        if (!await_more(fd, reading, so_far, error))
            return false;
        const ssize_t got =
            read(fd, piece, left < READ_CHUNK_BYTES ? (size_t)left : READ_CHUNK_BYTES);
        if (got < 0 && errno == EAGAIN && reading->deadline > 0 && clock_ns() < reading->deadline) {
            const struct timespec interval = {.tv_nsec = PATIENCE_NS / PATIENCE_ATTEMPTS};
            if (nanosleep(&interval, NULL) != 0)
                return fail_to_read(error, reading->path, errno);
            continue;
        }
        if (got < 0 && errno == EAGAIN)
            return refuse_endless(reading->path, "data keep arriving", reading->watch, error);
        if (got < 0)
            return fail_to_read(error, reading->path, errno);
        if (got == 0)
            return true;
        if ((size_t)got > reading->limit - so_far)
            return too_long(reading->path, reading->limit, error);
        buffer_put(content, (struct text){piece, (size_t)got});
        if (content->failed)
            return error_memory(error);
        const struct text seen = {content->data + reading->old_len,
                                  content->len - reading->old_len};
        if (reading->watch && !reading->watch->look(reading->watch->context, seen,
                                                    first ? 0 : so_far, reading->size, error))
            return false;
    }
}

/* Does the work of file_read_watched(); the caller closes *fd and restores content on failure. */
static bool read_all(const char *path, size_t limit, struct read_watch *watch,
                     struct buffer *content, int *fd, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct stat st = {0}, final_status;
    struct file_reading reading = {path, limit, content->len, 0, watch, 0};
    if (!open_file(path, fd, &st, watch, content, error))
        return false;
    reading.size = S_ISREG(st.st_mode) ? (uintmax_t)st.st_size : 0;
    if (watch && watch->patience > 0 && (!S_ISREG(st.st_mode) || is_generated(&st, watch)))
        reading.deadline = clock_ns() + watch->patience;
    if (reading.size > limit)
        return error_set(error, ERROR_IO, "%s has %ju bytes; at most %zu are read",
                         safe_name(text_of(path), name), reading.size, limit);
    if (content->len - reading.old_len > limit)
        return too_long(path, limit, error);
    if (!read_pieces(*fd, &reading, content, error))
        return false;
    if (watch)
        watch->grew = reading.size > 0 && fstat(*fd, &final_status) == 0 &&
                      (uintmax_t)final_status.st_size > reading.size;
    buffer_put(content, TEXT("")); /* an empty file gives "", not NULL */
    return !content->failed || error_memory(error);
}

/* Appends the file to content, watched if watch is not NULL. Returns false with the error set and
 * content unchanged. */
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
