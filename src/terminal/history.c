/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The history file: appended line by line under a lock, so that sessions side by side lose nothing.
 */
#include "terminal/terminal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <readline/history.h>

/* Cut back to HISTORY_LINES when the file has grown to this many. */
#define HISTORY_MAX (HISTORY_LINES + HISTORY_LINES / 2)
#define HISTORY_BYTES ((size_t)64 << 20)

/* Opens the file and locks it; again if another session replaced it in between. -1: no place for
 * it. */
static int open_locked(const char *path)
{
    for (;;) {
        int fd = open(path, O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (fd < 0) {
            return -1;
        }
        struct stat mine;
        struct stat there;
        while (flock(fd, LOCK_EX) != 0 && errno == EINTR) {
        }
        if (fstat(fd, &mine) == 0 && stat(path, &there) == 0 && mine.st_ino == there.st_ino &&
            mine.st_dev == there.st_dev) {
            return fd;
        }
        close(fd);
    }
}

/* The last HISTORY_LINES of the file go into a new one that takes its place; called under the lock.
 */
static void cut_back(const char *path, const char *saved, size_t len)
{
    struct buffer temporary = {0};
    buffer_format(&temporary, "%s.%ld", path, (long)getpid());
    int fd =
        temporary.failed ? -1 : open(temporary.data, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd >= 0) {
        bool whole = write(fd, saved, len) == (ssize_t)len && fsync(fd) == 0;
        whole = close(fd) == 0 && whole;
        if (!whole || rename(temporary.data, path) != 0) {
            unlink(temporary.data);
        }
    }
    buffer_free(&temporary);
}

void history_load(void)
{
    using_history();
    stifle_history(HISTORY_LINES);
    char *path = state_path("history", true);
    int fd = path ? open_locked(path) : -1;
    struct buffer content = {0};
    struct error error;
    if (fd >= 0 && file_read(path, HISTORY_BYTES, &content, &error)) {
        size_t lines = 0;
        for (size_t i = 0; i < content.len; i++) {
            lines += content.data[i] == '\n';
        }
        struct text rest = buffer_text(&content);
        struct text line;
        size_t skip = lines > HISTORY_LINES ? lines - HISTORY_LINES : 0;
        while (skip > 0 && text_split(&rest, '\n', &line)) {
            skip--;
        }
        if (lines > HISTORY_MAX) {
            cut_back(path, rest.at, rest.len);
        }
        while (text_split(&rest, '\n', &line)) {
            if (line.len > 0) {
                /* the newline, or the final NUL */
                content.data[line.at + line.len - content.data] = 0;
                add_history(line.at);
            }
        }
    }
    if (fd >= 0) {
        close(fd);
    }
    buffer_free(&content);
    free(path);
}

bool history_append(const char *line, struct error *error)
{
    add_history(line);
    char *path = state_path("history", true);
    int fd = path ? open_locked(path) : -1;
    bool saved = fd >= 0;
    if (fd >= 0) {
        struct buffer text = {0};
        buffer_put(&text, text_of(line));
        buffer_char(&text, '\n');
        /* one write: whole lines only */
        saved = !text.failed && write(fd, text.data, text.len) == (ssize_t)text.len;
        saved = close(fd) == 0 && saved;
        buffer_free(&text);
    }
    if (!saved) {
        error_set(error, ERROR_IO, "the history cannot be kept%s%s: %s", path ? " in " : "",
                  path ? path : "", path ? strerror(errno) : "HOME is not set");
    }
    free(path);
    return saved;
}
