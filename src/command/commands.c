/* SPDX-License-Identifier: GPL-3.0-or-later */
/* All commands in one table: the rows at the bottom of every file in commands.def. */
#define COMMAND_ROWS
#define COMMAND(id, ...) bool command_##id(HANDLER_PARAMETERS);
#include <hooke/plot.h>
#include <hooke/report.h>
#include <hooke/command/handler.h>
#include <hooke/command/figure_arguments.h>

#include "command/commands.def"
#include "lists/commands.def"
#undef COMMAND

#define COMMAND(id, ...) {.handler = command_##id, __VA_ARGS__},
static const struct command commands[] = {
#include "command/commands.def"
#include "lists/commands.def"
};

const struct catalog command_catalog = CATALOG("command", commands);

const struct command *command_with(enum command_flag flag)
{
    const struct command *command = commands;
    while (!(command->flags & flag))
        command++;
    return command;
}
