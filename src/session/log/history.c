/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/session/log.h>
#include <hooke/session/subject.h>

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void history_add(struct session *session, struct text line)
{
    line = text_trim(line);
    if (line.len == 0)
        return;
    /* The list only helps people: without memory the line is just not listed. */
    if (session->histories == HISTORY_MAX) {
        free(session->history[0]);
        memmove(session->history, session->history + 1,
                (HISTORY_MAX - 1) * sizeof *session->history);
        session->histories--;
    } else if ((session->histories & (session->histories - 1)) ==
               0) { /* full at every power of two */
        const size_t capacity = session->histories ? 2 * (size_t)session->histories : 1;
        char **larger = realloc(session->history, capacity * sizeof *larger);
        if (!larger)
            return;
        session->history = larger;
    }
    char *copy = strndup(line.at, line.len);
    if (copy)
        session->history[session->histories++] = copy;
}

bool history_open(struct session *session, const char *path, struct error *error)
{
    /* The writer knows which targets are allowed: no link, no device, nothing outside with --safe.
     */
    struct writer check;
    if (!writer_open(&check, path, session_policy(session, true), error))
        return false;
    writer_abandon(&check);
    struct stat st;
    const int fd =
        open(path, O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK, 0666);
    char *copy = strdup(path);
    if (fd < 0 || fstat(fd, &st) != 0 || !S_ISREG(st.st_mode) || !copy) {
        if (fd >= 0)
            close(fd);
        free(copy);
        return error_set(error, ERROR_IO, "cannot append to %s", path);
    }
    history_close(session);
    session->record_fd = fd;
    session->record_path = copy;
    return true;
}

void history_close(struct session *session)
{
    if (session->record_fd >= 0)
        close(session->record_fd);
    free(session->record_path);
    session->record_fd = -1;
    session->record_path = NULL;
}

/* All of it or an error; a line is written by one call so that two sessions do not mix theirs. */
static bool append(int fd, struct text text)
{
    while (text.len > 0) {
        const ssize_t n = write(fd, text.at, text.len);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        text = (struct text){text.at + n, text.len - (size_t)n};
    }
    return true;
}

bool history_record(struct session *session, struct text statement, struct error *error)
{
    if (session->record_fd < 0)
        return true;
    struct buffer line = {0};
    buffer_put(&line, statement);
    buffer_char(&line, '\n');
    const bool ok = !line.failed && append(session->record_fd, buffer_text(&line)) &&
                    fsync(session->record_fd) == 0;
    buffer_free(&line);
    if (!ok) {
        error_set(error, ERROR_IO, "cannot append to %s: the recording of commands ends here",
                  session->record_path);
        history_close(session);
    }
    return ok;
}
