/* SPDX-License-Identifier: GPL-3.0-or-later */
/* row: the beginning of each row of a table that users choose from by name. */
#pragma once

struct row {
    const char *name;     /* word that users type */
    const char *unit;     /* unit of its value, "" if none */
    const char *brief;    /* one line for lists */
    const char *citation; /* author year equation, or "" */
    const char *alias;    /* other names, separated by blanks, or NULL */
};
