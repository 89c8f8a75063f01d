/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion of a sweep: NAME=FROM:TO with the unit behind a number, and what is measured. */
#include <hooke/study/sweep.h>
#include "command/complete/complete.h"
#include <hooke/command/handler.h>

#include <string.h>

void complete_sweep(struct completion *c, const struct command *command, struct text before)
{
    const struct scene *scene = &c->session->setup.scene;
    const struct catalog *names[] = {scene_params(scene), scene_derived(scene)};
    size_t from = before.len;
    while (from > 0 && before.at[from - 1] != '=')
        from--;
    if (text_is(last_word(before), "at")) {
        complete_offer(c, "period", "each of the drive");
        complete_events(c);
        complete_columns(c, NULL);
        return;
    }
    const bool item = from > 0 && strchr("=,:", before.at[before.len - 1]);
    const struct text name = from > 0 ? last_word((struct text){before.at, from - 1}) : TEXT("");
    if (item && text_is(name, "measure")) {
        const char *paren = memchr(c->word.at, '(', c->word.len); /* max(z */
        if (paren)
            c->word = (struct text){paren + 1, (size_t)(c->word.at + c->word.len - paren - 1)};
        else {
            complete_catalog(c, &sweep_measure_catalog);
            complete_offer(c, "rms", "root of the mean square: rms(v)");
        }
        complete_columns(c, NULL);
        return;
    }
    if (item || ends_in_digit(before)) {
        if (from > 0)
            complete_set(c, name, before);
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
    complete_next(c, command, before);
}
