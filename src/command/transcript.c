/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "command/internal.h"
#include "command/transcript.h"

#include <string.h>

static bool writes_file(const struct arguments *arguments)
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

static bool is_choice(const struct argument *argument)
{
    return type_is(argument, TYPE_ABBREVIATED);
}

/* The choice that begins first at `from` or after it; NULL: none. */
static const struct item *next_choice(const struct arguments *arguments, struct text statement,
                                      const char *from)
{
    const struct item *next = NULL;
    for (int i = 0; i < arguments->command->arguments; i++) {
        const struct given_argument *given = &arguments->given[i];
        for (int k = 0; k < given->count && is_choice(&arguments->command->argument[i]); k++) {
            const struct item *item = &given->item[k];
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

/* As a file has to say it: without abbreviations, with the consent that was asked for. */
static void put_in_full(const struct session *session, const struct arguments *arguments,
                        struct text statement, struct buffer *out)
{
    const struct text word = arguments->word;
    const char *at = statement.at + word.len;
    if (word.len > 0)
        put_name(out, arguments->command->row.name, word);
    if (session->confirmed)
        buffer_put(out, TEXT(" --force"));
    for (const struct item *item; (item = next_choice(arguments, statement, at));) {
        buffer_put(out, (struct text){at, (size_t)(item->text.at - at)});
        put_name(out, item->row->name, item->text);
        at = item->text.at + item->text.len;
    }
    buffer_put(out, (struct text){at, (size_t)(statement.at + statement.len - at)});
    buffer_char(out, '\n');
}

void transcript_add(struct session *session, const struct arguments *arguments,
                    struct text statement, bool nested, bool ok, size_t at)
{
    struct buffer *transcript = &session->transcript, later = {0};
    const struct buffer *instead = &session->live.record;
    const bool replaced = !nested && instead->len > 0;
    if ((arguments->command->flags & (COMMAND_UNRECORDED | COMMAND_NESTS)) ||
        writes_file(arguments))
        return;
    buffer_put(&later, (struct text){transcript->data ? transcript->data + at : NULL,
                                     transcript->len - at});
    transcript->len = at;
    if (replaced)
        buffer_put(transcript, buffer_text(instead));
    else
        put_in_full(session, arguments, statement, transcript);
    buffer_put(transcript, buffer_text(&later));
    transcript->failed |= later.failed;
    session->transcript_fails |= !ok && !replaced;
    buffer_free(&later);
}
