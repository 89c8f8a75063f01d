/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types of arguments, rows of src/language/types.def. Each has a function that reads an item of
 * this type from a statement, and one that offers completions. */
#include <hooke/run.h>
#include <hooke/method.h>
#include <hooke/data.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/session/series_tools.h>
#include <hooke/language/complete.h>
#include <hooke/scene/formula.h>
#include <hooke/module.h>
#include "language/column_names.h"

#include <stdio.h>
#include <string.h>

/* Declares a reader: it takes an item off parser->rest and fills `item`; `stops` are characters
 * that end a word. It returns false with `error` filled, and uses only some of its parameters. */
#define UNUSED_OK __attribute__((__unused__))
#define READ_ITEM(name)                                                                            \
    static bool name(UNUSED_OK struct parser *parser, UNUSED_OK const struct argument *argument,   \
                     UNUSED_OK const char *stops, UNUSED_OK struct item *item,                     \
                     UNUSED_OK struct error *error)
/* Declares a completer: it offers candidates for an argument; `preceding` is the argument's text
 * before the current word. */
#define COMPLETE_ITEM(name)                                                                        \
    static void name(UNUSED_OK struct completion *c, UNUSED_OK const struct argument *argument,    \
                     UNUSED_OK struct text preceding)

/* Returns false with an error if the argument must be positive and the value is not. A comma behind
 * the number suggests that a decimal comma was typed. */
static bool check_positive(const struct parser *parser, const struct argument *argument,
                           const struct item *item, struct error *error)
{
    const struct text rest = parser->rest;
    if ((argument->flags & ARG_NEGATIVE) || item->value.value > 0)
        return true;
    error_at(error, item->text, "%s must be more than 0, got '%.*s'", argument->name,
             (int)item->text.len, item->text.data);
    if (rest.len > 1 && rest.data[0] == ',' && rest.data[1] >= '0' && rest.data[1] <= '9')
        error_hint(error, "the comma separates the values of a list; the decimal mark is a point");
    return false;
}

/* Sets item->row and item->index to the row of the argument's catalog named by item->text. Returns
 * false with an error that lists the choices if they are few. */
static bool choose_row(struct parser *parser, const struct argument *argument, struct item *item,
                       struct error *error)
{
    item->row = catalog_choose(parser->session, argument->choices, item->text);
    if (item->row) {
        item->index = catalog_index(argument->choices, item->row);
        return true;
    }
    if (!choice_is_in(argument->choices, item->text, error))
        return false;
    catalog_unknown(argument->choices, item->text, error);
    if (!error->hint[0] && argument->choices->count <= 24) {
        struct buffer all = {0};
        for (size_t i = 0; i < argument->choices->count; i++)
            buffer_format(&all, "%s%s", i ? ", " : "", catalog_row(argument->choices, i)->name);
        error_hint(error, "it is one of: %s", buffer_view(&all));
        buffer_free(&all);
    }
    return false;
}

READ_ITEM(read_choice)
{
    return parse_word(parser, stops, item, error) && choose_row(parser, argument, item, error);
}

/* Reads the name of a scene: one of the user's own, a preset, or "new" (row NULL). */
READ_ITEM(read_scene)
{
    const struct setup *setup = &parser->session->setup;
    if (!parse_word(parser, stops, item, error))
        return false;
    const struct preset *own = own_scene(setup, item->text);
    item->row = own ? &own->row : catalog_choose(parser->session, &preset_catalog, item->text);
    if (item->row || text_is(item->text, "new"))
        return true;
    catalog_unknown(&preset_catalog, item->text, error);
    struct suggestion suggestion = {.wanted = item->text};
    suggestion_offer(&suggestion, "new");
    for (int i = 0; i < setup->owns; i++)
        suggestion_offer(&suggestion, setup->own[i]->row.name);
    if (!error->hint[0])
        suggestion_hint(&suggestion, error);
    return error->hint[0]
               ? false
               : error_hint(error, "'list scenes' lists them; scene new begins one of your own");
}

/* Reads the number or the name of a run into item->index, or "all" (-1) where it is allowed. */
READ_ITEM(read_run)
{
    if (!parse_word(parser, ",", item, error))
        return false;
    if ((argument->flags & ARG_ALL) && text_is(item->text, "all"))
        return true;
    item->index = session_find_run(parser->session, item->text);
    if (item->index >= 0)
        return true;
    const struct row *method = catalog_find(&method_catalog, item->text);
    const bool none = parser->session->runs.count == 0;
    if (none)
        error_at(error, item->text, "there is no run yet");
    else
        error_at(error, item->text, "there is no run '%.*s'",
                 (int)(item->text.len < 64 ? item->text.len : 64), item->text.data);
    if (method)
        return error_hint(error, "'method %s' chooses the method", method->name);
    if (none)
        return error_hint(error, "type: run");
    return error_hint(error, "'runs' lists them");
}

/* Returns true if the word is a label that a module gave to a result, such as an orbit. */
static bool is_label(struct text word)
{
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->labels.is_label && module_list[i]->labels.is_label(word))
            return true;
    return false;
}

/* Reads a run, or the label of a result that a module keeps (its index is -1). */
READ_ITEM(read_kept)
{
    struct parser ahead = *parser;
    struct error ignored;
    if (parse_word(&ahead, ",", item, &ignored) &&
        session_find_run(parser->session, item->text) < 0 && is_label(item->text)) {
        *parser = ahead;
        item->index = -1;
        return true;
    }
    return read_run(parser, argument, stops, item, error);
}

/* Reads the name of a recording into item->index. */
READ_ITEM(read_recording)
{
    const struct session *session = parser->session;
    if (!parse_word(parser, ",", item, error))
        return false;
    item->index = session_find_recording(session, item->text);
    if (item->index >= 0)
        return true;
    error_at(error, item->text, "there is no recording '%.*s'",
             (int)(item->text.len < 64 ? item->text.len : 64), item->text.data);
    struct suggestion suggestion = {.wanted = item->text};
    for (int i = 0; i < session->recordings; i++)
        suggestion_offer(&suggestion, session->recording[i]->recording->name);
    suggestion_hint(&suggestion, error);
    return session->recordings ? error_hint(error, "('data list' lists them)")
                               : error_hint(error, "type: load FILE");
}

/* Reads a quantity to plot: a choice, an observable, a variable, or a column of a table. */
READ_ITEM(read_column)
{
    if (!parse_word(parser, ",", item, error))
        return false;
    if ((argument->flags & ARG_OF) && statement_has_of(parser->rest))
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
    if (session_has_typed_variable(parser->session, item->text))
        return true;
    if (argument->flags & ARG_OF && argument->choices) { /* a method or a column of a study */
        item->row = catalog_find(&method_catalog, item->text);
        if (item->row || session_has_found_column(parser->session, item->text))
            return true;
    }
    if (argument->choices)
        return choose_row(parser, argument, item, error);
    return catalog_unknown(&observable_catalog, item->text, error);
}

/* Reads a comparison, such as y < 0, compiled into item->condition. */
READ_ITEM(read_condition)
{
    struct condition *condition = arena_alloc(parser->arena, sizeof *condition);
    if (!condition)
        return error_memory(error);
    size_t used;
    text_skip_blanks(&parser->rest);
    if (!condition_compile(before_option(parser->rest), parser->scope, parser->arena, condition,
                           &used, error))
        return false;
    item->text = (struct text){parser->rest.data, used};
    item->condition = condition;
    parser->rest = text_after(parser->rest, used);
    return true;
}

/* Reads NAME=VALUE; item->text is the name, item->value the value. */
READ_ITEM(read_start)
{
    char what[LIMIT_NAME + 1];
    const struct text name = peek_name(parser->rest);
    if (name.len == 0 || name.len > LIMIT_NAME)
        return error_at(error, peek_word(parser->rest, ","), "NAME=VALUE is missing");
    memcpy(what, name.data, name.len);
    what[name.len] = 0;
    parser->rest = (struct text){name.data + name.len, parser->rest.len - name.len};
    text_skip_blanks(&parser->rest);
    if (parser->rest.len == 0 || parser->rest.data[0] != '=')
        return error_at(error, name, "'%s' needs a value: %s=VALUE", what, what);
    parser->rest = text_after(parser->rest, 1);
    if (!parse_value(parser, what, QUANTITY_OTHER, item, error))
        return false;
    item->text = name;
    return true;
}

/* Reads NAME=FROM:TO; item->text is the name, item->range the range. */
READ_ITEM(read_side)
{
    const struct text name = peek_name(parser->rest);
    if (name.len == 0 || name.len > LIMIT_NAME)
        return error_at(error, peek_word(parser->rest, ","), "NAME=FROM:TO is missing");
    parser->rest = (struct text){name.data + name.len, parser->rest.len - name.len};
    text_skip_blanks(&parser->rest);
    if (!text_starts(parser->rest, TEXT("=")))
        return error_at(error, name, "%.*s needs a range, as in %.*s=-1:1", (int)name.len,
                        name.data, (int)name.len, name.data);
    parser->rest = text_after(parser->rest, 1);
    const int variable = model_state(parser->session->setup.scene.model, name);
    const char *known =
        variable < 0 ? "range" : parser->session->setup.scene.model->variable[variable].name;
    if (!parse_range(parser, known, QUANTITY_OTHER, item, error))
        return false;
    item->text = name;
    return true;
}

/* Reads the model of a fit: a string, the name of one, or a formula such as a + b*t. */
READ_ITEM(read_model)
{
    struct error why = {0};
    size_t used = 0;
    const struct text rest = parser->rest, word = peek_word(rest, "");
    if (strchr("'\"", rest.data[0]))
        return parse_word(parser, stops, item, error);
    struct text remainder = {rest.data + word.len, rest.len - word.len};
    text_skip_blanks(&remainder);
    /* A lone name is no formula; a + b*t is one. */
    if (peek_name(rest).len == word.len &&
        (remainder.len == 0 || !strchr("+-*/^", remainder.data[0]) ||
         text_starts(remainder, TEXT("--"))))
        return read_choice(parser, argument, stops, item, error);
    if (!series_tools()->formula(before_option(rest), parser->arena, &used, &why)) {
        *error = why;
        return false;
    }
    item->text = text_trim((struct text){rest.data, used});
    parser->rest = text_after(rest, used);
    return true;
}

READ_ITEM(read_none)
{
    return true;
}

READ_ITEM(read_value)
{
    return parse_value(parser, argument->name, argument->quantity, item, error) &&
           check_positive(parser, argument, item, error);
}

READ_ITEM(read_integer)
{
    return parse_integer(parser, argument->name, (argument->flags & ARG_NEGATIVE) != 0, item,
                         error);
}

READ_ITEM(read_range)
{
    return parse_range(parser, argument->name, argument->quantity, item, error);
}

READ_ITEM(read_size)
{
    return parse_sides(parser, argument->name, stops, item, error);
}

/* Reads an expression with its value, or a string that is kept as text. */
READ_ITEM(read_expr)
{
    return strchr("'\"", parser->rest.data[0])
               ? parse_word(parser, stops, item, error)
               : parse_value(parser, "the expression", QUANTITY_OTHER, item, error);
}

/* Reads a unit of the catalog, or a compound one, which the module `recording` knows. */
READ_ITEM(read_unit)
{
    if (!parse_word(parser, stops, item, error))
        return false;
    if (!series_tools()->unit(item->text, parser->arena, &item->unit))
        return error_memory(error);
    return item->unit || catalog_unknown(&unit_catalog, item->text, error);
}

static void parser_advance(struct parser *parser, size_t used)
{
    parser->rest = text_after(parser->rest, used);
}

/* Reads a name that is to be defined or set. */
READ_ITEM(read_name)
{
    item->text = peek_name(parser->rest);
    if (item->text.len == 0) {
        const struct text word = peek_word(parser->rest, "");
        error_at(error, word, "'%.*s' is not a name", (int)(word.len < 64 ? word.len : 64),
                 word.data);
        return error_hint(error, "a name begins with a letter, a to z; digits and _ may follow");
    }
    parser_advance(parser, item->text.len);
    return true;
}

/* Reads the name of a parameter; item->index is -1 if the scene has none of this name. */
READ_ITEM(read_param)
{
    item->text = peek_name(parser->rest);
    if (item->text.len == 0)
        return error_at(error, peek_word(parser->rest, ""), "%s needs the names of parameters",
                        argument->name);
    item->index = scene_param_at(&parser->session->setup.scene, item->text);
    parser_advance(parser, item->text.len);
    return true;
}

READ_ITEM(read_text)
{
    return parse_word(parser, stops, item, error);
}

READ_ITEM(read_rest)
{
    item->text = parser->rest;
    parser_advance(parser, parser->rest.len);
    return true;
}

/* ---- completion ---- */

COMPLETE_ITEM(complete_expression)
{
    complete_value(c, TEXT(""), QUANTITY_OTHER, complete_operands);
}

/* Offers units after a number, else operands of expressions. */
COMPLETE_ITEM(complete_quantity)
{
    if (ends_in_digit(preceding))
        complete_units(c,
                       type_is(argument, TYPE_HAS_QUANTITY) ? argument->quantity : QUANTITY_OTHER);
    else
        complete_expression(c, argument, preceding);
}

COMPLETE_ITEM(complete_size)
{
    complete_offer(c, "8x6", "cm: one column of a two-column page");
    complete_offer(c, "12x8", "cm");
    complete_offer(c, "16x10", "cm: the full width of a page");
}

COMPLETE_ITEM(complete_choice)
{
    complete_catalog(c, argument->choices);
}

COMPLETE_ITEM(complete_scene)
{
    for (int i = 0; i < c->session->setup.owns; i++)
        complete_offer(c, c->session->setup.own[i]->row.name, "of your own");
    complete_catalog(c, &preset_catalog);
    complete_offer(c, "new", "an empty scene for your own equations");
}

COMPLETE_ITEM(complete_column)
{
    if (argument->choices)
        complete_catalog(c, argument->choices);
    complete_columns(c, argument->choices);
}

COMPLETE_ITEM(complete_unit)
{
    complete_units(c, argument->quantity == QUANTITY_NUMBER ? QUANTITY_OTHER : argument->quantity);
}

/* Offers numbers and names of runs, and "all" where it is allowed. */
COMPLETE_ITEM(complete_run)
{
    for (int i = 0; i < c->session->runs.count; i++) {
        const struct run *run = c->session->runs.slot[i]->run;
        char number[16];
        snprintf(number, sizeof number, "%d", run->number);
        complete_offer(c, number, run->method->row.name);
        if (run->name[0])
            complete_offer(c, run->name, run->method->row.name);
    }
    if ((argument->flags & ARG_ALL) && c->session->runs.count > 0)
        complete_offer(c, "all", "every run");
}

COMPLETE_ITEM(complete_kept)
{
    complete_run(c, argument, preceding);
    for (size_t i = 0; module_list[i]; i++)
        if (module_list[i]->labels.complete)
            module_list[i]->labels.complete(c);
}

COMPLETE_ITEM(complete_recording)
{
    for (int i = 0; i < c->session->recordings; i++)
        complete_offer(c, c->session->recording[i]->recording->name, "recording");
}

COMPLETE_ITEM(complete_name)
{
    if (argument->choices)
        complete_catalog(c, argument->choices);
    complete_settable(c);
}

COMPLETE_ITEM(complete_param)
{
    complete_catalog(c, scene_params(&c->session->setup.scene));
}

COMPLETE_ITEM(complete_event_name)
{
    complete_events(c);
}

COMPLETE_ITEM(complete_file)
{
    c->file = "";
}

COMPLETE_ITEM(complete_scene_file)
{
    c->file = ".ode";
}

/* ---- the table ---- */

#define TYPE_BODIES
#include "language/types.def"
#undef TYPE_BODIES

static const struct argument_type_row rows[] = {
#define ARGUMENT_TYPE(name, shown, read, complete, flags) {#name, shown, read, complete, flags},
#include "language/types.def"
};

const struct argument_type_row *argument_type(const struct argument *argument)
{
    return argument->own_type ? argument->own_type : &rows[argument->type];
}

const struct argument_type_row *argument_type_row(enum argument_type type)
{
    return &rows[type];
}

void complete_item(struct completion *c, const struct argument *argument, struct text preceding)
{
    const struct argument_type_row *type = argument_type(argument);
    if (type->complete)
        type->complete(c, argument, preceding);
}
