/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Help on one argument of a command, from its type and the command's text; and help for the word at
 * the cursor (F1). */
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include "command/session/topics.h"

#include <string.h>

/* Returns true if word gives a command this argument; key is the part of word before a '='. */
static bool gives_argument(const struct argument *argument, struct text word, struct text key)
{
    if (argument->form == FORM_KEY)
        return text_is(key, argument->name) && !type_is(argument, TYPE_IS_ANY_KEY);
    if (argument->form == FORM_OPTION)
        return text_starts(word, TEXT("--")) && text_is(text_after(word, 2), argument->name);
    return argument->form == FORM_WORD && text_is(word, argument->name);
}

/* Returns the argument that `dt=5ms`, `--force` or `until` gives the command, or NULL if there is
 * none. */
static const struct argument *find_argument(const struct command *command, struct text word)
{
    const char *equals = memchr(word.data, '=', word.len);
    const struct text key = {word.data, equals ? (size_t)(equals - word.data) : word.len};
    for (int i = 0; i < command->arguments; i++)
        if (gives_argument(&command->argument[i], word, key))
            return &command->argument[i];
    return NULL;
}

/* Appends the argument's name as used in a sentence, such as "dt=", "--force" or "until". */
static void put_name(const struct argument *argument, struct buffer *text)
{
    const char *const dashes = argument->form == FORM_OPTION ? "--" : "";
    buffer_format(text, "%s%s%s", dashes, argument->name, argument->form == FORM_KEY ? "=" : "");
}

/* Returns true if the sentence contains the name as a whole word. */
static bool sentence_has_name(struct text sentence, struct text name)
{
    for (size_t i = 0; i + name.len <= sentence.len; i++) {
        const size_t end = i + name.len;
        if (memcmp(sentence.data + i, name.data, name.len) == 0 &&
            (i == 0 || strchr(" '(\n", sentence.data[i - 1])) &&
            (name.data[name.len - 1] == '=' || end == sentence.len ||
             strchr(" ').,;:\n", sentence.data[end])))
            return true;
    }
    return false;
}

/* Appends the sentences of the text that contain the name; returns false if there are none. */
static bool put_sentences(struct text text, struct text name, struct buffer *output)
{
    const char *separator = "\n";
    while (text.len > 0) {
        size_t len = 2;
        while (len < text.len && !(text.data[len - 1] == '.' && text.data[len - 2] != '.' &&
                                   strchr(" \n", text.data[len])))
            len++;
        len = len < text.len ? len : text.len;
        struct text sentence = {text.data, len};
        text = text_after(text, len);
        while (sentence.len > 0 && strchr(" \n", sentence.data[0]))
            sentence = text_after(sentence, 1);
        if (!sentence_has_name(sentence, name))
            continue;
        buffer_put(output, text_of(separator));
        for (size_t i = 0; i < sentence.len; i++)
            buffer_char(output, sentence.data[i] == '\n' ? ' ' : sentence.data[i]);
        separator = " ";
    }
    return *separator == ' ';
}

/* Explains an argument: its form and units, the sentences about it, choices and examples. */
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
        if (name.len > 0 && sentence_has_name(line, buffer_text(&name))) {
            buffer_format(text, "%s\n  %.*s", head, (int)line.len, line.data);
            head = "";
        }
    buffer_format(text, "\nsee also: %s", command->row.name);
    buffer_free(&name);
    buffer_free(&units);
}

/* Divides `COMMAND ARGUMENT` into both; *command is NULL for a single topic. */
struct text help_topic_of(struct text words, const struct command **command)
{
    words = text_trim(words);
    const struct text first = peek_word(words, "");
    const struct text rest = text_trim(text_after(words, first.len));
    *command = rest.len > 0 && peek_word(rest, "").len == rest.len
                   ? command_at(catalog_find(&command_catalog, first))
                   : NULL;
    return *command ? rest : words;
}

void help_given(const struct command *command, struct text *word, struct buffer *text)
{
    const struct argument *argument = find_argument(command, *word);
    const char *equals = memchr(word->data, '=', word->len);
    if (equals)
        word->len = (size_t)(equals - word->data);
    if (!argument)
        return;
    put_argument(command, argument, text);
    if (argument->form != FORM_KEY || !catalog_find(&setting_catalog, *word))
        word->len = 0;
}

/* ---- F1 ---- */

/* Moves *begin back to the start of the word around it, which ends at one of `ends`. Returns the
 * length of the word. */
static size_t word_around(struct text line, size_t *begin, const char *ends)
{
    size_t end = *begin;
    while (*begin > 0 && !strchr(ends, line.data[*begin - 1]))
        --*begin;
    while (end < line.len && !strchr(ends, line.data[end]))
        end++;
    return end - *begin;
}

/* Characters that end a word at the cursor. */
#define WORD_ENDS " \t\n;"

/* Finds statement and word at the cursor, and appends the help command that explains it. */
void help_line(struct text line, size_t cursor, struct buffer *text)
{
    size_t word_begin = cursor < line.len ? cursor : line.len;
    /* If the cursor is after a word and blanks, explain that word. */
    while (word_begin > 0 && strchr(" \t", line.data[word_begin - 1]) &&
           (word_begin == line.len || strchr(WORD_ENDS, line.data[word_begin])))
        word_begin--;
    size_t token_begin = word_begin, begin = word_begin,
           word_len = word_around(line, &word_begin, WORD_ENDS);
    while (begin > 0 && !strchr("\n;", line.data[begin - 1]))
        begin--;
    struct text statement = {line.data + begin, line.len - begin},
                word = {line.data + word_begin, word_len};
    text_skip_blanks(&statement);
    const struct text first = peek_name(statement);
    const bool command = catalog_find(&command_catalog, first) != NULL;
    const char *equals = memchr(word.data, '=', word.len);
    const bool key = command && word.data > first.data && equals && equals > word.data;
    if (key) {
        word.len = (size_t)(equals + 1 - word.data);
    } else if (!text_starts(word, TEXT("--"))) {
        word.len = word_around(line, &token_begin, WORD_ENDS ",=()*/+^<>:'\"");
        word.data = line.data + token_begin;
    }
    const bool letter = word.len > 0 && (word.data[0] == '-' || peek_name(word).len > 0);
    buffer_put(text, TEXT("help"));
    if ((command && first.data != word.data) || !letter)
        buffer_format(text, "%s%.*s", first.len ? " " : "", (int)first.len, first.data);
    if (letter)
        buffer_format(text, " %.*s", (int)word.len, word.data);
}
