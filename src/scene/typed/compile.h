/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compilation of typed scenes: declarations shared by compile.c and names.c. All names are declared
 * as symbols first; expressions are then read with indices of symbols as slots, and renumbered when
 * it is known which parameters are read. */
#pragma once

#include "scene/typed/typed.h"

struct suggestion;

enum symbol_kind {
    SYMBOL_TIME,
    SYMBOL_VARIABLE, /* typed variable */
    SYMBOL_VELOCITY, /* velocity of a typed variable */
    SYMBOL_STATE,    /* state variable of the built-in base */
    SYMBOL_PARAM,
    SYMBOL_OBSERVED
};

/* A name that expressions may use, or that is taken. */
struct symbol {
    char name[LIMIT_SYMBOL + 1];
    enum symbol_kind kind;
    int index;   /* index among symbols of its kind */
    int primed;  /* symbol whose derivative this velocity is; -1 for other symbols */
    bool hidden; /* expressions cannot use it, as initial values */
    bool used;   /* an expression uses it */
    int slot;    /* number of the name in the equations (struct typed) */
};

/* A typed variable, with or without its equation. */
struct unknown {
    /* the lines that declare it, set its initial velocity and give its equation; the last two may
     * be NULL */
    const struct typed_line *line, *speed, *equation;
    int symbol, velocity;    /* its symbol, and that of its velocity or -1 */
    const struct expr *expr; /* right-hand side of the equation; NULL if there is none */
    int order;               /* 1 or 2 */
};

/* State of a compilation. */
struct compile {
    struct typed *typed;
    struct error *error;
    struct symbol *symbol; /* [symbols] */
    int symbols;
    struct unknown *unknown; /* [unknowns] */
    int unknowns;
    struct param_row *own;     /* [owns] parameters that were typed, and initial values */
    int owns, bases;           /* number of these, and of the base's parameters before them */
    const struct expr **force; /* [lines] force of each line; NULL for other lines */
    int state;                 /* number of state variables of the base; 0 if there is none */
};

/* ---- names.c ---- */

/* Returns true if the symbol has this name. */
static inline bool symbol_is(const struct symbol *symbol, struct text name)
{
    const size_t last = name.len - 1; /* names like x1 and x2 differ in their last byte */
    return name.len > 0 && name.len <= LIMIT_SYMBOL && symbol->name[name.len] == '\0' &&
           symbol->name[last] == name.data[last] && memcmp(symbol->name, name.data, last) == 0;
}

/* Declares all names but those of observed quantities. Returns false with an error. */
bool typed_declare(struct compile *c);
/* Adds a symbol and returns its index. Returns -1, with an error at `where`, if the name is
 * taken. */
int typed_symbol(struct compile *c, struct text name, enum symbol_kind kind, int index,
                 struct text where);
/* Adds the parameter of a variable's initial value: that of the line, or 0 if it is NULL. Returns
 * false with an error. */
bool typed_initial(struct compile *c, struct text variable, const struct typed_line *line,
                   enum quantity quantity, struct text where);
/* Adds the parameter t0. Returns false with an error. */
bool typed_start_time(struct compile *c);
/* Functions find and offer of the scope of expressions; slots are indices of symbols. */
bool typed_find(const void *context, struct text name, int *slot);
void typed_offer(const void *context, struct suggestion *suggestion);
/* Explains why an unknown name of that line is not known here, if more can be reported. Always
 * returns false. */
bool typed_explain(struct compile *c, const struct typed_line *line);
