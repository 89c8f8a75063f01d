/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Several recordings in one file: side by side, each with its own columns, or below each other,
 * each a block with its own header. Users refer to them by the instrument's names ("Run #2",
 * "Latest") or by number. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Runs that a list shows. */
#define LISTED_RUNS_MAX 12

/* Names a run by a text of the file, made safe to show. */
static void set_name(struct recording_run *run, struct text name)
{
    struct buffer safe = {0};
    safe_text(&safe, name, false);
    snprintf(run->name, sizeof run->name, "%.*s", (int)text_fitting(buffer_text(&safe), LIMIT_NAME),
             safe.data ? safe.data : "");
    buffer_free(&safe);
}

/* Returns the run with that name, in any case, or -1 if there is none. */
static int run_named(const struct recording *recording, struct text name)
{
    for (int i = 0; i < recording->runs; i++)
        if (strlen(recording->run[i].name) == name.len &&
            (name.len == 0 || strncasecmp(recording->run[i].name, name.data, name.len) == 0))
            return i;
    return -1;
}

/* Returns the number at the end of a name, 2 for "Run #2", or -1 if there is none. */
static double trailing_number(const char *name)
{
    size_t index = strlen(name);
    double number;
    while (index > 0 && name[index - 1] >= '0' && name[index - 1] <= '9')
        index--;
    return real_parse(text_of(name + index), &number) == REAL_OK ? number : -1;
}

/* Finds a run by its name, by the number in its name, or by its position in the file. Sets *run.
 * Returns false with the error, which lists the runs. */
bool run_find(const struct recording *recording, struct text wanted, int *run, struct error *error)
{
    struct text name = text_trim(wanted);
    char shown[SHORT_NAME];
    double number;
    if (name.len >= 2 && strchr("'\"", name.data[0]) && name.data[name.len - 1] == name.data[0])
        name = (struct text){name.data + 1, name.len - 2};
    *run = run_named(recording, name);
    if (*run < 0 && real_parse(name, &number) == REAL_OK) {
        bool numbered = false;
        for (int i = 0; i < recording->runs && *run < 0; i++) {
            const double own = trailing_number(recording->run[i].name);
            numbered |= own >= 0;
            *run = own == number ? i : -1;
        }
        if (*run < 0 && !numbered && number >= 1 && number <= recording->runs &&
            number == floor(number))
            *run = (int)number - 1;
    }
    if (*run >= 0)
        return true;
    struct buffer names = {0};
    run_list(recording, &names);
    error_at(error, wanted, "there is no run '%s' in this file", short_name(name, shown));
    if (recording->runs > 0)
        error_hint(error, "runs: %s", buffer_view(&names));
    else
        error_hint(error, "it contains only one recording; omit run=");
    buffer_free(&names);
    return false;
}

/* Separates names by commas and marks the run used. */
void run_list(const struct recording *recording, struct buffer *text)
{
    static const char *const separator[] = {"", ", "};
    for (int i = 0; i < recording->runs && i < LISTED_RUNS_MAX; i++)
        buffer_format(text, i == recording->taken ? "%s%s = used" : "%s%s", separator[i > 0],
                      recording->run[i].name);
    if (recording->runs > LISTED_RUNS_MAX)
        buffer_format(text, " and %d more", recording->runs - LISTED_RUNS_MAX);
}

/* Assigns columns to runs: part() finds the run in a column's name, and runs are numbered as they
 * appear. Returns false with the error if out of memory. */
bool runs_of_columns(struct recording *recording, bool (*part)(struct text name, struct text *run),
                     struct error *error)
{
    struct text name;
    recording->run =
        arena_array(&recording->arena, (size_t)recording->columns, sizeof *recording->run);
    if (!recording->run)
        return error_memory(error);
    for (int i = 0; i < recording->columns; i++) {
        struct column *column = &recording->column[i];
        if (!part(text_of(column->name), &name))
            continue;
        column->run = run_named(recording, name);
        if (column->run < 0) {
            column->run = recording->runs++;
            set_name(&recording->run[column->run], name);
        }
    }
    return true;
}

/* ---- below each other ---- */

/* Sets *part to the text of a block and finds its table. Returns false with part->problem if there
 * is none. */
static bool block_text(const struct table_text *whole, const struct table_block *block,
                       const struct load_options *options, struct arena *arena,
                       struct table_text *part)
{
    *part = (struct table_text){.name = whole->name,
                                .text = {block->begin, block->len},
                                .first = block->line,
                                .header = block->header};
    if (!table_head(part, arena))
        return error_memory(&part->problem);
    return table_find(part, 0, options, &part->layout, &part->problem);
}

/* Names the blocks as runs and sets *part to the requested block, by default the first with a
 * table. Returns false with the error if there is none. */
static bool choose_block(const struct table_text *whole, const struct table_block *block,
                         int blocks, const struct load_options *options,
                         struct recording *recording, struct arena *arena, struct table_text *part,
                         struct error *error)
{
    recording->run = arena_array(&recording->arena, (size_t)blocks, sizeof *recording->run);
    if (!recording->run)
        return error_memory(error);
    for (int i = 0; i < blocks; i++) {
        struct recording_run *run = &recording->run[i];
        set_name(run, block[i].name);
        if (run->name[0] == '\0' ||
            run_named(recording, text_of(run->name)) >= 0) /* a second one of the same name */
            snprintf(run->name, sizeof run->name, "block %d", i + 1);
        recording->runs++;
    }
    const bool wanted = options->run.len > 0;
    if (wanted && !run_find(recording, options->run, &recording->taken, error))
        return false;
    for (; recording->taken < blocks; recording->taken++) {
        if (block_text(whole, &block[recording->taken], options, arena, part))
            return true;
        if (wanted)
            break;
        arena_reset(arena);
    }
    *error = part->problem;
    return false;
}

/* Reads one block of a text with several: find() lists the blocks, which become runs, and read()
 * reads the chosen one. Without blocks it is read as one table. Returns false with the error. */
bool runs_of_blocks(const struct table_text *text, const struct load_options *options,
                    struct recording *recording, table_blocks *find, table_block_read *read,
                    struct error *error)
{
    struct arena arena = {0};
    struct load_options own = *options;
    struct table_text part;
    struct table_block *block = calloc(TABLE_BLOCKS_MAX, sizeof *block);
    const int blocks = block ? find(text, block, &own) : 0;
    bool done;
    if (!block)
        done = error_memory(error);
    else if (blocks == 0)
        done = table_read(text, options, recording, error);
    else
        done = choose_block(text, block, blocks, &own, recording, &arena, &part, error) &&
               read(&part, &block[recording->taken], recording, error);
    arena_reset(&arena);
    free(block);
    return done;
}
