/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion of the grid of a sweep, NAME=FROM:TO, with units behind numbers. */
#include <hooke/command/complete.h>
#include <hooke/command/handler.h>

#include <string.h>

/* Finds the name of the last NAME= before the word. Returns true if the word is its value. */
bool complete_is_item(struct text preceding, struct text *name)
{
    size_t begin = preceding.len;
    while (begin > 0 && preceding.data[begin - 1] != '=')
        begin--;
    *name = begin > 0 ? last_word((struct text){preceding.data, begin - 1}) : TEXT("");
    return begin > 0 && strchr("=,:", preceding.data[preceding.len - 1]);
}

/* Offers values behind NAME=, else the names that a sweep can vary. */
void complete_grid(struct completion *c, const struct command *command, struct text preceding)
{
    const struct scene *scene = &c->session->setup.scene;
    const struct catalog *names[] = {scene_params(scene), scene_derived(scene)};
    struct text name;
    const bool item = complete_is_item(preceding, &name);
    if (item || ends_in_digit(preceding)) {
        if (name.len > 0)
            complete_set(c, name, preceding);
        if (item)
            return;
    }
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (size_t j = 0; j < names[i]->count; j++) {
            const struct row *row = catalog_row(names[i], j);
            if (i == 0 || ((const struct derived_row *)(const void *)row)->inverse)
                complete_affixed(c, "", row->name, "=", row->brief);
        }
    complete_affixed(c, "", "dt", "=", "");
    complete_affixed(c, "", "tol", "=", "");
    complete_next(c, command, preceding);
}
