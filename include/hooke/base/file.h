/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * file: files and folders that are read, written whole, or appended to.
 *
 * Reading appends the whole file, up to `limit` bytes, from regular files, pipes and links. A
 * failure leaves `content` unchanged; a signal ends the reading with ERROR_CANCELLED (its handler
 * must be installed without SA_RESTART). Writing goes to an unnamed temporary file in the same
 * folder, which writer_commit puts in place after flush, fsync and close have all succeeded. An
 * existing name is refused without `force`; a link, a directory or a device is never written
 * through. A killed program leaves the old file or none.
 */
#pragma once

#include <hooke/base/error.h>

bool file_read(const char *path, size_t limit, struct buffer *content, struct error *error);

/* Looks at what is read, as it comes in, so that a file that is not wanted costs no more than its
 * beginning. */
struct read_watch {
    void *context;
    /* Is called after every piece with what has been read, where the piece begins, and the size
     * [byte] of the file, 0 if it is not known. Returns false with `error` set to stop. */
    bool (*look)(void *context, struct text content, size_t piece_begin, uintmax_t size,
                 struct error *error);
    /* Time [ns] within which a pipe or a device has to end, unless it is fast. 0 means any time. */
    int64_t patience;
    bool grew;    /* is set if the file grew meanwhile; `content` is what it held at first */
    bool endless; /* is set if it did not end in time */
};

/* This path stands for standard input, whatever that is. */
#define STANDARD_INPUT "/dev/stdin"

/* Does the same as file_read(), with a watch. */
bool file_read_watched(const char *path, size_t limit, struct read_watch *watch,
                       struct buffer *content, struct error *error);

#define STRAY_NAME_SIZE 256 /* [byte] of a hidden name */
/* Marks of a file that is to replace another, and of one that is to be removed then. */
enum { STRAY_NEW = '.', STRAY_OLD = '~' };

/* Makes a hidden name: ".hooke-", a random number, `mark`, and as much of `base` as fits. The file
 * stands beside the one it replaces, and is locked while it is written. */
bool stray_name(char name[STRAY_NAME_SIZE], const char *base, char mark);
/* Removes files with such names that killed programs have left in a folder. */
void strays_sweep_path(const char *path);

struct writer {
    int fd, folder;                  /* -1 if closed */
    char *path;                      /* as the user gave it */
    char *base;                      /* last component (points into path) */
    char temporary[STRAY_NAME_SIZE]; /* name in the folder, "" while unnamed */
    bool force, failed;
    char *chunk; /* write-behind buffer */
    size_t used;
    int failure; /* errno of the first failure */
};

struct write_policy {
    bool force;   /* replace an existing regular file */
    bool confine; /* only below the current directory (--safe) */
    bool refuse;  /* write nothing at all */
    bool secret;  /* make a folder that only the user can open */
};

bool writer_open(struct writer *writer, const char *path, struct write_policy policy,
                 struct error *error);
/* Appends text; writer_commit() reports a failure. */
void writer_put(struct writer *writer, struct text text);
bool writer_commit(struct writer *writer, struct error *error); /* closes in every case */
void writer_abandon(struct writer *writer);
/* Opens, writes and commits a file. */
bool file_write(const char *path, struct text content, struct write_policy policy,
                struct error *error);

/* Writes all of *text, also after signals and partial writes. Returns 0, or an errno with what is
 * left in *text. */
int file_put(int fd, struct text *text);
/* Locks a whole file for this process until it is closed. wait: for up to 0.2 s, or a signal, if
 * another process holds it. Returns false if it is locked. */
bool file_lock(int fd, bool wait);
void file_unlock(int fd);

/*
 * Opens a file that grows by whole lines, never through a link, a pipe or a device. `mode` holds
 * the access rights of a new file. Returns its descriptor, or -1 with `error` set.
 */
int append_open(const char *path, struct write_policy policy, unsigned mode, struct error *error);
/* Appends lines; sync: waits until they are on the disk. Returns false with the file as it was and
 * `error` set, which does not name the file. */
bool append_lines(int fd, struct text lines, bool sync, struct error *error);

/*
 * A folder of files that is written whole or not at all: it is filled under a hidden name, and
 * folder_commit() renames it after every file is on the disk. An existing folder is replaced only
 * with `force`, and only if it holds nothing but regular files for whose names `own` returns true.
 * A killed program leaves the old folder, the new one or none, and perhaps a hidden one, which the
 * next folder_open() beside it removes or puts back.
 */
typedef bool folder_owns(const char *name);

struct folder {
    struct writer writer; /* destination */
    int fd;               /* -1 if closed */
    folder_owns *own;
};

/* Trailing slashes in the path do not matter. */
bool folder_open(struct folder *folder, const char *path, struct write_policy policy,
                 folder_owns *own, struct error *error);
bool folder_put(struct folder *folder, const char *name, struct text content, struct error *error);
bool folder_commit(struct folder *folder, struct error *error); /* closes in every case */
void folder_abandon(struct folder *folder);
