/* SPDX-License-Identifier: GPL-3.0-or-later */
/* module: the interface of modules. A module is a capability in a folder of its own,
 * src/modules/NAME, that a build may leave out (make WITHOUT=NAME). A module defines a struct
 * module, all of whose members but `row` are optional. The core calls modules through module_list
 * and names none of them. src/modules/README.md tells how a module is written. */
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
struct store_tools; /* <hooke/session/stored.h> */

/* Reads scenes of another program, for `load scene FILE`. */
struct scene_reader {
    /* Ending of the files, such as "ode"; NULL if the module reads no scenes. */
    const char *ending;
    const char *kind; /* Name in messages, such as "files of XPPAUT". */
    /* Replaces the session's scene by that of the file at path `file`. `set` is the name of one of
     * the sets of values in the file, or empty. Returns false, with `error` set and the session
     * unchanged, on failure. */
    bool (*load)(struct session *session, const struct arguments *arguments, struct text file,
                 struct text set, struct reply *reply, struct error *error);
};

/* Writes the session's scene for another program, for `export scene FILE`. */
struct scene_writer {
    /* Endings of the files, such as ".c .py"; NULL if the module writes no scenes. */
    const char *endings;
    /* Formats, a row for each ending, whose name is the ending without its dot. */
    const struct catalog *kinds;
    /* Appends the content of a file in format `kind`, an index in `kinds`. Temporary memory is the
     * arena's. Returns false with `error` set. */
    bool (*write)(const struct session *session, size_t kind, struct arena *arena,
                  struct buffer *output, struct error *error);
};

/* Draws figures as pictures, for `plot > FILE`. */
struct picture_writer {
    /* Endings of the files, such as ".svg .pdf"; NULL if the module draws no pictures. */
    const char *files;
    /* Description of the files in messages, such as "a picture in a file that ends in .svg or
     * .pdf". */
    const char *where;
    /* Formats, a row for each ending, whose name is the ending without its dot. */
    const struct catalog *kinds;
    /* Appends the content of a file in format `kind`, an index in `kinds`, with a picture of width
     * x height points (1/72 inch); 0 stands for the usual size. Returns false with `error` set. */
    bool (*write)(const struct figure *figure, size_t kind, double width, double height,
                  struct buffer *output, struct error *error);
};

/* Functions that save and restore a module's part (its state in a session, session_part()) in the
 * session's file, which is a series of records (<hooke/session/stored.h>). `part` points to
 * module->part_size bytes. Each function may be NULL. */
struct module_store {
    /* Appends the fields of the part to the record of the session's state (RECORD_STATE). */
    void (*put)(const void *part, struct buffer *output);
    /* Makes one record of the part's own: the first one, counted from number *next, that the file
     * does not contain; advances *next. Returns false if there is none. */
    bool (*put_next)(const void *part, struct stored *stored, int *next);
    /* Sets piece[0] and piece[1] to large content of the part that the file has to contain only
     * once, such as the curve of a fit; the two slices are written one after the other in one
     * record. *sum is set to the address of a checksum in the part, where the caller stores the
     * checksum of that record; it is 0 as long as the content has not been written. After reading,
     * store_tools()->bytes() finds the content by this checksum. Returns false if there is no
     * content. At most one module of a build has this function. */
    bool (*content)(void *part, struct text piece[2], uint64_t **sum);
    /* Marks records in the file as unused if the part does not have their content any more. */
    void (*forget)(const void *part, struct stored *stored);
    /* Restores the part from the records of a file (<hooke/session/read.h>). */
    void (*read)(struct reader *reader);
};

/* Labels of earlier results, to which the command `use LABEL` returns. */
struct module_labels {
    /* Returns true if the word has the form of a label; NULL if the module has no labels. */
    bool (*is_label)(struct text word);
    /* Offers the labels that exist. */
    void (*complete)(struct completion *completion);
    /* Returns to the result whose label is the argument of `use`. Returns false with `error` set.
     */
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
    /* Discards the stopped work; called when a new run has begun. */
    void (*forget)(struct session *session);
};

/* Functions of the module for the prompt. Each may be NULL. */
struct module_prompt {
    /* Called after each line that was executed at a prompt or, without a prompt, after each
     * statement of a script, so that the module can continue its work, such as a lesson, with their
     * result; may reply. Not called for the commands of events and of saved sessions. */
    void (*typed)(struct session *session, struct reply *reply);
    /*
     * Appends the line to be offered next, which an empty Enter at the prompt executes. Returns
     * false if the module has none, so that the next module is asked.
     */
    bool (*next)(const struct session *session, struct buffer *line);
    /* Appends the module's current activity to the state line, in place of the scene. `counts` adds
     * numbers, such as of samples received; `blanks` writes blanks between numbers and units.
     * Returns false, with nothing appended, if the module does nothing at present. */
    bool (*state)(const struct session *session, bool counts, bool blanks, struct buffer *output);
    /* Appends a name that replaces "hooke" in the prompt, such as "lab 2/9", or nothing. */
    void (*label)(const struct session *session, struct buffer *text);
};

/* A command-line option with which the program does one task and then ends: `hooke --WORD …`. */
struct module_option {
    const char *word;  /* Name of the option without its dashes; NULL if the module has none. */
    const char *shown; /* Arguments of the option in `hooke --help`, such as " DIR ...". */
    const char *brief; /* Description of the option in one line. */
    const char *wants; /* Word for the arguments in messages, such as "folders". */
    bool takes_first;  /* The word after the option is an argument even if it begins with a dash. */
    /* Does the task in a new session, with word [words] the arguments of the option, words >= 1.
     * Returns the exit status. */
    int (*run)(struct session *session, const char *const *word, int words, struct reply *reply);
};

/* A module, an element of module_list. Members that a module does not use are NULL or 0. */
struct module {
    struct row row;    /* Name of the module and of its folder, and its purpose. */
    const char *needs; /* Names of the modules that it requires, separated by blanks. */
    struct scene_reader reader;
    struct scene_writer writer;
    struct picture_writer pictures;
    /* Size [byte] of the module's part, its own state in each session, which session_part() makes
     * with all bytes 0. */
    size_t part_size;
    /* Frees the memory to which the part points, not the part; may be NULL. */
    void (*part_free)(void *part);
    /* Returns true if the part points to this typed model, which then must not be freed; may be
     * NULL. */
    bool (*part_uses)(const void *part, const struct model *model);
    struct module_store store;
    struct module_labels labels;
    struct module_prompt prompt;
    struct module_option option;
    find_attractor *attractor; /* Computes points of `sweep measure=attractor`; may be NULL. */
    struct module_stopped stopped;
    /* Appends lines to the text of `plan`; may be NULL. */
    void (*plan)(const struct session *session, struct buffer *text);
    /* Catalogs whose names `help` explains, ended by NULL; may be NULL. */
    const struct catalog *const *catalogs;
    /* Offers completions of the word after the text `preceding`, which follows the command's name.
     * Returns false if the types of the command's arguments decide instead; may be NULL. */
    bool (*complete)(struct completion *completion, const struct command *command,
                     struct text preceding);
    /* Functions on series that the core and other modules call, provided by the module `recording`;
     * else NULL (<hooke/session/series_tools.h>). */
    const struct series_tools *series;
    /* Functions by which other modules save their parts in the session's file, provided by the
     * module `resume`; else NULL (struct store_tools in <hooke/session/stored.h>). */
    const struct store_tools *keeps;
    /* Called directly after the handler of every statement, even one that failed or was executed by
     * another statement, and before undo records the change; may be NULL. */
    void (*statement_ended)(struct session *session);
};

/* The modules of this build in the order of their names, then NULL. */
extern const struct module *const module_list[];
/* The names of the modules that this build leaves out, then NULL. */
extern const char *const module_left_out[];
/* Appends the line "modules   NAME NAME" with the modules of this build. */
void modules_put(struct buffer *text);

/* Appends the name for the prompt of the first module that has one (module_prompt.label). */
void modules_label(const struct session *session, struct buffer *text);

/* Returns false if this build leaves out the module to which `what` belongs: a command, an option,
 * "load .ode" or "export .py". `error` then has status 2, the module's name and, as its position,
 * that of `word`. */
bool module_is_in(const char *what, struct text word, struct error *error);

/* Returns the functions that draw pictures, or NULL if no module of this build has them. */
const struct picture_writer *module_pictures(void);

/* Returns the module with stopped work, or NULL if there is none. */
const struct module *module_waiting(const struct session *session);
/* Discards the stopped work of all modules. */
void modules_forget_stopped(struct session *session);

/* Returns a module's part of the session, which the first call creates; NULL if out of memory. */
void *session_part(const struct session *session, const struct module *module);
/* Returns the module's part if session_part() has created it, else NULL. */
void *session_part_if_made(const struct session *session, const struct module *module);
