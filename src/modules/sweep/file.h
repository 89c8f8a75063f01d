/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The points of a sweep in a file that grows until it is complete (`sweep --resume FILE`). To add
 * points call sweep_file_read(), sweep_file_add() for each piece, sweep_file_sort(),
 * sweep_file_make_whole(), sweep_file_free(). */
#pragma once

#include <hooke/report.h>

struct cancel;
struct writer;

/* A run of consecutive points whose rows follow each other in a file. */
struct sweep_block {
    int64_t first, count; /* number of the first point, and how many there are */
    int64_t begin, end;   /* [byte] begin and end of their rows in the file */
};

/* The contents of a file of a sweep, or of several files of one sweep together. */
struct sweep_file {
    const char *path;
    const struct cancel *cancel;
    struct buffer head, seal;  /* text of head and seal, empty if the file has none; owned */
    int64_t total, rows_max;   /* N and R of the seal, 0 without a seal */
    int64_t shard, shards;     /* I and N of an unfinished file, otherwise 1 */
    bool unfinished;           /* the file has a line `begun` */
    int64_t heads, seals;      /* number of heads and of seals */
    struct sweep_block *block; /* [blocks] owned */
    size_t blocks, capacity;
    int64_t end, size; /* [byte] end of the valid part, and size of the file */
};

/* Reads a file. A last point of which rows may be missing is left out. Blocks are added to those of
 * `file`, which is zeroed but for path and cancel, or already holds other files of the same sweep.
 * Returns false with an error if this is no file of a sweep, if it belongs to another sweep, cannot
 * be read, or if cancelled. sweep_file_free() must be called in any case. */
bool sweep_file_read(int fd, struct sweep_file *file, struct error *error);
/* Frees what the structure owns, not the structure. */
void sweep_file_free(struct sweep_file *file);
/* Sorts the blocks by their points. */
void sweep_file_sort(struct sweep_file *file);
/* Appends to `seal` the seal of the sweep with that head. */
void sweep_seal(struct text head, int64_t total, int64_t rows_max, struct buffer *seal);
/* Appends lines to the file and moves its end. Returns false with an error if they cannot be
 * written. */
bool sweep_file_put(struct sweep_file *file, int fd, struct text lines, struct error *error);
/* Appends the rows of some points and adds a block for them. Returns false with an error as
 * sweep_file_put() does, or if out of memory. */
bool sweep_file_add(struct sweep_file *file, int fd, int64_t first, int64_t count, struct text rows,
                    struct error *error);
/* Returns true if the file is complete: it has exactly these points in order, with heads and seals
 * where they belong. */
bool sweep_file_is_whole(const struct sweep_file *file, int64_t first, int64_t count);
/* Copies all points in order, with head and seals, to the writer, which the caller commits. The
 * blocks must be sorted and without gaps. Returns false with an error if the file cannot be read or
 * if cancelled. */
bool sweep_file_make_whole(const struct sweep_file *file, int fd, struct text head,
                           struct text seal, struct writer *writer, struct error *error);

/* Executes `hooke --check-sweep FILE...`: checks that the files together have each point of their
 * sweep once, and replies. Returns the exit status, 0 if they do. */
int sweep_check(struct session *session, const char *const *path, int count, struct reply *reply);
