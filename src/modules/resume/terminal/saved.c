/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Session files: which ones exist, which sessions are still running, and how one is restored. A
 * running session has its file locked, since process numbers mean nothing after a reboot, in a
 * container or in a folder that several machines share. */
#define _GNU_SOURCE /* F_OFD_GETLK */
#include "modules/resume/terminal/autosave.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* [byte] largest session file that is read, with rows and what is left of earlier ones */
#define SAVED_BYTES ((size_t)2 << 30)

/* ---- locks ---- */

/* Locks the open file, not the process: a copy of the descriptor shares the lock, another
 * opening does not. If the file system has no such locks, it may support flock(). */
bool saved_lock(int fd)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    return fcntl(fd, F_OFD_SETLK, &lock) == 0 ||
           (errno != EAGAIN && errno != EACCES && flock(fd, LOCK_EX | LOCK_NB) == 0);
}

/* Returns true if a session has the file locked. */
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

/* Returns true for names such as session-20261121-114700-1234.hks. */
static bool is_saved_name(const char *name)
{
    int used = 0;
    return strlen(name) < sizeof((struct autosaved *)0)->name &&
           sscanf(name, AUTOSAVE_PREFIX "%*8[0-9]-%*6[0-9]-%*9[0-9]%n", &used) == 0 && used > 0 &&
           strcmp(name + used, AUTOSAVE_ENDING) == 0;
}

/* Orders files for qsort(), the newest first. */
static int by_time(const void *a, const void *b)
{
    const struct autosaved *x = a, *y = b;
    if (x->time == y->time)
        return strcmp(y->name, x->name);
    return x->time < y->time ? 1 : -1;
}

/* Lists the session files in a folder, the newest first, without those for which there is no
 * memory. The caller frees item. */
struct saved_list saved_list(const char *folder)
{
    struct saved_list list = {0};
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        struct stat status;
        if (!is_saved_name(entry->d_name) ||
            fstatat(dirfd(directory), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0 ||
            !S_ISREG(status.st_mode))
            continue;
        struct autosaved *more = realloc(list.item, (size_t)(list.count + 1) * sizeof *more);
        if (!more)
            continue;
        list.item = more;
        struct autosaved *saved = &list.item[list.count++];
        *saved = (struct autosaved){.time = status.st_mtime,
                                    .living = is_locked(dirfd(directory), entry->d_name),
                                    .empty = status.st_size <= (off_t)strlen(STORE_HEADER)};
        memcpy(saved->name, entry->d_name, strlen(entry->d_name) + 1); /* fits, as checked above */
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

/* Returns true if that is the file's name, with or without its ending. */
static bool is_named(const struct autosaved *saved, const char *name)
{
    const size_t len = strlen(name);
    return strncmp(saved->name, name, len) == 0 &&
           (saved->name[len] == '\0' || strcmp(saved->name + len, AUTOSAVE_ENDING) == 0);
}

/* Returns the path of the named session file, or if name is NULL of the newest one of an ended
 * session. The caller frees it. Returns NULL with an error whose hint lists some sessions. */
static char *choose_saved(const char *folder, const char *name, struct error *error)
{
    struct saved_list list = saved_list(folder);
    const struct autosaved *found = NULL;
    for (int i = 0; i < list.count && !found; i++)
        if (name ? is_named(&list.item[i], name) : !list.item[i].living && !list.item[i].empty)
            found = &list.item[i];
    struct buffer path = {0};
    if (found) {
        buffer_format(&path, "%s%s", folder, found->name);
    } else {
        const char *const which = name ? name : "";
        error_set(error, ERROR_USAGE, "there is no saved session%s%s in %s", name ? " " : "", which,
                  folder);
        for (int i = 0; i < list.count && i < AUTOSAVE_KEPT; i++) {
            const size_t used = strlen(error->hint);
            snprintf(error->hint + used, sizeof error->hint - used, "%s%s",
                     i ? " " : "existing sessions: ", list.item[i].name);
        }
    }
    free(list.item);
    return path.data;
}

/* Replaces *session by the saved one called `name`, or the most recent one if name is NULL, and
 * destroys the previous one. Appends a summary and notes on what was left out to `messages`.
 * Returns false with *error, and *session unchanged, if there is none or it cannot be restored. */
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
    const char *shown = path ? strrchr(path, '/') + 1 : NULL;
    bool ok = path && file_read(path, SAVED_BYTES, &content, error);
    if (ok && !(restored = session_create(&(*session)->front))) {
        error_memory(error);
        ok = false;
    }
    if (ok) {
        restored->options = (*session)->options;
        ok = session_restore(restored, buffer_text(&content), shown, getenv("TMPDIR"), &notes,
                             error);
    }
    if (ok) {
        buffer_format(messages, "%s restored: %d run%s, %d recording%s", shown,
                      restored->runs.count, restored->runs.count == 1 ? "" : "s",
                      restored->recordings, restored->recordings == 1 ? "" : "s");
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
