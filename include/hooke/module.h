/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * module: a capability in a folder of its own, src/modules/NAME, that a build may leave out
 * (make WITHOUT=NAME). The core finds modules in the list of those that are in and never names one.
 * How a module is written: src/modules/README.md.
 */
#pragma once

#include <hooke/session.h>
#include <hooke/session/series_tools.h>
#include <hooke/run/attractor.h>

struct arguments;
struct catalog;
struct command;
struct completion;
struct figure;
struct reader; /* hooke/session/read.h */
struct reply;
struct stored;      /* hooke/session/stored.h */
struct store_tools; /* there, too */

/* Reads scenes of another program, for `load scene FILE`. */
struct scene_reader {
    const char *ending; /* "ode" for files NAME.ode; NULL if the module reads no scenes */
    const char *kind;   /* name in messages, such as "files of XPPAUT" */
    /*
     * Makes the file's scene that of the session. set: name of one of the file's sets of values,
     * empty if none was asked for. Returns false with the session unchanged and `error` filled.
     */
    bool (*load)(struct session *session, const struct arguments *arguments, struct text file,
                 struct text set, struct reply *reply, struct error *error);
};

/* Writes the session's scene for another program, for `export scene FILE`. */
struct scene_writer {
    const char *endings;         /* ".c .py"; NULL if the module writes no scenes */
    const struct catalog *kinds; /* rows are named by these endings, without their points */
    /* Appends the file's content. kind: index in `kinds`. Returns false with `error` filled. */
    bool (*write)(const struct session *session, size_t kind, struct arena *arena,
                  struct buffer *output, struct error *error);
};

/* Draws figures as pictures, for `plot > FILE`. */
struct picture_writer {
    /* endings of the files it writes, such as ".svg .pdf", or NULL if the module draws none */
    const char *files;
    /* description in messages, such as "a picture in a file that ends in .svg or .pdf" */
    const char *where;
    const struct catalog *kinds; /* rows are named by these endings, without their points */
    /* Appends the content of a file with a picture of width x height points, or of a usual size if
     * they are 0; kind: place in `kinds`. Returns false with `error` filled. */
    bool (*write)(const struct figure *figure, size_t kind, double width, double height,
                  struct buffer *output, struct error *error);
};

/* Functions that keep a module's part in the session's file. Each may be NULL. */
struct module_store {
    /* Appends its fields to the record of the session's state. */
    void (*put)(const void *part, struct buffer *output);
    /* Writes the first of its own records from *next on that the file does not have yet. Returns
     * false if there is none. */
    bool (*put_next)(const void *part, struct stored *stored, int *next);
    /* Sets two pieces of content that are written once, as a record that reader_bytes() finds by
     * *sum, which is 0 until then. Returns false if there is no content. At most one module of a
     * build has this function. */
    bool (*content)(void *part, struct text piece[2], uint64_t **sum);
    /* Stops counting records as live whose content was dropped from the session. */
    void (*forget)(const void *part, struct stored *stored);
    void (*read)(struct reader *reader);
};

/* Labels of results that `use LABEL` goes back to. */
struct module_labels {
    /* Returns true if the word has the form of a label; NULL if the module has no labels. */
    bool (*is_label)(struct text word);
    void (*complete)(struct completion *completion);
    bool (*use)(struct session *session, const struct arguments *arguments, struct reply *reply,
                struct error *error);
};

/* Work of the module that was stopped, which `continue` resumes instead of the run. */
struct module_stopped {
    bool (*waits)(const struct session *session); /* NULL if the module has no such work */
    /* Resumes the work; what is stopped again can be resumed later. Returns false with `error`
     * filled. */
    bool (*go_on)(struct session *session, const struct arguments *arguments, struct reply *reply,
                  struct error *error);
    void (*forget)(struct session *session); /* is called when a new run has begun */
};

/* Functions of the module for the prompt. Each may be NULL. */
struct module_prompt {
    /* Is called after a typed line was executed, and after each statement of a script. */
    void (*typed)(struct session *session, struct reply *reply);
    /*
     * Appends the line to be offered next, which an empty Enter at the prompt executes. Returns
     * false if the module has none, so that the next module is asked.
     */
    bool (*next)(const struct session *session, struct buffer *line);
    /* Appends the module's current activity to the state line, instead of the simulated scene.
     * counts: with numbers of what was done; blanks: between numbers and units. Returns false if
     * the module is doing nothing. */
    bool (*state)(const struct session *session, bool counts, bool blanks, struct buffer *output);
    /* Appends a name for the prompt that replaces "hooke", or nothing. */
    void (*label)(const struct session *session, struct buffer *text);
};

/* An option with which the program does one thing and then ends: `hooke --WORD ...`. */
struct module_option {
    const char *word;  /* its name without the dashes; NULL if the module has none */
    const char *shown; /* its words in `hooke --help`, such as " DIR ..." */
    const char *brief;
    const char *wants; /* its words in a message: "folders" */
    bool takes_first;  /* the word after it is the first of them, even if it begins with a dash */
    /* Executes it in a new session with the words of the command line, at least one. Returns the
     * exit status. */
    int (*run)(struct session *session, const char *const *word, int words, struct reply *reply);
};

struct module {
    struct row row;    /* its name, that of its folder, and what it is for */
    const char *needs; /* the modules without which it is not built: names with blanks between */
    struct scene_reader reader;
    struct scene_writer writer;
    struct picture_writer pictures;
    size_t part_size; /* [byte] size of its part of a session, which is zeroed at first */
    void (*part_free)(void *part); /* frees what the part points to; may be NULL */
    /* Returns true while the part needs a typed model; may be NULL. */
    bool (*part_uses)(const void *part, const struct model *model);
    struct module_store store;
    struct module_labels labels;
    struct module_prompt prompt;
    struct module_option option;
    find_attractor *attractor; /* computes `sweep measure=attractor`; may be NULL */
    struct module_stopped stopped;
    /* Appends lines to the text of `plan`; may be NULL. */
    void (*plan)(const struct session *session, struct buffer *text);
    /* catalogs whose names `help` explains, ended by NULL; may be NULL */
    const struct catalog *const *catalogs;
    /* Offers completions after the text `preceding` of a command. Returns false if the command's
     * arguments define them; may be NULL. */
    bool (*complete)(struct completion *completion, const struct command *command,
                     struct text preceding);
    const struct series_tools *series; /* hooke/session/series_tools.h; NULL if it has none */
    const struct store_tools *keeps;   /* keeps parts of modules in files; NULL if it does not */
    void (*statement_ended)(struct session *session); /* is called after each; may be NULL */
};

/* The modules of this build, in the order of their names, then NULL. */
extern const struct module *const module_list[];
/* The names of the modules that this build leaves out, then NULL. */
extern const char *const module_left_out[];
/* Appends the line "modules   NAME NAME" with the modules of this build. */
void modules_put(struct buffer *text);

/* Appends a name for the prompt, such as "lab 2/9", or nothing. */
void modules_label(const struct session *session, struct buffer *text);

/*
 * Returns false, with status 2 and the module's name in `error`, if this build leaves out the
 * module that `what` belongs to: a command, an option, "load .ode" or "export .py". word: the place
 * of the error.
 */
bool module_is_in(const char *what, struct text word, struct error *error);

/* Returns what draws pictures, or NULL if no module of this build does. */
const struct picture_writer *module_pictures(void);

/* Returns the module whose work was stopped and waits, or NULL if none does. */
const struct module *module_waiting(const struct session *session);
/* Has all modules forget what was stopped. */
void modules_forget_stopped(struct session *session);

/* Returns a module's part of the session, which is created by the first call, or NULL if out of
 * memory. */
void *session_part(const struct session *session, const struct module *module);
/* Returns the part if it has been created, else NULL. */
void *session_part_if_made(const struct session *session, const struct module *module);
