/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads one item of an argument, as its type says. */
#include <hooke/language.h>

#include <string.h>

const struct row *choose(const struct session *session, const struct catalog *catalog,
                         struct text name)
{
    const size_t min = catalog == &method_catalog ? 3 : 1;
    return session->typed ? catalog_prefix(catalog, name, min) : catalog_find(catalog, name);
}

static bool in_range(const struct parser *parser, const struct argument *argument,
                     const struct item *item, struct error *error)
{
    const struct text rest = parser->rest;
    if ((argument->flags & ARG_NEGATIVE) || argument->type != TYPE_VALUE || item->value.value > 0)
        return true;
    error_at(error, item->text, "%s must be more than 0, got '%.*s'", argument->name,
             (int)item->text.len, item->text.at);
    if (rest.len > 1 && rest.at[0] == ',' && rest.at[1] >= '0' && rest.at[1] <= '9')
        error_hint(error, "the comma separates the values of a list; the decimal mark is a point");
    return false;
}

static bool choose_row(struct parser *parser, const struct argument *argument, struct item *item,
                       struct error *error)
{
    item->row = choose(parser->session, argument->choices, item->text);
    if (item->row) {
        item->index = catalog_index(argument->choices, item->row);
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

static bool read_choice(struct parser *parser, const struct argument *argument, const char *stops,
                        struct item *item, struct error *error)
{
    return parse_word(parser, stops, item, error) && choose_row(parser, argument, item, error);
}

static bool read_scene(struct parser *parser, const char *stops, struct item *item,
                       struct error *error)
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
    return error->hint[0]
               ? false
               : error_hint(error, "'list scenes' lists them; scene new begins one of your own");
}

static bool read_run(struct parser *parser, const struct argument *argument, struct item *item,
                     struct error *error)
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
    error_at(error, item->text, "there is no run '%.*s'",
             (int)(item->text.len < 64 ? item->text.len : 64), item->text.at);
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
    error_at(error, item->text, "there is no recording '%.*s'",
             (int)(item->text.len < 64 ? item->text.len : 64), item->text.at);
    struct suggestion near = {.wanted = item->text};
    for (int i = 0; i < session->recordings; i++)
        suggestion_offer(&near, session->recording[i]->recording->name);
    suggestion_hint(&near, error);
    return session->recordings ? error_hint(error, "('data list' lists them)")
                               : error_hint(error, "type: load FILE");
}

/* Something that moves, or is observed, in what the user has typed: the scene's or a run's. */
static bool typed_column(const struct session *session, struct text name)
{
    bool known = false;
    for (int i = -1; i < session->runs && !known; i++) {
        const struct model *model =
            i < 0 ? session->setup.scene.model : session->run[i]->run->system.model;
        known = model->typed &&
                (model_variable(model, name) >= 0 || model_observation(model, name) >= 0);
    }
    return known;
}

/* Whether the word `of` stands in the rest of the statement. */
static bool is_of_table(struct text rest)
{
    for (struct text word; (rest = text_trim(rest)).len > 0;) {
        word = peek_word(rest, "");
        if (text_is(word, "of"))
            return true;
        const size_t used = word.len ? word.len : 1;
        rest = (struct text){rest.at + used, rest.len - used};
    }
    return false;
}

static bool read_column(struct parser *parser, const struct argument *argument, struct item *item,
                        struct error *error)
{
    if (!parse_word(parser, ",", item, error))
        return false;
    if ((argument->flags & ARG_OF) && is_of_table(parser->rest))
        return true;
    const struct row *choice =
        argument->choices ? catalog_find(argument->choices, item->text) : NULL;
    if (choice) {
        item->row = choice;
        item->index = catalog_index(argument->choices, choice);
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
    text_skip_blanks(&parser->rest);
    if (!condition_compile(before_option(parser->rest), parser->scope, parser->arena, condition,
                           &used, error))
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
    text_skip_blanks(&parser->rest);
    if (parser->rest.len == 0 || parser->rest.at[0] != '=')
        return error_at(error, name, "'%s' needs a value: %s=VALUE", what, what);
    parser->rest = (struct text){parser->rest.at + 1, parser->rest.len - 1};
    if (!parse_value(parser, what, QUANTITY_OTHER, item, error))
        return false;
    item->text = name;
    return true;
}

static bool read_model(struct parser *parser, const struct argument *argument, const char *stops,
                       struct item *item, struct error *error)
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
    if (!formula_compile(before_option(rest), NULL, NULL, 0, parser->arena, &formula, &used,
                         &why)) {
        *error = why;
        return false;
    }
    item->text = text_trim((struct text){rest.at, used});
    parser->rest = (struct text){rest.at + used, rest.len - used};
    return true;
}

bool read_item(struct parser *parser, const struct argument *argument, const char *stops,
               struct item *item, struct error *error)
{
    const char *name = argument->name;
    const bool negative = (argument->flags & ARG_NEGATIVE) != 0;
    switch (argument->type) {
    case TYPE_NONE:
        return true;
    case TYPE_VALUE:
        return parse_value(parser, name, argument->quantity, item, error) &&
               in_range(parser, argument, item, error);
    case TYPE_INTEGER:
        return parse_integer(parser, name, negative, item, error);
    case TYPE_RANGE:
        return parse_range(parser, name, argument->quantity, item, error);
    case TYPE_CONDITION:
        return read_condition(parser, item, error);
    case TYPE_EXPR:
        return strchr("'\"", parser->rest.at[0])
                   ? parse_word(parser, stops, item, error)
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
        return !unit_spelled(item->text, parser->arena, &item->unit) ? error_memory(error)
               : item->unit                                          ? true
                            : catalog_unknown(&unit_catalog, item->text, error);
    case TYPE_NAME:
        item->text = peek_name(parser->rest);
        if (item->text.len == 0) {
            const struct text word = peek_word(parser->rest, "");
            error_at(error, word, "'%.*s' is not a name", (int)(word.len < 64 ? word.len : 64),
                     word.at);
            return error_hint(error,
                              "a name begins with a letter, a to z; digits and _ may follow");
        }
        parser->rest =
            (struct text){parser->rest.at + item->text.len, parser->rest.len - item->text.len};
        return true;
    case TYPE_PARAM:
        item->text = peek_name(parser->rest);
        if (item->text.len == 0)
            return error_at(error, peek_word(parser->rest, ""), "%s needs the names of parameters",
                            argument->name);
        item->index = scene_param_at(&parser->session->setup.scene, item->text);
        parser->rest =
            (struct text){parser->rest.at + item->text.len, parser->rest.len - item->text.len};
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
