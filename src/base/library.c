/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Loads shared libraries when they are needed, since linking them would slow down every start of
 * the program. */
#include <hooke/base/library.h>

#include <dlfcn.h>
#include <string.h>

/* Loads a library and looks up its symbols in the table. Returns false if it is missing, or lacks
 * the symbol *missing. */
bool library_load(struct library *library, const char *name, const struct library_symbol *symbol,
                  size_t count, void *table, const char **missing)
{
    *missing = NULL;
    /* NODELETE, because caches of some libraries would be lost memory if they were unloaded. */
    library->handle = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    for (size_t i = 0; i < count && library->handle; i++) {
        void *found = dlsym(library->handle, symbol[i].name);
        if (!found) {
            *missing = symbol[i].name;
            library_unload(library);
            return false;
        }
        /* ISO C has no cast from an object pointer to a function pointer: the bytes are copied. */
        memcpy((char *)table + symbol[i].offset, &found, sizeof found);
    }
    return library->handle != NULL;
}

void library_unload(struct library *library)
{
    if (library->handle)
        dlclose(library->handle);
    library->handle = NULL;
}
