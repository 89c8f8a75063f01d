/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Help on one argument of a command: what it takes, what the command's text says of it. */
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include "command/session/topics.h"

#include <string.h>

/* Returns the argument that `dt=5ms`, `--force` or `until` gives the command, or NULL if there is
 * none. */
static const struct argument *find_argument(const struct command *command, struct text word)
{
    const char *equals = memchr(word.at, '=', word.len);
    const struct text key = {word.at, equals ? (size_t)(equals - word.at) : word.len};
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        const bool named =
            argument->form == FORM_KEY ? text_is(key, argument->name)
            : argument->form == FORM_OPTION
                ? text_starts(word, TEXT("--")) &&
                      text_is((struct text){word.at + 2, word.len - 2}, argument->name)
                : argument->form == FORM_WORD && text_is(word, argument->name);
        if (named && !(argument->form == FORM_KEY && type_is(argument, TYPE_IS_ANY_KEY)))
            return argument;
    }
    return NULL;
}

/* Appends the argument's name as used in a sentence, such as "dt=", "--force" or "until". */
static void put_name(const struct argument *argument, struct buffer *text)
{
    buffer_format(text, "%s%s%s", argument->form == FORM_OPTION ? "--" : "", argument->name,
                  argument->form == FORM_KEY ? "=" : "");
}

static bool stands_in(struct text sentence, struct text name)
{
    for (size_t i = 0; i + name.len <= sentence.len; i++) {
        const size_t after = i + name.len;
        if (memcmp(sentence.at + i, name.at, name.len) == 0 &&
            (i == 0 || strchr(" '(\n", sentence.at[i - 1])) &&
            (name.at[name.len - 1] == '=' || after == sentence.len ||
             strchr(" ').,;:\n", sentence.at[after])))
            return true;
    }
    return false;
}

/* Appends the sentences of the text that contain the name; returns false if there are none. */
static bool put_sentences(struct text text, struct text name, struct buffer *out)
{
    const char *between = "\n";
    while (text.len > 0) {
        size_t len = 2;
        while (len < text.len &&
               !(text.at[len - 1] == '.' && text.at[len - 2] != '.' && strchr(" \n", text.at[len])))
            len++;
        len = len < text.len ? len : text.len;
        struct text sentence = {text.at, len};
        text = (struct text){text.at + len, text.len - len};
        while (sentence.len > 0 && strchr(" \n", sentence.at[0]))
            sentence = (struct text){sentence.at + 1, sentence.len - 1};
        if (!stands_in(sentence, name))
            continue;
        buffer_put(out, text_of(between));
        for (size_t i = 0; i < sentence.len; i++)
            buffer_char(out, sentence.at[i] == '\n' ? ' ' : sentence.at[i]);
        between = " ";
    }
    return *between == ' ';
}

static void put_argument(const struct command *command, const struct argument *argument,
                         struct buffer *text)
{
    struct buffer name = {0}, units = {0};
    put_name(argument, &name);
    argument_usage(argument, text);
    buffer_format(text, ", an argument of %s", command->row.name);
    if (type_is(argument, TYPE_HAS_QUANTITY)) {
        quantity_units(argument->quantity, &units);
        buffer_format(text, ": %s", quantity_name(argument->quantity));
        if (units.len > 0)
            buffer_format(text, "; units: %s", buffer_view(&units));
    }
    if (name.len > 0 && !put_sentences(text_of(command->text), buffer_text(&name), text)) {
        buffer_put(text, TEXT("\nusage: "));
        command_usage(command, text);
    }
    const struct catalog *choices = argument->choices;
    for (size_t i = 0; choices && choices->count <= HELP_CHOICES && i < choices->count; i++)
        buffer_format(text, "\n  %-10s %s", catalog_row(choices, i)->name,
                      catalog_row(choices, i)->brief);
    struct text rest = text_of(command->examples), line;
    for (const char *head = "\nexamples:"; text_split(&rest, '\n', &line);)
        if (name.len > 0 && stands_in(line, buffer_text(&name))) {
            buffer_format(text, "%s\n  %.*s", head, (int)line.len, line.at);
            head = "";
        }
    buffer_format(text, "\nsee also: %s", command->row.name);
    buffer_free(&name);
    buffer_free(&units);
}

struct text help_topic_of(struct text words, const struct command **command)
{
    words = text_trim(words);
    const struct text first = peek_word(words, "");
    const struct text rest = text_trim((struct text){words.at + first.len, words.len - first.len});
    *command = rest.len > 0 && peek_word(rest, "").len == rest.len
                   ? command_at(catalog_find(&command_catalog, first))
                   : NULL;
    return *command ? rest : words;
}

void help_given(const struct command *command, struct text *word, struct buffer *text)
{
    const struct argument *argument = find_argument(command, *word);
    const char *equals = memchr(word->at, '=', word->len);
    if (equals)
        word->len = (size_t)(equals - word->at);
    if (!argument)
        return;
    put_argument(command, argument, text);
    if (argument->form != FORM_KEY || !catalog_find(&setting_catalog, *word))
        word->len = 0;
}

/* ---- F1 ---- */

static size_t word_around(struct text line, size_t *from, const char *ends)
{
    size_t to = *from;
    while (*from > 0 && !strchr(ends, line.at[*from - 1]))
        --*from;
    while (to < line.len && !strchr(ends, line.at[to]))
        to++;
    return to - *from;
}

#define WORD_ENDS " \t\n;"

void help_line(struct text line, size_t cursor, struct buffer *text)
{
    size_t from = cursor < line.len ? cursor : line.len;
    /* If the cursor is after a word and blanks, explain that word. */
    while (from > 0 && strchr(" \t", line.at[from - 1]) &&
           (from == line.len || strchr(WORD_ENDS, line.at[from])))
        from--;
    size_t at = from, begin = from, word_len = word_around(line, &from, WORD_ENDS);
    while (begin > 0 && !strchr("\n;", line.at[begin - 1]))
        begin--;
    struct text statement = {line.at + begin, line.len - begin}, word = {line.at + from, word_len};
    text_skip_blanks(&statement);
    const struct text first = peek_name(statement);
    const bool command = catalog_find(&command_catalog, first) != NULL;
    const char *equals = memchr(word.at, '=', word.len);
    const bool key = command && word.at > first.at && equals && equals > word.at;
    if (key) {
        word.len = (size_t)(equals + 1 - word.at);
    } else if (!text_starts(word, TEXT("--"))) {
        word.len = word_around(line, &at, WORD_ENDS ",=()*/+^<>:'\"");
        word.at = line.at + at;
    }
    const bool letter = word.len > 0 && (word.at[0] == '-' || peek_name(word).len > 0);
    buffer_put(text, TEXT("help"));
    if ((command && first.at != word.at) || !letter)
        buffer_format(text, "%s%.*s", first.len ? " " : "", (int)first.len, first.at);
    if (letter)
        buffer_format(text, " %.*s", (int)word.len, word.at);
}
