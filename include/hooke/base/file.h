/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * file: reads files, writes files and folders that appear only when they are complete, and appends
 * to files.
 *
 * A file is read by file_read(), and written by writer_open(), any number of writer_put(), then
 * writer_commit() or writer_abandon(). The bytes go to a temporary file in the same folder, which
 * gets its name after flush, fsync and close have all succeeded. An existing name is refused
 * without `force`; a symbolic link, a directory or a device is never written through. A killed
 * program leaves the old file or none. A folder is written by folder_open(), folder_put() for each
 * file, then folder_commit() or folder_abandon(). A file is appended to by append_open(),
 * append_lines() and close().
 */
#pragma once

#include <hooke/base/error.h>

/* Appends a file of at most `limit` bytes to `content`; pipes, devices and links are read, too.
 * Returns false, with `content` unchanged and `error` set, if that fails. A signal ends the reading
 * with ERROR_CANCELLED if its handler was installed without SA_RESTART. */
bool file_read(const char *path, size_t limit, struct buffer *content, struct error *error);

/* Callback that sees a file while it is read, and that can stop the reading of an unwanted file
 * early. */
struct read_watch {
    /* Argument of look(). */
    void *context;
    /* Called after every piece of at most 16 kB. `content` is everything read so far, piece_begin
     * the offset [byte] of the last piece in it, `size` the size [byte] of the file, or 0 if
     * unknown. Returns false with `error` set to stop reading. */
    bool (*look)(void *context, struct text content, size_t piece_begin, uintmax_t size,
                 struct error *error);
    /* Time [ns] after which the reading of a pipe or a device fails, unless more than 64 kB have
     * arrived by then. 0 means that there is no such limit. */
    int64_t patience;
    /* Set to true by the reader if the file grew while it was read; `content` then has its length
     * at the start. */
    bool grew;
    bool endless; /* Set to true by the reader if it failed because of `patience`. */
};

/* Path by which file_read() reads standard input. */
#define STANDARD_INPUT "/dev/stdin"

/* Reads a file as file_read() does, and calls watch->look() after each piece; `watch` may be NULL.
 */
bool file_read_watched(const char *path, size_t limit, struct read_watch *watch,
                       struct buffer *content, struct error *error);

#define STRAY_NAME_SIZE 256 /* Size [byte] of a hidden temporary name with its NUL. */
/* Values of `mark` below: STRAY_NEW for a file that will replace another or be new, STRAY_OLD for
 * one that has been replaced and will be removed. */
enum { STRAY_NEW = '.', STRAY_OLD = '~' };

/* Makes the name of a temporary file: ".hooke-", a random number, `mark`, and as much of `base` as
 * fits. Such a file lies in the folder of the file that it replaces and is locked while it is
 * written. Returns false, with errno set, if there are no random numbers. */
bool stray_name(char name[STRAY_NAME_SIZE], const char *base, char mark);
/* Removes temporary files and folders that killed programs have left in the folder `path`. Failures
 * are ignored. */
void strays_sweep_path(const char *path);

/* A file that is being written. writer_commit() and writer_abandon() free all that it owns. */
struct writer {
    /* Descriptors of the file and of its folder, -1 if closed. */
    int fd, folder;
    char *path; /* Path as given by the user; owned. */
    char *base; /* Last component of the path; points into `path`. */
    /* Name of the temporary file in the folder, or "" if it has no name yet. */
    char temporary[STRAY_NAME_SIZE];
    /* An existing file may be replaced (`force`); a write has failed (`failed`). */
    bool force, failed;
    char *chunk; /* Buffer of bytes not yet written, of which `used` are filled; owned. */
    size_t used;
    int failure; /* errno of the first failed write, or 0. */
};

/* Rules for writing. All false is the default. */
struct write_policy {
    /* An existing regular file may be replaced, or a folder of which folder_owns() accepts all
     * files. */
    bool force;
    bool confine; /* Only names below the current directory are allowed (option --safe). */
    bool refuse;  /* Nothing may be written: opening always fails. */
    bool secret;  /* A new folder gets access rights for the user alone. */
};

/* Opens a temporary file that will become `path`. Returns false, with `error` set and nothing to
 * close, if the policy or the file system does not allow it. */
bool writer_open(struct writer *writer, const char *path, struct write_policy policy,
                 struct error *error);
/* Appends text. Does nothing after a failure, which writer_commit() reports. */
void writer_put(struct writer *writer, struct text text);
/* Completes the file, gives it its name and frees the writer. Returns false, with `error` set and
 * no new file, on any failure. */
bool writer_commit(struct writer *writer, struct error *error);
/* Removes the temporary file and frees the writer. Does nothing if it is not open. */
void writer_abandon(struct writer *writer);
/* Writes a whole file: writer_open(), writer_put() and writer_commit(). Returns false with `error`
 * set. */
bool file_write(const char *path, struct text content, struct write_policy policy,
                struct error *error);

/* Writes all of *text to a descriptor, continuing after signals and partial writes. Returns 0, or
 * an errno with the unwritten remainder in *text. */
int file_put(int fd, struct text *text);
/* Locks a file for this process until it is closed. If another process has locked it, waits for at
 * most 0.2 s, or until a signal, if `wait` is true. Returns false if the file could not be locked.
 */
bool file_lock(int fd, bool wait);
/* Releases the lock of file_lock(). */
void file_unlock(int fd);

/* Opens or creates a file to which whole lines are appended; links, pipes and devices are refused.
 * A new file gets the access rights `mode`, such as 0600. Returns its descriptor, which the caller
 * closes, or -1 with `error` set. */
int append_open(const char *path, struct write_policy policy, unsigned mode, struct error *error);
/* Appends lines, after a newline if the file ends in an incomplete line; with `sync`, waits until
 * they are on the disk. Returns false with `error` set, whose message does not name the file; what
 * was written is removed again unless somebody else has written since. */
bool append_lines(int fd, struct text lines, bool sync, struct error *error);

/* A folder of files that appears only when it is complete: it is filled under a hidden name, and
 * folder_commit() renames it after every file is on the disk. An existing folder is replaced only
 * with `force`, and only if all it contains are regular files for whose names `own` returns true. A
 * killed program leaves the old folder, the new one or none, and perhaps a hidden one, which the
 * next folder_open() in the same parent removes or renames back. */

/* Returns true if a file of this name may be deleted together with its folder. */
typedef bool folder_owns(const char *name);

/* A folder that is being filled. folder_commit() and folder_abandon() free all that it owns. */
struct folder {
    struct writer writer; /* Path of the folder and its hidden name. */
    int fd;               /* Descriptor of the hidden folder, -1 if closed. */
    /* Decides which files of an existing folder may be replaced. */
    folder_owns *own;
};

/* Makes the hidden folder that will become `path`, whose trailing slashes are ignored. Returns
 * false, with `error` set and nothing to close, if that is not allowed or fails. */
bool folder_open(struct folder *folder, const char *path, struct write_policy policy,
                 folder_owns *own, struct error *error);
/* Writes a file in the folder; `name` must be new. Returns false with `error` set; the folder stays
 * open. */
bool folder_put(struct folder *folder, const char *name, struct text content, struct error *error);
/* Gives the folder its name and frees the struct. Returns false, with `error` set and no new
 * folder, on any failure. */
bool folder_commit(struct folder *folder, struct error *error);
/* Removes the hidden folder with its files and frees the struct. Does nothing if it is not open. */
void folder_abandon(struct folder *folder);
