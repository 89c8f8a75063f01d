/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The options of the program: one table for reading and for --help. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include "terminal/parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Kinds of values of options. */
enum value {
    VALUE_NONE,
    VALUE_FILE,
    VALUE_TEXT,
    VALUE_SIZE,
    VALUE_WORD,
    VALUE_RESUME,
    VALUE_MODULE
};

static const struct option_row {
    char letter; /* 0 if there is none */
    const char *name;
    enum value value;
    const char *shown; /* name of the value in --help */
    /* offset of a bool (VALUE_NONE) or a string (VALUE_WORD) in struct options */
    size_t offset;
    const char *brief;
    const struct module_option *module; /* VALUE_MODULE */
} rows[] = {
#define FLAG(letter, name, field, brief)                                                           \
    {                                                                                              \
        letter, name, VALUE_NONE, "", offsetof(struct options, field), brief, NULL                 \
    }
    {'f', "file", VALUE_FILE, " FILE", 0,
     "run a command file (\"-\" = standard input); repeatable, in order with -c", NULL},
    {'c', "command", VALUE_TEXT, " TEXT", 0, "run commands (\";\" separates); repeatable", NULL},
    FLAG('i', "interactive", interactive, "go to the prompt after -f, -c, FILE"),
    FLAG('b', "batch", batch, "show no prompt (default when stdin or stdout is not a terminal)"),
    FLAG(0, "plain", plain, "prompt with readline, no panes"),
    {0, "resume", VALUE_RESUME, " [NAME]", 0,
     "continue the last autosaved session, or session-NAME", NULL},
    FLAG('k', "keep-going", keep_going,
         "do not stop a script at the first error (exit status still 1)"),
    FLAG('n', "norc", norc, "do not read the rc file"),
    FLAG(0, "rc", rc, "read the rc file in batch, too"),
    FLAG(0, "safe", safe, "refuse to write outside the current directory"),
    {0, "size", VALUE_SIZE, " WxH", 0, "size of plots when there is no terminal (default 80x24)",
     NULL},
    {0, "charset", VALUE_WORD, " NAME", offsetof(struct options, charset),
     "auto, braille, block, ascii, ...: 'help charset' lists all", NULL},
    {0, "color", VALUE_WORD, " WHEN", offsetof(struct options, color), "auto, always or never",
     NULL},
    {0, "format", VALUE_WORD, " FORM", offsetof(struct options, format),
     "text, csv or json: form of results", NULL},
    {0, "split", VALUE_WORD, " DIR", offsetof(struct options, split),
     "with --format csv: write each table to a file in a new folder", NULL},
    FLAG('q', "quiet", quiet,
         "print only records, warnings and errors; do not estimate errors of runs (help run)"),
    FLAG('v', "verbose", verbose, "print each line on standard error before it is executed"),
    FLAG('h', "help", help, "show this list"),
    FLAG('V', "version", version, "show the version and the modules"),
#undef FLAG
};

/* Returns true if this build has the option: --resume needs the module that keeps sessions. */
static bool option_is_in_build(const struct option_row *row)
{
    return row->value != VALUE_RESUME || session_keeper();
}

/* Appends the line of an option for --help. */
static void put_option(char letter, const char *name, const char *shown, const char *brief,
                       struct buffer *text)
{
    char left[40];
    snprintf(left, sizeof left, "--%s%s", name, shown);
    if (letter)
        buffer_format(text, "  -%c, %-20s %s\n", letter, left, brief);
    else
        buffer_format(text, "      %-20s %s\n", left, brief);
}

static void put_module_option(const struct module_option *option, struct buffer *text)
{
    if (option->word)
        put_option(0, option->word, option->shown, option->brief, text);
}

/* Appends the usage, all options of this build, and the exit statuses. */
void options_help(struct buffer *text)
{
    buffer_format(text,
                  "usage: hooke [options] [FILE.hk ...]\n\n"
                  "A laboratory for oscillators and the methods that integrate them.\n"
                  "Without files and commands: a prompt, or commands from standard input.\n\n");
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        if (option_is_in_build(&rows[i]))
            put_option(rows[i].letter, rows[i].name, rows[i].shown, rows[i].brief, text);
    for (size_t i = 0; module_list[i]; i++)
        put_module_option(&module_list[i]->option, text);
    for (size_t i = 0; terminal_parts[i]; i++)
        put_module_option(&terminal_parts[i]->option, text);
    buffer_format(text, "\nexit status: 0 done, 1 a command failed, 2 bad option or script not "
                        "readable, 3 numerical failure,\n"
                        "4 input or output failed, 129 130 143 ended by a signal\n");
}

/* Writes an error about a word of the command line. Returns false. */
static bool complain(const char *what, const char *word)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(word), false);
    fprintf(stderr, "hooke: error: %s '%s' ('hooke --help' lists the options)\n", what,
            safe.data ? safe.data : "");
    buffer_free(&safe);
    return false;
}

/* Reads WIDTHxHEIGHT into the options. Returns false after a message if it is malformed. */
static bool read_size_option(struct options *options, const char *value)
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
    return complain("--size needs WIDTHxHEIGHT in characters (1 to 1000), such as 80x24, not",
                    value);
}

/* Returns true if the next word (or NULL) is the option's value; that of --resume may be missing.
 */
static bool wants_value(const struct option_row *row, const char *next)
{
    if (row->value == VALUE_RESUME)
        return next && session_keeper()->is_name(next);
    return row->value == VALUE_MODULE ? row->module->takes_first : row->value != VALUE_NONE;
}

/* Stores an option with its value, NULL if it has none. Returns false after a message. */
static bool option_take(struct options *options, const struct option_row *row, const char *value)
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
        return value && read_size_option(options, value);
    case VALUE_RESUME:
        options->resume = true;
        options->resume_name = value;
        return true;
    case VALUE_MODULE:
        options->only = row->module;
        options->first = value;
        return true;
    case VALUE_FILE:
    case VALUE_TEXT:
        options->task[options->tasks++] =
            (struct task){row->value == VALUE_FILE ? TASK_FILE : TASK_COMMAND, value};
        return true;
    }
    return false;
}

/* Makes a row of a module's option if it has this name. Returns false if not. */
static bool find_module_option(const struct module_option *option, struct text name,
                               struct option_row *row)
{
    if (!option->word || !text_is(name, option->word))
        return false;
    *row = (struct option_row){.name = option->word, .value = VALUE_MODULE, .module = option};
    return true;
}

/* Finds the row of an option by its long name, those of modules too. Returns false if there is
 * none. */
static bool find_long(struct text name, struct option_row *row)
{
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        if (text_is(name, rows[i].name) && option_is_in_build(&rows[i])) {
            *row = rows[i];
            return true;
        }
    for (size_t i = 0; module_list[i]; i++)
        if (find_module_option(&module_list[i]->option, name, row))
            return true;
    for (size_t i = 0; terminal_parts[i]; i++)
        if (find_module_option(&terminal_parts[i]->option, name, row))
            return true;
    return false;
}

/* Writes a message about an unknown long option, or about the module that it belongs to. Returns
 * false. */
static bool refuse_unknown(struct text name, const char *word)
{
    char what[40];
    struct error error = {0};
    snprintf(what, sizeof what, "--%.*s", (int)name.len, name.data);
    if (module_is_in(what, name, &error))
        return complain("unknown option", word);
    fprintf(stderr, "hooke: error: %s; %s\n", error.text, error.hint);
    return false;
}

/* Stores an option. `given` is the value in the word itself, or NULL; *next is set to NULL if the
 * next word is used as the value. Returns false after a message. */
static bool read_option(struct options *options, const struct option_row *row, const char *word,
                        const char *given, const char **next)
{
    const bool wants = wants_value(row, *next);
    if (given && !wants && row->value != VALUE_RESUME)
        return complain("no value is allowed with option", word);
    if (given || !wants)
        return option_take(options, row, given);
    const char *value = *next;
    *next = NULL;
    return value ? option_take(options, row, value)
                 : complain("a value is missing after option", word);
}

/* Reads "--NAME" or "--NAME=VALUE". Returns false after a message. */
static bool read_long(struct options *options, const char *word, const char **next)
{
    const char *equals = strchr(word, '=');
    const struct text name = {word + 2, equals ? (size_t)(equals - word - 2) : strlen(word + 2)};
    struct option_row row;
    const char *const value = equals ? equals + 1 : NULL;
    return find_long(name, &row) ? read_option(options, &row, word, value, next)
                                 : refuse_unknown(name, word);
}

/* Reads letters of options such as -qk; a letter with a value takes the rest of the word, or the
 * next word. Returns false after a message. */
static bool read_letters(struct options *options, const char *word, const char **next)
{
    bool ok = true;
    for (const char *letter = word + 1; *letter && ok; letter++) {
        size_t i = 0;
        while (i < COUNT_OF(rows) && rows[i].letter != *letter)
            i++;
        if (i == COUNT_OF(rows))
            return complain("unknown option", word);
        if (rows[i].value != VALUE_NONE)
            return read_option(options, &rows[i], word, letter[1] ? letter + 1 : NULL, next);
        ok = option_take(options, &rows[i], NULL);
    }
    return ok;
}

/* Reads the words of the command line into options and tasks. Returns false after a message to
 * standard error. */
bool options_read(struct options *options, int argc, char **argv)
{
    *options = (struct options){.task = calloc((size_t)argc + 1, sizeof(struct task))};
    if (!options->task) {
        fputs("hooke: error: out of memory\n", stderr);
        return false;
    }
    bool only_files = false;
    for (int i = 1; i < argc && argv[i]; i++) {
        const char *word = argv[i], *next = argv[i + 1];
        if (only_files || word[0] != '-' || word[1] == 0)
            options->task[options->tasks++] = (struct task){TASK_FILE, word};
        else if (strcmp(word, "--") == 0)
            only_files = true;
        else if (!(word[1] == '-' ? read_long : read_letters)(options, word, &next))
            return false;
        i += argv[i + 1] && !next;
    }
    return true;
}

void options_free(struct options *options)
{
    free(options->task);
}
