/* SPDX-License-Identifier: GPL-3.0-or-later */
/* row: the first member of every struct that is a row of a catalog (<hooke/base/catalog.h>). Texts
 * are constants of the program, or live as long as the table. */
#pragma once

/* The texts of a row that users see. */
struct row {
    const char *name;     /* Word that users type. */
    const char *unit;     /* Unit of the row's value, such as "kg", or "" if it has none. */
    const char *brief;    /* Description in one line, for lists and completion. */
    const char *citation; /* Source as "Author Year, equation", or "". */
    const char *alias;    /* Other names that find the row, separated by blanks, or NULL. */
};
