/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The line of usage of a command, such as "run [DURATION | to T] [--force]", made from its table of
 * arguments. */
#include <hooke/language.h>

/* Appends the usage of an argument's item: the name of one known by its position, "V" or "FILE" by
 * its type, "T" for a time that follows a word ("to T"), or the choices themselves if they are
 * few. */
static void put_item(const struct argument *argument, struct buffer *output)
{
    const struct argument_type_row *type = argument_type(argument);
    if ((type->flags & TYPE_SHOWS_CHOICES) && argument->choices->count <= USAGE_CHOICES) {
        for (size_t i = 0; i < argument->choices->count; i++)
            buffer_format(output, "%s%s", i ? "|" : "", catalog_row(argument->choices, i)->name);
        if (type->flags & TYPE_SHOWS_BOTH)
            buffer_format(output, "|%s", type->shown);
    } else if (argument->form == FORM_PLACE) {
        buffer_put(output, text_of(argument->name));
    } else if (argument->form == FORM_WORD && argument->type == TYPE_VALUE &&
               argument->quantity == QUANTITY_TIME) {
        buffer_char(output, 'T');
    } else {
        buffer_put(output, text_of(type->shown));
    }
    if (argument->flags & ARG_MANY)
        buffer_put(output, argument->form == FORM_KEY ? TEXT(",..") : TEXT(".."));
    if (argument->flags & ARG_ALL)
        buffer_put(output, TEXT("|all"));
}

/* Appends the usage of one argument, such as "dt=V", "--force" or "DURATION". */
void argument_usage(const struct argument *argument, struct buffer *output)
{
    if (argument->form == FORM_OPTION)
        buffer_put(output, TEXT("--"));
    if (argument->form != FORM_PLACE)
        buffer_put(output, text_of(argument->name));
    if (argument->type == TYPE_NONE)
        return;
    if (argument->form != FORM_PLACE)
        buffer_char(output, argument->form == FORM_KEY ? '=' : ' ');
    put_item(argument, output);
}

/* Appends the usage of a command: optional arguments in brackets, arguments that exclude each other
 * separated by "|". */
void command_usage(const struct command *command, struct buffer *text)
{
    buffer_put(text, text_of(command->row.name));
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        const bool required = (argument->flags & ARG_REQUIRED) != 0;
        buffer_put(text, required ? TEXT(" ") : TEXT(" ["));
        if (argument->lead)
            buffer_format(text, "%s ", argument->lead);
        argument_usage(argument, text);
        while (argument->group && i + 1 < command->arguments &&
               command->argument[i + 1].group == argument->group) {
            buffer_char(text, '|');
            argument_usage(&command->argument[++i], text);
        }
        if (!required)
            buffer_char(text, ']');
        if (argument->more)
            buffer_format(text, " %s", argument->more);
    }
    if (command->flags & COMMAND_TABLES)
        buffer_put(text, TEXT(" [> FILE]"));
}
