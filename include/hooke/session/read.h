/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A session file while it is read. */
#pragma once

#include <hooke/session/log.h>
#include <hooke/session/stored.h>

struct made; /* private, as the next two */
struct read_run;

struct read_record {
    enum record_kind kind;
    struct text content;
};

struct reader {
    struct session *session;
    const char *name, *temporary; /* name of the file; folder for other files */
    struct buffer *notes;
    struct arena arena;
    struct read_record *record; /* that count, in order */
    size_t records, record_capacity;
    struct read_run *run;
    size_t runs, run_capacity;
    struct text state;          /* the last S */
    struct field_places places; /* indices of the parameters of its scene */
    struct made *made;
    size_t mades;
    size_t damaged, unknown;
};

/* That the names of an item's `exact` end. */
#define ENDS(type, i) FIELD_OF(type, exact.name[i])
#define ALL_END(type)                                                                              \
    ENDS(type, 0), ENDS(type, 1), ENDS(type, 2), ENDS(type, 3), ENDS(type, 4), ENDS(type, 5),      \
        ENDS(type, 6), ENDS(type, 7)
