/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Files that grow by whole lines, to which several programs may add at the same time: each adds at
 * the end, under a lock, and removes again what could not be written completely. */
#include <hooke/base/safe_text.h>
#include "base/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define LOCK_NS 200000000 /* [ns] longest wait for a lock that another program holds */
#define LOCK_ATTEMPTS 20  /* number of attempts within that time */

/* ---- opening ---- */

/* Opens or creates the writer's path for appending. Returns the descriptor, or -1 with the error
 * set if the path is not a regular file or may not be written. */
static int open_file(struct writer *writer, struct write_policy policy, mode_t mode,
                     struct error *error)
{
    mode_t ignored;
    struct stat st;
    writer->force = true; /* it is added to, not replaced */
    if (!writer_open_folder(writer, policy.confine, error) ||
        !writer_allows(writer, &ignored, error))
        return -1;
    const int fd = openat(writer->folder, writer->base,
                          O_RDWR | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK, mode);
    if (fd >= 0 && fstat(fd, &st) == 0 && S_ISREG(st.st_mode))
        return fd;
    writer_refuse(writer, error, fd < 0 ? system_message(errno) : "it is not a regular file");
    if (fd >= 0)
        close(fd);
    return -1;
}

/* Opens a file for appending; see file.h. A struct writer serves only to check the path. */
int append_open(const char *path, struct write_policy policy, unsigned mode, struct error *error)
{
    struct writer writer = {.fd = -1, .folder = -1, .path = strdup(path)};
    int fd = -1;
    if (!writer.path)
        error_memory(error);
    else if (policy.refuse)
        writer_refuse(&writer, error, WRITER_REFUSED);
    else
        fd = open_file(&writer, policy, mode, error);
    writer_abandon(&writer);
    return fd;
}

/* Locks the whole file; with wait it tries for LOCK_NS. Returns false if another process holds it,
 * or after Ctrl-C. */
bool file_lock(int fd, bool wait)
{
    const struct timespec interval = {.tv_nsec = LOCK_NS / LOCK_ATTEMPTS};
    for (int attempt = 0;; attempt++) {
        if (flock(fd, LOCK_EX | LOCK_NB) == 0)
            return true;
        const bool held = errno == EWOULDBLOCK || errno == EINTR;
        /* Ctrl-C ends the waiting */
        if (!held || !wait || attempt == LOCK_ATTEMPTS || nanosleep(&interval, NULL) != 0)
            return false;
    }
}

void file_unlock(int fd)
{
    flock(fd, LOCK_UN);
}

/* ---- adding ---- */

/* Truncates the file to size bytes, which removes what this program has appended, unless somebody
 * else has written since. Returns false if the incomplete line had to remain. */
static bool remove_appended(int fd, off_t size)
{
    struct stat now;
    int result = 0;
    if (fstat(fd, &now) != 0)
        return false;
    if (now.st_size <= size)
        return true;
    if (now.st_size != lseek(fd, 0, SEEK_CUR))
        return false;
    do
        result = ftruncate(fd, size);
    while (result != 0 && errno == EINTR);
    return result == 0;
}

/* Appends lines, after a line break if the file does not end with one, and sets *status to the
 * state of the file before. Returns 0 or an errno. */
static int file_append(int fd, struct text lines, bool sync, struct stat *status)
{
    char last = '\n';
    struct buffer text = {0};
    if (fstat(fd, status) != 0)
        return errno;
    if (status->st_size > 0 && pread(fd, &last, 1, status->st_size - 1) != 1)
        return errno;
    if (last != '\n') /* somebody's incomplete line must not join the first new one */
        buffer_char(&text, '\n');
    buffer_put(&text, lines);
    struct text rest = buffer_text(&text);
    int number = text.failed ? ENOMEM : file_put(fd, &rest);
    buffer_free(&text);
    return number == 0 && sync ? file_synced(fd) : number;
}

/* Appends lines completely or not at all. Returns false with the error set. */
bool append_lines(int fd, struct text lines, bool sync, struct error *error)
{
    struct stat status = {.st_size = 0};
    const int number = file_append(fd, lines, sync, &status);
    const bool is_complete = number == 0 || remove_appended(fd, status.st_size);
    return number == 0 || error_set(error, ERROR_IO, "%s%s", system_message(number),
                                    is_complete ? "" : " (the last line is incomplete)");
}
