/* SPDX-License-Identifier: GPL-3.0-or-later */
/* library: shared libraries, looked up when they are needed. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

struct library {
    void *handle; /* NULL if it is not loaded */
};

struct library_symbol {
    const char *name;
    size_t offset; /* [byte] of the function pointer in the table */
};

/* Loads the shared library `name` (as for dlopen) and puts `count` of its functions into the table.
 * Returns false if there is no such library (*missing is NULL then) or it has no function *missing.
 * Only the dynamic linker allocates memory. */
bool library_load(struct library *library, const char *name, const struct library_symbol *symbol,
                  size_t count, void *table, const char **missing);
void library_unload(struct library *library);
