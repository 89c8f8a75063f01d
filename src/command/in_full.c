/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Statements without abbreviations, for the history and for files. */
#include "command/in_full.h"

#include <string.h>

/* Returns true if a FILE was given to a command that has --force. */
bool writes_file(const struct arguments *arguments)
{
    const struct command *command = arguments->command;
    bool file = false, force = false;
    for (int i = 0; i < command->arguments; i++) {
        file |= type_is(&command->argument[i], TYPE_IS_FILE) && has_argument_at(arguments, i);
        force |= command->argument[i].form == FORM_OPTION &&
                 strcmp(command->argument[i].name, "force") == 0;
    }
    return file && force;
}

/* Returns true if `part` points into `whole`. */
static bool is_inside(struct text part, struct text whole)
{
    return part.len > 0 && part.data >= whole.data &&
           part.data + part.len <= whole.data + whole.len;
}

/* Returns the choice that begins first at `begin` or after it, or NULL if there is none. */
static const struct item *next_choice(const struct arguments *arguments, struct text statement,
                                      const char *begin)
{
    const struct item *next = NULL;
    for (int i = 0; i < arguments->command->arguments; i++) {
        const struct argument_value *args = &arguments->value[i];
        for (int k = 0; k < args->count; k++) {
            const struct item *item = &args->item[k];
            if (item->row && is_inside(item->text, statement) && item->text.data >= begin &&
                (!next || item->text.data < next->text.data))
                next = item;
        }
    }
    return next;
}

/* Appends the full name if the typed text abbreviates it, else the typed text, which may be an
 * alias. */
static void put_name(struct buffer *output, const char *name, struct text typed)
{
    buffer_put(output, text_starts(text_of(name), typed) ? text_of(name) : typed); /* or an alias */
}

/* Appends the statement with full names for the command word and for chosen rows; the text between
 * them is copied. */
void statement_in_full(const struct session *session, const struct arguments *arguments,
                       struct text statement, struct buffer *output)
{
    const struct text word = arguments->word;
    const char *cursor = statement.data + word.len;
    if (session->execution.meant) {
        buffer_put(output, text_of(session->execution.meant));
        return;
    }
    if (word.len > 0)
        put_name(output, arguments->command->row.name, word);
    if (session->execution.confirmed)
        buffer_put(output, TEXT(" --force"));
    for (const struct item *item; (item = next_choice(arguments, statement, cursor));) {
        buffer_put(output, (struct text){cursor, (size_t)(item->text.data - cursor)});
        put_name(output, item->row->name, item->text);
        cursor = item->text.data + item->text.len;
    }
    buffer_put(output, (struct text){cursor, (size_t)(statement.data + statement.len - cursor)});
}
