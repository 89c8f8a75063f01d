/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The statements of an .ode file: all its names, settings and events, with formulas still as
 * text. */
#pragma once

#include "modules/xppaut/ode.h"

/* A set of values, `set NAME {NAME=VALUE,...}`. */
struct ode_set {
    struct text name, values; /* name, and what follows it */
    int line;
};

struct ode_value { /* an initial value */
    struct text name;
    double value;
    int line;
};

/* Everything that the lines of a file say. */
struct ode_statements {
    struct ode ode;
    struct ode_settings settings;
    const struct ode_line *line; /* [lines] of the file */
    int lines;
    /* [initials] initial values, of which the last one for a name holds */
    struct ode_value *initial;
    struct ode_set *set;    /* [sets] */
    struct ode_line *event; /* [events] lines of events without their first word */
    struct ode_note *note;  /* [notes] */
    int initials, initial_capacity, sets, events, notes, note_capacity;
};

/* Makes room in the array at *array, of `count` entries of `size` bytes, for one more. Returns
 * false with an error if out of memory. */
bool ode_grow(struct ode *ode, void *array, int count, int *capacity, size_t size);
/* Takes all lines; s->ode.arena, line and lines must be set. Returns false with an error, also if
 * something is not supported or if cancelled. */
bool ode_statements(struct ode_statements *s, struct error *error);
/* Adds a note on a line, which `warns` if something is left out; a note that exists already, or too
 * many, are dropped. Returns false with an error if out of memory. */
bool ode_note(struct ode_statements *s, int line, bool warns, const char *format, ...)
    PRINTF_LIKE(4, 5);
