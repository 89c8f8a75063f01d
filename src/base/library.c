/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared libraries that are looked up when they are needed: linking them would cost every start of
 * the program. */
#include <hooke/base/library.h>

#include <dlfcn.h>
#include <string.h>

bool library_load(struct library *library, const char *name, const struct library_symbol *symbol,
                  size_t count, void *table, const char **missing)
{
    *missing = NULL;
    /* It stays in memory: some libraries keep caches that only they can find. */
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
