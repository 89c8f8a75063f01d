/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session file while it is read. */
#ifndef HOOKE_SESSION_READ_H
#define HOOKE_SESSION_READ_H

#include <hooke/run/store.h>
#include <hooke/session/log.h>
#include <hooke/session/stored.h>

struct read_run {
    uint64_t id;
    struct text content; /* of its last R; empty: damaged */
    struct stored_rows *piece;
    size_t pieces, piece_capacity;
};

struct read_record {
    enum record_kind kind;
    struct text content;
};

/* Scenes and events that were made already: what reads the same is the same. */
struct made {
    struct text script;
    const struct model *model;
    const struct preset *preset;
    const struct events *events;
    bool is_events;
};

struct reader {
    struct session *session;
    const struct restorer *restorer;
    struct buffer *notes;
    struct arena arena;
    struct read_record *record; /* that count, in order */
    size_t records, record_capacity;
    struct read_run *run;
    size_t runs, run_capacity;
    struct text state;          /* the last S */
    struct field_places places; /* of the parameters of its scene */
    struct made *made;
    size_t mades, made_capacity;
    size_t damaged, unknown;
};

/* A line of the notes. */
void reader_note(struct reader *reader, const char *format, ...) PRINTF_LIKE(2, 3);

/* scan.c: all records that count, rows and runs by id. False: no memory, or no S. */
bool reader_scan(struct reader *reader, struct text content, struct error *error);
struct read_run *reader_run(struct reader *reader, uint64_t id); /* NULL: not there */

/* places.c */
/* Finds where the file has the parameters of a scene that it calls `of`. */
bool reader_places(struct text of, const struct scene *scene, struct field_places *places);
/* Moves the items of an array [PARAM_MAX], of at most 8 bytes each, from where the file has them.
 */
void reader_move(const struct field_places *places, void *array, size_t item);
/* Returns the bytes of an element of an array in the file. */
size_t reader_item(struct text in, size_t item);
/* Reads an element by its members; others are 0. Returns false if the file does not say which it
 * has, and has another number of bytes. */
bool reader_members(struct text in, const struct field *member, size_t members, struct text stored,
                    size_t item, void *to);

/* pieces.c */
/* Reads a scene; places: of its parameters in the file, or NULL. */
bool reader_scene(struct reader *reader, struct text in, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error);
/* So that the next one that reads the same is this one. */
void reader_made(struct reader *reader, struct text script, const struct scene *scene);
bool reader_events(struct reader *reader, struct text in, const struct events **events,
                   struct error *error);
void reader_runs(struct reader *reader, struct text ids);
void reader_recordings(struct reader *reader);
/* The bytes that the file has under that sum. */
bool reader_bytes(const struct reader *reader, uint64_t sum, struct text *content);

/* sound.c: whether what was read can stand in a session. */
bool sound_setting(const struct setting *setting, const struct settings *settings);
bool sound_item(const struct store_array *array, const void *item);
bool sound_fit(const struct fit *fit);
bool sound_adopted(const struct adopted_fit *adopted);
bool sound_scene(const struct scene *scene);
bool sound_view(const struct view *view);
bool sound_field(const struct recording_field *field, struct text value);
bool sound_asked(const struct asked *asked, const struct scene *scene);

#endif
