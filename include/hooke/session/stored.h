/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Content that a session file keeps of the parts of modules. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* lists of equilibria, orbits and branches together */
#define STORE_FOUND (1 + LIMIT_ORBITS + LIMIT_BRANCHES)

/* Content of a file for a session; all zeros if there is nothing yet. */
struct stored {
    struct stored_run *run;
    int runs, run_capacity;
    uint64_t recording[LIMIT_RECORDINGS]; /* sums */
    int recordings;
    uint64_t found_id[STORE_FOUND]; /* [found] identifiers of the results that the file has */
    int found;
    uint64_t content;     /* its checksum; 0 if there is none */
    size_t entries, text; /* entries and bytes of session->history */
    uint64_t said;        /* lines of session->log */
    uint64_t state;       /* sum of the last S */
    uint64_t bytes;       /* written */
    int left_out;         /* runs whose rows found no room */
    struct buffer record; /* the last one, of which `sent` bytes are written */
    size_t sent;
    bool unfinished; /* saving was stopped; the next call continues where this one ended */
};

enum record_kind {
    RECORD_BYTES = 'D',
    RECORD_RUN = 'R',
    RECORD_ROWS = 'W',
    RECORD_LINES = 'L',
    RECORD_SAID = 'T',
    RECORD_FOUND = 'B',
    RECORD_STATE = 'S',
};

/* An array of a session, or of a module's part of one: a field for each element. */
struct store_array {
    const char *name;
    size_t offset, item;        /* offset of the array, bytes of an element */
    size_t count;               /* offset of the int */
    int max;                    /* 0 if the array is allocated */
    const struct field *member; /* [members] of an element that are kept; others are 0 */
    size_t members;
    /* Returns true if an element that was read is valid in a session, beyond what its fields check;
     * or NULL. */
    bool (*sound)(const void *item);
};
#define STORE_ARRAY(name, owner, array, counted, limit, members, sound)                            \
    {                                                                                              \
        name, offsetof(owner, array), sizeof *((owner *)0)->array, offsetof(owner, counted),       \
            limit, members, COUNT_OF(members), sound                                               \
    }

/* Functions that the module for saved sessions provides for the parts of others. */
struct reader; /* hooke/session/read.h */
struct store_tools {
    /* Append fields to a record. `owner` is what the array's offsets count from. */
    void (*put_array)(const struct store_array *array, const void *owner, struct buffer *output);
    void (*put_scene)(const struct scene *scene, const char *name, struct buffer *output);
    /* Adds a line to what is told of the reading. */
    void (*note)(struct reader *reader, const char *format, ...) PRINTF_LIKE(2, 3);
    /* Reads an array into `owner`, which stays unchanged if one of its elements cannot be read. */
    void (*array)(struct reader *reader, const struct store_array *array, void *owner);
    /* Reads a scene and where the file has its parameters; places may be NULL. */
    bool (*scene)(struct reader *reader, struct text text, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error);
    /* Moves the items of an array [PARAM_MAX], of at most 8 bytes each, from where the file has
     * them. */
    void (*move)(const struct field_places *places, void *array, size_t item);
    /* Finds the bytes that the file has under that sum. */
    bool (*bytes)(const struct reader *reader, uint64_t sum, struct text *content);
};
/* Returns the tools; only for functions of struct module_store, which the module that has them
 * calls. */
const struct store_tools *store_tools(void);
