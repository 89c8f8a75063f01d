/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command recipe: executes the lines of a topic of help. */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>
#include "command/session/topics.h"

/* Shows each line as if it were typed and executes it. */
HANDLER(recipe)
{
    UNUSED(error);
    const struct row *row = argument_value(args, "TOPIC")->item->row;
    const struct guide_topic *topic = (const struct guide_topic *)(const void *)row;
    static const struct source prompt = {.name = NULL};
    struct text rest = text_of(topic->recipe), line;
    struct script script;
    script_begin(&script, session, row->name, args->where ? args->where : &prompt);
    while (rest.len > 0 && !script.stopped && text_split(&rest, '\n', &line)) {
        reply_line(reply, "hooke> %.*s", (int)line.len, line.data);
        script_feed(&script, session, line, reply);
    }
    /* The script has already reported its error; the error stays without a code. */
    return script_end(&script, session, reply);
}
#endif

COMMAND(recipe, .group = "SESSION", .flags = COMMAND_NESTS,
        ARGUMENTS(PLACE("TOPIC", TYPE_CHOICE, .flags = ARG_REQUIRED, .choices = &guide_catalog)))
