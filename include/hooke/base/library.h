/* SPDX-License-Identifier: GPL-3.0-or-later */
/* library: loads shared libraries and finds their functions when they are first needed, so that the
 * program starts without them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* A shared library; zero-initialise it, and end with library_unload(). */
struct library {
    void *handle; /* Handle of dlopen(), or NULL if it is not loaded. */
};

/* A function to look up, and the position of its pointer in a struct of function pointers. */
struct library_symbol {
    /* Name of the function in the library. */
    const char *name;
    size_t offset; /* Offset [byte] of the function pointer in the table. */
};

/* Loads the shared library `name` (as for dlopen) and stores pointers to `count` functions in
 * `table`, a struct of the caller. Returns false if the library cannot be loaded (*missing is NULL)
 * or lacks the function *missing. Memory is allocated by the dynamic linker alone. */
bool library_load(struct library *library, const char *name, const struct library_symbol *symbol,
                  size_t count, void *table, const char **missing);
/* Closes the library. Its code stays in memory, because some libraries keep caches that a second
 * load would not find. */
void library_unload(struct library *library);
