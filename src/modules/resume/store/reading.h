/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared by writing and reading of session files: heads of records, tables of what is kept. */
#pragma once

#include "modules/resume/store.h"

#include <hooke/run/store.h>
#include <hooke/session/read.h>

#define RECORD_MAGIC "\xF0HR\n"

struct record_head {
    char magic[4];
    uint32_t kind;
    uint64_t bytes, sum, own; /* own is the checksum of the three members before it */
};

struct rows_head {
    uint64_t id, first, count, row_bytes;
};

struct read_run {
    uint64_t id;
    struct text content; /* content of its last R, or empty if damaged */
    struct stored_rows *piece;
    size_t pieces, piece_capacity;
};

/* Scenes and events that were made already: what reads the same is the same. */
struct made {
    struct text script;
    const struct model *model;
    const struct preset *preset;
    const struct events *events;
    bool is_events;
};

/* Tables of members that a file keeps (state.c). */
extern const struct field store_session[], store_view[], store_request[];
extern const size_t store_session_count, store_view_count, store_request_count;
extern const struct store_array store_arrays[]; /* arrays of a session */
extern const size_t store_array_count;

/* Functions in state.c write fields of a record. `owner` is the struct that the array's offsets
 * refer to. */
void store_put_array(const struct store_array *array, const void *owner, struct buffer *output);
void store_put_scene(const struct scene *scene, const char *name, struct buffer *output);
void store_put_events(const struct events *events, struct buffer *output);
void store_put_state(const struct session *session, struct buffer *output);

/* A line of the notes. */
void reader_note(struct reader *reader, const char *format, ...) PRINTF_LIKE(2, 3);

/* Collects all valid records, and rows and runs by id (scan.c). Returns false if out of memory
 * or if there is no S. */
bool reader_scan(struct reader *reader, struct text content, struct error *error);
/* Returns NULL if it is not there */
struct read_run *reader_run(struct reader *reader, uint64_t id);

/* restore.c */
/* Executes the lines; the first that fails ends it. */
bool reader_execute(struct reader *reader, struct text commands, struct error *error);
/* Reads an array into `owner`, where its offsets begin; unchanged if one of its elements cannot be
 * read. */
void reader_array(struct reader *reader, const struct store_array *array, void *owner);

/* pieces.c */
/* Moves the items of an array [PARAM_MAX], of at most 8 bytes each, from where the file has them.
 */
void reader_move(const struct field_places *places, void *array, size_t item);
/* Reads a scene; `places` receives the positions of its parameters in the file; it may be NULL. */
bool reader_scene(struct reader *reader, struct text text, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error);
/* So that the next scene, or events, that read the same are these. */
void reader_made_scene(struct reader *reader, const struct scene *scene);
void reader_made_events(struct reader *reader, const struct events *events);
void reader_runs(struct reader *reader, struct text ids);
void reader_recordings(struct reader *reader);
/* The bytes that the file has under that sum. */
bool reader_bytes(const struct reader *reader, uint64_t sum, struct text *content);
