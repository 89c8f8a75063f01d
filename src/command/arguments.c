/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads what stands after the name of a command, by the command's own description of its arguments. */
#include "internal.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

int catalog_place(const struct catalog *catalog, const struct row *row)
{
    return (int)((size_t)((const char *)row - (const char *)catalog->rows) / catalog->stride);
}

const struct row *choose(const struct session *session, const struct catalog *catalog, struct text name)
{
    const size_t least = catalog == &method_catalog ? 3 : 1;
    return session->typed ? catalog_prefix(catalog, name, least) : catalog_find(catalog, name);
}

const struct given *given_for(const struct arguments *arguments, const char *name)
{
    const struct command *command = arguments->command;
    int place = 0;
    while (place < command->arguments && strcmp(command->argument[place].name, name) != 0)
        place++;
    assert(place < command->arguments);
    return &arguments->given[place];
}

/* Room for one more item; they live in the arena of the statement. */
static struct item *next_item(struct parser *parser, struct given *given, struct error *error)
{
    if (given->count >= LIMIT_TOKENS) {
        error_set(error, ERROR_COMMAND, "more than %d words in a statement", LIMIT_TOKENS);
        return NULL;
    }
    if ((given->count & (given->count - 1)) == 0) { /* full at every power of two */
        struct item *larger = arena_array(parser->arena, given->count ? 2 * (size_t)given->count : 1, sizeof *larger);
        if (!larger) {
            error_memory(error);
            return NULL;
        }
        if (given->count)
            memcpy(larger, given->item, (size_t)given->count * sizeof *larger);
        given->item = larger;
    }
    struct item *item = &given->item[given->count];
    *item = (struct item){.quantity = QUANTITY_OTHER, .index = -1};
    return item;
}

static bool in_range(const struct parser *parser, const struct argument *argument, const struct item *item,
                     struct error *error)
{
    const struct text rest = parser->rest;
    if ((argument->flags & ARG_NEGATIVE) || argument->type != TYPE_VALUE || item->value.value > 0)
        return true;
    error_at(error, item->text, "%s must be more than 0, got '%.*s'", argument->name, (int)item->text.len,
             item->text.at);
    if (rest.len > 1 && rest.at[0] == ',' && rest.at[1] >= '0' && rest.at[1] <= '9')
        error_hint(error, "the comma separates the values of a list; the decimal mark is a point");
    return false;
}

static bool choose_row(struct parser *parser, const struct argument *argument, struct item *item, struct error *error)
{
    item->row = choose(parser->session, argument->choices, item->text);
    if (item->row) {
        item->index = catalog_place(argument->choices, item->row);
        return true;
    }
    catalog_unknown(argument->choices, item->text, error);
    if (!error->hint[0] && argument->choices->count <= 16) {
        struct buffer all = {0};
        for (size_t i = 0; i < argument->choices->count; i++)
            buffer_format(&all, "%s%s", i ? ", " : "", catalog_row(argument->choices, i)->name);
        error_hint(error, "it is one of: %s", buffer_view(&all));
        buffer_free(&all);
    }
    return false;
}

static bool read_choice(struct parser *parser, const struct argument *argument, const char *stops, struct item *item,
                        struct error *error)
{
    return parse_word(parser, stops, item, error) && choose_row(parser, argument, item, error);
}

const struct preset *own_scene(const struct setup *setup, struct text name)
{
    for (int i = 0; i < setup->owns; i++)
        if (text_is(name, setup->own[i]->row.name))
            return setup->own[i];
    return NULL;
}

static bool read_scene(struct parser *parser, const char *stops, struct item *item, struct error *error)
{
    const struct setup *setup = &parser->session->setup;
    if (!parse_word(parser, stops, item, error))
        return false;
    const struct preset *own = own_scene(setup, item->text);
    item->row = own ? &own->row : choose(parser->session, &preset_catalog, item->text);
    if (item->row || text_is(item->text, "new"))
        return true;
    catalog_unknown(&preset_catalog, item->text, error);
    struct suggestion near = {.wanted = item->text};
    suggestion_offer(&near, "new");
    for (int i = 0; i < setup->owns; i++)
        suggestion_offer(&near, setup->own[i]->row.name);
    if (!error->hint[0])
        suggestion_hint(&near, error);
    return error->hint[0] ? false : error_hint(error, "'list scenes' lists them; scene new begins one of your own");
}

static bool read_run(struct parser *parser, const struct argument *argument, struct item *item, struct error *error)
{
    if (!parse_word(parser, ",", item, error))
        return false;
    if ((argument->flags & ARG_ALL) && text_is(item->text, "all"))
        return true;
    item->index = session_find_run(parser->session, item->text);
    if (item->index >= 0)
        return true;
    if (parser->session->runs == 0) {
        error_at(error, item->text, "there is no run yet");
        return error_hint(error, "type: run");
    }
    error_at(error, item->text, "there is no run '%.*s'", (int)(item->text.len < 64 ? item->text.len : 64),
             item->text.at);
    return error_hint(error, "'runs' lists them");
}

static bool read_recording(struct parser *parser, struct item *item, struct error *error)
{
    const struct session *session = parser->session;
    if (!parse_word(parser, ",", item, error))
        return false;
    item->index = session_find_recording(session, item->text);
    if (item->index >= 0)
        return true;
    error_at(error, item->text, "there is no recording '%.*s'", (int)(item->text.len < 64 ? item->text.len : 64),
             item->text.at);
    struct suggestion near = {.wanted = item->text};
    for (int i = 0; i < session->recordings; i++)
        suggestion_offer(&near, session->recording[i]->recording->name);
    suggestion_hint(&near, error);
    return session->recordings ? error_hint(error, "('data list' lists them)") : error_hint(error, "type: load FILE");
}

/* Something that moves, or is observed, in what the user has typed: the scene's or a run's. */
static bool typed_column(const struct session *session, struct text name)
{
    bool known = false;
    for (int i = -1; i < session->runs && !known; i++) {
        const struct model *model = i < 0 ? session->setup.scene.model : session->run[i]->run->system.model;
        known = model->typed && (model_variable(model, name) >= 0 || model_observation(model, name) >= 0);
    }
    return known;
}

static bool read_column(struct parser *parser, const struct argument *argument, struct item *item, struct error *error)
{
    if (!parse_word(parser, ",", item, error))
        return false;
    const struct row *choice = argument->choices ? catalog_find(argument->choices, item->text) : NULL;
    if (choice) {
        item->row = choice;
        item->index = catalog_place(argument->choices, choice);
        return true;
    }
    item->row = catalog_find(&observable_catalog, item->text);
    for (const struct model *const *model = scene_models; *model; model++)
        if (item->row || model_variable(*model, item->text) >= 0)
            return true;
    if (typed_column(parser->session, item->text))
        return true;
    if (argument->choices)
        return choose_row(parser, argument, item, error);
    return catalog_unknown(&observable_catalog, item->text, error);
}

static bool read_condition(struct parser *parser, struct item *item, struct error *error)
{
    struct condition *condition = arena_alloc(parser->arena, sizeof *condition);
    if (!condition)
        return error_memory(error);
    size_t used;
    skip_blanks(&parser->rest);
    if (!condition_compile(before_option(parser->rest), parser->scope, parser->arena, condition, &used, error))
        return false;
    item->text = (struct text){parser->rest.at, used};
    item->condition = condition;
    if (!check_condition(parser, item->text, error))
        return false;
    parser->rest = (struct text){parser->rest.at + used, parser->rest.len - used};
    return true;
}

/* NAME=value */
static bool read_start(struct parser *parser, struct item *item, struct error *error)
{
    char what[LIMIT_NAME + 1];
    const struct text name = peek_name(parser->rest);
    if (name.len == 0 || name.len > LIMIT_NAME)
        return error_at(error, peek_word(parser->rest, ","), "NAME=VALUE is missing");
    memcpy(what, name.at, name.len);
    what[name.len] = 0;
    parser->rest = (struct text){name.at + name.len, parser->rest.len - name.len};
    skip_blanks(&parser->rest);
    if (parser->rest.len == 0 || parser->rest.at[0] != '=')
        return error_at(error, name, "'%s' needs a value: %s=VALUE", what, what);
    parser->rest = (struct text){parser->rest.at + 1, parser->rest.len - 1};
    if (!parse_value(parser, what, QUANTITY_OTHER, item, error))
        return false;
    item->text = name;
    return true;
}

static bool read_model(struct parser *parser, const struct argument *argument, const char *stops, struct item *item,
                       struct error *error)
{
    struct formula formula;
    struct error why = {0};
    size_t used = 0;
    const struct text rest = parser->rest, word = peek_word(rest, "");
    if (strchr("'\"", rest.at[0]))
        return parse_word(parser, stops, item, error);
    /* A lone name is no formula. */
    if (peek_name(rest).len == word.len)
        return read_choice(parser, argument, stops, item, error);
    if (!formula_compile(before_option(rest), NULL, NULL, 0, parser->arena, &formula, &used, &why)) {
        *error = why;
        return false;
    }
    item->text = text_trim((struct text){rest.at, used});
    parser->rest = (struct text){rest.at + used, rest.len - used};
    return true;
}

static bool read_item(struct parser *parser, const struct argument *argument, const char *stops, struct item *item,
                      struct error *error)
{
    const char *name = argument->name;
    const bool negative = (argument->flags & ARG_NEGATIVE) != 0;
    switch (argument->type) {
    case TYPE_NONE:
        return true;
    case TYPE_VALUE:
        return parse_value(parser, name, argument->quantity, item, error) && in_range(parser, argument, item, error);
    case TYPE_INTEGER:
        return parse_integer(parser, name, negative, item, error);
    case TYPE_RANGE:
        return parse_range(parser, name, argument->quantity, item, error);
    case TYPE_CONDITION:
        return read_condition(parser, item, error);
    case TYPE_EXPR:
        return strchr("'\"", parser->rest.at[0]) ? parse_word(parser, stops, item, error)
                                                 : parse_value(parser, "the expression", QUANTITY_OTHER, item, error);
    case TYPE_CHOICE:
        return read_choice(parser, argument, stops, item, error);
    case TYPE_SCENE:
        return read_scene(parser, stops, item, error);
    case TYPE_COLUMN:
        return read_column(parser, argument, item, error);
    case TYPE_RUN:
        return read_run(parser, argument, item, error);
    case TYPE_RECORDING:
        return read_recording(parser, item, error);
    case TYPE_UNIT:
        if (!parse_word(parser, stops, item, error))
            return false;
        item->unit = unit_find(item->text);
        return item->unit || catalog_unknown(&unit_catalog, item->text, error);
    case TYPE_NAME:
        item->text = peek_name(parser->rest);
        if (item->text.len == 0) {
            const struct text word = peek_word(parser->rest, "");
            error_at(error, word, "'%.*s' is not a name", (int)(word.len < 64 ? word.len : 64), word.at);
            return error_hint(error, "a name begins with a letter, a to z; digits and _ may follow");
        }
        parser->rest = (struct text){parser->rest.at + item->text.len, parser->rest.len - item->text.len};
        return true;
    case TYPE_PARAM:
        item->text = peek_name(parser->rest);
        if (item->text.len == 0)
            return error_at(error, peek_word(parser->rest, ""), "%s needs the names of parameters", argument->name);
        item->index = scene_param_at(&parser->session->setup.scene, item->text);
        parser->rest = (struct text){parser->rest.at + item->text.len, parser->rest.len - item->text.len};
        return true;
    case TYPE_START:
        return read_start(parser, item, error);
    case TYPE_MODEL:
        return read_model(parser, argument, stops, item, error);
    case TYPE_TEXT:
    case TYPE_EVENT:
    case TYPE_FILE:
        return parse_word(parser, stops, item, error);
    case TYPE_REST:
    case TYPE_FORMULA:
        item->text = parser->rest;
        parser->rest = (struct text){parser->rest.at + parser->rest.len, 0};
        return true;
    }
    return false;
}

/* Where one argument's items go, and what is still expected. */
struct progress {
    struct parser *parser;
    const struct command *command;
    struct arguments *arguments;
    int open;                  /* argument that may take more items without a new introduction, -1: none */
    const struct item *number; /* that was read last, NULL: something else */
};

static bool read_into(struct progress *progress, int place, const char *start, struct error *error)
{
    struct parser *parser = progress->parser;
    const struct argument *argument = &progress->command->argument[place];
    struct given *given = &progress->arguments->given[place];
    for (int i = 0; given->count == 0 && argument->group && i < progress->command->arguments; i++)
        if (i != place && progress->command->argument[i].group == argument->group && has(progress->arguments, i)) {
            error_at(error,
                     (struct text){start, (size_t)(parser->rest.at - start) ? (size_t)(parser->rest.at - start) : 1},
                     "'%s' and '%s' exclude each other", progress->command->argument[i].name, argument->name);
            return false;
        }
    const bool many = (argument->flags & ARG_MANY) != 0;
    const bool needs = argument->type != TYPE_NONE;
    for (bool more = true; more;) {
        skip_blanks(&parser->rest);
        if (needs && parser->rest.len == 0) {
            error_at(error, (struct text){parser->rest.at, 0}, "%s needs a value after '%s'",
                     progress->command->row.name, argument->name);
            struct buffer usage = {0};
            command_usage(progress->command, &usage);
            error_hint(error, "usage: %s", buffer_view(&usage));
            buffer_free(&usage);
            return false;
        }
        struct item *item = next_item(parser, given, error);
        if (!item || !read_item(parser, argument, many ? "," : "", item, error))
            return false;
        given->count++;
        more = many && parser->rest.len > 0 && parser->rest.at[0] == ',';
        if (more)
            parser->rest = (struct text){parser->rest.at + 1, parser->rest.len - 1};
    }
    given->where = (struct text){start, (size_t)(parser->rest.at - start)};
    const bool number = argument->type == TYPE_VALUE || argument->type == TYPE_RANGE || argument->type == TYPE_EXPR ||
                        argument->type == TYPE_INTEGER || argument->type == TYPE_CONDITION;
    progress->number = number ? &given->item[given->count - 1] : NULL;
    progress->open = many && argument->form == FORM_WORD ? place : -1;
    return true;
}

static int find_argument(const struct command *command, enum argument_form form, struct text name)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == form && text_is(name, command->argument[i].name))
            return i;
    return -1;
}

/* The argument that takes any NAME=VALUE, -1: none. */
static int find_start(const struct command *command)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].type == TYPE_START)
            return i;
    return -1;
}

static bool is_lead(const struct command *command, struct text word)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].lead && text_is(word, command->argument[i].lead))
            return true;
    return false;
}

static bool unknown_argument(const struct command *command, enum argument_form form, struct text name,
                             struct error *error)
{
    error_at(error, name, "%s has no %s '%.*s'", command->row.name, form == FORM_OPTION ? "option" : "argument",
             (int)(name.len < 64 ? name.len : 64), name.at);
    struct suggestion near = {.wanted = name};
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == form)
            suggestion_offer(&near, command->argument[i].name);
    suggestion_hint(&near, error);
    struct buffer usage = {0};
    command_usage(command, &usage);
    error_hint(error, "usage: %s", buffer_view(&usage));
    buffer_free(&usage);
    return false;
}

/* The length of NAME and blanks and "=" at the start of text, 0 if it is not of this form. */
static size_t key_length(struct text text, struct text name)
{
    struct text rest = {text.at + name.len, text.len - name.len};
    skip_blanks(&rest);
    if (name.len == 0 || rest.len == 0 || rest.at[0] != '=' || (rest.len > 1 && rest.at[1] == '='))
        return 0;
    return (size_t)(rest.at + 1 - text.at);
}

/* The place where an item without introduction goes, -1: none. */
static int next_place(const struct progress *progress, struct text word)
{
    const struct command *command = progress->command;
    if (progress->open >= 0 && command->argument[progress->open].type == TYPE_RUN && word.len > 0 &&
        ((word.at[0] >= '0' && word.at[0] <= '9') || session_find_run(progress->parser->session, word) >= 0))
        return progress->open;
    if (progress->open >= 0 && command->argument[progress->open].type == TYPE_CHOICE)
        return progress->open;
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == FORM_PLACE &&
            (!has(progress->arguments, i) || (command->argument[i].flags & ARG_MANY)))
            return i;
    return -1;
}

static bool takes_rest(const struct argument *argument)
{
    return argument->type == TYPE_REST || argument->type == TYPE_FORMULA;
}

static bool read_next(struct progress *progress, struct error *error)
{
    struct parser *parser = progress->parser;
    struct text *rest = &parser->rest;
    const char *start = rest->at;
    const struct text name = rest->at[0] == '>' ? (struct text){rest->at, 1} : peek_name(*rest);
    size_t used = 0;
    int place = next_place(progress, (struct text){rest->at, 0});
    if (place >= 0 && takes_rest(&progress->command->argument[place]))
        return read_into(progress, place, start, error);
    if (text_starts(*rest, TEXT("--")) && rest->len > 2 && is_name_start(rest->at[2])) {
        const struct text option = peek_name((struct text){rest->at + 2, rest->len - 2});
        place = find_argument(progress->command, FORM_OPTION, option);
        if (place < 0)
            return unknown_argument(progress->command, FORM_OPTION, option, error);
        used = key_length(*rest, (struct text){rest->at, option.len + 2});
        used = used ? used : option.len + 2;
    } else if ((used = key_length(*rest, name)) > 0) {
        place = find_argument(progress->command, FORM_KEY, name);
        if (place < 0 && (place = find_start(progress->command)) >= 0)
            used = 0; /* the name is part of it */
        /* `let NAME = value`: the = belongs to what follows. */
        if (place < 0 && next_place(progress, name) >= 0 &&
            progress->command->argument[next_place(progress, name)].type == TYPE_NAME) {
            place = next_place(progress, name);
            used = 0;
        }
        if (place < 0)
            return unknown_argument(progress->command, FORM_KEY, name, error);
    } else if (place >= 0 && progress->command->argument[place].type == TYPE_CHOICE &&
               !has(progress->arguments, place) && catalog_find(progress->command->argument[place].choices, name)) {
        used = 0; /* `measure energy`: what the place wants comes before a word of the same name, as in `of energy` */
    } else if ((place = find_argument(progress->command, FORM_WORD, name)) >= 0 &&
               peek_word(*rest, "").len == name.len) {
        used = name.len;
    } else if (is_lead(progress->command, name)) {
        *rest = (struct text){rest->at + name.len, rest->len - name.len};
        return true;
    } else {
        place = next_place(progress, peek_word(*rest, ","));
        used = 0;
        if (place < 0)
            return refuse_rest(parser, progress->number, error);
    }
    if (has(progress->arguments, place) && !(progress->command->argument[place].flags & ARG_MANY))
        return error_at(error, (struct text){start, used ? used : 1}, "'%s' is given twice",
                        progress->command->argument[place].name);
    *rest = (struct text){rest->at + used, rest->len - used};
    return read_into(progress, place, start, error);
}

bool parse_arguments(struct parser *parser, const struct command *command, struct arguments *arguments,
                     struct error *error)
{
    struct progress progress = {parser, command, arguments, -1, NULL};
    for (;;) {
        struct text before = parser->rest;
        skip_blanks(&parser->rest);
        if (parser->rest.len == 0)
            break;
        /* Something glued to a number, as in 0,5 or 5cmm. */
        if (progress.number && before.at == parser->rest.at)
            return refuse_rest(parser, progress.number, error);
        if (!read_next(&progress, error))
            return false;
    }
    for (int i = 0; i < command->arguments; i++)
        if ((command->argument[i].flags & ARG_REQUIRED) && !has(arguments, i)) {
            struct buffer usage = {0};
            command_usage(command, &usage);
            error_at(error, (struct text){parser->rest.at, 0}, "%s needs %s", command->row.name,
                     command->argument[i].name);
            error_hint(error, "usage: %s", buffer_view(&usage));
            buffer_free(&usage);
            return false;
        }
    return true;
}
