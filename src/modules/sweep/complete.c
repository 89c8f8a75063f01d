/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion of `sweep` where it is not NAME=FROM:TO: events of a section, and measures. */
#include <hooke/command/complete.h>
#include "modules/sweep/handlers.h"

#include <string.h>

/* Offers completions of `sweep`: events after `at`, measures after `measure=`, and columns within
 * their parentheses. Returns false if none apply at the end of prefix. */
bool sweep_complete(struct completion *c, const struct command *command, struct text prefix)
{
    struct text name;
    if (strcmp(command->row.name, "sweep") != 0)
        return false;
    if (text_is(last_word(prefix), "at")) {
        complete_offer(c, "period", "each period of the drive");
        complete_events(c);
        complete_columns(c, NULL);
        return true;
    }
    if (!complete_is_item(prefix, &name) || !text_is(name, "measure"))
        return false;
    const char *paren = memchr(c->word.data, '(', c->word.len); /* max(z */
    if (paren)
        c->word = (struct text){paren + 1, (size_t)(c->word.data + c->word.len - paren - 1)};
    else {
        complete_catalog(c, &sweep_measure_catalog);
        complete_offer(c, "rms", "root mean square: rms(v)");
    }
    complete_columns(c, NULL);
    return true;
}
