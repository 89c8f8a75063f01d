/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The history file of typed lines: it is appended to line by line under a lock, so that sessions at
 * the same time lose nothing. */
#include "terminal/terminal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <readline/history.h>

/* The file is shortened to HISTORY_LINES when it has grown to this many lines. */
#define HISTORY_MAX (HISTORY_LINES + HISTORY_LINES / 2)
/* [byte] longer files are not read */
#define HISTORY_BYTES ((size_t)64 << 20)

/* Opens the file and locks it; repeats if another session has replaced it meanwhile. Sets *locked
 * if the lock was obtained. Returns the descriptor, or -1 with an error if the file cannot be
 * opened. */
static int open_locked(const char *path, bool *locked, struct error *error)
{
    /* set when one wait for the lock was unsuccessful; later calls do not wait */
    static bool waited;
    const struct write_policy policy = {.force = true};
    for (;;) {
        struct stat mine, there;
        const int fd = append_open(path, policy, 0600, error);
        if (fd < 0)
            return -1;
        *locked = file_lock(fd, !waited);
        waited = !*locked;
        if (!*locked || (fstat(fd, &mine) == 0 && stat(path, &there) == 0 &&
                         mine.st_ino == there.st_ino && mine.st_dev == there.st_dev))
            return fd;
        close(fd);
    }
}

/* Replaces the file by its last lines; the caller holds the lock. */
static void cut_back(const char *path, struct text last)
{
    struct error ignored;
    file_write(path, last, (struct write_policy){.force = true}, &ignored);
}

/* Adds the last HISTORY_LINES lines of the file to readline's history, and shortens a long file if
 * it is locked. */
static void history_file_load(const char *path, bool locked)
{
    struct buffer content = {0};
    struct error error;
    if (!file_read(path, HISTORY_BYTES, &content, &error))
        return;
    size_t lines = 0;
    for (size_t i = 0; i < content.len; i++)
        lines += content.data[i] == '\n';
    struct text rest = buffer_text(&content), line;
    for (size_t skip = lines > HISTORY_LINES ? lines - HISTORY_LINES : 0; skip > 0; skip--)
        text_split(&rest, '\n', &line);
    if (lines > HISTORY_MAX && locked)
        cut_back(path, rest);
    while (text_split(&rest, '\n', &line)) {
        if (line.len > 0) {
            content.data[line.data + line.len - content.data] =
                0; /* the newline, or the final NUL */
            add_history(line.data);
        }
    }
    buffer_free(&content);
}

/* Loads readline's history from the file; without a file it begins empty. */
void history_load(void)
{
    struct error ignored; /* reported when a line is added */
    bool locked;
    using_history();
    stifle_history(HISTORY_LINES);
    char *path = state_path("history", true);
    const int fd = path ? open_locked(path, &locked, &ignored) : -1;
    if (fd >= 0) {
        history_file_load(path, locked);
        close(fd);
    }
    free(path);
}

/* Adds a line to readline's history and to the file. Returns false with an error if the file could
 * not be written, or was written without the lock. */
bool history_append(const char *line, struct error *error)
{
    struct error why = {0};
    struct buffer text = {0};
    bool locked = true;
    add_history(line);
    char *path = state_path("history", true);
    const int fd = path ? open_locked(path, &locked, &why) : -1;
    bool saved = fd >= 0;
    buffer_format(&text, "%s\n", line);
    if (fd >= 0) {
        saved =
            text.failed ? error_memory(&why) : append_lines(fd, buffer_text(&text), false, &why);
        /* some file systems report a full disk only at close() */
        if (close(fd) != 0 && errno != EINTR && saved)
            saved = error_set(&why, ERROR_IO, "%s", strerror(errno));
    }
    buffer_free(&text);
    if (!path)
        error_set(error, ERROR_IO, "the history cannot be saved: HOME is not set");
    else if (!saved)
        error_set(error, ERROR_IO, "the history cannot be saved in %.200s: %s", path, why.text);
    else if (!locked)
        error_set(error, ERROR_IO, "another program has locked %.200s; lines are added anyway",
                  path);
    free(path);
    return saved && locked;
}

/* Adds a line to the history; a failure is reported once per program. */
void history_keep(const char *line, struct reply *reply)
{
    static bool warned;
    struct error error;
    if (history_append(line, &error) || warned)
        return;
    warned = true;
    reply_warning(reply, "%s", error.text);
}
