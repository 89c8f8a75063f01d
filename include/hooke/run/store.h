/* SPDX-License-Identifier: GPL-3.0-or-later */
/* store: a run as bytes in a session file. run_store() writes all but scene, method and rows,
 * run_store_rows() the rows, in pieces; run_restore() makes the run again. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/run.h>

/* A piece of consecutive rows in the bytes that run_store_rows() wrote. */
struct stored_rows {
    /* Index of the first row, number of rows, and bytes per row. */
    size_t first, count, row_bytes;
    /* First byte of the first row; owned by the caller. */
    const char *cursor;
};

/* Appends all of a run but scene, method and rows, as fields (<hooke/base/fields.h>). */
void run_store(const struct run *run, struct buffer *output);
/* Returns the number of recorded rows, without the current state. */
size_t run_recorded(const struct run *run);
/* Returns the number of bytes of a stored row. */
size_t run_row_bytes(const struct run *run);
/* Appends the rows first to first + count - 1. */
void run_store_rows(const struct run *run, size_t first, size_t count, struct buffer *output);
/* Returns how many of the first rows are in the file and unchanged since run_set_stored(); 0 before
 * its first call. */
size_t run_rows_stored(const struct run *run);
/* Notes that the first `rows` rows are in the file, so that run_rows_stored() returns this number
 * until rows change. */
void run_set_stored(struct run *run, size_t rows);
/* Restores a run, bit for bit, so that it continues as it would have; only an external solver,
 * which has memory of its own, starts afresh. Nothing is computed again. `scene` is the scene at
 * the start, `fields` the bytes that run_store() wrote, `places` maps the scene's parameters to
 * their indices in the file, and piece [pieces] are all rows in order. Returns NULL, with `error`
 * set, if they are not a valid run; free the result by run_destroy(). */
struct run *run_restore(const struct scene *scene, const struct method *method, struct text fields,
                        const struct field_places *places, const struct stored_rows *piece,
                        size_t pieces, struct error *error);
