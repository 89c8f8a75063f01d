/* SPDX-License-Identifier: GPL-3.0-or-later */
/* row: the beginning of each row of a table that users choose from by name. */
#ifndef HOOKE_BASE_ROW_H
#define HOOKE_BASE_ROW_H

struct row {
    const char *name;     /* word that users type */
    const char *unit;     /* unit of its value, "" if none */
    const char *brief;    /* one line for lists */
    const char *citation; /* author year equation, or "" */
    const char *alias;    /* other names, separated by blanks, or NULL */
};

#endif
