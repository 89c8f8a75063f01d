/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the commands that take an argument which was given to another command, for hints
 * (finding.c). */
#include "command/finding.h"

/* Returns true if the argument has that name or, with as_choice, such a choice. A bare word never
 * means a key. */
static bool is_named(const struct argument *argument, struct text word, bool as_choice,
                     enum argument_form form)
{
    if (as_choice)
        return (argument->choices && catalog_find(argument->choices, word)) ||
               ((argument->flags & ARG_ALL) && text_is(word, "all"));
    return argument->form != FORM_PLACE && text_is(word, argument->name) &&
           argument->name[0] != '>' && (form != FORM_WORD || argument->form != FORM_KEY);
}

/* Returns the argument of the command with that name (or choice), preferably of that form; NULL if
 * there is none. */
static const struct argument *find_taken(const struct command *command, struct text word,
                                         bool as_choice, enum argument_form form)
{
    const struct argument *found = NULL;
    for (int i = 0; i < command->arguments; i++)
        if (is_named(&command->argument[i], word, as_choice, form) &&
            (!found || command->argument[i].form == form))
            found = &command->argument[i];
    return found;
}

/* Appends, in quotes, how the command is written with `argument` and with the arguments that it
 * requires. With as_choice the argument's value is `word`, one of its choices; otherwise the
 * argument appears as in the usage. */
static void put_taker(const struct command *command, const struct argument *argument,
                      struct text word, bool as_choice, struct buffer *text)
{
    buffer_format(text, "'%s ", command->row.name);
    for (int i = 0; i < command->arguments; i++)
        if ((command->argument[i].flags & ARG_REQUIRED) && &command->argument[i] != argument) {
            argument_usage(&command->argument[i], text);
            buffer_char(text, ' ');
        }
    if (!as_choice) {
        argument_usage(argument, text);
    } else {
        if (argument->form == FORM_KEY || argument->form == FORM_WORD)
            buffer_format(text, "%s%s", argument->name, argument->form == FORM_KEY ? "=" : " ");
        buffer_put(text, word);
    }
    buffer_char(text, '\'');
}

/* Appends at most `most` commands other than this one that take the word, as the name of an
 * argument or, with as_choice, as one of its choices; those that take it in the typed `form` come
 * first. Returns false, and appends nothing, if there are none. */
static bool put_others(const struct command *command, struct text word, bool as_choice,
                       enum argument_form form, int most, struct buffer *text)
{
    int count = 0;
    /* those that take it in the form that was typed come first */
    for (int same = 1; same >= 0; same--)
        for (size_t i = 0; i < command_catalog.count; i++) {
            const struct command *other = command_at(catalog_row(&command_catalog, i));
            const struct argument *argument = find_taken(other, word, as_choice, form);
            if (other == command || !argument || (argument->form == form) != same)
                continue;
            if (++count > most)
                continue;
            buffer_put(text, count > 1 ? TEXT(", ") : TEXT(""));
            put_taker(other, argument, word, as_choice, text);
        }
    if (count > most)
        buffer_format(text, " and %d more", count - most);
    if (count > 0)
        buffer_format(text, " %s it", count > 1 ? "take" : "takes");
    return count > 0;
}

/* Appends how the command itself takes the word in another form, else which other commands take it,
 * by name or by choice. Returns false if none does. */
bool put_takers(const struct command *command, struct text word, enum argument_form form, int most,
                struct buffer *text)
{
    const struct argument *own = command ? find_taken(command, word, false, form) : NULL;
    if (own && own->form == form)
        return false;
    if (own) {
        put_taker(command, own, word, false, text);
        buffer_put(text, TEXT(" is how it is written"));
        return true;
    }
    return put_others(command, word, false, form, most, text) ||
           (form == FORM_WORD && put_others(command, word, true, form, most, text));
}
