/* SPDX-License-Identifier: GPL-3.0-or-later */
/* stored: the content of a session file, by which the module `resume` saves a session as it
 * changes, and the functions that it provides to other modules for their parts of a session. */
#pragma once

#include <hooke/base/fields.h>
#include <hooke/session.h>

/* Largest number of stored results of studies: a list of equilibria, periodic orbits and branches.
 */
#define STORE_FOUND (1 + LIMIT_ORBITS + LIMIT_BRANCHES)

/* Record of what the file of a session contains so far, by which saving appends only what has
 * changed; all zeros for an empty file. */
struct stored {
    /* [runs] records of what the file contains of each run; owned, and private to the module
     * `resume`. */
    struct stored_run *run;
    int runs, run_capacity;
    /* [recordings] checksums of the files of recordings whose content is stored. */
    uint64_t recording[LIMIT_RECORDINGS];
    int recordings;
    uint64_t found_id[STORE_FOUND]; /* [found] identifiers of the stored results. */
    int found;
    /* Checksum of the content that a module stores once (such as the curve of a fit), or 0 if none
     * is stored. */
    uint64_t content;
    /* Number of entries, and of bytes of text, of session->history that are stored. */
    size_t entries, text;
    uint64_t said;  /* Number of stored lines of session->log. */
    uint64_t state; /* Checksum of the last RECORD_STATE. */
    uint64_t bytes; /* Size [byte] of the session file. */
    /* Number of runs whose rows are not stored, because the file would become too large. */
    int left_out;
    /* Record that is being written; its first `sent` bytes are in the file. */
    struct buffer record;
    size_t sent;
    bool unfinished; /* Saving was interrupted; the next call continues from there. */
};

/* Kinds of records in a session file; the value is the letter with which each record begins. */
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

/* Describes an array, in a session or in the part of a module, for writing and reading; each
 * element is stored as a field of its own. */
struct store_array {
    /* Name of the field. */
    const char *name;
    /* Offset [byte] of the array, or of the pointer to it, in the struct that contains it, and size
     * [byte] of an element. */
    size_t offset, item;
    size_t count; /* Offset [byte] in that struct of the int that is the number of elements. */
    /* Largest number of elements of an array in the struct, or 0 for a pointer to an allocated
     * array. */
    int max;
    /* [members] fields of an element that are stored; others are 0 after reading. */
    const struct field *member;
    size_t members;
    /* Returns true if an element that was read is valid, for conditions that the ranges of its
     * fields do not express; may be NULL. */
    bool (*sound)(const void *item);
};
/* Initialiser of a struct store_array for the member `array` of struct `owner`, whose elements the
 * member `counted` counts. `limit` is its `max`; `members` is an array of struct field. */
#define STORE_ARRAY(name, owner, array, counted, limit, members, sound)                            \
    {                                                                                              \
        name, offsetof(owner, array), sizeof *((owner *)0)->array, offsetof(owner, counted),       \
            limit, members, COUNT_OF(members), sound                                               \
    }

struct reader; /* <hooke/session/read.h> */

/* Functions that the module `resume` provides to other modules. */
struct store_tools {
    /* put_array() appends an array, put_scene() a scene as the field `name`, to a record; `owner`
     * is the struct to which the offsets in `array` refer. */
    void (*put_array)(const struct store_array *array, const void *owner, struct buffer *output);
    void (*put_scene)(const struct scene *scene, const char *name, struct buffer *output);
    /* Adds a remark to those that tell the user what could not be restored. */
    void (*note)(struct reader *reader, const char *format, ...) PRINTF_LIKE(2, 3);
    /* Reads an array into `owner`; if an element cannot be read, the array is unchanged. */
    void (*array)(struct reader *reader, const struct store_array *array, void *owner);
    /* Reads the scene in the field `name` of the record `text`, and sets *places, unless NULL, to
     * the indices of the scene's parameters in arrays of the file. Returns false with `error` set.
     */
    bool (*scene)(struct reader *reader, struct text text, const char *name, struct scene *scene,
                  struct field_places *places, struct error *error);
    /* Reorders array [PARAM_MAX], which has an item of `item` bytes (at most 8) for each parameter,
     * from the order of the file to that of this program. */
    void (*move)(const struct field_places *places, void *array, size_t item);
    /* Sets *content to the content of another file that is stored in the session file and has the
     * checksum `sum`. Returns false if it is not stored. */
    bool (*bytes)(const struct reader *reader, uint64_t sum, struct text *content);
};
/* Returns the functions. Only functions of struct module_store, which the module `resume` calls,
 * may use them. */
const struct store_tools *store_tools(void);
