/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that writing and reading of session files share: heads of records, tables of
 * stored members, and the stages of reading (scan.c, restore.c, pieces.c). */
#pragma once

#include "modules/resume/store.h"

#include <hooke/run/store.h>
#include <hooke/session/read.h>

#define RECORD_MAGIC "\xF0HR\n" /* bytes at which each record begins */

/* Head of a record, as it is in the file. */
struct record_head {
    char magic[4];
    uint32_t kind;
    uint64_t bytes, sum, own; /* size and checksum of the content; checksum of all before `own` */
};

/* Begin of the content of a record of rows: id of the run, first row, number of rows, and size of
 * each. */
struct rows_head {
    uint64_t id, first, count, row_bytes;
};

/* A run as the file has it. */
struct read_run {
    uint64_t id;
    struct text content;       /* content of its last record R, or empty if damaged */
    struct stored_rows *piece; /* [pieces] its rows, in consecutive pieces */
    size_t pieces, piece_capacity;
};

/* A scene, or events, that were made from commands already and are used for the same commands
 * again. */
struct made {
    struct text script;        /* the commands, in the reader's arena */
    const struct model *model; /* these two are of a scene */
    const struct preset *preset;
    const struct events *events;
    bool is_events; /* events were made, no scene */
};

/* Tables of the members that a file has (state.c). */
extern const struct field store_session[], store_view[], store_request[];
extern const size_t store_session_count, store_view_count, store_request_count;
extern const struct store_array store_arrays[]; /* arrays of a session */
extern const size_t store_array_count;

/* Functions in state.c append fields of a record. `owner` is the struct that the array's offsets
 * refer to. */
void store_put_array(const struct store_array *array, const void *owner, struct buffer *output);
void store_put_scene(const struct scene *scene, const char *name, struct buffer *output);
void store_put_events(const struct events *events, struct buffer *output);
void store_put_state(const struct session *session, struct buffer *output);

/* Adds a line to the notes on what could not be restored. */
void reader_note(struct reader *reader, const char *format, ...) PRINTF_LIKE(2, 3);

/* Collects all valid records up to the last S, and rows and runs by id (scan.c). Returns false with
 * an error if out of memory or if there is no S. */
bool reader_scan(struct reader *reader, struct text content, struct error *error);
/* Returns the run of that id, or NULL if the file has none. */
struct read_run *reader_run(struct reader *reader, uint64_t id);

/* restore.c */
/* Executes commands, one per line. Stops at the first that fails, and returns false with its
 * error. */
bool reader_execute(struct reader *reader, struct text commands, struct error *error);
/* Reads an array of the state into `owner`. It is unchanged, with a note, if an element cannot be
 * read. */
void reader_array(struct reader *reader, const struct store_array *array, void *owner);

/* pieces.c */
/* Reorders an array [PARAM_MAX] with one item per parameter, of at most 8 bytes each, from the
 * order of the file to that of the program. */
void reader_move(const struct field_places *places, void *array, size_t item);
/* Reads the scene in the field `name` of a text. `places`, unless NULL, receives the positions of
 * its parameters in the file. Returns false with an error. */
bool reader_scene(struct reader *reader, struct text text, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error);
/* Remember a scene, or events, for later ones with the same commands. */
void reader_made_scene(struct reader *reader, const struct scene *scene);
void reader_made_events(struct reader *reader, const struct events *events);
/* Adds the runs with these ids, in this order, to the session; those that cannot be restored are
 * noted. */
void reader_runs(struct reader *reader, struct text ids);
/* Adds the recordings of the state to the session; those that cannot be restored are noted. */
void reader_recordings(struct reader *reader);
/* Finds the bytes that the file has under that checksum. Returns false if it has none. */
bool reader_bytes(const struct reader *reader, uint64_t sum, struct text *content);
