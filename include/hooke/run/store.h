/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A run as bytes: what a session file keeps of it. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/run.h>

struct stored_rows { /* consecutive rows, as run_store_rows() gives them */
    size_t first, count, row_bytes;
    const char *cursor;
};

/* All but scene, method and rows, as fields (hooke/base/fields.h). */
void run_store(const struct run *run, struct buffer *output);
size_t run_recorded(const struct run *run); /* that are recorded, as they are stored */
size_t run_row_bytes(const struct run *run);
void run_store_rows(const struct run *run, size_t first, size_t count, struct buffer *output);
/* Rows that have not changed since somebody said that so many are stored; 0 at first. */
size_t run_rows_stored(const struct run *run);
void run_set_stored(struct run *run, size_t rows);
/*
 * Restores a run bit for bit, so that it continues as it would have; only an external solver, whose
 * memory is its own, begins anew there. Nothing of the run is computed again. `scene` is the scene
 * at the start, `places` has the indices of its parameters in the file, and piece [pieces] are all
 * the rows, in order. Returns NULL, with an error, if they do not make a run.
 */
struct run *run_restore(const struct scene *scene, const struct method *method, struct text fields,
                        const struct field_places *places, const struct stored_rows *piece,
                        size_t pieces, struct error *error);
