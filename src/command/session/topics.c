/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The topics of help (tasks of a newcomer with lines that can be pasted), and the lists of
 * commands. */
#include "command/session/topics.h"

#include <string.h>

static const struct guide_topic topics[] = {
#define TOPIC_TEXT(id, name, says, explains, lines, others)                                        \
    {.row = {name, "", says, "", NULL}, .text = explains, .recipe = lines},
#include "lists/help.def"
};

const struct catalog guide_catalog = CATALOG("topic", topics);

/* Lists all commands by group, in the order of their first commands. */
void help_commands(struct buffer *text)
{
    for (size_t first = 0; first < command_catalog.count; first++) {
        const char *group = command_at(catalog_row(&command_catalog, first))->group;
        bool is_new = true;
        for (size_t i = 0; i < first && is_new; i++)
            is_new = strcmp(command_at(catalog_row(&command_catalog, i))->group, group) != 0;
        if (is_new)
            buffer_format(text, "%s%s\n", first ? "\n" : "", group);
        for (size_t i = first; is_new && i < command_catalog.count; i++) {
            const struct command *command = command_at(catalog_row(&command_catalog, i));
            if (strcmp(command->group, group) == 0)
                buffer_format(text, "  %-12s %s\n", command->row.name, command->row.brief);
        }
    }
}

/* Lists the topics with a line each, then the names of all commands. */
void help_all(struct buffer *text)
{
    buffer_put(text,
               TEXT("A laboratory for oscillators and integration methods. To begin with:\n"));
    for (size_t i = 0; i < guide_catalog.count; i++) {
        const struct row *row = catalog_row(&guide_catalog, i);
        buffer_format(text, "  help %-10s %s\n", row->name, row->brief);
    }
    buffer_put(text,
               TEXT("help WORD explains a word, apropos WORD searches for it. All commands:\n"));
    for (size_t i = 0; i < command_catalog.count; i++)
        buffer_format(text, "%s%s", i ? " " : "", catalog_row(&command_catalog, i)->name);
}
