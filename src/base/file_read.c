/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "hooke/base.h"
#include "internal.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#define PIECE 65536u

static bool cannot_read(struct error *error, const char *path, int number)
{
    char name[SAFE_NAME_SIZE];
    if (number == EINTR)
        return error_set(error, ERROR_CANCELLED, "reading %s was interrupted", safe_name(text_of(path), name));
    return error_set(error, ERROR_IO, "cannot read %s: %s", safe_name(text_of(path), name),
                     number == EISDIR ? "it is a directory" : system_message(number));
}

static bool read_all(int fd, const char *path, size_t limit, struct buffer *content, struct error *error)
{
    char name[SAFE_NAME_SIZE], piece[PIECE];
    const size_t before = content->len;
    struct stat st;
    if (fstat(fd, &st) != 0)
        return cannot_read(error, path, errno);
    if (S_ISDIR(st.st_mode))
        return cannot_read(error, path, EISDIR);
    if (S_ISREG(st.st_mode) && (uintmax_t)st.st_size > limit)
        return error_set(error, ERROR_IO, "%s has %ju bytes; at most %zu are read", safe_name(text_of(path), name),
                         (uintmax_t)st.st_size, limit);
    /* EINTR is not retried: it is how Ctrl-C gets out of a pipe that nobody writes to. */
    for (ssize_t got; (got = read(fd, piece, sizeof piece)) != 0;) {
        if (got < 0)
            return cannot_read(error, path, errno);
        if ((size_t)got > limit - (content->len - before))
            return error_set(error, ERROR_IO, "%s goes on after %zu bytes; at most %zu are read",
                             safe_name(text_of(path), name), limit, limit);
        buffer_put(content, (struct text){piece, (size_t)got});
        if (content->failed)
            return error_memory(error);
    }
    buffer_put(content, TEXT("")); /* an empty file gives "", not NULL */
    return !content->failed || error_memory(error);
}

bool file_read(const char *path, size_t limit, struct buffer *content, struct error *error)
{
    const size_t before = content->len;
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (fd < 0)
        return cannot_read(error, path, errno);
    bool done = read_all(fd, path, limit, content, error);
    close(fd); /* nothing was written: nothing can be lost */
    if (!done && content->data) {
        content->len = before;
        content->data[before] = '\0';
    }
    return done;
}
