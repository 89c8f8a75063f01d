/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Folders whole or not at all. rename(2) puts a new one in place and fails where the name is taken
 * by anything but an empty folder; with force both names are exchanged, and the old folder is
 * removed under the hidden one.
 */
#define _GNU_SOURCE /* asprintf, renameat2 */
#include <hooke/base/safe_text.h>
#include <hooke/base/folder_file.h>
#include "base/internal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define NAME_MAX_SIZE 256 /* [byte] of a name in a folder */

/* ---- what a folder holds ---- */

static bool is_self(const char *name)
{
    return strcmp(name, ".") == 0 || strcmp(name, "..") == 0;
}

/* Calls `act` for each entry until it returns false. stopped is then the name of that entry, or ""
 * if all passed. Returns false with errno set on failure. */
static bool each_entry(int fd, bool (*act)(int fd, const char *name, folder_owns *own),
                       folder_owns *own, char stopped[NAME_MAX_SIZE])
{
    const int again = openat(fd, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *list = again < 0 ? NULL : fdopendir(again);
    stopped[0] = '\0';
    if (!list) {
        const int number = errno;
        if (again >= 0)
            close(again);
        errno = number;
        return false;
    }
    errno = 0;
    for (struct dirent *entry; !stopped[0] && (entry = readdir(list)); errno = 0)
        if (!is_self(entry->d_name) && !act(fd, entry->d_name, own))
            snprintf(stopped, NAME_MAX_SIZE, "%s", entry->d_name);
    const int number = stopped[0] ? 0 : errno;
    closedir(list);
    errno = number;
    return number == 0;
}

static bool is_own_file(int fd, const char *name, folder_owns *own)
{
    struct stat st;
    return own(name) && fstatat(fd, name, &st, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(st.st_mode);
}

static bool remove_own(int fd, const char *name, folder_owns *own)
{
    if (is_own_file(fd, name, own))
        unlinkat(fd, name, 0);
    return true;
}

void folder_empty(int fd, folder_owns *own)
{
    char ignored[NAME_MAX_SIZE];
    each_entry(fd, remove_own, own, ignored);
}

/* The folder of the hidden name goes, if there is nothing foreign in it. */
static void remove_hidden(struct folder *folder, const char *name)
{
    const int fd = openat(folder->at.folder, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0)
        return;
    folder_empty(fd, folder->own);
    close(fd);
    unlinkat(folder->at.folder, name, AT_REMOVEDIR);
}

/* ---- opening ---- */

/* Returns true if the name is free, or is a folder that force may replace. */
static bool target_allows(const struct folder *folder, bool *exists, struct error *error)
{
    const struct writer *at = &folder->at;
    struct stat st;
    char foreign[NAME_MAX_SIZE], shown[SAFE_NAME_SIZE], path[SAFE_NAME_SIZE];
    *exists = fstatat(at->folder, at->base, &st, AT_SYMLINK_NOFOLLOW) == 0;
    if (!*exists)
        return errno == ENOENT || writer_refuse(at, error, system_message(errno));
    if (!S_ISDIR(st.st_mode))
        return writer_refuse(at, error, "there is something of that name that is not a folder");
    if (!at->force)
        return writer_refuse_existing(at, error);
    const int fd = openat(at->folder, at->base, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    const bool read = fd >= 0 && each_entry(fd, is_own_file, folder->own, foreign);
    const int number = errno;
    if (fd >= 0)
        close(fd);
    if (!read)
        return writer_refuse(at, error, system_message(number));
    if (!foreign[0])
        return true;
    error_set(error, ERROR_IO, "cannot replace %s: it also holds %s, which would be lost",
              safe_name(text_of(at->path), path), safe_name(text_of(foreign), shown));
    return error_hint(error, "choose another name, or move that elsewhere");
}

static bool make_hidden(struct folder *folder, mode_t mode)
{
    struct writer *at = &folder->at;
    for (int i = 0; i < NAME_ATTEMPTS && stray_name(at->temporary, at->base, STRAY_NEW); i++) {
        if (mkdirat(at->folder, at->temporary, mode) != 0) {
            if (errno == EEXIST)
                continue;
            break;
        }
        folder->fd =
            openat(at->folder, at->temporary, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
        if (folder->fd < 0 && errno != ENOENT)
            return false;
        if (folder->fd >= 0 && stray_is_held(at->folder, at->temporary, folder->fd))
            return true;
        if (folder->fd >= 0) /* taken for a stray before it was locked */
            close(folder->fd);
        folder->fd = -1;
    }
    at->temporary[0] = '\0';
    return false;
}

static bool open_all(struct folder *folder, struct write_policy policy, struct error *error)
{
    struct writer *at = &folder->at;
    bool exists;
    if (!at->path)
        return error_memory(error);
    size_t len = strlen(at->path);
    while (len > 1 && at->path[len - 1] == '/')
        at->path[--len] = '\0';
    if (!writer_open_folder(at, policy.confine, error))
        return false;
    if (is_self(at->base))
        return writer_refuse(at, error, "a folder needs a name of its own");
    return target_allows(folder, &exists, error) &&
           (make_hidden(folder, policy.secret ? 0700 : 0777) ||
            writer_refuse(at, error, system_message(errno)));
}

bool folder_open(struct folder *folder, const char *path, struct write_policy policy,
                 folder_owns *own, struct error *error)
{
    *folder = (struct folder){
        .at = {.fd = -1, .folder = -1, .force = policy.force}, .fd = -1, .own = own};
    folder->at.path = strdup(path);
    if (policy.refuse && folder->at.path)
        writer_refuse(&folder->at, error, WRITER_REFUSED);
    else if (open_all(folder, policy, error))
        return true;
    folder_abandon(folder);
    return false;
}

/* ---- filling ---- */

bool folder_file_open(const struct folder *folder, const char *name, struct writer *file,
                      struct error *error)
{
    *file = (struct writer){.fd = -1, .folder = -1};
    if (asprintf(&file->path, "%s/%s", folder->at.path, name) < 0)
        file->path = NULL;
    file->chunk = malloc(WRITER_CHUNK);
    if (!file->path || !file->chunk) {
        writer_abandon(file);
        return error_memory(error);
    }
    file->fd = openat(folder->fd, name, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file->fd >= 0)
        return true;
    writer_refuse(file, error, system_message(errno));
    writer_abandon(file);
    return false;
}

bool folder_put(struct folder *folder, const char *name, struct text content, struct error *error)
{
    struct writer file;
    if (!folder_file_open(folder, name, &file, error))
        return false;
    writer_put(&file, content);
    return writer_commit(&file, error);
}

/* ---- putting in place: each step returns 0 or an errno ---- */

static int move(const struct writer *at, const char *from, const char *to, unsigned flags)
{
    return renameat2(at->folder, from, at->folder, to, flags) == 0 ? 0 : errno;
}

/* Replaces a folder in two steps, where names cannot be exchanged (NFS, FAT): the old folder is
 * moved aside first. */
static int replace_in_turn(struct folder *folder)
{
    struct writer *at = &folder->at;
    char fresh[sizeof at->temporary];
    const int old = openat(at->folder, at->base, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    int number = old < 0 ? errno : EEXIST;
    memcpy(fresh, at->temporary, sizeof fresh);
    if (old >= 0)
        file_lock(old, false); /* or it would be taken for a stray */
    for (int i = 0; i < NAME_ATTEMPTS && (number == EEXIST || number == ENOTEMPTY); i++)
        number = stray_name(at->temporary, at->base, STRAY_OLD)
                     ? move(at, at->base, at->temporary, 0)
                     : errno;
    if (number == 0 && (number = move(at, fresh, at->base, 0)) != 0)
        move(at, at->temporary, at->base, 0);
    if (number != 0)
        memcpy(at->temporary, fresh, sizeof fresh);
    if (old >= 0)
        close(old);
    return number;
}

static int publish(struct folder *folder, bool exists)
{
    struct writer *at = &folder->at;
    if (exists) {
        const int number = move(at, at->temporary, at->base, RENAME_EXCHANGE);
        return number == EINVAL || number == ENOSYS ? replace_in_turn(folder) : number;
    }
    const int number = move(at, at->temporary, at->base, 0);
    if (number == 0)
        at->temporary[0] = '\0';
    return number;
}

bool folder_commit(struct folder *folder, struct error *error)
{
    struct writer *at = &folder->at;
    bool exists, done = false;
    int number = file_synced(folder->fd);
    number = number == EINVAL ? 0 : number; /* a folder that cannot be synced */
    if (number == 0 && target_allows(folder, &exists, error)) {
        number = publish(folder, exists);
        if (number == 0) {
            number = file_synced(at->folder);
            if (number == EINVAL || number == EBADF) /* or was opened by O_PATH */
                number = 0;
        }
        done = number == 0;
    }
    if (number == EEXIST || number == ENOTEMPTY)
        writer_refuse_existing(at, error);
    else if (number != 0)
        writer_refuse(at, error, system_message(number));
    folder_abandon(folder);
    return done;
}

void folder_abandon(struct folder *folder)
{
    if (!folder->at.path) /* not open, or all zeros */
        folder->fd = -1;
    if (folder->at.temporary[0] != '\0')
        remove_hidden(folder, folder->at.temporary);
    folder->at.temporary[0] = '\0';
    if (folder->fd >= 0)
        close(folder->fd);
    folder->fd = -1;
    writer_abandon(&folder->at);
}
