/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The parts that modules add to the terminal layer, and functions that call each of them. */
#include "terminal/parts.h"

#define MODULE(name) extern const struct terminal_part name##_terminal;
#include "lists/terminal.def"
#undef MODULE

#define MODULE(name) &name##_terminal,
const struct terminal_part *const terminal_parts[] = {
#include "lists/terminal.def"
    NULL,
};

/* Lets each part set callbacks of a new front end. */
void terminal_offer(struct front *front, struct streams *streams)
{
    for (size_t i = 0; terminal_parts[i]; i++)
        if (terminal_parts[i]->offer)
            terminal_parts[i]->offer(front, streams);
}

/* Lets each part look at a key; returns the key for readline, or NO_KEY. */
int terminal_key(int key)
{
    for (size_t i = 0; terminal_parts[i] && key != NO_KEY; i++)
        if (terminal_parts[i]->key)
            key = terminal_parts[i]->key(key);
    return key;
}

/* Returns the part that keeps the session in a file, or NULL. */
const struct session_keeper *session_keeper(void)
{
    size_t i = 0;
    while (terminal_parts[i] && !terminal_parts[i]->keeper.word)
        i++;
    return terminal_parts[i] ? &terminal_parts[i]->keeper : NULL;
}

int64_t keeper_due(void)
{
    const struct session_keeper *keeper = session_keeper();
    return keeper ? keeper->due() : INT64_MAX;
}

bool keeper_keep(bool line, struct error *error)
{
    const struct session_keeper *keeper = session_keeper();
    return !keeper || keeper->keep(line, error);
}
