/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Option --split DIR: each table of the results in CSV becomes a file in a new folder. All files
 * appear, or none. */
#include "terminal/terminal.h"

#include <stdio.h>
#include <string.h>
#include <string.h>

/* Returns true for names that --split writes, which may be removed if the folder is abandoned. */
static bool is_split_file(const char *name)
{
    const size_t digits = strspn(name, "0123456789"), len = strlen(name);
    return digits >= 3 && name[digits] == '-' && len > 4 && strcmp(name + len - 4, ".csv") == 0;
}

/* Opens the new folder. Returns false with an error if it exists or cannot be made. */
bool split_begin(struct split *split, const char *path, bool safe, struct error *error)
{
    *split = (struct split){.count = 0};
    split->open = folder_open(&split->folder, path, (struct write_policy){.confine = safe},
                              is_split_file, error);
    if (split->open || !strstr(error->text, "--force"))
        return split->open;
    error_set(error, ERROR_IO, "%s already exists", path);
    return error_hint(error, "name a folder that does not exist yet");
}

/* Writes the current file into the folder; a failure is kept for split_end(). */
static void write_current_file(struct split *split)
{
    if (split->count > 0 && !split->failed &&
        !(split->content.failed ? error_memory(&split->error)
                                : folder_put(&split->folder, split->name,
                                             buffer_text(&split->content), &split->error)))
        split->failed = true;
    buffer_clear(&split->content);
}

/* Ends the current file and begins that of the next table (callback of the reply). */
void split_part(void *context, const char *kind)
{
    struct streams *streams = context;
    struct split *split = streams->split;
    write_current_file(split);
    snprintf(split->name, sizeof split->name, "%03d-%s.csv", ++split->count, kind);
}

/* Adds text to the current file. Returns false for text before the first table, which goes to
 * standard output. */
bool split_takes(struct split *split, struct text text)
{
    if (split->count == 0) /* a comment before the first table */
        return false;
    buffer_put(&split->content, text);
    return true;
}

/* Writes the last file and makes the folder appear. Returns false with an error, and leaves no
 * folder, if anything failed. */
bool split_end(struct split *split, struct error *error)
{
    if (!split->open)
        return true;
    if (signals_ending() && !split->failed) {
        split->failed = true;
        error_set(&split->error, ERROR_CANCELLED, "ended by a signal: no table was written");
    }
    write_current_file(split);
    buffer_free(&split->content);
    split->open = false;
    if (!split->failed)
        return folder_commit(&split->folder, error);
    folder_abandon(&split->folder);
    *error = split->error;
    return false;
}
