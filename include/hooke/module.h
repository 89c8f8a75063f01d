/* SPDX-License-Identifier: GPL-3.0-or-later */
/* module: the interface of modules. A module is a capability in a folder of its own,
 * src/modules/NAME, that a build may leave out (make WITHOUT=NAME). It fills a struct module, whose
 * members are all optional but the row; the core finds modules by module_list and never names one.
 * src/modules/README.md tells how a module is written. Functions that return bool set `error` when
 * they return false. */
#pragma once

#include <hooke/session.h>
#include <hooke/session/series_tools.h>
#include <hooke/run/attractor.h>

struct arguments;
struct catalog;
struct command;
struct completion;
struct figure;
struct reader; /* <hooke/session/read.h> */
struct reply;
struct stored;      /* <hooke/session/stored.h> */
struct store_tools; /* there, too */

/* Reads scenes of another program, for `load scene FILE`. */
struct scene_reader {
    /* Ending of the files, such as "ode"; NULL if the module reads no scenes. */
    const char *ending;
    const char *kind; /* Name in messages, such as "files of XPPAUT". */
    /* Makes the file's scene that of the session. `set` is the name of one of the file's sets of
     * values, or empty. Returns false with `error` set and the session unchanged. */
    bool (*load)(struct session *session, const struct arguments *arguments, struct text file,
                 struct text set, struct reply *reply, struct error *error);
};

/* Writes the session's scene for another program, for `export scene FILE`. */
struct scene_writer {
    /* Endings of the files, such as ".c .py"; NULL if the module writes no scenes. */
    const char *endings;
    /* Formats, whose rows are named by these endings without their dots. */
    const struct catalog *kinds;
    /* Appends the content of a file; `kind` is the index in `kinds`. Returns false with `error`
     * set. */
    bool (*write)(const struct session *session, size_t kind, struct arena *arena,
                  struct buffer *output, struct error *error);
};

/* Draws figures as pictures, for `plot > FILE`. */
struct picture_writer {
    /* Endings of the files, such as ".svg .pdf"; NULL if the module draws no pictures. */
    const char *files;
    /* Description in messages, such as "a picture in a file that ends in .svg or .pdf". */
    const char *where;
    /* Formats, whose rows are named by these endings without their dots. */
    const struct catalog *kinds;
    /* Appends the content of a file with a picture of width x height points, or of a usual size if
     * they are 0; `kind` is the index in `kinds`. Returns false with `error` set. */
    bool (*write)(const struct figure *figure, size_t kind, double width, double height,
                  struct buffer *output, struct error *error);
};

/* Functions that save a module's part (its state in a session) in the session's file. Each may be
 * NULL. */
struct module_store {
    /* Appends its fields to the record of the session's state. */
    void (*put)(const void *part, struct buffer *output);
    /* Makes the next of its own records, from number *next on, that the file does not contain.
     * Returns false if there is none. */
    bool (*put_next)(const void *part, struct stored *stored, int *next);
    /* Sets two pieces of content that are written once, as a record that store_tools()->bytes()
     * finds by *sum, which is 0 until then. Returns false if there is no content. At most one
     * module of a build has this function. */
    bool (*content)(void *part, struct text piece[2], uint64_t **sum);
    /* Marks the records as unused whose content was dropped from the session. */
    void (*forget)(const void *part, struct stored *stored);
    /* Restores the part from the records that were read. */
    void (*read)(struct reader *reader);
};

/* Labels of results to which `use LABEL` goes back. */
struct module_labels {
    /* Returns true if the word has the form of a label; NULL if the module has no labels. */
    bool (*is_label)(struct text word);
    /* Offers the labels that exist. */
    void (*complete)(struct completion *completion);
    /* Goes back to the result with the label of `use`. Returns false with `error` set. */
    bool (*use)(struct session *session, const struct arguments *arguments, struct reply *reply,
                struct error *error);
};

/* Work of the module that was stopped, which `continue` resumes instead of the run. */
struct module_stopped {
    /* Returns true if there is stopped work; NULL if the module has no such work. */
    bool (*waits)(const struct session *session);
    /* Resumes the work, which can be stopped and resumed again. Returns false with `error` set. */
    bool (*go_on)(struct session *session, const struct arguments *arguments, struct reply *reply,
                  struct error *error);
    /* Forgets the stopped work, when a new run has begun. */
    void (*forget)(struct session *session);
};

/* Functions of the module for the prompt. Each may be NULL. */
struct module_prompt {
    /* Called after a typed line was executed, and after each statement of a script. */
    void (*typed)(struct session *session, struct reply *reply);
    /*
     * Appends the line to be offered next, which an empty Enter at the prompt executes. Returns
     * false if the module has none, so that the next module is asked.
     */
    bool (*next)(const struct session *session, struct buffer *line);
    /* Appends the module's current activity to the state line, in place of the scene; with numbers
     * of what was done if `counts`, with blanks between numbers and units if `blanks`. Returns
     * false if it does nothing. */
    bool (*state)(const struct session *session, bool counts, bool blanks, struct buffer *output);
    /* Appends a name for the prompt that replaces "hooke", or nothing. */
    void (*label)(const struct session *session, struct buffer *text);
};

/* An option with which the program does one thing and then ends: `hooke --WORD …`. */
struct module_option {
    const char *word;  /* Its name without the dashes; NULL if the module has none. */
    const char *shown; /* Its arguments in `hooke --help`, such as " DIR ...". */
    /* Its description in one line. */
    const char *brief;
    /* Its arguments in messages, such as "folders". */
    const char *wants;
    bool takes_first; /* The word after it is an argument even if it begins with a dash. */
    /* Executes it in a new session with `words` >= 1 arguments of the command line. Returns the
     * exit status. */
    int (*run)(struct session *session, const char *const *word, int words, struct reply *reply);
};

/* A module, an element of module_list. Members that it does not use are NULL or 0. */
struct module {
    struct row row;    /* Its name, that of its folder, and its purpose. */
    const char *needs; /* Names of modules without which it is not built, separated by blanks. */
    struct scene_reader reader;
    struct scene_writer writer;
    struct picture_writer pictures;
    size_t part_size; /* [byte] size of its part: its state in a session, zeroed at first. */
    void (*part_free)(void *part); /* Frees what the part points to; may be NULL. */
    /* Returns true if the part refers to the typed model; may be NULL. */
    bool (*part_uses)(const void *part, const struct model *model);
    struct module_store store;
    struct module_labels labels;
    struct module_prompt prompt;
    struct module_option option;
    find_attractor *attractor; /* Computes `sweep measure=attractor`; may be NULL. */
    struct module_stopped stopped;
    /* Appends lines to the text of `plan`; may be NULL. */
    void (*plan)(const struct session *session, struct buffer *text);
    /* Catalogs whose names `help` explains, ended by NULL; may be NULL. */
    const struct catalog *const *catalogs;
    /* Offers completions after the text `preceding` of a command. Returns false if the command's
     * arguments define them; may be NULL. */
    bool (*complete)(struct completion *completion, const struct command *command,
                     struct text preceding);
    /* Functions on series, or NULL (<hooke/session/series_tools.h>). */
    const struct series_tools *series;
    /* Functions that save parts of modules, or NULL (<hooke/session/stored.h>). */
    const struct store_tools *keeps;
    /* Called after each statement; may be NULL. */
    void (*statement_ended)(struct session *session);
};

/* The modules of this build in the order of their names, then NULL. */
extern const struct module *const module_list[];
/* The names of the modules that this build leaves out, then NULL. */
extern const char *const module_left_out[];
/* Appends the line "modules   NAME NAME" with the modules of this build. */
void modules_put(struct buffer *text);

/* Appends a name for the prompt, such as "lab 2/9", or nothing. */
void modules_label(const struct session *session, struct buffer *text);

/* Returns false, with status 2 and the module's name in `error`, if this build leaves out the
 * module to which `what` belongs: a command, an option, "load .ode" or "export .py". `word` is the
 * position of the error. */
bool module_is_in(const char *what, struct text word, struct error *error);

/* Returns the functions that draw pictures, or NULL if no module of this build has them. */
const struct picture_writer *module_pictures(void);

/* Returns the module with stopped work, or NULL if there is none. */
const struct module *module_waiting(const struct session *session);
/* Makes all modules forget stopped work. */
void modules_forget_stopped(struct session *session);

/* Returns a module's part of the session, which the first call creates; NULL if out of memory. */
void *session_part(const struct session *session, const struct module *module);
/* Returns the part if it exists, else NULL. */
void *session_part_if_made(const struct session *session, const struct module *module);
