/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Writes folders completely or not at all: folder_open(), folder_put() for each file, then
 * folder_commit(). The new folder has a hidden name until rename(2) puts it in place, which fails
 * if the name is taken by anything but an empty folder. With force both names are exchanged, and
 * the old folder is removed under the hidden one.
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

/* Calls act(fd, name, own) for each entry of the folder until it returns false; `own` decides which
 * names belong to this program. Sets stopped to the name of the entry that was refused, or to "" if
 * act accepted all. Returns false with errno set if the folder cannot be read. */
static bool each_entry(int fd, bool (*act)(int fd, const char *name, folder_owns *own),
                       folder_owns *own, char stopped[NAME_MAX_SIZE])
{
    const int list_fd = openat(fd, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *list = list_fd < 0 ? NULL : fdopendir(list_fd);
    stopped[0] = '\0';
    if (!list) {
        const int number = errno;
        if (list_fd >= 0)
            close(list_fd);
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

/* Returns true if the entry is a regular file with a name that own accepts. */
static bool is_own_file(int fd, const char *name, folder_owns *own)
{
    struct stat st;
    return own(name) && fstatat(fd, name, &st, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(st.st_mode);
}

/* Removes the entry if it is an own file. Returns true, so that each_entry() continues. */
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

/* Removes the folder of that hidden name, unless it holds foreign files. */
static void remove_hidden(struct folder *folder, const char *name)
{
    const int fd =
        openat(folder->writer.folder, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0)
        return;
    folder_empty(fd, folder->own);
    close(fd);
    unlinkat(folder->writer.folder, name, AT_REMOVEDIR);
}

/* ---- opening ---- */

/* Returns true if the target's name is free, or is a folder that force may replace; sets *exists.
 * Returns false with the error set, also if the old folder holds foreign files. */
static bool target_allows(const struct folder *folder, bool *exists, struct error *error)
{
    const struct writer *writer = &folder->writer;
    struct stat st;
    char foreign[NAME_MAX_SIZE], shown[SAFE_NAME_SIZE], path[SAFE_NAME_SIZE];
    *exists = fstatat(writer->folder, writer->base, &st, AT_SYMLINK_NOFOLLOW) == 0;
    if (!*exists)
        return errno == ENOENT || writer_refuse(writer, error, system_message(errno));
    if (!S_ISDIR(st.st_mode))
        return writer_refuse(writer, error, "something that is not a folder already has that name");
    if (!writer->force)
        return writer_refuse_existing(writer, error);
    const int fd =
        openat(writer->folder, writer->base, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    const bool read = fd >= 0 && each_entry(fd, is_own_file, folder->own, foreign);
    const int number = errno;
    if (fd >= 0)
        close(fd);
    if (!read)
        return writer_refuse(writer, error, system_message(number));
    if (!foreign[0])
        return true;
    error_set(error, ERROR_IO, "cannot replace %s: it also holds %s, which would be lost",
              safe_name(text_of(writer->path), path), safe_name(text_of(foreign), shown));
    return error_hint(error, "choose another name, or move that file first");
}

/* Makes and opens a new folder under a hidden name, locked so that no other program takes it for a
 * stray. Returns false with errno set. */
static bool make_hidden(struct folder *folder, mode_t mode)
{
    struct writer *writer = &folder->writer;
    for (int i = 0; i < NAME_ATTEMPTS && stray_name(writer->temporary, writer->base, STRAY_NEW);
         i++) {
        if (mkdirat(writer->folder, writer->temporary, mode) != 0) {
            if (errno == EEXIST)
                continue;
            break;
        }
        folder->fd = openat(writer->folder, writer->temporary,
                            O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
        if (folder->fd < 0 && errno != ENOENT)
            return false;
        if (folder->fd >= 0 && stray_is_held(writer->folder, writer->temporary, folder->fd))
            return true;
        if (folder->fd >= 0) /* taken for a stray before it was locked */
            close(folder->fd);
        folder->fd = -1;
    }
    writer->temporary[0] = '\0';
    return false;
}

/* Opens the parent folder, checks the target and makes the hidden folder. Returns false with the
 * error set; the caller cleans up. */
static bool folder_prepare(struct folder *folder, struct write_policy policy, struct error *error)
{
    struct writer *writer = &folder->writer;
    bool exists;
    if (!writer->path)
        return error_memory(error);
    size_t len = strlen(writer->path);
    while (len > 1 && writer->path[len - 1] == '/')
        writer->path[--len] = '\0';
    if (!writer_open_folder(writer, policy.confine, error))
        return false;
    if (is_self(writer->base))
        return writer_refuse(writer, error, "'.' and '..' cannot be used; name a new folder");
    return target_allows(folder, &exists, error) &&
           (make_hidden(folder, policy.secret ? 0700 : 0777) ||
            writer_refuse(writer, error, system_message(errno)));
}

/* Prepares a folder to be filled under a hidden name. Returns false with the error set. */
bool folder_open(struct folder *folder, const char *path, struct write_policy policy,
                 folder_owns *own, struct error *error)
{
    *folder = (struct folder){
        .writer = {.fd = -1, .folder = -1, .force = policy.force}, .fd = -1, .own = own};
    folder->writer.path = strdup(path);
    if (policy.refuse && folder->writer.path)
        writer_refuse(&folder->writer, error, WRITER_REFUSED);
    else if (folder_prepare(folder, policy, error))
        return true;
    folder_abandon(folder);
    return false;
}

/* ---- filling ---- */

/* Opens a new file in the folder for writing. Returns false with the error set. */
bool folder_file_open(const struct folder *folder, const char *name, struct writer *file,
                      struct error *error)
{
    *file = (struct writer){.fd = -1, .folder = -1};
    if (asprintf(&file->path, "%s/%s", folder->writer.path, name) < 0)
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

/* Writes a file of the folder. Returns false with the error set. */
bool folder_put(struct folder *folder, const char *name, struct text content, struct error *error)
{
    struct writer file;
    if (!folder_file_open(folder, name, &file, error))
        return false;
    writer_put(&file, content);
    return writer_commit(&file, error);
}

/* ---- putting in place: each step returns 0 or an errno ---- */

static int writer_rename(const struct writer *writer, const char *old_name, const char *new_name,
                         unsigned flags)
{
    return renameat2(writer->folder, old_name, writer->folder, new_name, flags) == 0 ? 0 : errno;
}

/* Replaces a folder in two steps, where names cannot be exchanged (NFS, FAT): the old folder is
 * moved aside first. */
static int replace_in_turn(struct folder *folder)
{
    struct writer *writer = &folder->writer;
    char fresh[sizeof writer->temporary];
    const int old =
        openat(writer->folder, writer->base, O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    int number = old < 0 ? errno : EEXIST;
    memcpy(fresh, writer->temporary, sizeof fresh);
    if (old >= 0)
        file_lock(old, false); /* another program would take it for a stray otherwise */
    for (int i = 0; i < NAME_ATTEMPTS && (number == EEXIST || number == ENOTEMPTY); i++)
        number = stray_name(writer->temporary, writer->base, STRAY_OLD)
                     ? writer_rename(writer, writer->base, writer->temporary, 0)
                     : errno;
    if (number == 0 && (number = writer_rename(writer, fresh, writer->base, 0)) != 0)
        writer_rename(writer, writer->temporary, writer->base, 0);
    if (number != 0)
        memcpy(writer->temporary, fresh, sizeof fresh);
    if (old >= 0)
        close(old);
    return number;
}

/* Gives the finished folder its name; an old one of that name ends up under the hidden name. */
static int folder_publish(struct folder *folder, bool exists)
{
    struct writer *writer = &folder->writer;
    if (exists) {
        const int number = writer_rename(writer, writer->temporary, writer->base, RENAME_EXCHANGE);
        return number == EINVAL || number == ENOSYS ? replace_in_turn(folder) : number;
    }
    const int number = writer_rename(writer, writer->temporary, writer->base, 0);
    if (number == 0)
        writer->temporary[0] = '\0';
    return number;
}

/* Syncs the folder, gives it its name, and removes an old one. Returns false with the error set;
 * closes in every case. */
bool folder_commit(struct folder *folder, struct error *error)
{
    struct writer *writer = &folder->writer;
    bool exists, done = false;
    int number = file_synced(folder->fd);
    number = number == EINVAL ? 0 : number; /* a folder that cannot be synced */
    if (number == 0 && target_allows(folder, &exists, error)) {
        number = folder_publish(folder, exists);
        if (number == 0) {
            number = file_synced(writer->folder);
            if (number == EINVAL || number == EBADF) /* or was opened by O_PATH */
                number = 0;
        }
        done = number == 0;
    }
    if (number == EEXIST || number == ENOTEMPTY)
        writer_refuse_existing(writer, error);
    else if (number != 0)
        writer_refuse(writer, error, system_message(number));
    folder_abandon(folder);
    return done;
}

/* Closes the folder and removes what still has a hidden name; may be called for one that is not
 * open. */
void folder_abandon(struct folder *folder)
{
    if (!folder->writer.path) /* not open, or all zeros */
        folder->fd = -1;
    if (folder->writer.temporary[0] != '\0')
        remove_hidden(folder, folder->writer.temporary);
    folder->writer.temporary[0] = '\0';
    if (folder->fd >= 0)
        close(folder->fd);
    folder->fd = -1;
    writer_abandon(&folder->writer);
}
