/* SPDX-License-Identifier: GPL-3.0-or-later */
/* read: struct reader, which module_store.read() (<hooke/module.h>) receives when a session file is
 * read, so that a module can restore its part of the session. */
#pragma once

#include <hooke/session/log.h>
#include <hooke/session/stored.h>

/* A scene or list of events that was rebuilt from commands in the file, see reader.made. Private to
 * the module `resume`, as is struct read_run, a run as the file has it. */
struct made;
struct read_run;

/* A record of the file; `content` is a slice of the file's bytes. */
struct read_record {
    enum record_kind kind;
    struct text content;
};

/* State of reading a session file. Functions module_store.read() use only `session`, `arena`,
 * `state` and `places`; the other members are private to the module `resume`. */
struct reader {
    /* The session that is being restored. */
    struct session *session;
    /* Name of the file, for messages, and folder in which contents of other files are written. */
    const char *name, *temporary;
    /* Receives remarks for the user on what could not be restored, one per line. */
    struct buffer *notes;
    /* Memory that is freed when the file has been read. */
    struct arena arena;
    /* [records] valid records in the order of the file. */
    struct read_record *record;
    size_t records, record_capacity;
    struct read_run *run; /* [runs] runs of the file. */
    size_t runs, run_capacity;
    /* Content of the last record RECORD_STATE, a sequence of fields (<hooke/base/fields.h>). */
    struct text state;
    /* Maps parameters of the scene to their indices in the file's arrays. */
    struct field_places places;
    /* [mades] scenes and lists of events that have been rebuilt already from commands in the file.
     * They are used again for the same commands, so that runs that share a scene or events in the
     * session's file do so after it has been read, too. */
    struct made *made;
    size_t mades;
    /* Number of damaged records, which were skipped, and of records of unknown kinds. */
    size_t damaged, unknown;
};

/* ALL_END(type) initialises EXACT_NAMES items of a table of struct field (<hooke/base/fields.h>)
 * that describes members of a struct `type`, which has a member `exact`, a struct exact_names
 * (<hooke/session.h>). Each item, ENDS(type, i), describes the text exact.name[i], so that
 * fields_sound() returns false if the value from a file has a name that does not end in a NUL. */
#define ENDS(type, i) FIELD_OF(type, exact.name[i])
#define ALL_END(type)                                                                              \
    ENDS(type, 0), ENDS(type, 1), ENDS(type, 2), ENDS(type, 3), ENDS(type, 4), ENDS(type, 5),      \
        ENDS(type, 6), ENDS(type, 7)
