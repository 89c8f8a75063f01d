/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The catalog of commands. It is made of the rows at the bottom of the files in commands.def (and
 * those of modules), with their texts in the help.txt beside each file. */
#define COMMAND_ROWS
#define COMMAND(id, ...)                                                                           \
    bool command_##id(HANDLER_PARAMETERS);                                                         \
    enum { IS_COMMAND_##id = true };
#include <hooke/plot.h>
#include <hooke/report.h>
#include <hooke/command/handler.h>
#include <hooke/command/figure_arguments.h>

#include "lists/arguments.def"

#include "command/commands.def"
#include "lists/commands.def"
#undef COMMAND

/* A text without a command, or a command without a text, ends the build. */
#define COMMAND_TEXT(id, name, says, explains, lines, others)                                      \
    _Static_assert(IS_COMMAND_##id, "");                                                           \
    static const char brief_##id[] = says, text_##id[] = explains, examples_##id[] = lines,        \
                      see_##id[] = others;
#include "lists/help.def"

#define COMMAND(id, ...)                                                                           \
    {.row.name = #id,                                                                              \
     .row.unit = "",                                                                               \
     .row.brief = brief_##id,                                                                      \
     .row.citation = "",                                                                           \
     .text = text_##id,                                                                            \
     .examples = examples_##id,                                                                    \
     .see = see_##id,                                                                              \
     .handler = command_##id,                                                                      \
     __VA_ARGS__},
static const struct command commands[] = {
#include "command/commands.def"
#include "lists/commands.def"
};

const struct catalog command_catalog = CATALOG("command", commands);

/* Returns the command with this flag, which exactly one command has. */
const struct command *command_with(enum command_flag flag)
{
    const struct command *command = commands;
    while (!(command->flags & flag))
        command++;
    return command;
}
