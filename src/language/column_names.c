/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds out which words of a statement can be names of columns, beside those of the catalogs. */
#include "language/column_names.h"

#include <hooke/base/statement.h>
#include <hooke/run.h>

#include <string.h>

/* Returns true if a typed scene, of the session or of a run, has this variable or observed one. */
bool session_has_typed_variable(const struct session *session, struct text name)
{
    bool known = false;
    for (int i = -1; i < session->runs.count && !known; i++) {
        const struct model *model =
            i < 0 ? session->setup.scene.model : session->runs.slot[i]->run->system.model;
        known = model->typed &&
                (model_variable(model, name) >= 0 || model_observation(model, name) >= 0);
    }
    return known;
}

/* Returns true if a table that a study left has a column of this name. */
bool session_has_found_column(const struct session *session, struct text name)
{
    const struct table_store *found = &session->studies.found;
    for (int i = 0; i < found->count; i++)
        for (int c = 0; c < found->table[i]->table.columns; c++)
            if (text_is(name, found->table[i]->table.column[c].name))
                return true;
    return false;
}

/* Returns true if the rest of the statement contains the word `of`, outside of strings. */
bool statement_has_of(struct text rest)
{
    for (struct text word; (rest = text_trim(rest)).len > 0;) {
        word = peek_word(rest, "");
        if (text_is(word, "of"))
            return true;
        size_t used = 0;
        while (used < word.len && !strchr("'\"", rest.data[used]))
            used++;
        const struct text string = {rest.data + used, rest.len - used};
        if (string.len && strchr("'\"", string.data[0]))
            used += text_quoted(string);
        used = used ? used : 1;
        rest = text_after(rest, used);
    }
    return false;
}
