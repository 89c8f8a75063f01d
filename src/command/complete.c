/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion: what can stand at the cursor, by the description of the arguments. Nothing is executed and no expression
 * is evaluated. */
#include "complete.h"

#include <stdio.h>
#include <string.h>

static void offer(struct completion *c, const char *candidate, const char *brief)
{
    if (text_starts(text_of(candidate), c->word))
        c->offer(c->context, candidate, brief);
}

void complete_offer(struct completion *c, const char *candidate, const char *brief)
{
    offer(c, candidate, brief);
}

static void offer_name(void *context, const char *name, const char *brief)
{
    offer(context, name, brief);
}

void complete_catalog(struct completion *c, const struct catalog *catalog)
{
    for (size_t i = 0; i < catalog->count; i++)
        offer(c, catalog_row(catalog, i)->name, catalog_row(catalog, i)->brief);
}

static void offer_suffixed(struct completion *c, const char *before, const char *name, const char *after,
                           const char *brief)
{
    char z[LIMIT_NAME + 8];
    snprintf(z, sizeof z, "%s%s%s", before, name, after);
    offer(c, z, brief);
}

static void offer_units(struct completion *c, enum quantity quantity)
{
    for (size_t i = 0; i < unit_catalog.count; i++) {
        const struct unit *unit = (const struct unit *)(const void *)catalog_row(&unit_catalog, i);
        if (quantity == QUANTITY_OTHER || unit->quantity == quantity)
            offer(c, unit->row.name, unit->row.brief);
    }
}

static void offer_settable(struct completion *c)
{
    const struct catalog *derivable = scene_derived(&c->session->setup.scene);
    complete_catalog(c, scene_params(&c->session->setup.scene));
    for (size_t i = 0; i < derivable->count; i++) {
        const struct derived_row *derived = (const struct derived_row *)(const void *)catalog_row(derivable, i);
        if (derived->inverse)
            offer(c, derived->row.name, derived->row.brief);
    }
    complete_catalog(c, &setting_catalog);
    for (int i = 0; i < c->session->setup.lets; i++)
        offer(c, c->session->setup.let[i].name, "variable");
}

static void offer_names(struct completion *c)
{
    names_each(c->session, offer_name, c);
    complete_catalog(c, &function_catalog);
}

static void offer_runs(struct completion *c, bool all)
{
    for (int i = 0; i < c->session->runs; i++) {
        const struct run *run = c->session->run[i]->run;
        char number[16];
        snprintf(number, sizeof number, "%d", run->number);
        offer(c, number, run->method->row.name);
        if (run->name[0])
            offer(c, run->name, run->method->row.name);
    }
    if (all && c->session->runs > 0)
        offer(c, "all", "every run");
}

static bool digit_before(struct text before)
{
    const struct text t = text_trim(before);
    return t.len > 0 && t.at[t.len - 1] >= '0' && t.at[t.len - 1] <= '9';
}

/* State variables and observables of the current run, or of the one that the scene would give; not what stands in
 * `besides`, too. */
static void offer_columns(struct completion *c, const struct catalog *besides)
{
    const struct run *run = session_run(c->session);
    const struct model *moving = run ? run->system.model : c->session->setup.scene.model;
    for (int i = 0; i < moving->n; i++)
        if (!catalog_find(&observable_catalog, text_of(moving->variable[i].name)))
            offer(c, moving->variable[i].name, quantity_name(moving->variable[i].quantity));
    for (int i = 0; i < model_observed(moving); i++)
        offer(c, model_observed_variable(moving, i).name, "observed");
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct row *row = catalog_row(&observable_catalog, i);
        if (model_offers(moving, (const struct observable *)(const void *)row) &&
            !(besides && catalog_find(besides, text_of(row->name))))
            offer(c, row->name, row->brief);
    }
}

/* Candidates for one item; before: what stands to the left of the word. */
static void offer_item(struct completion *c, const struct argument *argument, struct text before)
{
    switch (argument->type) {
    case TYPE_VALUE:
    case TYPE_EXPR:
        if (digit_before(before))
            offer_units(c, argument->type == TYPE_EXPR ? QUANTITY_OTHER : argument->quantity);
        else
            complete_value(c, TEXT(""), QUANTITY_OTHER, offer_names);
        break;
    case TYPE_CONDITION:
    case TYPE_RANGE:
        complete_value(c, TEXT(""), QUANTITY_OTHER, offer_names);
        break;
    case TYPE_CHOICE:
    case TYPE_MODEL:
        complete_catalog(c, argument->choices);
        break;
    case TYPE_SCENE:
        for (int i = 0; i < c->session->setup.owns; i++)
            offer(c, c->session->setup.own[i]->row.name, "of your own");
        complete_catalog(c, &preset_catalog);
        offer(c, "new", "an empty scene, for equations of your own");
        break;
    case TYPE_COLUMN:
        if (argument->choices)
            complete_catalog(c, argument->choices);
        offer_columns(c, argument->choices);
        break;
    case TYPE_UNIT:
        offer_units(c, argument->quantity == QUANTITY_NUMBER ? QUANTITY_OTHER : argument->quantity);
        break;
    case TYPE_RUN:
        offer_runs(c, (argument->flags & ARG_ALL) != 0);
        break;
    case TYPE_RECORDING:
        for (int i = 0; i < c->session->recordings; i++)
            offer(c, c->session->recording[i]->recording->name, "recording");
        break;
    case TYPE_NAME:
        offer_settable(c);
        break;
    case TYPE_PARAM:
        complete_catalog(c, scene_params(&c->session->setup.scene));
        break;
    case TYPE_FILE:
        c->wants_file = true;
        break;
    case TYPE_START:
    case TYPE_NONE:
    case TYPE_INTEGER:
    case TYPE_TEXT:
    case TYPE_REST:
    case TYPE_FORMULA:
        break;
    }
}

/* After NAME of set: the unit of that name, or the choices of that setting. */
static void offer_for_name(struct completion *c, struct text name, struct text before)
{
    const struct scene *scene = &c->session->setup.scene;
    const struct row *row;
    enum quantity quantity = QUANTITY_OTHER;
    if ((row = catalog_find(scene_params(scene), name)))
        quantity = ((const struct param_row *)(const void *)row)->quantity;
    else if ((row = catalog_find(scene_derived(scene), name)))
        quantity = ((const struct derived_row *)(const void *)row)->quantity;
    else if ((row = catalog_find(&setting_catalog, name))) {
        const struct setting *setting = (const struct setting *)(const void *)row;
        if (setting->choices) {
            complete_catalog(c, setting->choices);
            return;
        }
        quantity = setting->quantity;
    }
    struct text value = {name.at + name.len, (size_t)(before.at + before.len - name.at) - name.len};
    skip_blanks(&value);
    if (value.len > 0 && value.at[0] == '=')
        value = (struct text){value.at + 1, value.len - 1};
    complete_value(c, value, quantity, offer_names);
}

static void offer_topics(struct completion *c)
{
    static const struct catalog *const topics[] = {&command_catalog, &setting_catalog, &method_catalog,
                                                   &observable_catalog, &preset_catalog, &unit_catalog};
    for (size_t i = 0; i < COUNT_OF(topics); i++)
        complete_catalog(c, topics[i]);
    for (const struct model *const *model = scene_models; *model; model++) {
        const struct catalog *const own[] = {(*model)->params, (*model)->derived};
        for (size_t i = 0; i < COUNT_OF(own); i++)
            for (size_t j = 0; j < own[i]->count; j++)
                if (model_with(text_of(catalog_row(own[i], j)->name)) == *model) /* each name once */
                    offer(c, catalog_row(own[i], j)->name, catalog_row(own[i], j)->brief);
    }
}

/* The last word before the one being completed. */
static struct text previous_word(struct text before)
{
    before = text_trim(before);
    size_t from = before.len;
    while (from > 0 && before.at[from - 1] != ' ' && before.at[from - 1] != '\t')
        from--;
    return (struct text){before.at + from, before.len - from};
}

int count_words(struct text text)
{
    int count = 0;
    for (struct text word; (text = text_trim(text)).len > 0; count++) {
        word = peek_word(text, "");
        const size_t used = word.len ? word.len : 1;
        text = (struct text){text.at + used, text.len - used};
    }
    return count;
}

static const struct argument *find_by_form(const struct command *command, enum argument_form form, struct text name)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == form && text_is(name, command->argument[i].name))
            return &command->argument[i];
    return NULL;
}

/* Can it have an expression that goes on over blanks? */
static bool takes_values(const struct command *command)
{
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].type >= TYPE_VALUE && command->argument[i].type <= TYPE_EXPR &&
            command->argument[i].type != TYPE_INTEGER)
            return true;
    return false;
}

/* What may come next: the words, keys and options of the command, and the item of the next place. */
static void offer_arguments(struct completion *c, const struct command *command, struct text before)
{
    /* After `of` only what it leads to. */
    const struct text last = previous_word(before);
    bool led = false;
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].lead && text_is(last, command->argument[i].lead)) {
            if (command->argument[i].form == FORM_PLACE)
                offer_item(c, &command->argument[i], TEXT(""));
            else
                offer(c, command->argument[i].name, "");
            led = true;
        }
    if (led)
        return;
    int places = count_words(before);
    const char *lead = "";
    const struct argument *place = NULL;
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        if (argument->form == FORM_PLACE && !place && (places-- == 0 || (argument->flags & ARG_MANY)))
            place = argument;
        if (argument->form == FORM_WORD && argument->name[0] != '>' && !argument->lead)
            offer(c, argument->name, "");
        else if (argument->form == FORM_KEY && argument->type != TYPE_START)
            offer_suffixed(c, "", argument->name, "=", "");
        else if (argument->form == FORM_OPTION)
            offer_suffixed(c, "--", argument->name, "", "");
        if (argument->lead && strcmp(argument->lead, lead) != 0)
            offer(c, argument->lead, "");
        lead = argument->lead ? argument->lead : lead;
    }
    if (place)
        offer_item(c, place, before);
    else if (digit_before(before) && command->arguments > 0 && takes_values(command))
        offer_units(c, command->argument[0].type == TYPE_VALUE ? command->argument[0].quantity : QUANTITY_OTHER);
}

static bool goes_on(const struct command *command, struct text before)
{
    const struct text t = text_trim(before);
    const bool compares = find_by_form(command, FORM_WORD, TEXT("until")) && t.len > 0 && strchr("<>", t.at[t.len - 1]);
    return takes_values(command) && (compares || value_is_open(before));
}

/* NAME=FROM:TO with the unit behind a number, and what is measured. */
static void complete_sweep(struct completion *c, const struct command *command, struct text before)
{
    const struct scene *scene = &c->session->setup.scene;
    const struct catalog *names[] = {scene_params(scene), scene_derived(scene)};
    size_t from = before.len;
    while (from > 0 && before.at[from - 1] != '=')
        from--;
    const bool item = from > 0 && strchr("=,:", before.at[before.len - 1]);
    const struct text name = from > 0 ? previous_word((struct text){before.at, from - 1}) : TEXT("");
    if (item && text_is(name, "measure")) {
        const char *paren = memchr(c->word.at, '(', c->word.len); /* max(z */
        if (paren)
            c->word = (struct text){paren + 1, (size_t)(c->word.at + c->word.len - paren - 1)};
        else
            complete_catalog(c, &sweep_measure_catalog);
        offer_columns(c, NULL);
        return;
    }
    if (item || digit_before(before)) {
        if (from > 0)
            offer_for_name(c, name, before);
        if (item)
            return;
    }
    for (size_t i = 0; i < COUNT_OF(names); i++)
        for (size_t j = 0; j < names[i]->count; j++) {
            const struct row *row = catalog_row(names[i], j);
            if (i == 0 || ((const struct derived_row *)(const void *)row)->inverse)
                offer_suffixed(c, "", row->name, "=", row->brief);
        }
    offer_suffixed(c, "", "dt", "=", "");
    offer_suffixed(c, "", "tol", "=", "");
    offer_arguments(c, command, before);
}

static void complete_arguments(struct completion *c, const struct command *command, struct text before)
{
    const struct text last = previous_word(before);
    const char *name = command->row.name;
    if (strcmp(name, "sweep") == 0) {
        complete_sweep(c, command, before);
        return;
    }
    /* NAME=item, also after commas: the word being completed begins behind the last = or comma. */
    if (before.len > 0 && (before.at[before.len - 1] == '=' || before.at[before.len - 1] == ',')) {
        const struct argument *key = find_by_form(command, FORM_KEY, peek_name(last));
        if (key) {
            offer_item(c, key, TEXT(""));
            return;
        }
    }
    /* NAME=5 and a blank: the unit. */
    size_t equals = before.len;
    while (equals > 0 && before.at[equals - 1] != '=')
        equals--;
    if (equals > 0 && digit_before(before)) {
        const struct argument *key =
            find_by_form(command, FORM_KEY, previous_word((struct text){before.at, equals - 1}));
        if (key && key->type == TYPE_VALUE) {
            offer_units(c, key->quantity);
            return;
        }
    }
    if (goes_on(command, before)) {
        complete_value(c, TEXT(""), QUANTITY_OTHER, offer_names);
        return;
    }
    const struct argument *word = find_by_form(command, FORM_WORD, last);
    const struct argument *option =
        last.len > 2 ? find_by_form(command, FORM_OPTION, (struct text){last.at + 2, last.len - 2}) : NULL;
    if (word && word->type != TYPE_NONE)
        offer_item(c, word, TEXT(""));
    else if (option && option->type != TYPE_NONE)
        offer_item(c, option, TEXT(""));
    else if (strcmp(name, "help") == 0)
        offer_topics(c);
    else if (strcmp(name, "show") == 0) {
        complete_catalog(c, &show_catalog);
        names_each(c->session, offer_name, c);
    } else if ((strcmp(name, "set") == 0 || strcmp(name, "let") == 0 || strcmp(name, "change") == 0) &&
               count_words(before) > 0)
        offer_for_name(c, peek_name(text_trim(before)), before);
    else
        offer_arguments(c, command, before);
}

/* The command of a statement that defines a scene or an event, and what stands behind its name; NULL: another one. */
static const struct command *formula_command(struct text statement, struct text *rest)
{
    skip_blanks(&statement);
    const struct text name = peek_name(statement);
    const struct command *command = command_at(catalog_find(&command_catalog, name));
    *rest = (struct text){statement.at + name.len, statement.len - name.len};
    if (name.len > 0 && rest->len > 0 && rest->at[0] == '\'')
        return command_at(catalog_find(&command_catalog, TEXT("equation")));
    const bool formula =
        command && command->arguments > 0 && command->argument[command->arguments - 1].type == TYPE_FORMULA;
    return formula && rest->len > 0 && strchr(" \t", rest->at[0]) ? command : NULL;
}

/* Where the commands of an unfinished event begin; NULL: it is another string. */
static const char *event_string(struct text statement)
{
    skip_blanks(&statement);
    if (!text_is(peek_name(statement), "event"))
        return NULL;
    for (size_t i = 0; i + 3 < statement.len; i++)
        if (strncmp(statement.at + i, " do ", 4) == 0) {
            struct text rest = {statement.at + i + 4, statement.len - i - 4};
            skip_blanks(&rest);
            return rest.len > 0 && strchr("'\"", rest.at[0]) ? rest.at + 1 : NULL;
        }
    return NULL;
}

bool command_complete(struct session *session, struct text line, size_t cursor, size_t *start,
                      void (*offer_to)(void *context, const char *candidate, const char *brief), void *context)
{
    struct text rest = {line.at, cursor < line.len ? cursor : line.len}, statement = rest;
    struct error ignored;
    while (rest.len > 0) {
        statement = rest;
        if (!next_statement(&rest, &statement, &ignored)) {
            const char *inside = event_string(statement), *end = line.at + cursor;
            if (!inside || inside > end)
                return true; /* inside a string */
            const struct text commands = {inside, (size_t)(end - inside)};
            const bool names = command_complete(session, commands, commands.len, start, offer_to, context);
            *start += (size_t)(inside - line.at);
            return names;
        }
        if (rest.len == 0 && rest.at > line.at && rest.at[-1] == ';')
            statement = rest;
        else if (rest.len == 0)
            statement.len = (size_t)(rest.at - statement.at); /* with the blanks at its end */
    }
    size_t word = statement.len;
    while (word > 0 && !strchr(" \t=,;:", statement.at[word - 1]))
        word--;
    struct completion c = {session, {statement.at + word, statement.len - word}, offer_to, context, false};
    struct text before = {statement.at, word}, behind;
    const struct command *formula = formula_command(before, &behind);
    skip_blanks(&before);
    const struct text name = peek_name(before);
    struct text after = {before.at + name.len, before.len - name.len};
    skip_blanks(&after);
    const struct command *command = command_at(catalog_find(&command_catalog, name));
    if (before.len == 0) {
        complete_catalog(&c, &command_catalog);
        offer_settable(&c);
    } else if (formula)
        complete_formula(&c, formula, behind);
    else if (after.len > 0 && after.at[0] == '=')
        offer_for_name(&c, name, before);
    else if (command)
        complete_arguments(&c, command, (struct text){before.at + name.len, before.len - name.len});
    *start = (size_t)(c.word.at - line.at);
    return !c.wants_file;
}
