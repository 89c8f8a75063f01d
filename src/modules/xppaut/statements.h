/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The statements of an .ode file, before names and formulas are what typed scenes have. */
#pragma once

#include "modules/xppaut/ode.h"

struct ode_set {
    struct text name, values;
    int line;
};

struct ode_value { /* an initial value */
    struct text name;
    double value;
    int line;
};

struct ode_statements {
    struct ode ode;
    struct ode_settings settings;
    const struct ode_line *line; /* [lines] as they were read: no array is longer */
    int lines;
    struct ode_value *initial;
    struct ode_set *set;
    struct ode_line *event; /* events without their first word */
    struct ode_note *note;
    int initials, initial_capacity, sets, events, notes, note_capacity;
};

/* Makes room for one more in *array. */
bool ode_grow(struct ode *ode, void *array, int count, int *capacity, size_t size);
/* Handles all lines. Returns false with an error, also if something is not supported. */
bool ode_statements(struct ode_statements *s, struct error *error);
bool ode_note(struct ode_statements *s, int line, bool warns, const char *format, ...)
    PRINTF_LIKE(4, 5);
