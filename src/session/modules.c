/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The modules of this build: their list, which the build generates, what they offer the core, and
 * their parts of a session. */
#include <hooke/module.h>
#include <hooke/session/stored.h>

#include <stdlib.h>
#include <string.h>

#define MODULE(name) extern const struct module name##_module;
#include "lists/modules.def"
#undef MODULE

#define MODULE(name) &name##_module,
const struct module *const module_list[] = {
#include "lists/modules.def"
    NULL,
};
_Static_assert(COUNT_OF(module_list) <= LIMIT_MODULES + 1,
               "there are more modules than a session can hold");

const char *const module_left_out[] = {
#include "lists/left_out.def"
    NULL,
};

/* Appends a line with the modules of this build. */
void modules_put(struct buffer *text)
{
    buffer_put(text, TEXT("modules  "));
    for (size_t i = 0; module_list[i]; i++)
        buffer_format(text, " %s", module_list[i]->row.name);
    buffer_put(text, module_list[0] ? TEXT("\n") : TEXT(" none\n"));
}

/* Appends the prompt's label of the first module that has one. */
void modules_label(const struct session *session, struct buffer *text)
{
    const size_t old_len = text->len;
    for (size_t i = 0; module_list[i] && text->len == old_len; i++)
        if (module_list[i]->prompt.label)
            module_list[i]->prompt.label(session, text);
}

/* ---- modules that were left out ---- */

/* Returns true if the command or option `what` is part of this build; otherwise sets an error that
 * names its module. */
bool module_is_in(const char *what, struct text word, struct error *error)
{
    static const char *const missing[][2] = {
#define MISSING(what, module) {what, module},
#include "lists/missing.def"
        {NULL, NULL},
    };
    size_t i = 0;
    while (missing[i][0] && strcmp(what, missing[i][0]) != 0)
        i++;
    if (!missing[i][0])
        return true;
    error_at(error, word, "'%s' belongs to the module %s, which this program was built without",
             what, missing[i][1]);
    error->code = ERROR_USAGE;
    return error_hint(error, "'hooke --version' lists the modules");
}

/* ---- studies that were stopped and can continue ---- */

/* Returns the module with a stopped study that can continue, or NULL. */
const struct module *module_waiting(const struct session *session)
{
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->stopped.waits && module_list[i]->stopped.waits(session))
            return module_list[i];
    return NULL;
}

void modules_forget_stopped(struct session *session)
{
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->stopped.waits)
            module_list[i]->stopped.forget(session);
}

/* ---- functions that modules offer the core ---- */

/* Returns the functions for series of the module that has them, or NULL. */
const struct series_tools *series_tools(void)
{
    size_t i = 0;
    while (module_list[i] && !module_list[i]->series)
        i++;
    return module_list[i] ? module_list[i]->series : NULL;
}

/* Returns the same functions; if there are none, sets an error for the command `what`. */
const struct series_tools *series_tools_for(const char *what, struct text word, struct error *error)
{
    const struct series_tools *tools = series_tools();
    if (!tools)
        module_is_in(what, word, error);
    return tools;
}

/* Returns the functions for stored sessions of the module that has them, or NULL. */
const struct store_tools *store_tools(void)
{
    size_t i = 0;
    while (module_list[i] && !module_list[i]->keeps)
        i++;
    return module_list[i] ? module_list[i]->keeps : NULL;
}

/* Returns the writer of pictures of the module that has one, or NULL. */
const struct picture_writer *module_pictures(void)
{
    size_t i = 0;
    while (module_list[i] && !module_list[i]->pictures.files)
        i++;
    return module_list[i] ? &module_list[i]->pictures : NULL;
}

/* ---- parts of a session ---- */

/* Returns what the module keeps in the session, or NULL if nothing yet. */
void *session_part_if_made(const struct session *session, const struct module *module)
{
    const struct session_parts *parts = session->parts;
    for (int i = 0; i < parts->count; i++)
        if (parts->item[i].module == module)
            return parts->item[i].state;
    return NULL;
}

/* Returns what the module keeps in the session, made on the first call; NULL if out of memory. */
void *session_part(const struct session *session, const struct module *module)
{
    struct session_parts *parts = session->parts;
    void *state = session_part_if_made(session, module);
    if (!state && (state = calloc(1, module->part_size)))
        parts->item[parts->count++] = (struct session_part){module, state};
    return state;
}

/* Frees what modules keep in the session. */
void session_free_parts(struct session *session)
{
    struct session_parts *parts = session->parts;
    for (int i = 0; i < parts->count; i++) {
        if (parts->item[i].module->part_free)
            parts->item[i].module->part_free(parts->item[i].state);
        free(parts->item[i].state);
    }
    free(parts);
}
