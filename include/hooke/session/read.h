/* SPDX-License-Identifier: GPL-3.0-or-later */
/* read: the state of reading a session file, for module functions that read a module's part of it
 * (struct module_store in <hooke/module.h>). */
#pragma once

#include <hooke/session/log.h>
#include <hooke/session/stored.h>

struct made; /* private, as the next two */
struct read_run;

/* A record of the file, as a slice of its bytes. */
struct read_record {
    enum record_kind kind;
    struct text content;
};

/* State of reading. Functions of modules use `session`, `arena`, `state` and `places`. */
struct reader {
    /* The session that is being restored. */
    struct session *session;
    const char *name, *temporary; /* Name of the file, and folder for other files. */
    /* Receives remarks for the user on what could not be restored. */
    struct buffer *notes;
    /* Memory of the reading. */
    struct arena arena;
    struct read_record *record; /* [records] valid records in order. */
    size_t records, record_capacity;
    struct read_run *run;
    size_t runs, run_capacity;
    struct text state;          /* Content of the last record RECORD_STATE. */
    struct field_places places; /* Indices in the file of the parameters of its scene. */
    struct made *made;
    size_t mades;
    /* Numbers of damaged records, and of those of unknown kinds. */
    size_t damaged, unknown;
};

/* Fields of an item's `exact.name[i]`, which check that the names are NUL-terminated. */
#define ENDS(type, i) FIELD_OF(type, exact.name[i])
#define ALL_END(type)                                                                              \
    ENDS(type, 0), ENDS(type, 1), ENDS(type, 2), ENDS(type, 3), ENDS(type, 4), ENDS(type, 5),      \
        ENDS(type, 6), ENDS(type, 7)
