/* SPDX-License-Identifier: GPL-3.0-or-later */
/* read: the state of reading a session file, as the functions see it by which modules read their
 * parts of the file (struct module_store in <hooke/module.h>). */
#pragma once

#include <hooke/session/log.h>
#include <hooke/session/stored.h>

struct made; /* Private to the module `resume`, as is struct read_run. */
struct read_run;

/* A record of the file, as a slice of its bytes. */
struct read_record {
    enum record_kind kind;
    struct text content;
};

/* State of reading a session file. Modules use only `session`, `arena`, `state` and `places`. */
struct reader {
    /* The session that is being restored. */
    struct session *session;
    /* Name of the file, for messages, and folder in which contents of other files are written. */
    const char *name, *temporary;
    /* Receives remarks for the user on what could not be restored. */
    struct buffer *notes;
    /* Memory of the reading. */
    struct arena arena;
    struct read_record *record; /* [records] valid records in order. */
    size_t records, record_capacity;
    struct read_run *run;
    size_t runs, run_capacity;
    struct text state; /* Content of the last record RECORD_STATE. */
    /* Maps parameters of the scene to their indices in the file's arrays. */
    struct field_places places;
    struct made *made;
    size_t mades;
    /* Number of damaged records, which were skipped, and of records of unknown kinds. */
    size_t damaged, unknown;
};

/* ENDS(type, i) is a struct field that describes exact.name[i] of a struct `type` with a member
 * `struct exact_names exact`. The array is stored as bytes by another field; these fields let
 * fields_sound() check that each of its names ends in a NUL. ALL_END(type) lists them for all
 * EXACT_NAMES names. */
#define ENDS(type, i) FIELD_OF(type, exact.name[i])
#define ALL_END(type)                                                                              \
    ENDS(type, 0), ENDS(type, 1), ENDS(type, 2), ENDS(type, 3), ENDS(type, 4), ENDS(type, 5),      \
        ENDS(type, 6), ENDS(type, 7)
