/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reading .ode files: lines, formulas, statements, settings. */
#pragma once

#include "modules/xppaut/ode_file.h"

struct cancel;

#define ODE_LINES 20000            /* largest number of lines after arrays are written out */
#define ODE_TEXT ((size_t)1 << 23) /* [byte] of them */
#define ODE_SYMBOLS 1024           /* names of all kinds: scenes have fewer */
#define ODE_ARGUMENTS 20
#define ODE_EVENTS 16
#define ODE_NOTES 64 /* said; nobody reads more */
#define ODE_LOOK 32  /* lines between two looks */

struct ode_line {
    struct text text; /* lower case, without blanks at its ends */
    int number;       /* line number in the file */
};

/* False with "line N: …" as the error. */
bool ode_error(struct error *error, int line, const char *format, ...) PRINTF_LIKE(3, 4);

/* Whole lines: continued ones joined, comments and what follows `done` gone, arrays written out. */
bool ode_lines(struct text file, struct arena *arena, struct ode_line **line, int *count,
               struct error *error);

/* ---- names ---- */

/* Those that are called come last. */
enum ode_kind {
    ODE_VARIABLE,
    ODE_PARAM,
    ODE_DERIVED,
    ODE_FIXED,
    ODE_AUX,
    ODE_FUNCTION,
    ODE_TABLE,
    ODE_NET,
    ODE_KINDS
};

struct ode_symbol {
    struct text name;
    const char *as; /* name in the scene */
    enum ode_kind kind;
    int index; /* index among symbols of its kind */
    int line;
    struct text text; /* right-hand side; of a parameter "" */
    double value;     /* value of a parameter; initial value of a variable */
    struct text argument[ODE_ARGUMENTS];
    int arguments;
    const struct ode_node *body; /* body of a function, once it is used */
    struct ode_table *table;
    struct ode_net *net;
};

struct ode {
    struct arena *arena;
    struct error *error;
    struct ode_symbol *symbol;
    int symbols, capacity, count[ODE_KINDS];
    size_t bytes; /* bytes of formulas so far */
    const struct cancel *cancel;
};

struct ode_symbol *ode_find(const struct ode *ode, struct text name);
/* True, with its error: it is cancelled. */
bool ode_stopped(const struct ode *ode);
/* Those that a right-hand side may read: all, or what is there before it. */
struct ode_reader {
    struct ode *ode;
    /* derived or hidden quantity; NULL if all names are available */
    const struct ode_symbol *subject;
    int line;
};

/* Appends the formula as one of typed scenes. */
bool ode_formula(const struct ode_reader *reader, struct text text, struct buffer *output);
/* The same in numbers: t is one, parameters are their values. */
bool ode_formula_at(struct ode *ode, const struct ode_symbol *owner, const struct ode_node *whole,
                    double t, struct buffer *output);

/* ---- settings and events ---- */

struct ode_settings {
    double t0, total, dt, tol, every;
    bool has_t0, has_total, has_dt, has_tol, has_every, has_method;
    char method; /* XPPAUT's letter */
    int line;    /* line of the method */
};

/* Reads the next NAME=VALUE; *equals is set if it has a value. Returns false if none is left. */
bool ode_pair(struct text *rest, struct text *name, struct text *value);
bool ode_number(int line, struct text name, struct text value, double *number, struct error *error);
/* One of `@` or of a set. *note: what is not done, or NULL. */
bool ode_setting(struct ode_settings *settings, int line, struct text name, struct text value,
                 const char **note, struct error *error);
/* Sets method, tolerance, times and steps of the scene. Returns false with the error if it is a map
 * or if time does not go forwards. */
bool ode_method(const struct ode_settings *settings, struct ode_scene *scene, struct error *error);
/* `global SIGN {CONDITION} {NAME=FORMULA;…}`, without its first word. */
bool ode_event(struct ode *ode, const struct ode_line *line, struct text rest,
               struct ode_event *event);
