/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The points of a sweep in a file that grows until it is whole. */
#pragma once

#include <hooke/report.h>

struct cancel;
struct writer;

/*
 *   file  = { [ head ] { row } seal } [ begun { row } ]
 *   head  = { "# KEY = VALUE" } "point,..."     hooke, set-up (each of its lines), sweep; columns
 *   seal  = "# sweep S: N points in all, at most R rows each"      S: a sum of the head
 *   begun = "# unfinished, shard I/N"
 *
 * A row begins with the number of its point; at a section a point has up to R rows. What is whole
 * has its points in order, a seal at the end of each cell (sweep_cell) and a head only before
 * point 0: shards begin and end with cells, so that shards one after another have the bytes of the
 * whole, and each of them names its sweep. Behind `begun` are points of one shard in any order; of
 * the last one some rows may be missing, and of the last row its end.
 */
struct sweep_block {
    int64_t first, count; /* points */
    int64_t begin, end;   /* [byte] of its rows in the file */
};

struct sweep_file {
    const char *path;
    const struct cancel *cancel;
    struct buffer head, seal; /* as in the file; empty if missing */
    int64_t total, rows_max;  /* N and R of the seal */
    int64_t shard, shards;    /* I and N of an unfinished one */
    bool unfinished;
    int64_t heads, seals; /* number of heads and of seals */
    struct sweep_block *block;
    size_t blocks, capacity;
    int64_t end, size; /* [byte] end of the valid part, and size of the file */
};

/* Reads the file; points that may lack rows, at its end, do not count. The blocks are added to
 * those of `file`, which may be of several files of a sweep, or all 0. Returns false if it is none,
 * or is of another sweep. The caller calls sweep_file_free() in every case. */
bool sweep_file_read(int fd, struct sweep_file *file, struct error *error);
void sweep_file_free(struct sweep_file *file);
/* Sorts the blocks by their points. */
void sweep_file_sort(struct sweep_file *file);
/* Appends the seal of the sweep with that head. */
void sweep_seal(struct text head, int64_t total, int64_t rows_max, struct buffer *seal);
/* Appends lines to the file, and sets its end. */
bool sweep_file_put(struct sweep_file *file, int fd, struct text lines, struct error *error);
bool sweep_file_add(struct sweep_file *file, int fd, int64_t first, int64_t count, struct text rows,
                    struct error *error);
/* Returns true if it has these points, of one shard, in the bytes that it is to have. */
bool sweep_file_is_whole(const struct sweep_file *file, int64_t first, int64_t count);
/* Puts all into another file; the writer is left open. The blocks are sorted and without gaps. */
bool sweep_file_make_whole(const struct sweep_file *file, int fd, struct text head,
                           struct text seal, struct writer *writer, struct error *error);

/* Checks whether the files together have each point once (`hooke --check-sweep FILE...`). Returns
 * the exit status. */
int sweep_check(struct session *session, const char *const *path, int count, struct reply *reply);
