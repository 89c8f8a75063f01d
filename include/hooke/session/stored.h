/* SPDX-License-Identifier: GPL-3.0-or-later */
/* stored: the content of a session file, by which the module `resume` saves a session as it
 * changes, and the functions that it provides to other modules for their parts of a session. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* largest number of stored results: a list of equilibria, orbits and branches */
#define STORE_FOUND (1 + LIMIT_ORBITS + LIMIT_BRANCHES)

/* Content of the file of a session so far, so that only changes are appended; all zeros for an
 * empty file. */
struct stored {
    /* [runs] what the file contains of each run; private to the module `resume`. */
    struct stored_run *run;
    int runs, run_capacity;
    uint64_t recording[LIMIT_RECORDINGS]; /* [recordings] checksums of their files. */
    int recordings;
    uint64_t found_id[STORE_FOUND]; /* [found] identifiers of the stored results. */
    int found;
    uint64_t content;     /* Checksum of the stored content of a file, or 0. */
    size_t entries, text; /* Numbers of stored entries and bytes of session->history. */
    uint64_t said;        /* Number of stored lines of session->log. */
    uint64_t state;       /* Checksum of the last RECORD_STATE. */
    uint64_t bytes;       /* Number of bytes written. */
    int left_out;         /* Number of runs whose rows were left out for want of room. */
    struct buffer record; /* Record that is being written, of which `sent` bytes are in the file. */
    size_t sent;
    bool unfinished; /* Saving was interrupted; the next call continues where this one ended. */
};

/* Kinds of records in a session file; a letter in the head of each record. */
enum record_kind {
    /* Content of another file. */
    RECORD_BYTES = 'D',
    /* A run without its rows. */
    RECORD_RUN = 'R',
    /* Rows of a run. */
    RECORD_ROWS = 'W',
    /* Entries of the history. */
    RECORD_LINES = 'L',
    /* Lines of the log pane. */
    RECORD_SAID = 'T',
    /* A result of a study. */
    RECORD_FOUND = 'B',
    /* All other state of the session. */
    RECORD_STATE = 'S',
};

/* Describes an array in a session or a module's part of one, which is stored as a field for each
 * element. */
struct store_array {
    /* Name of the field. */
    const char *name;
    /* Offset of the array (or of the pointer to it), and size [byte] of an element. */
    size_t offset, item;
    size_t count; /* Offset of the int that counts the elements. */
    int max;      /* Largest number of elements, or 0 if the array is allocated. */
    /* [members] fields of an element that are stored; others are 0 after reading. */
    const struct field *member;
    size_t members;
    /* Returns true if an element that was read is valid in a session, beyond the checks of its
     * fields; or NULL. */
    bool (*sound)(const void *item);
};
/* Initialiser for the member `array` of struct `owner`, counted by its member `counted`. */
#define STORE_ARRAY(name, owner, array, counted, limit, members, sound)                            \
    {                                                                                              \
        name, offsetof(owner, array), sizeof *((owner *)0)->array, offsetof(owner, counted),       \
            limit, members, COUNT_OF(members), sound                                               \
    }

struct reader; /* <hooke/session/read.h> */

/* Functions that the module `resume` provides to other modules. */
struct store_tools {
    /* Append an array, or a scene, as fields to a record; the array's offsets refer to `owner`. */
    void (*put_array)(const struct store_array *array, const void *owner, struct buffer *output);
    void (*put_scene)(const struct scene *scene, const char *name, struct buffer *output);
    /* Adds a remark for the user on what was read. */
    void (*note)(struct reader *reader, const char *format, ...) PRINTF_LIKE(2, 3);
    /* Reads an array into `owner`, which is unchanged if an element cannot be read. */
    void (*array)(struct reader *reader, const struct store_array *array, void *owner);
    /* Reads a scene, and the indices of its parameters in the file into *places, which may be NULL.
     * Returns false with `error` set. */
    bool (*scene)(struct reader *reader, struct text text, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error);
    /* Moves the items of an array [PARAM_MAX], at most 8 bytes each, from their indices in the file
     * to those of the program. */
    void (*move)(const struct field_places *places, void *array, size_t item);
    /* Finds the content of another file by its checksum. Returns false if it is not stored. */
    bool (*bytes)(const struct reader *reader, uint64_t sum, struct text *content);
};
/* Returns the functions. Only for functions of struct module_store, which the module `resume`
 * calls. */
const struct store_tools *store_tools(void);
