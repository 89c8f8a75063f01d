/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "command/in_full.h"

#include <string.h>

bool writes_file(const struct arguments *arguments)
{
    const struct command *command = arguments->command;
    bool file = false, force = false;
    for (int i = 0; i < command->arguments; i++) {
        file |= type_is(&command->argument[i], TYPE_IS_FILE) && has(arguments, i);
        force |= command->argument[i].form == FORM_OPTION &&
                 strcmp(command->argument[i].name, "force") == 0;
    }
    return file && force;
}

static bool is_inside(struct text part, struct text whole)
{
    return part.len > 0 && part.at >= whole.at && part.at + part.len <= whole.at + whole.len;
}

/* Returns the choice that begins first at `from` or after it, or NULL if there is none. */
static const struct item *next_choice(const struct arguments *arguments, struct text statement,
                                      const char *from)
{
    const struct item *next = NULL;
    for (int i = 0; i < arguments->command->arguments; i++) {
        const struct argument_value *args = &arguments->value[i];
        for (int k = 0; k < args->count; k++) {
            const struct item *item = &args->item[k];
            if (item->row && is_inside(item->text, statement) && item->text.at >= from &&
                (!next || item->text.at < next->text.at))
                next = item;
        }
    }
    return next;
}

static void put_name(struct buffer *out, const char *name, struct text typed)
{
    buffer_put(out, text_starts(text_of(name), typed) ? text_of(name) : typed); /* or an alias */
}

void statement_in_full(const struct session *session, const struct arguments *arguments,
                       struct text statement, struct buffer *out)
{
    const struct text word = arguments->word;
    const char *at = statement.at + word.len;
    if (session->execution.meant) {
        buffer_put(out, text_of(session->execution.meant));
        return;
    }
    if (word.len > 0)
        put_name(out, arguments->command->row.name, word);
    if (session->execution.confirmed)
        buffer_put(out, TEXT(" --force"));
    for (const struct item *item; (item = next_choice(arguments, statement, at));) {
        buffer_put(out, (struct text){at, (size_t)(item->text.at - at)});
        put_name(out, item->row->name, item->text);
        at = item->text.at + item->text.len;
    }
    buffer_put(out, (struct text){at, (size_t)(statement.at + statement.len - at)});
}
