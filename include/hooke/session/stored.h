/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What writing and reading of session files share: the tables of what they keep. */
#ifndef HOOKE_SESSION_STORED_H
#define HOOKE_SESSION_STORED_H

#include <hooke/base/fields.h>
#include <hooke/session/store.h>

#define RECORD_MAGIC "\xF0HR\n"

enum record_kind {
    RECORD_BYTES = 'D',
    RECORD_RUN = 'R',
    RECORD_ROWS = 'W',
    RECORD_LINES = 'L',
    RECORD_SAID = 'T',
    RECORD_FOUND = 'B',
    RECORD_STATE = 'S',
};

struct record_head {
    char magic[4];
    uint32_t kind;
    uint64_t bytes, sum, own; /* own: of the three before it */
};

struct rows_head {
    uint64_t id, first, count, row_bytes;
};

/* A request of a run's journal, without its condition. */
struct asked {
    int32_t kind, param, by_event, conditioned;
    int64_t from, end, met, rows;
    double from_t, t;
    struct measured value;
};

extern const struct field store_session[], store_view[], store_lesson[];
extern const size_t store_session_count, store_view_count, store_lesson_count;

/* Arrays of the session that have no pointers in them: a field each, and its count. */
struct store_array {
    const char *name;
    size_t offset, item;        /* of the array, bytes of an element */
    size_t count;               /* offset of the int */
    int max;                    /* 0: the array is allocated */
    const struct field *member; /* [members] of an element, all of them */
    size_t members;
};

extern const struct field store_entry[]; /* of struct entry */
extern const size_t store_entry_count;

/* Writes which bytes of an element each member has, and the names of quantities in their order. */
void store_put_members(const struct field *member, size_t count, struct buffer *to);

enum { STORE_LETS, STORE_RESULTS, STORE_MEASUREMENTS, STORE_FITS };
extern const struct store_array store_arrays[];
extern const size_t store_array_count;

/* state.c: fields of a record. */
void store_put_scene(const struct scene *scene, const char *name, struct buffer *to);
void store_put_events(const struct events *events, struct buffer *to);
void store_put_state(const struct session *session, struct buffer *to);

#endif
