/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * module: a capability in a folder of its own, src/modules/NAME, that a build may leave out
 * (make WITHOUT=NAME). The core finds modules in the list of those that are in and never names one.
 * How a module is written: src/modules/README.md.
 */
#ifndef HOOKE_MODULE_H
#define HOOKE_MODULE_H

#include <hooke/session.h>
#include <hooke/study/attractor.h>

struct arguments;
struct completion;
struct reader; /* hooke/session/read.h */
struct reply;
struct stored; /* hooke/session/stored.h */

/* Reads scenes of another program, for `load scene FILE`. */
struct scene_reader {
    const char *ending; /* "ode" for files NAME.ode; NULL if the module reads no scenes */
    const char *kind;   /* for messages: "files of XPPAUT" */
    /*
     * Makes the file's scene that of the session; `set`: the set of values that was asked for, "":
     * none. Returns false with the session unchanged and `error` filled.
     */
    bool (*load)(struct session *session, const struct arguments *arguments, struct text file,
                 struct text set, struct reply *reply, struct error *error);
};

/* Writes the session's scene for another program, for `export scene FILE`. */
struct scene_writer {
    const char *endings;         /* ".c .py"; NULL if the module writes no scenes */
    const struct catalog *kinds; /* rows are named by these endings, without their points */
    /* Appends the file's content; kind: place in `kinds`. Returns false with `error` filled. */
    bool (*write)(const struct session *session, size_t kind, struct arena *arena,
                  struct buffer *out, struct error *error);
};

/* Functions that keep a module's part in the session's file. Each may be NULL. */
struct module_store {
    /* Appends its fields to the record of the session's state. */
    void (*put)(const void *part, struct buffer *to);
    /* Writes the next of its own records that the file does not have yet, from *next on. Returns
     * false where there is none. */
    bool (*put_next)(const void *part, struct stored *stored, int *next);
    /* Counts records of what is gone as live no more. */
    void (*forget)(const void *part, struct stored *stored);
    void (*read)(struct reader *reader);
};

/* Labels of results that `use LABEL` goes back to. */
struct module_labels {
    bool (*is_label)(
        struct text word); /* whether the word has the form of a label; NULL: none has */
    void (*complete)(struct completion *completion);
    bool (*use)(struct session *session, const struct arguments *arguments, struct reply *reply,
                struct error *error);
};

struct module {
    struct row row;    /* its name, that of its folder, and what it is for */
    const char *needs; /* the modules without which it is not built: names with blanks between */
    struct scene_reader reader;
    struct scene_writer writer;
    size_t part_size; /* [byte] size of its part of a session, which is zeroed at first */
    void (*part_free)(void *part); /* frees what the part points to; may be NULL */
    /* Returns true while the part needs a typed model; may be NULL. */
    bool (*part_uses)(const void *part, const struct model *model);
    struct module_store store;
    struct module_labels labels;
    find_attractor *attractor; /* computes `sweep measure=attractor`; may be NULL */
};

/* The modules of this build, in the order of their names, then NULL. */
extern const struct module *const module_list[];
/* The names of those that it was built without, then NULL. */
extern const char *const module_left_out[];
/* Appends the line "modules   NAME NAME": those that are in. */
void modules_put(struct buffer *text);

/*
 * Returns false, with status 2 and the module's name in `error`, where this program was built
 * without the module that `what` belongs to: a command, "load .ode" or "export .py". `word`: where
 * the error is.
 */
bool module_is_in(const char *what, struct text word, struct error *error);

/* Returns a module's part of the session, which is made when it is first asked for. NULL: no
 * memory. */
void *session_part(const struct session *session, const struct module *module);
/* The same where it was asked for before, else NULL. */
void *session_part_if_made(const struct session *session, const struct module *module);

#endif
