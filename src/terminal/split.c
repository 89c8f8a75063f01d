/* SPDX-License-Identifier: GPL-3.0-or-later */
/* --split DIR: each table of the results in CSV as a file of its own, all or none. */
#include "terminal/terminal.h"

#include <stdio.h>
#include <string.h>
#include <string.h>

/* Returns true for names of files that are removed from a folder that is given up. */
static bool is_part(const char *name)
{
    const size_t digits = strspn(name, "0123456789"), len = strlen(name);
    return digits >= 3 && name[digits] == '-' && len > 4 && strcmp(name + len - 4, ".csv") == 0;
}

bool split_begin(struct split *split, const char *path, bool safe, struct error *error)
{
    *split = (struct split){.count = 0};
    split->open =
        folder_open(&split->folder, path, (struct write_policy){.confine = safe}, is_part, error);
    if (split->open || !strstr(error->text, "--force"))
        return split->open;
    error_set(error, ERROR_IO, "%s is there already", path);
    return error_hint(error, "name a folder that is not there yet");
}

static void put_part(struct split *split)
{
    if (split->count > 0 && !split->failed &&
        !(split->content.failed ? error_memory(&split->error)
                                : folder_put(&split->folder, split->name,
                                             buffer_text(&split->content), &split->error)))
        split->failed = true;
    buffer_clear(&split->content);
}

void split_part(void *context, const char *kind)
{
    struct streams *streams = context;
    struct split *split = streams->split;
    put_part(split);
    snprintf(split->name, sizeof split->name, "%03d-%s.csv", ++split->count, kind);
}

bool split_takes(struct split *split, struct text text)
{
    if (split->count == 0) /* a comment before the first table */
        return false;
    buffer_put(&split->content, text);
    return true;
}

bool split_end(struct split *split, struct error *error)
{
    if (!split->open)
        return true;
    if (signals_ending() && !split->failed) {
        split->failed = true;
        error_set(&split->error, ERROR_CANCELLED, "ended by a signal: no table was written");
    }
    put_part(split);
    buffer_free(&split->content);
    split->open = false;
    if (!split->failed)
        return folder_commit(&split->folder, error);
    folder_abandon(&split->folder);
    *error = split->error;
    return false;
}
