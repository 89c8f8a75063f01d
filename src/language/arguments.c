/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads the text after the name of a command into values, by the command's table of arguments:
 * words, NAME=VALUE, --options, and items that are known by their position. */
#include <hooke/base/statement.h>
#include <hooke/language.h>
#include <hooke/module.h>

#include <assert.h>
#include <stdio.h>
#include <string.h>

/* Returns the value of an argument that the command must have; its count is 0 if it was not given.
 */
const struct argument_value *argument_value(const struct arguments *arguments, const char *name)
{
    const struct command *command = arguments->command;
    int index = 0;
    while (index < command->arguments && strcmp(command->argument[index].name, name) != 0)
        index++;
    assert(index < command->arguments);
    return &arguments->value[index];
}

struct text argument_text(const struct arguments *arguments, const char *name)
{
    const struct argument_value *one = argument_value(arguments, name);
    return one->count ? one->item->text : (struct text){NULL, 0};
}

/* Returns the value of an argument that a module may have added to the command, or NULL if the
 * argument does not exist or was not given. */
const struct argument_value *added_argument(const struct arguments *arguments, const char *name)
{
    const struct command *command = arguments->command;
    for (int i = 0; i < command->arguments; i++)
        if (strcmp(command->argument[i].name, name) == 0)
            return has_argument_at(arguments, i) ? &arguments->value[i] : NULL;
    return NULL;
}

/* Returns a new item at the end of an argument's list, in the statement's arena, or NULL with an
 * error if out of memory or if the list is too long. The caller counts it. */
static struct item *append_item(struct parser *parser, struct argument_value *value,
                                struct error *error)
{
    if (value->count >= LIMIT_TOKENS) {
        error_set(error, ERROR_COMMAND, "more than %d words in a statement", LIMIT_TOKENS);
        return NULL;
    }
    if ((value->count & (value->count - 1)) == 0) { /* the capacity is the next power of two */
        struct item *larger =
            arena_array(parser->arena, value->count ? 2 * (size_t)value->count : 1, sizeof *larger);
        if (!larger) {
            error_memory(error);
            return NULL;
        }
        if (value->count)
            memcpy(larger, value->item, (size_t)value->count * sizeof *larger);
        value->item = larger;
    }
    struct item *item = &value->item[value->count];
    *item = (struct item){.quantity = QUANTITY_OTHER, .index = -1};
    return item;
}

/* Progress of reading a statement's arguments. */
struct argument_progress {
    struct parser *parser;
    const struct command *command;
    struct arguments *arguments;
    /* Index of the argument introduced by a word that takes items until another argument begins, or
     * -1. */
    int open;
    const struct item *number; /* the last item if it was a number, else NULL */
};

/* Reads the value of the argument number `index` from the parser, or several values separated by
 * commas if it is ARG_MANY. `start` is where the argument begins in the line, for messages. Sets
 * progress->number to the last value if that is a number, else to NULL, and progress->open to
 * `index` if more values may follow a word, else to -1. Returns false with an error if a value is
 * malformed or missing, or if an argument of the same group was given. */
static bool read_argument_value(struct argument_progress *progress, int index, const char *start,
                                struct error *error)
{
    struct parser *parser = progress->parser;
    const struct argument *argument = &progress->command->argument[index];
    struct argument_value *value = &progress->arguments->value[index];
    for (int i = 0; value->count == 0 && argument->group && i < progress->command->arguments; i++)
        if (i != index && progress->command->argument[i].group == argument->group &&
            has_argument_at(progress->arguments, i)) {
            error_at(error,
                     (struct text){start, (size_t)(parser->rest.data - start)
                                              ? (size_t)(parser->rest.data - start)
                                              : 1},
                     "'%s' and '%s' exclude each other", progress->command->argument[i].name,
                     argument->name);
            return false;
        }
    const bool many = (argument->flags & ARG_MANY) != 0;
    const bool needs = argument->type != TYPE_NONE;
    for (bool more = true; more;) {
        text_skip_blanks(&parser->rest);
        if (needs && parser->rest.len == 0) {
            error_at(error, (struct text){parser->rest.data, 0}, "%s needs a value after '%s'",
                     progress->command->row.name, argument->name);
            struct buffer usage = {0};
            command_usage(progress->command, &usage);
            error_usage(error, buffer_view(&usage));
            buffer_free(&usage);
            return false;
        }
        struct item *item = append_item(parser, value, error);
        if (!item || !argument_type(argument)->read(parser, argument, many ? "," : "", item, error))
            return false;
        value->count++;
        more = many && parser->rest.len > 0 && parser->rest.data[0] == ',';
        if (more)
            parser->rest = text_after(parser->rest, 1);
    }
    value->where = (struct text){start, (size_t)(parser->rest.data - start)};
    progress->number = type_is(argument, TYPE_IS_NUMBER) ? &value->item[value->count - 1] : NULL;
    progress->open = many && argument->form == FORM_WORD ? index : -1;
    return true;
}

/* Returns the index of the argument with this name and form, or -1. */
static int find_argument(const struct command *command, enum argument_form form, struct text name)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == form && text_is(name, command->argument[i].name))
            return i;
    return -1;
}

/* Returns the index of the argument that takes any NAME=VALUE, such as initial values, or -1. */
static int find_any_key_argument(const struct command *command)
{
    for (int i = 0; i < command->arguments; i++)
        if (type_is(&command->argument[i], TYPE_IS_ANY_KEY))
            return i;
    return -1;
}

/* Returns true if the word is one that may precede an argument without changing it, such as "of".
 */
static bool is_leading_word(const struct command *command, struct text word)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].lead && text_is(word, command->argument[i].lead))
            return true;
    return false;
}

/* Returns false with an error if a module that this program was built without would add the
 * argument. */
static bool argument_is_in(const struct command *command, enum argument_form form, struct text name,
                           struct error *error)
{
    char what[64];
    snprintf(what, sizeof what, form == FORM_OPTION ? "%s --%.*s" : "%s %.*s=", command->row.name,
             (int)name.len, name.data);
    return module_is_in(what, name, error);
}

/* Fills `error` for an unknown --option or NAME=: the module that is left out, or a similar name,
 * with the usage of the command. Returns false. */
static bool unknown_argument(const struct command *command, enum argument_form form,
                             struct text name, struct error *error)
{
    if (!argument_is_in(command, form, name, error))
        return false;
    const int shown = (int)(name.len < 64 ? name.len : 64);
    error_at(error, name, "%s has no %s '%.*s'", command->row.name,
             form == FORM_OPTION ? "option" : "argument", shown, name.data);
    struct suggestion suggestion = {.wanted = name};
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == form)
            suggestion_offer(&suggestion, command->argument[i].name);
    suggestion_hint(&suggestion, error);
    struct buffer usage = {0};
    command_usage(command, &usage);
    error_usage(error, buffer_view(&usage));
    buffer_free(&usage);
    return false;
}

/* Returns the length of NAME, blanks and "=" at the start of text, or 0 if "=" does not follow or
 * is part of "==". */
static size_t key_length(struct text text, struct text name)
{
    struct text rest = {text.data + name.len, text.len - name.len};
    text_skip_blanks(&rest);
    if (name.len == 0 || rest.len == 0 || rest.data[0] != '=' ||
        (rest.len > 1 && rest.data[1] == '='))
        return 0;
    return (size_t)(rest.data + 1 - text.data);
}

/* Returns the index of the argument that takes an item without introduction: the list that is open,
 * else the first positional argument that is free and accepts the word. Returns -1 if there is
 * none. */
static int find_positional_argument(const struct argument_progress *progress, struct text word)
{
    const struct command *command = progress->command;
    if (progress->open >= 0 && command->argument[progress->open].type == TYPE_RUN && word.len > 0 &&
        ((word.data[0] >= '0' && word.data[0] <= '9') ||
         session_find_run(progress->parser->session, word) >= 0))
        return progress->open;
    if (progress->open >= 0 && type_is(&command->argument[progress->open], TYPE_IS_LIST))
        return progress->open;
    int last = -1;
    for (int i = 0; i < command->arguments; i++) {
        if (command->argument[i].form != FORM_PLACE ||
            (has_argument_at(progress->arguments, i) && !(command->argument[i].flags & ARG_MANY)))
            continue;
        last = i;
        /* An optional recording or number leaves a word that is neither to the next positional
         * argument. */
        if (!type_is(&command->argument[i], TYPE_MAY_BE_SKIPPED) ||
            has_argument_at(progress->arguments, i) ||
            (command->argument[i].type == TYPE_INTEGER
                 ? word.len == 0 || !is_name_start(word.data[0])
                 : session_find_recording(progress->parser->session, word) >= 0))
            return i;
    }
    return last;
}

static bool takes_rest_of_statement(const struct argument *argument)
{
    return type_is(argument, TYPE_TAKES_REST);
}

/* Reads one argument at parser->rest, which begins with a non-blank. Tries --option, NAME=, a
 * keyword, a leading word and then position, in this order. Returns false with an error if nothing
 * fits or the argument is given twice. */
static bool read_next_argument(struct argument_progress *progress, struct error *error)
{
    struct parser *parser = progress->parser;
    struct text *rest = &parser->rest;
    const char *start = rest->data;
    const struct text name = rest->data[0] == '>' ? (struct text){rest->data, 1} : peek_name(*rest);
    size_t used = 0;
    int index = find_positional_argument(progress, (struct text){rest->data, 0});
    if (index >= 0 && takes_rest_of_statement(&progress->command->argument[index]))
        return read_argument_value(progress, index, start, error);
    if (text_starts(*rest, TEXT("--")) && rest->len > 2 && is_name_start(rest->data[2])) {
        const struct text option = peek_name((struct text){rest->data + 2, rest->len - 2});
        index = find_argument(progress->command, FORM_OPTION, option);
        if (index < 0)
            return unknown_argument(progress->command, FORM_OPTION, option, error);
        used = key_length(*rest, (struct text){rest->data, option.len + 2});
        used = used ? used : option.len + 2;
    } else if ((used = key_length(*rest, name)) > 0) {
        index = find_argument(progress->command, FORM_KEY, name);
        /* NAME is part of the item, as in an initial value y0=1 */
        if (index < 0 && (index = find_any_key_argument(progress->command)) >= 0) {
            used = 0;
            if (!argument_is_in(progress->command, FORM_KEY, name, error))
                return false;
        }
        /* The = of `let NAME = value` belongs to the value. */
        if (index < 0 && find_positional_argument(progress, name) >= 0 &&
            type_is(&progress->command->argument[find_positional_argument(progress, name)],
                    TYPE_BEFORE_EQUALS)) {
            index = find_positional_argument(progress, name);
            used = 0;
        }
        if (index < 0)
            return unknown_argument(progress->command, FORM_KEY, name, error);
    } else if (index >= 0 && type_is(&progress->command->argument[index], TYPE_BEFORE_WORDS) &&
               !has_argument_at(progress->arguments, index) &&
               catalog_find(progress->command->argument[index].choices, name)) {
        /* A word that the place accepts, as in `measure energy`, has priority over a keyword of the
         * same name, as in `of energy`. */
        used = 0;
    } else if ((index = find_argument(progress->command, FORM_WORD,
                                      text_is(name, "vs") && has_argument_at(progress->arguments, 0)
                                          ? TEXT("against")
                                          : name)) >= 0 &&
               peek_word(*rest, "").len == name.len) {
        used = name.len;
    } else if (is_leading_word(progress->command, name)) {
        *rest = (struct text){rest->data + name.len, rest->len - name.len};
        return true;
    } else {
        index = find_positional_argument(progress, peek_word(*rest, ","));
        used = 0;
        if (index < 0)
            return refuse_rest(parser, progress->number, error);
    }
    if (has_argument_at(progress->arguments, index) &&
        !(progress->command->argument[index].flags & ARG_MANY))
        return error_at(error, (struct text){start, used ? used : 1}, "'%s' is given twice",
                        progress->command->argument[index].name);
    *rest = (struct text){rest->data + used, rest->len - used};
    return read_argument_value(progress, index, start, error);
}

/* Reads all arguments of a statement into `arguments`. Returns false with an error at the first
 * that is wrong, or if a required one is missing. */
bool parse_arguments(struct parser *parser, const struct command *command,
                     struct arguments *arguments, struct error *error)
{
    struct argument_progress progress = {parser, command, arguments, -1, NULL};
    for (;;) {
        struct text previous = parser->rest;
        text_skip_blanks(&parser->rest);
        if (parser->rest.len == 0)
            break;
        /* No blank separates a number from what follows, as in 0,5 or 5cmm. */
        if (progress.number && previous.data == parser->rest.data)
            return refuse_rest(parser, progress.number, error);
        if (!read_next_argument(&progress, error))
            return false;
    }
    for (int i = 0; i < command->arguments; i++)
        if ((command->argument[i].flags & ARG_REQUIRED) && !has_argument_at(arguments, i)) {
            struct buffer usage = {0};
            command_usage(command, &usage);
            error_at(error, (struct text){parser->rest.data, 0}, "%s needs %s", command->row.name,
                     command->argument[i].name);
            error_usage(error, buffer_view(&usage));
            buffer_free(&usage);
            return false;
        }
    return true;
}
