/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion: candidates for the word at the cursor, from the descriptions of arguments. Nothing is
 * executed and no expression is evaluated. */
#include <hooke/base/statement.h>
#include <hooke/command/complete.h>
#include <hooke/command/handler.h>
#include "command/session/list_methods.h"

#include <string.h>

/* Returns the last word of the text, without blanks around it. */
struct text last_word(struct text preceding)
{
    preceding = text_trim(preceding);
    size_t begin = preceding.len;
    while (begin > 0 && preceding.data[begin - 1] != ' ' && preceding.data[begin - 1] != '\t')
        begin--;
    return text_after(preceding, begin);
}

/* Returns the number of words in the text. */
int count_words(struct text text)
{
    int count = 0;
    for (struct text word; (text = text_trim(text)).len > 0; count++) {
        word = peek_word(text, "");
        const size_t used = word.len ? word.len : 1;
        text = text_after(text, used);
    }
    return count;
}

/* Returns the argument of that form and name, or NULL if the command has none. */
static const struct argument *find_by_form(const struct command *command, enum argument_form form,
                                           struct text name)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == form && text_is(name, command->argument[i].name))
            return &command->argument[i];
    return NULL;
}

/* Returns true if the command can take an expression that continues over blanks. */
static bool takes_values(const struct command *command)
{
    for (int i = 0; i < command->arguments; i++)
        if (type_is(&command->argument[i], TYPE_GOES_ON))
            return true;
    return false;
}

/* Offers the words, keys and options of the command, the next positional argument, and units behind
 * a number. */
void complete_next(struct completion *c, const struct command *command, struct text preceding)
{
    /* a leading word such as `of` is followed only by the arguments that belong to it */
    const struct text last = last_word(preceding);
    bool led = false;
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].lead && text_is(last, command->argument[i].lead)) {
            if (command->argument[i].form == FORM_PLACE)
                complete_item(c, &command->argument[i], TEXT(""));
            else
                complete_offer(c, command->argument[i].name, "");
            led = true;
        }
    if (led)
        return;
    int words = count_words(preceding);
    const char *lead = "";
    const struct argument *index = NULL;
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        if (argument->form == FORM_PLACE && !index &&
            (words-- == 0 || (argument->flags & ARG_MANY)))
            index = argument;
        if (argument->form == FORM_WORD && argument->name[0] != '>' && !argument->lead)
            complete_offer(c, argument->name, "");
        else if (argument->form == FORM_KEY && !type_is(argument, TYPE_IS_ANY_KEY))
            complete_affixed(c, "", argument->name, "=", "");
        else if (argument->form == FORM_OPTION)
            complete_affixed(c, "--", argument->name, "", "");
        if (argument->lead && strcmp(argument->lead, lead) != 0)
            complete_offer(c, argument->lead, "");
        lead = argument->lead ? argument->lead : lead;
    }
    if (index)
        complete_item(c, index, preceding);
    else if (ends_in_digit(preceding) && command->arguments > 0 && takes_values(command))
        complete_units(c, type_is(&command->argument[0], TYPE_HAS_QUANTITY)
                              ? command->argument[0].quantity
                              : QUANTITY_OTHER);
}

/* Returns true if an expression continues at the cursor: after an operator, or after the comparison
 * of `until`. */
static bool expression_continues(const struct command *command, struct text preceding)
{
    const struct text t = text_trim(preceding);
    const bool compares = find_by_form(command, FORM_WORD, TEXT("until")) && t.len > 0 &&
                          strchr("<>", t.data[t.len - 1]);
    return takes_values(command) && (compares || value_is_open(preceding));
}

/* Completes the arguments of a command by what precedes the word. Modules come first, then values
 * behind NAME= and units behind numbers, then the arguments that may come next. */
static void complete_arguments(struct completion *c, const struct command *command,
                               struct text preceding)
{
    const struct text last = last_word(preceding);
    if (command->flags & COMMAND_TABLES && text_is(last, ">")) {
        c->file = "";
        return;
    }
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->complete && module_list[i]->complete(c, command, preceding))
            return;
    if (command->completes == COMPLETES_GRID) {
        complete_grid(c, command, preceding);
        return;
    }
    /* NAME=item, also after commas: the word being completed begins behind the last = or comma. */
    if (preceding.len > 0 &&
        (preceding.data[preceding.len - 1] == '=' || preceding.data[preceding.len - 1] == ',')) {
        const struct argument *key = find_by_form(command, FORM_KEY, peek_name(last));
        if (key) {
            complete_item(c, key, TEXT(""));
            return;
        }
    }
    /* NAME=5 and a blank: the unit. */
    size_t equals = preceding.len;
    while (equals > 0 && preceding.data[equals - 1] != '=')
        equals--;
    if (equals > 0 && ends_in_digit(preceding)) {
        const struct argument *key =
            find_by_form(command, FORM_KEY, last_word((struct text){preceding.data, equals - 1}));
        if (key && type_is(key, TYPE_HAS_QUANTITY)) {
            complete_units(c, key->quantity);
            return;
        }
    }
    if (expression_continues(command, preceding)) {
        complete_value(c, TEXT(""), QUANTITY_OTHER, complete_operands);
        return;
    }
    const struct argument *word = find_by_form(command, FORM_WORD, last);
    const struct argument *option =
        last.len > 2 ? find_by_form(command, FORM_OPTION, text_after(last, 2)) : NULL;
    if (word && word->type != TYPE_NONE)
        complete_item(c, word, TEXT(""));
    else if (option && option->type != TYPE_NONE)
        complete_item(c, option, TEXT(""));
    else if (command->completes == COMPLETES_TOPICS)
        complete_topics(c);
    else if (command->completes == COMPLETES_ATOL)
        complete_atol(c, count_words(preceding) > 0);
    else if (command->completes == COMPLETES_KINDS &&
             text_is(peek_name(text_trim(preceding)), "methods"))
        complete_catalog(c, &method_kind_catalog);
    else if (command->completes == COMPLETES_SHOWN) {
        complete_catalog(c, &show_catalog);
        complete_names(c);
    } else if (command->completes == COMPLETES_VALUES && count_words(preceding) > 0)
        complete_set(c, peek_name(text_trim(preceding)), preceding);
    else
        complete_next(c, command, preceding);
}

/* Returns the command of a statement that defines a scene or an event, with *rest set to the text
 * behind its name, or NULL for another statement. */
static const struct command *formula_command(struct text statement, struct text *rest)
{
    text_skip_blanks(&statement);
    const struct text name = peek_name(statement);
    const struct command *command = command_at(catalog_find(&command_catalog, name));
    *rest = text_after(statement, name.len);
    if (name.len > 0 && rest->len > 0 && rest->data[0] == '\'')
        return command_with(COMMAND_EQUATES);
    const bool formula = command && command->arguments > 0 &&
                         type_is(&command->argument[command->arguments - 1], TYPE_IS_FORMULA);
    return formula && rest->len > 0 && strchr(" \t", rest->data[0]) ? command : NULL;
}

static void offer_nothing(void *context, const char *candidate, const char *brief)
{
    UNUSED(context);
    UNUSED(candidate);
    UNUSED(brief);
}

/* Returns the kind of file that the string beginning behind `preceding` names, as described at
 * command_complete(). */
static const char *file_string(struct session *session, struct text preceding)
{
    size_t start = preceding.len;
    return preceding.len > 0 && strchr(" \t", preceding.data[preceding.len - 1])
               ? command_complete(session, preceding, preceding.len, &start, offer_nothing, NULL)
               : NULL;
}

/* Returns the beginning of the commands of an unfinished event, or NULL if the string is another
 * one. */
static const char *event_string(struct text statement)
{
    text_skip_blanks(&statement);
    if (!text_is(peek_name(statement), "event"))
        return NULL;
    for (size_t i = 0; i + 3 < statement.len; i++)
        if (strncmp(statement.data + i, " do ", 4) == 0) {
            struct text rest = {statement.data + i + 4, statement.len - i - 4};
            text_skip_blanks(&rest);
            return rest.len > 0 && strchr("'\"", rest.data[0]) ? rest.data + 1 : NULL;
        }
    return NULL;
}

/* Finds statement and word at the cursor, then completes by the kind of the statement; inside the
 * commands of an unfinished event it calls itself. */
const char *
command_complete(struct session *session, struct text line, size_t cursor, size_t *start,
                 void (*offer_to)(void *context, const char *candidate, const char *brief),
                 void *context)
{
    struct text rest = {line.data, cursor < line.len ? cursor : line.len}, statement = rest;
    struct error ignored = {0};
    while (rest.len > 0) {
        statement = rest;
        if (!next_statement(&rest, &statement, &ignored)) {
            const char *inside = event_string(statement), *end = line.data + cursor;
            const char *string = ignored.where.data;
            /* the cursor is in a string that is not closed, perhaps in the commands of an event */
            if (!inside || inside > end) {
                const struct text preceding = {line.data, (size_t)(string - line.data)};
                const char *const file = file_string(session, preceding);
                *start = file ? preceding.len : *start;
                return file;
            }
            const struct text commands = {inside, (size_t)(end - inside)};
            const char *const file =
                command_complete(session, commands, commands.len, start, offer_to, context);
            *start += (size_t)(inside - line.data);
            return file;
        }
        if (rest.len == 0 && rest.data > line.data && rest.data[-1] == ';')
            statement = rest;
        /* includes the blanks at its end */
        else if (rest.len == 0)
            statement.len = (size_t)(rest.data - statement.data);
    }
    size_t word = statement.len;
    while (word > 0 &&
           (!strchr(" \t=,;:", statement.data[word - 1]) ||
            (word > 1 && statement.data[word - 1] == ' ' && statement.data[word - 2] == '\\')))
        word--;
    struct completion c = {
        session, {statement.data + word, statement.len - word}, offer_to, context, NULL};
    struct text preceding = {statement.data, word}, argument_text;
    const struct command *formula = formula_command(preceding, &argument_text);
    text_skip_blanks(&preceding);
    const struct text name = peek_name(preceding);
    struct text remainder = {preceding.data + name.len, preceding.len - name.len};
    text_skip_blanks(&remainder);
    const struct command *command = command_at(catalog_find(&command_catalog, name));
    if (preceding.len == 0) {
        complete_catalog(&c, &command_catalog);
        complete_settable(&c);
    } else if (formula)
        complete_formula(&c, formula, argument_text);
    else if (remainder.len > 0 && remainder.data[0] == '=')
        complete_set(&c, name, preceding);
    else if (command)
        complete_arguments(&c, command, text_after(preceding, name.len));
    *start = (size_t)(c.word.data - line.data);
    return c.file;
}
