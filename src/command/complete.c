/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion: what can stand at the cursor, by the description of the arguments. Nothing is executed and no expression
 * is evaluated. */
#include "choices.h"

#include <stdio.h>
#include <string.h>

struct completion {
    struct session *session;
    struct text word; /* what stands before the cursor of the word */
    void (*offer)(void *context, const char *candidate, const char *brief);
    void *context;
    bool wants_file;
};

static void offer(struct completion *c, const char *candidate, const char *brief)
{
    if (text_starts(text_of(candidate), c->word))
        c->offer(c->context, candidate, brief);
}

static void offer_name(void *context, const char *name, const char *brief)
{
    offer(context, name, brief);
}

static void offer_catalog(struct completion *c, const struct catalog *catalog)
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
    offer_catalog(c, scene_params(&c->session->setup.scene));
    for (size_t i = 0; i < derivable->count; i++) {
        const struct derived_row *derived = (const struct derived_row *)(const void *)catalog_row(derivable, i);
        if (derived->inverse)
            offer(c, derived->row.name, derived->row.brief);
    }
    offer_catalog(c, &setting_catalog);
    for (int i = 0; i < c->session->setup.lets; i++)
        offer(c, c->session->setup.let[i].name, "variable");
}

static void offer_names(struct completion *c)
{
    names_each(c->session, offer_name, c);
    offer_catalog(c, &function_catalog);
}

/* In what defines a scene, its names are there whatever runs have been made. */
static void offer_formula(struct completion *c)
{
    const struct model *model = c->session->setup.scene.model;
    for (int i = 0; i < model->n; i++)
        offer(c, model->variable[i].name, quantity_name(model->variable[i].quantity));
    for (int i = 0; i < model_observed(model); i++)
        offer(c, model_observed_variable(model, i).name, "observed");
    offer_catalog(c, scene_params(&c->session->setup.scene));
    offer_catalog(c, &function_catalog);
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
        if (digit_before(before))
            offer_units(c, argument->quantity);
        else
            offer_names(c);
        break;
    case TYPE_EXPR:
        if (digit_before(before))
            offer_units(c, QUANTITY_OTHER);
        else
            offer_names(c);
        break;
    case TYPE_CONDITION:
    case TYPE_RANGE:
        offer_names(c);
        break;
    case TYPE_CHOICE:
    case TYPE_MODEL:
        offer_catalog(c, argument->choices);
        break;
    case TYPE_COLUMN:
        if (argument->choices)
            offer_catalog(c, argument->choices);
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
        offer_catalog(c, scene_params(&c->session->setup.scene));
        break;
    case TYPE_FORMULA:
        offer_formula(c);
        break;
    case TYPE_FILE:
        c->wants_file = true;
        break;
    case TYPE_START:
    case TYPE_NONE:
    case TYPE_INTEGER:
    case TYPE_TEXT:
    case TYPE_REST:
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
            offer_catalog(c, setting->choices);
            return;
        }
        quantity = setting->quantity;
    }
    if (digit_before(before))
        offer_units(c, quantity);
    else
        offer_names(c);
}

static void offer_topics(struct completion *c)
{
    static const struct catalog *const topics[] = {&command_catalog, &setting_catalog, &method_catalog,
                                                   &observable_catalog, &preset_catalog, &unit_catalog};
    for (size_t i = 0; i < COUNT_OF(topics); i++)
        offer_catalog(c, topics[i]);
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

static int count_words(struct text text)
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

/* What may come next: the words, keys and options of the command, and the item of the next place. */
static void offer_arguments(struct completion *c, const struct command *command, struct text before)
{
    /* After `of` only what it leads to. */
    const struct text last = previous_word(before);
    bool led = false;
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].lead && text_is(last, command->argument[i].lead)) {
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
    else if (digit_before(before) && command->arguments > 0 && command->argument[0].type == TYPE_VALUE)
        offer_units(c, command->argument[0].quantity);
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
        offer_catalog(c, &sweep_measure_catalog);
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
        offer_catalog(c, &show_catalog);
        names_each(c->session, offer_name, c);
    } else if ((strcmp(name, "set") == 0 || strcmp(name, "let") == 0 || strcmp(name, "change") == 0) &&
               count_words(before) > 0)
        offer_for_name(c, peek_name(text_trim(before)), before);
    else
        offer_arguments(c, command, before);
}

/* Words of formulas end at operators, too. */
static bool is_formula(struct text statement)
{
    skip_blanks(&statement);
    const struct text name = peek_name(statement);
    const struct command *command = (const struct command *)(const void *)catalog_find(&command_catalog, name);
    const bool marked = name.len > 0 && name.len < statement.len && statement.at[name.len] == '\'';
    return marked || (command && command->arguments > 0 &&
                      command->argument[command->arguments - 1].type == TYPE_FORMULA);
}

bool command_complete(struct session *session, struct text line, size_t cursor, size_t *start,
                      void (*offer_to)(void *context, const char *candidate, const char *brief), void *context)
{
    struct text rest = {line.at, cursor < line.len ? cursor : line.len}, statement = rest;
    struct error ignored;
    while (rest.len > 0) {
        statement = rest;
        if (!next_statement(&rest, &statement, &ignored))
            return true; /* inside a string */
        if (rest.len == 0 && rest.at > line.at && rest.at[-1] == ';')
            statement = rest;
        else if (rest.len == 0)
            statement.len = (size_t)(rest.at - statement.at); /* with the blanks at its end */
    }
    const bool formula = is_formula(statement);
    size_t word = statement.len;
    while (word > 0 && !strchr(formula ? " \t=,;:+-*/^()<>" : " \t=,;:", statement.at[word - 1]))
        word--;
    *start = (size_t)(statement.at + word - line.at);
    struct completion c = {session, {statement.at + word, statement.len - word}, offer_to, context, false};
    struct text before = {statement.at, word};
    skip_blanks(&before);
    if (before.len == 0) {
        offer_catalog(&c, &command_catalog);
        offer_settable(&c);
        return true;
    }
    const struct text name = peek_name(before);
    struct text after = {before.at + name.len, before.len - name.len};
    skip_blanks(&after);
    const struct command *command = (const struct command *)(const void *)catalog_find(&command_catalog, name);
    if (formula && after.len > 0 &&
        (after.at[0] == '\'' || !command || command->arguments == 1 || count_words(after) > 0))
        offer_formula(&c);
    else if (after.len > 0 && after.at[0] == '=')
        offer_for_name(&c, name, before);
    else if (command)
        complete_arguments(&c, command, (struct text){before.at + name.len, before.len - name.len});
    return !c.wants_file;
}
