/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The line of usage, made from the arguments. */
#include <hooke/language.h>

#include <string.h>

/* What stands for an item in usage: "V", "FILE", the choices themselves where they are few. */
static void put_item(const struct argument *argument, struct buffer *out)
{
    static const char *const shown[] = {
        [TYPE_VALUE] = "V",        [TYPE_INTEGER] = "N",      [TYPE_RANGE] = "FROM:TO",
        [TYPE_CONDITION] = "COND", [TYPE_EXPR] = "EXPR",      [TYPE_UNIT] = "UNIT",
        [TYPE_RUN] = "N",          [TYPE_RECORDING] = "NAME", [TYPE_NAME] = "NAME",
        [TYPE_SCENE] = "NAME",     [TYPE_TEXT] = "TEXT",      [TYPE_FILE] = "FILE",
        [TYPE_REST] = "TEXT",      [TYPE_FORMULA] = "EXPR",   [TYPE_COLUMN] = "COLUMN",
        [TYPE_PARAM] = "NAME",     [TYPE_EVENT] = "EVENT",    [TYPE_START] = "START"};
    const bool model = argument->type == TYPE_MODEL;
    if (model || (argument->type == TYPE_CHOICE && argument->choices->count <= USAGE_CHOICES)) {
        for (size_t i = 0; i < argument->choices->count; i++)
            buffer_format(out, "%s%s", i ? "|" : "", catalog_row(argument->choices, i)->name);
        buffer_put(out, model ? TEXT("|EXPR") : TEXT(""));
    } else if (argument->form == FORM_PLACE) {
        buffer_put(out, text_of(argument->name));
    } else {
        buffer_put(out, text_of(argument->type == TYPE_CHOICE ? "NAME" : shown[argument->type]));
    }
    if (argument->flags & ARG_MANY)
        buffer_put(out, argument->form == FORM_KEY ? TEXT(",..") : TEXT(".."));
    if (argument->flags & ARG_ALL)
        buffer_put(out, TEXT("|all"));
}

static void put_argument(const struct argument *argument, struct buffer *out)
{
    if (argument->form == FORM_OPTION)
        buffer_put(out, TEXT("--"));
    if (argument->form != FORM_PLACE)
        buffer_put(out, text_of(argument->name));
    if (argument->type == TYPE_NONE)
        return;
    if (argument->form != FORM_PLACE)
        buffer_char(out, argument->form == FORM_KEY ? '=' : ' ');
    put_item(argument, out);
}

void command_usage(const struct command *command, struct buffer *text)
{
    buffer_put(text, text_of(command->row.name));
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        const bool required = (argument->flags & ARG_REQUIRED) != 0;
        buffer_put(text, required ? TEXT(" ") : TEXT(" ["));
        if (argument->lead)
            buffer_format(text, "%s ", argument->lead);
        put_argument(argument, text);
        while (argument->group && i + 1 < command->arguments &&
               command->argument[i + 1].group == argument->group) {
            buffer_char(text, '|');
            put_argument(&command->argument[++i], text);
        }
        if (!required)
            buffer_char(text, ']');
    }
    if (command->flags & COMMAND_TABLES)
        buffer_put(text, TEXT(" [> FILE]"));
}
