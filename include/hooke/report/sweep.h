/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The points of a sweep in a file that grows until it is whole. */
#ifndef HOOKE_REPORT_SWEEP_H
#define HOOKE_REPORT_SWEEP_H

#include <hooke/report.h>

/*
 *   file    = [ rows ] { segment }     more than one: what was put together (cat)
 *   segment = head [ names ] rows
 *   head    = { "# KEY = VALUE" }      hooke, set-up (each of its lines), sweep, maybe shard
 *   names   = "point,...": of the columns, where point 0 belongs to the segment
 *   rows    = { row { row } mark }     of points that follow one another; at a section a point has
 *                                      as many rows as events
 *   mark    = "# points A to B of N: whole, sum H, sweep S", or "so far" for whole
 *
 * S is of the head without its shard, H of the rows and of S (marks without S: H is of that head
 * and the rows). What is whole has a mark at the end of each cell (sweep_cell), and a head only
 * where point 0 is: shards begin and end with cells, so that shards one after another have the
 * bytes of the whole, which depend on nothing but the sweep. Until it is whole a file has its head,
 * with the shard, and what a killed program leaves behind the last mark does not count.
 */
struct sweep_block {
    int64_t first, count; /* points */
    int64_t at, bytes;    /* of its rows and marks in the file */
    bool whole;
    int file; /* which one, for whoever looks at more than one */
};

struct sweep_file {
    const char *path;
    const struct cancel *cancel;
    struct buffer head, names;    /* of the first segment; the head without its shard */
    int64_t total, shard, shards; /* points of all shards, 0: no mark yet; shard of segment 1 */
    int segments;                 /* that have a head */
    bool ragged;                  /* marks are elsewhere than at the ends of cells */
    struct sweep_block *block;
    size_t blocks, capacity;
    int64_t end, size; /* [byte] of what counts, of the file */
    uint64_t seed;     /* S */
};

/* Reads and checks the file; what is behind the last mark, which may be rows only, is left out.
 * False: it is none, or was changed. sweep_file_free() in every case. */
bool sweep_file_read(int fd, struct sweep_file *file, struct error *error);
void sweep_file_free(struct sweep_file *file);
/* Sorts the blocks; false: a point is there twice, or outside of these. */
bool sweep_file_arrange(struct sweep_file *file, int64_t first, int64_t count, struct error *error);
/* The first of the missing points from `from` to `end`, and how many follow; blocks are sorted. */
bool sweep_file_gap(const struct sweep_file *file, int64_t from, int64_t end, int64_t *first,
                    int64_t *count);
uint64_t sweep_file_seed(struct text head);
/* [byte] of marks, for each point */
double sweep_file_mark_bytes(int64_t total);
/* Begins an empty one. */
bool sweep_file_begin(struct sweep_file *file, int fd, struct text head, struct text shard,
                      struct text names, struct error *error);
bool sweep_file_add(struct sweep_file *file, int fd, int64_t first, int64_t count, struct text rows,
                    struct error *error);
/* It has these points, and is as it is to be. */
bool sweep_file_is_whole(const struct sweep_file *file, int64_t first, int64_t count);
/* Puts it into another file; the writer is left open. Blocks are sorted and without gaps. */
bool sweep_file_make_whole(const struct sweep_file *file, int fd, struct text head,
                           struct text names, struct writer *writer, struct error *error);

/* `hooke --check-sweep FILE...`: whether these files together have each point once, unchanged.
 * Returns the exit status. */
int sweep_check(const char *const *path, int count, const struct cancel *cancel,
                struct reply *reply);

#endif
