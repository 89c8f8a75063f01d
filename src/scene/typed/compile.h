/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations shared by the makers of typed models: names while expressions are read, before their
 * meaning is known. */
#pragma once

#include "scene/typed/typed.h"

struct suggestion;

enum symbol_kind {
    SYMBOL_TIME,
    SYMBOL_VARIABLE,
    SYMBOL_VELOCITY,
    SYMBOL_STATE,
    SYMBOL_PARAM,
    SYMBOL_OBSERVED
};

struct symbol {
    char name[LIMIT_SYMBOL + 1];
    enum symbol_kind kind;
    int index;   /* index among symbols of its kind */
    int primed;  /* symbol whose derivative a velocity is */
    bool hidden; /* not to be used in expressions */
    bool used;
    int slot; /* as the equations count */
};

/* A variable that has an equation, or is going to have one. */
struct unknown {
    /* speed is the line var y' = …; NULL if a line is missing */
    const struct typed_line *line, *speed, *equation;
    int symbol, velocity; /* symbols, velocity -1: none */
    const struct expr *expr;
    int order;
};

struct compile {
    struct typed *typed;
    struct error *error;
    struct symbol *symbol;
    int symbols;
    struct unknown *unknown;
    int unknowns;
    struct param_row *own; /* parameters that are not those of the base */
    int owns, bases;
    const struct expr **force; /* [lines] */
    int state;                 /* state variables of the base, 0 if there is none */
};

/* ---- typed_names.c ---- */

static inline bool symbol_is(const struct symbol *symbol, struct text name)
{
    const size_t last = name.len - 1; /* names like x1 and x2 differ in their last byte */
    return name.len > 0 && name.len <= LIMIT_SYMBOL && symbol->name[name.len] == '\0' &&
           symbol->name[last] == name.data[last] && memcmp(symbol->name, name.data, last) == 0;
}

/* All names but those of observed quantities. */
bool typed_declare(struct compile *c);
/* Adds a symbol. Returns -1 if the name is taken. */
int typed_symbol(struct compile *c, struct text name, enum symbol_kind kind, int index,
                 struct text where);
/* The parameter that is a variable's value at the start (line NULL: 0), and t0; not for
 * expressions. */
bool typed_initial(struct compile *c, struct text variable, const struct typed_line *line,
                   enum quantity quantity, struct text where);
bool typed_start_time(struct compile *c);
/* The scope of expressions. */
bool typed_find(const void *context, struct text name, int *slot);
void typed_offer(const void *context, struct suggestion *suggestion);
/* Explains why an unknown name of that line is not known here, if more can be reported. Always
 * returns false. */
bool typed_explain(struct compile *c, const struct typed_line *line);
