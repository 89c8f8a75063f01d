/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Completion: what there is of each kind. */
#include "command/complete/complete.h"
#include "command/internal.h"
#include "command/session/topics.h"

#include <stdio.h>

void complete_offer(struct completion *c, const char *candidate, const char *brief)
{
    if (text_starts(text_of(candidate), c->word))
        c->offer(c->context, candidate, brief);
}

static void offer_name(void *context, const char *name, const char *brief)
{
    complete_offer(context, name, brief);
}

void complete_catalog(struct completion *c, const struct catalog *catalog)
{
    for (size_t i = 0; i < catalog->count; i++)
        complete_offer(c, catalog_row(catalog, i)->name, catalog_row(catalog, i)->brief);
}

void complete_affixed(struct completion *c, const char *before, const char *name, const char *after,
                      const char *brief)
{
    char z[LIMIT_NAME + 8];
    snprintf(z, sizeof z, "%s%s%s", before, name, after);
    complete_offer(c, z, brief);
}

void complete_units(struct completion *c, enum quantity quantity)
{
    for (size_t i = 0; i < unit_catalog.count; i++) {
        const struct unit *unit = (const struct unit *)(const void *)catalog_row(&unit_catalog, i);
        if (quantity == QUANTITY_OTHER || unit->quantity == quantity)
            complete_offer(c, unit->row.name, unit->row.brief);
    }
}

void complete_settable(struct completion *c)
{
    const struct catalog *derivable = scene_derived(&c->session->setup.scene);
    complete_catalog(c, scene_params(&c->session->setup.scene));
    for (size_t i = 0; i < derivable->count; i++) {
        const struct derived_row *derived =
            (const struct derived_row *)(const void *)catalog_row(derivable, i);
        if (derived->inverse)
            complete_offer(c, derived->row.name, derived->row.brief);
    }
    complete_catalog(c, &setting_catalog);
    for (int i = 0; i < c->session->setup.lets; i++)
        complete_offer(c, c->session->setup.let[i].name, "variable");
}

void complete_atol(struct completion *c, bool named)
{
    const struct model *model = c->session->setup.scene.model;
    for (int i = 0; i < model->n && !named; i++)
        complete_offer(c, model->variable[i].name, "variable of the scene");
    complete_offer(c, "off", named ? "as large as tol says" : "all of them as large as tol says");
}

void complete_names(struct completion *c)
{
    names_each(c->session, offer_name, c);
}

void complete_operands(struct completion *c)
{
    complete_names(c);
    complete_catalog(c, &function_catalog);
}

static void offer_runs(struct completion *c, bool all)
{
    for (int i = 0; i < c->session->runs; i++) {
        const struct run *run = c->session->run[i]->run;
        char number[16];
        snprintf(number, sizeof number, "%d", run->number);
        complete_offer(c, number, run->method->row.name);
        if (run->name[0])
            complete_offer(c, run->name, run->method->row.name);
    }
    if (all && c->session->runs > 0)
        complete_offer(c, "all", "every run");
}

bool ends_in_digit(struct text before)
{
    const struct text t = text_trim(before);
    return t.len > 0 && t.at[t.len - 1] >= '0' && t.at[t.len - 1] <= '9';
}

void complete_columns(struct completion *c, const struct catalog *besides)
{
    const struct run *run = session_run(c->session);
    const struct model *moving = run ? run->system.model : c->session->setup.scene.model;
    for (int i = 0; i < moving->n; i++)
        if (!catalog_find(&observable_catalog, text_of(moving->variable[i].name)))
            complete_offer(c, moving->variable[i].name,
                           quantity_name(moving->variable[i].quantity));
    for (int i = 0; i < model_observed(moving); i++)
        complete_offer(c, model_observed_variable(moving, i).name, "observed");
    for (size_t i = 0; i < observable_catalog.count; i++) {
        const struct row *row = catalog_row(&observable_catalog, i);
        if (model_offers(moving, (const struct observable *)(const void *)row) &&
            !(besides && catalog_find(besides, text_of(row->name))))
            complete_offer(c, row->name, row->brief);
    }
}

void complete_item(struct completion *c, const struct argument *argument, struct text before)
{
    switch (argument->type) {
    case TYPE_VALUE:
    case TYPE_EXPR:
        if (ends_in_digit(before))
            complete_units(c, argument->type == TYPE_EXPR ? QUANTITY_OTHER : argument->quantity);
        else
            complete_value(c, TEXT(""), QUANTITY_OTHER, complete_operands);
        break;
    case TYPE_CONDITION:
    case TYPE_RANGE:
        complete_value(c, TEXT(""), QUANTITY_OTHER, complete_operands);
        break;
    case TYPE_CHOICE:
    case TYPE_MODEL:
        complete_catalog(c, argument->choices);
        break;
    case TYPE_SCENE:
        for (int i = 0; i < c->session->setup.owns; i++)
            complete_offer(c, c->session->setup.own[i]->row.name, "of your own");
        complete_catalog(c, &preset_catalog);
        complete_offer(c, "new", "an empty scene, for equations of your own");
        break;
    case TYPE_COLUMN:
        if (argument->choices)
            complete_catalog(c, argument->choices);
        complete_columns(c, argument->choices);
        break;
    case TYPE_UNIT:
        complete_units(c,
                       argument->quantity == QUANTITY_NUMBER ? QUANTITY_OTHER : argument->quantity);
        break;
    case TYPE_RUN:
        offer_runs(c, (argument->flags & ARG_ALL) != 0);
        break;
    case TYPE_RECORDING:
        for (int i = 0; i < c->session->recordings; i++)
            complete_offer(c, c->session->recording[i]->recording->name, "recording");
        break;
    case TYPE_NAME:
        if (argument->choices)
            complete_catalog(c, argument->choices);
        complete_settable(c);
        break;
    case TYPE_PARAM:
        complete_catalog(c, scene_params(&c->session->setup.scene));
        break;
    case TYPE_EVENT:
        complete_events(c);
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

void complete_set(struct completion *c, struct text name, struct text before)
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
    text_skip_blanks(&value);
    if (value.len > 0 && value.at[0] == '=')
        value = (struct text){value.at + 1, value.len - 1};
    complete_value(c, value, quantity, complete_operands);
}

void complete_topics(struct completion *c)
{
    static const struct catalog *const topics[] = {
        &command_catalog, &setting_catalog, &method_catalog, &observable_catalog,
        &preset_catalog,  &unit_catalog,    &guide_catalog};
    for (size_t i = 0; i < COUNT_OF(topics); i++)
        complete_catalog(c, topics[i]);
    for (const struct model *const *model = scene_models; *model; model++) {
        const struct catalog *const own[] = {(*model)->params, (*model)->derived};
        for (size_t i = 0; i < COUNT_OF(own); i++)
            for (size_t j = 0; j < own[i]->count; j++)
                if (model_with(text_of(catalog_row(own[i], j)->name)) ==
                    *model) /* each name once */
                    complete_offer(c, catalog_row(own[i], j)->name, catalog_row(own[i], j)->brief);
    }
}
