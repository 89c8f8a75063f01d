/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of readline that line.c replaces, by name, for the static program: the archive that
 * it is linked with contains them a second time as own_NAME (see `make static`). */
#include <dlfcn.h>
#include <string.h>

void own_rl_add_undo(void);
void own_rl_insert_text(void);
void own_rl_newline(void);

#define OWN(name)                                                                                  \
    {                                                                                              \
#name, own_##name                                                                          \
    }

void *__wrap_dlsym(void *handle, const char *name);
/* Returns readline's function of this name, or NULL if it is none of the three that are looked up.
 * Linked in place of dlsym, which finds nothing in a static program; `handle` is ignored. */
void *__wrap_dlsym(void *handle, const char *name)
{
    static const struct {
        const char *name;
        void (*function)(void);
    } own[] = {OWN(rl_add_undo), OWN(rl_insert_text), OWN(rl_newline)};
    void *found = NULL;
    (void)handle;
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (strcmp(own[i].name, name) == 0)
            memcpy(&found, &own[i].function, sizeof found);
    return found;
}
