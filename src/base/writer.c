/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Writes files completely or not at all: writer_open(), writer_put() as often as needed, then
 * writer_commit() or writer_abandon(). The bytes go into an unnamed file (O_TMPFILE) of the folder,
 * which the kernel forgets when the program dies. It gets its name by link(2), which fails where
 * the name exists; with force a second step, rename(2), replaces the old file. Every name is looked
 * up in the folder opened at the start, wherever that is moved.
 */
#define _GNU_SOURCE /* O_TMPFILE, renameat2 */
#include <hooke/base/safe_text.h>
#include "base/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Sets the error "cannot write PATH: why". Returns false. */
bool writer_refuse(const struct writer *writer, struct error *error, const char *why)
{
    char name[SAFE_NAME_SIZE];
    return error_set(error, ERROR_IO, "cannot write %s: %s", safe_name(text_of(writer->path), name),
                     why);
}

/* Sets the error that the path exists. Returns false. */
bool writer_refuse_existing(const struct writer *writer, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    return error_set(error, ERROR_IO, "%s exists; add --force to replace it",
                     safe_name(text_of(writer->path), name));
}

/* ---- opening ---- */

static bool same_file(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* Returns true if the opened folder (a file descriptor, not closed here) is the current folder or
 * one below it. Climbs by ".." from the folder to the root and compares device and inode at each
 * level, so that links and ".." in the path that was opened cannot deceive it. */
static bool folder_is_below_here(int folder)
{
    struct stat here, current, parent_status;
    int fd = openat(folder, ".", O_PATH | O_DIRECTORY | O_CLOEXEC);
    bool is_below = false, climbing = fd >= 0 && stat(".", &here) == 0 && fstat(fd, &current) == 0;
    while (climbing && !is_below) {
        is_below = same_file(&current, &here);
        const int parent = openat(fd, "..", O_PATH | O_DIRECTORY | O_CLOEXEC);
        climbing = parent >= 0 && fstat(parent, &parent_status) == 0 &&
                   !same_file(&parent_status, &current);
        current = parent_status;
        close(fd);
        fd = parent;
    }
    if (fd >= 0)
        close(fd);
    return is_below;
}

/* Opens the folder of the path, checks that it is below the current one if confine is set, and
 * removes strays in it. Returns false with the error set. */
bool writer_open_folder(struct writer *writer, bool confine, struct error *error)
{
    char *slash = strrchr(writer->path, '/');
    writer->base = slash ? slash + 1 : writer->path;
    if (writer->base[0] == '\0')
        return writer_refuse(writer, error, slash ? "it is a directory" : "the name is empty");
    char *name;
    if (slash)
        name = strndup(writer->path, slash == writer->path ? 1 : (size_t)(slash - writer->path));
    else
        name = strdup(".");
    if (!name)
        return error_memory(error);
    writer->folder = open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (writer->folder < 0 &&
        errno == EACCES) /* one may be allowed to make files in a folder but not to list it */
        writer->folder = open(name, O_PATH | O_DIRECTORY | O_CLOEXEC);
    const int number = errno;
    free(name);
    if (writer->folder < 0)
        return writer_refuse(writer, error, system_message(number));
    if (confine && !folder_is_below_here(writer->folder))
        return writer_refuse(writer, error,
                             "it is outside the current directory, and --safe allows no other");
    strays_sweep(writer->folder);
    return true;
}

/* Returns true if the name is free, or is a regular file that force may replace; else false with an
 * error that names the kind of the entry. */
bool writer_allows(const struct writer *writer, mode_t *mode, struct error *error)
{
    static const struct {
        mode_t kind;
        const char *why;
    } kinds[] = {
        {S_IFDIR, "it is a directory"},  {S_IFLNK, "it is a symbolic link"},
        {S_IFIFO, "it is a named pipe"}, {S_IFCHR, "it is a device"},
        {S_IFBLK, "it is a device"},     {S_IFSOCK, "it is a socket"},
    };
    struct stat st;
    *mode = 0;
    if (fstatat(writer->folder, writer->base, &st, AT_SYMLINK_NOFOLLOW) != 0)
        return errno == ENOENT || writer_refuse(writer, error, system_message(errno));
    for (size_t i = 0; i < COUNT_OF(kinds); i++)
        if ((st.st_mode & S_IFMT) == kinds[i].kind)
            return writer_refuse(writer, error, kinds[i].why);
    *mode = st.st_mode & 0777;
    return writer->force || writer_refuse_existing(writer, error);
}

/* Writes the path under /proc through which an unnamed file can be linked. */
static void proc_name(const struct writer *writer, char output[32])
{
    snprintf(output, 32, "/proc/self/fd/%d", writer->fd);
}

/* Opens an unnamed file if the file system and /proc allow that, else one under a hidden name.
 * Returns false with errno set. */
static bool open_temporary(struct writer *writer)
{
    char proc[32], name[STRAY_NAME_SIZE];
    writer->fd = openat(writer->folder, ".", O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    if (writer->fd >= 0) {
        proc_name(writer, proc);
        file_lock(writer->fd, false);
        if (access(proc, F_OK) == 0)
            return true;
        close(writer->fd);
    } else if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) {
        return false;
    }
    for (int i = 0; i < NAME_ATTEMPTS && stray_name(name, writer->base, STRAY_NEW); i++) {
        writer->fd = openat(writer->folder, name,
                            O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (writer->fd >= 0 && stray_is_held(writer->folder, name, writer->fd)) {
            memcpy(writer->temporary, name, sizeof name);
            return true;
        }
        if (writer->fd >= 0)
            close(writer->fd);
        else if (errno != EEXIST)
            break;
        writer->fd = -1;
    }
    return false;
}

/* Opens the folder, checks the target and opens the temporary file. Returns false with the error
 * set; the caller cleans up. */
static bool writer_prepare(struct writer *writer, bool confine, struct error *error)
{
    mode_t mode;
    if (!writer->path || !writer->chunk) {
        error_memory(error);
        return false;
    }
    if (!writer_open_folder(writer, confine, error) || !writer_allows(writer, &mode, error))
        return false;
    const bool is_open = open_temporary(writer);
    if (!is_open)
        writer_refuse(writer, error, system_message(errno));
    return is_open;
}

/* Opens a temporary file for the path. Returns false with the error set. */
bool writer_open(struct writer *writer, const char *path, struct write_policy policy,
                 struct error *error)
{
    *writer = (struct writer){.fd = -1, .folder = -1, .force = policy.force};
    writer->path = strdup(path);
    writer->chunk = malloc(WRITER_CHUNK);
    if (policy.refuse && writer->path)
        writer_refuse(writer, error, WRITER_REFUSED);
    else if (writer_prepare(writer, policy.confine, error))
        return true;
    writer_abandon(writer);
    return false;
}

/* ---- writing ---- */

/* Writes all of *text, also after signals and partial writes. Returns 0 or an errno. */
int file_put(int fd, struct text *text)
{
    while (text->len > 0) {
        const ssize_t done = write(fd, text->data, text->len);
        if (done > 0) {
            text->data += done;
            text->len -= (size_t)done;
        } else if (done == 0 || errno != EINTR) {
            return done == 0 ? ENOSPC : errno;
        }
    }
    return 0;
}

/* Writes all of the text to the file. The first failure is remembered, after which nothing is
 * written. */
static void writer_write(struct writer *writer, struct text text)
{
    if (writer->failed)
        return;
    writer->failure = file_put(writer->fd, &text);
    writer->failed = writer->failure != 0;
}

static void writer_flush(struct writer *writer)
{
    writer_write(writer, (struct text){writer->chunk, writer->used});
    writer->used = 0;
}

/* Collects small texts in the chunk and writes large ones directly. */
void writer_put(struct writer *writer, struct text text)
{
    if (text.len > WRITER_CHUNK - writer->used)
        writer_flush(writer);
    if (text.len > WRITER_CHUNK) {
        writer_write(writer, text);
    } else if (text.len > 0) {
        memcpy(writer->chunk + writer->used, text.data, text.len);
        writer->used += text.len;
    }
}

/* ---- putting in place: each step returns 0 or an errno ---- */

/* Waits until the file is on the disk. Returns 0 or an errno. */
int file_synced(int fd)
{
    int result;
    do
        result = fsync(fd);
    while (result != 0 && errno == EINTR);
    return result == 0 ? 0 : errno;
}

/* Closes a duplicate of the descriptor, because some file systems report a full disk only on close.
 * Returns 0 or an errno. */
static int close_duplicate(int fd)
{
    const int duplicate = dup(fd);
    return duplicate >= 0 && (close(duplicate) == 0 || errno == EINTR) ? 0 : errno;
}

/* Gives the unnamed file a name in the folder. */
static int link_unnamed(const struct writer *writer, const char *name)
{
    char proc[32];
    proc_name(writer, proc);
    return linkat(AT_FDCWD, proc, writer->folder, name, AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
}

/* Gives the unnamed file a free hidden name, from which it can be renamed over an existing one. */
static int link_temporary(struct writer *writer)
{
    char name[STRAY_NAME_SIZE];
    int number = EEXIST;
    for (int i = 0; i < NAME_ATTEMPTS && number == EEXIST; i++)
        number = stray_name(name, writer->base, STRAY_NEW) ? link_unnamed(writer, name) : errno;
    if (number == 0)
        memcpy(writer->temporary, name, sizeof name);
    return number;
}

/* Renames the temporary file to its own name. Without force the name must be free; file systems
 * without RENAME_NOREPLACE get a second link, and writer_abandon() removes the first. */
static int rename_temporary(struct writer *writer)
{
    const int folder = writer->folder;
    if (renameat2(folder, writer->temporary, folder, writer->base,
                  writer->force ? 0 : RENAME_NOREPLACE) == 0) {
        writer->temporary[0] = '\0';
        return 0;
    }
    if (errno != EINVAL || writer->force)
        return errno;
    return linkat(folder, writer->temporary, folder, writer->base, 0) == 0 ? 0 : errno;
}

/* Gives the finished file its name: by a link if it is unnamed and the name is free, else by
 * rename. */
static int writer_publish(struct writer *writer)
{
    if (writer->temporary[0] == '\0') {
        int number = link_unnamed(writer, writer->base);
        if (number != EEXIST || !writer->force)
            return number;
        number = link_temporary(writer);
        if (number != 0)
            return number;
    }
    return rename_temporary(writer);
}

/* Ends writing: flushes, syncs, gives the file its name and syncs the folder. Returns false with
 * the first failure as the error; closes in every case. */
bool writer_commit(struct writer *writer, struct error *error)
{
    mode_t mode;
    writer_flush(writer);
    int number = writer->failed ? writer->failure : file_synced(writer->fd);
    if (number == 0)
        number = close_duplicate(writer->fd);
    const bool needs_name = writer->base != NULL; /* a file of a folder has its name already */
    bool done = number == 0 && (!needs_name || writer_allows(writer, &mode, error));
    if (done && needs_name) {
        number = mode != 0 && fchmod(writer->fd, mode) != 0 ? errno : writer_publish(writer);
        if (number == 0) {
            number = file_synced(writer->folder);
            if (number == EINVAL ||
                number == EBADF) /* a folder that cannot be synced, or was opened by O_PATH */
                number = 0;
        }
        done = number == 0;
    }
    if (number == EEXIST)
        writer_refuse_existing(writer, error);
    else if (number != 0)
        writer_refuse(writer, error, system_message(number));
    writer_abandon(writer);
    return done;
}

/* Opens, writes and commits a file. Returns false with the error set. */
bool file_write(const char *path, struct text content, struct write_policy policy,
                struct error *error)
{
    struct writer writer;
    if (!writer_open(&writer, path, policy, error))
        return false;
    writer_put(&writer, content);
    return writer_commit(&writer, error);
}

/* Closes the writer and removes its temporary file; may be called for one that is not open. */
void writer_abandon(struct writer *writer)
{
    if (!writer->path) /* not open, or all zeros: 0 would be the descriptor of somebody else */
        writer->fd = writer->folder = -1;
    if (writer->temporary[0] != '\0')
        unlinkat(writer->folder, writer->temporary, 0);
    if (writer->fd >= 0)
        close(writer->fd);
    if (writer->folder >= 0)
        close(writer->folder);
    free(writer->path);
    free(writer->chunk);
    *writer = (struct writer){.fd = -1, .folder = -1};
}
