/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The options of the program: one table for reading and for --help. */
#include "terminal/terminal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum value { VALUE_NONE, VALUE_FILE, VALUE_TEXT, VALUE_SIZE, VALUE_WORD, VALUE_RESUME };

static const struct option_row {
    char letter; /* 0: none */
    const char *name;
    enum value value;
    const char *shown; /* how --help names the value */
    size_t offset;     /* of a bool (VALUE_NONE) or a string (VALUE_WORD) in struct options */
    const char *brief;
} rows[] = {
#define FLAG(letter, name, field, brief)                                                           \
    {                                                                                              \
        letter, name, VALUE_NONE, "", offsetof(struct options, field), brief                       \
    }
    {'f', "file", VALUE_FILE, " FILE", 0,
     "run a command file (\"-\" = standard input); repeatable, in order with -c"},
    {'c', "command", VALUE_TEXT, " TEXT", 0, "run commands (\";\" separates); repeatable"},
    FLAG('i', "interactive", interactive, "go to the prompt after -f, -c, FILE"),
    FLAG('b', "batch", batch, "never a prompt (default when stdin or stdout is not a terminal)"),
    FLAG(0, "plain", plain, "prompt with readline, no panes"),
    {0, "resume", VALUE_RESUME, " [NAME]", 0,
     "continue the last autosaved session, or session-NAME"},
    FLAG('k', "keep-going", keep_going,
         "do not stop a script at the first error (exit status still 1)"),
    FLAG('n', "norc", norc, "do not read the rc file"),
    FLAG(0, "rc", rc, "read the rc file in batch, too"),
    FLAG(0, "safe", safe, "refuse to write outside the current directory"),
    {0, "size", VALUE_SIZE, " WxH", 0, "size of plots when there is no terminal (default 80x24)"},
    {0, "charset", VALUE_WORD, " NAME", offsetof(struct options, charset),
     "auto, braille, block, ascii or words"},
    {0, "color", VALUE_WORD, " WHEN", offsetof(struct options, color), "auto, always or never"},
    {0, "format", VALUE_WORD, " FORM", offsetof(struct options, format),
     "text, csv or json: form of results"},
    {0, "check", VALUE_WORD, " DIR ...", offsetof(struct options, check),
     "run session.hk of each hand-in again: which values and figures agree"},
    {0, "simulate-sensor", VALUE_WORD, " SCENE ", offsetof(struct options, sensor),
     "a sensor on standard output: [rate=100] [noise=0.03cm] [seed=1] [for=10s] [NAME=VALUE]"},
    {0, "check-sweep", VALUE_NONE, " FILES", offsetof(struct options, check_sweep),
     "whether they, shards of a sweep or a whole one, have each point once, unchanged"},
    {0, "split", VALUE_WORD, " DIR", offsetof(struct options, split),
     "with --format csv: each table as a file in a new folder"},
    FLAG('q', "quiet", quiet,
         "only records, warnings and errors; a run's own error is not estimated (help run)"),
    FLAG('v', "verbose", verbose, "show each line on standard error before it is executed"),
    FLAG('h', "help", help, "this list"),
    FLAG('V', "version", version, "the version, and the modules that are in"),
#undef FLAG
};

void options_help(struct buffer *text)
{
    buffer_format(text,
                  "usage: hooke [options] [FILE.hk ...]\n\n"
                  "A laboratory for oscillators and the methods that integrate them.\n"
                  "Without files and commands: a prompt, or commands from standard input.\n\n");
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        char name[40];
        snprintf(name, sizeof name, "--%s%s", rows[i].name, rows[i].shown);
        if (rows[i].letter) {
            buffer_format(text, "  -%c, %-20s %s\n", rows[i].letter, name, rows[i].brief);
        } else {
            buffer_format(text, "      %-20s %s\n", name, rows[i].brief);
        }
    }
    buffer_format(text, "\nexit status: 0 done, 1 a command failed, 2 bad option or script not "
                        "readable, 3 numerical failure,\n"
                        "4 input or output failed, 129 130 143 ended by a signal\n");
}

static bool complain(const char *what, const char *word)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(word), false);
    fprintf(stderr, "hooke: error: %s '%s' ('hooke --help' lists the options)\n", what,
            safe.data ? safe.data : "");
    buffer_free(&safe);
    return false;
}

static bool take_size(struct options *options, const char *value)
{
    double width;
    double height;
    size_t used;
    struct text text = text_of(value);
    if (real_scan(text, '.', &width, &used) == REAL_OK && used + 1 < text.len &&
        value[used] == 'x' &&
        real_parse((struct text){value + used + 1, text.len - used - 1}, &height) == REAL_OK &&
        width >= 1 && width <= 1000 && height >= 1 && height <= 1000 && width == floor(width) &&
        height == floor(height)) {
        options->width = (int)width;
        options->height = (int)height;
        return true;
    }
    return complain("--size wants WIDTHxHEIGHT in characters (1 to 1000), such as 80x24, not",
                    value);
}

/* Does a value follow? That of --resume may be left out; the names of saved sessions are told from
 * files by their beginning. */
static bool wants_next(const struct option_row *row, const char *next)
{
    if (row->value == VALUE_RESUME) {
        return next && strncmp(next, AUTOSAVE_PREFIX, strlen(AUTOSAVE_PREFIX)) == 0;
    }
    return row->value != VALUE_NONE;
}

/* value NULL: none was given. */
static bool take(struct options *options, const struct option_row *row, const char *value)
{
    char *field = (char *)options + row->offset;
    switch (row->value) {
    case VALUE_NONE:
        *(bool *)(void *)field = true;
        return true;
    case VALUE_WORD:
        *(const char **)(void *)field = value;
        return true;
    case VALUE_SIZE:
        return take_size(options, value);
    case VALUE_RESUME:
        options->resume = true;
        options->resume_name = value;
        return true;
    case VALUE_FILE:
    case VALUE_TEXT:
        options->task[options->tasks++] =
            (struct task){row->value == VALUE_FILE ? TASK_FILE : TASK_COMMAND, value};
        return true;
    }
    return false;
}

static const struct option_row *find_long(struct text name)
{
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        if (text_is(name, rows[i].name)) {
            return &rows[i];
        }
    }
    return NULL;
}

static const struct option_row *find_letter(char letter)
{
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        if (rows[i].letter == letter) {
            return &rows[i];
        }
    }
    return NULL;
}

bool options_read(struct options *options, int argc, char **argv)
{
    *options = (struct options){.task = calloc((size_t)argc + 1, sizeof(struct task))};
    if (!options->task) {
        fputs("hooke: error: out of memory\n", stderr);
        return false;
    }
    bool only_files = false;
    for (int i = 1; i < argc; i++) {
        char *word = argv[i];
        if (only_files || word[0] != '-' || word[1] == 0) {
            options->task[options->tasks++] = (struct task){TASK_FILE, word};
        } else if (strcmp(word, "--") == 0) {
            only_files = true;
        } else if (word[1] == '-') {
            const char *equals = strchr(word, '=');
            struct text name = {word + 2, equals ? (size_t)(equals - word - 2) : strlen(word + 2)};
            const struct option_row *row = find_long(name);
            if (!row) {
                return complain("unknown option", word);
            }
            if (row->value == VALUE_NONE && equals) {
                return complain("no value goes with option", word);
            }
            const bool next = !equals && wants_next(row, argv[i + 1]);
            if (next && i + 1 >= argc) {
                return complain("a value is missing after option", word);
            }
            if (!take(options, row, equals ? equals + 1 : next ? argv[++i] : NULL)) {
                return false;
            }
        } else {
            for (const char *letter = word + 1; *letter;) {
                const struct option_row *row = find_letter(*letter++);
                if (!row) {
                    return complain("unknown option", word);
                }
                if (row->value == VALUE_NONE) {
                    take(options, row, NULL);
                    continue;
                }
                if (!*letter && i + 1 >= argc) {
                    return complain("a value is missing after option", word);
                }
                if (!take(options, row, *letter ? letter : argv[++i])) {
                    return false;
                }
                break;
            }
        }
    }
    return true;
}

void options_free(struct options *options)
{
    free(options->task);
}
