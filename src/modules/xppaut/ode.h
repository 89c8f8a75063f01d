/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the files of this module share for reading .ode files, which ode_read()
 * does in this order: ode_lines(), ode_statements(), then names, formulas, settings and events. */
#pragma once

#include "modules/xppaut/ode_file.h"

struct cancel;

#define ODE_LINES 20000            /* largest number of lines, after arrays are written out */
#define ODE_TEXT ((size_t)1 << 23) /* largest size of these lines, and of all formulas [byte] */
#define ODE_SYMBOLS 1024           /* largest number of names of all kinds; scenes have fewer */
#define ODE_ARGUMENTS 20           /* largest number of arguments of a function */
#define ODE_EVENTS 16              /* largest number of events */
#define ODE_NOTES 64               /* largest number of notes */
#define ODE_LOOK 32                /* number of lines between two checks for Ctrl-C */

/* A complete line of the file, or one that an array was written out to. */
struct ode_line {
    struct text text; /* lower case, without blanks at its ends */
    int number;       /* line number in the file */
};

/* Sets the error "line N: ...". Returns false. */
bool ode_error(struct error *error, int line, const char *format, ...) PRINTF_LIKE(3, 4);

/* Splits a file into complete lines in the arena: continued ones are joined, comments and what
 * follows `done` removed, arrays written out. Returns false with an error. */
bool ode_lines(struct text file, struct arena *arena, struct ode_line **line, int *count,
               struct error *error);

/* ---- names ---- */

/* Kinds of names; those that are called like functions come last. */
enum ode_kind {
    ODE_VARIABLE,
    ODE_PARAM,
    ODE_DERIVED, /* derived parameter !NAME=FORMULA */
    ODE_FIXED,   /* hidden quantity NAME=FORMULA */
    ODE_AUX,     /* auxiliary quantity */
    ODE_FUNCTION,
    ODE_TABLE,
    ODE_NET,
    ODE_KINDS
};

/* A name of the file and what it stands for. */
struct ode_symbol {
    struct text name;
    const char *as; /* name in the scene */
    enum ode_kind kind;
    int index; /* index among symbols of its kind */
    int line;
    struct text text;                    /* right-hand side; of a parameter "" */
    double value;                        /* value of a parameter; initial value of a variable */
    struct text argument[ODE_ARGUMENTS]; /* names of the arguments of a function */
    int arguments;
    const struct ode_node *body; /* body of a function, once it is used */
    struct ode_table *table;     /* the table of kind ODE_TABLE */
    struct ode_net *net;         /* the network of kind ODE_NET */
};

/* The names of a file, and what reading needs. */
struct ode {
    struct arena *arena;       /* memory of everything that is read */
    struct error *error;       /* receives errors */
    struct ode_symbol *symbol; /* [symbols] in the order of their definitions */
    int symbols, capacity, count[ODE_KINDS];
    size_t bytes; /* bytes of formulas so far */
    const struct cancel *cancel;
};

/* Returns the symbol of that name, other than an auxiliary quantity, or NULL if there is none. */
struct ode_symbol *ode_find(const struct ode *ode, struct text name);
/* Returns true, and sets the error, if reading is cancelled. */
bool ode_stopped(const struct ode *ode);
/* A right-hand side, and the names that it may read: all, or those that are defined before it. */
struct ode_reader {
    struct ode *ode;
    /* derived or hidden quantity; NULL if all names are available */
    const struct ode_symbol *subject;
    int line;
};

/* Appends the formula `text` as a formula of typed scenes, with functions and sums written out.
 * Returns false with an error. */
bool ode_formula(const struct ode_reader *reader, struct text text, struct buffer *output);
/* Appends a parsed formula of a table, with `t` as the number t and parameters as their values.
 * Returns false with an error, also if something in it changes. */
bool ode_formula_at(struct ode *ode, const struct ode_symbol *owner, const struct ode_node *whole,
                    double t, struct buffer *output);

/* ---- settings and events ---- */

/* Settings of the file; has_NAME is true for those that it gives. */
struct ode_settings {
    double t0, total, dt, tol, every; /* times [s], tolerance, and steps per recorded row */
    bool has_t0, has_total, has_dt, has_tol, has_every, has_method;
    char method; /* XPPAUT's letter */
    int line;    /* line of the method */
};

/* Splits off the next NAME=VALUE, or NAME without a value. Returns false if none is left. */
bool ode_pair(struct text *rest, struct text *name, struct text *value);
/* Reads the number of NAME=VALUE. Returns false with an error that names the line. */
bool ode_number(int line, struct text name, struct text value, double *number, struct error *error);
/* Takes a setting of a line `@` or of a set. *note becomes what is not supported about it, or NULL;
 * unknown settings are ignored, as they are for windows and other tools. Returns false with an
 * error. */
bool ode_setting(struct ode_settings *settings, int line, struct text name, struct text value,
                 const char **note, struct error *error);
/* Sets method, tolerance, times and steps of the scene from the settings, or XPPAUT's defaults.
 * Returns false with an error if the file is a map or if time does not go forwards. */
bool ode_method(const struct ode_settings *settings, struct ode_scene *scene, struct error *error);
/* Reads an event from the text behind `global`: SIGN {CONDITION} {NAME=FORMULA;...}. Returns false
 * with an error. */
bool ode_event(struct ode *ode, const struct ode_line *line, struct text rest,
               struct ode_event *event);
