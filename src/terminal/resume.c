/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Sessions that saved themselves: which files there are, whose session is still there, and how one
 * is taken up again: from its file, or from commands that an older version has saved. A living
 * session has its file locked: process numbers say nothing after a reboot, in a container or on a
 * folder that several machines share. Files of older versions have no lock, but a process number in
 * their name.
 */
#define _GNU_SOURCE /* F_OFD_GETLK */
#include "terminal/terminal.h"

#include <hooke/plot.h>
#include <hooke/report.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* [byte] of a session file that are read: its rows, and what is left of earlier ones */
#define SAVED_BYTES ((size_t)2 << 30)

/* ---- locks ---- */

/* Of the open file, not of the process: a copy of the descriptor keeps it, another opening does not
 * have it. Where a file system knows none, flock() may be known. */
bool saved_lock(int fd)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    return fcntl(fd, F_OFD_SETLK, &lock) == 0 ||
           (errno != EAGAIN && errno != EACCES && flock(fd, LOCK_EX | LOCK_NB) == 0);
}

static bool is_locked(int folder, const char *name)
{
    const int fd = openat(folder, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    struct flock lock = {.l_type = F_RDLCK, .l_whence = SEEK_SET};
    if (fd < 0)
        return false;
    bool locked = fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
    if (!locked && flock(fd, LOCK_SH | LOCK_NB) != 0)
        locked = errno == EWOULDBLOCK;
    close(fd);
    return locked;
}

/* ---- the files there are ---- */

/* session-20261121-114700-1234.hks, of older versions .hk */
static bool read_name(int folder, const char *name, struct autosaved *saved)
{
    long pid;
    int used = 0;
    if (strlen(name) >= sizeof saved->name ||
        sscanf(name, AUTOSAVE_PREFIX "%*8[0-9]-%*6[0-9]-%9ld%n", &pid, &used) != 1 || used == 0 ||
        pid <= 0)
        return false;
    const char *ending = name + used;
    saved->old = strcmp(ending, ".hk") == 0;
    if (!saved->old && strcmp(ending, AUTOSAVE_ENDING) != 0)
        return false;
    memcpy(saved->name, name, strlen(name) + 1); /* fits: checked above */
    saved->living =
        saved->old ? kill((pid_t)pid, 0) == 0 || errno == EPERM : is_locked(folder, name);
    return true;
}

static int by_time(const void *a, const void *b)
{
    const struct autosaved *x = a, *y = b;
    return x->time != y->time ? (x->time < y->time ? 1 : -1) : strcmp(y->name, x->name);
}

/* Caller frees item. */
struct saved_list saved_list(const char *folder)
{
    struct saved_list list = {0};
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        struct autosaved saved;
        struct stat status;
        if (fstatat(dirfd(directory), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0 ||
            !S_ISREG(status.st_mode)) {
            continue;
        }
        struct autosaved *more = read_name(dirfd(directory), entry->d_name, &saved)
                                     ? realloc(list.item, (size_t)(list.count + 1) * sizeof *more)
                                     : NULL;
        if (more) {
            list.item = more;
            saved.time = status.st_mtime;
            saved.empty = status.st_size <= (saved.old ? 0 : (off_t)strlen(STORE_HEADER));
            list.item[list.count++] = saved;
        }
    }
    if (directory) {
        closedir(directory);
    }
    if (list.count > 1) {
        qsort(list.item, (size_t)list.count, sizeof *list.item, by_time);
    }
    return list;
}

/* ---- restoring ---- */

static bool drop(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

static bool keep(void *context, struct text text)
{
    buffer_put(context, text);
    return true;
}

/* Executes the lines; the first that fails ends it. */
static bool execute(struct session *session, const char *name, struct text content,
                    struct error *error)
{
    struct buffer said = {0};
    struct reply reply;
    reply_init(&reply, (struct sink){drop, keep, &said});
    struct source where = {.name = name};
    bool ok = true;
    for (struct text line; ok && content.len > 0 && text_split(&content, '\n', &line);) {
        where.line++;
        line = text_trim(line);
        if (line.len == 0 || line.at[0] == '#') {
            continue;
        }
        buffer_clear(&said);
        if (!command_exec(session, line, &where, &reply)) {
            struct text rest = text_trim(buffer_text(&said)), first = TEXT("");
            text_split(&rest, '\n', &first);
            ok = error_set(error, ERROR_COMMAND, "%.*s", (int)first.len, first.at);
        }
    }
    reply_free(&reply);
    buffer_free(&said);
    return ok;
}

static bool execute_part(void *context, struct session *session, struct text commands,
                         struct error *error)
{
    return execute(session, context, commands, error);
}

/* Also without its ending. */
static bool is_named(const struct autosaved *saved, const char *name)
{
    const size_t len = strlen(name);
    return strncmp(saved->name, name, len) == 0 &&
           (saved->name[len] == '\0' || strcmp(saved->name + len, ".hk") == 0 ||
            strcmp(saved->name + len, AUTOSAVE_ENDING) == 0);
}

static char *choose_saved(const char *folder, const char *name, struct error *error)
{
    struct saved_list list = saved_list(folder);
    const struct autosaved *found = NULL;
    for (int i = 0; i < list.count && !found; i++)
        if (name ? is_named(&list.item[i], name) : !list.item[i].living && !list.item[i].empty)
            found = &list.item[i];
    /* its process number may be somebody else's by now */
    for (int i = 0; i < list.count && !found && !name; i++)
        found = list.item[i].old ? &list.item[i] : NULL;
    struct buffer path = {0};
    if (found) {
        buffer_format(&path, "%s%s", folder, found->name);
    } else {
        error_set(error, ERROR_USAGE, "there is no saved session%s%s in %s", name ? " " : "",
                  name ? name : "", folder);
        for (int i = 0; i < list.count && i < AUTOSAVE_KEPT; i++) {
            const size_t used = strlen(error->hint);
            snprintf(error->hint + used, sizeof error->hint - used, "%s%s",
                     i ? " " : "there are: ", list.item[i].name);
        }
    }
    free(list.item);
    return path.data;
}

/* From records, or from the commands of older versions, whole or not at all. */
static bool restore(struct session *session, const char *shown, struct text content,
                    struct buffer *notes, struct error *error)
{
    struct buffer name = {0};
    buffer_put(&name, text_of(shown));
    const struct restorer restorer = {name.data, &plot_catalog, &result_catalog, execute_part,
                                      getenv("TMPDIR")};
    session->restoring = true;
    const bool ok = store_recognise(content)
                        ? session_restore(session, content, &restorer, notes, error)
                        : execute(session, shown, content, error);
    session->restoring = false;
    buffer_free(&name);
    return ok;
}

bool autosave_resume(struct session **session, const char *name, struct buffer *messages,
                     struct error *error)
{
    char *folder = state_path("", false);
    if (!folder) {
        return error_set(error, ERROR_USAGE, "there is no saved session: HOME is not set");
    }
    struct buffer content = {0}, notes = {0};
    struct session *restored = NULL;
    char *path = choose_saved(folder, name, error);
    const char *shown = path ? strrchr(path, '/') + 1 : "";
    bool ok = path && file_read(path, SAVED_BYTES, &content, error);
    if (ok && !(restored = session_create(&(*session)->front))) {
        error_memory(error);
        ok = false;
    }
    if (ok) {
        restored->safe = (*session)->safe;
        restored->keep_going = (*session)->keep_going;
        ok = restore(restored, shown, buffer_text(&content), &notes, error);
    }
    if (ok) {
        buffer_format(messages, "%s restored: %d run%s, %d recording%s", shown, restored->runs,
                      restored->runs == 1 ? "" : "s", restored->recordings,
                      restored->recordings == 1 ? "" : "s");
        if (notes.len > 0)
            buffer_format(messages, "\n%.*s", (int)notes.len - 1, notes.data);
        session_destroy(*session);
        *session = restored;
    } else {
        session_destroy(restored);
    }
    buffer_free(&content);
    buffer_free(&notes);
    free(path);
    free(folder);
    return ok;
}
