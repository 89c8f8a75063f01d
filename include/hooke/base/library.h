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

/* A function to look up, and where library_load() stores its pointer. */
struct library_symbol {
    /* Name of the function in the library. */
    const char *name;
    size_t offset; /* Offset [byte] of its pointer in the struct `table` of library_load(). */
};

/* Loads the shared library `name` (as for dlopen) and stores the pointers to the functions symbol
 * [count] in `table`, a struct of the caller with a member for each. Returns false if the library
 * cannot be loaded (*missing is then NULL) or does not have the function *missing. Memory is
 * allocated by the dynamic linker alone. */
bool library_load(struct library *library, const char *name, const struct library_symbol *symbol,
                  size_t count, void *table, const char **missing);
/* Closes the library. Its code stays in memory, because some libraries keep caches that a second
 * load would not find. */
void library_unload(struct library *library);
